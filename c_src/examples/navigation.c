/* Position, velocity and heading from an inertial sensor and a GNSS receiver: a car starts towards the north-east, brakes, and starts
 * again. Nothing states its heading; the filter finds it from the changes of the velocity. */
#include <hnav/hnav.h>
#include <math.h>
#include <stdio.h>

int main(void) {
    const double degree = 57.29578, earth_m = 6.378e6, latitude = 0.8, longitude = 0.2, heading = 45 / degree;
    const double rate[3] = {0, 0, 0}, velocity_sigma[3] = {0.1, 0.1, 0.2}, position_sigma[3] = {2, 2, 4};
    hnav_ins_options options = hnav_ins_defaults(HNAV_INS_CONSUMER); /* the grade of the inertial sensor */
    hnav_filter* ins;
    char message[256];
    if (hnav_ins_create(&ins, &options, message, sizeof message) != HNAV_OK) {
        fprintf(stderr, "%s\n", message);
        return 1;
    }
    double speed = 0, way = 0; /* m/s, m: the truth, in place of your sensors */
    for (int k = 0; k <= 6000; ++k) { /* a minute at 100 Hz */
        const double t_s = 0.01 * k, gain = k / 1000 % 2 == 0 ? 2 : -1.5; /* m/s2 along body x */
        const double force[3] = {gain, 0, -9.807};
        if (hnav_filter_push_imu(ins, t_s, rate, force) != HNAV_OK) fprintf(stderr, "%s\n", hnav_filter_message(ins));
        if (k % 20 == 0) { /* five fixes a second, each with the time at which it was valid */
            const double velocity[3] = {speed * cos(heading), speed * sin(heading), 0}; /* north, east, down */
            const double north = way * cos(heading) / earth_m, east = way * sin(heading) / earth_m / cos(latitude);
            hnav_filter_push_velocity(ins, t_s, velocity, velocity_sigma);
            hnav_filter_push_position(ins, t_s, latitude + north, longitude + east, 400, position_sigma);
        }
        if (hnav_filter_advance(ins, t_s) != HNAV_OK) fprintf(stderr, "%s\n", hnav_filter_message(ins));
        way += 0.01 * speed + 0.00005 * gain;
        speed += 0.01 * gain;
    }
    hnav_attitude attitude = {.size = sizeof attitude};
    hnav_navigation now = {.size = sizeof now};
    if (hnav_filter_attitude(ins, &attitude) == HNAV_OK && hnav_ins_navigation(ins, &now) == HNAV_OK) {
        printf("latitude %.5f  longitude %.5f deg, sigma %.1f m\n", now.latitude_rad * degree, now.longitude_rad * degree,
               now.sigma_position_m[0]);
        printf("velocity north %.1f  east %.1f m/s\n", now.velocity_n_m_s[0], now.velocity_n_m_s[1]);
        printf("heading %.0f deg, sigma %.1f deg, %s\n", attitude.heading_rad * degree, attitude.sigma_rad[2] * degree,
               attitude.heading_ready ? "ready" : "not ready");
    }
    hnav_filter_destroy(ins);
    return 0;
}
