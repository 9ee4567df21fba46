/* A chain of 64 numbers as an FMU for Model Exchange, FMI 2, of which each follows the next one: x_i' = x_(i+1) - x_i, the last x' = -x.
 * No events, no derivatives, no saved states: the least that an FMU may be. */
#include <fmi2Functions.h>

#include <stdlib.h>
#include <string.h>

enum { N = 64 };
typedef struct {
    double x[N];
} Plant;

#define NOTHING(name) \
    fmi2Status name(fmi2Component c) { \
        (void)c; \
        return fmi2OK; \
    }

const char* fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char* fmi2GetVersion(void) { return fmi2Version; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String uri, const fmi2CallbackFunctions* callbacks,
                              fmi2Boolean visible, fmi2Boolean logging) {
    (void)name, (void)type, (void)guid, (void)uri, (void)callbacks, (void)visible, (void)logging;
    return calloc(1, sizeof(Plant));
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean a, fmi2Real b, fmi2Real start, fmi2Boolean d, fmi2Real e) {
    (void)c, (void)a, (void)b, (void)start, (void)d, (void)e;
    return fmi2OK;
}
NOTHING(fmi2EnterInitializationMode)
NOTHING(fmi2ExitInitializationMode)
NOTHING(fmi2EnterEventMode)
NOTHING(fmi2EnterContinuousTimeMode)
fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo* info) {
    (void)c;
    memset(info, 0, sizeof *info);
    return fmi2OK;
}
fmi2Status fmi2SetTime(fmi2Component c, fmi2Real t) {
    (void)c, (void)t;
    return fmi2OK;
}
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Real value[]) {
    for (size_t i = 0; i < n; ++i) ((Plant*)c)->x[r[i]] = value[i];
    return fmi2OK;
}
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real value[]) {
    for (size_t i = 0; i < n; ++i) value[i] = ((Plant*)c)->x[r[i]];
    return fmi2OK;
}
fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) {
    memcpy(((Plant*)c)->x, x, n * sizeof *x);
    return fmi2OK;
}
fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    memcpy(x, ((Plant*)c)->x, n * sizeof *x);
    return fmi2OK;
}
fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    (void)c;
    for (size_t i = 0; i < n; ++i) x[i] = 1;
    return fmi2OK;
}
fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real dx[], size_t n) {
    const double* x = ((Plant*)c)->x;
    for (size_t i = 0; i < n; ++i) dx[i] = (i + 1 < n ? x[i + 1] : 0) - x[i];
    return fmi2OK;
}
