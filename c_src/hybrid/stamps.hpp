// From the time stamps of samples to the time of a filter, which never runs back.
//
// A clock that is set back: a sensor whose stamp lies more than a limit before its own last one, and before all others too,
// begins a new time base. Its sample follows the newest one after the sensor's usual interval, and the event is marked,
// because the body may have moved in between. A sensor that is always late never runs back against itself: its samples are
// late, and no new time base. A clock that is set forward is a gap to the filter; but a single stamp that lies far ahead of
// all others is an error of that stamp: its sample waits for a second stamp that agrees, and is left out.
//
// Bursts: samples of one sensor that share a stamp, as a FIFO hands them over, are spread over the time since the burst
// before it. How many share a stamp is learnt from the last burst. This holds for channels in the mask `bursts`: two fixes of one
// time come from two receivers.
//
// Of a plant of any pace samples may come once a minute: what is far ahead is then learnt from the intervals of its sensors.
#pragma once

#include "base/instant.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace hnav {

// Part of the saved state: eight-byte numbers only.
template <int channels, bool any_pace = false, std::uint64_t bursts = ~std::uint64_t{0}>
class Stamps {
public:
    enum class Place : std::uint64_t { stamped, spread, jumped, left_out };
    struct Placed {
        double t_s; // the filter's
        Place how;
    };

    Stamps() { clear(); }

    void clear() {
        *this = Stamps(0);
        for (Channel& c : channel_) c.last_s = -std::numeric_limits<double>::infinity();
    }

    double offset_s() const { return offset_s_; } // the filter's time is stamp + offset
    std::uint64_t jumps() const { return jumps_; }
    std::uint64_t left_out() const {
        std::uint64_t sum = 0;
        for (const Channel& c : channel_) sum += c.left_out;
        return sum;
    }
    std::uint64_t left_out(int channel) const { return channel_[channel].left_out; }
    Place last() const { return last_; } // of the newest sample
    double last_s(int channel) const { return channel_[channel].last_s; } // newest stamp; -infinity before the first
    double interval_s(int channel) const { return channel_[channel].interval_s; } // usual one between two stamps; 0: not known
    std::uint64_t late(int channel) const { return channel_[channel].late; }
    double late_s(int channel) const { return channel_[channel].late_s; } // the filter's time of the newest late sample
    void note_late(int channel, double now_s) {
        ++channel_[channel].late;
        channel_[channel].late_s = now_s;
    }

    // newest(): the time of the newest of all samples and of the shown estimate. closed_s: samples before it are late.
    // limit_s: 0 disables new time bases.
    template <class Newest>
    Placed place(int channel, double stamp_s, double shown_s, double closed_s, double limit_s, Newest&& newest) {
        Channel& c = channel_[channel];
        const double t_s = stamp_s + offset_s_, since_s = stamp_s - c.last_s;
        // The most frequent case.
        if (is_next(c, stamp_s, since_s) && (limit_s <= 0 || t_s - shown_s < far_limits * limit_s)) {
            c.interval_s = since_s;
            c.last_s = stamp_s;
            last_ = Place::stamped;
            return {t_s, last_};
        }
        return place_with_care(c, stamp_s, closed_s, limit_s, newest(), (bursts >> channel) & 1u);
    }

    // Places samples of several channels with the same stamp, if for each of them it follows after its usual interval. False:
    // nothing has changed, and each must be placed separately.
    bool place_together(std::uint64_t present, double stamp_s, double shown_s, double limit_s) {
        if (limit_s > 0 && !(stamp_s + offset_s_ - shown_s < far_limits * limit_s)) return false;
        for (int c = 0; c < channels; ++c)
            if ((present >> c) & 1u && !is_next(channel_[c], stamp_s, stamp_s - channel_[c].last_s)) return false;
        for (int c = 0; c < channels; ++c) {
            if (!((present >> c) & 1u)) continue;
            channel_[c].interval_s = stamp_s - channel_[c].last_s;
            channel_[c].last_s = stamp_s;
        }
        last_ = Place::stamped;
        return true;
    }

private:
    static constexpr double max_spread = 1.5; // length of the interval that a burst is spread over, in usual intervals
    static constexpr double far_limits = 10; // a stamp so many seconds ahead is implausible
    static constexpr double unknown_limits = 1000; // the same before the intervals of the sensors are known
    static constexpr double max_interval_s = any_pace ? HUGE_VAL : 1; // largest interval between two stamps that counts as usual

    struct Channel {
        std::uint64_t alone; // one sample per stamp, now and before
        double last_s; // stamp
        double interval_s; // usual interval between two stamps; 0: not known
        double count, expected; // samples of the present stamp, and of the one before
        double spread_s;
        std::uint64_t late, left_out;
        double late_s;
    };

    // The next sample after its usual interval, the only one with its stamp.
    static bool is_next(const Channel& c, double stamp_s, double since_s) {
        return c.alone && since_s > sample_instant_s(stamp_s) && since_s < max_spread * c.interval_s;
    }

    explicit Stamps(int) : offset_s_(0), ahead_s_(0), jumps_(0), last_(Place::stamped), channel_{} {}

    Placed place_with_care(Channel& c, double stamp_s, double closed_s, double limit_s, double newest_s, bool in_bursts) {
        last_ = Place::stamped;
        if (limit_s > 0 && is_far_ahead(stamp_s, newest_s, limit_s)) {
            ++c.left_out;
            return {stamp_s, last_ = Place::left_out};
        }
        const double since_s = stamp_s - c.last_s, same_s = sample_instant_s(stamp_s);
        if (since_s > same_s) begin_stamp(c, stamp_s, since_s);
        else if (since_s >= -same_s) c.count += 1;
        else if (limit_s > 0 && since_s < -limit_s && stamp_s + offset_s_ < newest_s - limit_s)
            return begin_time_base(c, stamp_s, newest_s);
        else return {stamp_s + offset_s_, last_};
        c.alone = c.count == 1 && c.expected <= 1;
        if (!in_bursts || c.expected <= 1 || c.count > c.expected) return {stamp_s + offset_s_, last_};
        last_ = Place::spread;
        return {std::max(closed_s, stamp_s + offset_s_ - c.spread_s * (1 - c.count / c.expected)), last_};
    }

    static void begin_stamp(Channel& c, double stamp_s, double since_s) {
        c.expected = c.count;
        c.count = 1;
        c.spread_s = c.interval_s > 0 ? std::min(since_s, max_spread * c.interval_s) : since_s;
        if (any_pace || c.interval_s == 0 || since_s < max_spread * c.interval_s)
            c.interval_s = since_s < max_interval_s ? since_s : 0;
        else c.interval_s = std::min(max_spread * c.interval_s, max_interval_s);
        c.last_s = stamp_s;
    }

    Placed begin_time_base(Channel& c, double stamp_s, double newest_s) {
        offset_s_ = newest_s + c.interval_s - stamp_s;
        ++jumps_;
        c.last_s = stamp_s;
        c.count = 1;
        c.expected = 0;
        return {newest_s + c.interval_s, last_ = Place::jumped};
    }

    // The first implausible stamp; a second stamp in agreement with it is accepted.
    bool is_far_ahead(double stamp_s, double newest_s, double limit_s) {
        const double ahead_s = stamp_s + offset_s_ - newest_s;
        double far_s = far_limits * limit_s, agree_s = far_s;
        if (!(ahead_s > far_s) || std::isinf(ahead_s)) return false;
        if (any_pace) {
            double pace_s = 0;
            for (const Channel& c : channel_) pace_s = std::max(pace_s, c.interval_s);
            far_s = pace_s > 0 ? std::max(far_s, far_limits * pace_s) : unknown_limits * limit_s;
            agree_s = std::max(far_s, 1.5 * (ahead_s_ + offset_s_ - newest_s)); // one of a few slow samples agrees with the next
            if (!(ahead_s > far_s)) return false;
        }
        if (stamp_s > ahead_s_ && stamp_s < ahead_s_ + agree_s) return false;
        ahead_s_ = stamp_s;
        return true;
    }

    double offset_s_;
    double ahead_s_; // the newest stamp that was far ahead
    std::uint64_t jumps_;
    Place last_;
    Channel channel_[channels];
};

} // namespace hnav
