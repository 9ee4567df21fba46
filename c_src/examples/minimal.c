/* The smallest program: a body lies tilted at rest; after two seconds of samples the filter has its attitude. */
#include <hnav/hnav.h>
#include <stdio.h>

int main(void) {
    const double rate[3] = {0, 0, 0}, force[3] = {0.855, -3.342, -9.183}, field[3] = {1.333e-5, 0.645e-5, 4.696e-5};
    hnav_ahrs_options options = hnav_ahrs_defaults(HNAV_PRESET_DEFAULT);
    hnav_filter* filter;
    char message[256];
    if (hnav_ahrs_create(&filter, &options, message, sizeof message) != HNAV_OK) {
        fprintf(stderr, "%s\n", message);
        return 1;
    }
    for (int k = 0; k <= 200; ++k) {
        const double t_s = 0.01 * k;
        hnav_filter_push_imu(filter, t_s, rate, force);
        hnav_filter_push_mag(filter, t_s, field);
        if (hnav_filter_advance(filter, t_s) != HNAV_OK) fprintf(stderr, "%s\n", hnav_filter_message(filter));
    }
    hnav_attitude a = {.size = sizeof a};
    if (hnav_filter_attitude(filter, &a) == HNAV_OK)
        printf("roll %.1f  pitch %.1f  heading %.1f deg, sigma %.1f deg\n", a.euler_rad[0] * 57.29578, a.euler_rad[1] * 57.29578,
               a.heading_rad * 57.29578, a.sigma_rad[2] * 57.29578);
    hnav_filter_destroy(filter);
    return 0;
}
