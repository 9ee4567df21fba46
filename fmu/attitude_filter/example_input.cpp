// Ten seconds of a body that lies tilted by 20 degrees and turns about its own z axis, to and fro.
#include "adapter/example_input.hpp"

#include <cmath>

namespace hnav::fmu {

void write_example_input(FILE* file) {
    std::fputs(
        "time,gyro.rate[1],gyro.rate[2],gyro.rate[3],accel.force[1],accel.force[2],accel.force[3],"
        "mag.field[1],mag.field[2],mag.field[3]\n",
        file);
    constexpr double tilt = 20 * M_PI / 180, g = 9.80665, north = 2e-5, down = 4.5e-5;
    for (int k = 0; k <= 1000; ++k) {
        const double t = 0.01 * k;
        const double turn = std::sin(0.5 * t); // about body z
        const double c = std::cos(turn), s = std::sin(turn);
        // Navigation vectors in axes rolled by the tilt, then turned.
        const auto body = [&](double x, double y, double z, double out[3]) {
            const double rolled_y = std::cos(tilt) * y + std::sin(tilt) * z, rolled_z = -std::sin(tilt) * y + std::cos(tilt) * z;
            out[0] = c * x + s * rolled_y;
            out[1] = -s * x + c * rolled_y;
            out[2] = rolled_z;
        };
        double force[3], field[3];
        body(0, 0, -g, force);
        body(north, 0, down, field);
        // The rate that leads to the next row, and a bias of a tenth of a degree per second about x.
        const double rate_z = (std::sin(0.5 * (t + 0.01)) - turn) / 0.01;
        std::fprintf(file, "%.2f,%.9g,0,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n", t, 0.1 * M_PI / 180, rate_z, force[0], force[1],
                     force[2], field[0], field[1], field[2]);
    }
}

} // namespace hnav::fmu
