// Estimates of a recording with hindsight. For each instant k the filter has the joint moments of X at k - 1 and at k given the samples up
// to k (joint.cpp). With the gain G = C P^-1 the Rauch-Tung-Striebel recursion goes back from the last instant:
//
//     X_k-1|n = X_k-1|k + G (X_k|n - X_k|k)          P_k-1|n = P_k-1|k + G (P_k|n - P_k|k) G'
//
// The joint moments are those of the whole mixture, with its saltation matrices, cuts and points, so that one recursion serves all plants.
#pragma once

#include "observer/observer_model.hpp"

#include <cstddef>

namespace hnav::observer {

class Smoother {
public:
    using State = RuntimeState;

    ~Smoother();
    Smoother(int N, std::size_t rows) : N_(N), rows_(rows) {}
    Smoother(const Smoother&) = delete;
    Smoother& operator=(const Smoother&) = delete;

    // False: no memory. 8 (N + 1.5 N^2) bytes and 8 more for each row.
    bool take_memory();
    // After a row: the newest state, if the estimate has begun.
    void note(std::size_t row, const Model& model, const State& newest);

    // From the last row to the first; true: X (N) and P (N x N), untruncated, are those of this row. False: it was before the start.
    bool go_back_to(std::size_t row);
    double *X = nullptr, *P = nullptr;

private:
    double* link(std::size_t instant) const { return links_ + instant * link_numbers(); }
    std::size_t link_numbers() const { return N_ + Layout::triangle(N_) + N_ * N_; }
    void keep_link();
    void solve_gain(double* G);

    int N_;
    std::size_t rows_;
    void* block_ = nullptr;
    double* links_ = nullptr; // of each instant, back to the one before: b, A, G of X = b + G X_next, P = A + G P_next G'
    double* instant_of_row_ = nullptr; // from 1; 0: before the start
    std::size_t instants_ = 0, at_ = 0;
    double t_s_ = 0; // of the newest instant
    Model::Joint joint_{};
    double *before_ = nullptr, *root_ = nullptr, *product_ = nullptr; // X of the instant before; N x N, N x N
};

} // namespace hnav::observer
