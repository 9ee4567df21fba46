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
        if (repeats_ > 0 && run_ > constant * longest()) *this = begun_with(now); // the values do not change any more
        return !(repeats_ > 0);
    }

    // Mean number of samples with the same value, where a source is held; else 0.
    double repeats() const { return repeats_; }

private:
    static constexpr int runs = 6; // chosen: a motion in steps repeats as regularly by chance once in hundreds
    static constexpr double regular = 2, constant = 4; // largest ratios of runs

    static HeldSource begun_with(const double* now) {
        HeldSource other;
        std::copy_n(now, most, other.last_);
        other.run_ = 1;
        return other;
    }

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
