// Gyroscope, accelerometer and magnetometer of one device, from the units of their datasheets.
#pragma once

#include "hnav/simulation.h"
#include "simulation/motion.hpp"
#include "simulation/sensor_model.hpp"

namespace hnav {

class ImuMagSensor {
public:
    static constexpr int sensor_count = 3; // numbered as in hnav_sensor

    // Plain numbers; all of the history.
    struct State {
        SensorModel::State of[sensor_count];
    };

    // Draws the spreads from the seed. start_s: time at which index 0 is due.
    ImuMagSensor(const hnav_imu_mag_sensor_options& options, double start_s);

    void reset() { state_ = {}; }

    // A communication point: the sensors that are due sample the truth.
    void sample(double t_s, const Truth& truth);
    // Delivers what has arrived by t_s.
    void advance(double t_s);
    double next_event_s() const; // the next time at which a sample is due or delivered

    const SensorModel& model(int sensor) const { return models_[sensor]; }
    const State& state() const { return state_; }
    // False, without any change, for numbers that are no state of these sensors.
    bool assign(const State& state);

private:
    SensorModel models_[sensor_count];
    State state_{};
};

} // namespace hnav
