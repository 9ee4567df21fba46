/* Steps the binary of an FMU through a trajectory, Co-Simulation of FMI 2 or 3, on any platform that has a C compiler:
 *
 *     trajectory BINARY PLAN > outputs
 *
 * A plan is text, made by release/trajectories.py from the model description, so that nothing here reads XML:
 *
 *     2 | 3                                     version of FMI
 *     instantiation token
 *     resource folder                           as a URI for FMI 2, as a path for FMI 3
 *     inputs: reals integers booleans   outputs: reals integers booleans   points
 *     value references                          of the inputs, then of the outputs, in that order
 *     time, inputs                              one line for each point
 *
 * At every point the inputs are set, the FMU steps to the next point and its outputs are printed, one line for each
 * step. Numbers are the sixteen hexadecimal digits of a double's bits in the plan and in the output: run-time libraries
 * differ in how they read and write decimals, and what is compared are the FMU's numbers alone. */
#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef _WIN32
#define WIN32_LEAN_AND_MEAN
#include <windows.h>
#else
#include <dlfcn.h>
#endif

#include <fmi2FunctionTypes.h>
#include <fmi3FunctionTypes.h>

enum { REALS, INTEGERS, BOOLEANS, KINDS };

static void fail(const char* what, const char* detail) {
    fprintf(stderr, "trajectory: %s%s%s\n", what, *detail ? ": " : "", detail);
    exit(1);
}

static void* allocate(size_t count, size_t size) {
    void* memory = calloc(count ? count : 1, size);
    if (!memory) fail("out of memory", "");
    return memory;
}

/* ------------------------------------------------------------------------------------------- the binary */

typedef void (*function)(void);

static function symbol(void* library, const char* name) {
    function found;
#ifdef _WIN32
    FARPROC address = GetProcAddress((HMODULE)library, name);
#else
    void* address = dlsym(library, name);
#endif
    if (!address) fail("the binary has no function", name);
    memcpy(&found, &address, sizeof found); /* ISO C has no cast from an object pointer to a function pointer */
    return found;
}

static void* open_library(const char* path) {
#ifdef _WIN32
    void* library = (void*)LoadLibraryA(path);
    if (!library) fail("cannot load", path);
#else
    void* library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library) fail("cannot load", dlerror());
#endif
    return library;
}

/* ------------------------------------------------------------------------------------------- the plan */

typedef struct {
    int version;
    char token[256], resources[4096];
    unsigned count_in[KINDS], count_out[KINDS], points;
    unsigned *in[KINDS], *out[KINDS]; /* value references */
    FILE* file;
} plan;

static void read_line(plan* p, char* line, size_t size) {
    if (!fgets(line, (int)size, p->file)) fail("the plan ends early", "");
    line[strcspn(line, "\r\n")] = '\0';
}

static unsigned read_count(plan* p) {
    unsigned value;
    if (fscanf(p->file, "%u", &value) != 1) fail("the plan holds no number where one belongs", "");
    return value;
}

static double read_real(plan* p) {
    uint64_t bits;
    double value;
    if (fscanf(p->file, "%" SCNx64, &bits) != 1) fail("the plan holds no bits where they belong", "");
    memcpy(&value, &bits, sizeof value);
    return value;
}

static void read_plan(plan* p, const char* path) {
    char line[64];
    int k;
    unsigned i;
    p->file = fopen(path, "r");
    if (!p->file) fail("cannot read", path);
    read_line(p, line, sizeof line);
    p->version = atoi(line);
    if (p->version != 2 && p->version != 3) fail("no such version of FMI", line);
    read_line(p, p->token, sizeof p->token);
    read_line(p, p->resources, sizeof p->resources);
    for (k = 0; k < KINDS; ++k) p->count_in[k] = read_count(p);
    for (k = 0; k < KINDS; ++k) p->count_out[k] = read_count(p);
    p->points = read_count(p);
    for (k = 0; k < KINDS; ++k) {
        p->in[k] = allocate(p->count_in[k], sizeof(unsigned));
        for (i = 0; i < p->count_in[k]; ++i) p->in[k][i] = read_count(p);
    }
    for (k = 0; k < KINDS; ++k) {
        p->out[k] = allocate(p->count_out[k], sizeof(unsigned));
        for (i = 0; i < p->count_out[k]; ++i) p->out[k][i] = read_count(p);
    }
}

/* Inputs and outputs at one point, doubles whatever their type. */
typedef struct {
    double *in[KINDS], *out[KINDS];
} values;

static void print_outputs(const plan* p, const values* v) {
    int k;
    unsigned i;
    for (k = 0; k < KINDS; ++k)
        for (i = 0; i < p->count_out[k]; ++i) {
            uint64_t bits;
            memcpy(&bits, &v->out[k][i], sizeof bits);
            printf("%016" PRIx64 " ", bits);
        }
    printf("\n");
}

/* ------------------------------------------------------------------------------------------- FMI 2 and 3 */

typedef struct {
    void (*start)(const plan* p, void* library, double start_s);
    void (*step)(const plan* p, values* v, double t_s, double step_s);
    void (*end)(void);
} stepper;

static void check(int status, const char* call) {
    if (status != 0) fail(call, "the FMU did not answer OK");
}

#define LOAD(type, name) (type*)symbol(library, #name)

static fmi2Component two;
static fmi2CallbackFunctions two_callbacks;
static fmi2SetRealTYPE* two_set_real;
static fmi2SetIntegerTYPE* two_set_integer;
static fmi2SetBooleanTYPE* two_set_boolean;
static fmi2GetRealTYPE* two_get_real;
static fmi2GetIntegerTYPE* two_get_integer;
static fmi2GetBooleanTYPE* two_get_boolean;
static fmi2DoStepTYPE* two_step;
static fmi2TerminateTYPE* two_terminate;
static fmi2FreeInstanceTYPE* two_free;

static void two_log(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                    fmi2String text, ...) {
    va_list arguments;
    (void)environment, (void)name, (void)status, (void)category;
    va_start(arguments, text);
    vfprintf(stderr, text, arguments);
    va_end(arguments);
    fprintf(stderr, "\n");
}

static void two_start(const plan* p, void* library, double start_s) {
    fmi2InstantiateTYPE* instantiate = LOAD(fmi2InstantiateTYPE, fmi2Instantiate);
    fmi2SetupExperimentTYPE* setup = LOAD(fmi2SetupExperimentTYPE, fmi2SetupExperiment);
    fmi2EnterInitializationModeTYPE* enter = LOAD(fmi2EnterInitializationModeTYPE, fmi2EnterInitializationMode);
    fmi2ExitInitializationModeTYPE* leave = LOAD(fmi2ExitInitializationModeTYPE, fmi2ExitInitializationMode);
    fmi2CallbackFunctions callbacks = {two_log, calloc, free, NULL, NULL};
    two_set_real = LOAD(fmi2SetRealTYPE, fmi2SetReal);
    two_set_integer = LOAD(fmi2SetIntegerTYPE, fmi2SetInteger);
    two_set_boolean = LOAD(fmi2SetBooleanTYPE, fmi2SetBoolean);
    two_get_real = LOAD(fmi2GetRealTYPE, fmi2GetReal);
    two_get_integer = LOAD(fmi2GetIntegerTYPE, fmi2GetInteger);
    two_get_boolean = LOAD(fmi2GetBooleanTYPE, fmi2GetBoolean);
    two_step = LOAD(fmi2DoStepTYPE, fmi2DoStep);
    two_terminate = LOAD(fmi2TerminateTYPE, fmi2Terminate);
    two_free = LOAD(fmi2FreeInstanceTYPE, fmi2FreeInstance);
    memcpy(&two_callbacks, &callbacks, sizeof callbacks); /* its members are const, and it has to outlive the instance */
    two = instantiate("trajectory", fmi2CoSimulation, p->token, p->resources, &two_callbacks, fmi2False, fmi2False);
    if (!two) fail("fmi2Instantiate", "no instance");
    check(setup(two, fmi2False, 0, start_s, fmi2False, 0), "fmi2SetupExperiment");
    check(enter(two), "fmi2EnterInitializationMode");
    check(leave(two), "fmi2ExitInitializationMode");
}

/* FMI 2 has int for integers and booleans alike. */
static void two_move_integers(const plan* p, values* v) {
    int k;
    unsigned i;
    for (k = INTEGERS; k <= BOOLEANS; ++k) {
        fmi2Integer* buffer = allocate(p->count_in[k], sizeof *buffer);
        for (i = 0; i < p->count_in[k]; ++i) buffer[i] = (fmi2Integer)v->in[k][i];
        if (p->count_in[k])
            check(k == INTEGERS ? two_set_integer(two, p->in[k], p->count_in[k], buffer)
                                : two_set_boolean(two, p->in[k], p->count_in[k], buffer),
                  "fmi2SetInteger or fmi2SetBoolean");
        free(buffer);
    }
}

static void two_take_integers(const plan* p, values* v) {
    int k;
    unsigned i;
    for (k = INTEGERS; k <= BOOLEANS; ++k) {
        fmi2Integer* buffer = allocate(p->count_out[k], sizeof *buffer);
        if (p->count_out[k])
            check(k == INTEGERS ? two_get_integer(two, p->out[k], p->count_out[k], buffer)
                                : two_get_boolean(two, p->out[k], p->count_out[k], buffer),
                  "fmi2GetInteger or fmi2GetBoolean");
        for (i = 0; i < p->count_out[k]; ++i) v->out[k][i] = buffer[i];
        free(buffer);
    }
}

static void two_do_step(const plan* p, values* v, double t_s, double step_s) {
    if (p->count_in[REALS]) check(two_set_real(two, p->in[REALS], p->count_in[REALS], v->in[REALS]), "fmi2SetReal");
    two_move_integers(p, v);
    check(two_step(two, t_s, step_s, fmi2True), "fmi2DoStep");
    if (p->count_out[REALS]) check(two_get_real(two, p->out[REALS], p->count_out[REALS], v->out[REALS]), "fmi2GetReal");
    two_take_integers(p, v);
}

static void two_end(void) {
    check(two_terminate(two), "fmi2Terminate");
    two_free(two);
}

static fmi3Instance three;
static fmi3SetFloat64TYPE* three_set_real;
static fmi3SetInt32TYPE* three_set_integer;
static fmi3SetBooleanTYPE* three_set_boolean;
static fmi3GetFloat64TYPE* three_get_real;
static fmi3GetInt32TYPE* three_get_integer;
static fmi3GetBooleanTYPE* three_get_boolean;
static fmi3DoStepTYPE* three_step;
static fmi3TerminateTYPE* three_terminate;
static fmi3FreeInstanceTYPE* three_free;

static void three_log(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String text) {
    (void)environment, (void)status, (void)category;
    fprintf(stderr, "%s\n", text);
}

static void three_start(const plan* p, void* library, double start_s) {
    fmi3InstantiateCoSimulationTYPE* instantiate = LOAD(fmi3InstantiateCoSimulationTYPE, fmi3InstantiateCoSimulation);
    fmi3EnterInitializationModeTYPE* enter = LOAD(fmi3EnterInitializationModeTYPE, fmi3EnterInitializationMode);
    fmi3ExitInitializationModeTYPE* leave = LOAD(fmi3ExitInitializationModeTYPE, fmi3ExitInitializationMode);
    three_set_real = LOAD(fmi3SetFloat64TYPE, fmi3SetFloat64);
    three_set_integer = LOAD(fmi3SetInt32TYPE, fmi3SetInt32);
    three_set_boolean = LOAD(fmi3SetBooleanTYPE, fmi3SetBoolean);
    three_get_real = LOAD(fmi3GetFloat64TYPE, fmi3GetFloat64);
    three_get_integer = LOAD(fmi3GetInt32TYPE, fmi3GetInt32);
    three_get_boolean = LOAD(fmi3GetBooleanTYPE, fmi3GetBoolean);
    three_step = LOAD(fmi3DoStepTYPE, fmi3DoStep);
    three_terminate = LOAD(fmi3TerminateTYPE, fmi3Terminate);
    three_free = LOAD(fmi3FreeInstanceTYPE, fmi3FreeInstance);
    three = instantiate("trajectory", p->token, p->resources, false, false, false, false, NULL, 0, NULL, three_log, NULL);
    if (!three) fail("fmi3InstantiateCoSimulation", "no instance");
    check(enter(three, false, 0, start_s, false, 0), "fmi3EnterInitializationMode");
    check(leave(three), "fmi3ExitInitializationMode");
}

static void three_do_step(const plan* p, values* v, double t_s, double step_s) {
    const unsigned in_integers = p->count_in[INTEGERS], in_booleans = p->count_in[BOOLEANS];
    const unsigned out_integers = p->count_out[INTEGERS], out_booleans = p->count_out[BOOLEANS];
    fmi3Int32* integers = allocate(in_integers + out_integers, sizeof *integers);
    fmi3Boolean *booleans = allocate(in_booleans + out_booleans, sizeof *booleans), event, terminate, early;
    fmi3Float64 last_s;
    unsigned i;
    for (i = 0; i < in_integers; ++i) integers[i] = (fmi3Int32)v->in[INTEGERS][i];
    for (i = 0; i < in_booleans; ++i) booleans[i] = v->in[BOOLEANS][i] != 0;
    if (p->count_in[REALS])
        check(three_set_real(three, p->in[REALS], p->count_in[REALS], v->in[REALS], p->count_in[REALS]), "fmi3SetFloat64");
    if (in_integers) check(three_set_integer(three, p->in[INTEGERS], in_integers, integers, in_integers), "fmi3SetInt32");
    if (in_booleans) check(three_set_boolean(three, p->in[BOOLEANS], in_booleans, booleans, in_booleans), "fmi3SetBoolean");
    check(three_step(three, t_s, step_s, true, &event, &terminate, &early, &last_s), "fmi3DoStep");
    if (p->count_out[REALS])
        check(three_get_real(three, p->out[REALS], p->count_out[REALS], v->out[REALS], p->count_out[REALS]), "fmi3GetFloat64");
    if (out_integers) check(three_get_integer(three, p->out[INTEGERS], out_integers, integers, out_integers), "fmi3GetInt32");
    if (out_booleans) check(three_get_boolean(three, p->out[BOOLEANS], out_booleans, booleans, out_booleans), "fmi3GetBoolean");
    for (i = 0; i < out_integers; ++i) v->out[INTEGERS][i] = integers[i];
    for (i = 0; i < out_booleans; ++i) v->out[BOOLEANS][i] = booleans[i];
    free(integers);
    free(booleans);
}

static void three_end(void) {
    check(three_terminate(three), "fmi3Terminate");
    three_free(three);
}

int main(int argc, char** argv) {
    static const stepper steppers[] = {{two_start, two_do_step, two_end}, {three_start, three_do_step, three_end}};
    const stepper* fmi;
    plan p;
    values now, next;
    double t_s, next_s;
    int k;
    unsigned i, n;
    if (argc != 3) fail("usage: trajectory BINARY PLAN", "");
    memset(&p, 0, sizeof p);
    read_plan(&p, argv[2]);
    fmi = &steppers[p.version - 2];
    for (k = 0; k < KINDS; ++k) {
        now.in[k] = allocate(p.count_in[k], sizeof(double));
        next.in[k] = allocate(p.count_in[k], sizeof(double));
        now.out[k] = allocate(p.count_out[k], sizeof(double));
    }
    t_s = read_real(&p);
    for (k = 0; k < KINDS; ++k)
        for (i = 0; i < p.count_in[k]; ++i) now.in[k][i] = read_real(&p);
    fmi->start(&p, open_library(argv[1]), t_s);
    for (n = 1; n < p.points; ++n) {
        next_s = read_real(&p);
        for (k = 0; k < KINDS; ++k)
            for (i = 0; i < p.count_in[k]; ++i) next.in[k][i] = read_real(&p);
        fmi->step(&p, &now, t_s, next_s - t_s);
        print_outputs(&p, &now);
        t_s = next_s;
        for (k = 0; k < KINDS; ++k) memcpy(now.in[k], next.in[k], p.count_in[k] * sizeof(double));
    }
    fmi->end();
    return 0;
}
