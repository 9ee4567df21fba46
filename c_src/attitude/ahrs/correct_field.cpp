// Correction by the magnetic field: the reference M against the mean field, as azimuth, horizontal and vertical intensity.
//
// The second row, azimuth, observes the heading. Tilt, velocity and gyro calibration are consider states: no magnet may tilt the
// horizon.
#include "attitude/ahrs/condition.hpp"

#include <algorithm>

namespace hnav {

// The three rows: residual = H error + noise, H error = theta x M - dM - (u x M) dl - (0, H, 0) dd.
struct AhrsModel::FieldRows {
    R H, Z;         // horizontal and vertical intensity of the reference
    Vector3R swept; // u x M: change of the field by a second of latency
    Vector3R residual;

    FieldRows(const State& s, const MeanField<R>& mean) : H(s.reference[0]), Z(s.reference[1]) {
        const Vector3R M(H, 0, Z), u_n = Vector3R(s.turn_sum) / s.field_count;
        swept = u_n.cross(M);
        // Exact for any heading error.
        residual = {H - mean.horizontal(), -H * wrap_angle(mean.azimuth_rad() - s.declination), Z - mean.n[2]};
    }

    R deviation() const { return length(residual[0], residual[2]); }

    Eigen::Matrix<R, errors, 3> PHt(const Correction& c) const {
        const Vector north = c.column(rotation), east = c.column(rotation + 1), late = c.column(latency);
        Eigen::Matrix<R, errors, 3> out;
        out.col(0) = Z * east - c.column(reference) - swept[0] * late;
        out.col(1) = H * (c.column(rotation + 2) - c.column(declination)) - Z * north - swept[1] * late;
        out.col(2) = -H * east - c.column(reference + 1) - swept[2] * late;
        return out;
    }

    // A column of the response, which begins with the rotation.
    struct FromRotation {
        const R* first;
        R operator[](int row) const { return first[row - rotation]; }
    };

    // H times an error, or a column of its covariance or response.
    template <class Column>
    Vector3R of(const Column& c) const {
        return {Z * c[rotation + 1] - c[reference] - swept[0] * c[latency],
                H * (c[rotation + 2] - c[declination]) - Z * c[rotation] - swept[1] * c[latency],
                -H * c[rotation + 1] - c[reference + 1] - swept[2] * c[latency]};
    }

    // Iron adds to the mean field, in its axes.
    Response<3> stepped(const Correction& c, const Matrix3R& R_bn) const {
        Response<3> out;
        for (int j = 0; j < step_parts; ++j) out.col(j) = of(FromRotation{c.response.col(j).data()});
        out.rightCols<3>() -= R_bn;
        return out;
    }

    Matrix3R HPHt(const Eigen::Matrix<R, errors, 3>& PHt) const {
        Matrix3R out;
        for (int k = 0; k < 3; ++k) out.col(k) = of(PHt.col(k));
        return out;
    }
};

void AhrsModel::correct_field(State& s, Correction& c, double t_s) const {
    constexpr R unknown_intensity =
        100; // sigma of the intensities of a field that is not the given one, in units of the strength
    MeanField<R> mean{Vector3R(s.field_sum) / s.field_count};
    choose_reference(s, c, mean);
    const FieldRows rows(s, mean);
    const R azimuth_away = azimuth_deviation(s, c, rows), away = std::fmax(rows.deviation(), azimuth_away);
    const FieldVerdict verdict = judge_field(s, c, away);
    const bool foreign = take_foreign_field(s, c, mean);
    note_contradiction(s, verdict, rows);
    forget_heading_far_off(c, rows);

    const Eigen::Matrix<R, errors, 3> PHt = rows.PHt(c);
    const Matrix3R HPHt = rows.HPHt(PHt);
    const Vector3R innovation = rows.residual - rows.of(c.error);
    Vector3R noise = field_noise(s);
    if (foreign) noise[0] = noise[2] = unknown_intensity * unknown_intensity;
    const R inflation = noise_inflation(verdict, away);
    Matrix3R S = HPHt;
    S.diagonal() += noise;
    record_field(s, t_s, innovation, S, inflation);
    confirm_heading(s, verdict, !foreign && azimuth_away > R(options_.mag_gate));
    const Vector3R known = HPHt.diagonal() - Vector3R(c.P(reference, reference), 0, c.P(reference + 1, reference + 1));

    const Response<3> stepped = rows.stepped(c, rotation_matrix<R>(QuaternionR(s.x)));
    // Else a disturbance passes, or the azimuth drifts with a horizon that is being found (a gyro that was stuck for 10 s, seed 47: 73 s instead
    // of 9 until the tilt is right again).
    const bool shows_drift = !foreign && s.heading_confirmed != 0 && is_tilt_found(s);
    if (shows_drift && verdict != FieldVerdict::accept) note_rejected_field(s, S, stepped, innovation);
    if (verdict != FieldVerdict::reject) {
        S.diagonal() += (inflation - 1) * noise;
        const R before = c.heading_variance();
        const bool is_evidence = shows_drift && verdict == FieldVerdict::accept;
        condition<3, considered>(c, PHt, S, innovation, stepped, is_evidence ? &s.steps.evidence : nullptr);
        if (!foreign) s.information.heading += information_gained(before, c.heading_variance());
    }
    if (!foreign) learn_field_noise(s, c, mean, innovation, known);
}

// S: with the noise before inflation, as in the record of the innovation.
void AhrsModel::note_rejected_field(State& s, const Matrix3R& S, const Response<3>& stepped, const Vector3R& innovation) {
    const Cholesky<3, R> factor(S);
    if (factor.positive()) s.steps.reject(stepped, weighted<3>(factor, stepped), innovation, s.innovation[mag].nis);
}

// The corrections are linear. An uncertain heading that is far off is no measurement of the drift that it correlates with: its error is
// another one, of the size of the angle.
void AhrsModel::forget_heading_far_off(Correction& c, const FieldRows& rows) {
    constexpr R linear_rad = R(0.5), sigmas2 = 9;
    const R away2 = square(rows.residual[1] / rows.H), variance = c.heading_variance();
    if (!(away2 > linear_rad * linear_rad && away2 < sigmas2 * variance)) return;
    c.P.row(rotation + 2).setZero();
    c.P.col(rotation + 2).setZero();
    c.heading_variance() = std::fmax(variance, std::fmin(any_angle_variance<R>, variance + away2));
}

// Returns true if the field is not the given one (given_field.hpp). Its declination then has the variance of its azimuth. When a new
// candidate field begins, the body has moved and the declination is a different one.
bool AhrsModel::take_foreign_field(State& s, Correction& c, const MeanField<R>& mean) const {
    if (place_.is_of_place(mean.horizontal(), mean.n[2])) {
        if (s.foreign2 > 0) leave_foreign_field(s, c);
        return false;
    }
    const R variance = place_.azimuth_variance(mean.horizontal(), mean.n[2]);
    const R before = s.field.candidate_age_s <= s.field_s ? 0 : s.foreign2;
    c.P(declination, declination) += std::fmax(R(0), variance - before);
    s.foreign2 = std::fmax(variance, before);
    return true;
}

void AhrsModel::leave_foreign_field(State& s, Correction& c) const {
    c.P.row(declination).setZero();
    c.P.col(declination).setZero();
    c.P(declination, declination) = s.field_noise.scale2 * sigma_.declination * sigma_.declination;
    c.error[declination] = 0;
    s.declination = s.foreign2 = 0;
}

// known: variances of the innovation without those of the reference. If the estimated disturbance of the place decreases, the prior
// variance of its declination decreases too; if it increases, the variance increases.
void AhrsModel::learn_field_noise(State& s, Correction& c, const MeanField<R>& mean, const Vector3R& innovation,
                                  const Vector3R& known) const {
    const R fast = R(options_.turning_rad_s), before = s.field_noise.scale2, sigma = sigma_.declination;
    const R turning = s.rest.at_rest(options_) ? 0 : std::fmin(R(1), s.rate_power / (fast * fast * s.x[13]));
    const R intensities[] = {mean.horizontal(), mean.n[2]}, innovations[] = {innovation[0], innovation[2]};
    const R known2 = std::fmax(R(0), known[0]) + std::fmax(R(0), known[2]);
    s.field_noise.note(intensities, innovations, known2, turning, s.field_s);
    const R now = s.field_noise.scale2;
    if (now > before) c.P(declination, declination) += (now - before) * sigma * sigma;
    if (!(now < before)) return;
    using Row1 = Eigen::Matrix<R, 1, 1>;
    const Vector PHt = c.column(declination);
    const R noise = sigma * sigma * now * before / (before - now);
    condition<1, considered>(c, PHt, Row1(PHt[declination] + noise), Row1(-s.declination - c.error[declination]),
                             c.stepped<1>(declination));
}

// Gathers evidence, and changes the reference if the evidence contradicts the present one.
void AhrsModel::choose_reference(State& s, Correction& c, MeanField<R>& mean) const {
    const R fast = R(options_.turning_rad_s);
    const bool turning = s.rate_power > fast * fast * s.x[13];
    s.field.weigh(options_, mean, s.reference[0], s.reference[1], turning, s.field_s);
    const bool possible = place_.is_of_place(s.field.candidate_horizontal(), s.field.candidate[2]);
    if (possible && s.field.candidate_wins(options_)) change_reference(s, c, mean);
}

// The candidate becomes the reference. The heading and the mean field turn by the share by which the heading is uncertain.
void AhrsModel::change_reference(State& s, Correction& c, MeanField<R>& mean) const {
    MagneticReference<R>& field = s.field;
    const R distrust = field.distrust(options_, c.heading_variance());
    keep_unit(s, mean);
    s.reference[0] = field.candidate_horizontal();
    s.reference[1] = field.candidate[2];
    forget_reference(c.P, R(options_.mag_gate));
    if (distrust > 0) {
        const R angle = -distrust * field.candidate_azimuth_rad();
        turn_heading(s, angle);
        turn_errors(c, angle);
        mean.n = rotation_matrix<R>(rotation_quaternion<R>({0, 0, angle})) * mean.n;
        c.heading_variance() += distrust * R(options_.turn_sigma_rad) * R(options_.turn_sigma_rad);
        s.information.heading = 0;
        s.heading_confirmed = 0;
        field.heading_trust_s *= 1 - distrust;
    }
    field.take_candidate();
    s.undisturbed_s = 0;
    s.contradicted_s = lasting_s;
}

// As turn_heading does with the state. A tilt and the accelerometer bias that hides it would otherwise seem to be known apart.
void AhrsModel::turn_errors(Correction& c, R angle_rad) {
    Matrix2R turn;
    turn << std::cos(angle_rad), -std::sin(angle_rad), std::sin(angle_rad), std::cos(angle_rad);
    for (int j = 0; j < errors; ++j) c.P.col(j) = c.column(j);
    for (const int row : {velocity, rotation}) {
        c.P.middleRows<2>(row) = (turn * c.P.middleRows<2>(row)).eval();
        c.P.middleCols<2>(row) = (c.P.middleCols<2>(row) * turn.transpose()).eval();
    }
    c.response.topRows<2>() = (turn * c.response.topRows<2>()).eval();
    c.velocity_response = (turn * c.velocity_response).eval();
}

// Gates and noise are in units of the strength.
void AhrsModel::keep_unit(State& s, MeanField<R>& mean) {
    const R change = s.field.candidate_unit();
    s.strength *= change;
    Eigen::Map<Vector3R>(s.field.candidate) /= change;
    mean.n /= change;
}

void AhrsModel::forget_reference(Covariance& P, R sigma) {
    rows<2>(P, reference).setZero();
    columns<2>(P, reference).setZero();
    diagonal<2>(P, reference).setConstant(sigma * sigma);
}

// While the heading is known, an azimuth that deviates from it counts against the field too, in units of the intensity gate.
Scalar AhrsModel::azimuth_deviation(const State& s, const Correction& c, const FieldRows& rows) const {
    const R ready = R(options_.ready_heading_rad);
    const R variance = rows.H * rows.H * c.P(rotation + 2, rotation + 2);
    if (!(R(options_.mag_azimuth_gate_sigmas) > 0) || c.P(rotation + 2, rotation + 2) > ready * ready) return 0;
    const R limit = R(options_.mag_azimuth_gate_sigmas) * std::sqrt(variance + field_noise(s)[1]);
    return R(options_.mag_gate) * std::fabs(rows.residual[1]) / limit;
}

// The gate. A reference that has been contradicted for long is estimated again.
FieldVerdict AhrsModel::judge_field(State& s, Correction& c, R away) const {
    const FieldVerdict verdict = s.field.judge(options_, away, s.field_s);
    s.verdict = static_cast<std::uint64_t>(verdict);
    if (verdict == FieldVerdict::begin_inflating) {
        s.contradicted_s = lasting_s;
        forget_reference(c.P, sigma_.reference);
        segment<2>(c.error, reference).setZero();
    }
    return verdict;
}

// A field that contradicts a rarely observed reference may be the true one. The heading, which was taken from the reference, is then
// wrong by the angle between the two. This angle is added to the output variance only: a gain that preferred one of the two fields
// would follow whichever is false.
void AhrsModel::note_contradiction(State& s, FieldVerdict verdict, const FieldRows& rows) {
    constexpr R trusted_s = 8, per_s = 2, forgotten_s = 10;
    const R T = s.field_s;
    if (verdict == FieldVerdict::accept) {
        const R lasted_s = std::fmin(s.contradicted_s, forgotten_s);
        s.reference_variance *= lasted_s > T ? 1 - T / lasted_s : 0;
        s.contradicted_s = std::fmax(R(0), s.contradicted_s - T);
        return;
    }
    const R untrusted = std::fmax(R(0), 1 - s.field.heading_trust_s / trusted_s);
    const R apart_rad = std::fmin(R(1), rows.deviation() / rows.H);
    s.reference_variance = std::fmin(any_angle_variance<R>, s.reference_variance + untrusted * per_s * T * apart_rad * apart_rad);
    s.contradicted_s += T;
}

// Variances of horizontal intensity, azimuth and vertical intensity of the mean field.
Vector3Of<Scalar> AhrsModel::field_noise(const State& s) const {
    const R scale = (s.rest.at_rest(options_) ? R(options_.mag_rest_factor) : 1) / s.field_s;
    const R room = s.field_noise.scale2, white = s.field_noise.white2 * s.field_s;
    const R intensity = (density_.intensity_density2 * room + white) * scale;
    return {intensity, (density_.azimuth_density2 * room + white) * scale, intensity};
}

// Beyond the gate the weight of an accepted field decreases with its distance.
Scalar AhrsModel::noise_inflation(FieldVerdict verdict, R deviation) const {
    if (verdict == FieldVerdict::accept || verdict == FieldVerdict::reject) return 1;
    const R gates = deviation / R(options_.mag_gate);
    return gates * gates;
}

void AhrsModel::record_field(State& s, double t_s, const Vector3R& innovation, const Matrix3R& S, R inflation) {
    InnovationOf<R>& i = s.innovation[mag];
    i = {};
    i.t_s = t_s;
    i.dimension = 3;
    i.noise_scale = FieldVerdict(s.verdict) == FieldVerdict::reject ? std::numeric_limits<R>::infinity() : inflation;
    Eigen::Map<Vector3R>(i.value) = innovation;
    Eigen::Map<Matrix3R>(i.S) = S;
    i.nis = normalised_square<3, R>(S, innovation);
    if (i.noise_scale > 1) s.gated[mag] += static_cast<std::uint64_t>(s.field_count);
}

// Whether the reference has been uncontradicted for long enough. An azimuth that stays far from the heading contradicts one of the two;
// until it returns the heading is not ready.
void AhrsModel::confirm_heading(State& s, FieldVerdict verdict, bool azimuth_is_far) const {
    const R T = s.field_s;
    s.azimuth_rejected_s = std::clamp(s.azimuth_rejected_s + (azimuth_is_far ? T : -T), R(0), 5 * max_azimuth_rejected_s);
    // One rejection may be noise: it reduces the undisturbed time by three times its own.
    s.undisturbed_s = verdict == FieldVerdict::accept ? s.undisturbed_s + T : std::fmax(R(0), s.undisturbed_s - 3 * T);
    // After a change of reference three times as long is required.
    const R needed_s = R(options_.ready_undisturbed_s) * (s.field.changes > 0 ? 3 : 1);
    if (has_lasted(s.undisturbed_s, needed_s) && has_lasted(s.field.heading_trust_s, R(options_.ready_evidence_s)))
        s.heading_confirmed = 1;
}

} // namespace hnav
