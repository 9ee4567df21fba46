/* A rod of N cells as an FMU for Model Exchange, FMI 2: heat goes from each cell to its neighbours, x_i' = RATE (x_(i-1) - 2 x_i + x_(i+1)),
 * and none leaves at its ends. No events, no saved states; directional derivatives where DIRECTIONAL is defined. */
#include <fmi2Functions.h>

#include <stdlib.h>
#include <string.h>

typedef struct {
    double x[N];
} Rod;

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
    return calloc(1, sizeof(Rod));
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
    for (size_t i = 0; i < n; ++i) ((Rod*)c)->x[r[i]] = value[i];
    return fmi2OK;
}
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real value[]) {
    for (size_t i = 0; i < n; ++i) value[i] = ((Rod*)c)->x[r[i]];
    return fmi2OK;
}
fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) {
    memcpy(((Rod*)c)->x, x, n * sizeof *x);
    return fmi2OK;
}
fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    memcpy(x, ((Rod*)c)->x, n * sizeof *x);
    return fmi2OK;
}
fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    (void)c;
    for (size_t i = 0; i < n; ++i) x[i] = 1;
    return fmi2OK;
}

static void flow(const double* x, double* dx) {
    for (int i = 0; i < N; ++i) {
        const double left = i > 0 ? x[i - 1] : x[i], right = i + 1 < N ? x[i + 1] : x[i];
        dx[i] = RATE * (left - 2 * x[i] + right);
    }
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real dx[], size_t n) {
    (void)n;
    flow(((Rod*)c)->x, dx);
    return fmi2OK;
}

#ifdef DIRECTIONAL
/* Of a linear flow: the flow along the direction. */
fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t rows, const fmi2ValueReference known[],
                                        size_t n, const fmi2Real seed[], fmi2Real out[]) {
    double direction[N] = {0}, along[N];
    (void)c;
    for (size_t k = 0; k < n; ++k) direction[known[k]] = seed[k];
    flow(direction, along);
    for (size_t i = 0; i < rows; ++i) out[i] = unknown[i] < N ? direction[unknown[i]] : along[unknown[i] - N];
    return fmi2OK;
}
#endif
