// The C boundary of every filter's saved states and snapshots.
#include "c_api/filter_object.hpp"
#include "c_api/saved_object.hpp"

using hnav::save_status;

namespace {

hnav_status no_snapshot(const hnav_filter* filter, size_t bytes) {
    return filter->fail(
        HNAV_ERROR_STATE_CORRUPT,
        "these %zu bytes are no snapshot of this filter; of an observer, a snapshot ends with the observer that it was taken of",
        bytes);
}

} // namespace

extern "C" {

hnav_status hnav_filter_state_size(const hnav_filter* filter, size_t* bytes) {
    REQUIRE(filter, bytes);
    *bytes = filter->state_size();
    return HNAV_OK;
}

hnav_status hnav_filter_save(const hnav_filter* filter, void* buffer, size_t bytes) {
    REQUIRE(filter, buffer);
    if (const char* why = filter->cannot_save()) return filter->fail(HNAV_ERROR_UNSUPPORTED, "%s", why);
    if (const hnav_status status = save_status(*filter, bytes, filter->state_size())) return status;
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
    if (const hnav_status status = save_status(*filter, bytes, filter->snapshot_size())) return status;
    filter->take_snapshot(buffer);
    return HNAV_OK;
}

hnav_status hnav_filter_restore_snapshot(hnav_filter* filter, const void* buffer, size_t bytes) {
    REQUIRE(filter, buffer);
    return filter->restore_snapshot(buffer, bytes) ? HNAV_OK : no_snapshot(filter, bytes);
}

hnav_status hnav_filter_release_snapshot(const hnav_filter* filter, const void* buffer, size_t bytes) {
    REQUIRE(filter, buffer);
    return filter->release_snapshot(buffer, bytes) ? HNAV_OK : no_snapshot(filter, bytes);
}

} // extern "C"
