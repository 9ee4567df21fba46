// The Vehicle FMU: truth of a car, an aircraft, a ship, a body at rest or on a given path over the rotating Earth. Position
// and course are the states of Model Exchange; in Co-Simulation they are integrated on a fixed grid of times, so that
// communication steps change nothing.
#include "adapter/library_model.hpp"
#include "adapter/option_parameters.hpp"
#include "adapter/outputs.hpp"
#include "adapter/sampled_inputs.hpp"
#include "adapter/state_rows.hpp"
#include "hnav/simulation.h"

#include <initializer_list>

namespace hnav::fmu {
namespace {

constexpr char option_list[] = "vehicle";

enum Group { truth_group };
constexpr int states = HNAV_VEHICLE_STATES;
constexpr double grid_s = 0.03125;

using VehicleCalls = LibraryObject<hnav_vehicle, hnav_vehicle_destroy, hnav_vehicle_message>;

// The vehicle has no history.
struct VehicleMemory {
    double start_s, points; // completed steps of the grid
    double x[states]; // at the last of them; in Model Exchange at the last event
    hnav_vehicle_truth truth;
};

class Vehicle final : public LibraryModel<Model, VehicleCalls, VehicleMemory> {
public:
    void describe(Table& table) override {
        using namespace rows;
        using T = hnav_vehicle_truth;
        constexpr auto on_x = DependsOn::all_states;
        table.add(time());
        const hnav_vehicle_options defaults = hnav_vehicle_defaults();
        options_ = add_options(table, option_of<option_list>, &defaults);
        describe_way(table);
        truth_.add<&T::latitude_rad>(table, flow("truth.latitude", "rad", "deg", on_x, "Latitude"));
        truth_.add<&T::longitude_rad>(table, flow("truth.longitude", "rad", "deg", on_x, "Longitude"));
        truth_.add<&T::height_m>(table, flow("truth.height", "m", "", on_x, "Height above the ellipsoid of WGS 84"));
        truth_.add<&T::velocity_n_m_s>(table, flow("truth.velocity", "m/s", "", on_x, "Velocity north, east, down"));
        truth_.add<&T::q_nb>(table,
                             flow("truth.q", "", "", on_x, "Attitude, body to north-east-down of true north, scalar first"));
        truth_.add<&T::euler_rad>(
            table, flow("truth.euler", "rad", "deg", on_x, "Roll, pitch, yaw (rotation order z y x); yaw is the heading"));
        truth_.add<&T::rate_b_rad_s>(
            table, flow("truth.rate", "rad/s", "deg/s", on_x,
                        "Angular rate against inertial axes, in body axes: with the rates of the Earth and of travel over it"));
        truth_.add<&T::force_b_m_s2>(table, flow("truth.force", "m/s2", "", on_x, "Specific force in body axes"));
        truth_.add<&T::field_b_tesla>(table, flow("truth.field", "T", "uT", on_x, "Magnetic field in body axes"));
        StateRows::add_to(table, [](StateRows& rows) {
            for (const char* name : {"state.displacement[1]", "state.displacement[2]", "state.displacement[3]"})
                rows.add(name, "m", 0, DependsOn::all_states, "Displacement from the start in Earth-fixed axes");
            rows.add("state.course", "rad", 0, DependsOn::nothing, "Course in level axes that are carried along");
        });
    }

    bool initialise(const double* values, double start_s, bool, Message* why) override {
        hnav_vehicle_options options = hnav_vehicle_defaults();
        take_options(option_of<option_list>, options_, values, &options);
        hnav_way_point way[way_points];
        const std::size_t points = take_way(values, way);
        if (options.kind == HNAV_VEHICLE_WAY ? !make(why, hnav_vehicle_create_along, &options, start_s, &way[0], points)
                                             : !make(why, hnav_vehicle_create, &options, start_s))
            return false;
        memory_.start_s = start_s;
        hnav_vehicle_start(object_, memory_.x);
        return see(start_s, memory_.x, why);
    }

    // Nothing is sampled, and nothing jumps.
    bool take_samples(double*, double) override { return false; }
    double next_sample_s(const double*) const override { return no_bound; }

    bool advance(double t_s, Message* why) override {
        const auto point_s = [this](double k) { return memory_.start_s + k * grid_s; };
        if (!check_span(point_s(memory_.points), t_s, "the grid inside", grid_s, why)) return false;
        for (; point_s(memory_.points + 1) <= t_s; memory_.points += 1)
            if (!carry(point_s(memory_.points), memory_.x, point_s(memory_.points + 1), why)) return false;
        double x[states];
        std::memcpy(x, memory_.x, sizeof x);
        return carry(point_s(memory_.points), x, t_s, why) && see(t_s, x, why);
    }

    void refresh(double* values, unsigned groups) override {
        truth_.refresh(groups, values, [this](hnav_vehicle_truth* truth) { *truth = memory_.truth; });
    }

    void get_states(double* x) const override { std::memcpy(x, memory_.x, sizeof memory_.x); }
    void get_nominals(double* nominals) const override {
        for (int i = 0; i < states; ++i) nominals[i] = 1;
    }
    bool derivatives(double t_s, const double* x, double* dx) const override {
        return hnav_vehicle_flow(object_, t_s, x, dx) == HNAV_OK;
    }
    bool jump(double t_s, double* x, bool*, Message* why) override {
        std::memcpy(memory_.x, x, sizeof memory_.x);
        return see(t_s, x, why);
    }
    void show(double t_s, const double* x) override {
        Message ignored;
        see(t_s, x, &ignored);
    }

private:
    static constexpr int way_points = 32; // parameters of the kind "way"

    void describe_way(Table& table) {
        using namespace rows;
        Variable points =
            parameter("way.points", "", 0, 0, way_points, "Points of the way of kind = way that count, the first ones");
        points.type = Type::integer;
        way_ = table.add(points);
        const auto column = [&](const char* name, const char* unit, double min, double max, const char* text) {
            table.add_vector(parameter(name, unit, 0, min, max, text), way_points);
        };
        column("way.t_s", "s", 0, 1e9, "Time of a point since the start; each later than that before");
        column("way.north_m", "m", -1e6, 1e6, "Distance of a point from the start along north there");
        column("way.east_m", "m", -1e6, 1e6, "Along east there");
        column("way.up_m", "m", -1e6, 1e6, "Height of a point above that of the start");
    }
    // How many there are.
    std::size_t take_way(const double* values, hnav_way_point* way) const {
        const double* column = values + way_ + 1;
        for (int i = 0; i < way_points; ++i)
            way[i] = {column[i], column[way_points + i], column[2 * way_points + i], column[3 * way_points + i]};
        return static_cast<std::size_t>(values[way_]);
    }

    bool carry(double from_s, double* x, double to_s, Message* why) {
        return done(hnav_vehicle_carry(object_, from_s, x, to_s), why);
    }
    bool see(double t_s, const double* x, Message* why) {
        auto truth = hnav_sized<hnav_vehicle_truth>();
        if (!done(hnav_vehicle_at(object_, t_s, x, &truth), why)) return false;
        memory_.truth = truth;
        return true;
    }

    int options_ = 0, way_ = 0;
    Outputs<hnav_vehicle_truth, truth_group> truth_;
};

} // namespace

constexpr ModelInfo model_info = {
    "Vehicle",
    "Truth for navigation: a car, an aircraft, a ship, a body at rest or one on a given way over the turning Earth, its place, "
    "velocity and attitude, and what ideal inertial sensors in it read",
    Experiment{0.01, 60},
    States{states, states},
    true,
    false}; // an importer that integrates a vehicle needs no directional derivatives
Model* make_model() { return new Vehicle; }

} // namespace hnav::fmu
