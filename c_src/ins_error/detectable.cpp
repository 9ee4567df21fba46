#include "ins_error/linear_model.hpp"

#include "maths/modes.hpp"

#include <Eigen/QR>

#include <cmath>

namespace hnav {

bool LinearModel::detectable(const Small& F, const Small& Hs, const Small& Ns, Refusal& why) const {
    using ComplexMatrix = Eigen::Matrix<Complex, Eigen::Dynamic, Eigen::Dynamic, 0, 2 * max_dimension, max_dimension>;
    Small seen = Hs;
    if (coloured) seen = Hs * F - Ns * Hs;
    const ComplexVector modes = eigenvalues(F);
    for (int k = 0; k < nx; ++k) {
        const Complex mu = modes[k];
        if (std::abs(mu) < 1 - 1e-9) continue;
        ComplexMatrix M = ComplexMatrix::Zero(nx + nz, nx);
        M.topRows(nx) = -F.cast<Complex>();
        for (int i = 0; i < nx; ++i) M(i, i) += mu;
        M.bottomRows(nz) = seen.cast<Complex>();
        Eigen::ColPivHouseholderQR<ComplexMatrix> qr(M);
        qr.setThreshold(1e-9);
        if (qr.rank() == nx) continue;
        return why.refuse(
            Refusal::impossible,
            "A has an unstable mode that %s does not show (eigenvalue %.6g%+.3gi of the step): its variance would grow without bound",
            coloured ? "H beside An" : "H", mu.real(), mu.imag());
    }
    return true;
}

} // namespace hnav
