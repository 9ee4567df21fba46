/* Magnetometer calibration from a recording of a sensor that was turned about all axes (a figure of eight in the air),
 * far from iron that does not turn with it: hard iron, soft iron, scale and misalignment, and the rotation between the
 * axes of the field and those of the force. An ellipsoid is fitted (Li and Griffiths 2004), gravity determines the remaining
 * rotation, both are refined together (Kok, Hol, Schon, Gustafsson, Luinge 2012), outliers are down-weighted.
 *
 *     corrected = matrix (field - offset) */
#ifndef HNAV_CALIBRATION_H
#define HNAV_CALIBRATION_H

#include "hnav/options/magnetometer.h"
#include "hnav/types.h"

#ifdef __cplusplus
extern "C" {
#endif

HNAV_API hnav_magnetometer_options hnav_magnetometer_defaults(void);

typedef enum hnav_magnetometer_fit {
    HNAV_MAGNETOMETER_FULL = 0,          /* offset and matrix, rotation included */
    HNAV_MAGNETOMETER_NO_ROTATION = 1,   /* rotation not observable: symmetric matrix, smallest rotation */
    HNAV_MAGNETOMETER_HARD_IRON_ONLY = 2 /* offset; matrix is the identity */
} hnav_magnetometer_fit;

typedef struct hnav_magnetometer_calibration {
    size_t size;                  /* of this struct; set by the caller */
    double offset[3];             /* hard iron, in the unit and axes of the field */
    double matrix[9];             /* row-major, determinant 1: the strength is kept on the mean over all directions */
    double strength;              /* of the corrected field, in its unit */
    double dip_rad;               /* of the field, positive down; NaN without force */
    double residual_before;       /* scatter of |field|, relative, rms over the samples that are no outliers */
    double residual_after;        /* of |corrected| */
    double dip_spread_before_rad; /* robust standard deviation of the angle to gravity; NaN without force */
    double dip_spread_after_rad;
    double outlier_fraction;      /* of the used samples, [0, 1] */
    double coverage;              /* 1: directions spread evenly over the sphere; 0: all in a plane */
    double condition;             /* largest over second smallest eigenvalue of the quadric's scatter; 0: not reached */
    double ambiguity;             /* smallest over second smallest: near 1, another ellipsoid fits as well */
    double axis_ratio;            /* longest over shortest axis of the ellipsoid; of the refused one, or 1 */
    double direction_sigma_rad;   /* error of the corrected direction, rms over the sphere, exceeded by one of ten
                                     calibrations; includes a rotation that was not estimated; NaN: offset_axes 2 */
    uint64_t samples;             /* rows with a field */
    uint64_t used_samples;        /* of these, rows with a new attitude: a rest counts once */
    uint64_t force_samples;       /* of these, rows whose force was taken for gravity */
    int32_t fit;                  /* hnav_magnetometer_fit */
    int32_t offset_axes;          /* 3, or 2 when the samples lie in a plane: across it offset is zero */
    double gap_direction[3];      /* of the corrected field: the middle of the largest part of the sphere without a sample */
    double gap_rad;               /* how far from it the nearest sample is */
} hnav_magnetometer_calibration;

/* field: n x 3, in any unit; force_b_m_s2: n x 3 of the same instants, may be null. A row of three NaN is a missing
 * sample. options: null for the defaults. calibration: written on success only. message (may be null): the reason of a
 * failure; after a success the omitted parts with their reason, and the part of the sphere without samples.
 * Errors: NULL_ARGUMENT, OPTION, OPTIONS_STAMP, OUT_OF_MEMORY, NON_FINITE, OUT_OF_RANGE, and ILL_CONDITIONED when the
 * samples are too few, do not vary, lie in a plane, cover too little of the sphere or are no ellipsoid. */
HNAV_API hnav_status hnav_calibrate_magnetometer(size_t n, const double* field, const double* force_b_m_s2,
                                                 const hnav_magnetometer_options* options,
                                                 hnav_magnetometer_calibration* calibration, char* message, size_t message_size);

#ifdef __cplusplus
}
#endif

#endif /* HNAV_CALIBRATION_H */
