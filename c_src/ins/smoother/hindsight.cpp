#include "ins/smoother/hindsight.hpp"

#include <algorithm>

namespace hnav::ins {
namespace {

// P = D L L' D over its used rows, D the sigmas.
struct Factors {
    int n;
    double inverse_sigma[errors], L[errors][errors];
    bool positive = true;

    explicit Factors(const Covariance& P) : n(P.n) {
        for (int i = 0; i < n; ++i) inverse_sigma[i] = P[i][i] > 0 ? 1 / std::sqrt(P[i][i]) : 0;
        for (int i = 0; i < n; ++i)
            for (int j = 0; j <= i; ++j) {
                double sum = i == j ? 1 : P[i][j] * inverse_sigma[i] * inverse_sigma[j];
                for (int k = 0; k < j; ++k) sum -= L[i][k] * L[j][k];
                positive = positive && (i != j || sum > 1e-14);
                L[i][j] = i == j ? std::sqrt(sum) : sum / L[j][j];
            }
    }

    // W becomes P^-1 W.
    void solve(Covariance& W) const {
        scale(W);
        for (int i = 0; i < n; ++i) {
            for (int k = 0; k < i; ++k) take(L[i][k], W[k], W[i]);
            for (int j = 0; j < n; ++j) W[i][j] /= L[i][i];
        }
        for (int i = n; i-- > 0;) {
            for (int k = i + 1; k < n; ++k) take(L[k][i], W[k], W[i]);
            for (int j = 0; j < n; ++j) W[i][j] /= L[i][i];
        }
        scale(W);
    }

private:
    void scale(Covariance& W) const {
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) W[i][j] *= inverse_sigma[i];
    }
    void take(double share, const double* of, double* from) const {
        for (int j = 0; j < n; ++j) from[j] -= share * of[j];
    }
};

// Phi P.
Covariance carried(const Step& step, const Covariance& P) {
    const int n = P.n;
    Covariance W = P;
    for (int i = 0; i < moved; ++i) {
        for (int j = 0; j < n; ++j) W[i][j] = 0;
        for (int k = 0; k < movers; ++k) {
            const double m = step.transition.M[i][k];
            if (m == 0) continue;
            for (int j = 0; j < n; ++j) W[i][j] += m * P[k][j];
        }
    }
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) W[i][j] *= step.kept[i];
    return W;
}

} // namespace

// P + X' (S - B) X and X' e with X = B^-1 Phi P. P: filtered before the step; B: predicted; S, e: smoothed after it (Rauch, Tung,
// Striebel 1965).
bool step_back(const Step& step, const Hindsight& after, Hindsight* now) {
    const int n = step.before.n;
    now->P.extend(n); // before the first sample of a magnetometer
    Covariance X = carried(step, now->P), D{}, DX{};
    const int common = std::min(n, after.P.n);
    const Factors before(step.before);
    if (!before.positive) return false;
    before.solve(X);
    for (int i = 0; i < n; ++i) {
        now->error[i] = 0;
        for (int j = 0; j < common && i < common; ++j) D[i][j] = after.P[i][j] - step.before[i][j];
    }
    for (int i = 0; i < n; ++i)
        for (int k = 0; k < n; ++k) {
            now->error[i] += X[k][i] * after.error[k];
            for (int j = 0; j < n; ++j) DX[i][j] += D[i][k] * X[k][j];
        }
    for (int k = 0; k < n; ++k)
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) now->P[i][j] += X[k][i] * DX[k][j];
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < i; ++j) now->P[i][j] = now->P[j][i] = 0.5 * (now->P[i][j] + now->P[j][i]);
    // Sigmas that an inconsistency showed to be too small were so before it. Of the error itself only the part that the sigma then
    // explained is carried back: whole it put the positions of an aircraft with late fixes 200 m off.
    for (int i = 0; i < n; ++i) now->P.scale(i, step.larger[i]);
    return true;
}

namespace {

// Vectors of errors, and their covariance, in axes turned by C.
void turn(const Matrix3& C, Hindsight& h) {
    for (const int row : {row_d, row_v, row_phi, row_colour}) vec(h.error + row) = Vector3(C * vec(h.error + row));
    turn(h.P, C);
}

// The same state in other axes.
void place_in(const State& axes, State& s) {
    const Matrix3 C = mat(axes.axes).transpose() * mat(s.axes);
    const Vector3 e = vec(s.anchor_e) - vec(axes.anchor_e);
    turn(s, C);
    vec(s.x) += mat(axes.axes).transpose() * e;
}

// Error to - from, in the axes of `from`. 0 for the pressure offset if one of them has none yet, and for fields of different units.
void difference(const State& to, const State& from, double* error) {
    State s = to;
    place_in(from, s);
    vec(error + row_d) = vec(s.x) - vec(from.x);
    vec(error + row_v) = vec(s.x + 3) - vec(from.x + 3);
    vec(error + row_phi) = rotation_vector(multiply(quat(s.x + 6), conjugate(quat(from.x + 6))));
    each_parameter(s, [error](int row, const double* value, int count) { std::copy_n(value, count, error + row); });
    each_parameter(from, [error](int row, const double* value, int count) {
        for (int i = 0; i < count; ++i) error[row + i] -= value[i];
    });
    error[row_u] = error[row_u + 1] = 0;
    if (!std::isfinite(error[row_offset])) error[row_offset] = 0;
    if (s.field_unit != from.field_unit) std::fill(error + row_iron, error + errors, 0.0);
}

} // namespace

Hindsight seen_from(const State& state, const Target& target) {
    Hindsight h{{}, target.P};
    turn(mat(state.axes).transpose() * mat(target.state.axes), h);
    difference(target.state, state, h.error);
    return h;
}

bool is_of_use(const State& filtered, const Hindsight& h) {
    constexpr double most_sigmas = 10; // of the filter: chosen
    for (int i = 0; i < moved; ++i) {
        const double off2 = i < row_v ? square(h.error[i]) : 0; // the displacement is what fixes observe
        if (!(std::fmax(h.P[i][i], off2) <= square(most_sigmas) * filtered.P[packed(i, i)])) return false;
    }
    return true;
}

bool is_expected(const State& filtered, const Hindsight& h, int row, int rows) {
    constexpr double most_sigmas = 3;
    for (int i = row; i < row + rows; ++i)
        if (!(square(h.error[i]) <= square(most_sigmas) * filtered.P[packed(i, i)])) return false;
    return true;
}

Hindsight before_samples(const Step& step, Hindsight h, const State& after) {
    turn(mat(step.axes).transpose() * mat(after.axes), h);
    add_errors(step.change, h.error, h.error);
    return h;
}

} // namespace hnav::ins
