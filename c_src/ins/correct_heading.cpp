// An external heading, from a compass or two antennas. Its error is correlated in time (heading_colour_s), so many samples within
// that time have the weight of one.
#include "estimation/gate.hpp"
#include "ins/model.hpp"

namespace hnav::ins {
namespace {

// When motion has determined the heading, external headings that agree with it reduce the inflation of their variance.
void note_agreement(State& s, double off, double variance, double sigma2) {
    constexpr double agrees = 4, memory = 50;
    if (!(variance < sigma2)) return;
    if (off * off < agrees * (sigma2 + variance)) s.heading_inflation = std::fmax(1, s.heading_inflation * (1 - 1 / memory));
}

} // namespace

void Model::correct_heading(State& s, Covariance& P, const Event& event) const {
    const double measured = event.value[ins::heading][0], sigma = event.value[ins::heading][1];
    const double since_s = event.t_s - s.last_s[ins::heading];
    const double variance = sigma * sigma * s.heading_inflation;
    const Matrix3 R = attitude(s);
    const double yaw = std::atan2(R(1, 0), R(0, 0));
    const double share = std::fmin(1, since_s / options_.heading_colour_s);
    if (is_free(s)) {
        weigh_heading(s, P, wrap_angle(measured - yaw), variance, share);
    } else {
        Measurement m{ins::heading, 1};
        m.H[0][row_phi + 2] = 1;
        m.R[0] = variance;
        m.r[0] = wrap_angle(measured - yaw);
        const double known = P[row_phi + 2][row_phi + 2], limit = gate_for_rows(1, options_.gate_nis);
        note_agreement(s, m.r[0], known, sigma * sigma);
        m.nis = m.r[0] * m.r[0] / (known + variance);
        const double over = beyond_gate(m.nis, limit);
        m.scale = over * over;
        // The gate uses the variance of one sample; the correction uses its share of the correlation time.
        m.R[0] *= m.scale / share;
        m.gated = false;
        use(s, P, event, m);
    }
}

} // namespace hnav::ins
