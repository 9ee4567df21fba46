// The Hrekf FMU: the paper's filter.
#include "attitude_filter/filter_model.hpp"

namespace hnav::fmu {
namespace {

constexpr char list[] = "hrekf";

struct Hrekf : KindOf<hnav_hrekf_options, hnav_hrekf_defaults, list, hnav_hrekf_create> {
    static constexpr ModelInfo info = {"Hrekf",
                                       "Hybrid (robust) extended Kalman filter: attitude, heading and gyro bias from gyroscope, "
                                       "accelerometer and magnetometer",
                                       Experiment{0.01, 10}, States{14, 4}};
    static constexpr int sensors = HNAV_SENSOR_HEADING + 1;
    static constexpr int accel_dimension = 3;
    static constexpr const char* accel_unit = "";
    static constexpr bool has_field = false;
    static constexpr bool reholds = false;
};

} // namespace

constexpr ModelInfo model_info = Hrekf::info;
Model* make_model() { return new FilterModel<Hrekf>; }

} // namespace hnav::fmu
