// The vectors that SUNDIALS computes with.
#pragma once

#include "hybrid/sundials_names.hpp"

namespace hnav::sundials {

// The stages of Dormand and Prince's method without the last one, which only estimates the error.
constexpr int stages_of_equal_steps = 6;

inline double* data(N_Vector v) { return static_cast<double*>(v->content); }

// n zeros; null without memory. read: number of elements that the flow reads, for a Runge-Kutta method.
N_Vector create_vector(int n, int read, SUNContext context);

} // namespace hnav::sundials
