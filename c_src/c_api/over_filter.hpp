// Calls of an object that its Filter<Model> answers. An object overrides those for which it does more.
#pragma once

#include "c_api/filter_object.hpp"
#include "hybrid/filter.hpp"

namespace hnav {

template <class Object, class OfModel>
struct OverFilter : Object {
    using Object::Object;
    using FilterOfModel = Filter<OfModel>;

    void reset() override { filter.reset(); }
    Outcome advance(double t_s) override { return filter.advance(t_s); }
    Outcome commit(double t_s) override { return filter.commit(t_s); }
    double now_s() const override { return filter.now_s(); }

    FilterOfModel filter;

protected:
    ~OverFilter() = default;
};

// Not in the small build. Object: over a filter.
template <class Object>
struct OverWholeFilter : Object {
    using Object::Object, Object::filter;

    std::size_t state_size() const override { return filter.state_size(); }
    void save(void* buffer) const override { filter.save(buffer); }
    LoadOutcome load(const void* buffer, std::size_t bytes) override { return filter.load(buffer, bytes); }
    std::size_t snapshot_size() const override { return filter.snapshot_size(); }
    void take_snapshot(void* buffer) const override { filter.take_snapshot(buffer); }
    bool restore_snapshot(const void* buffer, std::size_t bytes) override { return filter.restore_snapshot(buffer, bytes); }

    int nx() const override { return filter.nx(); }
    void get_x(double* x) const override { filter.get_x(x); }
    void nominal_x(double* x) const override { filter.model().nominal(x); }
    double next_event_s() const override { return filter.next_event_s(); }
    Outcome jump(double t_s, const double* x_minus, double* x_plus) override { return filter.jump(t_s, x_minus, x_plus); }
    void show(double t_s, const double* x) override { filter.show(t_s, x); }

protected:
    ~OverWholeFilter() = default;
};

} // namespace hnav
