// The table of allowed calls in each mode, for FMI 2 and FMI 3, Co-Simulation and Model Exchange.
#pragma once

namespace hnav::fmu {

enum Mode : unsigned {
    instantiated = 1,
    initialization = 2,
    event = 4,
    continuous = 8,    // Model Exchange
    step = 16,         // Co-Simulation
    intermediate = 32, // inside the callback of a step
    terminated = 64
};

constexpr unsigned any_mode = 127;
constexpr unsigned initialized = event | continuous | step | intermediate | terminated;

enum Interface : unsigned { co_simulation = 1, model_exchange = 2, both_interfaces = 3 };

enum class Call {
    enter_initialization,
    exit_initialization,
    enter_event_mode,
    enter_continuous_time_mode,
    enter_step_mode,
    update_discrete_states,
    terminate,
    reset,
    get_given,
    get_calculated,
    set_parameter,
    set_input,
    set_state,
    get_clock,
    set_clock,
    fmu_state,
    directional_derivative,
    adjoint_derivative,
    set_time,
    set_continuous_states,
    get_continuous_states,
    completed_integrator_step,
    do_step,
    set_debug_logging
};

struct Rule {
    Call call;
    const char* name; // without fmi2 or fmi3
    unsigned modes;
    unsigned interfaces;
};

constexpr Rule rules[] = {
    {Call::enter_initialization, "EnterInitializationMode", instantiated, both_interfaces},
    {Call::exit_initialization, "ExitInitializationMode", initialization, both_interfaces},
    {Call::enter_event_mode, "EnterEventMode", continuous | step, both_interfaces},
    {Call::enter_continuous_time_mode, "EnterContinuousTimeMode", event, model_exchange},
    {Call::enter_step_mode, "EnterStepMode", event, co_simulation},
    {Call::update_discrete_states, "the update of discrete states", event, both_interfaces},
    {Call::terminate, "Terminate", event | continuous | step, both_interfaces},
    {Call::reset, "Reset", any_mode & ~intermediate, both_interfaces},
    // PyFMI reads start values of parameters right after loading an archive.
    {Call::get_given, "getting a parameter or input", any_mode, both_interfaces},
    {Call::get_calculated, "getting a calculated variable", initialization | initialized, both_interfaces},
    {Call::set_parameter, "setting a parameter", instantiated | initialization, both_interfaces},
    // Also in continuous-time mode: PyFMI, OMSimulator, Simulink and Dymola write all inputs before each evaluation of the
    // derivatives. They take effect at the next event.
    {Call::set_input, "setting an input", instantiated | initialization | event | continuous | step, both_interfaces},
    // States by value reference. In continuous-time mode as SetContinuousStates (fmi-standard #392, #1956). In event mode the
    // standard lets an importer set states without `reinit` (#1950); PyFMI sets all of them. The jump at the event replaces
    // the values.
    {Call::set_state, "setting a continuous state", event | continuous, model_exchange},
    {Call::get_clock, "GetClock", initialization | event, both_interfaces},
    {Call::set_clock, "SetClock", event, both_interfaces},
    {Call::fmu_state, "getting or setting the FMU state", any_mode & ~intermediate, both_interfaces},
    {Call::directional_derivative, "GetDirectionalDerivative", initialization | initialized, model_exchange},
    {Call::adjoint_derivative, "GetAdjointDerivative", initialization | initialized, model_exchange},
    {Call::set_time, "SetTime", event | continuous, model_exchange},
    {Call::set_continuous_states, "SetContinuousStates", continuous, model_exchange},
    {Call::get_continuous_states, "getting continuous states", initialization | event | continuous | terminated, model_exchange},
    {Call::completed_integrator_step, "CompletedIntegratorStep", continuous, model_exchange},
    {Call::do_step, "DoStep", step, co_simulation},
    {Call::set_debug_logging, "SetDebugLogging", any_mode, both_interfaces},
};

// The rows stand in the order of Call: setting a value looks up its row by number.
constexpr bool rules_in_order() {
    int i = 0;
    for (const Rule& rule : rules)
        if (rule.call != static_cast<Call>(i++)) return false;
    return i == static_cast<int>(Call::set_debug_logging) + 1;
}
static_assert(rules_in_order());

constexpr const Rule& rule_of(Call call) { return rules[static_cast<int>(call)]; }

constexpr const char* mode_name(unsigned mode) {
    switch (mode) {
    case instantiated: return "the mode before initialization";
    case initialization: return "initialization mode";
    case event: return "event mode";
    case continuous: return "continuous-time mode";
    case step: return "step mode";
    case intermediate: return "intermediate update mode";
    default: return "the terminated mode";
    }
}

} // namespace hnav::fmu
