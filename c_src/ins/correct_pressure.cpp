// Barometric height. Its offset from the standard atmosphere is a state that GNSS positions determine.
#include "ins/model.hpp"

namespace hnav::ins {

void Model::correct_pressure(State& s, Covariance& P, const Event& event) const {
    const double* z = event.value[pressure];
    const double height = earth::pressure_height_m(z[0]);
    const earth::Place place = place_of(s);
    const Vector3 up = -vec(s.gravity).normalized();
    // At the first sample the offset is known to the range of weather only. If the height is known no better than that, the sample
    // contains no information.
    if (std::isnan(s.offset)) {
        constexpr double weather_m = 300;
        if (up.dot(P.block(row_d, row_d) * up) > weather_m * weather_m) return;
        s.offset = height - place.height_m;
        P.forget(row_offset);
        P[row_offset][row_offset] = weather_m * weather_m;
    }
    Measurement m{pressure, 1};
    for (int i = 0; i < 3; ++i) m.H[0][row_d + i] = up[i];
    m.H[0][row_offset] = 1;
    const double sigma = 0.5 * (earth::pressure_height_m(z[0] - z[1]) - earth::pressure_height_m(z[0] + z[1]));
    m.R[0] = sigma * sigma;
    m.r[0] = height - place.height_m - s.offset;
    use(s, P, event, m);
}

} // namespace hnav::ins
