// The Observer FMU: estimates the states of the plant in its resources. One binary serves all plants.
#include "adapter/estimate_model.hpp"
#include "adapter/filter_calls.hpp"
#include "observer/variables.hpp"

#include <algorithm>

namespace hnav::fmu {
namespace {

using namespace observer;

// A plant with events may be unable to serialise its memory: then states are snapshots, valid for this observer only.
bool keeps_states(const hnav_filter* o) {
    double nothing;
    return hnav_filter_save(o, &nothing, 0) == HNAV_ERROR_UNSUPPORTED;
}
hnav_status size_of_state(const hnav_filter* o, std::size_t* bytes) {
    return keeps_states(o) ? hnav_filter_snapshot_size(o, bytes) : hnav_filter_state_size(o, bytes);
}
hnav_status save_state(const hnav_filter* o, void* buffer, std::size_t bytes) {
    return keeps_states(o) ? hnav_filter_take_snapshot(o, buffer, bytes) : hnav_filter_save(o, buffer, bytes);
}
hnav_status load_state(hnav_filter* o, const void* buffer, std::size_t bytes) {
    return keeps_states(o) ? hnav_filter_restore_snapshot(o, buffer, bytes) : hnav_filter_load(o, buffer, bytes);
}

using ObserverCalls = FilterCalls<size_of_state, save_state, load_state>;

constexpr int max_channels = 62; // known inputs and sensors together

// Sampled channels: the known inputs, then the sensors.
struct ObserverMemory : EstimateMemory<max_channels> {
    double start_s;
    double now_s, behind; // of the last step; 1: outputs of the look-ahead must still be computed
    double keeps_states;  // 1: its saved states are snapshots
};

class Observer final : public EstimateModel<ObserverCalls, ObserverMemory> {
public:
    bool open(const char* resources, Message* why) override {
        char path[sizeof folder_ + 16];
        const std::size_t length = std::strlen(resources);
        const char* slash = length > 0 && std::strchr("/\\", resources[length - 1]) ? "" : "/";
        if (length == 0 || std::snprintf(folder_, sizeof folder_, "%s%splant", resources, slash) >= int(sizeof folder_)) {
            std::snprintf(why->text, sizeof why->text,
                          "the importer gives no folder of resources, or one of more than 1000 characters");
            return false;
        }
        std::snprintf(path, sizeof path, "%s%svariables.txt", resources, slash);
        return at_.read(path, why);
    }
    int state_count() const override { return at_.sizes.nx; }
    void describe(Table& table) override { at_.describe(table); }

    bool initialise(const double* values, double start_s, bool model_exchange, Message* why) override {
        if (model_exchange && at_.sizes.nx == 0) {
            std::snprintf(why->text, sizeof why->text,
                          "the plant offers Co-Simulation only, and so does its observer: import it for Co-Simulation");
            return false;
        }
        if (!check_periods(values, why) || !make_observer(values, start_s, why)) return false;
        if (!fits_the_plan()) {
            std::snprintf(why->text, sizeof why->text,
                          "variables.txt and observer.plan do not belong together: export the FMU again");
            return false;
        }
        memory_.start_s = start_s;
        memory_.model_exchange = model_exchange;
        memory_.keeps_states = keeps_states(object_);
        for (int c = 0; c < channels(); ++c)
            memory_.sampled.clock[c] = {start_s, period_s(values, c), values[at_.row(sampling_mode)], 0, 0};
        trouble_[0] = '\0';
        return true;
    }

    void begin(const double* values) override { memory_.reset_level = values[at_.row(reset_command)]; }

    // ------------------------------------------------------------------------------------------------ samples

    // Inputs before sensors: a sensor with feed-through at the same instant uses the new input.
    bool take_samples(double* values, double t_s) override {
        bool mistaken = false;
        for (int c = 0; c < channels(); ++c)
            mistaken |= memory_.sampled.begins_to_count(c, at(values, c, input_sample, sensor_sample));
        bool taken = (mistaken && restart()) | take_reset(values[at_.row(reset_command)]);
        for (int c = 0; c < channels(); ++c) {
            const bool valid = is_input(c) || values[at_.row(sensor_valid, sensor(c))] != 0;
            NewSample sample;
            if (!memory_.sampled.take(c, t_s, valid, at(values, c, input_sample, sensor_sample),
                                      at(values, c, input_t_meas, sensor_t_meas), &sample))
                continue;
            const double value = at(values, c, input_value, sensor_value);
            if (!is_input(c) && !memory_.sampled.is_new(c, &value, 1)) continue;
            pushed(push(c, sample.t_s, is_input(c) ? value : value + at_.value(values, sensor_offset, sensor(c), 0)));
            taken = true;
        }
        return taken;
    }

    Lost lost() const override {
        return memory_.sampled.lost([this](int c, bool counted) { return name_of(c, counted); });
    }
    Lost repeated() const override {
        return memory_.sampled.repeated([this](int c, bool counted) { return name_of(c, counted); });
    }
    const char* mistaken() const override {
        return memory_.sampled.mistaken([this](int c, bool counted) { return name_of(c, counted); });
    }

    // Logs the plant's message once when samples are dropped or the estimate is held.
    bool judge(Message* what) override {
        std::snprintf(what->text, sizeof what->text, "%s", trouble_);
        return trouble_[0] != '\0';
    }

    // The estimate alone: the look-ahead doubles the number of plant calls, and it is not read at every step by all
    // importers.
    bool advance(double t_s, Message* why) override {
        memory_.now_s = t_s;
        memory_.behind = 1;
        return goes_on(hnav_filter_commit(object_, t_s), why);
    }

    bool look_ahead(unsigned groups, Message* why) override {
        constexpr unsigned ahead = 1u << estimate_group | 1u << covariance_group | 1u << indicator_group;
        if (memory_.behind == 0 || !(groups & ahead)) return true;
        memory_.behind = 0;
        return goes_on(hnav_filter_advance(object_, memory_.now_s), why);
    }

    // ------------------------------------------------------------------------------------------------ outputs

    void refresh(double* values, unsigned groups) override {
        const auto wanted = [groups](Group group) { return (groups & (1u << group)) != 0; };
        double x[max_index], sigmas[max_index], post_x[max_index], post_sigmas[max_index];
        auto info = hnav_sized<hnav_observer_info>();
        hnav_observer_get_info(object_, &info);
        if (wanted(estimate_group)) hnav_observer_estimate(object_, x, sigmas);
        if (wanted(posterior_group)) hnav_observer_posterior(object_, post_x, post_sigmas);
        constexpr unsigned others = 1u << innovation_group | 1u << covariance_group | 1u << indicator_group | state_group;
        at_.each(groups & ~others, values, [&](Role role, int i, double* value) {
            switch (role) {
            case post_t: *value = std::isfinite(info.newest_s) ? info.newest_s : memory_.start_s; break;
            case post: *value = post_x[i]; break;
            case post_sigma: *value = post_sigmas[i]; break;
            case estimate: *value = x[i]; break;
            case sigma: *value = sigmas[i]; break;
            default: *value = count(role, info); break;
            }
        });
        if (wanted(innovation_group)) show_innovations(values);
        if (wanted(indicator_group)) {
            double z[max_indicators]{};
            hnav_observer_indicators(object_, nullptr, z);
            at_.each(1u << indicator_group, values, [&z](Role, int i, double* value) { *value = z[i]; });
        }
        if (wanted(covariance_group)) show_covariance(values);
    }

    // ------------------------------------------------------------------------------------------------ Model Exchange

    int indicator_count() const override { return at_.sizes.indicators; }
    bool indicators(double, const double* x, double* z) const override {
        return hnav_observer_indicators(object_, x, z) == HNAV_OK;
    }
    bool step_done(double, const double* x, bool* wants_event) override {
        std::int32_t wants = 0;
        const bool done = hnav_observer_step_done(object_, x, &wants) == HNAV_OK;
        *wants_event = wants != 0;
        return done;
    }

    bool can_serialise(const void* saved, std::size_t bytes, Message* why) const override {
        if (!is_snapshot(saved, bytes)) return true;
        std::snprintf(
            why->text, sizeof why->text,
            "the plant cannot write down what it remembers: export it with canSerializeFMUstate, and the observer again; "
            "GetFMUState and SetFMUState work as they are");
        return false;
    }
    // A snapshot of a destroyed observer no longer exists.
    void release(const void* saved, std::size_t bytes) override {
        if (object_ && is_snapshot(saved, bytes))
            hnav_filter_release_snapshot(object_, static_cast<const char*>(saved) + sizeof memory_, bytes - sizeof memory_);
    }

private:
    const char* name_of(int c, bool counted) const {
        const int row = is_input(c) ? at_.row(counted ? input_sample : input_period, c)
                                    : at_.row(counted ? sensor_sample : sensor_period, sensor(c));
        return row < 0 ? "a period" : at_.name(row);
    }

    static bool is_snapshot(const void* saved, std::size_t bytes) {
        ObserverMemory memory{};
        if (bytes > sizeof memory) std::memcpy(&memory, saved, sizeof memory);
        return memory.keeps_states != 0;
    }

    int channels() const { return at_.sizes.known_inputs + at_.sizes.sensors; }
    bool is_input(int channel) const { return channel < at_.sizes.known_inputs; }
    int sensor(int channel) const { return channel - at_.sizes.known_inputs; }
    double at(const double* values, int channel, Role of_input, Role of_sensor) const {
        return values[is_input(channel) ? at_.row(of_input, channel) : at_.row(of_sensor, sensor(channel))];
    }
    double period_s(const double* values, int channel) const {
        return is_input(channel) ? at_.value(values, input_period, channel, 0)
                                 : at_.value(values, sensor_period, sensor(channel), 0);
    }

    // A plant with events is queried whenever the importer asks for an event.
    bool event_due(double t_s) const override {
        auto info = hnav_sized<hnav_observer_info>();
        hnav_observer_get_info(object_, &info);
        return info.crosses != 0 || EstimateModel::event_due(t_s);
    }

    bool check_periods(const double* values, Message* why) const {
        int c = 0;
        while (c < channels() && check_period(name_of(c, false), period_s(values, c), why)) ++c;
        return c == channels();
    }

    // The created observer must have the sizes of the table.
    bool fits_the_plan() const {
        std::int32_t nx = 0;
        auto info = hnav_sized<hnav_observer_info>();
        auto seen = hnav_sized<hnav_observer_innovation_of>();
        const auto has_sensor = [&](int i) { return hnav_observer_innovation(object_, i, &seen) != HNAV_ERROR_OUT_OF_RANGE; };
        hnav_filter_nx(object_, &nx);
        hnav_observer_get_info(object_, &info);
        return (nx == at_.sizes.nx || at_.sizes.nx == 0) && info.n_estimated == at_.sizes.estimated() &&
               info.n_indicators == at_.sizes.indicators && has_sensor(at_.sizes.sensors - 1) && !has_sensor(at_.sizes.sensors);
    }

    bool make_observer(const double* values, double start_s, Message* why) {
        hnav_observer_options options = hnav_observer_defaults();
        for (int k = 0; const hnav_option_info* info = hnav_option("observer", k); ++k)
            if (at_.row(option, k) >= 0) hnav_set_option_value(info, &options, 0, values[at_.row(option, k)]);
        options.start_time_s = start_s;
        double starts[max_index]{}, start_sigmas[max_index]{}, noises[max_index]{}, sensor_sigmas[max_index]{},
            gates[max_index]{};
        const auto take = [&](Role role, int n, double* to) {
            for (int i = 0; i < n; ++i) to[i] = at_.value(values, role, i, 0);
            return at_.row(role, 0) >= 0 ? to : nullptr;
        };
        auto known = hnav_sized<hnav_observer_statistics>();
        const int N = at_.sizes.estimated();
        known.start = take(start, N, starts);
        known.start_sigma = take(start_sigma, N, start_sigmas);
        known.noise = take(noise, N, noises);
        known.sensor_sigma = take(sensor_sigma, at_.sizes.sensors, sensor_sigmas);
        known.gate_nis = take(gate_nis, at_.sizes.sensors, gates);
        return make(why, hnav_observer_open_known, &options, folder_, &known);
    }

    hnav_status push(int channel, double t_s, double value) {
        return is_input(channel) ? hnav_observer_push_input(object_, channel, t_s, value)
                                 : hnav_observer_push(object_, sensor(channel), t_s, value);
    }

    // Samples without a possible estimate are dropped and counted; while the plant fails, the estimate is held. The
    // simulation continues.
    bool goes_on(hnav_status status, Message* why) override {
        if (status != HNAV_ERROR_SOLVER && status != HNAV_OK) return done(status, why);
        auto info = hnav_sized<hnav_observer_info>();
        const bool any = status != HNAV_OK || (hnav_observer_get_info(object_, &info) == HNAV_OK && info.held > 0);
        if (any && !trouble_[0]) std::snprintf(trouble_, sizeof trouble_, "%s", hnav_filter_message(object_));
        return true;
    }

    static double count_of_events(Role role, const hnav_observer_info& info) {
        switch (role) {
        case parts: return info.parts;
        case largest_part: return info.largest_part;
        case plant_events: return static_cast<double>(info.plant_events);
        case splits: return static_cast<double>(info.splits);
        case grazing: return static_cast<double>(info.grazing);
        case chattering: return static_cast<double>(info.chattering);
        default: return static_cast<double>(info.projected);
        }
    }

    double count(Role role, const hnav_observer_info& info) const {
        switch (role) {
        case ready: return info.ready;
        case begun: return info.begun;
        case repeatable: return info.repeatable;
        case events: return static_cast<double>(info.events);
        case corrections: return static_cast<double>(info.corrections);
        case late: return static_cast<double>(info.late);
        case non_finite: return static_cast<double>(info.non_finite);
        case dropped: return static_cast<double>(info.dropped);
        case held_intervals: return static_cast<double>(info.held);
        case missed: return memory_.sampled.missed;
        default: return count_of_events(role, info);
        }
    }

    // 0 before the first sample of a sensor.
    void show_innovations(double* values) const {
        hnav_observer_innovation_of seen[max_channels];
        for (int i = 0; i < at_.sizes.sensors; ++i) {
            seen[i] = hnav_sized<hnav_observer_innovation_of>();
            hnav_observer_innovation(object_, i, seen + i);
        }
        at_.each(1u << innovation_group, values, [&](Role role, int i, double* value) {
            const hnav_observer_innovation_of& of = seen[i];
            *value = role == innovation         ? of.innovation
                     : role == innovation_sigma ? of.sigma
                     : role == nis              ? of.nis
                     : role == mean_nis         ? of.mean_nis
                     : role == sensor_used      ? static_cast<double>(of.samples)
                                                : static_cast<double>(of.inflated);
        });
    }

    // The index of an element numbers all of P, row by row.
    void show_covariance(double* values) const {
        double P[max_index * max_index];
        hnav_filter_covariance(object_, P);
        at_.each(1u << covariance_group, values, [&P](Role, int i, double* value) { *value = P[i]; });
    }

    Variables at_;
    char folder_[1024] = "";
    char trouble_[320] = "";
};

} // namespace

// The plant has no derivatives; its states are in its table.
constexpr ModelInfo model_info = {
    "Observer", "Estimates the states of the plant inside", Experiment{0.01, 10}, States{0, 0}, true, false};
Model* make_model() { return new Observer; }

} // namespace hnav::fmu
