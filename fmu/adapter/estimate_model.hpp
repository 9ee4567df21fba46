// A model around a library object whose estimate changes between samples: its sampled inputs and Model Exchange. Shared by
// the FMUs of all filters.
#pragma once

#include "adapter/library_model.hpp"
#include "adapter/sampled_inputs.hpp"

namespace hnav::fmu {

// State of such a model beside the library object; derived models extend it.
template <int inputs>
struct EstimateMemory {
    SampledInputs<inputs> sampled;
    double model_exchange;
    double reset_level;
    double was_reset; // in Model Exchange: the importer's states are still to be
};

// Calls: a LibraryObject and beside it the calls reset, get_x, nominal_x, derivative, next_event_s, jump and show of the object.
// Memory: an EstimateMemory.
template <class Calls, class Memory>
class EstimateModel : public LibraryModel<Model, Calls, Memory> {
public:
    double next_sample_s(const double*) const final {
        // In Model Exchange a sample with a time stamp in the future is processed at that time.
        return std::fmin(memory_.model_exchange != 0 ? next_event_s() : no_bound, memory_.sampled.next_s());
    }
    bool can_hold() const final { return true; }
    double next_sample_inside_s(double end_s) const final { return memory_.sampled.next_inside_s(end_s); }

    void get_states(double* x) const final { Calls::get_x(object_, x); }
    void get_nominals(double* nominals) const final { Calls::nominal_x(object_, nominals); }
    bool derivatives(double t_s, const double* x, double* dx) const final {
        return Calls::derivative(object_, t_s, x, dx) == HNAV_OK;
    }
    void show(double t_s, const double* x) final { Calls::show(object_, t_s, x); }
    bool jump(double t_s, double* x, bool* changed, Message* why) override {
        if (memory_.was_reset != 0) {
            Calls::get_x(object_, x);
            memory_.was_reset = 0;
            *changed = true;
        }
        if (!event_due(t_s)) return true;
        *changed = true;
        return goes_on(Calls::jump(object_, t_s, x, x), why);
    }

protected:
    using LibraryModel<Model, Calls, Memory>::object_;
    using LibraryModel<Model, Calls, Memory>::memory_;

    // Whether the simulation may continue after this status of a call.
    virtual bool goes_on(hnav_status status, Message* why) { return this->done(status, why); }

    virtual bool event_due(double t_s) const { return next_event_s() <= t_s + time_tolerance(t_s, min_period_s); }

    // The input `reset`; true at its rising edge.
    bool take_reset(double level) { return rising(level, &memory_.reset_level) && restart(); }
    bool restart() {
        Calls::reset(object_);
        memory_.was_reset = memory_.model_exchange;
        return true;
    }

    // Status of a push call. The object refuses and counts invalid samples; the simulation continues.
    void pushed(hnav_status status) {
        if (status == HNAV_ERROR_QUEUE_FULL) memory_.sampled.missed += 1;
        this->note_refusal(status);
    }

private:
    double next_event_s() const {
        double next_s = no_bound;
        Calls::next_event_s(object_, &next_s);
        return next_s;
    }
};

} // namespace hnav::fmu
