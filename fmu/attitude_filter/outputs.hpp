// Outputs of an FMU of an attitude filter: each row and the answer of the filter that it shows.
#pragma once

#include "adapter/outputs.hpp"
#include "adapter/rows.hpp"
#include "hnav/hnav.h"

namespace hnav::fmu {

// Calls of the C API behind the outputs; a step makes only those that are needed.
enum Group {
    attitude_group,
    bias_group,
    posterior_group,
    innovation_group,
    covariance_group,
    diagnostics_group,
    health_group,
    field_group
};

class FilterOutputs {
public:
    static constexpr unsigned looking_ahead = 1u << attitude_group | 1u << bias_group | 1u << covariance_group;

    template <class Kind>
    void describe(Table& table) {
        describe_posterior(table);
        describe_attitude(table);
        describe_readiness(table);
        describe_used<HNAV_SENSOR_GYRO>(table, "gyro");
        describe_sensor<HNAV_SENSOR_ACCEL, Kind::accel_dimension>(table, "accel", Kind::accel_unit, "");
        describe_sensor<HNAV_SENSOR_MAG, 3>(table, "mag", "", "");
        describe_sensor<HNAV_SENSOR_HEADING, 1>(table, "heading", "rad", "deg");
        if constexpr (Kind::sensors > HNAV_SENSOR_SPEED) describe_sensor<HNAV_SENSOR_SPEED, 2>(table, "wheel", "m/s", "");
        describe_diagnostics(table);
        describe_health(table);
        describe_covariance(table);
        if (Kind::has_field) describe_field(table);
    }

    // missed: samples lost by the clocks of the FMU.
    void refresh(const hnav_filter* filter, unsigned groups, double start_s, double missed, double* values) const {
        attitude_.refresh(groups, values, [&](hnav_attitude* a) {
            *a = {sizeof(hnav_attitude), 0, {1, 0, 0, 0}, {0, 0, 0}, 0, {M_PI, M_PI, M_PI}, 0, 0, 0};
            hnav_filter_attitude(filter, a); // leaves these values before the start
        });
        bias_.refresh(groups, values, [&](Bias* b) {
            hnav_filter_rate(filter, b->rate);
            hnav_filter_gyro_bias(filter, b->bias, b->sigma);
        });
        posterior_.refresh(groups, values, [&](hnav_posterior* p) {
            *p = {sizeof(hnav_posterior), start_s, {1, 0, 0, 0}, {0, 0, 0}, {M_PI, M_PI, M_PI, 0, 0, 0}, 0, 0, 0, 0};
            if (hnav_filter_posterior(filter, p) != HNAV_OK) hnav_filter_gyro_bias(filter, p->gyro_bias_rad_s, p->sigma + 3);
            if (!std::isfinite(p->t_s)) p->t_s = start_s;
        });
        for (int s = HNAV_SENSOR_ACCEL; s <= HNAV_SENSOR_SPEED; ++s)
            innovation_[s].refresh(groups, values, [&](hnav_innovation* i) {
                *i = hnav_sized<hnav_innovation>();
                i->accepted = 1;
                hnav_filter_innovation(filter, static_cast<hnav_sensor>(s), i); // stays zero before the first
            });
        covariance_.refresh(groups, values, [&](Covariance* c) { read_covariance(filter, c->P); });
        diagnostics_.refresh(groups, values, [&](Diagnostics* s) {
            s->size = sizeof(hnav_diagnostics);
            hnav_filter_diagnostics(filter, s);
            s->missed = missed;
        });
        health_.refresh(groups, values, [&](Health* h) {
            h->size = sizeof(hnav_health);
            hnav_filter_health(filter, h);
            h->start_s = start_s;
        });
        field_.refresh(groups, values, [&](Field* f) {
            double sigma[9];
            f->size = sizeof(hnav_field);
            hnav_filter_field(filter, f);
            hnav_filter_gyro_calibration(filter, f->gyro_calibration, sigma);
        });
    }

    // Derivatives of the continuous rows along a direction of the state.
    void along(const hnav_filter* filter, const double* seed, double* rows) const {
        auto a = hnav_sized<hnav_shown_along>();
        if (hnav_filter_shown_along(filter, seed, &a) != HNAV_OK) return;
        std::memcpy(rows + q_, a.q_nb, sizeof a.q_nb);
        std::memcpy(rows + euler_, a.euler_rad, sizeof a.euler_rad);
        rows[heading_] = a.heading_rad;
        std::memcpy(rows + sigma_, a.sigma_rad, sizeof a.sigma_rad);
        std::memcpy(rows + rate_, a.rate_b_rad_s, sizeof a.rate_b_rad_s);
        std::memcpy(rows + gyro_bias_, a.gyro_bias_rad_s, sizeof a.gyro_bias_rad_s);
        std::memcpy(rows + gyro_bias_sigma_, a.gyro_bias_sigma_rad_s, sizeof a.gyro_bias_sigma_rad_s);
        write_triangle(a.covariance, rows + cov_P_);
    }

private:
    struct Bias {
        double rate[3], bias[3], sigma[3];
    };
    struct Covariance {
        double P[36];
    };
    struct Diagnostics : hnav_diagnostics {
        double missed;
    };
    struct Health : hnav_health {
        double start_s;
    };
    struct Field : hnav_field {
        double gyro_calibration[9];
    };

    void describe_posterior(Table& table) {
        using namespace rows;
        posterior_.add<&hnav_posterior::t_s>(
            table, output("post.t", "s", "", "Time of the newest sample used; the start before the first"));
        posterior_.add<&hnav_posterior::q_nb>(
            table, output("post.q", "", "", "Attitude just after that sample, body to navigation, scalar first"));
        posterior_.add<&hnav_posterior::gyro_bias_rad_s>(
            table, output("post.bias", "rad/s", "deg/s", "Gyro bias just after that sample"));
        const int sigma = posterior_.add<&hnav_posterior::sigma>(
            table, output("post.sigma", "", "",
                          "Standard deviations just after that sample: rotation about the navigation axes, gyro bias"));
        for (int i = 0; i < 6; ++i) table.row(sigma + i).unit = i < 3 ? "rad" : "rad/s";
    }

    void describe_attitude(Table& table) {
        using namespace rows;
        constexpr auto on_q_b = DependsOn::first_states, on_all = DependsOn::all_states;
        q_ = attitude_.add<&hnav_attitude::q_nb>(table,
                                                 flow("att.q", "", "", on_q_b, "Attitude now, body to navigation, scalar first"));
        euler_ = attitude_.add<&hnav_attitude::euler_rad>(
            table, flow("att.euler", "rad", "deg", on_q_b, "Roll, pitch, yaw now (rotation order z y x)"));
        heading_ = attitude_.add<&hnav_attitude::heading_rad>(
            table, flow("att.heading", "rad", "deg", on_q_b, "True heading of body x now, clockwise from north"));
        sigma_ = attitude_.add<&hnav_attitude::sigma_rad>(
            table, flow("att.sigma", "rad", "deg", on_all,
                        "Standard deviation of the rotation error about the navigation axes; pi before the start"));
        posterior_.add<&hnav_posterior::near_singular>(
            table, output("att.near_singular", Type::boolean,
                          "Pitch was beyond 85 deg at the newest sample: roll and yaw are ill defined"));
        rate_ =
            bias_.add<&Bias::rate>(table, flow("rate.body", "rad/s", "deg/s", on_q_b, "Angular rate of the body, bias removed"));
        gyro_bias_ = bias_.add<&Bias::bias>(table, flow("bias.gyro", "rad/s", "deg/s", on_q_b, "Gyro bias"));
        gyro_bias_sigma_ = bias_.add<&Bias::sigma>(
            table, flow("bias.gyro_sigma", "rad/s", "deg/s", on_all, "Standard deviation of the gyro bias"));
    }

    void describe_readiness(Table& table) {
        using namespace rows;
        diagnostics_.add<&Diagnostics::started>(table, output("align.started", Type::boolean, "There is an attitude"));
        posterior_.add<&hnav_posterior::tilt_ready>(
            table,
            output("align.tilt_ready", Type::boolean, "Tilt at the newest sample: sigma below the limit, by information gained"));
        posterior_.add<&hnav_posterior::heading_ready>(
            table, output("align.heading_ready", Type::boolean,
                          "Heading at the newest sample: sigma below the limit, by information gained"));
    }

    template <int sensor>
    void describe_used(Table& table, const char* name) {
        diagnostics_.add(table, rows::output(rows::Name("count", name, "_used"), Type::integer, "Samples used"),
                         [](const Diagnostics& s, double* row) { *row = static_cast<double>(s.used[sensor]); });
    }

    template <int sensor, int dimension>
    void describe_sensor(Table& table, const char* name, const char* unit, const char* display) {
        using namespace rows;
        describe_used<sensor>(table, name);
        Innovation& innovation = innovation_[sensor];
        const auto add = [&](const Variable& v, Innovation::Show show) {
            return dimension == 1 ? innovation.add(table, v, show) : innovation.add_vector(table, v, dimension, show);
        };
        add(output(Name("innov", name), unit, display,
                   "Innovation of the last correction: measured minus expected (directions and fields without unit)"),
            [](const hnav_innovation& i, double* rows) { std::memcpy(rows, i.value, dimension * sizeof(double)); });
        add(output(Name("innov", name, "_sigma"), unit, display,
                   "Standard deviation that the filter expects of the innovation, sqrt(S_ii), noise as parametrised"),
            [](const hnav_innovation& i, double* rows) {
                for (int k = 0; k < dimension; ++k) rows[k] = std::sqrt(i.S[4 * k]);
            });
        innovation.template add<&hnav_innovation::nis>(
            table, output(Name("nis", name), "", "",
                          "Normalised innovation squared of the last sample; its expectation is the dimension"));
        innovation.template add<&hnav_innovation::accepted>(
            table, output(Name("gate", name, "_ok"), Type::boolean, "The last sample was within its gate"));
        diagnostics_.add(table, output(Name("count", name, "_gated"), Type::integer, "Samples whose noise the gate inflated"),
                         [](const Diagnostics& s, double* row) { *row = static_cast<double>(s.gated[sensor]); });
    }

    void describe_diagnostics(Table& table) {
        using namespace rows;
        if (model_info.clocks)
            diagnostics_.add<&Diagnostics::corrections>(
                table, clock("correction", Causality::output, "Ticks when samples have corrected the estimate"));
        diagnostics_.add(table, output("hinf.gamma_used", "", "", "gamma of the last correction; 0 stands for infinity (off)"),
                         [](const Diagnostics& s, double* row) { *row = std::isfinite(s.gamma_used) ? s.gamma_used : 0; });
        diagnostics_.add<&Diagnostics::gamma_margin>(
            table, output("hinf.margin", "", "", "Feasibility 1 - lmax(L P L')/gamma^2 of the last correction"));
        diagnostics_.add<&Diagnostics::decay_rate_1_s>(
            table, output("hinf.decay_rate", "1/s", "",
                          "Rate at which the last correction makes the filter forget, in the metric of its own covariance; "
                          "0 while there is none"));
        diagnostics_.add<&Diagnostics::adapted_bias_walk_rad_s_per_sqrt_s>(
            table, output("adapt.bias_walk", "rad/s/sqrt(s)", "", "Random walk of the gyro bias in use"));
        diagnostics_.add<&Diagnostics::corrections>(table, output("count.corrections", Type::integer, "Corrections"));
        diagnostics_.add<&Diagnostics::gamma_raised>(
            table, output("count.gamma_raised", Type::integer, "Corrections whose gamma had to be raised"));
        diagnostics_.add<&Diagnostics::covariance_repaired>(
            table, output("count.covariance_repaired", Type::integer, "Covariances that had to be repaired"));
        diagnostics_.add<&Diagnostics::missed>(
            table, output("count.missed", Type::integer, "Samples that a coarse communication step lost"));
        diagnostics_.add<&Diagnostics::late>(table, output("count.late", Type::integer, "Samples refused as too old"));
        diagnostics_.add<&Diagnostics::non_finite>(table,
                                                   output("count.non_finite", Type::integer, "Samples refused as not finite"));
        diagnostics_.add<&Diagnostics::zero>(table, output("count.zero", Type::integer, "Samples refused as zero vectors"));
        diagnostics_.add<&Diagnostics::solver_rhs_evals>(
            table, output("solver.rhs_evals", Type::integer, "Evaluations of the flow by the integrator inside"));
    }

    void describe_health(Table& table) {
        using namespace rows;
        describe_sensor_health<HNAV_SENSOR_GYRO>(table, "gyro");
        describe_sensor_health<HNAV_SENSOR_ACCEL>(table, "accel");
        describe_sensor_health<HNAV_SENSOR_MAG>(table, "mag");
        health_.add<&Health::lost>(table,
                                   output("health.lost", Type::boolean, "The attitude is searched again: nothing is ready"));
        health_.add<&Health::times_lost>(
            table, output("health.times_lost", Type::integer, "Times that the attitude was found wrong, or a gap too long"));
        health_.add<&Health::clock_jumps>(
            table, output("health.clock_jumps", Type::integer, "Times that stamps ran back and a new time base began"));
        health_.add<&Health::stamps_left_out>(
            table, output("health.stamps_left_out", Type::integer, "Samples left out: their stamp lay far ahead of all others"));
    }

    template <int sensor>
    void describe_sensor_health(Table& table, const char* name) {
        using namespace rows;
        const auto row = [&](const char* ending) { return Name("health", name, ending); };
        health_.add(
            table,
            output(row(".state"), {sensor_state, nullptr, HNAV_SENSOR_STATE_MISSING + 1}, "What the sensor is taken to be"),
            [](const Health& h, double* row) { *row = h.sensor[sensor].state; });
        health_.add(
            table,
            output(row(".since"), "s", "", "Time at which the state began; the start time when it has been so from the first"),
            [](const Health& h, double* row) {
                const double since_s = h.sensor[sensor].since_s;
                *row = std::isnan(since_s) ? h.start_s : since_s;
            });
        health_.add(table,
                    output(row(".axes"), Type::integer, "Axes stuck or saturated now: the sum of 1 for x, 2 for y, 4 for z"),
                    [](const Health& h, double* row) { *row = h.sensor[sensor].axes; });
        describe_health_count<sensor, &hnav_sensor_health::outliers>(table, row(".outliers"),
                                                                     "Samples that lay far from those beside them");
        describe_health_count<sensor, &hnav_sensor_health::stuck>(table, row(".stuck"), "Samples with an axis that was stuck");
        describe_health_count<sensor, &hnav_sensor_health::saturated>(table, row(".saturated"),
                                                                      "Samples with an axis at the end of its range");
        describe_health_count<sensor, &hnav_sensor_health::late>(table, row(".late"), "Samples refused as too old");
        describe_health_count<sensor, &hnav_sensor_health::left_out>(table, row(".left_out"), "Samples taken in and not used");
    }

    template <int sensor, auto count>
    void describe_health_count(Table& table, const char* name, const char* text) {
        health_.add(table, rows::output(name, Type::integer, text),
                    [](const Health& h, double* row) { *row = static_cast<double>(h.sensor[sensor].*count); });
    }

    static Choice sensor_state(const void*, int k) {
        constexpr Choice states[] = {
            {"ok", "Its samples are used"},
            {"late", "Within the last second a sample was refused: older than the committed estimate"},
            {"outlier", "Within the last second a sample lay far from those beside it"},
            {"stuck", "An axis repeats one value although the body moves"},
            {"saturated", "An axis is at the end of its range"},
            {"missing", "No sample yet, or none for a second and ten of its usual intervals"},
        };
        return states[k];
    }

    // The upper triangle, row by row.
    void describe_covariance(Table& table) {
        const int first = cov_P_ = table.add_triangle(
            rows::flow("cov.P", "", "", DependsOn::all_states, "Covariance of (rotation about the navigation axes, gyro bias)"),
            6);
        int row = first;
        for (int i = 0; i < 6; ++i)
            for (int j = i; j < 6; ++j) table.row(row++).unit = j < 3 ? "rad2" : i < 3 ? "rad2/s" : "rad2/s2";
        covariance_.bind(table, first, 21, [](const Covariance& c, double* rows) { write_triangle(c.P, rows); });
    }

    static void write_triangle(const double* P, double* rows) {
        for (int i = 0; i < 6; ++i)
            for (int j = i; j < 6; ++j) *rows++ = P[6 * i + j];
    }

    static void read_covariance(const hnav_filter* filter, double* P) {
        if (hnav_filter_covariance(filter, P) == HNAV_OK) return;
        double bias[3], sigma[3];
        hnav_filter_gyro_bias(filter, bias, sigma);
        std::memset(P, 0, 36 * sizeof(double));
        for (int i = 0; i < 3; ++i) {
            P[7 * i] = M_PI * M_PI; // no attitude: an error of up to half a turn
            P[7 * (i + 3)] = sigma[i] * sigma[i];
        }
    }

    void describe_field(Table& table) {
        using namespace rows;
        field_.add(table, output("field.strength", "T", "uT", "Strength of the reference field; 0 while there is none"),
                   [](const Field& f, double* row) { *row = known(f) ? f.strength_tesla : 0; });
        field_.add(table, output("field.dip", "rad", "deg", "Dip of the reference field below the horizon"),
                   [](const Field& f, double* row) { *row = known(f) ? f.dip_rad : 0; });
        field_.add<&Field::latency_s>(
            table, output("field.latency", "s", "ms", "Estimated delay of the magnetometer behind its time stamps"));
        field_.add<&Field::latency_sigma_s>(table, output("field.latency_sigma", "s", "ms", "Standard deviation of that delay"));
        field_.add<&Field::evidence_s>(
            table, output("field.evidence", "s", "", "Time for which the reference was seen, counted less at rest"));
        field_.add<&Field::heading_trust_s>(
            table, output("field.heading_trust", "s", "", "The same for the heading, through changes of reference"));
        field_.add<&Field::reference_changes>(
            table, output("field.reference_changes", Type::integer, "Changes of the reference field after the first"));
        field_.add<&Field::gate>(
            table, output("field.gate", {field_gate, nullptr, HNAV_FIELD_INFLATED + 1}, "What became of the last field"));
        field_.add<&Field::at_rest>(table, output("rest.detected", Type::boolean, "The body lies still"));
        field_.bind<&Field::gyro_calibration>(
            table, table.add_matrix(output("gyro_calibration.S", "", "",
                                           "Scale and misalignment of the gyroscope: rate = (I - S) reading - bias"),
                                    3));
    }

    static Choice field_gate(const void*, int k) {
        constexpr Choice verdicts[] = {
            {"accepted", "Used: it agrees with the reference"},
            {"rejected", "Not used: it lies away from the reference"},
            {"inflated", "Used with inflated noise although it lies away"},
        };
        return verdicts[k];
    }

    static bool known(const Field& field) { return !std::isnan(field.strength_tesla); }

    int q_ = 0, euler_ = 0, heading_ = 0, sigma_ = 0, rate_ = 0, gyro_bias_ = 0, gyro_bias_sigma_ = 0, cov_P_ = 0; // rows
    using Innovation = Outputs<hnav_innovation, innovation_group>;
    Outputs<hnav_attitude, attitude_group> attitude_;
    Outputs<Bias, bias_group> bias_;
    Outputs<hnav_posterior, posterior_group> posterior_;
    Innovation innovation_[HNAV_SENSOR_SPEED + 1]; // none of the gyro
    Outputs<Covariance, covariance_group> covariance_;
    Outputs<Diagnostics, diagnostics_group, 32> diagnostics_;
    Outputs<Health, health_group, 32> health_;
    Outputs<Field, field_group> field_;
};

} // namespace hnav::fmu
