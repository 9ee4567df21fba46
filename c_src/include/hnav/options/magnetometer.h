/* Made by c_src/options/generate.py from magnetometer.toml: change that, then ./run generate. */
#ifndef HNAV_OPTIONS_MAGNETOMETER_H
#define HNAV_OPTIONS_MAGNETOMETER_H

#include <stddef.h>
#include <stdint.h>

/* Options of the magnetometer calibration. All thresholds are free of units.
 * Make them with hnav_magnetometer_defaults, then change what you need; hnav_option("magnetometer", i) states all this at
 * run time. */
typedef struct hnav_magnetometer_options {
    size_t size;    /* of this struct in bytes; set by hnav_magnetometer_defaults */
    uint64_t stamp; /* the list and the version of the library that made it; set likewise */

    /* ------------------------ robust
     * Outliers. */

    /* 1: outliers lose their weight; 0: plain least squares.
     * [0, 1], default 1. 5 % of outliers make the direction error of plain least squares four times as large. */
    int32_t robust;
    /* Beyond this many robust standard deviations a sample is an outlier.
     * [1, 100], default 3. One good sample in four hundred loses its weight. */
    double outlier_sigma;
    /* A force is gravity when its length is this near to the median, relative.
     * (0, 1], default 0.05. Accelerations of half a metre per second squared are let through, swings of the arm are not. */
    double force_tolerance;

    /* ------------------------ limits
     * What the data must determine before an answer is given. */

    /* Attitudes needed, and attitudes with gravity for the rotation; at least 13, the number of unknowns.
     * [13, 2147483647], default 50. Four samples for each unknown. */
    int32_t min_samples;
    /* Do without the rotation, then refuse, when nine of ten errors are not sure to be smaller than this.
     * (0, inf] rad, default 1 deg. A chip as it comes is good to a degree or two. The error of a rotation that was given
     * up is stated beside, and may be larger. */
    double max_direction_sigma_rad;
    /* 1: where the full fit is refused, answer with the offset alone.
     * [0, 1], default 0. An offset alone is another answer than was asked for. */
    int32_t allow_hard_iron_only;
    /* Refuse the full fit when condition exceeds this.
     * (1, inf], default 1e3. Turning about one axis only gives more, and would be fitted with an error of tens of degrees. */
    double max_condition;
    /* Refuse the full fit when ambiguity exceeds this.
     * (0, 1], default 0.1. The next best ellipsoid must be ten times worse. */
    double max_ambiguity;
    /* Refuse the full fit when coverage is below this.
     * [0, 1), default 0.05. A cone of directions around one axis has less. */
    double min_coverage;
    /* Refuse the full fit when axis_ratio exceeds this.
     * (1, inf], default 3. No usual iron stretches a field so far: the data are of several places. */
    double max_axis_ratio;
} hnav_magnetometer_options;

#endif /* HNAV_OPTIONS_MAGNETOMETER_H */
