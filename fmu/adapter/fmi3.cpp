// FMI 3.0 by name; what the calls do stands in instance.cpp.
#include "adapter/instance.hpp"

#include <fmi3Functions.h>
#include <cstring>

namespace {

using hnav::fmu::Call;
using hnav::fmu::Instance;
using hnav::fmu::Status;
using hnav::fmu::Type;

Instance* of(fmi3Instance instance) { return static_cast<Instance*>(instance); }
fmi3Status to_fmi(Status status) { return status == Status::ok ? fmi3OK : fmi3Error; }

void log(const Instance& instance, Status status, const char* text) {
    if (const auto callback = reinterpret_cast<fmi3LogMessageCallback>(instance.importer().callback))
        callback(instance.importer().environment, to_fmi(status), "logStatusError", text);
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

// Calls of capabilities that this FMU declares not to have.
fmi3Status unsupported(fmi3Instance instance, const char* name) {
    return instance ? to_fmi(of(instance)->fail("%s is not supported by this FMU", name)) : fmi3Error;
}

// A type without variables: only the empty request is right.
fmi3Status none_of_type(fmi3Instance instance, size_t n, const char* type) {
    if (!instance) return fmi3Error;
    return n == 0 ? fmi3OK : to_fmi(of(instance)->fail("there are no variables of type %s", type));
}

template <class T>
fmi3Status get(fmi3Instance instance, Type type, const fmi3ValueReference* references, size_t n, T* values, size_t n_values) {
    if (!instance) return fmi3Error;
    if (of(instance)->check_array(references, n, values, n_values) != Status::ok) return fmi3Error;
    return to_fmi(of(instance)->get(type, references, n, values));
}

template <class T>
fmi3Status set(fmi3Instance instance, Type type, const fmi3ValueReference* references, size_t n, const T* values,
               size_t n_values) {
    if (!instance) return fmi3Error;
    if (of(instance)->check_array(references, n, values, n_values) != Status::ok) return fmi3Error;
    return to_fmi(of(instance)->set(type, references, n, values));
}

} // namespace

static_assert(sizeof(fmi3Int32) == sizeof(int) && sizeof(fmi3Int64) == sizeof(std::int64_t) &&
              sizeof(fmi3Boolean) == sizeof(bool));

extern "C" {

const char* fmi3GetVersion(void) { return fmi3Version; }

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean loggingOn, size_t, const fmi3String*) {
    if (!instance || !of(instance)->allowed(Call::set_debug_logging)) return fmi3Error;
    of(instance)->logging = loggingOn;
    return fmi3OK;
}

// ------------------------------------------------------------------------------------------------ life

fmi3Instance fmi3InstantiateModelExchange(fmi3String instanceName, fmi3String instantiationToken, fmi3String, fmi3Boolean,
                                          fmi3Boolean loggingOn, fmi3InstanceEnvironment instanceEnvironment,
                                          fmi3LogMessageCallback logMessage) {
    Instance::Options options;
    options.interface = hnav::fmu::model_exchange;
    Instance* made = Instance::create(instanceName, instantiationToken, options, importer(instanceEnvironment, logMessage));
    if (made) made->logging = loggingOn;
    return made;
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String instanceName, fmi3String instantiationToken, fmi3String, fmi3Boolean,
                                         fmi3Boolean loggingOn, fmi3Boolean eventModeUsed, fmi3Boolean earlyReturnAllowed,
                                         const fmi3ValueReference*, size_t, fmi3InstanceEnvironment instanceEnvironment,
                                         fmi3LogMessageCallback logMessage, fmi3IntermediateUpdateCallback intermediateUpdate) {
    Instance::Options options;
    options.event_mode_used = eventModeUsed;
    options.early_return_allowed = earlyReturnAllowed;
    Instance* made = Instance::create(instanceName, instantiationToken, options, importer(instanceEnvironment, logMessage));
    if (!made) return nullptr;
    made->logging = loggingOn;
    made->intermediate_callback = reinterpret_cast<void*>(intermediateUpdate);
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
    if (!instance || !of(instance)->allowed(Call::enter_initialization)) return fmi3Error;
    if (of(instance)->set_up_experiment(startTime, stopTimeDefined, stopTime) != Status::ok) return fmi3Error;
    return to_fmi(of(instance)->enter_initialization());
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance) {
    return instance ? to_fmi(of(instance)->exit_initialization(false)) : fmi3Error;
}

fmi3Status fmi3EnterEventMode(fmi3Instance instance) {
    return instance ? to_fmi(of(instance)->change_mode(Call::enter_event_mode, hnav::fmu::event)) : fmi3Error;
}

fmi3Status fmi3EnterStepMode(fmi3Instance instance) {
    return instance ? to_fmi(of(instance)->change_mode(Call::enter_step_mode, hnav::fmu::step)) : fmi3Error;
}

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance) {
    return instance ? to_fmi(of(instance)->change_mode(Call::enter_continuous_time_mode, hnav::fmu::continuous)) : fmi3Error;
}

fmi3Status fmi3Terminate(fmi3Instance instance) { return instance ? to_fmi(of(instance)->terminate()) : fmi3Error; }
fmi3Status fmi3Reset(fmi3Instance instance) { return instance ? to_fmi(of(instance)->reset()) : fmi3Error; }
fmi3Status fmi3EnterConfigurationMode(fmi3Instance instance) { return unsupported(instance, "EnterConfigurationMode"); }
fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance) { return unsupported(instance, "ExitConfigurationMode"); }

// ------------------------------------------------------------------------------------------------ variables

fmi3Status fmi3GetFloat64(fmi3Instance i, const fmi3ValueReference vr[], size_t n, fmi3Float64 values[], size_t n_values) {
    return get(i, Type::real, vr, n, values, n_values);
}
fmi3Status fmi3GetInt32(fmi3Instance i, const fmi3ValueReference vr[], size_t n, fmi3Int32 values[], size_t n_values) {
    return get(i, Type::integer, vr, n, values, n_values);
}
fmi3Status fmi3GetInt64(fmi3Instance i, const fmi3ValueReference vr[], size_t n, fmi3Int64 values[], size_t n_values) {
    return get(i, Type::enumeration, vr, n, values, n_values);
}
fmi3Status fmi3GetBoolean(fmi3Instance i, const fmi3ValueReference vr[], size_t n, fmi3Boolean values[], size_t n_values) {
    return get(i, Type::boolean, vr, n, values, n_values);
}
fmi3Status fmi3SetFloat64(fmi3Instance i, const fmi3ValueReference vr[], size_t n, const fmi3Float64 values[], size_t n_values) {
    return set(i, Type::real, vr, n, values, n_values);
}
fmi3Status fmi3SetInt32(fmi3Instance i, const fmi3ValueReference vr[], size_t n, const fmi3Int32 values[], size_t n_values) {
    return set(i, Type::integer, vr, n, values, n_values);
}
fmi3Status fmi3SetInt64(fmi3Instance i, const fmi3ValueReference vr[], size_t n, const fmi3Int64 values[], size_t n_values) {
    return set(i, Type::enumeration, vr, n, values, n_values);
}
fmi3Status fmi3SetBoolean(fmi3Instance i, const fmi3ValueReference vr[], size_t n, const fmi3Boolean values[], size_t n_values) {
    return set(i, Type::boolean, vr, n, values, n_values);
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
fmi3Status fmi3GetClock(fmi3Instance i, const fmi3ValueReference[], size_t n, fmi3Clock[]) { return none_of_type(i, n, "Clock"); }
fmi3Status fmi3SetClock(fmi3Instance i, const fmi3ValueReference[], size_t n, const fmi3Clock[]) {
    return none_of_type(i, n, "Clock");
}

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance i, fmi3ValueReference, size_t*) {
    return unsupported(i, "GetNumberOfVariableDependencies");
}
fmi3Status fmi3GetVariableDependencies(fmi3Instance i, fmi3ValueReference, size_t[], fmi3ValueReference[], size_t[],
                                       fmi3DependencyKind[], size_t) {
    return unsupported(i, "GetVariableDependencies");
}

// ------------------------------------------------------------------------------------------------ complete state

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState* state) {
    return instance ? to_fmi(of(instance)->take_snapshot(reinterpret_cast<Instance::Snapshot**>(state))) : fmi3Error;
}
fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state) {
    return instance ? to_fmi(of(instance)->restore_snapshot(static_cast<Instance::Snapshot*>(state))) : fmi3Error;
}
fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState* state) {
    if (!instance) return fmi3Error;
    if (!state) return fmi3OK;
    Instance::free_snapshot(static_cast<Instance::Snapshot*>(*state));
    *state = nullptr;
    return fmi3OK;
}
fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t* size) {
    if (!instance) return fmi3Error;
    if (!state || !size) return to_fmi(of(instance)->fail("SerializedFMUStateSize got a null pointer"));
    *size = static_cast<Instance::Snapshot*>(state)->bytes;
    return fmi3OK;
}
fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
    return instance ? to_fmi(of(instance)->serialise(static_cast<Instance::Snapshot*>(state), bytes, size)) : fmi3Error;
}
fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[], size_t size, fmi3FMUState* state) {
    return instance ? to_fmi(of(instance)->deserialise(bytes, size, reinterpret_cast<Instance::Snapshot**>(state))) : fmi3Error;
}

// ------------------------------------------------------------------------------------------------ derivatives

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                        const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[], size_t nSeed,
                                        fmi3Float64 sensitivity[], size_t nSensitivity) {
    if (!instance) return fmi3Error;
    if (nKnowns != nSeed || nUnknowns != nSensitivity)
        return to_fmi(of(instance)->fail("GetDirectionalDerivative: all variables are scalars, but the array sizes differ"));
    return to_fmi(of(instance)->directional_derivative(unknowns, nUnknowns, knowns, nKnowns, seed, sensitivity));
}
fmi3Status fmi3GetAdjointDerivative(fmi3Instance i, const fmi3ValueReference[], size_t, const fmi3ValueReference[], size_t,
                                    const fmi3Float64[], size_t, fmi3Float64[], size_t) {
    return unsupported(i, "GetAdjointDerivative");
}

// ------------------------------------------------------------------------------------------------ clocks: none

fmi3Status fmi3GetIntervalDecimal(fmi3Instance i, const fmi3ValueReference[], size_t, fmi3Float64[], fmi3IntervalQualifier[]) {
    return unsupported(i, "GetIntervalDecimal");
}
fmi3Status fmi3GetIntervalFraction(fmi3Instance i, const fmi3ValueReference[], size_t, fmi3UInt64[], fmi3UInt64[],
                                   fmi3IntervalQualifier[]) {
    return unsupported(i, "GetIntervalFraction");
}
fmi3Status fmi3GetShiftDecimal(fmi3Instance i, const fmi3ValueReference[], size_t, fmi3Float64[]) {
    return unsupported(i, "GetShiftDecimal");
}
fmi3Status fmi3GetShiftFraction(fmi3Instance i, const fmi3ValueReference[], size_t, fmi3UInt64[], fmi3UInt64[]) {
    return unsupported(i, "GetShiftFraction");
}
fmi3Status fmi3SetIntervalDecimal(fmi3Instance i, const fmi3ValueReference[], size_t, const fmi3Float64[]) {
    return unsupported(i, "SetIntervalDecimal");
}
fmi3Status fmi3SetIntervalFraction(fmi3Instance i, const fmi3ValueReference[], size_t, const fmi3UInt64[], const fmi3UInt64[]) {
    return unsupported(i, "SetIntervalFraction");
}
fmi3Status fmi3SetShiftDecimal(fmi3Instance i, const fmi3ValueReference[], size_t, const fmi3Float64[]) {
    return unsupported(i, "SetShiftDecimal");
}
fmi3Status fmi3SetShiftFraction(fmi3Instance i, const fmi3ValueReference[], size_t, const fmi3UInt64[], const fmi3UInt64[]) {
    return unsupported(i, "SetShiftFraction");
}
fmi3Status fmi3ActivateModelPartition(fmi3Instance i, fmi3ValueReference, fmi3Float64) {
    return unsupported(i, "ActivateModelPartition");
}

// ------------------------------------------------------------------------------------------------ events

// Nothing is to be evaluated apart from an update: outputs follow the states of the last event.
fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance) {
    return instance && of(instance)->allowed(Call::update_discrete_states) ? fmi3OK : fmi3Error;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean* discreteStatesNeedUpdate,
                                    fmi3Boolean* terminateSimulation, fmi3Boolean* nominalsOfContinuousStatesChanged,
                                    fmi3Boolean* valuesOfContinuousStatesChanged, fmi3Boolean* nextEventTimeDefined,
                                    fmi3Float64* nextEventTime) {
    if (!instance) return fmi3Error;
    if (!discreteStatesNeedUpdate || !terminateSimulation || !nominalsOfContinuousStatesChanged ||
        !valuesOfContinuousStatesChanged || !nextEventTimeDefined || !nextEventTime)
        return to_fmi(of(instance)->fail("UpdateDiscreteStates got a null pointer"));
    Instance::Events events;
    const Status status = of(instance)->update_discrete_states(&events);
    *discreteStatesNeedUpdate = *terminateSimulation = fmi3False;
    *nominalsOfContinuousStatesChanged = *valuesOfContinuousStatesChanged = events.states_changed;
    *nextEventTimeDefined = events.next_event_defined;
    *nextEventTime = events.next_event_s;
    return to_fmi(status);
}

// ------------------------------------------------------------------------------------------------ Model Exchange

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time) {
    return instance ? to_fmi(of(instance)->set_time(time)) : fmi3Error;
}
fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 states[], size_t n) {
    return instance ? to_fmi(of(instance)->set_states(states, n)) : fmi3Error;
}
fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 states[], size_t n) {
    return instance ? to_fmi(of(instance)->get_states(states, n)) : fmi3Error;
}
fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 derivatives[], size_t n) {
    return instance ? to_fmi(of(instance)->get_derivatives(derivatives, n)) : fmi3Error;
}
fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals[], size_t n) {
    return instance ? to_fmi(of(instance)->get_nominals(nominals, n)) : fmi3Error;
}
fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64[], size_t n) {
    if (!instance || !of(instance)->allowed(Call::get_continuous_states)) return fmi3Error;
    return n == 0 ? fmi3OK : to_fmi(of(instance)->fail("there are no event indicators, but %zu were asked for", n));
}
fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t* n) {
    if (!instance) return fmi3Error;
    if (!n) return to_fmi(of(instance)->fail("GetNumberOfEventIndicators got a null pointer"));
    *n = 0;
    return fmi3OK;
}
fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t* n) {
    if (!instance) return fmi3Error;
    if (!n) return to_fmi(of(instance)->fail("GetNumberOfContinuousStates got a null pointer"));
    *n = static_cast<size_t>(hnav::fmu::model_info.nx);
    return fmi3OK;
}
fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean, fmi3Boolean* enterEventMode,
                                       fmi3Boolean* terminateSimulation) {
    if (!instance) return fmi3Error;
    if (!enterEventMode || !terminateSimulation) return to_fmi(of(instance)->fail("CompletedIntegratorStep got a null pointer"));
    *enterEventMode = *terminateSimulation = fmi3False;
    return to_fmi(of(instance)->completed_integrator_step());
}

// ------------------------------------------------------------------------------------------------ Co-Simulation

fmi3Status fmi3GetOutputDerivatives(fmi3Instance i, const fmi3ValueReference[], size_t, const fmi3Int32[], fmi3Float64[],
                                    size_t) {
    return unsupported(i, "GetOutputDerivatives");
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 currentCommunicationPoint, fmi3Float64 communicationStepSize,
                      fmi3Boolean, fmi3Boolean* eventHandlingNeeded, fmi3Boolean* terminateSimulation, fmi3Boolean* earlyReturn,
                      fmi3Float64* lastSuccessfulTime) {
    if (!instance) return fmi3Error;
    if (!eventHandlingNeeded || !terminateSimulation || !earlyReturn || !lastSuccessfulTime)
        return to_fmi(of(instance)->fail("DoStep got a null pointer"));
    Instance::Step step;
    const Status status = of(instance)->do_step(currentCommunicationPoint, communicationStepSize,
                                                of(instance)->intermediate_callback ? intermediate_update : nullptr, &step);
    *eventHandlingNeeded = step.event_handling_needed;
    *terminateSimulation = fmi3False;
    *earlyReturn = step.early_return;
    *lastSuccessfulTime = step.last_successful_s;
    return to_fmi(status);
}

} // extern "C"
