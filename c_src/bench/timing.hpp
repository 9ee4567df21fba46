// Times of benchmarks: CPU time of the thread, because the wall clock of a busy machine lies, and of many rounds the least and
// the median. Rounds go through all cases in turn, so that a change of the machine's speed meets them alike.
#pragma once

#include <time.h>
#include <algorithm>
#include <vector>

namespace bench {

inline double cpu_s() {
    timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

inline double least(const std::vector<double>& v) { return *std::min_element(v.begin(), v.end()); }

inline double median(std::vector<double> v) {
    std::nth_element(v.begin(), v.begin() + v.size() / 2, v.end());
    return v[v.size() / 2];
}

} // namespace bench
