// Navigation with hindsight: every row of a recording from all of its samples, before it and after it.
//
// The filter goes through the recording once, and from the last row to the first each correction is undone with what came
// later (Rauch, Tung, Striebel 1965), in the error state and with the filter's own transition. A part before the heading was
// found is filtered again, with the attitude that follows from what came later as the point to linearise about, and nothing
// known but of the sensors: so its rows too are navigation, from the first sample on. A gap that is too long and what was lost
// end what is told backwards; where a heading was never found the filter's rows stay.
//
// Nothing but states from time to time is kept of the way forward; a piece is gone through again when its turn comes.
#pragma once

#include "ins/model.hpp"

#include <cstddef>

namespace hnav::ins {

// A row with hindsight; of the navigation all but circle is set.
struct SmoothedRow {
    Navigation navigation;
    Vector3 gyro_bias, accel_bias;
};

// What goes through the smoother, and where its answers go.
class Recording {
public:
    virtual std::size_t rows() const = 0;
    virtual double t_s(std::size_t row) const = 0;
    virtual bool imu_sample(std::size_t row, Sample* sample) = 0; // false: the row has none
    virtual std::size_t aids() const = 0;
    virtual const Sample& aid(std::size_t i) const = 0; // in the order of their times
    // A row of the filter, at its time, with the state brought so far beyond the last event. Answers what is ready: bit 0 tilt, then
    // heading, velocity, position.
    virtual unsigned char write(std::size_t row, const State& shown, double ahead_s) = 0;
    // The row with hindsight, later.
    virtual void write(std::size_t row, const SmoothedRow& smoothed) = 0;

protected:
    ~Recording() = default;
};

enum class Smoothing { done, out_of_memory };
Smoothing smooth(const Model& model, Recording& recording);

} // namespace hnav::ins
