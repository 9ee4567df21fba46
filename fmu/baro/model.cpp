// The Baro FMU: the pressure of the standard atmosphere at the height of a vehicle, and the weather.
#include "aid_sensor/sensor_model.hpp"

namespace hnav::fmu {
namespace {

class Baro final : public AidSensorModel<HNAV_AID_BARO> {
public:
    void describe(Table& table) override {
        using namespace rows;
        table.add(time());
        height_ = table.add(truth_row("truth.height", "m", "", "Height, of which the standard atmosphere makes a pressure"));
        describe_options(table);
        const int first = show_value<0>(table, output("baro.pressure", "Pa", "", "Pressure of the air, newest sample delivered"));
        show_sigma<0>(table, output("baro.sigma", "Pa", "", "Its standard deviation, as stated"));
        show_marks(table, "baro", first);
        show_counts(table);
    }

private:
    void read(const double* values, hnav_vehicle_truth* truth) const override { truth->height_m = values[height_]; }

    int height_ = 0;
};

} // namespace

constexpr ModelInfo model_info = sensor_info(
    HNAV_FMU_NAME, "A barometer under changing weather: heights to samples with counters and time stamps", HNAV_FMU_CLOCKS != 0);
Model* make_model() { return new Baro; }

} // namespace hnav::fmu
