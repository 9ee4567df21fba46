/* A mass on a spring as an FMU for Co-Simulation, FMI 2 or with FMI3 defined FMI 3, in Euler's steps of 1 ms:
 *     x' = v,  v' = -k x - 0.3 v + u,  y = x + v,  late: x at the end of the newest step               u: input, k: tunable
 * At a wall, x < -0.9 where wall is 1, it is thrown back, and its spring is half as stiff for ever, a discrete state that no variable shows.
 * mode 1: states cannot be set between steps. 2: a step is discarded where |v| > 3. 3: a step fails after 1 s. */
#ifdef FMI3
#include <fmi3Functions.h>
#define FMI(name) fmi3##name
#define STATE(before, after) fmi3##before##FMUState##after
#define fmi3DeSerializeFMUState fmi3DeserializeFMUState
typedef fmi3Instance Component;
#else
#include <fmi2Functions.h>
#define FMI(name) fmi2##name
#define STATE(before, after) fmi2##before##FMUstate##after
typedef fmi2Component Component;
#endif

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { X, V, DX, DV, K, U, Y, LATE, WALL, MODE, SINE, COUNT };

typedef struct {
    double value[COUNT], t;
    int broken, begun;
} State;

typedef struct {
    State s;
#ifdef FMI3
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
#else
    fmi2CallbackFunctions callbacks;
#endif
} Plant;

static FMI(Status) say(Plant* p, FMI(Status) status, const char* text) {
#ifdef FMI3
    p->log(p->environment, status, "error", text);
#else
    p->callbacks.logger(p->callbacks.componentEnvironment, "plant", status, "error", "%s", text);
#endif
    return status;
}

static Plant* made(void) {
    Plant* p = calloc(1, sizeof *p);
    p->s.value[X] = p->s.value[LATE] = 1;
    p->s.value[K] = 4;
    return p;
}

static FMI(Status) put(Plant* p, const FMI(ValueReference) r[], size_t n, const double value[]) {
    for (size_t i = 0; i < n; ++i) {
        if (p->s.begun && r[i] <= V && p->s.value[MODE] == 1) return say(p, FMI(Error), "not between steps");
        p->s.value[r[i]] = value[i];
    }
    return FMI(OK);
}

static FMI(Status) take(Plant* p, const FMI(ValueReference) r[], size_t n, double value[]) {
    p->s.value[Y] = p->s.value[X] + p->s.value[V];
    for (size_t i = 0; i < n; ++i) value[i] = p->s.value[r[i]];
    return FMI(OK);
}

static FMI(Status) advance(Plant* p, double t, double length) {
    double* v = p->s.value;
    if (fabs(t - p->s.t) > 1e-9) return say(p, FMI(Error), "its time is another one");
    for (int k = 0; k < (int)(length / 1e-3 + 0.5); ++k) {
        const double pull = v[SINE] ? sin(v[X]) : v[X], dx = v[V], dv = -v[K] * pull - 0.3 * v[V] + v[U];
        v[X] += 1e-3 * dx;
        v[V] += 1e-3 * dv;
        if (v[WALL] && v[X] < -0.9 && v[V] < 0) {
            v[V] = -v[V];
            if (!p->s.broken) v[K] *= 0.5;
            p->s.broken = 1;
        }
        if (v[MODE] == 2 && fabs(v[V]) > 3) return say(p, FMI(Discard), "too fast");
    }
    if (v[MODE] == 3 && t > 1) return say(p, FMI(Error), "the spring broke");
    v[LATE] = v[X];
    p->s.t = t + length;
    return FMI(OK);
}

#ifdef FMI3
const char* fmi3GetVersion(void) { return fmi3Version; }

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String path, fmi3Boolean visible, fmi3Boolean logging,
                                         fmi3Boolean events, fmi3Boolean early, const fmi3ValueReference between[], size_t count,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update) {
    (void)name, (void)path, (void)visible, (void)logging, (void)between, (void)update;
    if (events || early || count || strcmp(token, "{steps}") != 0) return NULL;
    Plant* p = made();
    p->environment = environment;
    p->log = log;
    return p;
}
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean a, fmi3Float64 b, fmi3Float64 start, fmi3Boolean d, fmi3Float64 e) {
    (void)a, (void)b, (void)d, (void)e;
    ((Plant*)c)->s.t = start;
    return fmi3OK;
}
fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference r[], size_t n, const fmi3Float64 value[], size_t values) {
    return n == values ? put(c, r, n, value) : fmi3Error;
}
fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference r[], size_t n, fmi3Float64 value[], size_t values) {
    return n == values ? take(c, r, n, value) : fmi3Error;
}
fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 length, fmi3Boolean no_return, fmi3Boolean* event,
                      fmi3Boolean* terminate, fmi3Boolean* early, fmi3Float64* last) {
    *event = *terminate = *early = false;
    const fmi3Status status = no_return ? fmi3Error : advance(c, t, length);
    *last = ((Plant*)c)->s.t;
    return status;
}
#else
const char* fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char* fmi2GetVersion(void) { return fmi2Version; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String uri,
                              const fmi2CallbackFunctions* callbacks, fmi2Boolean visible, fmi2Boolean logging) {
    (void)name, (void)uri, (void)visible, (void)logging;
    if (type != fmi2CoSimulation || strcmp(guid, "{steps}") != 0) return NULL;
    Plant* p = made();
    p->callbacks = *callbacks;
    return p;
}
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean a, fmi2Real b, fmi2Real start, fmi2Boolean d, fmi2Real e) {
    (void)a, (void)b, (void)d, (void)e;
    ((Plant*)c)->s.t = start;
    return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return c ? fmi2OK : fmi2Error; }
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Real value[]) { return put(c, r, n, value); }
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real value[]) { return take(c, r, n, value); }
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real length, fmi2Boolean no_return) {
    return no_return ? fmi2Error : advance(c, t, length);
}
#endif

FMI(Status) FMI(ExitInitializationMode)(Component c) {
    ((Plant*)c)->s.begun = 1;
    return FMI(OK);
}
void FMI(FreeInstance)(Component c) { free(c); }

FMI(Status) STATE(Get, )(Component c, STATE(, ) * state) {
    if (!*state) *state = malloc(sizeof(State));
    memcpy(*state, &((Plant*)c)->s, sizeof(State));
    return FMI(OK);
}
FMI(Status) STATE(Set, )(Component c, STATE(, ) state) {
    memcpy(&((Plant*)c)->s, state, sizeof(State));
    return FMI(OK);
}
FMI(Status) STATE(Free, )(Component c, STATE(, ) * state) {
    (void)c;
    free(*state);
    *state = NULL;
    return FMI(OK);
}
FMI(Status) STATE(Serialized, Size)(Component c, STATE(, ) state, size_t* size) {
    (void)c, (void)state;
    *size = sizeof(State);
    return FMI(OK);
}
FMI(Status) STATE(Serialize, )(Component c, STATE(, ) state, FMI(Byte) bytes[], size_t size) {
    (void)c;
    memcpy(bytes, state, size);
    return FMI(OK);
}
FMI(Status) STATE(DeSerialize, )(Component c, const FMI(Byte) bytes[], size_t size, STATE(, ) * state) {
    (void)c;
    *state = malloc(size);
    memcpy(*state, bytes, size);
    return FMI(OK);
}
