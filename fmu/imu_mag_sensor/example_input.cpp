// Five seconds of a level body that turns about its vertical axis at 20 deg/s and starts magnetically north.
#include "adapter/example_input.hpp"

#include <cmath>

namespace hnav::fmu {

void write_example_input(FILE* file) {
    std::fputs(
        "time,truth.q[1],truth.q[2],truth.q[3],truth.q[4],truth.rate[1],truth.rate[2],truth.rate[3],truth.force[1],"
        "truth.force[2],truth.force[3],truth.field[1],truth.field[2],truth.field[3]\n",
        file);
    constexpr double rate = 20 * M_PI / 180, north = 2e-5, down = 4.5e-5;
    for (int k = 0; k <= 500; ++k) {
        const double t = 0.01 * k, yaw = rate * t;
        std::fprintf(file, "%.2f,%.9g,0,0,%.9g,0,0,%.9g,0,0,-9.80665,%.9g,%.9g,%.9g\n", t, std::cos(0.5 * yaw),
                     std::sin(0.5 * yaw), rate, north * std::cos(yaw), -north * std::sin(yaw), down);
    }
}

} // namespace hnav::fmu
