/* Our filters; -DCREATE=ahrs or hrekf. */
#include "contender.h"

#include <hnav/ahrs.h>
#include <hnav/hrekf.h>

#define JOINED(a, b, c) a##b##c
#define CALL_OF(filter, name) JOINED(hnav_, filter, name)
#define CALL(name) CALL_OF(CREATE, name)

static double memory[28 * 1024 / sizeof(double)];
static hnav_filter* filter;

static CALL(_options) options(void) {
    CALL(_options) o = CALL(_defaults)(HNAV_PRESET_DEFAULT);
    o.solver = HNAV_SOLVER_CLOSED_FORM;
    o.queue_capacity = 4;
    return o;
}

size_t contender_bytes(void) {
    const CALL(_options) o = options();
    return CALL(_memory_bytes)(&o);
}

int contender_begin(double interval_s) {
    const CALL(_options) o = options();
    (void)interval_s;
    return CALL(_create_in)(memory, sizeof memory, &filter, &o, NULL, 0);
}

int contender_step(double t_s, const double rate[3], const double force[3], const double field[3], double q[4]) {
    hnav_attitude attitude = {.size = sizeof attitude};
    hnav_status status = hnav_filter_push_imu(filter, t_s, rate, force);
    if (status == HNAV_OK) status = hnav_filter_push_mag(filter, t_s, field);
    if (status == HNAV_OK) status = hnav_filter_advance(filter, t_s);
    if (status != HNAV_OK) return status;
    if (hnav_filter_attitude(filter, &attitude) == HNAV_OK)
        for (int i = 0; i < 4; ++i) q[i] = attitude.q_nb[i];
    return 0;
}
