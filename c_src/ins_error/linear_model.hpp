// A linear system whose measurements carry coloured errors, and what makes one impossible to filter.
//
//   x(k) = A x(k-1) + B u(k-1) + G w(k-1)         w ~ (0, Qw)
//   z(k) = H x(k) + v(k) + lambda(k)              v ~ (0, Qv)
//   lambda(k) = An lambda(k-1) + Bn U(k-1)        U ~ (0, QU),  lambda(0) ~ (0, Lambda0)
//
//   C. Hajiyev, R. Hacizade, A Covariance Matching-Based Adaptive Measurement Differencing Kalman Filter for INS's Error
//   Compensation, WSEAS Trans. Systems and Control 18, 2023 ("the paper").
#pragma once

#include "base/hash.hpp"
#include "maths/discretise.hpp"
#include "maths/matrix_arena.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>

#include <cmath>
#include <complex>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstring>

namespace hnav {

// As the caller gives it: row-major, null where a default stands for it.
struct ModelData {
    int nx, nu, nz, nw, nl;
    double interval_s; // above 0: A, B, Qw, An, QU belong to differential equations
    const double *A, *B, *G, *H, *An, *Bn, *Qw, *Qv, *QU, *Lambda0, *x0, *P0;
};

struct Refusal {
    enum Kind { none, null, size, non_finite, impossible } kind = none;
    char text[256] = "";

    __attribute__((format(printf, 3, 4))) bool refuse(Kind k, const char* format, ...) {
        kind = k;
        va_list arguments;
        va_start(arguments, format);
        std::vsnprintf(text, sizeof text, format, arguments);
        va_end(arguments);
        return false;
    }
};

class LinearModel {
public:
    LinearModel(MatrixArena& arena, const ModelData& m)
        : nx(m.nx),
          nu(m.nu),
          nz(m.nz),
          coloured(m.An != nullptr),
          A(arena.matrix(nx, nx)),
          B(arena.matrix(nx, nu)),
          H(arena.matrix(nz, nx)),
          An(arena.matrix(nz, nz)),
          Q(arena.matrix(nx, nx)),
          Ql(arena.matrix(nz, nz)),
          Qv(arena.matrix(nz, nz)),
          Lambda0(arena.matrix(nz, nz)),
          P0(arena.matrix(nx, nx)),
          x0(arena.vector(nx)) {}

    const int nx, nu, nz;
    const bool coloured; // without An there is no lambda at all

    Matrix A, B, H, An;
    Matrix Q;  // G Qw G'
    Matrix Ql; // Bn QU Bn'
    Matrix Qv, Lambda0, P0;
    Vector x0;
    bool Qv_is_diagonal = true;
    double separability = 1;     // see below; the smallest over the modes of A
    char warning[256] = "";

    static bool sizes_fit(const ModelData& m, Refusal& why) {
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
                        : why.refuse(Refusal::size, "nl = %d without Bn: it must be nz = %d (Bn is the identity), or 0", m.nl,
                                     m.nz);
        return true;
    }

    // Checks the whole before it touches anything: after a refusal the model is as it was.
    bool assign(const ModelData& m, Refusal& why) {
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

    // Over what the filter will use, going on from start: equal models, equal fingerprint.
    std::uint64_t fingerprint(std::uint64_t start) const {
        for (const Matrix* part : {&A, &B, &H, &An, &Q, &Ql, &Qv, &Lambda0, &P0})
            start = hash(part->data(), part->size() * sizeof(double), start);
        return hash(x0.data(), x0.size() * sizeof(double), start);
    }

    template <class M>
    static bool is_diagonal(const M& matrix) {
        for (int i = 0; i < matrix.rows(); ++i)
            for (int j = 0; j < matrix.cols(); ++j)
                if (i != j && matrix(i, j) != 0) return false;
        return true;
    }

private:
    using Complex = std::complex<double>;

    bool sizes_stay(const ModelData& m, Refusal& why) const {
        const bool has_An = m.An != nullptr;
        if (m.nx == nx && m.nu == nu && m.nz == nz && has_An == coloured) return true;
        return why.refuse(Refusal::size, "the sizes are nx = %d, nu = %d, nz = %d, %s An: those of create were %d, %d, %d, %s",
                          m.nx, m.nu, m.nz, has_An ? "with" : "without", nx, nu, nz, coloured ? "with" : "without");
    }

    bool matrices_are_possible(const ModelData& m, Refusal& why) const {
        if (!std::isfinite(m.interval_s) || m.interval_s < 0)
            return why.refuse(Refusal::impossible, "interval_s = %g: it must be 0 (discrete matrices) or above", m.interval_s);
        return matrices_of_x_are_possible(m, why) && (!coloured || matrices_of_lambda_are_possible(m, why));
    }

    bool matrices_of_x_are_possible(const ModelData& m, Refusal& why) const {
        return numbers("A", m.A, nx, nx, why) && (nu == 0 || numbers("B", m.B, nx, nu, why)) && numbers("H", m.H, nz, nx, why) &&
               (!m.G || numbers("G", m.G, nx, m.nw, why)) && covariance("Qw", m.Qw, nw_of(m), why) &&
               covariance("Qv", m.Qv, nz, why) && covariance("P0", m.P0, nx, why) && (!m.x0 || numbers("x0", m.x0, 1, nx, why));
    }

    bool matrices_of_lambda_are_possible(const ModelData& m, Refusal& why) const {
        return numbers("An", m.An, nz, nz, why) && (!m.Bn || numbers("Bn", m.Bn, nz, m.nl, why)) &&
               covariance("QU", m.QU, nl_of(m), why) && (!m.Lambda0 || covariance("Lambda0", m.Lambda0, nz, why));
    }

    // Of the noises: an identity stands for a G or Bn that is not given.
    int nw_of(const ModelData& m) const { return m.G ? m.nw : nx; }
    int nl_of(const ModelData& m) const { return m.Bn ? m.nl : nz; }

    // The state and the coloured error over one step.
    bool discretise_both(const ModelData& m, Discrete* x, Discrete* lambda, Refusal& why) const {
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

    // The covariance of lambda(0): what is given, else the stationary one. Zero without colour.
    bool start_of_lambda(const ModelData& m, const Discrete& lambda, Small* start, Refusal& why) const {
        const double radius = spectral_radius(lambda.A);
        if (radius > 1 + 1e-9)
            return why.refuse(Refusal::impossible,
                              "An is unstable: its spectral radius is %.6g, and coloured errors must not grow", radius);
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

    static Small given(const double* values, int rows, int columns) {
        Small m(rows, columns);
        for (int i = 0; i < rows; ++i)
            for (int j = 0; j < columns; ++j) m(i, j) = values[i * columns + j];
        return m;
    }

    // G Qw G'; the identity stands for a G that is not given.
    static Small noise(const double* G, const double* Qw, int n, int nw) {
        const Small W = given(Qw, nw, nw);
        if (!G) return 0.5 * (W + W.transpose());
        const Small M = given(G, n, nw);
        const Small S = M * W * M.transpose();
        return 0.5 * (S + S.transpose());
    }

    static bool numbers(const char* name, const double* values, int rows, int columns, Refusal& why) {
        if (!values) return why.refuse(Refusal::null, "%s is null", name);
        for (int i = 0; i < rows; ++i)
            for (int j = 0; j < columns; ++j)
                if (!std::isfinite(values[i * columns + j]))
                    return rows == 1 ? why.refuse(Refusal::non_finite, "%s[%d] = %g is not finite", name, j, values[j])
                                     : why.refuse(Refusal::non_finite, "%s[%d][%d] = %g is not finite", name, i, j,
                                                  values[i * columns + j]);
        return true;
    }

    // Judged as a correlation matrix: a velocity in m/s beside an angle in rad must not hide the angle's error.
    static bool covariance(const char* name, const double* values, int n, Refusal& why) {
        if (!numbers(name, values, n, n, why)) return false;
        const Small S = given(values, n, n);
        Small correlation = Small::Identity(n, n);
        for (int i = 0; i < n; ++i)
            if (S(i, i) < 0)
                return why.refuse(Refusal::impossible, "%s is not positive semidefinite: %s[%d][%d] = %g", name, name, i, i,
                                  S(i, i));
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) {
                const double scale = std::sqrt(S(i, i)) * std::sqrt(S(j, j));
                if (std::fabs(S(i, j) - S(j, i)) > 1e-9 * scale)
                    return why.refuse(Refusal::impossible, "%s is not symmetric: %s[%d][%d] = %g and %s[%d][%d] = %g", name, name,
                                      i, j, S(i, j), name, j, i, S(j, i));
                if (i == j) continue;
                if (std::fabs(S(i, j)) > (1 + 1e-9) * scale)
                    return why.refuse(Refusal::impossible,
                                      "%s is not positive semidefinite: %s[%d][%d] = %g exceeds the variances", name, name, i, j,
                                      S(i, j));
                correlation(i, j) = scale > 0 ? S(i, j) / scale : 0;
            }
        const Eigen::SelfAdjointEigenSolver<Small> eigen(correlation, Eigen::EigenvaluesOnly);
        const double smallest = eigen.eigenvalues()[0]; // in increasing order
        return smallest >= -1e-9 ||
               why.refuse(Refusal::impossible, "%s is not positive semidefinite: an eigenvalue of its correlations is %g", name,
                          smallest);
    }

    static double spectral_radius(const Small& M) {
        return Eigen::EigenSolver<Small>(M, false).eigenvalues().cwiseAbs().maxCoeff();
    }

    // Solves L = M L M' + W by doubling: after i turns the sum has 2^i terms.
    static Small stationary(Small M, const Small& W) {
        Small L = W;
        for (int turn = 0; turn < 64 && M.cwiseAbs().maxCoeff() > 1e-30; ++turn) {
            const Small more = M * L * M.transpose();
            L += more;
            const Small squared = M * M;
            M = squared;
        }
        return 0.5 * (L + L.transpose());
    }

    // A mode a of A hides behind lambda when H a behaves as lambda does: (An - mu I) H a = Hd a = 0, with
    // Hd = H A - An H. One that does not decay either lets the covariance grow without bound (Popov-Belevitch-Hautus).
    bool detectable(const Small& F, const Small& Hs, const Small& Ns, Refusal& why) const {
        using ComplexMatrix = Eigen::Matrix<Complex, Eigen::Dynamic, Eigen::Dynamic, 0, 2 * max_dimension, max_dimension>;
        Small seen = Hs;
        if (coloured) seen = Hs * F - Ns * Hs;
        const auto modes = Eigen::EigenSolver<Small>(F, false).eigenvalues().eval();
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

    // For a mode a of A with eigenvalue mu, |(mu - An) H a| / (|(1 - mu) H a| + |(1 - An) H a|): 0 when the mode moves
    // the measurements just as lambda does, so that they separate by the start values alone; 1 when it is far from that.
    // In units of sigma(lambda), which makes the channels comparable; a channel without colour shows the mode plainly.
    void judge_separability() {
        separability = 1;
        warning[0] = '\0';
        if (!coloured) return;
        using ComplexVector = Eigen::Matrix<Complex, Eigen::Dynamic, 1, 0, max_dimension, 1>;
        const Small transition = A, colour = An, output = H;
        const Eigen::EigenSolver<Small> modes(transition);
        Complex worst = 0;
        for (int k = 0; k < nx; ++k) {
            const Complex mu = modes.eigenvalues()[k];
            const ComplexVector shown = output.cast<Complex>() * modes.eigenvectors().col(k);
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
};

} // namespace hnav
