// The object behind hnav_filter: the interface of the calls in hnav/filter.h for any filter. They check their arguments and write
// messages (filter.cpp, filter_hybrid.cpp, filter_saved.cpp); the calls of one product find their own object by object_of.
#pragma once

#include "base/saved_state.hpp"
#include "base/small.hpp"
#include "c_api/message.hpp"
#include "hnav/filter.h"
#include "hybrid/outcome.hpp"

#include <cmath>

namespace hnav {

enum class Product { attitude, ins, observer };

// Largest number of values of a sample of hnav_sensor: those of a fix and their sigmas.
constexpr int max_values = 6;

struct EveryObject : KeptMessage<512> {
    explicit EveryObject(Product p) : product(p) {}
    const Product product;

    virtual void destroy() = 0;
    virtual void reset() = 0;

    // sensor: hnav_sensor. Refuses with a message what the filter does not take.
    virtual hnav_status take(int sensor, double t_s, const double* value) = 0;
    virtual hnav_status take_imu(double t_s, const double* rate, const double* force) = 0;

    virtual Outcome advance(double t_s) = 0;
    virtual Outcome commit(double t_s) = 0;
    virtual double now_s() const = 0;
    // Writes the reason why samples up to t_s were dropped.
    virtual hnav_status no_estimate(double t_s) const {
        return fail(HNAV_ERROR_SOLVER, "samples up to t = %.9g s led to no usable estimate and were dropped", t_s);
    }

    virtual hnav_status attitude(hnav_attitude* out) const = 0;
    virtual hnav_status rate(double* rate_b) const = 0;
    virtual hnav_status gyro_bias(double* bias_b, double* sigma) const = 0;
    virtual hnav_status covariance(double* P) const = 0;
    virtual hnav_status innovation(int sensor, hnav_innovation* out) const = 0;
    virtual void diagnostics(hnav_diagnostics* out) const = 0;
    virtual void health(hnav_health* out) const = 0;

    hnav_status unsupported(const char* what) const { return fail(HNAV_ERROR_UNSUPPORTED, "this filter has no %s", what); }

protected:
    ~EveryObject() = default; // not destroyed through the base: see destroy()
};

// Not in the small build: saved states, and an integrator of the caller.
struct WholeObject : EveryObject {
    using EveryObject::EveryObject;

    virtual const char* cannot_save() const { return nullptr; } // reason, or null
    virtual std::size_t state_size() const = 0;
    virtual void save(void* buffer) const = 0;
    virtual LoadOutcome load(const void* buffer, std::size_t bytes) = 0;
    virtual std::size_t snapshot_size() const = 0;
    virtual void take_snapshot(void* buffer) const = 0;
    virtual bool restore_snapshot(const void* buffer, std::size_t bytes) = 0;
    virtual bool release_snapshot(const void*, std::size_t) const { return true; }

    virtual int nx() const = 0;
    virtual int quaternion_at() const { return -1; } // place of an attitude in x; -1: it has none
    virtual void get_x(double* x) const = 0;
    virtual void nominal_x(double* x) const = 0;
    virtual hnav_status derivative(const double* x, double* dx) const = 0;
    virtual hnav_status derivative_along(const double* x, const double* seed, double* out) const = 0;
    virtual double next_event_s() const = 0;
    virtual const char* cannot_jump() const { return nullptr; }
    virtual Outcome jump(double t_s, const double* x_minus, double* x_plus) = 0;
    virtual void show(double t_s, const double* x) = 0;

protected:
    ~WholeObject() = default;
};

constexpr double max_time_s = 1e12; // beyond this, intervals overflow in a covariance
// Chosen: 95 000 turns a minute, above every body that carries a gyroscope. The cost of an interval grows with the rate, so a
// limit on the rate bounds the time of a call.
constexpr double max_rate_rad_s = 1e4;
constexpr double near_singular_pitch = 85 * M_PI / 180; // beyond this, roll and yaw are hardly distinct
const char* sensor_name(int sensor); // in messages

// What every innovation has.
template <class Innovation>
void fill_innovation(const Innovation& i, double stamp_s, hnav_innovation* out) {
    out->t_s = stamp_s;
    for (int k = 0; k < 3; ++k) out->value[k] = i.value[k];
    out->nis = i.nis;
    out->noise_scale = i.noise_scale;
    out->dimension = static_cast<int32_t>(i.dimension);
    out->accepted = !(i.noise_scale > 1);
}

// Times nearer to 0 than a picosecond are set to 0: elsewhere the spacing of doubles is larger, and here a difference of two
// times may be too small as a divisor.
inline double clock_time(double t_s) { return std::fabs(t_s) < 1e-12 ? 0 : t_s; }

inline hnav_status check_time(const EveryObject* f, double t_s) {
    if (std::fabs(t_s) <= max_time_s) return HNAV_OK;
    if (!std::isfinite(t_s)) return f->fail(HNAV_ERROR_NON_FINITE, "t_s = %g is not finite", t_s);
    return f->fail(HNAV_ERROR_OUT_OF_RANGE, "t_s = %g lies beyond %g s", t_s, max_time_s);
}

// Outcome of an advance to t_s.
inline hnav_status advanced(const EveryObject* f, double t_s, Outcome outcome) {
    switch (outcome) {
    case Outcome::ok: return HNAV_OK;
    case Outcome::backwards:
        return f->fail(HNAV_ERROR_TIME_BACKWARDS, "t_s = %.9g s is before the last advance to %.9g s", t_s, f->now_s());
    default: return f->no_estimate(t_s);
    }
}

// Outcome of pushing a sample into the queue.
inline hnav_status queued(const EveryObject* f, Outcome outcome, const char* what, double t_s, double late_limit_s) {
    switch (outcome) {
    case Outcome::ok: return HNAV_OK;
    case Outcome::late:
        return f->fail(HNAV_ERROR_LATE_SAMPLE,
                       "%s sample at t = %.9g s is late: samples before %.9g s are closed, a longer horizon_s admits them", what,
                       t_s, late_limit_s);
    default:
        return f->fail(HNAV_ERROR_QUEUE_FULL,
                       "the queue is full: advance before pushing the %s sample at t = %.9g s, or raise queue_capacity", what,
                       t_s);
    }
}

} // namespace hnav

struct hnav_filter : std::conditional_t<hnav::small_build, hnav::EveryObject, hnav::WholeObject> {
    using Base = std::conditional_t<hnav::small_build, hnav::EveryObject, hnav::WholeObject>;
    using Base::Base;

protected:
    ~hnav_filter() = default;
};

namespace hnav {

// The object of a product behind the handle; null, with a message, for another product. Object: const or not, as the handle.
template <class Object, class Handle>
Object* object_of(Handle* filter) {
    if (filter->product == Object::of_product) return static_cast<Object*>(filter);
    filter->fail(HNAV_ERROR_UNSUPPORTED, "this call is for %s", Object::whom);
    return nullptr;
}

} // namespace hnav

// Declares `object`, the Object behind the handle `filter`.
#define REQUIRE_OBJECT(Object, object, filter)                                                                                   \
    if (!(filter)) return HNAV_ERROR_NULL_ARGUMENT;                                                                              \
    auto* const object = hnav::object_of<Object>(filter);                                                                        \
    if (!(object)) return HNAV_ERROR_UNSUPPORTED
