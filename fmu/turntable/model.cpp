// The Turntable FMU: true motion of a body on three axes. In Co-Simulation all of it is in closed form; in Model Exchange
// the attitude is a state that the exact rate drives, and corners of the motion are time events.
#include "adapter/model.hpp"
#include "adapter/option_parameters.hpp"
#include "hnav/simulation.h"

#include <cstring>
#include <new>

namespace hnav::fmu {
namespace {

enum Group : unsigned { truth_group = 1 };

class Turntable final : public Model {
public:
    const ModelInfo& info() const override {
        static constexpr ModelInfo turntable = {
            "Turntable", "Truth for sensors: a turntable with three axes, its attitude, rate, specific force and magnetic field",
            0.01,        60,
            4,           4,
            true,        true};
        return turntable;
    }

    void describe(Table& table) override {
        using namespace rows;
        constexpr auto flowing = Variability::continuous;
        constexpr auto on_q = DependsOn::first_states;
        Variable time = variable("time", Type::real, Causality::independent, flowing, "Simulation time");
        time.unit = "s";
        table.add(time);
        const hnav_turntable_options defaults = hnav_turntable_defaults();
        at_.options = add_options(table, hnav_turntable_option, &defaults);
        at_.q = table.add_vector(output("truth.q", "", "", truth_group, flowing, on_q,
                                        "Attitude, body to north-east-down of true north, scalar first"),
                                 4);
        at_.euler = table.add_vector(
            output("truth.euler", "rad", "deg", truth_group, flowing, on_q, "Roll, pitch, yaw (rotation order z y x)"), 3);
        at_.rate = table.add_vector(output("truth.rate", "rad/s", "deg/s", truth_group, flowing, DependsOn::nothing,
                                           "Angular rate of the body, in body axes"),
                                    3);
        at_.force =
            table.add_vector(output("truth.force", "m/s2", "", truth_group, flowing, on_q, "Specific force in body axes"), 3);
        at_.field =
            table.add_vector(output("truth.field", "T", "uT", truth_group, flowing, on_q, "Magnetic field in body axes"), 3);
        table.row(at_.q).start = 1;
        Variable state = variable("state.q", Type::real, Causality::local, flowing, "Attitude as a state of Model Exchange");
        state.group = state_group;
        state.is_state = true;
        const int first = table.add_vector(state, 4);
        table.row(first).start = 1;
        for (int i = 0; i < 4; ++i) {
            Variable derivative = state;
            std::snprintf(derivative.name, sizeof derivative.name, "der(state.q[%d])", i + 1);
            derivative.is_state = false;
            derivative.derivative_of = first + i;
            derivative.depends_on = on_q;
            table.add(derivative);
        }
    }

    bool initialise(double* values, const double* written, double start_s, bool model_exchange, Message* why) override {
        hnav_turntable_options options = hnav_turntable_defaults();
        take_options(hnav_turntable_option, at_.options, values, written, &options);
        clear();
        if (hnav_turntable_create(&table_, &options, why->text, sizeof why->text) != HNAV_OK) return false;
        now_ = {start_s, start_s, model_exchange ? 1.0 : 0.0};
        return see(start_s, nullptr, why);
    }

    // Nothing is sampled; the events of Model Exchange are the corners.
    bool take_samples(double*, double) override { return false; }
    double next_sample_s(const double*) const override {
        double corner_s = no_bound;
        if (now_.model_exchange != 0) hnav_turntable_next_corner_s(table_, now_.piece_s, &corner_s);
        return corner_s;
    }

    bool advance(double t_s, Message* why) override { return see(t_s, nullptr, why); }

    void refresh(double* values, unsigned groups) override {
        if (!(groups & truth_group)) return;
        std::memcpy(values + at_.q, truth_.q_nb, sizeof truth_.q_nb);
        std::memcpy(values + at_.euler, truth_.euler_rad, sizeof truth_.euler_rad);
        std::memcpy(values + at_.rate, truth_.rate_b_rad_s, sizeof truth_.rate_b_rad_s);
        std::memcpy(values + at_.force, truth_.force_b_m_s2, sizeof truth_.force_b_m_s2);
        std::memcpy(values + at_.field, truth_.field_b_tesla, sizeof truth_.field_b_tesla);
    }

    void get_states(double* x) const override { std::memcpy(x, truth_.q_nb, sizeof truth_.q_nb); }
    void get_nominals(double* nominals) const override {
        for (int i = 0; i < 4; ++i) nominals[i] = 1;
    }
    bool derivatives(double t_s, const double* x, double* dx) const override { return derivatives_along(t_s, x, x, dx); }
    // The flow q' = 1/2 q (x) (0, rate) is linear in q.
    bool derivatives_along(double t_s, const double*, const double* seed, double* out) const override {
        hnav_truth truth;
        if (hnav_turntable_in_piece(table_, piece_s(t_s), t_s, &truth) != HNAV_OK) return false;
        const double *u = truth.rate_b_rad_s, *q = seed;
        out[0] = 0.5 * (-q[1] * u[0] - q[2] * u[1] - q[3] * u[2]);
        out[1] = 0.5 * (q[0] * u[0] - q[3] * u[1] + q[2] * u[2]);
        out[2] = 0.5 * (q[3] * u[0] + q[0] * u[1] - q[1] * u[2]);
        out[3] = 0.5 * (-q[2] * u[0] + q[1] * u[1] + q[0] * u[2]);
        return true;
    }
    bool jump(double t_s, double* x, bool*, Message* why) override {
        now_.piece_s = t_s;
        return see(t_s, x, why);
    }
    void show(double t_s, const double* x) override {
        Message ignored;
        see(t_s, x, &ignored);
    }

    std::size_t state_size() const override { return sizeof now_; }
    void save(void* buffer) const override { std::memcpy(buffer, &now_, sizeof now_); }
    bool load(const void* buffer, std::size_t bytes) override {
        if (bytes != sizeof now_) return false;
        std::memcpy(&now_, buffer, sizeof now_);
        Message why;
        return see(now_.t_s, nullptr, &why);
    }

    void clear() override {
        hnav_turntable_destroy(table_);
        table_ = nullptr;
    }
    void destroy() override {
        clear();
        this->~Turntable();
        std::free(this);
    }

private:
    ~Turntable() = default;

    // In Model Exchange a piece holds until the event at its corner, so that the flow is smooth for the integrator.
    double piece_s(double t_s) const { return now_.model_exchange != 0 ? now_.piece_s : t_s; }

    // Truth at t_s; force and field in the attitude x where one is given.
    bool see(double t_s, const double* x, Message* why) {
        hnav_truth truth;
        bool seen = hnav_turntable_in_piece(table_, piece_s(t_s), t_s, &truth) == HNAV_OK;
        if (seen && x) {
            double length = 0;
            for (int i = 0; i < 4; ++i) length += x[i] * x[i];
            length = std::sqrt(length);
            for (int i = 0; i < 4; ++i) truth.q_nb[i] = x[i] / length;
            const double* q = truth.q_nb;
            truth.euler_rad[0] = std::atan2(2 * (q[0] * q[1] + q[2] * q[3]), 1 - 2 * (q[1] * q[1] + q[2] * q[2]));
            truth.euler_rad[1] = std::asin(std::fmin(1.0, std::fmax(-1.0, 2 * (q[0] * q[2] - q[3] * q[1]))));
            truth.euler_rad[2] = std::atan2(2 * (q[0] * q[3] + q[1] * q[2]), 1 - 2 * (q[2] * q[2] + q[3] * q[3]));
            seen = hnav_turntable_seen_from(table_, x, truth.force_b_m_s2, truth.field_b_tesla) == HNAV_OK;
        }
        if (!seen) {
            std::snprintf(why->text, sizeof why->text, "the attitude at t = %g s is none", t_s);
            return false;
        }
        truth_ = truth;
        now_.t_s = t_s;
        return true;
    }

    struct {
        int options, q, euler, rate, force, field;
    } at_{};
    struct {
        double t_s, piece_s, model_exchange;
    } now_{};
    hnav_truth truth_{0, {1, 0, 0, 0}, {}, {}, {}, {}};
    hnav_turntable* table_ = nullptr;
};

} // namespace

Model* make_model() {
    void* memory = std::malloc(sizeof(Turntable));
    return memory ? new (memory) Turntable : nullptr;
}

} // namespace hnav::fmu
