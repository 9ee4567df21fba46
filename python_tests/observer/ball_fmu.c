/* A ball that bounces as an FMU for Model Exchange, FMI 2, which watches over the order of calls: what is not allowed is an error, and
 * then it is lost. What it does wrong is its parameter mode.
 * (lifts: gravity points up, so that a ball thrown down hardly comes to the floor, which throws it back; switches: gravity becomes 2 m/s2
 * upwards at 1 s, an event of time that is lost while a second instance lives: as many as the library counts, or, with SHARES_PROCESS,
 * the process)
 *     h' = v,  v' = -g while free, 0 at rest;  h <= 0, v < 0: v = -e v, at rest below 0.1 m/s;  kick: a discrete input that adds to v */
#include <fmi2Functions.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { H, V, DH, DV, E, KICK, RESTS, BOUNCES, MODE, COUNT };
enum { SOUND, ITERATES, TERMINATES, ERROR_IN_EVENT, NAN_AFTER_EVENT, ENDLESS_TIMES, STEP_EVENT, GROWS, LIFTS, SWITCHES };
enum phase { START, EVENTS, CONTINUOUS };

typedef struct {
    double value[COUNT], t, kicked;
    enum phase phase;
    int lost, switched;
} State;
typedef struct {
    State s;
    fmi2CallbackFunctions callbacks;
} Plant;

int copies = 0; /* of states that are out */

/* How many instances live, one more or less. */
static int living(int by) {
#ifdef SHARES_PROCESS
    const char* before = getenv("HNAV_TEST_BALLS");
    char now[16];
    snprintf(now, sizeof now, "%d", (before ? atoi(before) : 0) + by);
    setenv("HNAV_TEST_BALLS", now, 1);
    return atoi(now);
#else
    static int count = 0;
    return count += by;
#endif
}

static fmi2Status fail(Plant* p, const char* text) {
    p->callbacks.logger(p->callbacks.componentEnvironment, "plant", fmi2Error, "error", "%s", text);
    p->s.lost = 1;
    return fmi2Error;
}
#define IN(c, condition)                                                                                                         \
    Plant* p = c;                                                                                                                \
    if (p->s.lost || !(condition)) return fail(p, "not allowed in this state")
#define ALWAYS 1
#define MODE_IS(m) (p->s.value[MODE] == (m))

const char* fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char* fmi2GetVersion(void) { return fmi2Version; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String uri, const fmi2CallbackFunctions* callbacks,
                              fmi2Boolean visible, fmi2Boolean logging) {
    (void)name, (void)type, (void)guid, (void)uri, (void)visible, (void)logging;
    Plant* p = calloc(1, sizeof *p);
    p->callbacks = *callbacks;
    p->s.value[H] = 1;
    p->s.value[E] = 0.7;
    living(1);
    return p;
}
void fmi2FreeInstance(fmi2Component c) {
    living(-1);
    free(c);
}
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean a, fmi2Real b, fmi2Real start, fmi2Boolean d, fmi2Real e) {
    (void)a, (void)b, (void)d, (void)e;
    ((Plant*)c)->s.t = start;
    return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    IN(c, p->s.phase == START);
    return fmi2OK;
}
fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    IN(c, p->s.phase == START);
    p->s.phase = EVENTS;
    return fmi2OK;
}
fmi2Status fmi2EnterEventMode(fmi2Component c) {
    IN(c, p->s.phase == CONTINUOUS);
    p->s.phase = EVENTS;
    return fmi2OK;
}
fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
    IN(c, p->s.phase == EVENTS);
    p->s.phase = CONTINUOUS;
    return fmi2OK;
}
fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo* info) {
    IN(c, p->s.phase == EVENTS);
    double* v = p->s.value;
    memset(info, 0, sizeof *info);
    if (v[KICK] != p->s.kicked) v[V] += v[KICK], v[RESTS] = 0, p->s.kicked = v[KICK];
    if (v[H] <= 0 && v[V] < 0 && v[RESTS] == 0) {
        if (MODE_IS(ERROR_IN_EVENT)) return fail(p, "the floor broke");
        v[H] = 1e-300;
        v[V] *= -v[E];
        v[BOUNCES] += 1;
        if (MODE_IS(LIFTS)) v[V] += 1;
        else if (v[V] < 0.1) v[V] = 0, v[RESTS] = 1;
    }
    info->valuesOfContinuousStatesChanged = fmi2True;
    info->newDiscreteStatesNeeded = MODE_IS(ITERATES) && v[BOUNCES] > 0;
    info->terminateSimulation = MODE_IS(TERMINATES) && v[BOUNCES] > 0;
    if (p->s.t >= 1 && living(0) == 1) p->s.switched = 1;
    info->nextEventTimeDefined = MODE_IS(ENDLESS_TIMES) || (MODE_IS(SWITCHES) && !p->s.switched && living(0) == 1);
    info->nextEventTime = MODE_IS(SWITCHES) ? 1 : p->s.t;
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real value[]) {
    IN(c, ALWAYS);
    for (size_t i = 0; i < n; ++i) value[i] = p->s.value[r[i]];
    return fmi2OK;
}
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Real value[]) {
    IN(c, p->s.phase != CONTINUOUS);
    for (size_t i = 0; i < n; ++i) p->s.value[r[i]] = value[i];
    return fmi2OK;
}
fmi2Status fmi2SetTime(fmi2Component c, fmi2Real t) {
    IN(c, p->s.phase == CONTINUOUS);
    p->s.t = t;
    return fmi2OK;
}
fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) {
    IN(c, p->s.phase == CONTINUOUS);
    memcpy(p->s.value + H, x, n * sizeof *x);
    return fmi2OK;
}
fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    IN(c, p->s.phase != START);
    memcpy(x, p->s.value + H, n * sizeof *x);
    return fmi2OK;
}
fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    IN(c, p->s.phase != START);
    for (size_t i = 0; i < n; ++i) x[i] = 1;
    return fmi2OK;
}
fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real dx[], size_t n) {
    IN(c, p->s.phase != START);
    (void)n;
    dx[0] = p->s.value[V];
    dx[1] = p->s.value[RESTS] ? 0 : MODE_IS(LIFTS) ? 9.81 : MODE_IS(SWITCHES) && p->s.switched ? 2 : -9.81;
    if (MODE_IS(NAN_AFTER_EVENT) && p->s.value[BOUNCES] > 0) dx[1] = NAN;
    return fmi2OK;
}
fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real z[], size_t n) {
    IN(c, p->s.phase != START);
    (void)n;
    z[0] = p->s.value[RESTS] || MODE_IS(STEP_EVENT) ? 1 : p->s.value[H];
    return fmi2OK;
}
fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean no_way_back, fmi2Boolean* event, fmi2Boolean* terminate) {
    IN(c, p->s.phase == CONTINUOUS && !no_way_back);
    *event = MODE_IS(STEP_EVENT) && p->s.value[H] <= 0 && p->s.value[V] < 0;
    *terminate = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate* state) {
    IN(c, ALWAYS);
    if (!*state && ++copies > 2000) return fail(p, "too many copies");
    if (!*state) *state = malloc(sizeof p->s);
    memcpy(*state, &p->s, sizeof p->s);
    return fmi2OK;
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    memcpy(&((Plant*)c)->s, state, sizeof(State));
    return fmi2OK;
}
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate* state) {
    (void)c;
    --copies;
    free(*state);
    *state = NULL;
    return fmi2OK;
}
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t* size) {
    Plant* p = c;
    *size = sizeof(State) + (MODE_IS(GROWS) ? 200 * (size_t)((State*)state)->value[BOUNCES] : 0);
    return fmi2OK;
}
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    (void)c;
    memset(bytes, 0, size);
    memcpy(bytes, state, sizeof(State));
    return fmi2OK;
}
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate* state) {
    (void)c, (void)size;
    if (!*state && ++copies > 2000) return fail(c, "too many copies");
    if (!*state) *state = malloc(sizeof(State));
    memcpy(*state, bytes, sizeof(State));
    return fmi2OK;
}
