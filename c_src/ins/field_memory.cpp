// Tests whether the field is still that of a moment ago. In axes held by the gyroscopes the field of the Earth is constant in intensity,
// dip and direction; the field of the body's iron turns with the body. The test needs neither the heading nor the intensity. The
// equation of correct_field.cpp alone would accept any field while the intensity is unknown, because a fit that shrinks the
// strength explains every sample. This test rejects such a field from the start.
#include "ins/model.hpp"
#include "maths/cholesky.hpp"

namespace hnav::ins {

namespace {

Eigen::Map<Matrix3> axes_then(State& s) { return Eigen::Map<Matrix3>(s.in_t.attitude[0]); }
Matrix3 axes_then(const State& s) { return Eigen::Map<const Matrix3>(s.in_t.attitude[0]); }

} // namespace

void turn_field(State& s, const Matrix3& C) {
    vec(s.in_t.field) = Vector3(C * vec(s.in_t.field));
    axes_then(s) = Matrix3(C * axes_then(s));
}

// NIS of the change, in units of the horizontal field: strength (m - m0) - (R - R0) iron. If only the body has turned, m - m0 is
// (R - R0) iron / strength, so an error of the strength acts only through the iron estimated with it. Measurement noise biases the
// strength of a body that has not turned towards 0. The strength used here is therefore at least 1 / |m0|, with the iron that
// corresponds to it: a field is rarely weaker than the horizontal field of the Earth.
double Model::nis_of_change(const State& s, const Covariance& P, const Vector3& measured, double age_s) const {
    const Vector3 before = vec(s.in_t.field);
    const Matrix3 R = attitude(s), turned = R - axes_then(s);
    const Vector3 with_strength(P[row_iron][row_strength], P[row_iron + 1][row_strength], P[row_iron + 2][row_strength]);
    const double strength = std::fmax(1 / before.norm(), s.strength), known = P[row_strength][row_strength];
    const Vector3 iron = vec(s.iron) + (strength - s.strength) / known * with_strength, share = iron / strength;
    const Matrix3 both = with_strength * share.transpose();
    const Matrix3 unknown = P.block(row_iron, row_iron) - both - both.transpose() + known * share * share.transpose();
    const Matrix3 drift = age_s * strength * cross_matrix(before) * R; // by gyroscope bias
    // Soft iron acts on the whole field as the body turns.
    const double aside = std::fmax(1, strength * before.head<2>().norm());
    const double noise2 = options_.field_noise * options_.field_noise *
                          (aside * aside + strength * strength * before.squaredNorm() * turned.squaredNorm() / 3);
    const Matrix3 S = turned * unknown * turned.transpose() + drift * P.block(row_gyro, row_gyro) * drift.transpose() +
                      noise2 * Matrix3::Identity();
    return normalised_square<3, double>(S, strength * (measured - before) - turned * iron);
}

// Returns false for a different field. After a rejection the limit is the mean of chi-square instead of the gate: otherwise a body
// that turns with unknown iron would gradually widen the test until the gate accepts the different field.
bool Model::remembers_field(State& s, const Covariance& P, const Event& event) const {
    constexpr double by_chance = 3; // mean of chi-square with three degrees of freedom
    const double over_s = options_.field_colour_s, since_s = event.t_s - s.field_until_s;
    const bool refused = std::isfinite(s.refused_since_s[field]);
    const Vector3 measured = attitude(s) * (s.field_unit * vec(event.value[field]));
    if (std::isnan(since_s) || (!refused && has_passed(since_s, over_s))) {
        vec(s.in_t.field) = measured;
        axes_then(s) = attitude(s);
        s.field_until_s = event.t_s;
        return true;
    }
    if (options_.gate_nis > 0) {
        const double limit = refused ? std::fmin(by_chance, options_.gate_nis) : options_.gate_nis;
        if (nis_of_change(s, P, measured, since_s + over_s) > limit) return false;
    }
    const double share = since_s / (since_s + over_s);
    vec(s.in_t.field) += share * (measured - vec(s.in_t.field));
    axes_then(s) += share * (attitude(s) - axes_then(s));
    s.field_until_s = event.t_s;
    return true;
}

} // namespace hnav::ins
