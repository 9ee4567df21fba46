// The Gnss FMU: a satellite receiver in a vehicle, whose samples have the names of the Ins's inputs.
#include "aid_sensor/sensor_model.hpp"

namespace hnav::fmu {
namespace {

class Gnss final : public AidSensorModel<HNAV_AID_GNSS> {
public:
    void describe(Table& table) override {
        using namespace rows;
        table.add(time());
        body_.describe(table);
        longitude_ = table.add(truth_row("truth.longitude", "rad", "deg", "Longitude"));
        height_ = table.add(truth_row("truth.height", "m", "", "Height above the ellipsoid of WGS 84"));
        describe_options(table);
        const int place =
            show_value<0>(table, output("gnss.latitude", "rad", "deg", "Latitude of the antenna, newest sample delivered"));
        show_value<1>(table, output("gnss.longitude", "rad", "deg", "Longitude of the antenna"));
        show_value<2>(table, output("gnss.height", "m", "", "Height of the antenna above the ellipsoid of WGS 84"));
        show_sigma<0, 3>(table, output("gnss.sigma", "m", "", "Standard deviations north, east, down, as stated"));
        show_marks(table, "gnss", place);
        const int velocity = show_value<3, 3>(
            table, output("gnssvel.velocity", "m/s", "", "Velocity of the antenna north, east, down, newest sample"));
        show_sigma<3, 3>(table, output("gnssvel.sigma", "m/s", "", "Standard deviations north, east, down, as stated"));
        show_marks(table, "gnssvel", velocity);
        show_counts(table);
    }

private:
    void read(const double* values, hnav_vehicle_truth* truth) const override {
        body_.read(values, truth);
        truth->longitude_rad = values[longitude_];
        truth->height_m = values[height_];
    }

    BodyRows body_{};
    int longitude_ = 0, height_ = 0;
};

} // namespace

constexpr ModelInfo model_info =
    sensor_info(HNAV_FMU_NAME,
                "A receiver of satellites, with slow errors, latency, outages and jumps: truth to fixes with "
                "counters and time stamps",
                HNAV_FMU_CLOCKS != 0);
Model* make_model() { return new Gnss; }

} // namespace hnav::fmu
