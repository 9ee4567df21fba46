// The C boundary of the observer: outputs and saved states.
#include "c_api/health.hpp"
#include "c_api/observer.hpp"
#include "c_api/sized.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

using hnav::ObserverObject;
using hnav::observer::Layout;

namespace {

hnav_status check_sensor(const ObserverObject* o, int sensor) {
    const int count = o->problem->sensors;
    if (sensor >= 0 && sensor < count) return HNAV_OK;
    return o->fail(HNAV_ERROR_OUT_OF_RANGE, "there is no sensor %d: there are %d", sensor, count);
}

// Header of a snapshot.
struct SnapshotHead {
    std::uint64_t observer, dropped;
};

// For a snapshot of this observer: act receives the header and the following bytes, and returns whether they are complete.
template <class Act>
bool with_snapshot(const ObserverObject* o, const void* buffer, std::size_t bytes, Act&& act) {
    SnapshotHead head{};
    if (bytes > sizeof head) std::memcpy(&head, buffer, sizeof head);
    if (bytes <= sizeof head || head.observer != o->own_number) return false;
    return act(head, static_cast<const unsigned char*>(buffer) + sizeof head, bytes - sizeof head);
}

// The snapshot begins or ends to own the discrete state of the plant.
bool hold_states(const ObserverObject* o, const unsigned char* snapshot, std::size_t bytes, int by) {
    const Layout& at = o->layout();
    return o->filter.visit_snapshot(snapshot, bytes, [&](const hnav::RuntimeState& s) {
        for (int i = 0; i < at.parts; ++i) o->plant->hold(s.x() + i * at.part_numbers + at.memory, by);
    });
}

} // namespace

namespace hnav {

hnav_status ObserverObject::covariance(double* P) const {
    filter.model().estimate(filter.shown(), nullptr, nullptr, P);
    return HNAV_OK;
}

void ObserverObject::diagnostics(hnav_diagnostics* out) const {
    out->gamma_used = out->gamma_margin = out->mean_nis = out->gyro_vibration_rad_s = out->accel_vibration_m_s2 = std::nan("");
    diagnose(filter, out);
    out->corrections = static_cast<std::uint64_t>(number(layout().corrections));
    out->started = number(layout().begun) != 0;
}

void ObserverObject::health(hnav_health* out) const {
    for (hnav_sensor_health& h : out->sensor) h = sensor_without_samples();
    out->stamps_left_out = filter.stamps().left_out();
    out->clock_jumps = filter.stamps().jumps();
}

const char* ObserverObject::cannot_save() const {
    return plant->memory_lasts()
               ? nullptr
               : "the plant cannot write down what it remembers (canSerializeFMUstate): its observer cannot be saved, but for a "
                 "snapshot in this process; export the plant with it";
}

std::size_t ObserverObject::snapshot_size() const { return sizeof(SnapshotHead) + filter.snapshot_size(); }

void ObserverObject::take_snapshot(void* buffer) const {
    const std::size_t inside = filter.snapshot_size();
    const SnapshotHead head{own_number, dropped};
    auto* place = static_cast<unsigned char*>(buffer) + sizeof head;
    std::memcpy(buffer, &head, sizeof head);
    filter.take_snapshot(place);
    hold_states(this, place, inside, 1);
}

bool ObserverObject::restore_snapshot(const void* buffer, std::size_t bytes) {
    return with_snapshot(this, buffer, bytes, [this](const SnapshotHead& head, const unsigned char* snapshot, std::size_t size) {
        const bool whole = filter.restore_snapshot(snapshot, size);
        if (whole) dropped = head.dropped;
        return whole;
    });
}

bool ObserverObject::release_snapshot(const void* buffer, std::size_t bytes) const {
    return with_snapshot(this, buffer, bytes, [this](const SnapshotHead&, const unsigned char* snapshot, std::size_t size) {
        return hold_states(this, snapshot, size, -1);
    });
}

} // namespace hnav

extern "C" {

hnav_status hnav_observer_estimate(const hnav_filter* handle, double* x, double* sigma) {
    REQUIRE_OBJECT(const ObserverObject, observer, handle);
    observer->filter.model().estimate(observer->filter.shown(), x, sigma, nullptr);
    return HNAV_OK;
}

hnav_status hnav_observer_posterior(const hnav_filter* handle, double* x, double* sigma) {
    REQUIRE_OBJECT(const ObserverObject, observer, handle);
    observer->filter.model().estimate(observer->filter.newest(), x, sigma, nullptr);
    return HNAV_OK;
}

hnav_status hnav_observer_innovation(const hnav_filter* handle, int32_t sensor, hnav_observer_innovation_of* out) {
    REQUIRE_OBJECT(const ObserverObject, observer, handle);
    REQUIRE_STRUCT(observer, out, hnav_observer_innovation_of);
    if (const hnav_status status = check_sensor(observer, sensor)) return status;
    const auto number = [&](Layout::OfSensor what) { return observer->number(observer->layout().of_sensor(sensor, what)); };
    if (number(Layout::samples) == 0) return observer->fail(HNAV_ERROR_NO_DATA, "no sample of sensor %d yet", sensor);
    hnav_observer_innovation_of result{};
    result.innovation = number(Layout::innovation);
    result.sigma = number(Layout::innovation_sigma);
    result.nis = number(Layout::nis);
    result.mean_nis = number(Layout::mean_nis);
    result.samples = static_cast<std::uint64_t>(number(Layout::samples));
    result.inflated = static_cast<std::uint64_t>(number(Layout::gated));
    return hnav::hand_out(result, out);
}

hnav_status hnav_observer_get_info(const hnav_filter* handle, hnav_observer_info* info) {
    REQUIRE_OBJECT(const ObserverObject, observer, handle);
    REQUIRE_STRUCT(observer, info, hnav_observer_info);
    const auto& filter = observer->filter;
    const Layout& at = observer->layout();
    hnav_observer_info result{};
    result.n_estimated = observer->problem->N;
    result.begun = observer->number(at.begun) != 0;
    result.ready = filter.model().ready(filter.shown());
    result.repeatable = observer->proof.repeatable;
    result.now_s = filter.now_s();
    result.newest_s = filter.newest_s();
    result.late_limit_s = filter.late_limit_s();
    result.events = static_cast<std::uint64_t>(observer->number(at.events));
    result.corrections = static_cast<std::uint64_t>(observer->number(at.corrections));
    result.late = filter.refused.late;
    result.non_finite = filter.refused.non_finite;
    result.dropped = observer->dropped;
    result.flow_evaluations = filter.propagator().rhs_evals();
    result.steps = filter.propagator().steps();
    const auto parts = filter.model().parts(filter.shown());
    const auto count = [&](Layout::Counts what) { return static_cast<std::uint64_t>(observer->number(at.counts + what)); };
    result.parts = parts.count;
    result.largest_part = parts.largest;
    result.plant_events = static_cast<std::uint64_t>(parts.events);
    result.splits = count(Layout::splits);
    result.grazing = count(Layout::grazing);
    result.chattering = count(Layout::chattering);
    result.projected = count(Layout::projected);
    result.crosses = filter.model().crosses();
    result.n_indicators = observer->problem->sizes.indicators;
    for (int i = 0; i < observer->problem->sensors; ++i) {
        result.outliers += filter.model().check(filter.newest(), i).outliers;
        result.stuck += filter.model().check(filter.newest(), i).stuck;
    }
    result.stamps_left_out = filter.stamps().left_out();
    result.clock_jumps = filter.stamps().jumps();
    result.held = count(Layout::holding);
    return hnav::hand_out(result, info);
}

hnav_status hnav_observer_proof(const hnav_filter* handle, hnav_plant_block block, hnav_observer_block_proof* proof) {
    REQUIRE_OBJECT(const ObserverObject, observer, handle);
    REQUIRE_STRUCT(observer, proof, hnav_observer_block_proof);
    using hnav::observer::functions;
    using hnav::observer::variables;
    const int index = static_cast<int>(block);
    if (index < 0 || index >= functions * variables)
        return observer->fail(HNAV_ERROR_OUT_OF_RANGE, "there is no block %d of derivatives", index);
    const hnav::observer::BlockProof& found = observer->proof.block[index / variables][index % variables];
    hnav_observer_block_proof result{};
    result.offered = found.offered;
    result.exact = found.exact;
    result.row = found.row;
    result.column = found.column;
    result.stated = found.stated;
    result.measured = found.measured;
    return hnav::hand_out(result, proof);
}

} // extern "C"
