// Shared by the create calls of all attitude filters: checks of the options, and the parts of them with the same meaning in
// each.
#pragma once

#include "attitude/common/start.hpp"
#include "c_api/attitude_object.hpp"
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

struct Creation : CallersMessage {
    const OptionList& list;

    template <class Options>
    hnav_status check(hnav_filter** filter, const Options* options) const {
        return check_creation(*this, filter, options, list);
    }

    template <class Model, class Options>
    hnav_status make(hnav_filter** filter, const Options& o) const {
        if constexpr (small_build) return fail(HNAV_ERROR_UNSUPPORTED, "the small build takes the caller's memory");
        else {
            const Frames frames = frames_of(o);
            const Model model(o, frames);
            const auto settings = settings_of<Model>(o);
            if (const hnav_status status = check_memory(*this, model, settings, o.queue_capacity)) return status;
            *filter = AttitudeFilter<Model>::make(model, frames, hold_of(o), settings);
            return *filter
                       ? HNAV_OK
                       : fail(HNAV_ERROR_OUT_OF_MEMORY, "no memory for a filter with queue_capacity = %d", int(o.queue_capacity));
        }
    }

    // In memory of the caller with this size.
    template <class Model, class Options>
    hnav_status make_in(void* memory, std::size_t bytes, hnav_filter** filter, const Options& o) const {
        if (!memory) return fail(HNAV_ERROR_NULL_ARGUMENT, "memory is null");
        if (o.solver != HNAV_SOLVER_CLOSED_FORM)
            return fail(HNAV_ERROR_UNSUPPORTED, "the caller's memory supports solver = closed_form only");
        const Frames frames = frames_of(o);
        const Model model(o, frames);
        const auto settings = settings_of<Model>(o);
        const std::size_t needed = AttitudeFilter<Model>::bytes(model, settings);
        if (bytes < needed)
            return fail(HNAV_ERROR_SIZE, "memory has %zu bytes, a filter with queue_capacity = %d needs %zu", bytes,
                        int(o.queue_capacity), needed);
        *filter = AttitudeFilter<Model>::make_in(memory, model, frames, hold_of(o), settings);
        return HNAV_OK;
    }

    // Bytes for make_in; 0 for invalid options.
    template <class Model, class Options>
    std::size_t bytes_for(const Options* o) const {
        hnav_filter* none;
        return check(&none, o) == HNAV_OK ? AttitudeFilter<Model>::bytes(Model(), settings_of<Model>(*o)) : 0;
    }

private:
    template <class Model, class Options>
    auto settings_of(const Options& o) const {
        return engine_settings<Model>(o, list);
    }
};

} // namespace hnav
