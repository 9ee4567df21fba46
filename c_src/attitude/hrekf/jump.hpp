// At an event: force and field correct first, then the heading aid; a new rate is held from here on.
#pragma once

#include "attitude/hrekf/model.hpp"

namespace hnav {

template <class R>
void HrekfModelOf<R>::jump(State& s, const Event& event) const {
    for (int c = 0; c < channel_count; ++c) s.used[c] += event.has(c);
    if (!s.started) {
        collect_for_start(s, event);
    } else {
        s.error_map.flow(event.t_s, QuaternionR(s.x).normalized(), turn_rate(s, s.x));
        correct_directions(s, event);
        if (event.has(heading)) correct_heading(s, event);
    }
    for (int c = 0; c < channel_count; ++c)
        if (event.has(c)) s.last_s[c] = event.t_s;
    if (event.has(gyro)) hold(s, event);
}

} // namespace hnav
