// A sensor whose white noise is increased for a while: the noise-increment fault of Hajiyev and Hacizade (2023).
#pragma once

#include <cmath>

namespace hnav {

struct NoiseFault {
    double start_s = 0, stop_s = 0; // both samples included
    double factor = 1;              // on the standard deviation; 1: no fault

    // Sample k of the interval dt. In samples, because 15.000000000000002 s must not lose the last one.
    bool active(double k, double dt_s) const {
        return factor != 1 && k >= std::ceil(start_s / dt_s - 1e-6) && k <= std::floor(stop_s / dt_s + 1e-6);
    }
    double factor_at(double k, double dt_s) const { return active(k, dt_s) ? factor : 1; }
};

} // namespace hnav
