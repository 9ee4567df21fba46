// Whether a field is still that of a moment ago. Seen in axes that the gyroscopes hold the field of the Earth stays as it is, in size and dip
// and, as far as the gyroscopes tell, in direction; that of the iron turns with the body. None of this needs the heading, nor the strength of
// the field: where an unknown strength may be anything, a sample that is judged by the equation of correct_field.cpp fits by making the
// strength of all samples small. So what has changed by itself is seen while nothing is known yet, and a false field does not get in.
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

// In units of the horizontal field: strength (m - m0) - (R - R0) iron. If nothing but the body has turned, m - m0 is (R - R0) iron / strength,
// so an error of the strength counts as far as it changes the iron that fits. Noise in what is measured draws the strength of a body that
// has not turned towards 0; but with iron or without, hardly a field is weaker than the horizontal part of that of the Earth, and the iron is
// the one that goes with that.
double Model::nis_of_change(const State& s, const Covariance& P, const Vector3& measured, double age_s) const {
    const Vector3 before = vec(s.in_t.field);
    const Matrix3 R = attitude(s), turned = R - axes_then(s);
    const Vector3 with_strength(P[row_iron][row_strength], P[row_iron + 1][row_strength], P[row_iron + 2][row_strength]);
    const double strength = std::fmax(1 / before.norm(), s.strength), known = P[row_strength][row_strength];
    const Vector3 iron = vec(s.iron) + (strength - s.strength) / known * with_strength, share = iron / strength;
    const Matrix3 both = with_strength * share.transpose();
    const Matrix3 unknown = P.block(row_iron, row_iron) - both - both.transpose() + known * share * share.transpose();
    const Matrix3 drift = age_s * strength * cross_matrix(before) * R; // by an error of the gyroscopes
    // What is soft in the iron acts on the whole field as the body turns.
    const double aside = std::fmax(1, strength * before.head<2>().norm());
    const double noise2 = options_.field_noise * options_.field_noise *
                          (aside * aside + strength * strength * before.squaredNorm() * turned.squaredNorm() / 3);
    const Matrix3 S = turned * unknown * turned.transpose() + drift * P.block(row_gyro, row_gyro) * drift.transpose() +
                      noise2 * Matrix3::Identity();
    const Cholesky<3> factor(S);
    const Vector3 change = strength * (measured - before) - turned * iron;
    return factor.positive() ? change.dot(factor.solve<1>(change)) : 0;
}

// False: this is another field. Once one was, only a field that fits as well as by chance is the old one: a body that turns meanwhile, with
// iron that nobody knows, would let it fade into what the gate lets through.
bool Model::remembers_field(State& s, const Covariance& P, const Event& event) const {
    constexpr double by_chance = 3; // the mean of chi square, of three values
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
