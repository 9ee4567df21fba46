// Seeded numbers and Jacobians by perturbation, for tests of laws.
#pragma once

#include "maths/rotation.hpp"

#include <gtest/gtest.h>
#include <random>

namespace hnav::test {

class Random {
public:
    explicit Random(unsigned seed) : engine_(seed) {}

    double normal(double sigma = 1) { return sigma * normal_(engine_); }
    Vector3 vector(double sigma = 1) { return {normal(sigma), normal(sigma), normal(sigma)}; }
    template <int n>
    Eigen::Matrix<double, n, 1> numbers() {
        Eigen::Matrix<double, n, 1> v;
        for (int i = 0; i < n; ++i) v[i] = normal();
        return v;
    }
    Quaternion quaternion() { return Quaternion(normal(), normal(), normal(), normal()).normalized(); }

    template <int n>
    Eigen::Matrix<double, n, n> covariance(double scale = 1) {
        Eigen::Matrix<double, n, n> A;
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) A(i, j) = normal();
        return scale * (A * A.transpose() + 0.1 * Eigen::Matrix<double, n, n>::Identity());
    }

private:
    std::mt19937_64 engine_;
    std::normal_distribution<double> normal_;
};

// Central differences of f: R^n -> R^m.
template <int m, int n, class F>
Eigen::Matrix<double, m, n> perturbation_jacobian(F&& f, const Eigen::Matrix<double, n, 1>& x, double step = 1e-5) {
    Eigen::Matrix<double, m, n> J;
    for (int j = 0; j < n; ++j) {
        Eigen::Matrix<double, n, 1> up = x, down = x;
        up[j] += step;
        down[j] -= step;
        J.col(j) = (f(up) - f(down)) / (2 * step);
    }
    return J;
}

template <class A, class B>
double distance(const A& a, const B& b) {
    return (a - b).cwiseAbs().maxCoeff();
}

} // namespace hnav::test
