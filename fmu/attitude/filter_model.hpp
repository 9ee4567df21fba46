// An attitude filter of the C API behind the adapter's Model. Kind is described in variables.hpp.
#pragma once

#include "adapter/model.hpp"
#include "attitude/variables.hpp"

#include <cmath>
#include <cstring>
#include <new>

namespace hnav::fmu {

template <class Kind>
class FilterModel final : public Model {
public:
    static Model* make() {
        void* memory = std::malloc(sizeof(FilterModel));
        return memory ? new (memory) FilterModel : nullptr;
    }

    const ModelInfo& info() const override { return Kind::info; }

    void describe(Table& table) override { describe_all<Kind>(table, at_); }

    bool initialise(double* values, const double* written, double start_s, bool model_exchange, Message* why) override {
        typename Kind::Options options = Kind::defaults(static_cast<hnav_preset>(static_cast<int>(values[at_.preset])));
        // What the importer has set goes before the preset; the rest shows what the preset means.
        int row = at_.options;
        for (int k = 0; const hnav_option_info* option = Kind::option(k); ++k)
            for (int i = 0; i < option->count; ++i, ++row) {
                if (written[row] != 0) set_option(*option, &options, i, values[row]);
                values[row] = option_value(*option, &options, i);
            }
        if (!Kind::reholds && model_exchange && options.gyro_hold == HNAV_GYRO_HOLD_BACKWARD) {
            std::snprintf(why->text, sizeof why->text,
                          "gyro_hold = backward needs Co-Simulation: an integrator outside cannot know a rate before its sample");
            return false;
        }
        clear();
        if (Kind::create(&filter_, &options, why->text, sizeof why->text) != HNAV_OK) return false;
        sampler_ = {};
        sampler_.start_s = start_s;
        sampler_.model_exchange = model_exchange;
        sampler_.reset_level = values[at_.reset];
        sampler_.realign_level = values[at_.realign];
        return true;
    }

    // ------------------------------------------------------------------------------------------------ samples

    bool take_samples(double* values, double t_s) override {
        bool taken = false;
        if (rising(values[at_.reset], &sampler_.reset_level)) {
            hnav_filter_reset(filter_);
            sampler_.command = command_reset;
            taken = true;
        }
        if (rising(values[at_.realign], &sampler_.realign_level)) {
            hnav_filter_realign(filter_);
            if (sampler_.command != command_reset) sampler_.command = command_realign;
            taken = true;
        }
        for (int s = 0; s < HNAV_SENSOR_COUNT; ++s) {
            const Places::Sensor& sensor = at_.sensor[s];
            double stamp_s = t_s;
            const bool due =
                values[at_.sampling_mode] == counter ? counter_changed(s, values, &stamp_s) : period_elapsed(s, values, t_s);
            if (!due || values[sensor.valid] == 0) continue;
            push(s, stamp_s, values + sensor.value);
            taken = true;
        }
        return taken;
    }

    double next_sample_s(const double* values) const override {
        double next = std::numeric_limits<double>::infinity();
        // In Model Exchange a sample stamped later than it came waits for its time.
        if (sampler_.model_exchange != 0) hnav_filter_next_event_s(filter_, &next);
        if (values[at_.sampling_mode] == counter) return next;
        for (int s = 0; s < HNAV_SENSOR_COUNT; ++s) {
            const double period = values[at_.sensor[s].period];
            if (period > 0) next = std::fmin(next, sampler_.start_s + sampler_.due[s] * period);
        }
        return next;
    }

    bool advance(double t_s, Message* why) override { return done(hnav_filter_advance(filter_, t_s), why); }

    // ------------------------------------------------------------------------------------------------ outputs

    void refresh(double* values, unsigned groups) override {
        if (groups & attitude_group) refresh_attitude(values);
        if (groups & bias_group) refresh_bias(values);
        if (groups & posterior_group) refresh_posterior(values);
        if (groups & innovation_group) refresh_innovations(values);
        if (groups & covariance_group) refresh_covariance(values);
        if (groups & status_group) refresh_status(values);
        if (groups & field_group) refresh_field(values);
    }

    // ------------------------------------------------------------------------------------------------ Model Exchange

    void get_states(double* x) const override { hnav_filter_get_x(filter_, x); }
    void get_nominals(double* nominals) const override { hnav_filter_nominal_x(filter_, nominals); }
    bool derivatives(double t_s, const double* x, double* dx) const override {
        return hnav_filter_derivative(filter_, t_s, x, dx) == HNAV_OK;
    }
    bool derivatives_along(double t_s, const double* x, const double* seed, double* out) const override {
        return hnav_filter_derivative_along(filter_, t_s, x, seed, out) == HNAV_OK;
    }
    bool jump(double t_s, double* x, bool* changed, Message* why) override {
        if (sampler_.command != 0) {
            double replaced[Kind::info.nx];
            hnav_filter_get_x(filter_, replaced);
            if (sampler_.command == command_realign) Kind::keep_on_realign(x, replaced);
            std::memcpy(x, replaced, sizeof replaced);
            sampler_.command = 0;
            *changed = true;
        }
        double next_s;
        hnav_filter_next_event_s(filter_, &next_s);
        if (next_s > t_s) return true;
        *changed = true;
        return done(hnav_filter_jump(filter_, t_s, x, x), why);
    }
    void show(double t_s, const double* x) override { hnav_filter_show(filter_, t_s, x); }

    // ------------------------------------------------------------------------------------------------ complete state

    std::size_t state_size() const override {
        std::size_t bytes = 0;
        hnav_filter_state_size(filter_, &bytes);
        return sizeof sampler_ + bytes;
    }
    void save(void* buffer) const override {
        std::memcpy(buffer, &sampler_, sizeof sampler_);
        hnav_filter_save(filter_, static_cast<char*>(buffer) + sizeof sampler_, state_size() - sizeof sampler_);
    }
    bool load(const void* buffer, std::size_t bytes) override {
        if (bytes != state_size()) return false;
        std::memcpy(&sampler_, buffer, sizeof sampler_);
        return hnav_filter_load(filter_, static_cast<const char*>(buffer) + sizeof sampler_, bytes - sizeof sampler_) == HNAV_OK;
    }

    void clear() override {
        hnav_filter_destroy(filter_);
        filter_ = nullptr;
    }
    void destroy() override {
        clear();
        this->~FilterModel();
        std::free(this);
    }

private:
    FilterModel() = default;
    ~FilterModel() = default;

    // What was seen of the inputs so far. Eight-byte numbers, saved as they are.
    struct Sampler {
        double start_s;
        double seen[HNAV_SENSOR_COUNT]; // counters
        double due[HNAV_SENSOR_COUNT];  // periods from the start until the next sample
        double reset_level, realign_level;
        double missed;
        double command; // that Model Exchange has still to apply to the importer's states
        double model_exchange;
    };
    enum Command { command_reset = 1, command_realign = 2 };

    // A counter that went up by more than one says that samples came and went between two communication points.
    bool counter_changed(int s, const double* values, double* stamp_s) {
        const double now = values[at_.sensor[s].sample];
        if (now == sampler_.seen[s]) return false;
        if (now > sampler_.seen[s] + 1) sampler_.missed += now - sampler_.seen[s] - 1;
        sampler_.seen[s] = now;
        *stamp_s = values[at_.sensor[s].t_meas];
        return true;
    }

    // The first communication point at or after k periods takes sample k; points that come too late lose samples.
    bool period_elapsed(int s, const double* values, double t_s) {
        const double period = values[at_.sensor[s].period];
        if (!(period > 0)) return false;
        const double tolerance = 1e-9 * std::fmax(1, std::fabs(t_s));
        const double k = std::floor((t_s - sampler_.start_s + tolerance) / period);
        if (k < sampler_.due[s]) return false;
        if (values[at_.sensor[s].valid] != 0) sampler_.missed += k - sampler_.due[s];
        sampler_.due[s] = k + 1;
        return true;
    }

    // What is no sample is refused and counted by the filter; that is no reason to stop a simulation.
    void push(int s, double t_s, const double* value) {
        hnav_status status = HNAV_OK;
        switch (s) {
        case HNAV_SENSOR_GYRO: status = hnav_filter_push_gyro(filter_, t_s, value); break;
        case HNAV_SENSOR_ACCEL: status = hnav_filter_push_accel(filter_, t_s, value); break;
        case HNAV_SENSOR_MAG: status = hnav_filter_push_mag(filter_, t_s, value); break;
        default: status = hnav_filter_push_heading(filter_, t_s, value[0], value[1]); break;
        }
        if (status == HNAV_ERROR_QUEUE_FULL) sampler_.missed += 1;
    }

    bool done(hnav_status status, Message* why) const {
        if (status == HNAV_OK) return true;
        std::snprintf(why->text, sizeof why->text, "%s", hnav_filter_message(filter_));
        return false;
    }

    static void put(double* values, int first, const double* from, int n) {
        std::memcpy(values + first, from, n * sizeof(double));
    }

    void refresh_attitude(double* values) const {
        hnav_attitude a{0, {1, 0, 0, 0}, {0, 0, 0}, 0, {M_PI, M_PI, M_PI}, 0, 0, 0};
        hnav_filter_attitude(filter_, &a); // leaves these values before the start
        put(values, at_.att_q, a.q_nb, 4);
        put(values, at_.att_euler, a.euler_rad, 3);
        put(values, at_.att_sigma, a.sigma_rad, 3);
        values[at_.att_heading] = a.heading_rad;
    }

    void refresh_bias(double* values) const {
        double rate[3], bias[3], sigma[3];
        hnav_filter_rate(filter_, rate);
        hnav_filter_gyro_bias(filter_, bias, sigma);
        put(values, at_.rate, rate, 3);
        put(values, at_.bias, bias, 3);
        put(values, at_.bias_sigma, sigma, 3);
    }

    void refresh_posterior(double* values) const {
        hnav_posterior p{sampler_.start_s, {1, 0, 0, 0}, {0, 0, 0}, {M_PI, M_PI, M_PI, 0, 0, 0}, 0, 0, 0, 0};
        if (hnav_filter_posterior(filter_, &p) != HNAV_OK) hnav_filter_gyro_bias(filter_, p.gyro_bias_rad_s, p.sigma + 3);
        values[at_.post_t] = p.t_s;
        put(values, at_.post_q, p.q_nb, 4);
        put(values, at_.post_bias, p.gyro_bias_rad_s, 3);
        put(values, at_.post_sigma, p.sigma, 6);
        values[at_.near_singular] = p.near_singular;
        values[at_.tilt_ready] = p.tilt_ready;
        values[at_.heading_ready] = p.heading_ready;
    }

    void refresh_innovations(double* values) const {
        for (int s = HNAV_SENSOR_ACCEL; s < HNAV_SENSOR_COUNT; ++s) {
            const Places::Innovation& place = at_.innovation[s];
            hnav_innovation i{};
            i.accepted = 1;
            hnav_filter_innovation(filter_, static_cast<hnav_sensor>(s), &i); // stays zero before the first
            put(values, place.value, i.value, place.dimension);
            for (int row = 0; row < place.dimension; ++row) values[place.sigma + row] = std::sqrt(i.S[3 * row + row]);
            values[place.nis] = i.nis;
            values[place.gate_ok] = i.accepted;
        }
    }

    void refresh_covariance(double* values) const {
        double P[36] = {};
        if (hnav_filter_covariance(filter_, P) != HNAV_OK) { // no attitude: anything within half a turn
            double bias[3], sigma[3];
            hnav_filter_gyro_bias(filter_, bias, sigma);
            for (int i = 0; i < 3; ++i) {
                P[7 * i] = M_PI * M_PI;
                P[7 * (i + 3)] = sigma[i] * sigma[i];
            }
        }
        double* out = values + at_.covariance;
        for (int i = 0; i < 6; ++i)
            for (int j = i; j < 6; ++j) *out++ = P[6 * i + j];
    }

    void refresh_status(double* values) const {
        hnav_filter_status s{};
        hnav_filter_get_status(filter_, &s);
        values[at_.started] = s.started;
        values[at_.gamma] = std::isfinite(s.gamma_used) ? s.gamma_used : 0;
        values[at_.margin] = s.gamma_margin;
        values[at_.decay_rate] = s.decay_rate_1_s;
        values[at_.bias_walk] = s.adapted_bias_walk_rad_s_per_sqrt_s;
        for (int i = 0; i < HNAV_SENSOR_COUNT; ++i) {
            values[at_.innovation[i].used] = s.used[i];
            if (i != HNAV_SENSOR_GYRO) values[at_.innovation[i].gated] = s.gated[i];
        }
        values[at_.corrections] = s.corrections;
        values[at_.raised] = s.gamma_raised;
        values[at_.repaired] = s.covariance_repaired;
        values[at_.missed] = sampler_.missed;
        values[at_.late] = s.late;
        values[at_.non_finite] = s.non_finite;
        values[at_.zero] = s.zero;
        values[at_.rhs_evals] = s.solver_rhs_evals;
    }

    void refresh_field(double* values) const {
        hnav_field f{};
        hnav_filter_field(filter_, &f);
        const bool known = !std::isnan(f.strength_tesla);
        values[at_.field] = known ? f.strength_tesla : 0;
        values[at_.field + 1] = known ? f.dip_rad : 0;
        values[at_.latency] = f.latency_s;
        values[at_.latency_sigma] = f.latency_sigma_s;
        values[at_.evidence] = f.evidence_s;
        values[at_.heading_trust] = f.heading_trust_s;
        values[at_.adopted] = f.adopted;
        values[at_.field_gate] = f.gate;
        values[at_.at_rest] = f.at_rest;
        double S[9], sigma[9];
        hnav_filter_gyro_calibration(filter_, S, sigma);
        put(values, at_.gyro_calibration, S, 9);
    }

    Places at_{};
    Sampler sampler_{};
    hnav_filter* filter_ = nullptr;
};

} // namespace hnav::fmu
