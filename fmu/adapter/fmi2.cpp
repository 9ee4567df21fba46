// The functions of FMI 2.0. They call Instance.
#include "adapter/entry.hpp"
#include "adapter/resource_path.hpp"

#include <fmi2Functions.h>

namespace {

using hnav::fmu::Call;
using hnav::fmu::Instance;
using hnav::fmu::of;
using hnav::fmu::Status;
using hnav::fmu::Type;
using Snapshot = Instance::Snapshot;

struct Fmi2 : hnav::fmu::Entry<fmi2Status, fmi2OK, fmi2Warning, fmi2Error> {};

void log(const Instance& instance, Status status, const char* text) {
    const auto callback = reinterpret_cast<fmi2CallbackLogger>(instance.importer().callback);
    if (!callback) return;
    // The logger takes a format: a percent sign in a message must not become a directive.
    char safe[512];
    std::snprintf(safe, sizeof safe, "%s", text);
    for (char* p = safe; *p; ++p)
        if (*p == '%') *p = ' ';
    callback(instance.importer().environment, instance.name(), Fmi2::to_fmi(status), Instance::category(status), safe);
}

// FMI 2 has one C type for integers and enumerations; the row of the variable has the type.
Type integer_type(fmi2Component c, fmi2ValueReference reference) {
    return of(c)->is_enumeration(reference) ? Type::enumeration : Type::integer;
}

} // namespace

static_assert(sizeof(fmi2Integer) == sizeof(int) && sizeof(fmi2Boolean) == sizeof(int));

extern "C" {

const char* fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char* fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn, size_t nCategories, const fmi2String categories[]) {
    return Fmi2::call(c, &Instance::set_debug_logging, loggingOn != fmi2False, nCategories, categories);
}

// ------------------------------------------------------------------------------------------------ life

fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID, fmi2String fmuResourceLocation,
                              const fmi2CallbackFunctions* functions, fmi2Boolean, fmi2Boolean loggingOn) {
    Instance::Options options;
    const hnav::fmu::ResourcePath resources(fmuResourceLocation);
    options.resources = resources;
    options.logging_on = loggingOn != fmi2False;
    options.interface = fmuType == fmi2ModelExchange ? hnav::fmu::model_exchange : hnav::fmu::co_simulation;
    Instance::Importer importer;
    if (functions) importer = {functions->componentEnvironment, reinterpret_cast<void*>(functions->logger), log};
    return Instance::create(instanceName, fmuGUID, options, importer);
}

void fmi2FreeInstance(fmi2Component c) { delete of(c); }

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean, fmi2Real, fmi2Real startTime, fmi2Boolean stopTimeDefined,
                               fmi2Real stopTime) {
    return Fmi2::call(c, &Instance::set_up_experiment, startTime, stopTimeDefined != fmi2False, stopTime);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return Fmi2::call(c, &Instance::enter_initialization); }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return Fmi2::call(c, &Instance::exit_initialization, true); }
fmi2Status fmi2Terminate(fmi2Component c) { return Fmi2::call(c, &Instance::terminate); }
fmi2Status fmi2Reset(fmi2Component c) { return Fmi2::call(c, &Instance::reset); }

// ------------------------------------------------------------------------------------------------ variables

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    return Fmi2::get(c, Type::real, vr, n, value, n);
}
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    return Fmi2::set(c, Type::real, vr, n, value, n);
}
fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[]) {
    return Fmi2::get(c, Type::boolean, vr, n, value, n);
}
fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean value[]) {
    return Fmi2::set(c, Type::boolean, vr, n, value, n);
}
fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer value[]) {
    if (n == 0) return Fmi2::get(c, Type::integer, vr, n, value, n);
    fmi2Status status = Fmi2::call(c, &Instance::check_array, vr, n, value, n);
    for (size_t i = 0; i < n && status == fmi2OK; ++i) status = Fmi2::get(c, integer_type(c, vr[i]), vr + i, 1, value + i, 1);
    return status;
}
fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer value[]) {
    fmi2Status status = Fmi2::call(c, &Instance::check_array, vr, n, value, n);
    for (size_t i = 0; i < n && status == fmi2OK; ++i) status = Fmi2::set(c, integer_type(c, vr[i]), vr + i, 1, value + i, 1);
    return status;
}
fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference[], size_t n, fmi2String[]) {
    return n == 0 && c ? fmi2OK : Fmi2::unsupported(c, "GetString");
}
fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference[], size_t n, const fmi2String[]) {
    return n == 0 && c ? fmi2OK : Fmi2::unsupported(c, "SetString");
}

// ------------------------------------------------------------------------------------------------ complete state

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate* state) {
    return Fmi2::call(c, &Instance::take_snapshot, reinterpret_cast<Snapshot**>(state));
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    return Fmi2::call(c, &Instance::restore_snapshot, static_cast<Snapshot*>(state));
}
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate* state) {
    return Fmi2::call(c, &Instance::release_snapshot, reinterpret_cast<Snapshot**>(state));
}
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t* size) {
    return Fmi2::call(c, &Instance::get_snapshot_bytes, static_cast<Snapshot*>(state), size);
}
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    return Fmi2::call(c, &Instance::serialise, static_cast<Snapshot*>(state), reinterpret_cast<unsigned char*>(bytes), size);
}
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate* state) {
    return Fmi2::call(c, &Instance::deserialise, reinterpret_cast<const unsigned char*>(bytes), size,
                      reinterpret_cast<Snapshot**>(state));
}

// ------------------------------------------------------------------------------------------------ derivatives

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference vUnknown[], size_t nUnknown,
                                        const fmi2ValueReference vKnown[], size_t nKnown, const fmi2Real dvKnown[],
                                        fmi2Real dvUnknown[]) {
    return Fmi2::call(c, &Instance::directional_derivative, vUnknown, nUnknown, vKnown, nKnown, dvKnown, nKnown, dvUnknown,
                      nUnknown);
}

// ------------------------------------------------------------------------------------------------ Model Exchange

fmi2Status fmi2EnterEventMode(fmi2Component c) {
    return Fmi2::call(c, &Instance::change_mode, Call::enter_event_mode, hnav::fmu::event);
}
fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo* info) {
    if (!c) return fmi2Error;
    if (!info) return Fmi2::fail(c, "NewDiscreteStates got a null pointer");
    Instance::Events events;
    const Status status = of(c)->update_discrete_states(&events);
    info->newDiscreteStatesNeeded = events.update_needed;
    info->terminateSimulation = fmi2False;
    info->nominalsOfContinuousStatesChanged = info->valuesOfContinuousStatesChanged = events.states_changed;
    info->nextEventTimeDefined = events.next_event_defined;
    info->nextEventTime = events.next_event_s;
    return Fmi2::to_fmi(status);
}
fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
    return Fmi2::call(c, &Instance::change_mode, Call::enter_continuous_time_mode, hnav::fmu::continuous);
}
fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean, fmi2Boolean* enterEventMode,
                                       fmi2Boolean* terminateSimulation) {
    if (!c) return fmi2Error;
    if (!enterEventMode || !terminateSimulation) return Fmi2::fail(c, "CompletedIntegratorStep got a null pointer");
    bool wants_event = false;
    const fmi2Status status = Fmi2::call(c, &Instance::step_done, &wants_event);
    *enterEventMode = wants_event ? fmi2True : fmi2False;
    *terminateSimulation = fmi2False;
    return status;
}
fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time) { return Fmi2::call(c, &Instance::set_time, time); }
fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t nx) {
    return Fmi2::call(c, &Instance::set_states, x, nx);
}
fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t nx) {
    return Fmi2::call(c, &Instance::get_derivatives, derivatives, nx);
}
fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real indicators[], size_t n) {
    return Fmi2::call(c, &Instance::get_indicators, indicators, n);
}
fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t nx) {
    return Fmi2::call(c, &Instance::get_states, x, nx);
}
fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real nominals[], size_t nx) {
    return Fmi2::call(c, &Instance::get_nominals, nominals, nx);
}

// ------------------------------------------------------------------------------------------------ Co-Simulation

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference[], size_t, const fmi2Integer[],
                                       const fmi2Real[]) {
    return Fmi2::unsupported(c, "SetRealInputDerivatives");
}
fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference[], size_t, const fmi2Integer[], fmi2Real[]) {
    return Fmi2::unsupported(c, "GetRealOutputDerivatives");
}
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint, fmi2Real communicationStepSize, fmi2Boolean) {
    if (!c) return fmi2Error;
    Instance::Step step;
    return Fmi2::to_fmi(of(c)->do_step(currentCommunicationPoint, communicationStepSize, nullptr, &step));
}
fmi2Status fmi2CancelStep(fmi2Component c) { return Fmi2::unsupported(c, "CancelStep"); }
fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind, fmi2Status*) { return Fmi2::unsupported(c, "GetStatus"); }
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real* value) {
    if (!c || !value || kind != fmi2LastSuccessfulTime) return Fmi2::unsupported(c, "GetRealStatus");
    *value = of(c)->time_s();
    return fmi2OK;
}
fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind, fmi2Integer*) {
    return Fmi2::unsupported(c, "GetIntegerStatus");
}
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind, fmi2Boolean*) {
    return Fmi2::unsupported(c, "GetBooleanStatus");
}
fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind, fmi2String*) {
    return Fmi2::unsupported(c, "GetStringStatus");
}

} // extern "C"
