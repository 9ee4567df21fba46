// The C boundary of the observer of an FMU.
#include "c_api/observer.hpp"

#include "base/hash.hpp"
#include "c_api/sized.hpp"
#include "observer/plan.hpp"
#include "options/lists.hpp"

#ifdef HNAV_FMU_PLANTS
#include "observer/live_plants.hpp"
#endif

#include <algorithm>

namespace {

#ifdef HNAV_FMU_PLANTS

// Entries that are not null replace those of the plan.
void replace(hnav::observer::Plan& plan, const hnav_observer_statistics& known) {
    const hnav::observer::PlantSizes& sizes = plan.sizes;
    const auto take = [](const double* from, int count, double* to) {
        if (from) std::copy_n(from, count, to);
    };
    take(known.start, sizes.estimated(), plan.start);
    take(known.start_sigma, sizes.estimated(), plan.start_sigma);
    take(known.noise, sizes.estimated(), plan.noise);
    take(known.nominal, sizes.estimated(), plan.nominal);
    take(known.ready_sigma, sizes.estimated(), plan.ready_sigma);
    take(known.time_constant_s, sizes.unknown_inputs, plan.time_constant_s);
    take(known.input_start, sizes.known_inputs(), plan.input_start);
    take(known.sensor_sigma, sizes.outputs, plan.sensor_sigma);
    take(known.gate_nis, sizes.outputs, plan.gate_nis);
    take(known.min, sizes.estimated(), plan.min);
    take(known.max, sizes.estimated(), plan.max);
    if (known.logarithmic) std::copy_n(known.logarithmic, sizes.parameters, plan.logarithmic);
}

// Settings of a plan that are not in Problem.
std::uint64_t fingerprint_of(const hnav::observer::Plan& plan, std::uint64_t start) {
    std::uint64_t sum = hnav::hash(plan.token, sizeof plan.token, start);
    sum = hnav::hash(plan.set_value, plan.set_count * sizeof(double), sum);
    sum = hnav::hash(plan.sensor, plan.sizes.outputs * sizeof(std::uint32_t), sum);
    return hnav::hash(plan.parameter, plan.sizes.parameters * sizeof(std::uint32_t), sum);
}

hnav_status open(hnav_filter** filter, const hnav_observer_options& options, const char* folder,
                 const hnav_observer_statistics& known, hnav::observer::Plan& plan, const hnav::CallersMessage& caller) {
    hnav::Refusal why;
    if (!plan.read(folder, why) || !hnav::observer::Problem::sizes_fit(plan.sizes, why)) return caller.refuse(why);
    replace(plan, known);
    auto* plant = hnav::observer::open_beside_others(folder, plan, options.start_time_s, why);
    if (!plant) return caller.refuse(why);
    const std::uint64_t fingerprint = fingerprint_of(plan, hnav::fingerprint(hnav::observer_options, &options));
    return hnav::make_observer(filter, options, plant, plan.statistics(), fingerprint, caller);
}

#else

hnav_status open(hnav_filter**, const hnav_observer_options&, const char*, const hnav_observer_statistics&, hnav::observer::Plan&,
                 const hnav::CallersMessage& caller) {
    return caller.fail(HNAV_ERROR_UNSUPPORTED, "this library was built without the headers of FMI (HNAV_FMI_HEADERS)");
}

#endif

} // namespace

extern "C" {

hnav_status hnav_observer_open(hnav_filter** filter, const hnav_observer_options* options, const char* folder, char* message,
                               size_t message_size) {
    const auto none = hnav_sized<hnav_observer_statistics>();
    return hnav_observer_open_known(filter, options, folder, &none, message, message_size);
}

hnav_status hnav_observer_open_known(hnav_filter** filter, const hnav_observer_options* options, const char* folder,
                                     const hnav_observer_statistics* known, char* message, size_t message_size) {
    const hnav::CallersMessage caller{message, message_size};
    if (const hnav_status status = caller.begin(filter, "filter", {{options, "options"}, {folder, "folder"}, {known, "known"}}))
        return status;
    if (const hnav_status status = hnav::check_size(caller, *known, "known", "hnav_observer_statistics")) return status;
    if (const hnav_status status = caller.check_options(options, hnav::observer_options)) return status;
    auto* plan = hnav::make_object<hnav::observer::Plan>();
    if (!plan) return caller.fail(HNAV_ERROR_OUT_OF_MEMORY, "no memory for a plan");
    const hnav_status status = open(filter, *options, folder, hnav::take_in(*known), *plan, caller);
    hnav::destroy_object(plan);
    return status;
}

} // extern "C"
