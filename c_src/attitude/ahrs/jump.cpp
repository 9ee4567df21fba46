// At an event: gathers the samples, and corrects a few dozen times a second.
#include "attitude/ahrs/model.hpp"

namespace hnav {

void AhrsModel::jump(State& s, const Event& event) const {
    const std::uint64_t usable = s.usable(event);
    const int channels = has_aid(event) ? channel_count : heading; // that may have a sample
    for (int c = 0; c < channels; ++c) s.used[c] += (usable >> c) & 1;
    if (s.started) {
        Eigen::Map<QuaternionR>(s.x).normalize();
        if (s.gap_too_long) pass_gap(s, event.t_s);
        if (event.begins_time_base()) widen_after_clock_jump(s);
        take_turn(s);
    }
    if (s.has(event, gyro) && !holds_backward(options_)) hold(s, event);
    if (!s.started) {
        start(s, event);
    } else {
        const R rate_s = s.has(event, gyro) ? interval(s, gyro, event.t_s) : 0;
        gather(s, event, rate_s);
        // At the sample nearest to the end of the interval, so that jitter does not matter.
        const double since_s = event.t_s - s.last_correction_s;
        const bool due = has_lasted(since_s + 0.5 * double(rate_s), options_.correction_interval_s);
        if (due || has_aid(event)) correct(s, event);
    }
    for (int c = 0; c < channels; ++c)
        if ((usable >> c) & 1) s.note_time(c, event.t_s);
    s.last_event_s = event.t_s;
}

} // namespace hnav
