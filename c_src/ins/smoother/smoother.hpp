// Smoothing: estimates every row of a recording from all samples, earlier and later ones.
//
// The filter runs once over the recording. A backward pass then smooths each correction (Rauch, Tung, Striebel 1965), in the error state
// and with the filter's own transition. The part before the heading was found is filtered again, linearised about the smoothed
// attitude, with wide priors for everything but the sensor errors. So its rows are navigation too, from the first sample on. A gap
// that is too long and a loss of the state end the backward pass, and hindsight that has become far less certain than the filter; it
// begins again before them. Where a heading was never found the filter's rows stay.
//
// Only checkpoints of the forward pass are kept; a piece between two of them is run again when the backward pass reaches it.
#pragma once

#include "ins/model.hpp"

#include <cstddef>

namespace hnav::ins {

// A smoothed row; circle is not set.
struct SmoothedRow {
    Navigation navigation;
    Vector3 gyro_bias, accel_bias;
};

// Input and output of the smoother.
class Recording {
public:
    virtual std::size_t rows() const = 0;
    virtual double t_s(std::size_t row) const = 0; // not decreasing
    // In the order of their events: those of one instant have the same time, first the first samples of all channels, then the second ones.
    virtual std::size_t samples() const = 0;
    virtual double sample_s(std::size_t i) const = 0;
    virtual int channel(std::size_t i) const = 0;
    virtual bool begins_time_base(std::size_t i) const = 0;
    virtual Sample sample(std::size_t i) const = 0;
    // Writes a row of the filter, with the state propagated by ahead_s beyond the last event. Returns the ready flags: bit 0 tilt, then
    // heading, velocity, position.
    virtual unsigned char write(std::size_t row, const State& shown, double ahead_s) = 0;
    // Writes the smoothed row, later.
    virtual void write(std::size_t row, const SmoothedRow& smoothed) = 0;

protected:
    ~Recording() = default;
};

enum class Smoothing { done, out_of_memory };
Smoothing smooth(const Model& model, Recording& recording);

} // namespace hnav::ins
