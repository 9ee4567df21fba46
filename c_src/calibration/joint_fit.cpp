#include "calibration/joint_fit.hpp"

#include "calibration/joint_equations.hpp"

namespace hnav {
namespace {

constexpr int passes = 50;        // a few suffice once the weights have converged
constexpr double settled = 1e-12; // step in units of the field strength

double cost(const Samples& s) {
    const Values length = s.residual(), angle = s.angle(), weight = s.weight(), angle_weight = s.angle_weight();
    double sum = 0;
    for (Index i = 0; i < s.count; ++i) sum += weight[i] * square(length[i]) + angle_weight[i] * square(angle[i]);
    return sum;
}

} // namespace

void refine(double outlier_sigma, bool with_force, Samples& s, Correction* c) {
    Values length = s.residual(), angle = s.angle();
    double damping = 1e-6;
    for (int pass = 0; pass < passes; ++pass) {
        residuals(s, *c, with_force, length, angle);
        weigh(outlier_sigma, with_force, s);
        const double before = cost(s);
        Matrix13 JtJ = Matrix13::Zero();
        Vector13 Jtr = Vector13::Zero();
        accumulate(s, *c, 0, s.count, JtJ, Jtr);
        fill_upper(JtJ);

        bool better = false;
        Vector13 step = Vector13::Zero();
        for (int attempt = 0; attempt < 8 && !better; ++attempt) {
            Matrix13 damped = JtJ;
            // The second term damps unknowns that no equation determines.
            damped.diagonal() += damping * (JtJ.diagonal() + Vector13::Constant(1e-6 * JtJ.trace()));
            step = -solve_symmetric(damped, Jtr);
            const Correction next = moved(*c, step);
            residuals(s, next, with_force, length, angle);
            better = cost(s) <= before;
            if (better) *c = next;
            damping = better ? std::fmax(damping / 10, 1e-12) : damping * 10;
        }
        if (!better || step.norm() < settled) break;
    }
}

} // namespace hnav
