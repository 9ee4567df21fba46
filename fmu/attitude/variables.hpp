// The variables of an FMU of an attitude filter. Parameters are the options of the C API, by the same names; here stand
// inputs and outputs. What differs between filters comes from Kind:
//     using Options                                         the options struct of the C API
//     static Options defaults(hnav_preset); static const hnav_option_info* option(int);
//     static hnav_status create(hnav_filter**, const Options*, char*, size_t)
//     static constexpr ModelInfo info
//     static constexpr const char* presets[]                names of the presets, in the order of the C enum
//     static constexpr int accel_dimension, accel_unit      of the innovation of force
//     static constexpr bool has_field                       outputs of the magnetic reference and the gyro calibration
//     static constexpr bool reholds                         Model Exchange can take the backward gyro hold
//     static void describe_states(StateRows&)
//     static void keep_on_realign(const double* x, double* replaced)    states that a realignment leaves as they are
#pragma once

#include "adapter/option_row.hpp"
#include "adapter/sampling.hpp"

#include <cmath>
#include <cstring>

namespace hnav::fmu {

// Parts of the filter that outputs are read from, so that a step costs only what is asked for.
enum Group : unsigned {
    attitude_group = 1,
    bias_group = 2,
    posterior_group = 4,
    innovation_group = 8,
    covariance_group = 16,
    status_group = 32,
    field_group = 64
};

constexpr int covariance_terms = 21; // upper triangle of 6 x 6

// Where the variables stand in the table.
struct Places {
    int preset, sampling_mode;
    struct Sensor {
        int value, sample, t_meas, valid, period;
    } sensor[HNAV_SENSOR_COUNT]; // value: three components; of the heading aid: heading, sigma
    int reset, realign;
    int options; // the first row of the option table

    int post_t, post_q, post_bias, post_sigma;
    int att_q, att_euler, att_heading, att_sigma, near_singular, tilt_ready, heading_ready, started;
    int rate, bias, bias_sigma;
    struct Innovation {
        int value, sigma, nis, gate_ok, used, gated;
        int dimension;
    } innovation[HNAV_SENSOR_COUNT]; // of the gyro: used only
    int gamma, margin, decay_rate, bias_walk, raised, repaired, late, non_finite, zero, missed, corrections, rhs_evals;
    int covariance;
    int field, latency, latency_sigma, evidence, heading_trust, adopted, field_gate, at_rest, gyro_calibration; // has_field
};

template <class Kind>
void describe_options(Table& table, Places& at) {
    const typename Kind::Options defaults = Kind::defaults(HNAV_PRESET_DEFAULT);
    at.options = table.size();
    for (int k = 0; const hnav_option_info* option = Kind::option(k); ++k)
        for (int i = 0; i < option->count; ++i) table.add(option_row(*option, &defaults, i));
}

inline void describe_inputs(Table& table, Places& at) {
    using namespace rows;
    struct Sensor {
        const char *prefix, *value, *unit, *display, *text;
        double start[3];
    };
    constexpr Sensor sensors[] = {
        {"gyro", "rate", "rad/s", "deg/s", "Angular rate in sensor axes", {0, 0, 0}},
        {"accel",
         "force",
         "m/s2",
         "",
         "Specific force in sensor axes; at rest with z down it is (0, 0, -9.81)",
         {0, 0, -9.80665}},
        {"mag", "field", "T", "uT", "Magnetic field in sensor axes", {2e-5, 0, 4.5e-5}},
        {"aid", "heading", "rad", "deg", "True heading of body x, clockwise from north", {0, 0, 0}},
    };
    char name[64];
    const auto named = [&name](const char* prefix, const char* suffix) {
        std::snprintf(name, sizeof name, "%.20s.%.30s", prefix, suffix);
        return name;
    };
    for (int s = 0; s < HNAV_SENSOR_COUNT; ++s) {
        const Sensor& sensor = sensors[s];
        const bool aid = s == HNAV_SENSOR_HEADING;
        Places::Sensor& place = at.sensor[s];
        if (aid) {
            place.value = table.add(input(named(sensor.prefix, sensor.value), sensor.unit, sensor.display, 0, sensor.text));
            table.add(input(named(sensor.prefix, "heading_sigma"), "rad", "deg", 0.05, "Standard deviation of the heading"));
        } else {
            const Variable v = input(named(sensor.prefix, sensor.value), sensor.unit, sensor.display, 0, sensor.text);
            place.value = table.add_vector(v, 3);
            for (int i = 0; i < 3; ++i) table.row(place.value + i).start = sensor.start[i];
        }
        place.sample = table.add(input(named(sensor.prefix, "sample"), Type::integer, 0,
                                       "Sample counter: a change marks a new sample (sampling_mode counter)"));
        place.t_meas = table.add(
            input(named(sensor.prefix, "t_meas"), "s", "ms", 0, "Time at which the sample was measured (sampling_mode counter)"));
        place.valid = table.add(input(named(sensor.prefix, "valid"), Type::boolean, !aid, "False: the sample is not used"));
    }
    at.reset = table.add(input("reset", Type::boolean, 0, "Rising edge: back to the state after initialization"));
    at.realign =
        table.add(input("realign", Type::boolean, 0, "Rising edge: forget the attitude and start anew, keep the gyro bias"));
}

template <class Kind>
void describe_sampling(Table& table, Places& at) {
    using namespace rows;
    constexpr int preset_count = sizeof Kind::presets / sizeof *Kind::presets;
    at.preset = table.add(choice("preset", Kind::presets, preset_count, 0,
                                 "Set of defaults; parameters that differ from their start values override it"));
    at.sampling_mode = table.add(choice("sampling_mode", sampling_modes, 2, periodic,
                                        "periodic: inputs are sampled every period; counter: when a sample counter changes"));
    constexpr const char* names[] = {"gyro.period", "accel.period", "mag.period", "aid.period"};
    for (int s = 0; s < HNAV_SENSOR_COUNT; ++s) {
        Variable v = parameter(names[s], "s", 0.01, 0, 1e6, "Sampling period (sampling_mode periodic); 0: never");
        v.display_unit = "ms";
        at.sensor[s].period = table.add(v);
    }
}

template <class Kind>
void describe_outputs(Table& table, Places& at) {
    using namespace rows;
    constexpr auto held = Variability::discrete, flowing = Variability::continuous;
    constexpr auto none = DependsOn::nothing, on_q_b = DependsOn::first_states, on_all = DependsOn::all_states;

    at.post_t = table.add(output("post.t", "s", "ms", posterior_group, held, none, "Time of the newest sample used"));
    at.post_q = table.add_vector(output("post.q", "", "", posterior_group, held, none,
                                        "Attitude just after that sample, body to navigation, scalar first"),
                                 4);
    at.post_bias = table.add_vector(
        output("post.bias", "rad/s", "deg/s", posterior_group, held, none, "Gyro bias just after that sample"), 3);
    at.post_sigma =
        table.add_vector(output("post.sigma", "", "", posterior_group, held, none,
                                "Standard deviations just after that sample: rotation about the navigation axes, gyro bias"),
                         6);

    for (int i = 0; i < 6; ++i) table.row(at.post_sigma + i).unit = i < 3 ? "rad" : "rad/s";

    at.att_q = table.add_vector(
        output("att.q", "", "", attitude_group, flowing, on_q_b, "Attitude now, body to navigation, scalar first"), 4);
    at.att_euler = table.add_vector(
        output("att.euler", "rad", "deg", attitude_group, flowing, on_q_b, "Roll, pitch, yaw now (rotation order z y x)"), 3);
    at.att_heading = table.add(
        output("att.heading", "rad", "deg", attitude_group, flowing, on_q_b, "True heading of body x now, clockwise from north"));
    at.att_sigma =
        table.add_vector(output("att.sigma", "rad", "deg", attitude_group, flowing, on_all,
                                "Standard deviation of the rotation error about the navigation axes; pi before the start"),
                         3);
    at.near_singular = table.add(output("att.near_singular", Type::boolean, posterior_group,
                                        "Pitch was beyond 85 deg at the newest sample: roll and yaw are ill defined"));
    at.rate = table.add_vector(
        output("rate.body", "rad/s", "deg/s", bias_group, flowing, on_q_b, "Angular rate of the body, bias removed"), 3);
    at.bias = table.add_vector(output("bias.gyro", "rad/s", "deg/s", bias_group, flowing, on_q_b, "Gyro bias"), 3);
    at.bias_sigma = table.add_vector(
        output("bias.gyro_sigma", "rad/s", "deg/s", bias_group, flowing, on_all, "Standard deviation of the gyro bias"), 3);

    at.started = table.add(output("align.started", Type::boolean, status_group, "There is an attitude"));
    at.tilt_ready = table.add(output("align.tilt_ready", Type::boolean, posterior_group,
                                     "Tilt at the newest sample: sigma below the limit, by information gained"));
    at.heading_ready = table.add(output("align.heading_ready", Type::boolean, posterior_group,
                                        "Heading at the newest sample: sigma below the limit, by information gained"));

    constexpr const char* sensors[] = {"gyro", "accel", "mag", "heading"};
    char name[64];
    const auto named = [&name](const char* prefix, const char* suffix) {
        std::snprintf(name, sizeof name, "%.20s.%.30s", prefix, suffix);
        return name;
    };
    for (int s = 0; s < HNAV_SENSOR_COUNT; ++s) {
        Places::Innovation& place = at.innovation[s];
        char counted[64];
        std::snprintf(counted, sizeof counted, "count.%s_used", sensors[s]);
        place.used = table.add(output(counted, Type::integer, status_group, "Samples used"));
        if (s == HNAV_SENSOR_GYRO) continue;
        place.dimension = s == HNAV_SENSOR_HEADING ? 1 : s == HNAV_SENSOR_ACCEL ? Kind::accel_dimension : 3;
        const char* unit = s == HNAV_SENSOR_HEADING ? "rad" : s == HNAV_SENSOR_ACCEL ? Kind::accel_unit : "";
        const Variable value =
            output(named("innov", sensors[s]), unit, s == HNAV_SENSOR_HEADING ? "deg" : "", innovation_group, held, none,
                   "Innovation of the last correction: measured minus expected (directions and fields without unit)");
        place.value = place.dimension == 1 ? table.add(value) : table.add_vector(value, place.dimension);
        std::snprintf(counted, sizeof counted, "%s_sigma", sensors[s]);
        const Variable sigma =
            output(named("innov", counted), unit, value.display_unit, innovation_group, held, none,
                   "Standard deviation that the filter expects of the innovation, sqrt(S_ii), noise as parametrised");
        place.sigma = place.dimension == 1 ? table.add(sigma) : table.add_vector(sigma, place.dimension);
        place.nis = table.add(output(named("nis", sensors[s]), "", "", innovation_group, held, none,
                                     "Normalised innovation squared of the last sample; its expectation is the dimension"));
        std::snprintf(counted, sizeof counted, "gate.%s_ok", sensors[s]);
        place.gate_ok = table.add(output(counted, Type::boolean, innovation_group, "The last sample was within its gate"));
        std::snprintf(counted, sizeof counted, "count.%s_gated", sensors[s]);
        place.gated = table.add(output(counted, Type::integer, status_group, "Samples whose noise the gate inflated"));
    }

    at.gamma = table.add(
        output("hinf.gamma_used", "", "", status_group, held, none, "gamma of the last correction; 0 stands for infinity (off)"));
    at.margin = table.add(
        output("hinf.margin", "", "", status_group, held, none, "Feasibility 1 - lmax(L P L')/gamma^2 of the last correction"));
    at.decay_rate = table.add(output(
        "hinf.decay_rate", "1/s", "", status_group, held, none,
        "Rate at which the last correction makes the filter forget, in the metric of its own covariance; 0 while there is none"));
    at.bias_walk = table.add(
        output("adapt.bias_walk", "rad/s/sqrt(s)", "", status_group, held, none, "Random walk of the gyro bias in use"));
    at.corrections = table.add(output("count.corrections", Type::integer, status_group, "Corrections"));
    at.raised = table.add(output("count.gamma_raised", Type::integer, status_group, "Corrections whose gamma had to be raised"));
    at.repaired =
        table.add(output("count.covariance_repaired", Type::integer, status_group, "Covariances that had to be repaired"));
    at.missed = table.add(output("count.missed", Type::integer, status_group, "Samples that a coarse communication step lost"));
    at.late = table.add(output("count.late", Type::integer, status_group, "Samples refused as too old"));
    at.non_finite = table.add(output("count.non_finite", Type::integer, status_group, "Samples refused as not finite"));
    at.zero = table.add(output("count.zero", Type::integer, status_group, "Samples refused as zero vectors"));
    at.rhs_evals =
        table.add(output("solver.rhs_evals", Type::integer, status_group, "Evaluations of the flow by the integrator inside"));

    at.covariance = table.size();
    for (int i = 1; i <= 6; ++i)
        for (int j = i; j <= 6; ++j) {
            char element[32];
            std::snprintf(element, sizeof element, "cov.P[%d,%d]", i, j);
            const char* unit = j <= 3 ? "rad2" : i <= 3 ? "rad2/s" : "rad2/s2";
            table.add(output(element, unit, "", covariance_group, flowing, on_all,
                             "Covariance of (rotation about the navigation axes, gyro bias)"));
        }

    // What outputs show before initialization: no attitude, and any error.
    table.row(at.att_q).start = table.row(at.post_q).start = 1;
    for (int i = 0; i < 3; ++i) table.row(at.att_sigma + i).start = table.row(at.post_sigma + i).start = M_PI;
}

// The continuous states, once as values and once as derivatives.
class StateRows {
public:
    StateRows(Table& table, bool derivatives, int first_state)
        : table_(table), derivatives_(derivatives), first_state_(first_state) {}

    // depends_on: of the derivative.
    void add(const char* name, const char* unit, double start, DependsOn depends_on, const char* text) {
        Variable v = variable(name, Type::real, Causality::local, Variability::continuous, text);
        if (derivatives_) std::snprintf(v.name, sizeof v.name, "der(%.50s)", name);
        v.unit = derivatives_ ? "" : unit;
        v.group = state_group;
        v.depends_on = derivatives_ ? depends_on : DependsOn::nothing;
        v.is_state = !derivatives_;
        v.start = derivatives_ ? 0 : start;
        v.derivative_of = derivatives_ ? first_state_ + count_ : -1;
        table_.add(v);
        ++count_;
    }

private:
    Table& table_;
    bool derivatives_;
    int first_state_;
    int count_ = 0;
};

inline void describe_field(Table& table, Places& at) {
    using namespace rows;
    constexpr auto held = Variability::discrete;
    constexpr auto none = DependsOn::nothing;
    at.field = table.add(
        output("field.strength", "T", "uT", field_group, held, none, "Strength of the reference field; 0 while there is none"));
    table.add(output("field.dip", "rad", "deg", field_group, held, none, "Dip of the reference field below the horizon"));
    at.latency = table.add(output("field.latency", "s", "ms", field_group, held, none,
                                  "Estimated delay of the magnetometer behind its time stamps"));
    at.latency_sigma =
        table.add(output("field.latency_sigma", "s", "ms", field_group, held, none, "Standard deviation of that delay"));
    at.evidence = table.add(output("field.evidence", "s", "", field_group, held, none,
                                   "Time for which the reference was seen, counted less at rest"));
    at.heading_trust = table.add(output("field.heading_trust", "s", "", field_group, held, none,
                                        "The same for the heading, through changes of reference"));
    at.adopted = table.add(output("field.adopted", Type::integer, field_group, "References taken after the first"));
    at.field_gate = table.add(
        output("field.gate", Type::integer, field_group, "Last field: 0 accepted, 1 refused, 2 used with inflated noise"));
    at.at_rest = table.add(output("rest.detected", Type::boolean, field_group, "The body lies still"));
    at.gyro_calibration = table.size();
    for (int i = 1; i <= 3; ++i)
        for (int j = 1; j <= 3; ++j) {
            char element[32];
            std::snprintf(element, sizeof element, "gyro_calibration.S[%d,%d]", i, j);
            table.add(output(element, "", "", field_group, held, none,
                             "Scale and misalignment of the gyroscope: rate = (I - S) reading - bias"));
        }
}

template <class Kind>
void describe_all(Table& table, Places& at) {
    Variable time = variable("time", Type::real, Causality::independent, Variability::continuous, "Simulation time");
    time.unit = "s";
    table.add(time);
    describe_inputs(table, at);
    describe_sampling<Kind>(table, at);
    describe_options<Kind>(table, at);
    describe_outputs<Kind>(table, at);
    if (Kind::has_field) describe_field(table, at);
    const int first = table.size();
    StateRows states(table, false, first), derivatives(table, true, first);
    Kind::describe_states(states);
    Kind::describe_states(derivatives);
}

} // namespace hnav::fmu
