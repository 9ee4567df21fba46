// The Turntable FMU: true motion of a body on three axes. In Co-Simulation it is in closed form; in Model Exchange the
// attitude is a state driven by the exact rate, and corners of the motion are time events.
#include "adapter/library_model.hpp"
#include "adapter/option_parameters.hpp"
#include "adapter/outputs.hpp"
#include "adapter/sampling_clock.hpp"
#include "adapter/state_rows.hpp"
#include "hnav/simulation.h"

#include <initializer_list>

namespace hnav::fmu {
namespace {

constexpr char option_list[] = "turntable";

enum Group { truth_group };

// The table has no history.
using TurntableCalls = LibraryObject<hnav_turntable, hnav_turntable_destroy, hnav_turntable_message>;

struct TurntableMemory {
    double piece_s; // in Model Exchange a piece is held until the event at its corner, so that the derivative is smooth
    double model_exchange;
    hnav_truth truth; // shown
    double length;    // the attitude of the last show
};

class Turntable final : public LibraryModel<Model, TurntableCalls, TurntableMemory> {
public:
    void describe(Table& table) override {
        using namespace rows;
        constexpr auto on_q = DependsOn::first_states;
        table.add(time());
        const hnav_turntable_options defaults = hnav_turntable_defaults();
        options_ = add_options(table, option_of<option_list>, &defaults);
        q_ = truth_.add<&hnav_truth::q_nb>(
            table, flow("truth.q", "", "", on_q, "Attitude, body to north-east-down of true north, scalar first"));
        euler_ = truth_.add<&hnav_truth::euler_rad>(
            table, flow("truth.euler", "rad", "deg", on_q, "Roll, pitch, yaw (rotation order z y x)"));
        truth_.add<&hnav_truth::rate_b_rad_s>(
            table, flow("truth.rate", "rad/s", "deg/s", DependsOn::nothing, "Angular rate of the body, in body axes"));
        force_ =
            truth_.add<&hnav_truth::force_b_m_s2>(table, flow("truth.force", "m/s2", "", on_q, "Specific force in body axes"));
        field_ =
            truth_.add<&hnav_truth::field_b_tesla>(table, flow("truth.field", "T", "uT", on_q, "Magnetic field in body axes"));
        StateRows::add_to(table, [](StateRows& states) { states.add_attitude("Attitude as a state of Model Exchange"); });
    }

    bool initialise(const double* values, double start_s, bool model_exchange, Message* why) override {
        hnav_turntable_options options = hnav_turntable_defaults();
        take_options(option_of<option_list>, options_, values, &options);
        if (!make(why, hnav_turntable_create, &options)) return false;
        memory_.piece_s = start_s;
        memory_.model_exchange = model_exchange;
        return see(start_s, nullptr, why);
    }

    // Nothing is sampled; the events of Model Exchange are the corners.
    bool take_samples(double*, double) override { return false; }
    double next_sample_s(const double*) const override {
        double corner_s = no_bound;
        if (memory_.model_exchange != 0) hnav_turntable_next_corner_s(object_, memory_.piece_s, &corner_s);
        return corner_s;
    }

    bool advance(double t_s, Message* why) override { return see(t_s, nullptr, why); }

    void refresh(double* values, unsigned groups) override {
        truth_.refresh(groups, values, [this](hnav_truth* truth) { *truth = memory_.truth; });
    }

    void get_states(double* x) const override { std::memcpy(x, memory_.truth.q_nb, sizeof memory_.truth.q_nb); }
    void get_nominals(double* nominals) const override {
        for (int i = 0; i < 4; ++i) nominals[i] = 1;
    }
    bool derivatives(double t_s, const double* x, double* dx) const override { return derivatives_along(t_s, x, x, dx); }
    // The derivative is linear in the attitude.
    bool derivatives_along(double t_s, const double*, const double* seed, double* out) const override {
        auto truth = hnav_sized<hnav_truth>();
        if (hnav_turntable_in_piece(object_, piece_s(t_s), t_s, &truth) != HNAV_OK) return false;
        return hnav_quaternion_derivative(seed, truth.rate_b_rad_s, out) == HNAV_OK;
    }
    // At a corner the rate jumps. An integrator with a history restarts only when it is informed of changed states.
    bool jump(double t_s, double* x, bool* changed, Message* why) override {
        double corner_s = no_bound;
        hnav_turntable_next_corner_s(object_, memory_.piece_s, &corner_s);
        *changed = corner_s <= t_s + time_tolerance(t_s, min_period_s);
        memory_.piece_s = t_s;
        return see(t_s, x, why);
    }
    void show(double t_s, const double* x) override {
        Message ignored;
        see(t_s, x, &ignored);
    }

    // Force and field are quadratic in the components of the attitude, whose length is removed: the difference of two values
    // on both sides is the exact derivative.
    void rows_along(const double* seed, double* rows) const override {
        double q[4], turn[4], inner = 0, length = 0;
        std::memcpy(q, memory_.truth.q_nb, sizeof q);
        for (int i = 0; i < 4; ++i) inner += q[i] * seed[i];
        for (int i = 0; i < 4; ++i) turn[i] = (seed[i] - inner * q[i]) / memory_.length; // only the direction is shown
        for (int i = 0; i < 4; ++i) length += turn[i] * turn[i];
        length = std::sqrt(length);
        std::memcpy(rows + q_, turn, sizeof turn);
        hnav_quaternion_to_euler_along(q, turn, rows + euler_);
        if (!(length > 0)) return;
        for (const int side : {1, -1}) {
            double to[4], force[3], field[3]; // of length sqrt(2): products of two components are halves of their earlier values
            for (int i = 0; i < 4; ++i) to[i] = q[i] + side * turn[i] / length;
            hnav_turntable_seen_from(object_, to, force, field);
            for (int i = 0; i < 3; ++i) {
                rows[force_ + i] += side * length * force[i];
                rows[field_ + i] += side * length * field[i];
            }
        }
    }

private:
    double piece_s(double t_s) const { return memory_.model_exchange != 0 ? memory_.piece_s : t_s; }

    // Truth at t_s, at the attitude x if given.
    bool see(double t_s, const double* x, Message* why) {
        auto truth = hnav_sized<hnav_truth>();
        if (!done(hnav_turntable_in_piece(object_, piece_s(t_s), t_s, &truth), why)) return false;
        memory_.length = 1;
        if (x) {
            if (!done(hnav_turntable_seen_from(object_, x, truth.force_b_m_s2, truth.field_b_tesla), why)) return false;
            double length = 0;
            for (int i = 0; i < 4; ++i) length += x[i] * x[i];
            length = std::sqrt(length);
            for (int i = 0; i < 4; ++i) truth.q_nb[i] = x[i] / length;
            memory_.length = length;
            hnav_quaternion_to_euler(truth.q_nb, truth.euler_rad);
        }
        memory_.truth = truth;
        return true;
    }

    int options_ = 0, q_ = 0, euler_ = 0, force_ = 0, field_ = 0; // first rows
    Outputs<hnav_truth, truth_group> truth_;
};

} // namespace

constexpr ModelInfo model_info = {
    "Turntable", "Truth for sensors: a turntable with three axes, its attitude, rate, specific force and magnetic field",
    Experiment{0.01, 60}, States{4, 4}};
Model* make_model() { return new Turntable; }

} // namespace hnav::fmu
