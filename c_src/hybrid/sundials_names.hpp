// One spelling for SUNDIALS 6.4 to 7.x: version 7 renamed ERKStepX and ARKStepX to ARKodeX, and errors are silenced on the context.
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
#define HNAV_ERK(call) ARKode##call
#define HNAV_ARK(call) ARKode##call
using real = sunrealtype;
using boolean = sunbooleantype;

inline int create_context(SUNContext* context) {
    const int rc = SUNContext_Create(SUN_COMM_NULL, context);
    if (rc == 0) SUNContext_ClearErrHandlers(*context);
    return rc;
}
inline void silence_erk(void*) {}
inline void silence_ark(void*) {}
inline void silence_cv(void*) {}
constexpr int unused_interpolant = ARK_INTERP_LAGRANGE; // the cheapest: Hermite's evaluates the flow at the end of a step
#else
#define HNAV_ERK(call) ERKStep##call
#define HNAV_ARK(call) ARKStep##call
using real = realtype;
using boolean = booleantype;

inline void ignore_error(int, const char*, const char*, char*, void*) {}
inline int create_context(SUNContext* context) { return SUNContext_Create(nullptr, context); }
inline void silence_erk(void* memory) { ERKStepSetErrHandlerFn(memory, ignore_error, nullptr); }
inline void silence_ark(void* memory) { ARKStepSetErrHandlerFn(memory, ignore_error, nullptr); }
inline void silence_cv(void* memory) { CVodeSetErrHandlerFn(memory, ignore_error, nullptr); }
constexpr int unused_interpolant = ARK_INTERP_HERMITE; // the cheapest: it copies two existing vectors
#endif
using length = sunindextype;

inline void free_erk(void** memory) { HNAV_ERK(Free)(memory); }
inline void free_ark(void** memory) { HNAV_ARK(Free)(memory); }
constexpr auto erk_tolerances = HNAV_ERK(SVtolerances);
constexpr auto erk_set_user_data = HNAV_ERK(SetUserData);
constexpr auto erk_set_interpolant_type = HNAV_ERK(SetInterpolantType);
constexpr auto erk_set_interpolant_degree = HNAV_ERK(SetInterpolantDegree);
constexpr auto erk_set_max_steps = HNAV_ERK(SetMaxNumSteps);
constexpr auto erk_set_first_step = HNAV_ERK(SetInitStep);
constexpr auto erk_set_stop_time = HNAV_ERK(SetStopTime);
constexpr auto erk_reset = HNAV_ERK(Reset);
constexpr auto erk_evolve = HNAV_ERK(Evolve);
constexpr auto erk_set_fixed_step = HNAV_ERK(SetFixedStep);
constexpr auto erk_weights = HNAV_ERK(WFtolerances);
constexpr auto erk_steps = HNAV_ERK(GetNumSteps);
constexpr auto erk_next_step = HNAV_ERK(GetCurrentStep);
constexpr auto erk_between = HNAV_ERK(GetDky);
constexpr auto ark_tolerances = HNAV_ARK(SVtolerances);
constexpr auto ark_set_user_data = HNAV_ARK(SetUserData);
constexpr auto ark_set_first_step = HNAV_ARK(SetInitStep);
constexpr auto ark_set_stop_time = HNAV_ARK(SetStopTime);
constexpr auto ark_reset = HNAV_ARK(Reset);
constexpr auto ark_evolve = HNAV_ARK(Evolve);
constexpr auto ark_set_interpolant_type = HNAV_ARK(SetInterpolantType);
constexpr auto ark_set_interpolant_degree = HNAV_ARK(SetInterpolantDegree);
constexpr auto ark_set_max_error_failures = HNAV_ARK(SetMaxErrTestFails);
constexpr auto ark_set_max_solver_failures = HNAV_ARK(SetMaxConvFails);
constexpr auto ark_between = HNAV_ARK(GetDky);
constexpr auto ark_set_linear_solver = HNAV_ARK(SetLinearSolver);
constexpr auto ark_set_jacobian = HNAV_ARK(SetJacFn);
#undef HNAV_ERK
#undef HNAV_ARK

} // namespace hnav::sundials
