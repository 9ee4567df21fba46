// Robust scale and weights for fits with outliers.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace hnav {

// Memory is the caller's: nothing here or in the fits allocates.
using Index = Eigen::Index;
using Columns = Eigen::Map<Eigen::Matrix<double, 3, Eigen::Dynamic>>; // one sample for each column
using Values = Eigen::Map<Eigen::VectorXd>;                           // one number for each sample

// Smallest scale of residuals, in units of the field strength, so that rounding in exact data is not
// taken for outliers.
constexpr double least_sigma = 1e-9;

// The value below which a share of the values lies. Reorders them; NaN when there are none.
inline double quantile(double* values, Index count, double share) {
    if (count == 0) return std::nan("");
    double* at = values + static_cast<Index>(share * static_cast<double>(count));
    std::nth_element(values, at, values + count);
    return *at;
}

inline double median(double* values, Index count) { return quantile(values, count, 0.5); }

// Standard deviation about zero from the median of |residual|, right for a normal distribution and indifferent to up to
// half of outliers (Huber and Ronchetti 2009, section 5.1). Where use is given, only residuals with use > 0 count.
inline double robust_sigma(const Values& residual, Values& scratch, const Values* use = nullptr) {
    Index count = 0;
    for (Index i = 0; i < residual.size(); ++i)
        if (!use || (*use)[i] > 0) scratch[count++] = std::fabs(residual[i]);
    return count ? std::fmax(1.4826 * median(scratch.data(), count), least_sigma) : 1;
}

// Weight of iteratively reweighted least squares for the loss of Geman and McClure: 1 at zero, 1/4 at the limit, and
// falling with the fourth power beyond, so that a gross outlier loses all influence.
inline double geman_mcclure(double residual, double limit) {
    const double x = residual / limit;
    const double root = 1 / (1 + x * x);
    return root * root;
}

} // namespace hnav
