#include "observer/smoother.hpp"

#include "base/memory.hpp"

#include <algorithm>
#include <utility>

namespace hnav::observer {

Smoother::~Smoother() { release_block(block_); }

bool Smoother::take_memory() {
    const std::size_t square = static_cast<std::size_t>(N_) * N_;
    const std::size_t numbers = rows_ * (link_numbers() + 1) + 4 * static_cast<std::size_t>(N_) + 6 * square;
    block_ = take_block(numbers * sizeof(double));
    if (!block_) return false;
    auto* next = static_cast<double*>(block_);
    const auto take = [&](std::size_t count) {
        double* piece = next;
        next += count;
        std::fill_n(piece, count, 0.0);
        return piece;
    };
    X = take(N_);
    P = take(square);
    joint_ = {take(N_), take(square), take(N_), take(square), take(square)};
    before_ = take(N_);
    root_ = take(square);
    product_ = take(square);
    instant_of_row_ = take(rows_);
    links_ = next;
    return true;
}

// An instant that a second row corrects again replaces itself.
void Smoother::note(std::size_t row, const Model& model, const State& newest) {
    if (!model.flows(newest)) return;
    const double t_s = newest.x()[model.layout().t];
    const bool again = instants_ > 0 && t_s == t_s_;
    if (!again) {
        std::copy_n(joint_.X, N_, before_);
        t_s_ = t_s;
        ++instants_;
    }
    model.joint_moments(newest, joint_);
    if (instants_ > 1) keep_link();
    instant_of_row_[row] = static_cast<double>(instants_);
}

// b = X_before + moved - G X,  A = O - G C'
void Smoother::keep_link() {
    double *b = link(instants_ - 1), *A = b + N_, *G = A + Layout::triangle(N_);
    solve_gain(G);
    for (int i = 0; i < N_; ++i) {
        b[i] = before_[i] + joint_.moved[i];
        for (int j = 0; j < N_; ++j) b[i] -= G[i * N_ + j] * joint_.X[j];
        for (int j = i; j < N_; ++j) {
            double sum = joint_.origin_P[i * N_ + j];
            for (int k = 0; k < N_; ++k)
                sum -= 0.5 * (G[i * N_ + k] * joint_.C[j * N_ + k] + G[j * N_ + k] * joint_.C[i * N_ + k]);
            *A++ = i == j ? std::max(0.0, sum) : sum;
        }
    }
}

// G = C P^-1 by a Cholesky root of P, whose numbers without a variance of their own are left out.
void Smoother::solve_gain(double* G) {
    constexpr double singular = 1e-13; // of a variance
    const int N = N_;
    const double* L = root_;
    root_of(N, joint_.P, singular, root_);
    for (int r = 0; r < N; ++r) {
        double* g = G + r * N;
        for (int i = 0; i < N; ++i) {
            double sum = joint_.C[r * N + i];
            for (int k = 0; k < i; ++k) sum -= L[i * N + k] * g[k];
            g[i] = L[i * N + i] > 0 ? sum / L[i * N + i] : 0;
        }
        for (int i = N - 1; i >= 0; --i) {
            for (int k = i + 1; k < N; ++k) g[i] -= L[k * N + i] * g[k];
            g[i] = L[i * N + i] > 0 ? g[i] / L[i * N + i] : 0;
        }
    }
}

bool Smoother::go_back_to(std::size_t row) {
    const auto wanted = static_cast<std::size_t>(instant_of_row_[row]);
    if (wanted == 0) return false;
    if (at_ == 0) {
        at_ = instants_;
        std::copy_n(joint_.X, N_, X);
        std::copy_n(joint_.P, N_ * N_, P);
    }
    for (; at_ > wanted; --at_) {
        const double *b = link(at_ - 1), *A = b + N_, *G = A + Layout::triangle(N_);
        times_rows(G, N_, N_, X, before_);
        for (int i = 0; i < N_; ++i) X[i] = b[i] + before_[i];
        unpack_upper(A, N_, 1, root_);
        add_congruence(N_, G, P, product_, root_);
        std::swap(P, root_);
    }
    return true;
}

} // namespace hnav::observer
