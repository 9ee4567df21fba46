// Exact discretisation of dx/dt = A x + B u + w with u held over the interval T and w white of spectral density Q.
//   C. F. Van Loan, Computing integrals involving the matrix exponential, IEEE Trans. Automatic Control 23(3), 1978:
//   exp([-A Q; 0 A'] T) = [* M12; 0 M22],  Ad = M22',  Qd = Ad M12;   exp([A B; 0 0] T) = [Ad Bd; 0 I].
#pragma once

#include <Eigen/Core>

namespace hnav {

constexpr int max_dimension = 32;

// Bounded at compile time, so that the exponential works on the stack: no allocation here or inside Eigen.
template <int bound>
using Bounded = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, bound, bound>;
using Small = Bounded<max_dimension>;

namespace {
// Eigen determines the cache sizes of the processor once, in a function-local static. Determined when the library is loaded,
// they are set before there are threads.
[[maybe_unused]] const std::ptrdiff_t cache_size_is_known = Eigen::l1CacheSize();
} // namespace

struct Discrete {
    Small A, B, Q;
};

// A n x n, B n x m (m may be 0), Q n x n symmetric; T in the time unit of A. n and m at most 32.
Discrete discretise(const Small& A, const Small& B, const Small& Q, double T);

} // namespace hnav
