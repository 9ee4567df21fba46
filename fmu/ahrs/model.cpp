// The Ahrs FMU: the filter for real sensors.
#include "attitude_filter/filter_model.hpp"

namespace hnav::fmu {
namespace {

constexpr char list[] = "ahrs";

struct Ahrs : KindOf<hnav_ahrs_options, hnav_ahrs_defaults, list, hnav_ahrs_create> {
    static constexpr ModelInfo info = {
        HNAV_FMU_NAME,
        "Attitude and heading from real gyroscopes, accelerometers and magnetometers: gyro bias and calibration, "
        "magnetometer latency, magnetic disturbances, rest",
        Experiment{0.01, 10},
        States{14, 4},
        true,
        true,
        HNAV_FMU_ARRAYS != 0,
        HNAV_FMU_CLOCKS != 0};
    static constexpr int accel_dimension = 2;
    static constexpr const char* accel_unit = "m/s";
    static constexpr bool has_field = true;
    static constexpr bool reholds = true;

    static void describe_states(StateRows& states) {
        states.add_attitude("Attitude, body to north-east-down of magnetic north");
        char name[32];
        for (int j = 1; j <= 3; ++j)
            for (int i = 1; i <= 3; ++i) {
                std::snprintf(name, sizeof name, "state.G[%d,%d]", i, j);
                states.add(name, "s", 0, DependsOn::first_states,
                           "Integral of the rotation matrix since the last correction: how bias becomes rotation");
            }
        states.add("state.clock", "s", 0, DependsOn::nothing, "Time since the last correction");
    }

    // What was learnt of the sensors is no continuous state.
    static void keep_on_realign(const double*, double*) {}
};

} // namespace

constexpr ModelInfo model_info = Ahrs::info;
Model* make_model() { return new FilterModel<Ahrs>; }

} // namespace hnav::fmu
