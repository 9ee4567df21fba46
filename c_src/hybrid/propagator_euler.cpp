// The paper's integrator, which needs no library.
#include "hybrid/propagator.hpp"

#include <cmath>

namespace hnav {

bool Propagator::integrate_euler(const void* context, double interval_s, double* x) {
    // Equal sub-steps, none longer than requested.
    const double steps = std::fmax(1, std::ceil(interval_s / euler_step_s_ - 1e-9));
    if (steps > static_cast<double>(max_steps_)) return false;
    const double h = interval_s / steps;
    for (double k = 0; k < steps; ++k) {
        if (flow_(context, x, slope_) != 0) return false;
        for (int i = 0; i < nx_; ++i) x[i] += h * slope_[i];
    }
    rhs_evals_ += static_cast<std::uint64_t>(steps);
    steps_ += static_cast<std::uint64_t>(steps);
    return true;
}

} // namespace hnav
