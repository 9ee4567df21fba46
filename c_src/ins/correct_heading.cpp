// A heading from elsewhere: a compass, two antennas. Its error stays as it is for a while, so that many of them tell no more than one.
#include "estimation/gate.hpp"
#include "ins/model.hpp"

namespace hnav::ins {
namespace {

// Once motion has told the heading, headings that agree with it earn trust again.
void note_agreement(State& s, double off, double variance, double sigma2) {
    constexpr double agrees = 4, memory = 50;
    if (!(variance < sigma2)) return;
    if (off * off < agrees * (sigma2 + variance)) s.heading_doubt = std::fmax(1, s.heading_doubt * (1 - 1 / memory));
}

} // namespace

void Model::correct_heading(State& s, Covariance& P, const Event& event) const {
    const double told = event.value[ins::heading][0], sigma = event.value[ins::heading][1];
    const double since_s = event.t_s - s.last_s[ins::heading];
    const double variance = sigma * sigma * s.heading_doubt;
    const Matrix3 R = attitude(s);
    const double yaw = std::atan2(R(1, 0), R(0, 0));
    Measurement m{ins::heading};
    if (is_free(s)) {
        // The turn of the axes is what lies between the heading and the yaw in them: its cosine and sine are u.
        const double c = std::cos(told - yaw), t = std::sin(told - yaw);
        m.rows = 2;
        m.H[0][row_u] = m.H[1][row_u + 1] = 1;
        m.H[0][row_phi + 2] = -t;
        m.H[1][row_phi + 2] = c;
        m.R[0] = m.R[1] = variance;
        m.r[0] = c - s.u[0];
        m.r[1] = t - s.u[1];
        gate_given_heading(s, P, m);
    } else {
        m.rows = 1;
        m.H[0][row_phi + 2] = 1;
        m.R[0] = variance;
        m.r[0] = wrap_angle(told - yaw);
        const double known = P[row_phi + 2][row_phi + 2], limit = gate_for_rows(1, options_.gate_nis);
        note_agreement(s, m.r[0], known, sigma * sigma);
        m.nis = m.r[0] * m.r[0] / (known + variance);
        const double over = beyond_gate(m.nis, limit);
        m.scale = over * over;
        m.R[0] *= m.scale;
        m.gated = false;
    }
    // Judged as one heading; what it adds to those before it is less.
    for (double& r : m.R) r *= std::fmax(1, options_.heading_colour_s / since_s);
    use(s, P, event, m);
    double& in_row = s.refused_in_row[ins::heading];
    in_row = s.innovation[ins::heading].noise_scale > 1 ? in_row + 1 : 0;
}

// A heading that contradicts those which are told has to be known better than one that nobody contradicts: they have had their part in it.
double Model::contradicted(const State& s, double now_s) const {
    constexpr double by_chance = 5, better = 3, fresh_s = 60;
    return s.refused_in_row[ins::heading] > by_chance && now_s - s.last_s[ins::heading] < fresh_s ? better : 1;
}

} // namespace hnav::ins
