// At an event: the error growth of the interval is gathered, then the samples correct the state.
#include "ins/model.hpp"

namespace hnav::ins {
namespace {

bool has_aid(const Event& event) { return (event.present & ~(std::uint64_t{1} << field)) >> rest != 0; }

// A sample of the IMU or the field within the motion. Without a correction it changes none of the seldom members of the state.
bool is_plain(const State& s, const Event& event) {
    return s.started() && !s.gap_too_long && !has_aid(event) && !event.begins_time_base();
}

void note_times(State& s, const Event& event) {
    const double T = event.t_s - s.last_s[imu];
    if (s.has(event, imu) && std::isfinite(T)) s.usual_interval_s = usual_interval(T, s.usual_interval_s);
    for (int c = 0; c < channel_count; ++c)
        if (s.has(event, c)) {
            s.last_s[c] = std::fmax(s.last_s[c], event.t_s);
            ++s.used[c];
        }
    s.last_event_s = event.t_s;
    quat(s.seen_q) = quat(s.x + 6);
    vec(s.seen_v) = vec(s.x + 3);
}

void note_place(State& s, const Event& event) {
    const double* p = event.value[position];
    const earth::Place place{p[0], p[1], p[2]};
    const double sigma_m = std::fmax(p[3], p[4]) * std::sqrt(s.fit(position).noise);
    s.aids.note_position(earth::position_of(place), earth::axes_at(place), sigma_m, event.t_s);
}

} // namespace

// Processes the interval since the last event.
void Model::cross(State& s, const Event& event) const {
    const double since_s = event.t_s - s.last_event_s;
    if (!(since_s > 0) || !std::isfinite(since_s)) return;
    quat(s.x + 6).normalize();
    gather(s, since_s);
    s.window.gap.add(s.last_event_s - s.last_s[imu], event.t_s - s.last_s[imu], s.usual_interval_s, s.rest.rate2, s.rest.force2);
    put_gravity(s);
}

// Updates the rest and glide detectors and the GNSS speed.
void Model::note(State& s, const Event& event) const {
    if (has_new(s, event, imu)) {
        const double T = event.t_s - s.last_s[imu];
        if (std::isfinite(T)) s.rest.note(options_, vec(event.value[imu]), vec(event.value[imu] + 3), T);
    }
    const bool still = s.rest.still(options_);
    if (!still) {
        s.glide.begin(event.t_s);
        vec(s.in_t.colour_at_rest) = vec(s.in_t.colour);
    }
    if (is_elsewhere(s, event)) return;
    if (s.has(event, velocity)) s.aids.note_velocity(event.value[velocity], event.t_s);
    if (s.has(event, position)) note_place(s, event);
    if (!s.has(event, velocity)) return;
    const double* z = event.value[velocity];
    s.speed_known_m_s = std::hypot(z[0], z[1]);
    s.speed_sigma_m_s = std::fmax(z[3], z[4]);
    s.speed_known_s = event.t_s;
    note_slow(s, event.t_s);
    // A velocity far from 0 does not belong to a glide.
    constexpr double fastest_m_s = 0.6;
    if (still && s.speed_known_m_s < std::fmax(fastest_m_s, 4 * s.speed_sigma_m_s)) s.glide.note(event.t_s, z, s.speed_sigma_m_s);
}

void Model::try_start(State& s, const Event& event) const {
    const bool stays = place_given(options_) && s.used[position] == 0; // nothing else will say where it is
    const bool has_place = s.has(event, position) || (s.has(event, imu) && (stays || has_given_place(s)));
    const bool has_inertial = s.has(event, imu) || !has_passed(event.t_s - s.last_s[imu], options_.longest_gap_s);
    if (s.phase != Phase::levelling || !has_place || !has_inertial) return;
    Tilt tilt;
    if (has_given_state(s) || find_tilt(s, event.t_s, &tilt)) start(s, event, tilt);
}

void Model::jump(State& s, const Event& event) const {
    if (!is_plain(s, event)) ++s.seldom_changes;
    if (s.gap_too_long && s.started()) {
        // The motion during the gap is unknown. The sensor errors stay as estimated.
        ++s.times_lost;
        begin_levelling(s);
    }
    if (s.started()) cross(s, event);
    if (event.begins_time_base()) {
        if (s.started()) widen_after_clock_jump(s);
        else begin_levelling(s);
    }
    note(s, event);
    if (!s.started()) level(s, event);
    // With forward hold the new sample acts from here on.
    if (!holds_backward(options_) && has_new(s, event, imu)) hold(s, event);
    if (s.started()) {
        const double half_s = s.has(event, imu) ? 0.5 * s.usual_interval_s : 0;
        const double since_s = event.t_s - s.last_correction_s + half_s;
        if (has_aid(event) || wants_field(s, event) || has_lasted(since_s, options_.correction_interval_s)) {
            ++s.seldom_changes;
            correct(s, event);
        }
    } else {
        try_start(s, event);
    }
    note_times(s, event);
}

} // namespace hnav::ins
