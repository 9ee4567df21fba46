// The calls of hnav_filter that the FMUs of all filters share.
#pragma once

#include "adapter/library_model.hpp"
#include "hnav/filter.h"

namespace hnav::fmu {

// Saving, loading and measuring the state that an FMU keeps for its importer: a saved state or a snapshot.
template <hnav_status (*size)(const hnav_filter*, std::size_t*), hnav_status (*keep)(const hnav_filter*, void*, std::size_t),
          hnav_status (*bring_back)(hnav_filter*, const void*, std::size_t)>
struct FilterCalls : LibraryObject<hnav_filter, hnav_filter_destroy, hnav_filter_message, size, keep, bring_back> {
    static constexpr auto reset = hnav_filter_reset;
    static constexpr auto get_x = hnav_filter_get_x;
    static constexpr auto nominal_x = hnav_filter_nominal_x;
    static constexpr auto derivative = hnav_filter_derivative;
    static constexpr auto next_event_s = hnav_filter_next_event_s;
    static constexpr auto jump = hnav_filter_jump;
    static constexpr auto show = hnav_filter_show;
};

} // namespace hnav::fmu
