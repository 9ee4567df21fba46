// Disturbance of the field by iron of the place. The options state its size in a room; in the open there is none. Iron that turns the
// azimuth also changes the intensities, which are observed whatever the heading is. They determine the share of the options' variance
// that is present, in addition to the white noise of the magnetometer.
#pragma once

#include "maths/rotation.hpp"

#include <algorithm>
#include <cmath>

namespace hnav {

// Part of a filter's state: numbers of one kind only. Fields in units of the reference.
template <class R>
struct FieldNoise {
    static constexpr R room = R(0.012); // slow departures of the intensities in a room as the options have it
    static constexpr R at_first = R(0.006); // assumed before any was measured

    R last[2], has_last; // horizontal and vertical intensity of the mean field before
    R white2; // variance of a mean field beside the next
    R slow[2]; // innovations of the intensities, smoothed over a second
    R slow2; // running mean square of one of them while the body turns
    R scale2; // share of the options' variances
    R settled; // 1: the options hold in full

    void begin() {
        *this = {};
        slow2 = at_first * at_first;
        scale2 = slow2 / (room * room);
    }

    // In smoothing, a heading is the mean over all places of a recording, so a few places do not determine the share.
    void take_in_full() {
        settled = scale2 = 1;
        has_last = slow[0] = slow[1] = 0;
    }

    // Intensities of a mean field over T seconds, their innovations, the variance of one of these that comes from tilt and latency,
    // and the share of the time for which the body turned, because a body at rest measures one place only.
    void note(const R* intensities, const R* innovations, R known2, R turning, R T) {
        constexpr R white_s = 5, smoothing_s = 1, memory_s = 20, outlier = R(0.05), rising = 3;
        if (settled > 0) return;
        if (has_last > 0) {
            const R h = intensities[0] - last[0], z = intensities[1] - last[1];
            white2 += T / (white_s + T) * (std::fmin((h * h + z * z) / 4, outlier * outlier) - white2);
        }
        for (int i = 0; i < 2; ++i) {
            last[i] = intensities[i];
            slow[i] += T / (smoothing_s + T) * (std::clamp(innovations[i], -outlier, outlier) - slow[i]);
        }
        has_last = 1;
        const R now2 = std::fmax(R(0), (slow[0] * slow[0] + slow[1] * slow[1]) / 2 - known2);
        const R weighted_s = T * (now2 > slow2 ? rising : turning);
        slow2 += weighted_s / (memory_s + weighted_s) * (now2 - slow2);
        constexpr R min_scale2 = R(0.01);
        const R of_white2 = white2 * T / (2 * smoothing_s);
        scale2 = std::clamp((slow2 - of_white2) / (room * room), min_scale2, R(1));
    }
};

} // namespace hnav
