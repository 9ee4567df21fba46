// Eigenvalues and vectors of a symmetric matrix by plane rotations, until the off-diagonal elements are zero (Jacobi 1846). For
// many rows it takes several times as long as Eigen's solver, and a twentieth of its code.
#pragma once

#include "maths/covariance.hpp"

#include <cmath>
#include <limits>

namespace hnav {

// A is left with its eigenvalues on the diagonal; their vectors are the columns of V.
template <int n, class R>
class Jacobi {
public:
    explicit Jacobi(Square<n, R>& A) : A_(A) {
        constexpr int most_sweeps = 30; // six are usual
        V.setIdentity();
        for (int sweep = 0; sweep < most_sweeps && turn_all(); ++sweep) {
        }
    }

    Square<n, R> V;

private:
    // False: the matrix was already diagonal.
    bool turn_all() {
        constexpr R precision = std::numeric_limits<R>::epsilon();
        const R size = A_.diagonal().cwiseAbs().maxCoeff();
        bool turned = false;
        for (int p = 0; p < n; ++p)
            for (int q = p + 1; q < n; ++q) {
                const R beside = A_(p, q);
                if (!(std::fabs(beside) > precision * precision * size)) continue;
                turn(p, q, beside);
                turned = turned || std::fabs(beside) > precision * size;
            }
        return turned;
    }

    // The rotation in the plane of p and q that makes A(p, q) zero.
    void turn(int p, int q, R beside) {
        const R half = (A_(q, q) - A_(p, p)) / (2 * beside);
        const R t = std::copysign(1 / (std::fabs(half) + std::sqrt(1 + half * half)), half); // tangent, at most 1
        const R c = 1 / std::sqrt(1 + t * t), s = t * c;
        for (int i = 0; i < n; ++i) turn_pair(A_(i, p), A_(i, q), c, s);
        for (int i = 0; i < n; ++i) turn_pair(A_(p, i), A_(q, i), c, s);
        for (int i = 0; i < n; ++i) turn_pair(V(i, p), V(i, q), c, s);
    }

    static void turn_pair(R& a, R& b, R c, R s) {
        const R before = a;
        a = c * before - s * b;
        b = s * before + c * b;
    }

    Square<n, R>& A_;
};

} // namespace hnav
