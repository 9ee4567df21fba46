// The C boundary of the aircraft with an INS.
#include "hnav/simulation.h"

#include "base/memory.hpp"
#include "c_api/saved_object.hpp"
#include "c_api/sized.hpp"
#include "options/lists.hpp"
#include "simulation/aircraft.hpp"

using hnav::AircraftFlight;

struct hnav_aircraft : hnav::KeptMessage<320>, hnav::Aircraft {
    hnav_aircraft(const hnav_aircraft_options& options, const hnav_aircraft_model& model)
        : Aircraft(options, model), stamp(fingerprint()) {}

    void reset() { flight.reset(); }
    hnav::SavedState saved() const { return {hnav::SavedState::letters("HNAVAIRC"), 2, stamp, sizeof(AircraftFlight::State)}; }
    const void* numbers() const { return &flight.state; }
    bool assign(const void* numbers) {
        std::memcpy(&flight.state, numbers, sizeof flight.state);
        return true;
    }

    const std::uint64_t stamp; // of saved states
};

namespace {

// Checks the entries of a model in order and keeps the first error.
struct Check : hnav::CallersMessage {
    hnav_status status = HNAV_OK;

    // Every number of the entry is inside [min, max], or above min when that is open.
    void numbers(const char* name, const double* value, int count, double min, bool open, double max = no_bound) {
        if (status != HNAV_OK) return;
        if (!value) status = fail(HNAV_ERROR_NULL_ARGUMENT, "%s is null", name);
        for (int i = 0; i < count && status == HNAV_OK; ++i) number(name, value[i], i, min, open, max);
    }

    void number(const char* name, double value, int i, double min, bool open, double max = no_bound) {
        if (status != HNAV_OK) return;
        if (!std::isfinite(value)) status = fail(HNAV_ERROR_NON_FINITE, "%s[%d] = %g is not finite", name, i, value);
        else if (value < min || value > max || (open && value == min))
            status = fail(HNAV_ERROR_OPTION, "%s[%d] = %g is impossible: it must be %s %g", name, i, value,
                          value > max ? "at most"
                          : open      ? "above"
                                      : "at least",
                          value > max ? max : min);
    }

    void size(const char* name, int value, int min) {
        if (status == HNAV_OK && (value < min || value > hnav::max_dimension))
            status = fail(HNAV_ERROR_SIZE, "%s = %d: it must be in [%d, %d]", name, value, min, hnav::max_dimension);
    }

    static constexpr double no_bound = 1e300;
};

constexpr double any = -Check::no_bound;

void check_coloured_error(const hnav_aircraft_options& o, const hnav_aircraft_model& m, const hnav_gauss_markov& error,
                          const char* sigma, const char* time_constant, Check& is) {
    if (!error.sigma) return;
    is.numbers(sigma, error.sigma, m.nx, 0, false);
    is.numbers(time_constant, error.time_constant_s, m.nx, 0, true);
    for (int i = 0; i < m.nx && is.status == HNAV_OK; ++i) // beyond it 1 - dt/tau oscillates with growing amplitude
        if (o.euler_colour && !(m.interval_s < 2 * error.time_constant_s[i]))
            is.status = is.fail(HNAV_ERROR_OPTION,
                                "%s[%d] = %g is impossible with euler_colour: it must be above half of interval_s = %g",
                                time_constant, i, error.time_constant_s[i], m.interval_s);
}

void check_commands_and_faults(const hnav_aircraft_model& m, Check& is) {
    for (int j = 0; m.commands && j < m.nu; ++j) {
        is.number("commands.amplitude", m.commands[j].amplitude, j, any, false);
        is.number("commands.period_s", m.commands[j].period_s, j, 0, true);
        is.number("commands.phase_rad", m.commands[j].phase_rad, j, any, false);
    }
    for (int i = 0; m.faults && i < m.nx; ++i) {
        is.number("faults.start_s", m.faults[i].start_s, i, any, false);
        is.number("faults.stop_s", m.faults[i].stop_s, i, any, false);
        is.number("faults.factor", m.faults[i].factor, i, 0, false);
    }
}

void check(const hnav_aircraft_options& o, const hnav_aircraft_model& m, Check& is) {
    is.size("nx", m.nx, 1);
    is.size("nu", m.nu, 0);
    if (is.status != HNAV_OK) return;
    is.numbers("interval_s", &m.interval_s, 1, 0, true);
    is.numbers("A_1_s", m.A_1_s, m.nx * m.nx, any, false);
    if (m.nu > 0) is.numbers("B_1_s", m.B_1_s, m.nx * m.nu, any, false);
    is.numbers("process_noise_per_sqrt_s", m.process_noise_per_sqrt_s, m.nx, 0, false);
    is.numbers("measurement_sigma", m.measurement_sigma, m.nx, 0, false);
    if (m.start) is.numbers("start", m.start, m.nx, any, false);
    is.numbers("start_sigma", m.start_sigma, m.nx, 0, false);
    check_coloured_error(o, m, m.accelerometer_error, "accelerometer_error.sigma", "accelerometer_error.time_constant_s", is);
    check_coloured_error(o, m, m.gravity_error, "gravity_error.sigma", "gravity_error.time_constant_s", is);
    check_commands_and_faults(m, is);
    if (is.status != HNAV_OK) return;
    const std::complex<double> growth = hnav::LinearAircraft::fastest_growth(m.nx, m.A_1_s);
    if (growth.real() > 1e-9)
        is.status =
            is.fail(HNAV_ERROR_OPTION, "A_1_s is unstable: it has the eigenvalue %.4g%+.3gi 1/s", growth.real(), growth.imag());
}

void write(const AircraftFlight& f, std::size_t row, hnav_aircraft_sample* out) {
    out->k = static_cast<std::uint64_t>(f.state.k);
    out->t_s = f.time_s();
    const auto put = [row](double* to, int count, auto&& value) {
        for (int i = 0; to && i < count; ++i) to[row * count + i] = value(i);
    };
    put(out->x, f.nx, [&](int i) { return f.state.x[i]; });
    put(out->lambda, f.nx, [&](int i) { return f.lambda(i); });
    put(out->z, f.nx, [&](int i) { return f.state.z[i]; });
    put(out->u, f.nu, [&](int j) { return f.state.u[j]; });
    put(out->noise_factor, f.nx, [&](int i) { return f.noise_factor(i); });
}

hnav_status step(hnav_aircraft* a, const double* command) {
    for (int j = 0; command && j < a->flight.nu; ++j)
        if (!std::isfinite(command[j]))
            return a->fail(HNAV_ERROR_NON_FINITE, "command[%d] = %g is not finite in step %.0f", j, command[j],
                           a->flight.state.k);
    a->flight.step(command);
    return HNAV_OK;
}

} // namespace

extern "C" {

hnav_status hnav_aircraft_create(hnav_aircraft** aircraft, const hnav_aircraft_options* options, const hnav_aircraft_model* model,
                                 char* message, size_t message_size) {
    Check is{{message, message_size}};
    if (const hnav_status status = is.begin(aircraft, "aircraft", {{options, "options"}, {model, "model"}})) return status;
    is.status = hnav::check_size(is, *model, "model", "hnav_aircraft_model");
    if (is.status == HNAV_OK) is.status = is.check_options(options, hnav::aircraft_options);
    if (is.status != HNAV_OK) return is.status;
    const hnav_aircraft_model given = hnav::take_in(*model);
    check(*options, given, is);
    if (is.status != HNAV_OK) return is.status;

    auto* self = hnav::make_object<hnav_aircraft>(*options, given);
    if (!self) return is.fail(HNAV_ERROR_OUT_OF_MEMORY, "no memory for an aircraft with nx = %d", given.nx);
    if (!self->is_finite()) {
        hnav_aircraft_destroy(self);
        return is.fail(HNAV_ERROR_OPTION, "A_1_s over interval_s = %g s is beyond what numbers hold", given.interval_s);
    }
    *aircraft = self;
    return HNAV_OK;
}

void hnav_aircraft_destroy(hnav_aircraft* aircraft) { hnav::destroy_object(aircraft); }

hnav_status hnav_aircraft_reset(hnav_aircraft* aircraft) { return hnav::reset_object(aircraft); }

const char* hnav_aircraft_message(const hnav_aircraft* aircraft) { return aircraft ? aircraft->message : "aircraft is null"; }

hnav_status hnav_aircraft_step(hnav_aircraft* aircraft, const double* command) {
    if (!aircraft) return HNAV_ERROR_NULL_ARGUMENT;
    return step(aircraft, command);
}

hnav_status hnav_aircraft_get_sample(const hnav_aircraft* aircraft, hnav_aircraft_sample* sample) {
    REQUIRE_STRUCT(aircraft, sample, hnav_aircraft_sample);
    hnav_aircraft_sample out = hnav::take_in(*sample);
    write(aircraft->flight, 0, &out);
    return hnav::hand_out(out, sample);
}

hnav_status hnav_aircraft_run(hnav_aircraft* aircraft, size_t n, const double* command, hnav_aircraft_sample* output) {
    REQUIRE_STRUCT(aircraft, output, hnav_aircraft_sample);
    hnav_aircraft_sample out = hnav::take_in(*output);
    const int nu = aircraft->flight.nu;
    hnav_status status = HNAV_OK;
    for (size_t i = 0; i < n && status == HNAV_OK; ++i) {
        write(aircraft->flight, i, &out);
        status = step(aircraft, command && nu > 0 ? command + i * nu : nullptr);
    }
    hnav::hand_out(out, output);
    return status;
}

hnav_status hnav_aircraft_filter_model(const hnav_aircraft* aircraft, hnav_ins_error_model* model) {
    REQUIRE_STRUCT(aircraft, model, hnav_ins_error_model);
    return hnav::hand_out(aircraft->filter_model(), model);
}

hnav_status hnav_aircraft_state_size(const hnav_aircraft* aircraft, size_t* bytes) {
    return hnav::give_state_size(aircraft, bytes);
}

hnav_status hnav_aircraft_save(const hnav_aircraft* aircraft, void* buffer, size_t bytes) {
    return hnav::save_object(aircraft, buffer, bytes);
}

hnav_status hnav_aircraft_load(hnav_aircraft* aircraft, const void* buffer, size_t bytes) {
    return hnav::load_object(aircraft, buffer, bytes, "aircraft");
}

} // extern "C"
