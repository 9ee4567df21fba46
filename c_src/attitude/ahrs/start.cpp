// The prior, the start, and what a new start or a reversal of time resets.
#include "attitude/ahrs/model.hpp"

namespace hnav {

void AhrsModel::begin(State& s) const {
    Eigen::Map<Vector3R>(s.bias) = Vector3(options_.start_gyro_bias_rad_s).cast<R>();
    s.force_latency = R(options_.start_accel_latency);
    s.reversed = 0;
    s.wrong_hold = suspected_hold;
    s.gamma = std::numeric_limits<R>::infinity();
    s.gamma_margin = 1;
    for (InnovationOf<R>& i : s.innovation) i = {};
    forget_attitude(s);
}

void AhrsModel::realign(State& s) const {
    const Covariance P = unpack_columns<errors>(s.P);
    forget_attitude(s);
    Covariance kept = unpack_columns<errors>(s.P);
    block<9, 9>(kept, calibration, calibration) = block<9, 9>(P, calibration, calibration);
    block<3, 3>(kept, bias, bias) = block<3, 3>(P, bias, bias);
    kept(latency, latency) = P(latency, latency);
    block<4, 4>(kept, force_bias, force_bias) = block<4, 4>(P, force_bias, force_bias);
    pack_columns<errors>(kept, s.P);
    ++s.seldom_changes;
}

// Sigmas of a filter that has processed the recording, wide enough to estimate the other end again.
void AhrsModel::turn_back(State& s, double t_s) const {
    for (R* v : {s.bias, s.rate, s.read_rate, s.coning})
        for (int i = 0; i < 3; ++i) v[i] = -v[i];
    s.latency = -s.latency;
    s.reversed = !s.reversed;
    s.force_latency = -s.force_latency; // a force of the interval before is one of the interval after
    s.declination = s.foreign2 = 0;
    note_turning(s);
    for (R& v : s.force_turn) v = 0;
    s.velocity[0] = s.velocity[1] = 0;
    const Sigmas& set = sigma_;
    start_covariance(s, {R(0.02), R(0.15), R(1e-3), set.velocity, R(0.03), R(3e-3), R(7e-4), R(7e-4), R(0.2) * set.force_bias,
                         R(0.1), set.declination});
    // The reference has been measured in this recording, so a false field at its other end has to contradict that evidence. The trust in
    // the heading is gathered again.
    const MagneticReference<R> before = s.field;
    s.field = {};
    s.field.changes = before.changes;
    s.field.evidence_s = s.field.served_s = before.evidence_s;
    s.field_noise.take_in_full();
    s.reference_variance = s.contradicted_s = 0;
    s.motion.forget_velocity();
    s.lasting.forget_velocity();
    s.vehicle_tilt.forget_velocity();
    s.tilt_excess = {};
    s.speed = {};
    s.rest.clear(Vector3R::Zero(), Vector3R::Zero());
    for (double& t : s.last_s) t = nan;
    s.last_correction_s = t_s;
    forget_window(s);
}

void AhrsModel::forget_attitude(State& s) const {
    for (R& v : s.x) v = 0;
    s.x[0] = 1;
    s.started = s.lost = s.gap_too_long = 0;
    s.start.clear();
    s.field = {};
    s.velocity[0] = s.velocity[1] = s.declination = 0;
    for (R& v : s.force_turn) v = 0;
    for (double& t : s.last_s) t = nan;
    for (double& t : s.spacing_s) t = 0;
    s.last_correction_s = nan;
    s.information = {};
    s.verdict = s.heading_confirmed = 0;
    s.undisturbed_s = s.azimuth_rejected_s = s.reference_variance = s.contradicted_s = s.foreign2 = 0;
    s.has_reference = reference_given(options_);
    put_reference(s, reference_of<R>(options_));
    begin_motion(s);
    s.field_noise.begin();
    start_covariance(s, start_sigmas(start_.sigma_heading));
    forget_window(s);
}

void AhrsModel::start_covariance(State& s, const Sigmas& start) const {
    Vector sigma;
    segment<2>(sigma, velocity).setConstant(start.velocity);
    segment<9>(sigma, calibration).setConstant(start.misalignment);
    for (int i = 0; i < 9; i += 4) sigma[calibration + i] = start.scale;
    segment<2>(sigma, rotation).setConstant(start.tilt);
    sigma[rotation + 2] = start.heading;
    segment<3>(sigma, bias).setConstant(start.bias);
    segment<2>(sigma, reference).setConstant(start.reference);
    sigma[latency] = start.latency;
    segment<3>(sigma, force_bias).setConstant(start.force_bias);
    sigma[force_latency] = start.force_latency;
    sigma[declination] = start.declination;
    pack_columns<errors>(Covariance(sigma.cwiseAbs2().asDiagonal()), s.P);
    s.steps.forget_iron();
    begin_steps(s);
    ++s.seldom_changes;
}

AhrsModel::Sigmas AhrsModel::start_sigmas(R sigma_heading) const {
    Sigmas sigmas = sigma_;
    sigmas.heading = sigma_heading;
    sigmas.declination *= FieldNoise<R>::at_first / FieldNoise<R>::room;
    return sigmas;
}

// The unit is the given field, or the first measured one.
void AhrsModel::put_reference(State& s, const ReferenceFieldOf<R>& field) {
    s.strength = field.strength;
    s.reference[0] = std::cos(field.dip_rad);
    s.reference[1] = std::sin(field.dip_rad);
}

// Its dip was measured from the estimated horizon: in the notation of FieldRows (correct_field.cpp) theta x M = dM.
void AhrsModel::put_learnt_reference(State& s, const Vector3R& field_b) {
    put_reference(s, learn_reference<R>(QuaternionR(s.x), field_b));
    s.has_reference = 1;
    add_error(s, rotation + 1, s.reference[1], reference);
    add_error(s, rotation + 1, -s.reference[0], reference + 1);
}

// The heading is that of a field whose horizontal part was found with the estimated horizon.
void AhrsModel::tie_heading_to_horizon(State& s) {
    const R tangent = s.reference[1] / s.reference[0],
            largest = std::sqrt(any_angle_variance<R> / s.P[packed(rotation, rotation)]);
    add_error(s, rotation, std::clamp(tangent, -largest, largest), rotation + 2);
}

// The error `to` is larger by a multiple of the error `from`.
void AhrsModel::add_error(State& s, int from, R factor, int to) {
    const auto of = [&s](int i, int j) -> R& { return s.P[packed(std::min(i, j), std::max(i, j))]; };
    of(to, to) += factor * (2 * of(from, to) + factor * of(from, from));
    for (int j = 0; j < errors; ++j)
        if (j != to) of(to, j) += factor * of(from, j);
}

void AhrsModel::start(State& s, const Event& event) const {
    FirstAttitude<R> found;
    ++s.seldom_changes;
    if (!s.start.add(event, s.usable(event), turn_rate(s), start_, &found)) return;
    Eigen::Map<QuaternionR>(s.x) = found.q;
    const bool realigned = s.corrections > 0;
    if (!realigned) {
        start_covariance(s, start_sigmas(found.sigma_heading));
        if (start_.mode == StartMode::attitude) s.vehicle_tilt.tilt2 = std::fmin(s.vehicle_tilt.tilt2, sigma_.tilt * sigma_.tilt);
    } else s.P[packed(rotation + 2, rotation + 2)] = found.sigma_heading * found.sigma_heading;
    if (!s.has_reference && s.start.has_field(start_)) put_learnt_reference(s, s.start.field());
    if (found.by_field) tie_heading_to_horizon(s);
    if (place_.is_given && s.start.has_field(start_)) start_in_foreign_field(s);
    s.rest.clear(Vector3R::Zero(), s.start.force());
    s.last_correction_s = event.t_s;
    s.started = 1;
}

// A start in a field that is not the given one: the heading is wrong by the declination of that field.
void AhrsModel::start_in_foreign_field(State& s) const {
    const MeanField<R> seen{rotation_matrix<R>(QuaternionR(s.x)) * s.start.field() / s.strength};
    if (place_.is_of_place(seen.horizontal(), seen.n[2])) return;
    s.foreign2 = place_.azimuth_variance(seen.horizontal(), seen.n[2]);
    s.P[packed(rotation + 2, rotation + 2)] += s.foreign2;
    s.P[packed(declination, declination)] += s.foreign2;
    s.P[packed(rotation + 2, declination)] += s.foreign2;
}

// Turns attitude and all that is kept in navigation axes about the vertical.
void AhrsModel::turn_heading(State& s, R angle_rad) {
    const QuaternionR about_down = rotation_quaternion<R>({0, 0, angle_rad});
    Eigen::Map<QuaternionR>(s.x) = multiply<R>(about_down, QuaternionR(s.x));
    const R cosine = std::cos(angle_rad), sine = std::sin(angle_rad);
    for (R* v : {s.velocity, s.motion.velocity, s.motion.mean_force, s.field.candidate, s.lasting.before, s.lasting.velocity[0],
                 s.lasting.velocity[1], s.lasting.velocity[2], s.lasting.lasting[0], s.lasting.lasting[1], s.lasting.lasting[2],
                 s.lasting.mean_force, s.lasting.force, s.tilt_excess.corrected, s.vehicle_tilt.tilt, s.vehicle_tilt.velocity}) {
        const R north = v[0], east = v[1];
        v[0] = cosine * north - sine * east;
        v[1] = sine * north + cosine * east;
    }
}

// The first field after a start without one: its azimuth defines north, so the heading turns to it.
void AhrsModel::initialise_heading_by_field(State& s, const Vector3R& field_b) const {
    const Vector3R field_n = rotation_matrix<R>(QuaternionR(s.x)) * field_b;
    if (!(std::hypot(field_n[0], field_n[1]) > R(1e-3) * field_n.norm())) return;
    const R from_north = std::atan2(field_n[1], field_n[0]);
    ++s.seldom_changes;
    R& variance = s.P[packed(rotation + 2, rotation + 2)];
    if (from_north * from_north > variance || variance > 1) {
        turn_heading(s, -from_north);
        variance += start_.sigma_heading * start_.sigma_heading;
    }
    put_learnt_reference(s, field_b);
}

} // namespace hnav
