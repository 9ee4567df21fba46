// Options of the paper's filter, and the filter made from them.
#include "attitude/hrekf/model.hpp"
#include "c_api/creation.hpp"

#include <cmath>

using hnav::HrekfModel;

namespace {

// The model's enumerations are the API's, one to one.
static_assert(int(hnav::GammaMode::kl) == HNAV_GAMMA_KL && int(hnav::GammaMode::relative) == HNAV_GAMMA_RELATIVE);
static_assert(int(hnav::Adaptation::corrected) == HNAV_ADAPTATION_CORRECTED);
static_assert(int(hnav::StartMode::heading) == HNAV_START_HEADING);

// Conditions on several fields follow those on single fields.
hnav_status check(const hnav::Creation& creation, hnav_filter** filter, const hnav_hrekf_options* options) {
    const hnav_status status = creation.check(filter, options);
    if (status == HNAV_OK && options->adaptation_min_rad_s_per_sqrt_s > options->adaptation_max_rad_s_per_sqrt_s)
        return creation.fail(HNAV_ERROR_OPTION, "adaptation_min_rad_s_per_sqrt_s exceeds adaptation_max_rad_s_per_sqrt_s");
    return status;
}

} // namespace

extern "C" {

hnav_hrekf_options hnav_hrekf_defaults(hnav_preset preset) {
    return hnav::made_from<hnav_hrekf_options>(hnav::hrekf_options, preset);
}

hnav_status hnav_hrekf_create(hnav_filter** filter, const hnav_hrekf_options* options, char* message, size_t message_size) {
    const hnav::Creation creation{{message, message_size}, hnav::hrekf_options};
    const hnav_status status = check(creation, filter, options);
    return status == HNAV_OK ? creation.make<HrekfModel>(filter, *options) : status;
}

size_t hnav_hrekf_memory_bytes(const hnav_hrekf_options* options) {
    return hnav::Creation{{nullptr, 0}, hnav::hrekf_options}.bytes_for<HrekfModel>(options);
}

hnav_status hnav_hrekf_create_in(void* memory, size_t bytes, hnav_filter** filter, const hnav_hrekf_options* options,
                                 char* message, size_t message_size) {
    const hnav::Creation creation{{message, message_size}, hnav::hrekf_options};
    const hnav_status status = check(creation, filter, options);
    return status == HNAV_OK ? creation.make_in<HrekfModel>(memory, bytes, filter, *options) : status;
}

} // extern "C"
