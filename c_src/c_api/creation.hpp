// What the create calls of all attitude filters share: checks of the options, and the parts of them that mean the same
// in each.
#pragma once

#include "attitude/common/start.hpp"
#include "c_api/attitude_filter.hpp"
#include "c_api/engine_settings.hpp"
#include "c_api/message.hpp"
#include "maths/square.hpp"
#include "options/lists.hpp"

namespace hnav {

template <class Options>
Frames frames_of(const Options& o) {
    Frames frames;
    frames.set(o.navigation_frame == HNAV_FRAME_ENU, o.declination_rad, o.q_body_sensor);
    return frames;
}

template <class Options>
StartSettings<double> start_of(const Options& o, const Frames& frames) {
    StartSettings<double> s;
    s.mode = static_cast<StartMode>(o.start_mode);
    s.q = frames.to_internal(Quaternion(o.start_q_nb).normalized());
    s.heading_rad = o.start_heading_rad - o.declination_rad;
    s.samples = static_cast<std::uint64_t>(o.start_samples);
    s.sigma_heading = o.start_sigma_heading_rad;
    return s;
}

// In the order of the channels. The smallest ranges are those of chips that one can buy: 125 deg/s and 2 g.
template <class Options>
void set_checks(const Options& o, SensorCheckSettings<double>* check) {
    check[gyro] = {o.outlier_rate_rad_s, o.gyro_range_rad_s, 1.7};
    check[accel] = {o.outlier_force_m_s2, o.accel_range_m_s2, 18};
    check[mag] = {0, o.mag_range_tesla, max_reading};
}

struct Creation : CallersMessage {
    const OptionList& list;

    // Null pointers, the stamp, the range of every field, quaternions of no length.
    template <class Options>
    hnav_status check(hnav_filter** filter, const Options* options) const {
        clear();
        if (!filter) return fail(HNAV_ERROR_NULL_ARGUMENT, "filter is null");
        *filter = nullptr;
        if (!options) return fail(HNAV_ERROR_NULL_ARGUMENT, "options is null");
        const hnav_status status = check_options(options, list);
        if (status != HNAV_OK) return status;
        if (Quaternion(options->start_q_nb).norm() < 0.1)
            return fail(HNAV_ERROR_OPTION, "start_q_nb is no attitude: its length is below 0.1");
        if (Quaternion(options->q_body_sensor).norm() < 0.1)
            return fail(HNAV_ERROR_OPTION, "q_body_sensor is no attitude: its length is below 0.1");
        return HNAV_OK;
    }

    template <class Model, class Options>
    hnav_status make(hnav_filter** filter, const Model& model, const Frames& frames, const Options& o) const {
        auto e = engine_settings<Model>(o, list);
        e.time_jump_limit_s = o.time_jump_limit_s;
        *filter = AttitudeFilter<Model>::make(model, frames, o.gyro_hold == HNAV_GYRO_HOLD_BACKWARD, e);
        return *filter ? HNAV_OK
                       : fail(HNAV_ERROR_OUT_OF_MEMORY, "no memory for a filter with queue_capacity = %d", o.queue_capacity);
    }
};

} // namespace hnav
