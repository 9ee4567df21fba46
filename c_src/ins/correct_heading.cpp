// A heading from elsewhere: a compass, two antennas.
#include "ins/model.hpp"

namespace hnav::ins {

void Model::correct_heading(State& s, Covariance& P, const Event& event) const {
    const double told = event.value[ins::heading][0], sigma = event.value[ins::heading][1];
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
        m.R[0] = m.R[1] = sigma * sigma;
        m.r[0] = c - s.u[0];
        m.r[1] = t - s.u[1];
    } else {
        m.rows = 1;
        m.H[0][row_phi + 2] = 1;
        m.R[0] = sigma * sigma;
        m.r[0] = wrap_angle(told - yaw);
    }
    use(s, P, event, m);
}

} // namespace hnav::ins
