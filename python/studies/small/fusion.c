/* Fusion (x-io), as its documentation calls it: degrees and g, in single precision. */
#include "contender.h"

#include <Fusion.h>

static FusionAhrs ahrs;

size_t contender_bytes(void) { return sizeof ahrs; }

int contender_begin(double interval_s) {
    FusionAhrsSettings settings = fusionAhrsDefaultSettings;
    settings.sampleRate = (float)(1 / interval_s);
    FusionAhrsInitialise(&ahrs);
    FusionAhrsSetSettings(&ahrs, &settings);
    return 0;
}

static FusionVector scaled(const double v[3], float factor) {
    const FusionVector result = {{(float)v[0] * factor, (float)v[1] * factor, (float)v[2] * factor}};
    return result;
}

int contender_step(double t_s, const double rate[3], const double force[3], const double field[3], double q[4]) {
    (void)t_s;
    FusionAhrsUpdate(&ahrs, scaled(rate, 57.29578f), scaled(force, 1 / 9.80665f), scaled(field, 1e6f));
    const FusionQuaternion attitude = FusionAhrsGetQuaternion(&ahrs);
    for (int i = 0; i < 4; ++i) q[i] = attitude.array[i];
    return 0;
}
