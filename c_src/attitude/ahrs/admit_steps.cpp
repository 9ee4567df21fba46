// Steps of the gyro bias: how the error responds to them, and what follows when one is likely (bias_steps.hpp).
#include "attitude/ahrs/model.hpp"

namespace hnav {

// Over the time since the last correction, as propagate does with the columns of P.
void AhrsModel::carry_response(State& s) const {
    const Eigen::Map<const Matrix3R> G(s.x + 4);
    Eigen::Map<StepResponse> response(s.steps.response);
    Eigen::Map<Response<2>> of_velocity(s.steps.velocity_response);
    const Response<3> before = response.topRows<3>();
    const Response<3> after = before - G.lazyProduct(response.middleRows<3>(bias - rotation));
    const R half = R(0.5 * gravity_m_s2) * s.force_s;
    of_velocity.row(0) -= half * (before.row(1) + after.row(1));
    of_velocity.row(1) += half * (before.row(0) + after.row(0));
    response.topRows<3>() = after;
}

// A likely step is added to the estimate, its covariance to P, and what the estimate moves by as well: errors of motion and of the fields along a
// street are not white, so no ratio of likelihoods excludes that there was none, and what follows decides. Without it the heading of a simulated
// van jumps by 20 deg and is ready, and after a step of 0.7 deg/s aircraft are ready and wrong for 1.6 % of the time instead of 0.4.
void AhrsModel::admit_steps(State& s, Correction& c) const {
    if (s.lost) return;
    if (s.steps.look(s.x[13], s.rate_power)) {
        const auto found = s.steps.with_step();
        Eigen::Matrix<R, errors, 3> by_step = Eigen::Matrix<R, errors, 3>::Zero();
        by_step.topRows<2>() = c.velocity_response.leftCols<3>();
        by_step.bottomRows<responding>() = c.response.leftCols<3>();
        const Eigen::Matrix<R, errors, 3> spread = by_step * found.covariance().topLeftCorner<3, 3>();
        const Vector moved = by_step * found.mean().head<3>();
        constexpr R even = R(0.5); // probability that there was none; chosen: with 0.25 and 1 vans are as rarely wrong
        c.error += moved;
        for (int j = 0; j < errors; ++j)
            for (int i = 0; i <= j; ++i) c.P(i, j) += spread.row(i).dot(by_step.row(j)) + even * moved[i] * moved[j];
    } else if (!s.steps.is_over()) {
        return;
    }
    begin_steps(s);
}

} // namespace hnav
