// The C boundary of the observer: arrays, and their smoother.
#include "c_api/arrays.hpp"
#include "c_api/observer.hpp"
#include "c_api/sized.hpp"
#include "observer/smoother.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

using hnav::ObserverObject;
using hnav::row;
using hnav::observer::Layout;
using hnav::observer::Smoother;

namespace {

using Inputs = hnav_observer_run_input;
using Outputs = hnav_observer_run_output;

// Bits of hnav_observer_run_output.failed.
constexpr unsigned was_dropped = 1, was_held = 2;

void write_row(const ObserverObject& o, const double* sensors, unsigned failed, const Outputs& out, std::size_t i) {
    const int N = o.problem->N, m = o.problem->sensors;
    const bool used = (failed & was_dropped) == 0;
    o.filter.model().estimate(o.filter.shown(), row(out.x, i, N), row(out.sigma, i, N), row(out.covariance, i, N * N));
    if (out.parts || out.plant_events) {
        const auto parts = o.filter.model().parts(o.filter.shown());
        if (out.parts) out.parts[i] = static_cast<std::uint8_t>(parts.count);
        if (out.plant_events) out.plant_events[i] = parts.mean_events;
    }
    if (out.failed) out.failed[i] = static_cast<std::uint8_t>(failed);
    if (out.ready) out.ready[i] = o.filter.model().ready(o.filter.shown());
    if (out.log_likelihood) {
        const bool corrected = used && std::any_of(sensors, sensors + m, [](double y) { return !std::isnan(y); });
        out.log_likelihood[i] = corrected ? o.number(o.layout().likelihood) : std::nan("");
    }
    const struct {
        double* rows;
        Layout::OfSensor what;
    } wanted[] = {{out.innovation, Layout::innovation}, {out.innovation_sigma, Layout::innovation_sigma}, {out.nis, Layout::nis}};
    for (const auto& w : wanted)
        for (int k = 0; w.rows && k < m; ++k)
            row(w.rows, i, m)[k] = used && !std::isnan(sensors[k]) ? o.number(o.layout().of_sensor(k, w.what)) : std::nan("");
}

// NaN is no sample; any: whether there is one.
hnav_status push_row(ObserverObject* o, const Inputs& in, std::size_t i, bool* any) {
    const auto push = [&](auto* push_one, const double* values, int count) {
        for (int k = 0; values && k < count; ++k) {
            const double value = values[i * count + k];
            if (std::isnan(value)) continue;
            *any = true;
            if (const hnav_status status = push_one(o, k, in.t_s[i], value)) return status;
        }
        return HNAV_OK;
    };
    const hnav_status status = push(hnav_observer_push_input, in.inputs, o->problem->known);
    return status ? status : push(hnav_observer_push, in.sensors, o->problem->sensors);
}

// Advances to the time of a row whose samples have been pushed.
hnav_status advance_row(ObserverObject* o, double t_s, bool any) {
    if (const hnav_status status = hnav::check_time(o, t_s)) return status;
    const double at_s = hnav::clock_time(t_s);
    return hnav::advanced(o, t_s, any ? o->moved([&] { return o->filter.advance_row(at_s); }) : o->advance(at_s));
}

// A row without a sample also becomes an instant.
bool push_nothing(ObserverObject* o, double t_s) {
    const double nothing = 0;
    const auto& model = o->filter.model();
    return model.flows(o->filter.newest()) && o->filter.push({t_s, model.start_channel(), &nothing}) == hnav::Outcome::ok;
}

hnav_status solve_row(ObserverObject* o, const Inputs& in, std::size_t i, bool every_row, unsigned* failed) {
    bool any = false;
    hnav_status status = push_row(o, in, i, &any);
    if (every_row && status == HNAV_OK && !any) any = push_nothing(o, in.t_s[i]);
    const std::uint64_t dropped = o->dropped;
    const double held = o->held();
    if (status == HNAV_OK || status == HNAV_ERROR_LATE_SAMPLE) status = advance_row(o, in.t_s[i], any);
    *failed = (o->dropped != dropped ? was_dropped : 0) + (o->held() > held ? was_held : 0);
    return status;
}

// Runs all rows; smoother (may be null) records each.
hnav_status run_rows(ObserverObject* o, std::size_t n, const Inputs& in, const Outputs& out, size_t* rows_done,
                     Smoother* smoother) {
    char first_trouble[sizeof o->message] = "";
    for (std::size_t i = 0; i < n; ++i) {
        unsigned failed = 0;
        const hnav_status status = solve_row(o, in, i, smoother != nullptr, &failed);
        if (status == HNAV_ERROR_TIME_BACKWARDS)
            return o->fail(status, "row %zu: t_s = %.9g s is before %.9g s: sort the rows by it", i, in.t_s[i], o->now_s());
        if (status != HNAV_OK && status != HNAV_ERROR_SOLVER) return hnav::in_row(o, status, i);
        if ((status == HNAV_ERROR_SOLVER || (failed & was_held)) && !*first_trouble) std::strcpy(first_trouble, o->message);
        write_row(*o, in.sensors + i * o->problem->sensors, failed, out, i);
        if (smoother) smoother->note(i, o->filter.model(), o->filter.newest());
        if (rows_done) *rows_done = i + 1;
    }
    if (*first_trouble) std::strcpy(o->message, first_trouble);
    return HNAV_OK;
}

// Rows before the start stay those of the filter. Ready: the filter was ready at this row or a later one.
void go_back(const ObserverObject& o, std::size_t n, Smoother& smoother, double* P, const Outputs& out) {
    const int N = o.problem->N;
    double* X = P + N * N;
    bool ready = false;
    for (std::size_t i = n; i-- > 0;) {
        if (out.ready) out.ready[i] = ready = ready || out.ready[i];
        if (!smoother.go_back_to(i)) return;
        std::copy_n(smoother.X, N, X);
        std::copy_n(smoother.P, N * N, P);
        o.filter.model().finish(X, P);
        if (out.x) std::copy_n(X, N, row(out.x, i, N));
        if (out.covariance) std::copy_n(P, N * N, row(out.covariance, i, N * N));
        for (int k = 0; out.sigma && k < N; ++k) row(out.sigma, i, N)[k] = std::sqrt(std::max(0.0, P[k * N + k]));
    }
}

// The holders of both observers.
struct Both {
    const ObserverObject *one, *other;

    static void each(const void* context, void (*seen)(void*, const double*), void* visitor) {
        const auto* both = static_cast<const Both*>(context);
        for (const ObserverObject* o : {both->one, both->other}) hnav::each_holder(o, seen, visitor);
    }
};

// An observer of the same plant whose states have joint moments, from its start, for one recording.
class Twin {
public:
    explicit Twin(ObserverObject* of) : of_(of), twin_(hnav::make_object<ObserverObject>()), both_{of, twin_} {}
    ~Twin() {
        if (!twin_) return;
        of_->plant->set_holders({of_, hnav::each_holder});
        twin_->plant = nullptr; // not its own
        twin_->destroy();
    }
    Twin(const Twin&) = delete;
    Twin& operator=(const Twin&) = delete;

    hnav_status make() {
        if (!twin_) return of_->fail(HNAV_ERROR_OUT_OF_MEMORY, "no memory for a smoother");
        const hnav_status status = hnav::make_beside(*of_, twin_, {of_->message, sizeof of_->message});
        if (status == HNAV_OK) of_->plant->set_holders({&both_, Both::each});
        return status;
    }
    ObserverObject* operator->() const { return twin_; }
    ObserverObject* get() const { return twin_; }

private:
    ObserverObject *of_, *twin_;
    Both both_;
};

hnav_status check_arrays(const ObserverObject* o, std::size_t n, const Inputs* input, const Outputs* output) {
    REQUIRE_STRUCT(o, input, hnav_observer_run_input);
    REQUIRE_STRUCT(o, output, hnav_observer_run_output);
    if (n > 0) {
        REQUIRE(o, input->t_s);
        REQUIRE(o, input->sensors);
    }
    return HNAV_OK;
}

} // namespace

extern "C" {

hnav_status hnav_observer_run(hnav_filter* handle, size_t n, const hnav_observer_run_input* input,
                              const hnav_observer_run_output* output, size_t* rows_done) {
    if (rows_done) *rows_done = 0;
    REQUIRE_OBJECT(ObserverObject, observer, handle);
    if (const hnav_status status = check_arrays(observer, n, input, output)) return status;
    return run_rows(observer, n, hnav::take_in(*input), hnav::take_in(*output), rows_done, nullptr);
}

hnav_status hnav_observer_smooth(hnav_filter* handle, size_t n, const hnav_observer_run_input* input,
                                 const hnav_observer_run_output* output) {
    REQUIRE_OBJECT(ObserverObject, observer, handle);
    if (const hnav_status status = check_arrays(observer, n, input, output)) return status;
    const Outputs out = hnav::take_in(*output);
    Twin twin(observer);
    if (const hnav_status status = twin.make()) return status;
    const int N = observer->problem->N;
    Smoother smoother(N, n);
    auto* row = static_cast<double*>(hnav::take_block((N * N + N) * sizeof(double)));
    hnav_status status = HNAV_ERROR_OUT_OF_MEMORY;
    if (row && smoother.take_memory()) {
        status = run_rows(twin.get(), n, hnav::take_in(*input), out, nullptr, &smoother);
        std::strcpy(observer->message, twin->message);
    } else {
        observer->fail(status, "no memory to smooth %zu rows", n);
    }
    if (status == HNAV_OK) go_back(*twin.get(), n, smoother, row, out);
    hnav::release_block(row);
    return status;
}

} // extern "C"
