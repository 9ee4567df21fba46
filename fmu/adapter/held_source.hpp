// Finds a source that is slower than the period of its input: the importer holds its values, and a repeated value is no new sample.
#pragma once

#include <algorithm>

namespace hnav::fmu {

// Of one sensor. Eight-byte numbers, saved bytewise. Values of a sensor have noise and do not repeat. Held ones repeat about equally often
// between changes, while a simulation without noise repeats them for as long as the motion is constant.
class HeldSource {
public:
    static constexpr int most = 9; // numbers compared

    // Whether values taken at the period are a new sample. also: further values that change with them, or null.
    bool is_new(const double* value, int count, const double* also, int also_count) {
        double now[most] = {};
        std::copy_n(value, count, now);
        if (also) std::copy_n(also, also_count, now + count);
        const bool same = run_ > 0 && std::equal(now, now + most, last_);
        std::copy_n(now, most, last_);
        if (!same) {
            if (run_ > 0) end_run();
            run_ = 1;
            return true;
        }
        run_ += 1;
        if (repeats_ > 0 && run_ > constant * longest()) { // the values do not change any more
            std::fill_n(length_, runs, 0.0);
            run_ = 1;
            repeats_ = 0;
        }
        return !(repeats_ > 0);
    }

    // Mean number of samples with the same value, where a source is held; else 0.
    double repeats() const { return repeats_; }

private:
    static constexpr int runs = 6; // chosen: fewer may be alike by chance
    static constexpr double regular = 2; // largest ratio of two runs: a source of 33 Hz in steps of 0.02 s has 1 and 2 by turns
    static constexpr double constant = 4; // chosen: of the present run to the longest, beyond which nothing changes any more

    double longest() const { return *std::max_element(length_, length_ + runs); }

    void end_run() {
        std::copy(length_ + 1, length_ + runs, length_);
        length_[runs - 1] = run_;
        const double shortest = *std::min_element(length_, length_ + runs);
        const bool is_held = shortest > 0 && longest() > 1 && longest() <= regular * shortest;
        repeats_ = 0;
        if (is_held)
            for (const double length : length_) repeats_ += length / runs;
    }

    double last_[most] = {}, length_[runs] = {};
    double run_ = 0, repeats_ = 0;
};

} // namespace hnav::fmu
