// Laws of Gaussian mixtures.
#include "estimation/mixture.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

namespace mixture = hnav::mixture;

namespace {

constexpr int n = 3, triangle = n * (n + 1) / 2;

struct Gaussian {
    double weight, mean[n], P[triangle];
    int events;
};

// A container with the interface that mixture.hpp requires.
struct Parts {
    std::vector<Gaussian> part;

    int count() const { return static_cast<int>(part.size()); }
    double& weight(int i) { return part[i].weight; }
    void drop(int i) { part.erase(part.begin() + i); }
    void merge(int i, int j) {
        const double sum = weight(i) + weight(j), share = weight(j) / sum;
        mixture::merge(n, share, part[i].mean, part[i].P, part[j].mean, part[j].P);
        weight(i) = sum;
        drop(j);
    }
    double apart(int i, int j) const { return std::fabs(part[i].mean[0] - part[j].mean[0]); }
    bool alike(int i, int j) const { return part[i].events == part[j].events; }

    double sum() const {
        return std::accumulate(part.begin(), part.end(), 0.0, [](double s, const Gaussian& g) { return s + g.weight; });
    }
    std::vector<double> moments() const {
        std::vector<double> all(n + n * n);
        const auto of = [this](int i) { return mixture::Part{part[i].weight, part[i].mean, part[i].P}; };
        mixture::moments(count(), n, of, all.data(), all.data() + n);
        return all;
    }
};

Parts some(unsigned seed, int count) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    Parts parts;
    for (int i = 0; i < count; ++i) {
        Gaussian g{std::exp(normal(random)), {}, {}, i % 3};
        Eigen::Matrix<double, n, n> root;
        for (int k = 0; k < n * n; ++k) root.data()[k] = normal(random);
        const Eigen::Matrix<double, n, n> P = root * root.transpose();
        for (int j = 0, place = 0; j < n; ++j) {
            g.mean[j] = 2 * normal(random);
            for (int k = j; k < n; ++k) g.P[place++] = P(j, k);
        }
        parts.part.push_back(g);
    }
    mixture::normalise(parts);
    return parts;
}

void expect_near(const std::vector<double>& is, const std::vector<double>& should, double by = 1e-12) {
    ASSERT_EQ(is.size(), should.size());
    for (std::size_t i = 0; i < is.size(); ++i) EXPECT_NEAR(is[i], should[i], by) << i;
}

} // namespace

TEST(Mixture, AMergeKeepsTheMomentsAndTheWeight) {
    for (unsigned seed = 0; seed < 20; ++seed) {
        Parts parts = some(seed, 5);
        const std::vector<double> before = parts.moments();
        parts.merge(3, 1);
        EXPECT_EQ(parts.count(), 4);
        EXPECT_NEAR(parts.sum(), 1, 1e-15);
        expect_near(parts.moments(), before);
        mixture::merge_alike(parts);
        mixture::collapse(parts, 1);
        expect_near(parts.moments(), before);
        expect_near({parts.part[0].mean, parts.part[0].mean + n}, {before.begin(), before.begin() + n});
    }
}

TEST(Mixture, TheCovarianceOfAllPartsIsSymmetric) {
    const std::vector<double> all = some(2, 4).moments();
    const Eigen::Map<const Eigen::Matrix<double, n, n>> P(all.data() + n);
    EXPECT_EQ(P, P.transpose());
    EXPECT_GT(Eigen::MatrixXd(P).ldlt().vectorD().minCoeff(), 0);
}

TEST(Mixture, ACovarianceOfPointsIsThatOfTheirPlaces) {
    const double at[] = {-1, 0, 2};
    std::vector<double> mean(1), P(1);
    mixture::moments(3, 1, [&](int i) { return mixture::Part{i == 1 ? 0.5 : 0.25, at + i, nullptr}; }, mean.data(), P.data());
    EXPECT_DOUBLE_EQ(mean[0], 0.25);
    EXPECT_DOUBLE_EQ(P[0], 0.25 * 1.25 * 1.25 + 0.5 * 0.25 * 0.25 + 0.25 * 1.75 * 1.75);
}

TEST(Mixture, WeightsSumToOneHoweverUnlikelyASampleIs) {
    for (const double shift : {0.0, -1e4, 700.0}) {
        Parts parts = some(3, 4);
        const std::vector<Gaussian> before = parts.part;
        const double log_likelihood[] = {shift, shift - 1, shift - 2, shift - 5000};
        const double all = mixture::reweigh(parts, log_likelihood);
        EXPECT_NEAR(parts.sum(), 1, 1e-15);
        EXPECT_EQ(parts.weight(3), 0);
        double sum = 0;
        for (int i = 0; i < 3; ++i) sum += before[i].weight * std::exp(-i);
        EXPECT_NEAR(all - shift, std::log(sum), 1e-9);
        for (int i = 0; i < 3; ++i) EXPECT_NEAR(parts.weight(i), before[i].weight * std::exp(-i) / sum, 1e-15);
    }
}

TEST(Mixture, PruningKeepsTheHeaviest) {
    Parts parts = some(4, 4);
    const double weights[] = {1e-5, 0.7, 2e-5, 0.3};
    for (int i = 0; i < 4; ++i) parts.weight(i) = weights[i];
    mixture::prune(parts, 1e-4);
    ASSERT_EQ(parts.count(), 2);
    EXPECT_EQ(parts.weight(0), 0.7);
    EXPECT_EQ(parts.weight(1), 0.3);
    mixture::prune(parts, 0.9); // more than any has
    ASSERT_EQ(parts.count(), 1);
    EXPECT_EQ(parts.weight(0), 0.7);
}

TEST(Mixture, TheNearestMergeFirst) {
    Parts parts = some(5, 4);
    const double places[] = {0, 5, 5.1, 9};
    for (int i = 0; i < 4; ++i) parts.part[i].mean[0] = places[i];
    mixture::collapse(parts, 3);
    ASSERT_EQ(parts.count(), 3);
    EXPECT_EQ(parts.part[0].mean[0], 0);
    EXPECT_GT(parts.part[1].mean[0], 5);
    EXPECT_LT(parts.part[1].mean[0], 5.1);
    EXPECT_EQ(parts.part[2].mean[0], 9);
}

TEST(Mixture, TheOrderOfPartsDoesNotMatter) {
    for (unsigned seed = 0; seed < 20; ++seed) {
        Parts parts = some(seed, 6), turned = parts;
        std::reverse(turned.part.begin(), turned.part.end());
        for (Parts* p : {&parts, &turned}) {
            mixture::merge_alike(*p);
            mixture::collapse(*p, 2);
            std::sort(p->part.begin(), p->part.end(), [](const Gaussian& a, const Gaussian& b) { return a.mean[0] < b.mean[0]; });
        }
        ASSERT_EQ(parts.count(), 2);
        ASSERT_EQ(turned.count(), 2);
        for (int i = 0; i < 2; ++i) {
            EXPECT_NEAR(parts.weight(i), turned.weight(i), 1e-14);
            expect_near({parts.part[i].mean, parts.part[i].mean + n}, {turned.part[i].mean, turned.part[i].mean + n});
            expect_near({parts.part[i].P, parts.part[i].P + triangle}, {turned.part[i].P, turned.part[i].P + triangle});
        }
    }
}
