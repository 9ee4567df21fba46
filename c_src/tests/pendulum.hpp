// A damped pendulum with a torque input and a measured angle: the filter template is independent of attitude.
#pragma once

#include "hybrid/filter.hpp"
#include "maths/covariance.hpp"

#include <cmath>

namespace hnav::test {

struct Pendulum {
    static constexpr int nx = 5; // angle, rate, upper triangle of their covariance
    enum Channel { torque = 0, angle = 1 };
    using Event = FixedEvent<2, 1>;
    static constexpr bool has_closed_form = false, bounds_rate = false, reholds = false, turns_back = false;

    struct State {
        double x[nx];
        double held_torque;
        double jumps;
    };

    double process_psd = 1e-3;
    double angle_variance = 1e-4;

    void begin(State& s) const {
        const double start[nx] = {0.5, 0, 0.1, 0, 0.1};
        for (int i = 0; i < nx; ++i) s.x[i] = start[i];
    }
    bool flows(const State&) const { return true; }
    bool plausible(const State&) const { return true; }
    void normalise(State&) const {}

    void flow(const State& s, const double* x, double* dx) const {
        dx[0] = x[1];
        dx[1] = -9.81 * std::sin(x[0]) - 0.2 * x[1] + s.held_torque;
        Square<2> A;
        A << 0, 1, -9.81 * std::cos(x[0]), -0.2;
        const Square<2> P = unpack<2>(x + 2);
        Square<2> dP = A * P + P * A.transpose();
        dP(1, 1) += process_psd;
        pack<2>(dP, dx + 2);
    }
    void before_flow(State&, const Event&) const {}

    void jump(State& s, const Event& event) const {
        if (event.has(angle)) {
            Square<2> P = unpack<2>(s.x + 2);
            const Eigen::Vector2d K = P.col(0) / (P(0, 0) + angle_variance);
            const double nu = event.value[angle][0] - s.x[0];
            s.x[0] += K[0] * nu;
            s.x[1] += K[1] * nu;
            P -= (K * P.row(0)).eval();
            pack<2>(P, s.x + 2);
        }
        if (event.has(torque)) s.held_torque = event.value[torque][0];
        s.jumps += 1;
    }

    void nominal(double* x) const {
        for (int i = 0; i < nx; ++i) x[i] = i < 2 ? 1 : 0.1;
    }
};

} // namespace hnav::test
