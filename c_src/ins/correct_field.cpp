// The magnetic field of the Earth. A magnetometer observes the heading only: the horizontal field without that of the iron in the body
// points to magnetic north,
//     strength m - R iron = B(north) u + noise,
// which is linear in the unknowns: the heading u, the iron, and the strength, the inverse of the horizontal intensity. A body that turns
// therefore separates its iron from the field, whether its heading is known or not. Soft iron and iron beside the road are noise that is
// correlated over field_colour_s; the deviation of the local field from the declination is a slow error state of its own.
#include "ins/model.hpp"

namespace hnav::ins {

// At the rate of the filter's corrections; samples in between are ignored.
bool Model::wants_field(const State& s, const Event& event) const {
    if (!event.has(field) || !s.started()) return false;
    const double half_s = 0.5 * s.usual_interval_s;
    return has_lasted(event.t_s - s.field_used_s + half_s, options_.correction_interval_s);
}

// The first sample defines the unit: its horizontal part becomes about 1.
void Model::begin_field(State& s, Covariance& P, const Event& event) const {
    if (s.field_unit > 0) return;
    const Vector3 m = vec(event.value[field]);
    constexpr double steepest = 0.1;
    s.field_unit = 1 / std::fmax((attitude(s) * m).head<2>().norm(), steepest * m.norm());
    forget_field(s, P);
}

void Model::forget_field(State& s, Covariance& P) const {
    constexpr double strength_by_place = 0.1;
    vec(s.iron).setZero();
    s.strength = 1;
    s.direction = 0;
    s.field_until_s = nan;
    P.extend(errors);
    for (int row = row_iron; row < errors; ++row) {
        P.forget(row);
        s.mean[row] = 0;
    }
    const double iron2 = options_.start_sigma_iron * options_.start_sigma_iron;
    for (int i = 0; i < 3; ++i) P[row_iron + i][row_iron + i] = iron2;
    P[row_strength][row_strength] = iron2 + strength_by_place * strength_by_place;
    P[row_direction][row_direction] = options_.field_direction_rad * options_.field_direction_rad * s.heading_inflation;
}

double Model::direction_kept(const State& s) const { return std::exp(-s.window.length_s / options_.field_direction_s); }

// Iron was attached to the body, or the local field changed. Until iron and direction are estimated again, the field observes turns
// and not north.
void Model::accept_other_iron(State& s, Covariance& P, double now_s) const {
    double& since_s = s.refused_since_s[field];
    if (!std::isfinite(since_s) || !has_passed(now_s - since_s, options_.gate_longest_s)) return;
    const double iron2 = options_.start_sigma_iron * options_.start_sigma_iron;
    for (int row = row_iron; row <= row_strength; ++row) widen(P, row, iron2);
    constexpr double any_direction2 = 1;
    widen(P, row_direction, any_direction2);
    since_s = nan;
    s.field_until_s = nan;
}

// A field that differs from that of a moment ago is rejected until it has lasted for gate_longest_s (accept_other_iron).
bool Model::leaves_out_field(State& s, const Covariance& P, const Event& event) const {
    if (remembers_field(s, P, event)) return false;
    ++s.inflated[field];
    s.note_refusal(field, true, event.t_s);
    s.field_used_s = event.t_s;
    return true;
}

void Model::correct_field(State& s, Covariance& P, const Event& event) const {
    accept_other_iron(s, P, event.t_s);
    if (leaves_out_field(s, P, event)) return;
    const Matrix3 R = attitude(s);
    const Vector3 measured = R * (s.field_unit * vec(event.value[field]));
    const Vector3 iron = R * vec(s.iron), left = s.strength * measured - iron;
    // North and east at the present place.
    const Matrix3 N = is_free(s) ? Matrix3(mat(s.fix_axes)) : earth::axes_at(place_of(s));
    const double points = options_.declination_rad + s.direction;
    const Vector3 north = mat(s.axes).transpose() * (N * Vector3(std::cos(points), std::sin(points), 0));
    const double B[2][2] = {{north[0], north[1]}, {north[1], -north[0]}};
    const double expected[2] = {B[0][0] * s.u[0] + B[0][1] * s.u[1], B[1][0] * s.u[0] + B[1][1] * s.u[1]};
    const double across[2] = {-expected[1], expected[0]}; // derivative by a rotation about the vertical
    Measurement m{field, 2};
    const double tilt2 = P.larger(row_phi) * left[2] * left[2];
    for (int i = 0; i < 2; ++i) {
        for (int j = 0; j < 3; ++j) m.H[i][row_iron + j] = -R(i, j);
        for (int k = 0; k < 2 && is_free(s); ++k) m.H[i][row_u + k] = -B[i][k];
        m.H[i][row_strength] = measured[i];
        m.H[i][row_phi + 2] = across[i];
        m.H[i][row_direction] = -across[i];
        m.R[i] = options_.field_noise * options_.field_noise + tilt2;
        m.r[i] = expected[i] + iron[i] - s.strength * measured[i];
    }
    gate_given_heading(s, P, m);
    // The gate uses the noise of one sample; the correction uses its share of the correlation time.
    for (double& r : m.R) r *= std::fmax(1, options_.field_colour_s / (event.t_s - s.field_used_s));
    s.field_used_s = event.t_s;
    use(s, P, event, m);
    s.note_refusal(field, s.innovation[field].noise_scale > 1, event.t_s);
}

} // namespace hnav::ins
