// A minute of a car: it stands, gains speed towards the north-east, brakes, and drives curves; a fix each second.
#include "adapter/example_input.hpp"

#include <cmath>

namespace hnav::fmu {

void write_example_input(FILE* file) {
    std::fputs(
        "time,gyro.rate[1],gyro.rate[2],gyro.rate[3],accel.force[1],accel.force[2],accel.force[3],gnss.latitude,"
        "gnss.longitude,gnss.height,gnss.valid,gnssvel.velocity[1],gnssvel.velocity[2],gnssvel.velocity[3],gnssvel.valid\n",
        file);
    constexpr double step_s = 0.01, latitude = 0.8, longitude = 0.2, height_m = 400, g = 9.8, radius_m = 6.37e6;
    double speed = 0, heading = M_PI / 4, north_m = 0, east_m = 0;
    for (int k = 0; k <= 6000; ++k) {
        const double t = step_s * k;
        const double gain = t < 6 ? 0 : t < 26 ? 1.0 : t < 36 ? -0.5 : 0; // m/s2
        const double turn = t < 40 ? 0 : 0.1 * std::sin(0.4 * (t - 40));
        const double north = speed * std::cos(heading), east = speed * std::sin(heading);
        std::fprintf(file, "%.2f,0,0,%.9g,%.9g,%.9g,%.9g,%.12g,%.12g,%.9g,1,%.9g,%.9g,0,1\n", t, turn, gain, speed * turn, -g,
                     latitude + north_m / radius_m, longitude + east_m / (radius_m * std::cos(latitude)), height_m, north, east);
        speed += gain * step_s;
        heading += turn * step_s;
        north_m += north * step_s;
        east_m += east * step_s;
    }
}

} // namespace hnav::fmu
