/* Made by c_src/options/generate.py from turntable.toml: change that, then ./run generate. */
#ifndef HNAV_OPTIONS_TURNTABLE_H
#define HNAV_OPTIONS_TURNTABLE_H

#include <stddef.h>
#include <stdint.h>

/* Motion of an axis. */
typedef enum hnav_motion {
    HNAV_MOTION_CONSTANT = 0, /* angle_rad */
    HNAV_MOTION_STEP = 1,     /* from start_s it turns by amplitude_rad at rate_rad_s, then stands */
    HNAV_MOTION_SINE = 2,     /* from start_s: angle_rad + amplitude_rad sin(2 pi (t - start_s)/period_s) */
    HNAV_MOTION_TRIANGLE = 3  /* from start_s to and fro between angle_rad +- amplitude_rad at rate_rad_s */
} hnav_motion;

/* What each axis has. */
typedef struct hnav_axis_options {
    /* Motion: constant angle; step to another angle; sine; triangle to and fro at a constant rate.
     * hnav_motion, default constant. The axis is locked. */
    int32_t motion;
    /* Angle before start_s, and the middle of sine and triangle.
     * [-4 pi, 4 pi] rad, default 0. Level, to the north. */
    double angle_rad;
    /* Amplitude of sine and triangle, way of the step; negative: the other way first.
     * [-100 pi, 100 pi] rad, default 0. No motion. */
    double amplitude_rad;
    /* Rate of step and triangle.
     * [1e-9, 1e3] rad/s, default 10 deg. The paper's rate of yaw. */
    double rate_rad_s;
    /* Period of the sine.
     * [1e-6, 1e6] s, default 10. A slow swing. */
    double period_s;
    /* The motion begins here.
     * [-1e9, 1e9] s, default 0. From the beginning. */
    double start_s;
    /* The axis stands off by an angle drawn from seed, uniform within +- this.
     * [0, pi] rad, default 0. Nothing is unknown. */
    double unknown_rad;
} hnav_axis_options;

/* Options of the turntable. The defaults are the experiment of the HREKF's paper: yaw to and fro between +-60 deg at 10
 * deg/s, level; a field of 50 uT with a dip of 60 deg.
 * Make them with hnav_turntable_defaults, then change what you need; hnav_option("turntable", i) states all this at run
 * time. */
typedef struct hnav_turntable_options {
    size_t size;    /* of this struct in bytes; set by hnav_turntable_defaults */
    uint64_t stamp; /* the list and the version of the library that made it; set likewise */

    hnav_axis_options roll; /* motion about the innermost axis */

    hnav_axis_options pitch; /* motion about the axis between */

    hnav_axis_options yaw; /* motion about the outermost axis */

    /* ------------------------ place
     * Gravity and magnetic field of the place. */

    /* Gravity.
     * (0, 1e3] m/s2, default 9.80665. Standard gravity. */
    double gravity_m_s2;
    /* Strength of the magnetic field.
     * (0, 1] T, default 5e-5. A usual field of the Earth in middle latitudes. */
    double field_strength_tesla;
    /* Dip of the magnetic field below the horizon.
     * [-pi/2, pi/2] rad, default 60 deg. A usual dip in middle northern latitudes. */
    double field_dip_rad;
    /* Magnetic declination: the field points this much east of true north.
     * [-pi, pi] rad, default 0. True north is magnetic north. */
    double declination_rad;

    /* ------------------------ chance
     * What is drawn at random. */

    /* Seed of the unknown angles.
     * [0, 2147483647], default 0. Any seed is as good as any other. */
    int32_t seed;
} hnav_turntable_options;

#endif /* HNAV_OPTIONS_TURNTABLE_H */
