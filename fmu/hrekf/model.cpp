// The Hrekf FMU: the paper's filter.
#include "attitude/filter_model.hpp"

namespace hnav::fmu {
namespace {

struct Hrekf {
    using Options = hnav_hrekf_options;
    static Options defaults(hnav_preset preset) { return hnav_hrekf_defaults(preset); }
    static const hnav_option_info* option(int index) { return hnav_hrekf_option(index); }
    static hnav_status create(hnav_filter** filter, const Options* options, char* message, std::size_t size) {
        return hnav_hrekf_create(filter, options, message, size);
    }

    static constexpr ModelInfo info = {
        "Hrekf",
        "Hybrid (robust) extended Kalman filter: attitude, heading and gyro bias from gyroscope, accelerometer and magnetometer",
        0.01,
        10,
        35,
        7,
        true};
    static constexpr const char* presets[] = {"default", "paper"};
    static constexpr int accel_dimension = 3;
    static constexpr const char* accel_unit = "";
    static constexpr bool has_field = false;
    static constexpr bool reholds = false;

    static void describe_states(StateRows& states) {
        char name[32];
        for (int i = 1; i <= 4; ++i) {
            std::snprintf(name, sizeof name, "state.q[%d]", i);
            states.add(name, "", i == 1, DependsOn::first_states, "Attitude, body to north-east-down of magnetic north");
        }
        for (int i = 1; i <= 3; ++i) {
            std::snprintf(name, sizeof name, "state.b[%d]", i);
            states.add(name, "rad/s", 0, DependsOn::nothing, "Gyro bias");
        }
        for (int i = 1; i <= 7; ++i)
            for (int j = i; j <= 7; ++j) {
                std::snprintf(name, sizeof name, "state.P[%d,%d]", i, j);
                // The bias block grows by its noise alone.
                states.add(name, "", 0, i > 4 ? DependsOn::nothing : DependsOn::all_states, "Covariance of q and b");
            }
    }

    // The bias, and its covariance, which stands last in the packed triangle.
    static void keep_on_realign(const double* x, double* replaced) {
        std::memcpy(replaced + 4, x + 4, 3 * sizeof(double));
        std::memcpy(replaced + info.nx - 6, x + info.nx - 6, 6 * sizeof(double));
    }
};

} // namespace

Model* make_model() { return FilterModel<Hrekf>::make(); }

} // namespace hnav::fmu
