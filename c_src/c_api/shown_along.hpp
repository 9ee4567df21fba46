// Directional derivatives of a filter's outputs by its states.
//
// Attitude, rate, bias and covariance are polynomials of at most second degree in the states, except for the length of the
// quaternion, which is removed first. The difference between two states on both sides is therefore the exact derivative for any
// step, for large and small covariances.
#pragma once

#include "attitude/common/estimate.hpp"
#include "maths/rotation.hpp"

namespace hnav {

// In the model's own frames.
struct ShownAlong {
    Quaternion q = Quaternion::Zero();
    Vector3 rate = Vector3::Zero(), bias = Vector3::Zero(), bias_variance = Vector3::Zero();
    ErrorCovariance covariance = ErrorCovariance::Zero();
    Vector3 hold_error = Vector3::Zero(); // its square is omitted from the covariance: it is of fourth degree in the quaternion
};

// The outputs of one state; gamma and similar ones do not depend on it.
template <class Model, class State>
ShownAlong shown_in(const Model& model, const State& s) {
    const Estimate e = model.estimate(s);
    const Vector3 hold = model.hold_error(s).template cast<double>();
    ErrorCovariance covariance = model.error_covariance(s);
    covariance.topLeftCorner<3, 3>() -= hold * hold.transpose();
    return {e.q_bn, e.rate_b, e.bias_b, model.bias_variances(s), covariance, hold};
}

// Adds factor times the difference of two states; turned: factors of the terms of first and second degree in the quaternion.
inline void add_difference(const ShownAlong& plus, const ShownAlong& minus, double first, double second, ShownAlong* sum) {
    sum->q += first * (plus.q - minus.q);
    sum->rate += first * (plus.rate - minus.rate);
    sum->bias += first * (plus.bias - minus.bias);
    sum->bias_variance += first * (plus.bias_variance - minus.bias_variance);
    ErrorCovariance d = first * (plus.covariance - minus.covariance);
    d.topLeftCorner<3, 3>() *= second / first;
    sum->covariance += d;
    sum->hold_error += second * (plus.hold_error - minus.hold_error);
}

// At the state s, whose first four numbers are the quaternion; nx: the number of states.
template <class Model, class State>
ShownAlong shown_along(const Model& model, const State& s, const double* seed, int nx) {
    ShownAlong along;
    State plus = s, minus = s;
    const Quaternion q = Quaternion(s.x).normalized();
    Quaternion turn = Quaternion(seed) / Quaternion(s.x).norm();
    turn -= q * q.dot(turn); // only the direction of the quaternion is shown
    if (const double size = turn.norm(); size > 0) {
        // Both have the length sqrt(2), which the model removes: its products of two components are halves.
        const Quaternion to = turn / size;
        Eigen::Map<Quaternion>(plus.x) = q + to;
        Eigen::Map<Quaternion>(minus.x) = q - to;
        add_difference(shown_in(model, plus), shown_in(model, minus), std::sqrt(0.5) * size, size, &along);
        plus = minus = s;
    }
    double largest = 0;
    for (int i = 4; i < nx; ++i) largest = std::fmax(largest, std::fabs(seed[i]));
    if (largest > 0) {
        for (int i = 4; i < nx; ++i) {
            plus.x[i] += seed[i] / largest;
            minus.x[i] -= seed[i] / largest;
        }
        add_difference(shown_in(model, plus), shown_in(model, minus), 0.5 * largest, 0.5 * largest, &along);
    }
    const Vector3 hold = model.hold_error(s).template cast<double>();
    along.covariance.topLeftCorner<3, 3>() += along.hold_error * hold.transpose() + hold * along.hold_error.transpose();
    return along;
}

} // namespace hnav
