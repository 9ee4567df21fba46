// Five seconds of a body that drives at 10 m/s along its x axis and turns from north to east at 20 deg/s. Used for Gnss and
// Wheel; longitude and height keep their start values.
#include "adapter/example_input.hpp"

#include <cmath>

namespace hnav::fmu {

void write_example_input(FILE* file) {
    std::fputs("time,truth.latitude,truth.velocity[1],truth.velocity[2],truth.q[1],truth.q[4],truth.rate[3]\n", file);
    constexpr double rate = 20 * M_PI / 180, speed = 10, latitude = 0.8;
    for (int k = 0; k <= 500; ++k) {
        const double t = 0.01 * k, yaw = rate * t;
        std::fprintf(file, "%.2f,%.12g,%.9g,%.9g,%.9g,%.9g,%.9g\n", t, latitude, speed * std::cos(yaw), speed * std::sin(yaw),
                     std::cos(0.5 * yaw), std::sin(0.5 * yaw), rate);
    }
}

} // namespace hnav::fmu
