// At an event: force and field correct first, then the heading aid; a new rate is held from here on.
#include "attitude/hrekf/model.hpp"

namespace hnav {

void HrekfModel::jump(State& s, const Event& event) const {
    if (s.started) {
        Eigen::Map<QuaternionR>(s.x).normalize();
        take_turn(s);
    }
    if (!holds_backward(options_)) examine(s, event);
    for (int c = 0; c < channel_count; ++c) s.used[c] += s.has(event, c);
    if (s.started && is_lost(s, event)) lose_attitude(s);
    if (s.started && is_gap(event.t_s - s.last_s[gyro], s.spacing_s)) widen_for_gap(s, event);
    if (s.started && event.begins_time_base()) widen(s, Vector3R(R(0.01), R(0.01), R(0.04)).asDiagonal());
    if (!s.started) {
        collect_for_start(s, event);
    } else {
        correct_directions(s, event);
        if (event.has(heading)) correct_heading(s, event);
    }
    if (s.has(event, gyro)) {
        s.spacing_s = usual_interval(event.t_s - s.last_s[gyro], s.spacing_s);
        hold(s, event);
    }
    for (int c = 0; c < channel_count; ++c)
        if (s.has(event, c)) s.last_s[c] = event.t_s;
}

} // namespace hnav
