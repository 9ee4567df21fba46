#include "ins/smoother/recorded_events.hpp"

namespace hnav::ins {

bool next_event(Recording& recording, Place& p, std::size_t row, Event* event) {
    const double row_s = recording.t_s(row);
    const bool has_aid = p.aid < recording.aids() && recording.aid(p.aid).t_s <= row_s;
    *event = {};
    event->t_s = has_aid ? recording.aid(p.aid).t_s : row_s;
    Sample sample;
    if (p.row == row && event->t_s == row_s) {
        ++p.row;
        if (recording.imu_sample(row, &sample)) event->add(sample);
    }
    while (p.aid < recording.aids() && recording.aid(p.aid).t_s == event->t_s && !event->has(recording.aid(p.aid).channel))
        event->add(recording.aid(p.aid++));
    return event->present != 0;
}

void step_over(const Model& model, State& s, const Event& event) {
    const State before = s;
    model.before_flow(s, event);
    const double interval_s = event.t_s - before.last_event_s;
    if (interval_s > 0 && std::isfinite(interval_s) && model.flows(s)) model.flow_exactly(s, interval_s);
    model.jump(s, event);
    double sum = 0;
    for (const double x : s.x) sum += x * x;
    if (!std::isfinite(sum) || !model.plausible(s)) s = before;
}

double look_ahead(const Model& model, double to_s, State& s) {
    const double ahead_s = to_s - s.last_event_s;
    if (!(ahead_s > 0) || std::isinf(ahead_s)) return 0;
    if (model.flows(s)) model.flow_exactly(s, ahead_s);
    return ahead_s;
}

} // namespace hnav::ins
