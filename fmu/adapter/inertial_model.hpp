// A filter whose inertial samples are readings of instants or means of intervals, by how the importer marks them.
#pragma once

#include "adapter/estimate_model.hpp"
#include "hnav/options/shared.h"

namespace hnav::fmu {

// State of such a model beside the library object; derived models extend it.
template <int inputs>
struct InertialMemory : EstimateMemory<inputs> {
    double reads_instants; // 1: the object was made with gyro_hold = instant although the parameter is backward
};

// Held inputs that are a sample at a communication point are readings of its instant, whatever interval the sensor's own samples
// stand for. Samples with a counter are those of the sensor. Options: with gyro_hold. gyro: the input that decides.
template <class Calls, class Memory, class Options, int gyro,
          hnav_status (*create)(hnav_filter**, const Options*, char*, std::size_t)>
class InertialModel : public EstimateModel<Calls, Memory> {
    using Base = EstimateModel<Calls, Memory>;

protected:
    using Base::memory_;

    // mode: the value of sampling_mode, or counter.
    bool make_with(const Options& options, double mode, Message* why) {
        options_ = options;
        const bool held = mode == periodic || mode == automatic;
        const double reads_instants = held && options.gyro_hold == HNAV_GYRO_HOLD_BACKWARD ? 1 : 0;
        const Options made = options_for(reads_instants);
        if (!this->make(why, create, &made)) return false;
        memory_.reads_instants = reads_instants;
        return true;
    }

    // Called before samples are taken. True if the filter has restarted: the samples until now were none of its sensors.
    template <int sensors>
    bool begins_to_count(const SensorRows (&rows)[sensors], const double* values) {
        const bool mistaken = memory_.sampled.begins_to_count(rows, values);
        return (takes_means(values[rows[gyro].sample]) || mistaken) && this->restart();
    }

    // The options of an object are no part of its state.
    bool make_other(const Memory& memory, hnav_filter** other, Message* why) const final {
        if (memory.reads_instants == memory_.reads_instants) return true;
        const Options made = options_for(memory.reads_instants);
        return create(other, &made, why->text, sizeof why->text) == HNAV_OK;
    }

private:
    Options options_for(double reads_instants) const {
        Options made = options_;
        if (reads_instants != 0) made.gyro_hold = HNAV_GYRO_HOLD_INSTANT;
        return made;
    }

    // True once: a counter marks the samples of the gyroscope, which are means, and the object is exchanged.
    bool takes_means(double count) {
        if (memory_.reads_instants == 0 || !memory_.sampled.clock[gyro].counts(count)) return false;
        Memory of_means = memory_;
        of_means.reads_instants = 0;
        hnav_filter* other = nullptr;
        Message why;
        if (!make_other(of_means, &other, &why)) return false;
        this->replace(other);
        memory_.reads_instants = 0;
        return true;
    }

    Options options_{};
};

} // namespace hnav::fmu
