// Van der Pol's oscillator with damping 1 as functions of a plant: x (2) position and speed, one output, the position.
#pragma once

namespace hnav::test {

inline int van_der_pol(void*, double, const double* x, const double*, const double*, double* dx) {
    dx[0] = x[1];
    dx[1] = (1 - x[0] * x[0]) * x[1] - x[0];
    return 0;
}

inline int van_der_pol_jacobian(void*, double, const double* x, const double*, const double*, double* J) {
    J[0] = 0;
    J[1] = 1;
    J[2] = -2 * x[0] * x[1] - 1;
    J[3] = 1 - x[0] * x[0];
    return 0;
}

inline int first_state(void*, double, const double* x, const double*, const double*, double* y) {
    y[0] = x[0];
    return 0;
}

} // namespace hnav::test
