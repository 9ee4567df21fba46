// A vector that is read at instants, for a filter that integrates means over intervals.
#pragma once

#include <cmath>
#include <cstring>

namespace hnav::fmu {

// Eight-byte numbers, saved bytewise.
struct Reading {
    double last[3];
    double has_last;

    // The mean over the interval that ends with this reading, by the trapezoid; without it an integrated rate leads by half an
    // interval. now_mean: a reading, and on return the mean. spike: a larger change is none of a motion, and must not spread to
    // two samples, whose check looks for single ones; 0: any is.
    void to_mean(double* now_mean, double spike) {
        double now[3];
        std::memcpy(now, now_mean, sizeof now);
        bool moves = has_last != 0; // false for NaN too
        for (int i = 0; i < 3; ++i) moves = moves && std::fabs(now[i] - last[i]) < (spike > 0 ? spike : HUGE_VAL);
        for (int i = 0; i < 3 && moves; ++i) now_mean[i] = 0.5 * (last[i] + now[i]);
        std::memcpy(last, now, sizeof last);
        has_last = 1;
    }
};

} // namespace hnav::fmu
