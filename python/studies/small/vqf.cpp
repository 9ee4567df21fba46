// VQF (Laidig and Seel 2023), as its documentation calls it.
#include "contender.h"

#include <vqf.hpp>

#include <new>

alignas(VQF) static unsigned char memory[sizeof(VQF)];
static VQF* filter;

size_t contender_bytes(void) { return sizeof(VQF); }

int contender_begin(double interval_s) {
    filter = new (memory) VQF(vqf_real_t(interval_s));
    return 0;
}

int contender_step(double, const double rate[3], const double force[3], const double field[3], double q[4]) {
    vqf_real_t gyr[3], acc[3], mag[3], attitude[4];
    for (int i = 0; i < 3; ++i) {
        gyr[i] = vqf_real_t(rate[i]);
        acc[i] = vqf_real_t(force[i]);
        mag[i] = vqf_real_t(field[i]);
    }
    filter->update(gyr, acc, mag);
    filter->getQuat9D(attitude);
    for (int i = 0; i < 4; ++i) q[i] = attitude[i];
    return 0;
}
