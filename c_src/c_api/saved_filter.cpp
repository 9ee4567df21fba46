// The C boundary of an attitude filter's saved states and snapshots.
#include "c_api/attitude_filter.hpp"
#include "c_api/message.hpp"

extern "C" {

hnav_status hnav_filter_state_size(const hnav_filter* filter, size_t* bytes) {
    REQUIRE(filter, bytes);
    *bytes = filter->state_size();
    return HNAV_OK;
}

hnav_status hnav_filter_save(const hnav_filter* filter, void* buffer, size_t bytes) {
    REQUIRE(filter, buffer);
    if (const hnav_status status = hnav::save_status(*filter, bytes, filter->state_size())) return status;
    filter->save(buffer);
    return HNAV_OK;
}

hnav_status hnav_filter_load(hnav_filter* filter, const void* buffer, size_t bytes) {
    REQUIRE(filter, buffer);
    return hnav::load_status(*filter, filter->load(buffer, bytes), "filter", bytes, filter->state_size());
}

hnav_status hnav_filter_snapshot_size(const hnav_filter* filter, size_t* bytes) {
    REQUIRE(filter, bytes);
    *bytes = filter->snapshot_size();
    return HNAV_OK;
}

hnav_status hnav_filter_take_snapshot(const hnav_filter* filter, void* buffer, size_t bytes) {
    REQUIRE(filter, buffer);
    if (const hnav_status status = hnav::save_status(*filter, bytes, filter->snapshot_size())) return status;
    filter->take_snapshot(buffer);
    return HNAV_OK;
}

hnav_status hnav_filter_restore_snapshot(hnav_filter* filter, const void* buffer, size_t bytes) {
    REQUIRE(filter, buffer);
    if (filter->restore_snapshot(buffer, bytes)) return HNAV_OK;
    return filter->fail(HNAV_ERROR_STATE_CORRUPT, "these %zu bytes are no snapshot of a filter with such options", bytes);
}

} // extern "C"
