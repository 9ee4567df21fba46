// The Hrekf FMU: the paper's filter.
#include "attitude_filter/filter_model.hpp"

namespace hnav::fmu {
namespace {

constexpr char list[] = "hrekf";

struct Hrekf : KindOf<hnav_hrekf_options, hnav_hrekf_defaults, list, hnav_hrekf_create> {
    static constexpr ModelInfo info = {"Hrekf",
                                       "Hybrid (robust) extended Kalman filter: attitude, heading and gyro bias from gyroscope, "
                                       "accelerometer and magnetometer",
                                       Experiment{0.01, 10}, States{35, 7}};
    static constexpr int accel_dimension = 3;
    static constexpr const char* accel_unit = "";
    static constexpr bool has_field = false;
    static constexpr bool reholds = false;

    static void describe_states(StateRows& states) {
        states.add_attitude("Attitude, body to north-east-down of magnetic north");
        char name[32];
        for (int i = 1; i <= 3; ++i) {
            std::snprintf(name, sizeof name, "state.b[%d]", i);
            states.add(name, "rad/s", 0, DependsOn::nothing, "Gyro bias");
        }
        for (int i = 1; i <= 7; ++i)
            for (int j = i; j <= 7; ++j) {
                std::snprintf(name, sizeof name, "state.P[%d,%d]", i, j);
                // The bias block grows by its noise only.
                states.add(name, "", 0, i > 4 ? DependsOn::nothing : DependsOn::all_states, "Covariance of q and b");
            }
    }

    // The bias, and its covariance, which stands last in the packed triangle.
    static void keep_on_realign(const double* x, double* replaced) {
        std::memcpy(replaced + 4, x + 4, 3 * sizeof(double));
        std::memcpy(replaced + info.states.count - 6, x + info.states.count - 6, 6 * sizeof(double));
    }
};

} // namespace

constexpr ModelInfo model_info = Hrekf::info;
Model* make_model() { return new FilterModel<Hrekf>; }

} // namespace hnav::fmu
