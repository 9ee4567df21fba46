// Filters the part before the heading was found a second time, linearised about the smoothed state.
#include "ins/smoother/passes.hpp"

#include <algorithm>

namespace hnav::ins {

// Smooths the part before the heading was known well enough to linearise about it. Returns false if it could not be filtered again.
bool Smoother::go_back_before(const Node& found, const Hindsight& hindsight, std::size_t piece) {
    Place place;
    State begin, later = found.state;
    if (!find_begin(found.state, piece, &place, &begin)) return false;
    add_error(hindsight.error, later);
    const Target target{later, hindsight.P};
    carry_back(later, found.sample, begin.last_event_s);
    const double known_s = place_at_first_fix(later, place.sample) - begin.last_event_s;
    Options options = model_.options();
    options.start = HNAV_INS_START_STATE;
    Way way{Model(options), before_, 0, found.state.last_event_s, true, {}};
    // Its wide start is linearised about an estimate that has used the same samples: the first innovations are no evidence of steps.
    way.model.expect_no_steps();
    for (const int channel : {velocity, position}) way.settled_s[channel] = time_of_fix(channel, place.sample, 5);
    State end = way.model.once_more(begin, later, known_s);
    if (!go_forward(way, place, end, false)) return false;
    // Both passes have used the same samples. Far from its linearisation the second finds another heading: a walker's was 70 deg off, at a
    // sigma of 4.
    if (!is_expected(end, seen_from(end, target), row_phi + 2, 1)) return false;
    go_back(way, &target);
    return true;
}

// Finds the begin of the search that found this heading.
bool Smoother::find_begin(const State& found, std::size_t piece, Place* place, State* s) {
    const auto within = [&found](const State& state) {
        return state.times_lost == found.times_lost && state.phase != Phase::waiting &&
               state.last_event_s >= found.levelling.began_s;
    };
    while (piece > 0 && within(main_[piece].state)) --piece;
    *place = main_[piece].place;
    *s = main_[piece].state;
    Event event;
    for (; place->row < recording_.rows(); ++place->row) {
        while (next_event(recording_, *place, &event)) {
            step_over(model_, *s, event);
            if (within(*s)) return s->phase != Phase::navigating;
        }
    }
    return false;
}

// After a long backward integration velocity and place are inaccurate; they are replaced by those of the first fixes from a sample on.
// Returns the time of the place.
double Smoother::place_at_first_fix(State& s, std::size_t sample) const {
    double at_s = s.last_event_s;
    bool has_place = model_.has_given_place(s), has_velocity = false;
    if (has_place) vec(s.x).setZero();
    vec(s.x + 3).setZero();
    for (; sample < recording_.samples() && recording_.sample_s(sample) <= s.last_event_s && !(has_place && has_velocity);
         ++sample) {
        const Sample fix = recording_.sample(sample);
        const earth::Place place{fix.value[0], fix.value[1], fix.value[2]};
        if (fix.channel == position && !has_place) {
            vec(s.x) = mat(s.axes).transpose() * (earth::position_of(place) - vec(s.anchor_e));
            at_s = fix.t_s;
            has_place = true;
        } else if (fix.channel == velocity && !has_velocity) {
            const Vector3 v(fix.value[0], fix.value[1], std::isnan(fix.value[2]) ? 0 : fix.value[2]);
            vec(s.x + 3) = mat(s.axes).transpose() * (mat(s.fix_axes) * v);
            has_velocity = true;
        }
    }
    return at_s;
}

// Time of the count-th fix of a channel from a sample on.
double Smoother::time_of_fix(int channel, std::size_t sample, int count) const {
    for (; sample < recording_.samples(); ++sample)
        if (recording_.channel(sample) == channel && --count == 0) return recording_.sample_s(sample);
    return -std::numeric_limits<double>::infinity();
}

// Integrates rate and force backwards, from a correction before this sample to an earlier time.
void Smoother::carry_back(State& s, std::size_t next_sample, double to_s) {
    const Hold hold = hold_of(model_.options());
    Vector3 later_rate = vec(s.held.read_rate[0]), later_force = vec(s.held.read_force[0]);
    double now_s = s.last_event_s;
    vec(s.held.coning).setZero();
    vec(s.held.sculling).setZero();
    // The first IMU sample that is not earlier: it may act on the time before it.
    std::size_t i = next_sample;
    while (i > 0 && recording_.sample_s(i - 1) >= now_s) --i;
    while (i < recording_.samples() && recording_.channel(i) != imu) ++i;
    for (i = std::min(i + 1, recording_.samples()); i-- > 0 && now_s > to_s;) {
        if (recording_.channel(i) != imu) continue;
        const Sample sample = recording_.sample(i);
        const double until_s = std::fmax(to_s, std::fmin(now_s, sample.t_s));
        const auto take = [&] {
            vec(s.held.rate) = mean_between<double>(hold, later_rate, vec(sample.value));
            vec(s.held.force) = mean_between<double>(hold, later_force, vec(sample.value + 3));
            later_rate = vec(sample.value);
            later_force = vec(sample.value + 3);
        };
        if (hold != Hold::backward) take();
        model_.flow_exactly(s, until_s - now_s);
        if (hold == Hold::backward) take();
        now_s = until_s;
    }
    quat(s.x + 6).normalize();
}

} // namespace hnav::ins
