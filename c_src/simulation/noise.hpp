// Noise of three like axes, by sample index: white noise, flicker noise (bias instability) and random walk.
//
//   IEEE Std 952-2020 annex C (densities and their Allan deviations).
//
// Flicker noise is a sum of first-order Gauss-Markov processes of equal variance s^2 whose correlation times stand in the
// ratio r: the densities 2 s^2 tau / (1 + (2 pi f tau)^2) add up to s^2 / (2 ln r f). Equal to B^2 / (2 pi f), whose Allan
// variance is (2 ln 2 / pi) B^2 =: floor^2, gives s^2 = floor^2 ln r / (2 ln 2); with r = 4, s is the floor itself.
#pragma once

#include "maths/rotation.hpp"
#include "simulation/random.hpp"

namespace hnav {

struct NoiseDensities {
    double white = 0; // unit/sqrt(Hz)
    double floor = 0; // unit: flat part of the Allan deviation
    double walk = 0;  // unit/sqrt(s)
};

// 1/4 s ... 4096 s: the floor is flat within 5 % from 2 s to 1000 s.
constexpr int flicker_processes = 8;
constexpr double flicker_shortest_s = 0.25, flicker_ratio = 4;

class Noise {
public:
    // State of the next sample; plain numbers.
    struct State {
        double flicker[flicker_processes][3];
        double walk[3];
    };

    Noise() = default;
    Noise(const NoiseDensities& densities, double period_s, std::uint64_t seed, std::uint64_t white, std::uint64_t flicker,
          std::uint64_t walk)
        : densities_(densities), white_(seed, white), flicker_(seed, flicker), walk_(seed, walk) {
        const double root_period = std::sqrt(period_s);
        white_sigma_ = densities.white / root_period;
        walk_sigma_ = densities.walk * root_period;
        double tau = flicker_shortest_s;
        for (int j = 0; j < flicker_processes; ++j, tau *= flicker_ratio) {
            keep_[j] = std::exp(-period_s / tau);
            drive_[j] = densities.floor * std::sqrt(-std::expm1(-2 * period_s / tau));
        }
    }

    // From sample k - 1 to k; at sample 0 the flicker noise is stationary and the walk zero. Called once for each k.
    void step(double k, State* state) const {
        const auto index = static_cast<std::uint64_t>(k);
        if (densities_.floor > 0)
            for (int j = 0; j < flicker_processes; ++j)
                for (int i = 0; i < 3; ++i) {
                    const double n =
                        flicker_.normal((flicker_processes * index + static_cast<unsigned>(j)) * 4 + static_cast<unsigned>(i));
                    double& x = state->flicker[j][i];
                    x = index == 0 ? densities_.floor * n : keep_[j] * x + drive_[j] * n;
                }
        if (densities_.walk > 0 && index > 0)
            for (int i = 0; i < 3; ++i) state->walk[i] += walk_sigma_ * walk_.normal(4 * index + static_cast<unsigned>(i));
    }

    // Of sample k. white_factor: on the standard deviation of the white noise.
    Vector3 at(double k, const State& state, double white_factor) const {
        Vector3 sum = Vector3::Zero();
        for (int i = 0; i < 3; ++i) {
            if (white_sigma_ > 0)
                sum[i] =
                    white_factor * white_sigma_ * white_.normal(4 * static_cast<std::uint64_t>(k) + static_cast<unsigned>(i));
            for (const auto& process : state.flicker) sum[i] += process[i];
            sum[i] += state.walk[i];
        }
        return sum;
    }

    double white_psd() const { return densities_.white * densities_.white; }

private:
    NoiseDensities densities_;
    RandomStream white_{0, 0}, flicker_{0, 0}, walk_{0, 0};
    double white_sigma_ = 0, walk_sigma_ = 0;
    double keep_[flicker_processes] = {}, drive_[flicker_processes] = {};
};

} // namespace hnav
