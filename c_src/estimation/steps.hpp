// Whether parts of a state that are modelled as constant have stepped. B is the response of the estimate's error, corrections included, to a unit
// step of each part at the begin of a window. A step then changes an innovation by H B step, so the innovations contain a Gaussian likelihood of
// the steps with the information sum (H B)' S^-1 H B (Friedland 1969; generalised likelihood ratio, Willsky and Jones 1976). With a Gaussian
// prior of the steps the ratio of the likelihoods with and without steps has a closed form, and so has the posterior of the steps: adding it to
// the estimate gives that of a filter that had expected them at the begin of the window.
//
// Without a step the ratio has mean 1, so it exceeds exp(x / 2) at any time of a window with a probability of at most exp(-x / 2) (Ville).
#pragma once

#include "maths/cholesky.hpp"
#include "maths/square.hpp"

#include <cmath>

namespace hnav {

// Chosen: the errors by which a step shows grow for some seconds, and a long window hides the next one.
constexpr double steps_window_s = 20;

// Part of a filter's state: numbers of one kind only.
template <int count, class R = double>
struct StepEvidence {
    R information[count * count], sum[count]; // of (H B)' S^-1 H B, and of (H B)' S^-1 r
    R excess; // of r' S^-1 r over that of an outlier, of rejected samples

    // Of m rows: response is H B, weighted S^-1 H B.
    template <int m>
    void add(const Eigen::Matrix<R, m, count>& response, const Eigen::Matrix<R, m, count>& weighted,
             const Eigen::Matrix<R, m, 1>& innovation) {
        const Eigen::Matrix<R, count, m> columns = response.transpose(); // vectorised; 6 by 3 take a third of the instructions
        Eigen::Map<Square<count, R>>(information).noalias() += columns.lazyProduct(weighted);
        Eigen::Map<Eigen::Matrix<R, count, 1>>(sum).noalias() += weighted.transpose().lazyProduct(innovation);
    }
    void add(const StepEvidence& more) {
        for (int i = 0; i < count * count; ++i) information[i] += more.information[i];
        for (int i = 0; i < count; ++i) sum[i] += more.sum[i];
        excess += more.excess;
    }
};

template <int count, class R = double>
class Steps {
public:
    using Vector = Eigen::Matrix<R, count, 1>;

    // sigmas: of the prior of each part.
    Steps(const StepEvidence<count, R>& of, const R* sigmas) : sum_(of.sum), excess_(of.excess) {
        Square<count, R> posterior = Eigen::Map<const Square<count, R>>(of.information);
        for (int i = 0; i < count; ++i) {
            posterior(i, i) += 1 / square(sigmas[i]);
            priors_ *= square(sigmas[i]);
        }
        factor_ = Cholesky<count, R>(posterior);
    }
    // Twice the logarithm of the ratio of the likelihoods with steps, and with none but outliers instead.
    R twice_log_ratio() const { return factor_.quadratic_form(sum_) - R(std::log(factor_.determinant() * priors_)) - excess_; }
    Vector mean() const { return factor_.template solve<1>(sum_); }
    Square<count, R> covariance() const {
        return factor_.template solve<count>(typename Cholesky<count, R>::template Rows<count>(Square<count, R>::Identity()));
    }

private:
    Vector sum_;
    R excess_;
    Cholesky<count, R> factor_;
    double priors_ = 1; // product of their variances
};

} // namespace hnav
