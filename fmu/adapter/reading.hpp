// A vector that is read at instants, for a filter that integrates means over intervals.
#pragma once

#include <cstring>

namespace hnav::fmu {

// Eight-byte numbers, saved bytewise.
struct Reading {
    double last[3];
    double has_last;

    // The mean over the interval that ends with this reading, by the trapezoid; without it an integrated rate leads by half an
    // interval. now_mean: a reading, and on return the mean.
    void to_mean(double* now_mean) {
        double now[3];
        std::memcpy(now, now_mean, sizeof now);
        for (int i = 0; i < 3 && has_last != 0; ++i) now_mean[i] = 0.5 * (last[i] + now[i]);
        std::memcpy(last, now, sizeof last);
        has_last = 1;
    }
};

} // namespace hnav::fmu
