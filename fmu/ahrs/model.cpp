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
    static constexpr int sensors = HNAV_SENSOR_SPEED + 1;
    static constexpr int accel_dimension = 2;
    static constexpr const char* accel_unit = "m/s";
    static constexpr bool has_field = true;
    static constexpr bool reholds = true;
};

} // namespace

constexpr ModelInfo model_info = Ahrs::info;
Model* make_model() { return new FilterModel<Ahrs>; }

} // namespace hnav::fmu
