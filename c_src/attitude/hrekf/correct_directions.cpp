// Correction by force and field: the directions of gravity and of the magnetic field, each known in navigation axes and
// measured in body axes. Force and field of one event correct together: the six rows of the paper.
//
// A direction m = (north, 0, down) is measured as R_nb (m + m x theta + 2 m l) + noise, the same in all directions. Seen along east,
// along c = (down, 0, -north) and along m that are three rows without a sine:
//     east   down theta_n - north theta_d        c   -theta_e        m   2 l
#include "attitude/hrekf/correction.hpp"
#include "attitude/hrekf/model.hpp"
#include "estimation/gate.hpp"

namespace hnav {

struct HrekfDirection {
    using R = Scalar;

    int channel;
    R north, down; // of length 1
    Vector3Of<R> measured_b;
    R variance;
};

// Its rows at one attitude.
struct HrekfRows {
    using R = Scalar;

    R north, down;
    Vector3Of<R> east_b, c_b, m_b; // the axes, in the body
    Vector3Of<R> nu_b, nu;
    R noise, noise_between; // noise of the first two by theta, on and beside the diagonal; noise of the third
    R noise_c, length_noise;

    void set(const HrekfDirection& d, const Matrix3Of<R>& R_bn) {
        north = d.north;
        down = d.down;
        noise = noise_c = length_noise = d.variance;
        noise_between = 0;
        const Vector3Of<R> x = R_bn.row(0), z = R_bn.row(2);
        east_b = R_bn.row(1);
        c_b = down * x - north * z;
        m_b = north * x + down * z;
        nu_b = d.measured_b - m_b;
        nu = {east_b.dot(nu_b), c_b.dot(nu_b), m_b.dot(nu_b)};
    }
    Vector3Of<R> of_east() const { return {down, 0, -north}; }
    static Vector3Of<R> of_c() { return {0, -1, 0}; }
};

namespace {

// A field of a thousand times the reference is used as a direction only: at its full length it would drive the bias estimate beyond
// any rate.
Vector3Of<Scalar> field_in_units(const AttitudeEvent& event, Scalar strength) {
    constexpr Scalar longest = 1e3;
    const Vector3Of<Scalar> field = vector_of<Scalar>(event, mag) / strength;
    const Scalar length = field.norm();
    return length > longest ? Vector3Of<Scalar>(field * (longest / length)) : field;
}

} // namespace

void HrekfModel::correct_directions(State& s, const Event& event) const {
    const R T_accel = s.has(event, accel) ? interval(s, accel, event.t_s) : 0;
    R T_mag = s.has(event, mag) ? interval(s, mag, event.t_s) : 0;
    if (s.has(event, mag) && !s.has_reference) { // started without a field: this one becomes the reference
        learn(s, QuaternionR(s.x).normalized(), vector_of<R>(event, mag));
        T_mag = 0;
    }
    HrekfDirection directions[2];
    int count = 0;
    if (T_accel > 0)
        directions[count++] = {accel, 0, -1, vector_of<R>(event, accel).normalized(), density_.accel_density2 / T_accel};
    if (T_mag > 0)
        directions[count++] = {mag, s.reference_north, s.reference_down, field_in_units(event, s.reference_strength),
                               density_.mag_density2 / T_mag};
    if (count > 0) correct_by(s, event.t_s, directions, count);
    if (T_mag > 0) note_contradiction(s, T_mag);
}

// Stores the innovation of a sensor. A sample beyond its gate is not rejected: its noise is inflated until its NIS is at the limit.
void HrekfModel::judge(State& s, double t_s, const HrekfDirection& d, const HrekfCorrection& correction, HrekfRows& rows) const {
    const Covariance& P = correction.gaussian().P;
    const R east = correction.gaussian().seen_by(rows.of_east()) + rows.noise, c = P(1, 1) + rows.noise_c;
    const R between = rows.north * P(1, 2) - rows.down * P(0, 1);
    const R along = 4 * correction.gaussian().length_variance + rows.length_noise;
    InnovationOf<R>& i = s.innovation[d.channel];
    i.t_s = t_s;
    i.dimension = 3;
    Eigen::Map<Vector3R>(i.value) = rows.nu_b;
    const Vector3R by_east = east * rows.east_b + between * rows.c_b, by_c = between * rows.east_b + c * rows.c_b;
    const Vector3R by_m = along * rows.m_b;
    for (int k = 0; k < 3; ++k)
        Eigen::Map<Vector3R>(i.S + 3 * k) = by_east[k] * rows.east_b + by_c[k] * rows.c_b + by_m[k] * rows.m_b;
    const Vector3R& nu = rows.nu;
    const R across = (c * nu[0] * nu[0] - 2 * between * nu[0] * nu[1] + east * nu[1] * nu[1]) / (east * c - between * between);
    i.nis = std::fmax(R(0), across + nu[2] * nu[2] / along); // rounding, where S is nearly singular
    i.noise_scale = 1;
    const R over = beyond_gate(i.nis, gate_nis(d.channel));
    if (!(over > 1 && gate_works(s, d.channel, correction.rotation_variances()))) return;
    i.noise_scale = 1 + (over - 1) * (east + c + along) / (3 * d.variance);
    rows.noise += (over - 1) * east;
    rows.noise_c += (over - 1) * c;
    rows.noise_between = (over - 1) * between;
    rows.length_noise += (over - 1) * along;
    ++s.gated[d.channel];
}

// All gates are evaluated before the first correction.
void HrekfModel::correct_by(State& s, double t_s, const HrekfDirection* directions, int count) const {
    const Matrix3R R_bn = rotation_matrix<R>(QuaternionR(s.x));
    HrekfCorrection correction(law_, s, t_s, covariance(s), length_variance(s));
    HrekfRows rows[2];
    for (int k = 0; k < count; ++k) {
        rows[k].set(directions[k], R_bn);
        judge(s, t_s, directions[k], correction, rows[k]);
    }
    R weight = 0, weighted = 0; // what all say along c, where they see the same
    for (int k = 0; k < count; ++k) {
        const HrekfRows& r = rows[k];
        const R shared = r.noise_between / r.noise_c; // the first row without what its noise shares with that of the second
        correction.take(r.of_east() - shared * r.of_c(), r.nu[0] - shared * r.nu[1], r.noise - shared * r.noise_between);
        correction.take_length(r.nu[2], r.length_noise);
        weight += 1 / r.noise_c;
        weighted += r.nu[1] / r.noise_c;
    }
    correction.take(HrekfRows::of_c(), weighted / weight, 1 / weight);
    correction.apply(directions[0].channel == accel, directions[count - 1].channel == mag);
}

} // namespace hnav
