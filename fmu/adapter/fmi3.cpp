// The functions of FMI 3.0. They call Instance.
#include "adapter/entry.hpp"

#include <fmi3Functions.h>

namespace {

using hnav::fmu::Call;
using hnav::fmu::Instance;
using hnav::fmu::of;
using hnav::fmu::Status;
using hnav::fmu::Type;
using Snapshot = Instance::Snapshot;

struct Fmi3 : hnav::fmu::Entry<fmi3Status, fmi3OK, fmi3Warning, fmi3Error> {};

void log(const Instance& instance, Status status, const char* text) {
    if (const auto callback = reinterpret_cast<fmi3LogMessageCallback>(instance.importer().callback))
        callback(instance.importer().environment, Fmi3::to_fmi(status), Instance::category(status), text);
}

Instance::Importer importer(fmi3InstanceEnvironment environment, fmi3LogMessageCallback callback) {
    return {environment, reinterpret_cast<void*>(callback), log};
}

void intermediate_update(Instance& instance, double t_s) {
    const auto callback = reinterpret_cast<fmi3IntermediateUpdateCallback>(instance.intermediate_callback);
    fmi3Boolean early_return_requested = fmi3False;
    fmi3Float64 early_return_time = t_s;
    callback(instance.importer().environment, t_s, fmi3False, fmi3True, fmi3True, fmi3False, &early_return_requested,
             &early_return_time);
}

// No variable has this type: only an empty request is valid.
fmi3Status none_of_type(fmi3Instance instance, size_t n, const char* type) {
    if (!instance) return fmi3Error;
    return n == 0 ? fmi3OK : Fmi3::to_fmi(of(instance)->fail("there are no variables of type %s", type));
}

} // namespace

static_assert(sizeof(fmi3Int32) == sizeof(int) && sizeof(fmi3Int64) == sizeof(std::int64_t) &&
              sizeof(fmi3Boolean) == sizeof(bool));

extern "C" {

const char* fmi3GetVersion(void) { return fmi3Version; }

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean loggingOn, size_t nCategories, const fmi3String categories[]) {
    return Fmi3::call(instance, &Instance::set_debug_logging, loggingOn, nCategories, categories);
}

// ------------------------------------------------------------------------------------------------ life

fmi3Instance fmi3InstantiateModelExchange(fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath,
                                          fmi3Boolean, fmi3Boolean loggingOn, fmi3InstanceEnvironment instanceEnvironment,
                                          fmi3LogMessageCallback logMessage) {
    Instance::Options options;
    options.resources = resourcePath;
    options.logging_on = loggingOn;
    options.interface = hnav::fmu::model_exchange;
    return Instance::create(instanceName, instantiationToken, options, importer(instanceEnvironment, logMessage));
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath,
                                         fmi3Boolean, fmi3Boolean loggingOn, fmi3Boolean eventModeUsed,
                                         fmi3Boolean earlyReturnAllowed, const fmi3ValueReference*, size_t,
                                         fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage,
                                         fmi3IntermediateUpdateCallback intermediateUpdate) {
    Instance::Options options;
    options.resources = resourcePath;
    options.logging_on = loggingOn;
    options.event_mode_used = eventModeUsed;
    options.early_return_allowed = earlyReturnAllowed;
    Instance* made = Instance::create(instanceName, instantiationToken, options, importer(instanceEnvironment, logMessage));
    if (made) made->intermediate_callback = reinterpret_cast<void*>(intermediateUpdate);
    return made;
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String, fmi3String, fmi3String, fmi3Boolean, fmi3Boolean,
                                               fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage,
                                               fmi3ClockUpdateCallback, fmi3LockPreemptionCallback,
                                               fmi3UnlockPreemptionCallback) {
    if (logMessage)
        logMessage(instanceEnvironment, fmi3Error, "logStatusError", "Scheduled Execution is not supported by this FMU");
    return nullptr;
}

void fmi3FreeInstance(fmi3Instance instance) { delete of(instance); }

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean, fmi3Float64, fmi3Float64 startTime,
                                       fmi3Boolean stopTimeDefined, fmi3Float64 stopTime) {
    const fmi3Status status = Fmi3::call(instance, &Instance::set_up_experiment, startTime, stopTimeDefined, stopTime);
    return status == fmi3OK ? Fmi3::call(instance, &Instance::enter_initialization) : status;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance) {
    return Fmi3::call(instance, &Instance::exit_initialization, false);
}

fmi3Status fmi3EnterEventMode(fmi3Instance instance) {
    return Fmi3::call(instance, &Instance::change_mode, Call::enter_event_mode, hnav::fmu::event);
}

fmi3Status fmi3EnterStepMode(fmi3Instance instance) {
    return Fmi3::call(instance, &Instance::change_mode, Call::enter_step_mode, hnav::fmu::step);
}

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance) {
    return Fmi3::call(instance, &Instance::change_mode, Call::enter_continuous_time_mode, hnav::fmu::continuous);
}

fmi3Status fmi3Terminate(fmi3Instance instance) { return Fmi3::call(instance, &Instance::terminate); }
fmi3Status fmi3Reset(fmi3Instance instance) { return Fmi3::call(instance, &Instance::reset); }
fmi3Status fmi3EnterConfigurationMode(fmi3Instance instance) { return Fmi3::unsupported(instance, "EnterConfigurationMode"); }
fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance) { return Fmi3::unsupported(instance, "ExitConfigurationMode"); }

// ------------------------------------------------------------------------------------------------ variables

fmi3Status fmi3GetFloat64(fmi3Instance i, const fmi3ValueReference vr[], size_t n, fmi3Float64 values[], size_t n_values) {
    return Fmi3::get(i, Type::real, vr, n, values, n_values);
}
fmi3Status fmi3GetInt32(fmi3Instance i, const fmi3ValueReference vr[], size_t n, fmi3Int32 values[], size_t n_values) {
    return Fmi3::get(i, Type::integer, vr, n, values, n_values);
}
fmi3Status fmi3GetInt64(fmi3Instance i, const fmi3ValueReference vr[], size_t n, fmi3Int64 values[], size_t n_values) {
    return Fmi3::get(i, Type::enumeration, vr, n, values, n_values);
}
fmi3Status fmi3GetBoolean(fmi3Instance i, const fmi3ValueReference vr[], size_t n, fmi3Boolean values[], size_t n_values) {
    return Fmi3::get(i, Type::boolean, vr, n, values, n_values);
}
fmi3Status fmi3SetFloat64(fmi3Instance i, const fmi3ValueReference vr[], size_t n, const fmi3Float64 values[], size_t n_values) {
    return Fmi3::set(i, Type::real, vr, n, values, n_values);
}
fmi3Status fmi3SetInt32(fmi3Instance i, const fmi3ValueReference vr[], size_t n, const fmi3Int32 values[], size_t n_values) {
    return Fmi3::set(i, Type::integer, vr, n, values, n_values);
}
fmi3Status fmi3SetInt64(fmi3Instance i, const fmi3ValueReference vr[], size_t n, const fmi3Int64 values[], size_t n_values) {
    return Fmi3::set(i, Type::enumeration, vr, n, values, n_values);
}
fmi3Status fmi3SetBoolean(fmi3Instance i, const fmi3ValueReference vr[], size_t n, const fmi3Boolean values[], size_t n_values) {
    return Fmi3::set(i, Type::boolean, vr, n, values, n_values);
}

#define NO_VARIABLES(T)                                                                                                          \
    fmi3Status fmi3Get##T(fmi3Instance i, const fmi3ValueReference[], size_t n, fmi3##T[], size_t) {                             \
        return none_of_type(i, n, #T);                                                                                           \
    }                                                                                                                            \
    fmi3Status fmi3Set##T(fmi3Instance i, const fmi3ValueReference[], size_t n, const fmi3##T[], size_t) {                       \
        return none_of_type(i, n, #T);                                                                                           \
    }
NO_VARIABLES(Float32)
NO_VARIABLES(Int8)
NO_VARIABLES(UInt8)
NO_VARIABLES(Int16)
NO_VARIABLES(UInt16)
NO_VARIABLES(UInt32)
NO_VARIABLES(UInt64)
NO_VARIABLES(String)
#undef NO_VARIABLES

fmi3Status fmi3GetBinary(fmi3Instance i, const fmi3ValueReference[], size_t n, size_t[], fmi3Binary[], size_t) {
    return none_of_type(i, n, "Binary");
}
fmi3Status fmi3SetBinary(fmi3Instance i, const fmi3ValueReference[], size_t n, const size_t[], const fmi3Binary[], size_t) {
    return none_of_type(i, n, "Binary");
}
fmi3Status fmi3GetClock(fmi3Instance i, const fmi3ValueReference vr[], size_t n, fmi3Clock values[]) {
    return Fmi3::call(i, &Instance::get_clocks, vr, n, values);
}
fmi3Status fmi3SetClock(fmi3Instance i, const fmi3ValueReference vr[], size_t n, const fmi3Clock values[]) {
    return Fmi3::call(i, &Instance::set_clocks, vr, n, values);
}

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance i, fmi3ValueReference, size_t*) {
    return Fmi3::unsupported(i, "GetNumberOfVariableDependencies");
}
fmi3Status fmi3GetVariableDependencies(fmi3Instance i, fmi3ValueReference, size_t[], fmi3ValueReference[], size_t[],
                                       fmi3DependencyKind[], size_t) {
    return Fmi3::unsupported(i, "GetVariableDependencies");
}

// ------------------------------------------------------------------------------------------------ complete state

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState* state) {
    return Fmi3::call(instance, &Instance::take_snapshot, reinterpret_cast<Snapshot**>(state));
}
fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state) {
    return Fmi3::call(instance, &Instance::restore_snapshot, static_cast<Snapshot*>(state));
}
fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState* state) {
    return Fmi3::call(instance, &Instance::release_snapshot, reinterpret_cast<Snapshot**>(state));
}
fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t* size) {
    return Fmi3::call(instance, &Instance::get_snapshot_bytes, static_cast<Snapshot*>(state), size);
}
fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
    return Fmi3::call(instance, &Instance::serialise, static_cast<Snapshot*>(state), bytes, size);
}
fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[], size_t size, fmi3FMUState* state) {
    return Fmi3::call(instance, &Instance::deserialise, bytes, size, reinterpret_cast<Snapshot**>(state));
}

// ------------------------------------------------------------------------------------------------ derivatives

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                        const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[], size_t nSeed,
                                        fmi3Float64 sensitivity[], size_t nSensitivity) {
    return Fmi3::call(instance, &Instance::directional_derivative, unknowns, nUnknowns, knowns, nKnowns, seed, nSeed, sensitivity,
                      nSensitivity);
}
fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                    const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[], size_t nSeed,
                                    fmi3Float64 sensitivity[], size_t nSensitivity) {
    return Fmi3::call(instance, &Instance::adjoint_derivative, unknowns, nUnknowns, knowns, nKnowns, seed, nSeed, sensitivity,
                      nSensitivity);
}

// ------------------------------------------------------------------------------------------------ intervals of clocks: none

fmi3Status fmi3GetIntervalDecimal(fmi3Instance i, const fmi3ValueReference[], size_t, fmi3Float64[], fmi3IntervalQualifier[]) {
    return Fmi3::unsupported(i, "GetIntervalDecimal");
}
fmi3Status fmi3GetIntervalFraction(fmi3Instance i, const fmi3ValueReference[], size_t, fmi3UInt64[], fmi3UInt64[],
                                   fmi3IntervalQualifier[]) {
    return Fmi3::unsupported(i, "GetIntervalFraction");
}
fmi3Status fmi3GetShiftDecimal(fmi3Instance i, const fmi3ValueReference[], size_t, fmi3Float64[]) {
    return Fmi3::unsupported(i, "GetShiftDecimal");
}
fmi3Status fmi3GetShiftFraction(fmi3Instance i, const fmi3ValueReference[], size_t, fmi3UInt64[], fmi3UInt64[]) {
    return Fmi3::unsupported(i, "GetShiftFraction");
}
fmi3Status fmi3SetIntervalDecimal(fmi3Instance i, const fmi3ValueReference[], size_t, const fmi3Float64[]) {
    return Fmi3::unsupported(i, "SetIntervalDecimal");
}
fmi3Status fmi3SetIntervalFraction(fmi3Instance i, const fmi3ValueReference[], size_t, const fmi3UInt64[], const fmi3UInt64[]) {
    return Fmi3::unsupported(i, "SetIntervalFraction");
}
fmi3Status fmi3SetShiftDecimal(fmi3Instance i, const fmi3ValueReference[], size_t, const fmi3Float64[]) {
    return Fmi3::unsupported(i, "SetShiftDecimal");
}
fmi3Status fmi3SetShiftFraction(fmi3Instance i, const fmi3ValueReference[], size_t, const fmi3UInt64[], const fmi3UInt64[]) {
    return Fmi3::unsupported(i, "SetShiftFraction");
}
fmi3Status fmi3ActivateModelPartition(fmi3Instance i, fmi3ValueReference, fmi3Float64) {
    return Fmi3::unsupported(i, "ActivateModelPartition");
}

// ------------------------------------------------------------------------------------------------ events

// Outputs follow the states of the last event, so EvaluateDiscreteStates computes nothing.
fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance) {
    return Fmi3::call(instance, &Instance::permit, Call::update_discrete_states);
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean* discreteStatesNeedUpdate,
                                    fmi3Boolean* terminateSimulation, fmi3Boolean* nominalsOfContinuousStatesChanged,
                                    fmi3Boolean* valuesOfContinuousStatesChanged, fmi3Boolean* nextEventTimeDefined,
                                    fmi3Float64* nextEventTime) {
    if (!instance) return fmi3Error;
    if (!discreteStatesNeedUpdate || !terminateSimulation || !nominalsOfContinuousStatesChanged ||
        !valuesOfContinuousStatesChanged || !nextEventTimeDefined || !nextEventTime)
        return Fmi3::fail(instance, "UpdateDiscreteStates got a null pointer");
    Instance::Events events;
    const Status status = of(instance)->update_discrete_states(&events);
    *discreteStatesNeedUpdate = events.update_needed;
    *terminateSimulation = fmi3False;
    *nominalsOfContinuousStatesChanged = *valuesOfContinuousStatesChanged = events.states_changed;
    *nextEventTimeDefined = events.next_event_defined;
    *nextEventTime = events.next_event_s;
    return Fmi3::to_fmi(status);
}

// ------------------------------------------------------------------------------------------------ Model Exchange

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time) { return Fmi3::call(instance, &Instance::set_time, time); }
fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 states[], size_t n) {
    return Fmi3::call(instance, &Instance::set_states, states, n);
}
fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 states[], size_t n) {
    return Fmi3::call(instance, &Instance::get_states, states, n);
}
fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 derivatives[], size_t n) {
    return Fmi3::call(instance, &Instance::get_derivatives, derivatives, n);
}
fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals[], size_t n) {
    return Fmi3::call(instance, &Instance::get_nominals, nominals, n);
}
fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 indicators[], size_t n) {
    return Fmi3::call(instance, &Instance::get_indicators, indicators, n);
}
fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t* n) {
    if (!instance) return fmi3Error;
    if (!n) return Fmi3::fail(instance, "GetNumberOfEventIndicators got a null pointer");
    *n = static_cast<size_t>(of(instance)->indicator_count());
    return fmi3OK;
}
fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t* n) {
    if (!instance) return fmi3Error;
    if (!n) return Fmi3::fail(instance, "GetNumberOfContinuousStates got a null pointer");
    *n = static_cast<size_t>(of(instance)->state_count());
    return fmi3OK;
}
fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean, fmi3Boolean* enterEventMode,
                                       fmi3Boolean* terminateSimulation) {
    if (!instance) return fmi3Error;
    if (!enterEventMode || !terminateSimulation) return Fmi3::fail(instance, "CompletedIntegratorStep got a null pointer");
    bool wants_event = false;
    const fmi3Status status = Fmi3::call(instance, &Instance::step_done, &wants_event);
    *enterEventMode = wants_event ? fmi3True : fmi3False;
    *terminateSimulation = fmi3False;
    return status;
}

// ------------------------------------------------------------------------------------------------ Co-Simulation

fmi3Status fmi3GetOutputDerivatives(fmi3Instance i, const fmi3ValueReference[], size_t, const fmi3Int32[], fmi3Float64[],
                                    size_t) {
    return Fmi3::unsupported(i, "GetOutputDerivatives");
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 currentCommunicationPoint, fmi3Float64 communicationStepSize,
                      fmi3Boolean, fmi3Boolean* eventHandlingNeeded, fmi3Boolean* terminateSimulation, fmi3Boolean* earlyReturn,
                      fmi3Float64* lastSuccessfulTime) {
    if (!instance) return fmi3Error;
    if (!eventHandlingNeeded || !terminateSimulation || !earlyReturn || !lastSuccessfulTime)
        return Fmi3::fail(instance, "DoStep got a null pointer");
    Instance::Step step;
    const Status status = of(instance)->do_step(currentCommunicationPoint, communicationStepSize,
                                                of(instance)->intermediate_callback ? intermediate_update : nullptr, &step);
    *eventHandlingNeeded = step.event_handling_needed;
    *terminateSimulation = fmi3False;
    *earlyReturn = step.early_return;
    *lastSuccessfulTime = step.last_successful_s;
    return Fmi3::to_fmi(status);
}

} // extern "C"
