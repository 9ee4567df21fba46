// One spelling for SUNDIALS 6.4 to 7.x: version 7 renamed ERKStepX to ARKodeX, and errors are silenced on the context.
#pragma once

#include <arkode/arkode_arkstep.h>
#include <arkode/arkode_erkstep.h>
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sundials/sundials_nvector.h>
#include <sundials/sundials_version.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

namespace hnav::sundials {

#if SUNDIALS_VERSION_MAJOR >= 7
using real = sunrealtype;
using boolean = sunbooleantype;
using length = sunindextype;

inline int create_context(SUNContext* context) {
    const int rc = SUNContext_Create(SUN_COMM_NULL, context);
    if (rc == 0) SUNContext_ClearErrHandlers(*context);
    return rc;
}
inline void silence_erk(void*) {}
inline void silence_cv(void*) {}
inline void free_erk(void** memory) { ARKodeFree(memory); }
constexpr auto erk_tolerances = ARKodeSVtolerances;
constexpr auto erk_set_user_data = ARKodeSetUserData;
constexpr auto erk_set_interpolant_type = ARKodeSetInterpolantType;
constexpr auto erk_set_interpolant_degree = ARKodeSetInterpolantDegree;
constexpr auto erk_set_max_steps = ARKodeSetMaxNumSteps;
constexpr auto erk_set_first_step = ARKodeSetInitStep;
constexpr auto erk_set_stop_time = ARKodeSetStopTime;
constexpr auto erk_reset = ARKodeReset;
constexpr auto erk_evolve = ARKodeEvolve;
constexpr auto erk_set_fixed_step = ARKodeSetFixedStep;
constexpr auto erk_weights = ARKodeWFtolerances;
constexpr auto erk_steps = ARKodeGetNumSteps;
constexpr auto erk_next_step = ARKodeGetCurrentStep;
constexpr auto erk_between = ARKodeGetDky;
constexpr int unused_interpolant = ARK_INTERP_LAGRANGE; // the cheapest: Hermite's evaluates the flow at the end of a step
inline void silence_ark(void*) {}
inline void free_ark(void** memory) { ARKodeFree(memory); }
constexpr auto ark_tolerances = ARKodeSVtolerances;
constexpr auto ark_set_user_data = ARKodeSetUserData;
constexpr auto ark_set_first_step = ARKodeSetInitStep;
constexpr auto ark_set_stop_time = ARKodeSetStopTime;
constexpr auto ark_reset = ARKodeReset;
constexpr auto ark_evolve = ARKodeEvolve;
constexpr auto ark_set_interpolant_type = ARKodeSetInterpolantType;
constexpr auto ark_set_interpolant_degree = ARKodeSetInterpolantDegree;
constexpr auto ark_set_max_error_failures = ARKodeSetMaxErrTestFails;
constexpr auto ark_set_max_solver_failures = ARKodeSetMaxConvFails;
constexpr auto ark_between = ARKodeGetDky;
constexpr auto ark_set_linear_solver = ARKodeSetLinearSolver;
constexpr auto ark_set_jacobian = ARKodeSetJacFn;
#else
using real = realtype;
using boolean = booleantype;
using length = sunindextype;

inline void ignore_error(int, const char*, const char*, char*, void*) {}
inline int create_context(SUNContext* context) { return SUNContext_Create(nullptr, context); }
inline void silence_erk(void* memory) { ERKStepSetErrHandlerFn(memory, ignore_error, nullptr); }
inline void silence_cv(void* memory) { CVodeSetErrHandlerFn(memory, ignore_error, nullptr); }
inline void free_erk(void** memory) { ERKStepFree(memory); }
constexpr auto erk_tolerances = ERKStepSVtolerances;
constexpr auto erk_set_user_data = ERKStepSetUserData;
constexpr auto erk_set_interpolant_type = ERKStepSetInterpolantType;
constexpr auto erk_set_interpolant_degree = ERKStepSetInterpolantDegree;
constexpr auto erk_set_max_steps = ERKStepSetMaxNumSteps;
constexpr auto erk_set_first_step = ERKStepSetInitStep;
constexpr auto erk_set_stop_time = ERKStepSetStopTime;
constexpr auto erk_reset = ERKStepReset;
constexpr auto erk_evolve = ERKStepEvolve;
constexpr auto erk_set_fixed_step = ERKStepSetFixedStep;
constexpr auto erk_weights = ERKStepWFtolerances;
constexpr auto erk_steps = ERKStepGetNumSteps;
constexpr auto erk_next_step = ERKStepGetCurrentStep;
constexpr auto erk_between = ERKStepGetDky;
constexpr int unused_interpolant = ARK_INTERP_HERMITE; // the cheapest: it copies two existing vectors
inline void silence_ark(void* memory) { ARKStepSetErrHandlerFn(memory, ignore_error, nullptr); }
inline void free_ark(void** memory) { ARKStepFree(memory); }
constexpr auto ark_tolerances = ARKStepSVtolerances;
constexpr auto ark_set_user_data = ARKStepSetUserData;
constexpr auto ark_set_first_step = ARKStepSetInitStep;
constexpr auto ark_set_stop_time = ARKStepSetStopTime;
constexpr auto ark_reset = ARKStepReset;
constexpr auto ark_evolve = ARKStepEvolve;
constexpr auto ark_set_interpolant_type = ARKStepSetInterpolantType;
constexpr auto ark_set_interpolant_degree = ARKStepSetInterpolantDegree;
constexpr auto ark_set_max_error_failures = ARKStepSetMaxErrTestFails;
constexpr auto ark_set_max_solver_failures = ARKStepSetMaxConvFails;
constexpr auto ark_between = ARKStepGetDky;
constexpr auto ark_set_linear_solver = ARKStepSetLinearSolver;
constexpr auto ark_set_jacobian = ARKStepSetJacFn;
#endif

} // namespace hnav::sundials
