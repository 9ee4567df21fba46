// Pendulums side by side, all driven by one torque and each coupled to its neighbours by springs: a model whose size is known
// at run time. A chain of one is the pendulum of pendulum.hpp.
#pragma once

#include "hybrid/filter.hpp"

#include <cmath>
#include <vector>

namespace hnav::test {

class PendulumChain {
public:
    using Event = RuntimeEvent;
    using State = RuntimeState; // angles, rates, upper triangle of their covariance; then held torque, number of jumps
    static constexpr bool has_closed_form = false, bounds_rate = false, reholds = false, turns_back = false;

    PendulumChain() = default;
    explicit PendulumChain(int links) : links_(links) {}

    int nx() const { return n() + n() * (n() + 1) / 2; }
    int channels() const { return 1 + links_; } // torque, angle of each
    int values() const { return 1; }
    std::size_t state_bytes() const { return static_cast<std::size_t>(nx() + 2) * sizeof(double); }
    double jumps(const State& s) const { return s.x()[nx() + 1]; }

    void begin(State& s) const {
        for (int i = 0; i < links_; ++i) s.x()[i] = 0.5;
        for (int i = 0; i < n(); ++i) s.x()[at(i, i)] = 0.1;
    }
    bool flows(const State&) const { return true; }
    bool plausible(const State&) const { return true; }
    void normalise(State&) const {}
    void before_flow(State&, const Event&) const {}

    void flow(const State& s, const double* x, double* dx) const {
        for (int i = 0; i < links_; ++i) {
            const double torque = s.x()[nx()];
            dx[i] = x[links_ + i];
            dx[links_ + i] = -9.81 * std::sin(x[i]) + coupling(i, [&](int k) { return x[k]; }) - 0.2 * x[links_ + i] + torque;
        }
        for (int i = 0; i < n(); ++i)
            for (int j = i; j < n(); ++j) {
                dx[at(i, j)] = linear_flow(x, i, j) + linear_flow(x, j, i);
                if (i == j && i >= links_) dx[at(i, j)] += 1e-3;
            }
    }

    void jump(State& s, const Event& event) const {
        for (int k = 0; k < links_; ++k)
            if (event.has(1 + k)) measure(s.x(), k, event.value(1 + k)[0]);
        if (event.has(0)) s.x()[nx()] = event.value(0)[0];
        s.x()[nx() + 1] += 1;
    }

    void nominal(double* x) const {
        for (int i = 0; i < nx(); ++i) x[i] = i < n() ? 1 : 0.1;
    }

private:
    static constexpr double angle_variance = 1e-4;

    int n() const { return 2 * links_; }

    // Place of element (i, j) of the covariance in x.
    int at(int i, int j) const { return i <= j ? n() + i * n() - i * (i - 1) / 2 + j - i : at(j, i); }

    // Torque of the springs on link i.
    template <class Angle>
    double coupling(int i, const Angle& angle) const {
        double sum = 0;
        if (i > 0) sum += 3 * (angle(i - 1) - angle(i));
        if (i + 1 < links_) sum += 3 * (angle(i + 1) - angle(i));
        return sum;
    }

    // Element (i, j) of the Jacobian of the flow times the covariance.
    double linear_flow(const double* x, int i, int j) const {
        if (i < links_) return x[at(links_ + i, j)];
        const int link = i - links_;
        return -9.81 * std::cos(x[link]) * x[at(link, j)] + coupling(link, [&](int k) { return x[at(k, j)]; }) -
               0.2 * x[at(i, j)];
    }

    void measure(double* x, int k, double angle) const {
        const double innovation = angle - x[k], S = x[at(k, k)] + angle_variance;
        double column[64];
        for (int i = 0; i < n(); ++i) column[i] = x[at(i, k)];
        for (int i = 0; i < n(); ++i) x[i] += column[i] / S * innovation;
        for (int i = 0; i < n(); ++i)
            for (int j = i; j < n(); ++j) x[at(i, j)] -= column[i] * column[j] / S;
    }

    int links_ = 1;
};

} // namespace hnav::test
