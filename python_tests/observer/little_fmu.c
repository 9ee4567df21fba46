/* A mass on a spring as an FMU for Model Exchange, FMI 2, that can be made to fail: what it does wrong is its parameter mode.
 *     x' = v,  v' = -k x - 0.3 v + u,  y = x + d,  z = v x (local)                                d: input, k: tunable */
#include <fmi2Functions.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { X, V, DX, DV, K, U, D, Y, Z, MODE, COUNT };
enum { SOUND, NAN_AFTER_1, ERROR_AFTER_1, ITERATES, TERMINATES, LIES, ONE_QUESTION, REMEMBERS, EVENT_AT_5, DISCARDS_ABOVE_3, FATAL_AFTER_1 };

typedef struct {
    double value[COUNT], t;
    int lost, asked;
    fmi2CallbackFunctions callbacks;
} Plant;

static int instances = 0;

static fmi2Status status(Plant* p, fmi2Status s, const char* text) {
    if (s > fmi2OK && p->callbacks.logger) p->callbacks.logger(p->callbacks.componentEnvironment, "plant", s, "error", "%s", text);
    if (s >= fmi2Error) p->lost = 1;
    return s;
}
#define SOUND_INSTANCE(c)                                                                                                        \
    Plant* p = c;                                                                                                                \
    if (p->lost) return status(p, fmi2Error, "not allowed in this state")

const char* fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char* fmi2GetVersion(void) { return fmi2Version; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String uri, const fmi2CallbackFunctions* callbacks,
                              fmi2Boolean visible, fmi2Boolean logging) {
    (void)name, (void)visible, (void)logging;
    Plant* p;
    if (type != fmi2ModelExchange || strcmp(guid, "{little}") != 0 || strncmp(uri, "file:///", 8) != 0) return NULL;
#ifdef ONCE
    if (instances > 0) return NULL;
#endif
    p = calloc(1, sizeof *p);
    p->callbacks = *callbacks;
    p->value[X] = 1;
    p->value[K] = 4;
    ++instances;
    return p;
}
void fmi2FreeInstance(fmi2Component c) {
#ifdef CRASHES_WHEN_FREED
    abort();
#endif
    --instances;
    free(c);
}
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean a, fmi2Real b, fmi2Real start, fmi2Boolean d, fmi2Real e) {
    (void)a, (void)b, (void)d, (void)e;
    ((Plant*)c)->t = start;
    return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return ((Plant*)c)->lost ? fmi2Error : fmi2OK; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return ((Plant*)c)->lost ? fmi2Error : fmi2OK; }
fmi2Status fmi2EnterEventMode(fmi2Component c) {
    SOUND_INSTANCE(c);
    return fmi2OK;
}
fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
    SOUND_INSTANCE(c);
    return fmi2OK;
}
fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo* info) {
    SOUND_INSTANCE(c);
    memset(info, 0, sizeof *info);
    info->newDiscreteStatesNeeded = p->value[MODE] == ITERATES;
    info->terminateSimulation = p->value[MODE] == TERMINATES;
    info->nextEventTimeDefined = p->value[MODE] == EVENT_AT_5;
    info->nextEventTime = 5;
    return fmi2OK;
}

static fmi2Status calculate(Plant* p) {
    double* v = p->value;
    const int late = p->t > 1;
#ifdef EXITS
    exit(0);
#endif
#ifdef ENDLESS
    fclose(fopen(getenv("LITTLE_LOOPS"), "w")); /* says that it has begun */
    for (volatile int i = 0; i >= 0; i = 0) continue;
#endif
    v[DX] = v[V];
    v[DV] = -v[K] * v[X] - 0.3 * v[V] + v[U];
    v[Y] = v[X] + v[D];
    v[Z] = v[V] * v[X];
    if (v[MODE] == NAN_AFTER_1 && late) v[DV] = NAN;
    if (v[MODE] == REMEMBERS) v[DV] += 1e-3 * p->asked++;
    if (v[MODE] == ERROR_AFTER_1 && late) return status(p, fmi2Error, "the spring broke");
    if (v[MODE] == FATAL_AFTER_1 && late) return status(p, fmi2Fatal, "the house burnt down");
    if (v[MODE] == DISCARDS_ABOVE_3 && fabs(v[V]) > 3) return status(p, fmi2Discard, "too fast");
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real value[]) {
    SOUND_INSTANCE(c);
    const fmi2Status s = calculate(p);
    for (size_t i = 0; i < n; ++i) value[i] = p->value[r[i]];
    return s;
}
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Real value[]) {
    SOUND_INSTANCE(c);
    for (size_t i = 0; i < n; ++i) p->value[r[i]] = value[i];
    return fmi2OK;
}
fmi2Status fmi2SetTime(fmi2Component c, fmi2Real t) {
    SOUND_INSTANCE(c);
    p->t = t;
    return fmi2OK;
}
fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) {
    SOUND_INSTANCE(c);
    memcpy(p->value + X, x, n * sizeof *x);
    return fmi2OK;
}
fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    SOUND_INSTANCE(c);
    memcpy(x, p->value + X, n * sizeof *x);
    return fmi2OK;
}
fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    SOUND_INSTANCE(c);
    for (size_t i = 0; i < n; ++i) x[i] = 1;
    return fmi2OK;
}
fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real dx[], size_t n) {
    SOUND_INSTANCE(c);
#ifdef CALLS_ITSELF
    static const fmi2ValueReference derivatives[] = {DX, DV};
    return fmi2GetReal(c, derivatives, n, dx);
#endif
    const fmi2Status s = calculate(p);
    memcpy(dx, p->value + DX, n * sizeof *dx);
    return s;
}
fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference of[], size_t rows, const fmi2ValueReference by[],
                                        size_t columns, const fmi2Real seed[], fmi2Real out[]) {
    SOUND_INSTANCE(c);
    if (p->value[MODE] == ONE_QUESTION) return status(p, fmi2Error, "derivatives are not offered");
    for (size_t i = 0; i < rows; ++i) {
        out[i] = 0;
        for (size_t k = 0; k < columns; ++k) {
            double d = 0;
            if (of[i] == Z || by[k] == K) return status(p, fmi2Error, "an illegal question");
            if (of[i] == by[k] || (of[i] == DX && by[k] == V)) d = 1;
            if (of[i] == DV) d = by[k] == X ? -p->value[K] : by[k] == V ? -0.3 : by[k] == U ? 1 : 0;
            if (of[i] == Y && (by[k] == X || by[k] == D)) d = 1;
            if (of[i] == DV && by[k] == V && p->value[MODE] == LIES) d = 0.3;
            out[i] += d * seed[k];
        }
    }
    return fmi2OK;
}
