// The Pendulum FMU: a plant for observers. Angle and rate are continuous states; a sensor reads the angle with seeded noise.
#include "adapter/model.hpp"
#include "adapter/outputs.hpp"
#include "adapter/rows.hpp"
#include "adapter/sampled_inputs.hpp"
#include "adapter/state_rows.hpp"

#include <cstdint>

namespace hnav::fmu {
namespace {

enum Group { truth_group, sample_group };
enum { angle, rate, dimension };

struct Truth {
    double x[dimension];
};
struct Sample {
    double value, number, t_s;
};

// Eight-byte numbers, saved bytewise.
struct Memory {
    SamplingClock clock;
    Truth truth; // shown, at now_s
    Sample sample;
    double now_s, drive;
    double damping_1_s, frequency2_rad2_s2, noise_rad, seed;
};
static_assert(sizeof(Memory) % 8 == 0);

constexpr double longest_substep_s = 2e-3, most_substeps_per_sample = 100; // of a tenth of a microsecond

// Number k of a seeded sequence of white noise: a function of seed and k, so that a repeated step draws the same numbers.
double normal(double seed, double k) {
    std::uint64_t words[2];
    std::uint64_t state = static_cast<std::uint64_t>(seed) * 0x9e3779b97f4a7c15ull ^ static_cast<std::uint64_t>(k);
    for (std::uint64_t& word : words) { // SplitMix64
        state += 0x9e3779b97f4a7c15ull;
        word = (state ^ (state >> 30)) * 0xbf58476d1ce4e5b9ull;
        word = (word ^ (word >> 27)) * 0x94d049bb133111ebull;
        word ^= word >> 31;
    }
    const auto uniform = [](std::uint64_t word) { return static_cast<double>(word >> 11) * 0x1p-53; };
    return std::sqrt(-2 * std::log(1 - uniform(words[0]))) * std::cos(6.283185307179586 * uniform(words[1]));
}

class Pendulum final : public Model {
public:
    void describe(Table& table) override {
        using namespace rows;
        constexpr auto on_x = DependsOn::all_states;
        table.add(time());
        drive_ = table.add(input("drive", "rad/s2", "", 0, "Angular acceleration by a motor, held from sample to sample"));
        start_angle_ = add_parameter(table, "start.angle_rad", "rad", 0.5, -3.2, 3.2, "Angle at the start, 0 when it hangs");
        start_rate_ = add_parameter(table, "start.rate_rad_s", "rad/s", 0, -100, 100, "Rate at the start");
        frequency_ = add_parameter(table, "frequency_rad_s", "rad/s", 3.0, 1e-3, 100, "Of small swings without damping");
        damping_ = add_parameter(table, "damping_1_s", "1/s", 0.1, 0, 100, "Rate that friction takes away");
        period_ = add_parameter(table, "measured.period_s", "s", 0.02, min_period_s, 1e6, "Sampling period");
        noise_ = add_parameter(table, "measured.noise_rad", "rad", 0.01, 0, 10, "Sigma of the noise of a sample");
        Variable v = variable("seed", Type::integer, Causality::parameter, Variability::fixed, "Of the noise");
        v.min = 0;
        v.max = 2147483647;
        v.start = 1;
        seed_ = table.add(v);
        true_angle_ = truth_.add(table, flow("truth.angle", "rad", "deg", on_x, "Angle, 0 when it hangs"),
                                 [](const Truth& t, double* row) { *row = t.x[angle]; });
        true_rate_ = truth_.add(table, flow("truth.rate", "rad/s", "deg/s", on_x, "Its rate"),
                                [](const Truth& t, double* row) { *row = t.x[rate]; });
        sample_.add<&Sample::value>(table, output("measured.value", "rad", "deg", "Angle, newest sample"));
        sample_.add<&Sample::number>(table, output("measured.sample", Type::integer, "Samples taken: a change marks a new one"));
        sample_.add<&Sample::t_s>(table, output("measured.t_meas", "s", "", "Time at which the sample was measured"));
        StateRows::add_to(table, [](StateRows& states) {
            states.add("angle", "rad", 0.5, on_x, "Angle, 0 when it hangs");
            states.add("rate", "rad/s", 0, on_x, "Its rate");
        });
    }

    bool initialise(const double* values, double start_s, bool, Message*) override {
        memory_ = {};
        memory_.clock = {start_s, values[period_], periodic, 0, 1}; // the first sample is due after one period
        memory_.truth = {{values[start_angle_], values[start_rate_]}};
        memory_.now_s = start_s;
        memory_.damping_1_s = values[damping_];
        memory_.frequency2_rad2_s2 = values[frequency_] * values[frequency_];
        memory_.noise_rad = values[noise_];
        memory_.seed = values[seed_];
        return true;
    }

    void begin(const double* values) override { memory_.drive = std::isfinite(values[drive_]) ? values[drive_] : 0; }

    // ------------------------------------------------------------------------------------------------ time

    // A drive of NaN leaves the previous one in force.
    bool take_samples(double* values, double) override {
        if (std::isfinite(values[drive_])) memory_.drive = values[drive_];
        return true;
    }
    double next_sample_s(const double*) const override { return memory_.clock.next_s(); }

    bool advance(double t_s, Message* why) override {
        if (!check_span(memory_.now_s, t_s, "measured.period_s", memory_.clock.period_s, why) ||
            !check_span(memory_.now_s, t_s, "the longest substep", most_substeps_per_sample * longest_substep_s, why))
            return false;
        for (;;) {
            const double due_s = memory_.clock.next_s();
            if (!(due_s <= t_s + time_tolerance(t_s, memory_.clock.period_s))) break;
            swing_to(std::fmax(due_s, memory_.now_s));
            measure(due_s);
        }
        swing_to(t_s);
        return true;
    }

    // ------------------------------------------------------------------------------------------------ outputs

    void refresh(double* values, unsigned groups) override {
        truth_.refresh(groups, values, [this](Truth* t) { *t = memory_.truth; });
        sample_.refresh(groups, values, [this](Sample* s) { *s = memory_.sample; });
    }

    // ------------------------------------------------------------------------------------------------ Model Exchange

    void get_states(double* x) const override { std::memcpy(x, memory_.truth.x, sizeof memory_.truth.x); }
    void get_nominals(double* nominals) const override { nominals[angle] = nominals[rate] = 1; }
    bool derivatives(double, const double* x, double* dx) const override {
        dx[angle] = x[rate];
        dx[rate] = -memory_.frequency2_rad2_s2 * std::sin(x[angle]) - memory_.damping_1_s * x[rate] + memory_.drive;
        return true;
    }
    bool derivatives_along(double, const double* x, const double* seed, double* out) const override {
        out[angle] = seed[rate];
        out[rate] = -memory_.frequency2_rad2_s2 * std::cos(x[angle]) * seed[angle] - memory_.damping_1_s * seed[rate];
        return true;
    }
    bool jump(double t_s, double* x, bool*, Message*) override {
        show(t_s, x);
        measure(t_s);
        return true;
    }
    void show(double t_s, const double* x) override {
        memory_.now_s = t_s;
        std::memcpy(memory_.truth.x, x, sizeof memory_.truth.x);
    }
    void rows_along(const double* seed, double* rows) const override {
        rows[true_angle_] = seed[angle];
        rows[true_rate_] = seed[rate];
    }

    std::size_t state_size() const override { return sizeof memory_; }
    void save(void* buffer) const override { std::memcpy(buffer, &memory_, sizeof memory_); }
    bool load(const void* buffer, std::size_t bytes, Message* /*why*/) override {
        if (bytes != sizeof memory_) return false;
        std::memcpy(&memory_, buffer, sizeof memory_);
        return true;
    }
    void clear() override { memory_ = {}; }

private:
    static int add_parameter(Table& table, const char* name, const char* unit, double start, double min, double max,
                             const char* text) {
        Variable v = rows::parameter(name, unit, start, min, max, text);
        if (!std::strcmp(unit, "rad")) v.display_unit = "deg";
        v.basic = true;
        return table.add(v);
    }

    // Takes the sample that is due at t_s, if there is one.
    void measure(double t_s) {
        NewSample due;
        if (!memory_.clock.take(t_s, 0, t_s, &due)) return;
        const double k = memory_.clock.due - 1;
        memory_.sample = {memory_.truth.x[angle] + memory_.noise_rad * normal(memory_.seed, k), k, t_s};
    }

    // The classical Runge-Kutta method of order 4 in equal steps.
    void swing_to(double t_s) {
        const double interval_s = t_s - memory_.now_s, steps = std::ceil(interval_s / longest_substep_s);
        if (!(interval_s > 0)) return;
        const double h = interval_s / steps;
        double* x = memory_.truth.x;
        for (double k = 0; k < steps; ++k) {
            double slope[4][dimension], at[dimension];
            derivatives(0, x, slope[0]);
            for (int stage = 1; stage < 4; ++stage) {
                const double part = stage == 3 ? h : h / 2;
                for (int i = 0; i < dimension; ++i) at[i] = x[i] + part * slope[stage - 1][i];
                derivatives(0, at, slope[stage]);
            }
            for (int i = 0; i < dimension; ++i) x[i] += h / 6 * (slope[0][i] + 2 * slope[1][i] + 2 * slope[2][i] + slope[3][i]);
        }
        memory_.now_s = t_s;
    }

    int drive_ = 0, start_angle_ = 0, start_rate_ = 0, frequency_ = 0, damping_ = 0, period_ = 0, noise_ = 0, seed_ = 0;
    int true_angle_ = 0, true_rate_ = 0; // all rows
    Outputs<Truth, truth_group> truth_;
    Outputs<Sample, sample_group> sample_;
    Memory memory_{};
};

} // namespace

constexpr ModelInfo model_info = {"Pendulum", "A damped pendulum and a sensor of its angle: a plant for observers",
                                  Experiment{0.02, 20}, States{dimension, dimension}};
Model* make_model() { return new Pendulum; }

} // namespace hnav::fmu
