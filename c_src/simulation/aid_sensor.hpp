// Aiding sensors: a GNSS receiver, a barometer, wheels. One object is one of them.
//
// Random numbers belong to the index of the sample, so communication steps change only the sampled truth.
#pragma once

#include "hnav/simulation.h"
#include "simulation/delivery.hpp"
#include "simulation/gauss_markov.hpp"
#include "simulation/sample_clock.hpp"
#include "simulation/vehicle.hpp"

namespace hnav {

class AidSensor {
public:
    static constexpr int values = 6; // of a sample at most: latitude, longitude, height, velocity north, east, down

    // Plain numbers; all of the history.
    struct State {
        double next; // index of the next sample
        double missed, dropped;
        double now_s; // of the last advance
        double colour[3];
        double origin_rad[2]; // latitude and longitude of the first sample: slow errors are in its level axes
        Delivery<values>::State delivery;
    };

    AidSensor(hnav_aid_sensor_kind kind, const hnav_aid_sensor_options& options, double start_s);

    void reset() { state_ = {}; }

    // A communication point: a sample that is due is taken.
    void sample(double t_s, const Vehicle::Seen& truth);
    // Delivers what has arrived by t_s.
    void advance(double t_s);
    // The next time at which a sample is due or delivered.
    double next_event_s() const;
    // Whether there is a sample, and no outage since.
    bool is_valid() const;
    // Stated standard deviations, one for each value; constant.
    void sigma(double* of) const;

    const State& state() const { return state_; }
    // False, without any change, for numbers that are no state of this sensor.
    bool assign(const State& state);

private:
    enum Source : std::uint64_t { white, coloured, dropouts, outliers, outlier_sizes, constants };

    RandomStream stream(Source source) const;
    double constant() const { return stream(constants).normal(0); }
    bool in_outage(double t_s) const;
    void step_colour(double k);
    void read(double t_s, double k, const Vehicle::Seen& truth, double* value) const;
    void read_satellites(double t_s, double k, const Vehicle::Seen& truth, double* value) const;
    double read_pressure(double k, const Vehicle::Seen& truth) const;
    double read_speed(double k, const Vehicle::Seen& truth) const;

    hnav_aid_sensor_kind kind_;
    hnav_aid_sensor_options options_;
    SampleClock clock_;
    double latency_s_, dropout_, stamp_error_s_;
    GaussMarkov colour_[3];
    State state_{};
};

} // namespace hnav
