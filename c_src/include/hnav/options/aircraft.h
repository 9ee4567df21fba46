/* Made by c_src/options/generate.py from aircraft.toml: change that, then ./run generate. */
#ifndef HNAV_OPTIONS_AIRCRAFT_H
#define HNAV_OPTIONS_AIRCRAFT_H

#include <stddef.h>
#include <stdint.h>

/* Options of the aircraft with an INS.
 * Make them with hnav_aircraft_defaults, then change what you need; hnav_option("aircraft", i) states all this at run
 * time. */
typedef struct hnav_aircraft_options {
    size_t size;    /* of this struct in bytes; set by hnav_aircraft_defaults */
    uint64_t stamp; /* the list and the version of the library that made it; set likewise */

    /* ------------------------ chance
     * What is drawn at random. */

    /* Seed of everything random.
     * [0, 2147483647], default 0. Any seed is as good as any other. */
    int32_t seed;

    /* ------------------------ discretisation
     * From the continuous model to samples. */

    /* 1: lambda by 1 - dt/tau, as the paper prints; 0: exact, exp(-dt/tau).
     * [0, 1], default 0. Exact. */
    int32_t euler_colour;
    /* 1: w integrated over the interval, which correlates the states (Van Loan 1978); 0: independent noise of variance
     * density times interval.
     * [0, 1], default 0. The setting of the comparison table. */
    int32_t exact_process_noise;
} hnav_aircraft_options;

#endif /* HNAV_OPTIONS_AIRCRAFT_H */
