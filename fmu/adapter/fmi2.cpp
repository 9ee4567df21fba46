// FMI 2.0 by name; what the calls do stands in instance.cpp.
#include "adapter/instance.hpp"

#include <fmi2Functions.h>
#include <cstring>

namespace {

using hnav::fmu::Call;
using hnav::fmu::Instance;
using hnav::fmu::Status;
using hnav::fmu::Type;

Instance* of(fmi2Component c) { return static_cast<Instance*>(c); }
fmi2Status to_fmi(Status status) { return status == Status::ok ? fmi2OK : fmi2Error; }

void log(const Instance& instance, Status status, const char* text) {
    const auto callback = reinterpret_cast<fmi2CallbackLogger>(instance.importer().callback);
    if (!callback) return;
    // The callback formats: a percent sign of ours must not become a directive.
    char safe[512];
    std::snprintf(safe, sizeof safe, "%s", text);
    for (char* p = safe; *p; ++p)
        if (*p == '%') *p = ' ';
    callback(instance.importer().environment, instance.name(), to_fmi(status), "logStatusError", safe);
}

fmi2Status unsupported(fmi2Component c, const char* name) {
    return c ? to_fmi(of(c)->fail("%s is not supported by this FMU", name)) : fmi2Error;
}

template <class T>
fmi2Status get(fmi2Component c, Type type, const fmi2ValueReference* references, size_t n, T* values) {
    if (!c) return fmi2Error;
    if (of(c)->check_array(references, n, values, n) != Status::ok) return fmi2Error;
    return to_fmi(of(c)->get(type, references, n, values));
}

template <class T>
fmi2Status set(fmi2Component c, Type type, const fmi2ValueReference* references, size_t n, const T* values) {
    if (!c) return fmi2Error;
    if (of(c)->check_array(references, n, values, n) != Status::ok) return fmi2Error;
    return to_fmi(of(c)->set(type, references, n, values));
}

// FMI 2 has one C type for integers and enumerations, so the row tells which it is.
Type integer_type(fmi2Component c, fmi2ValueReference reference) {
    const auto& table = of(c)->table();
    const bool enumeration =
        reference < static_cast<unsigned>(table.size()) && table[static_cast<int>(reference)].type == Type::enumeration;
    return enumeration ? Type::enumeration : Type::integer;
}

} // namespace

static_assert(sizeof(fmi2Integer) == sizeof(int) && sizeof(fmi2Boolean) == sizeof(int));

extern "C" {

const char* fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char* fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn, size_t, const fmi2String[]) {
    if (!c || !of(c)->allowed(Call::set_debug_logging)) return fmi2Error;
    of(c)->logging = loggingOn != fmi2False;
    return fmi2OK;
}

// ------------------------------------------------------------------------------------------------ life

fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID, fmi2String,
                              const fmi2CallbackFunctions* functions, fmi2Boolean, fmi2Boolean loggingOn) {
    Instance::Options options;
    options.interface = fmuType == fmi2ModelExchange ? hnav::fmu::model_exchange : hnav::fmu::co_simulation;
    Instance::Importer importer;
    if (functions) importer = {functions->componentEnvironment, reinterpret_cast<void*>(functions->logger), log};
    Instance* made = Instance::create(instanceName, fmuGUID, options, importer);
    if (made) made->logging = loggingOn != fmi2False;
    return made;
}

void fmi2FreeInstance(fmi2Component c) { delete of(c); }

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean, fmi2Real, fmi2Real startTime, fmi2Boolean stopTimeDefined,
                               fmi2Real stopTime) {
    if (!c || !of(c)->allowed(Call::enter_initialization)) return fmi2Error;
    return to_fmi(of(c)->set_up_experiment(startTime, stopTimeDefined != fmi2False, stopTime));
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return c ? to_fmi(of(c)->enter_initialization()) : fmi2Error; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return c ? to_fmi(of(c)->exit_initialization(true)) : fmi2Error; }
fmi2Status fmi2Terminate(fmi2Component c) { return c ? to_fmi(of(c)->terminate()) : fmi2Error; }
fmi2Status fmi2Reset(fmi2Component c) { return c ? to_fmi(of(c)->reset()) : fmi2Error; }

// ------------------------------------------------------------------------------------------------ variables

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    return get(c, Type::real, vr, n, value);
}
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    return set(c, Type::real, vr, n, value);
}
fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[]) {
    return get(c, Type::boolean, vr, n, value);
}
fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean value[]) {
    return set(c, Type::boolean, vr, n, value);
}
fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer value[]) {
    if (!c || of(c)->check_array(vr, n, value, n) != Status::ok) return fmi2Error;
    if (n == 0) return get(c, Type::integer, vr, n, value);
    for (size_t i = 0; i < n; ++i)
        if (get(c, integer_type(c, vr[i]), vr + i, 1, value + i) != fmi2OK) return fmi2Error;
    return fmi2OK;
}
fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer value[]) {
    if (!c || of(c)->check_array(vr, n, value, n) != Status::ok) return fmi2Error;
    for (size_t i = 0; i < n; ++i)
        if (set(c, integer_type(c, vr[i]), vr + i, 1, value + i) != fmi2OK) return fmi2Error;
    return fmi2OK;
}
fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference[], size_t n, fmi2String[]) {
    return n == 0 && c ? fmi2OK : unsupported(c, "GetString");
}
fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference[], size_t n, const fmi2String[]) {
    return n == 0 && c ? fmi2OK : unsupported(c, "SetString");
}

// ------------------------------------------------------------------------------------------------ complete state

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate* state) {
    return c ? to_fmi(of(c)->take_snapshot(reinterpret_cast<Instance::Snapshot**>(state))) : fmi2Error;
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    return c ? to_fmi(of(c)->restore_snapshot(static_cast<Instance::Snapshot*>(state))) : fmi2Error;
}
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate* state) {
    if (!c) return fmi2Error;
    if (!state) return fmi2OK;
    Instance::free_snapshot(static_cast<Instance::Snapshot*>(*state));
    *state = nullptr;
    return fmi2OK;
}
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t* size) {
    if (!c) return fmi2Error;
    if (!state || !size) return to_fmi(of(c)->fail("SerializedFMUstateSize got a null pointer"));
    *size = static_cast<Instance::Snapshot*>(state)->bytes;
    return fmi2OK;
}
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    return c ? to_fmi(of(c)->serialise(static_cast<Instance::Snapshot*>(state), reinterpret_cast<unsigned char*>(bytes), size))
             : fmi2Error;
}
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate* state) {
    return c ? to_fmi(of(c)->deserialise(reinterpret_cast<const unsigned char*>(bytes), size,
                                         reinterpret_cast<Instance::Snapshot**>(state)))
             : fmi2Error;
}

// ------------------------------------------------------------------------------------------------ derivatives

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference vUnknown[], size_t nUnknown,
                                        const fmi2ValueReference vKnown[], size_t nKnown, const fmi2Real dvKnown[],
                                        fmi2Real dvUnknown[]) {
    return c ? to_fmi(of(c)->directional_derivative(vUnknown, nUnknown, vKnown, nKnown, dvKnown, dvUnknown)) : fmi2Error;
}

// ------------------------------------------------------------------------------------------------ Model Exchange

fmi2Status fmi2EnterEventMode(fmi2Component c) {
    return c ? to_fmi(of(c)->change_mode(Call::enter_event_mode, hnav::fmu::event)) : fmi2Error;
}
fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo* info) {
    if (!c) return fmi2Error;
    if (!info) return to_fmi(of(c)->fail("NewDiscreteStates got a null pointer"));
    Instance::Events events;
    const Status status = of(c)->update_discrete_states(&events);
    info->newDiscreteStatesNeeded = info->terminateSimulation = fmi2False;
    info->nominalsOfContinuousStatesChanged = info->valuesOfContinuousStatesChanged = events.states_changed;
    info->nextEventTimeDefined = events.next_event_defined;
    info->nextEventTime = events.next_event_s;
    return to_fmi(status);
}
fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
    return c ? to_fmi(of(c)->change_mode(Call::enter_continuous_time_mode, hnav::fmu::continuous)) : fmi2Error;
}
fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean, fmi2Boolean* enterEventMode,
                                       fmi2Boolean* terminateSimulation) {
    if (!c) return fmi2Error;
    if (!enterEventMode || !terminateSimulation) return to_fmi(of(c)->fail("CompletedIntegratorStep got a null pointer"));
    *enterEventMode = *terminateSimulation = fmi2False;
    return to_fmi(of(c)->completed_integrator_step());
}
fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time) { return c ? to_fmi(of(c)->set_time(time)) : fmi2Error; }
fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t nx) {
    return c ? to_fmi(of(c)->set_states(x, nx)) : fmi2Error;
}
fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t nx) {
    return c ? to_fmi(of(c)->get_derivatives(derivatives, nx)) : fmi2Error;
}
fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real[], size_t n) {
    if (!c || !of(c)->allowed(Call::get_continuous_states)) return fmi2Error;
    return n == 0 ? fmi2OK : to_fmi(of(c)->fail("there are no event indicators, but %zu were asked for", n));
}
fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t nx) {
    return c ? to_fmi(of(c)->get_states(x, nx)) : fmi2Error;
}
fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real nominals[], size_t nx) {
    return c ? to_fmi(of(c)->get_nominals(nominals, nx)) : fmi2Error;
}

// ------------------------------------------------------------------------------------------------ Co-Simulation

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference[], size_t, const fmi2Integer[],
                                       const fmi2Real[]) {
    return unsupported(c, "SetRealInputDerivatives");
}
fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference[], size_t, const fmi2Integer[], fmi2Real[]) {
    return unsupported(c, "GetRealOutputDerivatives");
}
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint, fmi2Real communicationStepSize, fmi2Boolean) {
    if (!c) return fmi2Error;
    Instance::Step step;
    return to_fmi(of(c)->do_step(currentCommunicationPoint, communicationStepSize, nullptr, &step));
}
fmi2Status fmi2CancelStep(fmi2Component c) { return unsupported(c, "CancelStep"); }
fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind, fmi2Status*) { return unsupported(c, "GetStatus"); }
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real* value) {
    if (!c || !value || kind != fmi2LastSuccessfulTime) return unsupported(c, "GetRealStatus");
    *value = of(c)->time_s();
    return fmi2OK;
}
fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind, fmi2Integer*) {
    return unsupported(c, "GetIntegerStatus");
}
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind, fmi2Boolean*) {
    return unsupported(c, "GetBooleanStatus");
}
fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind, fmi2String*) { return unsupported(c, "GetStringStatus"); }

} // extern "C"
