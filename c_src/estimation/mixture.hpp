// A Gaussian mixture whose parts have a size known at run time: of each a weight, a mean of n numbers and a covariance, the upper
// triangle row by row. Flat loops; nothing allocates.
//
// Parts are whatever container has
//     int count() const
//     double& weight(int i)
//     void merge(int i, int j)                part j into part i by moments; j is gone, the others keep their order
//     void drop(int i)
//     double apart(int i, int j)              for collapse: the nearest merge first
//     bool alike(int i, int j)                for merge_alike
#pragma once

#include <algorithm>
#include <cmath>

namespace hnav::mixture {

// Mean X and covariance P of a part, and then of it with another, which has `share` of the weight of both.
inline void merge(int n, double share, double* X, double* P, const double* Y, const double* Q) {
    for (int i = 0; i < n; ++i)
        for (int j = i; j < n; ++j, ++P, ++Q) {
            const double apart = share * (1 - share) * (Y[i] - X[i]) * (Y[j] - X[j]);
            *P = (1 - share) * *P + share * *Q + apart;
        }
    for (int i = 0; i < n; ++i) X[i] += share * (Y[i] - X[i]);
}

struct Part {
    double weight;
    const double *mean, *P; // P: null for a point
};

// Mean and covariance, n x n, of all parts; their weights sum to one. part(i) answers a Part, and is asked twice for each.
template <class PartOf>
void moments(int count, int n, PartOf&& part, double* mean, double* P) {
    std::fill_n(mean, n, 0.0);
    std::fill_n(P, n * n, 0.0);
    for (int i = 0; i < count; ++i) {
        const Part of = part(i);
        for (int j = 0; j < n; ++j) mean[j] += of.weight * of.mean[j];
    }
    for (int i = 0; i < count; ++i) {
        const Part of = part(i);
        const double* own = of.P;
        for (int j = 0; j < n; ++j)
            for (int k = j; k < n; ++k)
                P[j * n + k] += of.weight * ((own ? *own++ : 0) + (of.mean[j] - mean[j]) * (of.mean[k] - mean[k]));
    }
    for (int j = 0; j < n; ++j)
        for (int k = 0; k < j; ++k) P[j * n + k] = P[k * n + j];
}

template <class Parts>
void normalise(Parts& parts) {
    double sum = 0;
    for (int i = 0; i < parts.count(); ++i) sum += parts.weight(i);
    for (int i = 0; i < parts.count(); ++i) parts.weight(i) /= sum;
}

// Weights after samples of which each part has the likelihood whose logarithm is given. Returns the logarithm of the likelihood of
// the mixture. The largest is taken out first, because far from all parts every likelihood underflows.
template <class Parts>
double reweigh(Parts& parts, const double* log_likelihood) {
    const double most = *std::max_element(log_likelihood, log_likelihood + parts.count());
    double sum = 0;
    for (int i = 0; i < parts.count(); ++i) sum += parts.weight(i) *= std::exp(log_likelihood[i] - most);
    for (int i = 0; i < parts.count(); ++i) parts.weight(i) /= sum;
    return most + std::log(sum);
}

// Drops the parts that weigh no more than `smallest`, but for the heaviest.
template <class Parts>
void prune(Parts& parts, double smallest) {
    double heaviest = 0;
    for (int i = 0; i < parts.count(); ++i) heaviest = std::max(heaviest, parts.weight(i));
    for (int i = parts.count() - 1; i >= 0; --i)
        if (parts.weight(i) <= smallest && parts.weight(i) < heaviest) parts.drop(i);
}

template <class Parts>
void merge_alike(Parts& parts) {
    for (int i = 0; i < parts.count(); ++i)
        for (int j = i + 1; j < parts.count();)
            if (parts.alike(i, j)) parts.merge(i, j);
            else ++j;
}

// The nearest two merge until there are `most`.
template <class Parts>
void collapse(Parts& parts, int most) {
    while (parts.count() > most) {
        int first = 0, second = 1;
        double nearest = HUGE_VAL;
        for (int i = 0; i < parts.count(); ++i)
            for (int j = i + 1; j < parts.count(); ++j) {
                const double apart = parts.apart(i, j);
                if (!(apart < nearest)) continue;
                nearest = apart;
                first = i;
                second = j;
            }
        parts.merge(first, second);
    }
}

} // namespace hnav::mixture
