// Twenty seconds of the aircraft with coloured errors and faults in the readings of its INS.
#include "adapter/example_input.hpp"
#include "aircraft/data.hpp"

namespace hnav::fmu {

void write_example_input(FILE* file) {
    using namespace aircraft;
    std::fputs("time", file);
    for (const Quantity& control : controls) std::fprintf(file, ",u.%s", control.name);
    for (const Quantity& state : states) std::fprintf(file, ",z.%s", state.name);
    std::fputs("\n", file);

    hnav_aircraft_options options = hnav_aircraft_defaults();
    options.seed = 1;
    auto model = hnav_sized<hnav_aircraft_model>();
    model.nx = nx;
    model.nu = nu;
    model.interval_s = interval_s;
    model.A_1_s = A_1_s;
    model.B_1_s = B_1_s;
    model.process_noise_per_sqrt_s = process_noise_per_sqrt_s;
    model.measurement_sigma = measurement_sigma;
    model.accelerometer_error = {ins_error_sigma, ins_error_time_constant_s};
    model.start_sigma = start_sigma;
    model.commands = commands;
    model.faults = faults;
    hnav_aircraft* plant;
    if (hnav_aircraft_create(&plant, &options, &model, nullptr, 0) != HNAV_OK) return;
    for (int k = 0; k <= 200; ++k) {
        double u[nu], z[nx];
        auto sample = hnav_sized<hnav_aircraft_sample>();
        sample.u = u;
        sample.z = z;
        hnav_aircraft_get_sample(plant, &sample);
        std::fprintf(file, "%.9g", sample.t_s);
        for (const double value : u) std::fprintf(file, ",%.9g", value);
        for (const double value : z) std::fprintf(file, ",%.9g", value);
        std::fputs("\n", file);
        hnav_aircraft_step(plant, nullptr);
    }
    hnav_aircraft_destroy(plant);
}

} // namespace hnav::fmu
