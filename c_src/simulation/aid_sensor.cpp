#include "simulation/aid_sensor.hpp"

#include "simulation/streams.hpp"

namespace hnav {
namespace {

using earth::rate_rad_s;

constexpr double ceiling_m = 44330; // height of zero pressure in the formula of the standard atmosphere

// Velocity of a point of the body, in the axes of the navigation frame.
Vector3 velocity_of(const Vehicle::Seen& truth, const Vector3& point_b) {
    const Matrix3 R_nb = rotation_matrix(truth.q_nb);
    const Vector3 earth_n{rate_rad_s * std::cos(truth.place.latitude_rad), 0, -rate_rad_s * std::sin(truth.place.latitude_rad)};
    return truth.velocity_n + R_nb * (truth.rate_b - R_nb.transpose() * earth_n).cross(point_b);
}

} // namespace

AidSensor::AidSensor(hnav_aid_sensor_kind kind, const hnav_aid_sensor_options& o, double start_s) : kind_(kind), options_(o) {
    const auto set = [&](double period_s, double latency_s, double dropout) {
        clock_ = {start_s, period_s, 0, RandomStream(0, 0)};
        latency_s_ = latency_s;
        dropout_ = dropout;
        stamp_error_s_ = 0;
    };
    switch (kind) {
    case HNAV_AID_GNSS:
        set(o.gnss.period_s, o.gnss.latency_s, o.gnss.dropout);
        stamp_error_s_ = o.gnss.stamp_error_s;
        for (int i = 0; i < 3; ++i)
            colour_[i] = GaussMarkov::over(o.gnss.period_s, o.gnss.colour_m[i == 2], o.gnss.colour_s, false);
        break;
    case HNAV_AID_BARO:
        set(o.baro.period_s, o.baro.latency_s, o.baro.dropout);
        colour_[0] = GaussMarkov::over(o.baro.period_s, o.baro.colour_pa, o.baro.colour_s, false);
        break;
    default: set(o.wheel.period_s, o.wheel.latency_s, o.wheel.dropout); break;
    }
}

RandomStream AidSensor::stream(Source source) const {
    return {static_cast<std::uint64_t>(options_.seed), streams::aid_sensor + 16 * static_cast<std::uint64_t>(kind_) + source};
}

// ------------------------------------------------------------------------------------------------ samples

void AidSensor::sample(double t_s, const Vehicle::Seen& truth) {
    Delivery<values>::advance(&state_.delivery, t_s); // no sample waits beyond its latency, so the queue has space for one more
    const double k = clock_.newest_due(t_s, state_.next);
    if (k < state_.next) return;
    if (state_.next > 0) {
        state_.missed += k - state_.next;
    } else {
        state_.origin_rad[0] = truth.place.latitude_rad;
        state_.origin_rad[1] = truth.place.longitude_rad;
    }
    for (double i = state_.next; i <= k; ++i) step_colour(i);
    state_.next = k + 1;
    if (in_outage(t_s)) return;
    if (stream(dropouts).uniform(static_cast<std::uint64_t>(k)) < dropout_) {
        state_.dropped += 1;
        return;
    }
    double value[values] = {};
    read(t_s, k, truth, value);
    Delivery<values>::send(&state_.delivery, value, t_s, t_s + stamp_error_s_, stamp_error_s_ + latency_s_);
}

void AidSensor::advance(double t_s) {
    state_.now_s = t_s;
    Delivery<values>::advance(&state_.delivery, t_s);
}

double AidSensor::next_event_s() const { return std::fmin(clock_.due_s(state_.next), Delivery<values>::next_s(state_.delivery)); }

bool AidSensor::is_valid() const { return state_.delivery.count > 0 && !in_outage(state_.now_s - stamp_error_s_ - latency_s_); }

bool AidSensor::assign(const State& state) {
    if (!(state.delivery.waiting >= 0 && state.delivery.waiting < max_in_flight) || !(state.next >= 0)) return false;
    state_ = state;
    return true;
}

bool AidSensor::in_outage(double t_s) const {
    const hnav_gnss_options& o = options_.gnss;
    if (kind_ != HNAV_AID_GNSS || !(o.outage_length_s > 0)) return false;
    const double since = t_s - o.outage_start_s + instant_s(t_s, o.period_s);
    return since >= 0 && (o.outage_every_s > 0 ? std::fmod(since, o.outage_every_s) : since) < o.outage_length_s;
}

// ------------------------------------------------------------------------------------------------ readings

void AidSensor::step_colour(double k) {
    const auto index = static_cast<std::uint64_t>(k);
    for (int i = 0; i < 3; ++i) {
        if (!(colour_[i].sigma > 0)) continue;
        const double n = stream(coloured).normal(4 * index + static_cast<unsigned>(i));
        state_.colour[i] = index == 0 ? colour_[i].start(n) : colour_[i].next(state_.colour[i], n);
    }
}

void AidSensor::read(double t_s, double k, const Vehicle::Seen& truth, double* value) const {
    if (kind_ == HNAV_AID_GNSS) read_satellites(t_s, k, truth, value);
    else if (kind_ == HNAV_AID_BARO) value[0] = read_pressure(k, truth);
    else value[0] = read_speed(k, truth);
}

void AidSensor::read_satellites(double t_s, double k, const Vehicle::Seen& truth, double* value) const {
    const hnav_gnss_options& o = options_.gnss;
    const auto index = static_cast<std::uint64_t>(k);
    const Vector3 antenna(o.antenna_b_m);
    Vector3 off = rotation_matrix(truth.q_nb) * antenna, velocity = velocity_of(truth, antenna);
    const Matrix3 axes_n = earth::axes_at(truth.place);
    const Matrix3 carried = earth::carried_axes(earth::axes_at({state_.origin_rad[0], state_.origin_rad[1], 0}), axes_n.col(2));
    const Vector3 colour_n = axes_n.transpose() * (carried * Vector3(state_.colour));
    const RandomStream noise = stream(white), size = stream(outlier_sizes);
    const bool is_outlier = stream(outliers).uniform(index) < o.outlier_probability;
    const bool has_jumped =
        t_s + instant_s(t_s, o.period_s) >= o.jump_start_s && t_s + instant_s(t_s, o.period_s) < o.jump_stop_s;
    for (unsigned i = 0; i < 3; ++i) {
        off[i] += colour_n[i] + o.noise_m[i == 2] * noise.normal(8 * index + i);
        velocity[i] += o.noise_m_s[i == 2] * noise.normal(8 * index + 4 + i);
        if (has_jumped) off[i] += o.jump_n_m[i];
        if (!is_outlier) continue;
        off[i] += o.outlier_m * size.normal(8 * index + i);
        velocity[i] += o.outlier_m_s * size.normal(8 * index + 4 + i);
    }
    const earth::Place seen = earth::place_of(earth::position_of(truth.place) + axes_n * off);
    // A receiver uses the north of its stated position, which differs from that of its true position near a pole.
    const Vector3 measured = earth::axes_at(seen).transpose() * (axes_n * velocity);
    value[0] = seen.latitude_rad;
    value[1] = seen.longitude_rad;
    value[2] = seen.height_m;
    for (int i = 0; i < 3; ++i) value[3 + i] = measured[i];
}

double AidSensor::read_pressure(double k, const Vehicle::Seen& truth) const {
    const hnav_baro_options& o = options_.baro;
    return earth::pressure_pa(std::fmin(truth.place.height_m, ceiling_m)) + o.offset_sigma_pa * constant() + state_.colour[0] +
           o.noise_pa * stream(white).normal(static_cast<std::uint64_t>(k));
}

double AidSensor::read_speed(double k, const Vehicle::Seen& truth) const {
    const hnav_wheel_options& o = options_.wheel;
    const Vector3 ahead_n = rotation_matrix(truth.q_nb).col(0);
    return (1 + o.scale_factor_sigma * constant()) * ahead_n.dot(velocity_of(truth, Vector3(o.wheel_b_m))) +
           o.noise_m_s * stream(white).normal(static_cast<std::uint64_t>(k));
}

void AidSensor::sigma(double* of) const {
    const hnav_aid_sensor_options& o = options_;
    for (int i = 0; i < 3; ++i) {
        of[i] = kind_ == HNAV_AID_GNSS ? o.gnss.noise_m[i == 2] : 0;
        of[3 + i] = kind_ == HNAV_AID_GNSS ? o.gnss.noise_m_s[i == 2] : 0;
    }
    if (kind_ == HNAV_AID_BARO) of[0] = o.baro.noise_pa;
    if (kind_ == HNAV_AID_WHEEL) of[0] = o.wheel.noise_m_s;
}

} // namespace hnav
