#include "ins_error/linear_model.hpp"

#include "maths/modes.hpp"

#include <cmath>
#include <cstdio>

namespace hnav {
namespace {

Small given(const double* values, int rows, int columns) {
    Small m(rows, columns);
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < columns; ++j) m(i, j) = values[i * columns + j];
    return m;
}

// G Qw G'; the identity stands for a G that is not given.
Small noise(const double* G, const double* Qw, int n, int nw) {
    const Small W = given(Qw, nw, nw);
    if (!G) return 0.5 * (W + W.transpose());
    const Small M = given(G, n, nw);
    const Small S = M * W * M.transpose();
    return 0.5 * (S + S.transpose());
}

bool numbers(const char* name, const double* values, int rows, int columns, Refusal& why) {
    if (!values) return why.refuse(Refusal::null, "%s is null", name);
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < columns; ++j)
            if (!std::isfinite(values[i * columns + j]))
                return rows == 1 ? why.refuse(Refusal::non_finite, "%s[%d] = %g is not finite", name, j, values[j])
                                 : why.refuse(Refusal::non_finite, "%s[%d][%d] = %g is not finite", name, i, j,
                                              values[i * columns + j]);
    return true;
}

// Tested as a correlation matrix: a velocity in m/s beside an angle in rad must not mask the angle's error.
bool covariance(const char* name, const double* values, int n, Refusal& why) {
    if (!numbers(name, values, n, n, why)) return false;
    const Small S = given(values, n, n);
    Small correlation = Small::Identity(n, n);
    for (int i = 0; i < n; ++i)
        if (S(i, i) < 0)
            return why.refuse(Refusal::impossible, "%s is not positive semidefinite: %s[%d][%d] = %g", name, name, i, i, S(i, i));
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const double scale = std::sqrt(S(i, i)) * std::sqrt(S(j, j));
            if (std::fabs(S(i, j) - S(j, i)) > 1e-9 * scale)
                return why.refuse(Refusal::impossible, "%s is not symmetric: %s[%d][%d] = %g and %s[%d][%d] = %g", name, name, i,
                                  j, S(i, j), name, j, i, S(j, i));
            if (i == j) continue;
            if (std::fabs(S(i, j)) > (1 + 1e-9) * scale)
                return why.refuse(Refusal::impossible, "%s is not positive semidefinite: %s[%d][%d] = %g exceeds the variances",
                                  name, name, i, j, S(i, j));
            correlation(i, j) = scale > 0 ? S(i, j) / scale : 0;
        }
    const double smallest = symmetric_eigenvalues(correlation, nullptr)[0];
    return smallest >= -1e-9 ||
           why.refuse(Refusal::impossible, "%s is not positive semidefinite: an eigenvalue of its correlations is %g", name,
                      smallest);
}

double spectral_radius(const Small& M) { return eigenvalues(M).cwiseAbs().maxCoeff(); }

// Solves L = M L M' + W by doubling: after i iterations the sum has 2^i terms.
Small stationary(Small M, const Small& W) {
    Small L = W;
    for (int turn = 0; turn < 64 && M.cwiseAbs().maxCoeff() > 1e-30; ++turn) {
        const Small more = M * L * M.transpose();
        L += more;
        const Small squared = M * M;
        M = squared;
    }
    return 0.5 * (L + L.transpose());
}

} // namespace

bool LinearModel::sizes_fit(const ModelData& m, Refusal& why) {
    const auto inside = [&](const char* name, int n, int min) {
        return (n >= min && n <= max_dimension) ||
               why.refuse(Refusal::size, "%s = %d: it must be in [%d, %d]", name, n, min, max_dimension);
    };
    if (!inside("nx", m.nx, 1) || !inside("nu", m.nu, 0) || !inside("nz", m.nz, 1)) return false;
    if (m.G ? !inside("nw", m.nw, 1) : m.nw != 0 && m.nw != m.nx)
        return m.G ? false
                   : why.refuse(Refusal::size, "nw = %d without G: it must be nx = %d (G is the identity), or 0", m.nw, m.nx);
    if (!m.An) return true;
    if (m.Bn ? !inside("nl", m.nl, 1) : m.nl != 0 && m.nl != m.nz)
        return m.Bn ? false
                    : why.refuse(Refusal::size, "nl = %d without Bn: it must be nz = %d (Bn is the identity), or 0", m.nl, m.nz);
    return true;
}

bool LinearModel::assign(const ModelData& m, Refusal& why) {
    if (!sizes_fit(m, why) || !sizes_stay(m, why) || !matrices_are_possible(m, why)) return false;
    Discrete x, lambda;
    if (!discretise_both(m, &x, &lambda, why)) return false;
    const Small Hs = given(m.H, nz, nx);
    Small start = Small::Zero(nz, nz);
    if (!start_of_lambda(m, lambda, &start, why) || !detectable(x.A, Hs, lambda.A, why)) return false;

    A = x.A;
    B = x.B;
    Q = x.Q;
    H = Hs;
    An = lambda.A;
    Ql = lambda.Q;
    Lambda0 = start;
    Qv = given(m.Qv, nz, nz);
    P0 = given(m.P0, nx, nx);
    x0.setZero();
    if (m.x0)
        for (int i = 0; i < nx; ++i) x0[i] = m.x0[i];
    Qv_is_diagonal = is_diagonal(Qv);
    judge_separability();
    return true;
}

std::uint64_t LinearModel::fingerprint(std::uint64_t start) const {
    for (const Matrix* part : {&A, &B, &H, &An, &Q, &Ql, &Qv, &Lambda0, &P0})
        start = hash(part->data(), part->size() * sizeof(double), start);
    return hash(x0.data(), x0.size() * sizeof(double), start);
}

bool LinearModel::sizes_stay(const ModelData& m, Refusal& why) const {
    const bool has_An = m.An != nullptr;
    if (m.nx == nx && m.nu == nu && m.nz == nz && has_An == coloured) return true;
    return why.refuse(Refusal::size, "the sizes are nx = %d, nu = %d, nz = %d, %s An: those of create were %d, %d, %d, %s", m.nx,
                      m.nu, m.nz, has_An ? "with" : "without", nx, nu, nz, coloured ? "with" : "without");
}

bool LinearModel::matrices_are_possible(const ModelData& m, Refusal& why) const {
    if (!std::isfinite(m.interval_s) || m.interval_s < 0)
        return why.refuse(Refusal::impossible, "interval_s = %g: it must be 0 (discrete matrices) or above", m.interval_s);
    return matrices_of_x_are_possible(m, why) && (!coloured || matrices_of_lambda_are_possible(m, why));
}

bool LinearModel::matrices_of_x_are_possible(const ModelData& m, Refusal& why) const {
    return numbers("A", m.A, nx, nx, why) && (nu == 0 || numbers("B", m.B, nx, nu, why)) && numbers("H", m.H, nz, nx, why) &&
           (!m.G || numbers("G", m.G, nx, m.nw, why)) && covariance("Qw", m.Qw, nw_of(m), why) &&
           covariance("Qv", m.Qv, nz, why) && covariance("P0", m.P0, nx, why) && (!m.x0 || numbers("x0", m.x0, 1, nx, why));
}

bool LinearModel::matrices_of_lambda_are_possible(const ModelData& m, Refusal& why) const {
    return numbers("An", m.An, nz, nz, why) && (!m.Bn || numbers("Bn", m.Bn, nz, m.nl, why)) &&
           covariance("QU", m.QU, nl_of(m), why) && (!m.Lambda0 || covariance("Lambda0", m.Lambda0, nz, why));
}

bool LinearModel::discretise_both(const ModelData& m, Discrete* x, Discrete* lambda, Refusal& why) const {
    *x = {given(m.A, nx, nx), given(m.B, nx, nu), noise(m.G, m.Qw, nx, nw_of(m))};
    *lambda = {Small::Zero(nz, nz), Small(nz, 0), Small::Zero(nz, nz)};
    if (coloured) *lambda = {given(m.An, nz, nz), Small(nz, 0), noise(m.Bn, m.QU, nz, nl_of(m))};
    if (m.interval_s > 0) {
        *x = discretise(x->A, x->B, x->Q, m.interval_s);
        if (coloured) *lambda = discretise(lambda->A, lambda->B, lambda->Q, m.interval_s);
    }
    if (!x->A.allFinite() || !x->B.allFinite() || !x->Q.allFinite())
        return why.refuse(Refusal::impossible, "A over interval_s = %g s is beyond what numbers hold", m.interval_s);
    if (!lambda->A.allFinite() || !lambda->Q.allFinite())
        return why.refuse(Refusal::impossible, "An over interval_s = %g s is beyond what numbers hold", m.interval_s);
    return true;
}

bool LinearModel::start_of_lambda(const ModelData& m, const Discrete& lambda, Small* start, Refusal& why) const {
    const double radius = spectral_radius(lambda.A);
    if (radius > 1 + 1e-9)
        return why.refuse(Refusal::impossible, "An is unstable: its spectral radius is %.6g, and coloured errors must not grow",
                          radius);
    if (!coloured) return true;
    if (m.Lambda0) {
        *start = given(m.Lambda0, nz, nz);
        return true;
    }
    if (radius > 1 - 1e-12)
        return why.refuse(Refusal::impossible,
                          "Lambda0 is null, and An of spectral radius 1 has no stationary covariance to stand for it");
    *start = stationary(lambda.A, lambda.Q);
    return true;
}

void LinearModel::judge_separability() {
    separability = 1;
    warning[0] = '\0';
    if (!coloured) return;
    const Small transition = A, colour = An, output = H;
    const Modes of_A = modes(transition);
    Complex worst = 0;
    for (int k = 0; k < nx; ++k) {
        const Complex mu = of_A.values[k];
        const ComplexVector shown = output.cast<Complex>() * of_A.vectors.col(k);
        const ComplexVector coloured_step = colour.cast<Complex>() * shown;
        double apart = 0, mode = 0, error = 0;
        bool plain = false;
        for (int i = 0; i < nz; ++i) {
            const double sigma = std::sqrt(Lambda0(i, i));
            plain = plain || (sigma == 0 && std::abs(shown[i]) > 1e-12);
            if (sigma == 0) continue;
            apart += std::norm((mu * shown[i] - coloured_step[i]) / sigma);
            mode += std::norm((1.0 - mu) * shown[i] / sigma);
            error += std::norm((shown[i] - coloured_step[i]) / sigma);
        }
        const double sum = std::sqrt(mode) + std::sqrt(error);
        if (plain || (sum == 0 && apart == 0 && shown.cwiseAbs().maxCoeff() == 0)) continue;
        const double value = sum > 0 ? std::sqrt(apart) / sum : 0;
        if (value >= separability) continue;
        separability = value;
        worst = mu;
    }
    if (separability < 0.1)
        std::snprintf(
            warning, sizeof warning,
            "states and coloured errors separate poorly (%.3g of 1): the mode of A with eigenvalue %.6g%+.3gi moves the "
            "measurements almost as An does",
            separability, worst.real(), worst.imag());
}

} // namespace hnav
