/* A mass on a spring as an FMU for Co-Simulation, FMI 2, in Euler's steps of 1 ms:
 *     x' = v,  v' = -k x - 0.3 v + u,  y = x + v,  late: x at the end of the newest step               u: input, k: tunable
 * At a wall, x < -0.9 where wall is 1, it is thrown back, and its spring is half as stiff for ever, a discrete state that no variable shows.
 * mode 1: states cannot be set between steps. 2: a step ends with fmi2Discard where |v| > 3. 3: with fmi2Error after 1 s. */
#include <fmi2Functions.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { X, V, DX, DV, K, U, Y, LATE, WALL, MODE, SINE, COUNT };

typedef struct {
    double value[COUNT], t;
    int broken, begun;
    fmi2CallbackFunctions callbacks;
} Plant;

static fmi2Status say(Plant* p, fmi2Status s, const char* text) {
    p->callbacks.logger(p->callbacks.componentEnvironment, "plant", s, "error", "%s", text);
    return s;
}

const char* fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char* fmi2GetVersion(void) { return fmi2Version; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String uri,
                              const fmi2CallbackFunctions* callbacks, fmi2Boolean visible, fmi2Boolean logging) {
    (void)name, (void)uri, (void)visible, (void)logging;
    if (type != fmi2CoSimulation || strcmp(guid, "{steps}") != 0) return NULL;
    Plant* p = calloc(1, sizeof *p);
    p->callbacks = *callbacks;
    p->value[X] = p->value[LATE] = 1;
    p->value[K] = 4;
    return p;
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean a, fmi2Real b, fmi2Real start, fmi2Boolean d, fmi2Real e) {
    (void)a, (void)b, (void)d, (void)e;
    ((Plant*)c)->t = start;
    return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return c ? fmi2OK : fmi2Error; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    ((Plant*)c)->begun = 1;
    return fmi2OK;
}
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Real value[]) {
    Plant* p = c;
    for (size_t i = 0; i < n; ++i) {
        if (p->begun && r[i] <= V && p->value[MODE] == 1) return say(p, fmi2Error, "not between steps");
        p->value[r[i]] = value[i];
    }
    return fmi2OK;
}
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real value[]) {
    Plant* p = c;
    p->value[Y] = p->value[X] + p->value[V];
    for (size_t i = 0; i < n; ++i) value[i] = p->value[r[i]];
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real length, fmi2Boolean no_return) {
    Plant* p = c;
    double* v = p->value;
    if (no_return || fabs(t - p->t) > 1e-9) return say(p, fmi2Error, "its time is another one");
    for (int k = 0; k < (int)(length / 1e-3 + 0.5); ++k) {
        const double pull = v[SINE] ? sin(v[X]) : v[X], dx = v[V], dv = -v[K] * pull - 0.3 * v[V] + v[U];
        v[X] += 1e-3 * dx;
        v[V] += 1e-3 * dv;
        if (v[WALL] && v[X] < -0.9 && v[V] < 0) {
            v[V] = -v[V];
            if (!p->broken) v[K] *= 0.5;
            p->broken = 1;
        }
        if (v[MODE] == 2 && fabs(v[V]) > 3) return say(p, fmi2Discard, "too fast");
    }
    if (v[MODE] == 3 && t > 1) return say(p, fmi2Error, "the spring broke");
    v[LATE] = v[X];
    p->t = t + length;
    return fmi2OK;
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate* state) {
    if (!*state) *state = malloc(sizeof(Plant));
    memcpy(*state, c, sizeof(Plant));
    return fmi2OK;
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    const fmi2CallbackFunctions callbacks = ((Plant*)c)->callbacks;
    memcpy(c, state, sizeof(Plant));
    ((Plant*)c)->callbacks = callbacks;
    return fmi2OK;
}
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate* state) {
    (void)c;
    free(*state);
    *state = NULL;
    return fmi2OK;
}
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t* size) {
    (void)c, (void)state;
    *size = sizeof(Plant);
    return fmi2OK;
}
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    (void)c;
    memcpy(bytes, state, size);
    return fmi2OK;
}
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate* state) {
    (void)c;
    *state = malloc(size);
    memcpy(*state, bytes, size);
    return fmi2OK;
}
