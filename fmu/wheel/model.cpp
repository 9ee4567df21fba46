// The Wheel FMU: speed along the body axis of a vehicle from its wheels.
#include "aid_sensor/sensor_model.hpp"

namespace hnav::fmu {
namespace {

class Wheel final : public AidSensorModel<HNAV_AID_WHEEL> {
public:
    void describe(Table& table) override {
        using namespace rows;
        table.add(time());
        body_.describe(table);
        describe_options(table);
        const int first = show_value<0>(table, output("wheel.speed", "m/s", "", "Speed along body x, newest sample delivered"));
        show_sigma<0>(table, output("wheel.sigma", "m/s", "", "Its standard deviation, as stated"));
        show_marks(table, "wheel", first);
        show_counts(table);
    }

private:
    void read(const double* values, hnav_vehicle_truth* truth) const override { body_.read(values, truth); }

    BodyRows body_{};
};

} // namespace

constexpr ModelInfo model_info = sensor_info(
    HNAV_FMU_NAME, "Speed by wheels of uncertain size: truth to samples with counters and time stamps", HNAV_FMU_CLOCKS != 0);
Model* make_model() { return new Wheel; }

} // namespace hnav::fmu
