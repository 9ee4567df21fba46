/* hnav: hybrid navigation filters, the C API.
 *
 * A filter is a hybrid system. Between samples an ODE solver integrates attitude, gyro bias and covariance (flow); at a
 * sample the estimate is corrected (jump). The estimate is stored at sample times only. A request for time t uses the
 * waiting samples, predicts a copy to t and returns the copy. The same samples therefore give the same bits for any
 * times of output.
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
 *   n    navigation frame: north-east-down, or east-north-up (option navigation_frame)
 *   b    body frame: the axes of the sensor turned by the mounting rotation q_body_sensor
 *   q    Hamilton quaternion, scalar first, unit length; q_nb turns body vectors into navigation axes
 *   force_b is specific force: a sensor at rest with its z axis down reads (0, 0, -9.81) m/s2
 *   SI units; a name ends with its unit; matrices are row-major
 *
 * Promises
 *   Every call returns a status. After a failure the estimate is unchanged and the object stays usable;
 *   hnav_filter_message has the cause with the argument or option.
 *   Memory is allocated in create only. Objects share no data; one object serves one thread at a time.
 *   Null arguments, non-finite numbers and invalid options are refused with a status.
 *
 * This header includes all the others; each of them can be included alone.
 *   types.h        status codes, version, sensors, descriptions of options
 *   filter.h       the calls that all filters share: life, samples, estimate, saved states, hybrid view
 *   ahrs.h         attitude and heading from low-cost sensors
 *   hrekf.h        the filter of the paper on alignment
 *   ins.h          position, velocity and attitude, aligned from any heading
 *   ins_error.h    linear models whose measurements have time-correlated errors, such as those of an INS
 *   observer.h     the states of your own plant
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
