// A linear system whose measurements have coloured errors, and the conditions for filtering it.
//
//   x(k) = A x(k-1) + B u(k-1) + G w(k-1)         w ~ (0, Qw)
//   z(k) = H x(k) + v(k) + lambda(k)              v ~ (0, Qv)
//   lambda(k) = An lambda(k-1) + Bn U(k-1)        U ~ (0, QU),  lambda(0) ~ (0, Lambda0)
//
//   C. Hajiyev, R. Hacizade, A Covariance Matching-Based Adaptive Measurement Differencing Kalman Filter for INS's Error
//   Compensation, WSEAS Trans. Systems and Control 18, 2023 ("the paper").
#pragma once

#include "base/hash.hpp"
#include "base/refusal.hpp"
#include "maths/discretise.hpp"
#include "maths/matrix_arena.hpp"

#include <cstdint>

namespace hnav {

// As given by the caller: row-major, null where a default applies.
struct ModelData {
    int nx, nu, nz, nw, nl;
    double interval_s; // above 0: A, B, Qw, An, QU belong to differential equations
    const double *A, *B, *G, *H, *An, *Bn, *Qw, *Qv, *QU, *Lambda0, *x0, *P0;
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
    const bool coloured; // false without An: no lambda

    Matrix A, B, H, An;
    Matrix Q;  // G Qw G'
    Matrix Ql; // Bn QU Bn'
    Matrix Qv, Lambda0, P0;
    Vector x0;
    bool Qv_is_diagonal = true;
    double separability = 1;     // see below; the smallest over the modes of A
    char warning[256] = "";

    static bool sizes_fit(const ModelData& m, Refusal& why);

    // Checks everything before any change: after a refusal the model is unchanged.
    bool assign(const ModelData& m, Refusal& why);

    // Hash of the model, continued from start: equal models, equal fingerprint.
    std::uint64_t fingerprint(std::uint64_t start) const;

    template <class M>
    static bool is_diagonal(const M& matrix) {
        for (int i = 0; i < matrix.rows(); ++i)
            for (int j = 0; j < matrix.cols(); ++j)
                if (i != j && matrix(i, j) != 0) return false;
        return true;
    }

private:
    bool sizes_stay(const ModelData& m, Refusal& why) const;

    bool matrices_are_possible(const ModelData& m, Refusal& why) const;

    bool matrices_of_x_are_possible(const ModelData& m, Refusal& why) const;

    bool matrices_of_lambda_are_possible(const ModelData& m, Refusal& why) const;

    // Numbers of noises: a G or Bn that is not given is the identity.
    int nw_of(const ModelData& m) const { return m.G ? m.nw : nx; }
    int nl_of(const ModelData& m) const { return m.Bn ? m.nl : nz; }

    // The state and the coloured error over one step.
    bool discretise_both(const ModelData& m, Discrete* x, Discrete* lambda, Refusal& why) const;

    // The covariance of lambda(0): the given or the stationary one. Zero without colour.
    bool start_of_lambda(const ModelData& m, const Discrete& lambda, Small* start, Refusal& why) const;

    // A mode a of A is not separable from lambda when H a has the dynamics of lambda: (An - mu I) H a = Hd a = 0, with
    // Hd = H A - An H. If such a mode does not decay, the covariance grows without bound (Popov-Belevitch-Hautus).
    bool detectable(const Small& F, const Small& Hs, const Small& Ns, Refusal& why) const;

    // For a mode a of A with eigenvalue mu, |(mu - An) H a| / (|(1 - mu) H a| + |(1 - An) H a|): 0 when the mode moves
    // the measurements just as lambda does, so that they separate by the start values alone; 1 when it is far from that.
    // In units of sigma(lambda), which makes the channels comparable; a channel without colour observes the mode directly.
    void judge_separability();
};

} // namespace hnav
