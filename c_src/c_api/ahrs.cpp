// Options of the AHRS, and the filter made from them.
#include "attitude/ahrs/model.hpp"
#include "c_api/creation.hpp"

using hnav::AhrsModel;

extern "C" {

hnav_ahrs_options hnav_ahrs_defaults(hnav_preset preset) {
    return hnav::made_from<hnav_ahrs_options>(hnav::ahrs_options, preset);
}

hnav_status hnav_ahrs_create(hnav_filter** filter, const hnav_ahrs_options* options, char* message, size_t message_size) {
    const hnav::Creation creation{{message, message_size}, hnav::ahrs_options};
    const hnav_status status = creation.check(filter, options);
    return status == HNAV_OK ? creation.make<AhrsModel>(filter, *options) : status;
}

size_t hnav_ahrs_memory_bytes(const hnav_ahrs_options* options) {
    return hnav::Creation{{nullptr, 0}, hnav::ahrs_options}.bytes_for<AhrsModel>(options);
}

hnav_status hnav_ahrs_create_in(void* memory, size_t bytes, hnav_filter** filter, const hnav_ahrs_options* options, char* message,
                                size_t message_size) {
    const hnav::Creation creation{{message, message_size}, hnav::ahrs_options};
    const hnav_status status = creation.check(filter, options);
    return status == HNAV_OK ? creation.make_in<AhrsModel>(memory, bytes, filter, *options) : status;
}

} // extern "C"
