// The C boundary of the observer of an FMU.
#include "c_api/observer.hpp"

#include "base/hash.hpp"
#include "observer/plan.hpp"
#include "options/lists.hpp"

#ifdef HNAV_FMU_PLANTS
#include "observer/fmu_plant.hpp"
#endif

namespace {

#ifdef HNAV_FMU_PLANTS

// Of what a plan says and Problem does not know.
std::uint64_t fingerprint_of(const hnav::observer::Plan& plan, std::uint64_t start) {
    std::uint64_t sum = hnav::hash(plan.token, sizeof plan.token, start);
    sum = hnav::hash(plan.set_value, plan.set_count * sizeof(double), sum);
    sum = hnav::hash(plan.sensor, plan.sizes.outputs * sizeof(std::uint32_t), sum);
    return hnav::hash(plan.parameter, plan.sizes.parameters * sizeof(std::uint32_t), sum);
}

hnav_status open(hnav_observer** observer, const hnav_observer_options& options, const char* folder, hnav::observer::Plan& plan,
                 const hnav::CallersMessage& caller) {
    using hnav::observer::FmuPlant;
    hnav::observer::Refusal why;
    if (!plan.read(folder, why) || !hnav::observer::Problem::sizes_fit(plan.sizes, why))
        return caller.fail(hnav::status_of(why), "%s", why.text);
    FmuPlant* plant = FmuPlant::open(folder, plan, options.start_time_s, why);
    if (!plant) return caller.fail(hnav::status_of(why), "%s", why.text);
    // The proof may cost an instance its life: it has its own, where there may be two.
    FmuPlant* prover = plan.once ? plant : FmuPlant::open(folder, plan, options.start_time_s, why);
    if (!prover) prover = plant;
    const std::uint64_t fingerprint = fingerprint_of(plan, hnav::fingerprint(hnav::observer_options, &options));
    const hnav_status status = hnav::make_observer(observer, options, plant, *prover, plan.statistics(), fingerprint, caller);
    if (prover != plant) prover->destroy();
    return status;
}

#else

hnav_status open(hnav_observer**, const hnav_observer_options&, const char*, hnav::observer::Plan&,
                 const hnav::CallersMessage& caller) {
    return caller.fail(HNAV_ERROR_UNSUPPORTED, "this library was built without the headers of FMI (HNAV_FMI_HEADERS)");
}

#endif

} // namespace

extern "C" hnav_status hnav_observer_open(hnav_observer** observer, const hnav_observer_options* options, const char* folder,
                                          char* message, size_t message_size) {
    const hnav::CallersMessage caller{message, message_size};
    caller.clear();
    if (!observer) return caller.fail(HNAV_ERROR_NULL_ARGUMENT, "observer is null");
    *observer = nullptr;
    if (!options) return caller.fail(HNAV_ERROR_NULL_ARGUMENT, "options is null");
    if (!folder) return caller.fail(HNAV_ERROR_NULL_ARGUMENT, "folder is null");
    if (const hnav_status status = caller.check_options(options, hnav::observer_options)) return status;
    auto* plan = hnav::make_object<hnav::observer::Plan>();
    if (!plan) return caller.fail(HNAV_ERROR_OUT_OF_MEMORY, "no memory for a plan");
    const hnav_status status = open(observer, *options, folder, *plan, caller);
    hnav::destroy_object(plan);
    return status;
}
