// Replaces propagator.cpp where SUNDIALS is missing: FMUs compiled from their own sources. Only Euler integrates; instead of
// the other integrators the closed forms of the models are used.
#include "hybrid/propagator.hpp"

#include <cstdlib>

namespace hnav {

struct Propagator::Solver {};

Propagator::~Propagator() { std::free(slope_); }

bool Propagator::create(int nx, Flow flow, const Settings& settings, const void*, const double*) {
    nx_ = nx;
    flow_ = flow;
    euler_step_s_ = settings.euler_step_s;
    max_steps_ = settings.integrator == Integrator::euler ? settings.max_steps : 0;
    slope_ = static_cast<double*>(std::calloc(2 * nx, sizeof(double)));
    return slope_ != nullptr;
}

bool Propagator::integrate(const void* context, double interval_s, double* x, double) {
    return max_steps_ > 0 && integrate_euler(context, interval_s, x);
}

bool Propagator::begin(const void*, double, const double*) { return false; }
bool Propagator::step(double*, double*) { return false; }
bool Propagator::between(double, double*) { return false; }

} // namespace hnav
