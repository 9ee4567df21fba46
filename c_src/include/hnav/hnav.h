/* hnav: hybrid navigation filters, the C API.
 *
 * A filter here is a hybrid system. Between samples its estimate flows: an ODE solver integrates attitude, gyro
 * bias and covariance. At a sample it jumps: the correction. The estimate is stored at sample times only; a request
 * for time t replays the samples that wait, coasts to t on a copy and shows the copy. Hence the same samples give the
 * same bits whatever times are asked for.
 *
 *     hnav_ahrs_options options = hnav_ahrs_defaults(HNAV_PRESET_DEFAULT);
 *     hnav_filter* filter;
 *     hnav_attitude attitude = {.size = sizeof attitude};
 *     hnav_ahrs_create(&filter, &options, NULL, 0);
 *     while (...) {
 *         hnav_filter_push_imu(filter, t_s, rate_b_rad_s, force_b_m_s2);
 *         hnav_filter_push_mag(filter, t_s, field_b_tesla);
 *         hnav_filter_advance(filter, t_s);
 *         hnav_filter_attitude(filter, &attitude);
 *     }
 *     hnav_filter_destroy(filter);
 *
 * Conventions
 *   n    navigation frame: north-east-down, or east-north-up when asked for (option navigation_frame)
 *   b    body frame: the axes of the sensor turned by the mounting rotation q_body_sensor
 *   q    Hamilton quaternion, scalar first, unit length; q_nb turns body vectors into navigation axes
 *   force_b is specific force: a sensor at rest with its z axis down reads (0, 0, -9.81) m/s2
 *   SI units, always; the last words of a name are its unit; matrices are row-major
 *
 * Promises
 *   Every call returns a status. After a failure the estimate is as it was before the call and the object stays
 *   usable; hnav_filter_message tells what was wrong, naming the argument or option.
 *   Memory is taken in create and nowhere else. Objects share nothing; one object serves one thread at a time.
 *   Null arguments, non-finite numbers and impossible options are answered, never followed.
 *
 * This header includes all the others; each of them can be included alone.
 *   types.h        status codes, version, sensors, descriptions of options
 *   filter.h       the calls that all filters share: life, samples, estimate, saved states, hybrid view
 *   ahrs.h         attitude and heading of real sensors
 *   hrekf.h        the filter of the paper on alignment
 *   ins.h          position, velocity and attitude, aligned from any heading
 *   ins_error.h    linear models whose measurements have time-correlated errors, such as those of an INS
 *   observer.h     the states of a plant of one's own
 *   calibration.h  magnetometer calibration
 *   simulation.h   truth and sensor models to drive filters with
 */
#ifndef HNAV_H
#define HNAV_H

#include "hnav/ahrs.h"
#include "hnav/calibration.h"
#include "hnav/filter.h"
#include "hnav/hrekf.h"
#include "hnav/ins.h"
#include "hnav/ins_error.h"
#include "hnav/observer.h"
#include "hnav/simulation.h"
#include "hnav/types.h"

#endif /* HNAV_H */
