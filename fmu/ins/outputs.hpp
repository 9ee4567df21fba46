// Outputs of the Ins FMU: each row and the answer of the filter that it shows.
#pragma once

#include "adapter/outputs.hpp"
#include "adapter/rows.hpp"
#include "hnav/hnav.h"

namespace hnav::fmu {

class InsOutputs {
public:
    void describe(Table& table) {
        describe_navigation(table);
        describe_attitude(table);
        describe_biases(table);
        describe_readiness(table);
        describe_observed(table);
        describe_sensor<HNAV_SENSOR_POSITION, 3>(table, "gnss", "m");
        describe_sensor<HNAV_SENSOR_VELOCITY, 3>(table, "gnssvel", "m/s");
        describe_sensor<HNAV_SENSOR_PRESSURE, 1>(table, "baro", "m");
        describe_sensor<HNAV_SENSOR_SPEED, 1>(table, "wheel", "m/s");
        describe_sensor<HNAV_SENSOR_HEADING, 1>(table, "aid", "rad");
        describe_sensor<HNAV_SENSOR_MAG, 2>(table, "mag", "");
        describe_counts(table);
    }

    // missed: samples lost by the clocks of the FMU.
    void refresh(const hnav_filter* ins, unsigned groups, double missed, double* values) const {
        navigation_.refresh(groups, values, [&](hnav_navigation* n) {
            n->size = sizeof *n;
            hnav_ins_navigation(ins, n);
            if (!(n->q_nb[0] == n->q_nb[0])) show_nothing(n);
        });
        observed_.refresh(groups, values, [&](hnav_observed* o) {
            o->size = sizeof *o;
            hnav_ins_observed(ins, o);
        });
        for (int s = 0; s < HNAV_SENSOR_COUNT; ++s)
            innovation_[s].refresh(groups, values, [&](hnav_innovation* i) {
                *i = hnav_sized<hnav_innovation>();
                hnav_filter_innovation(ins, static_cast<hnav_sensor>(s), i); // stays zero before the first
            });
        counts_.refresh(groups, values, [&](Counts* c) {
            c->size = sizeof(hnav_diagnostics);
            hnav_filter_diagnostics(ins, c);
            auto health = hnav_sized<hnav_health>();
            hnav_filter_health(ins, &health);
            c->times_lost = health.times_lost;
            c->missed = missed;
        });
    }

    // Derivatives of the continuous rows along a direction of the state.
    void along(const hnav_filter* ins, const double* seed, double* rows) const {
        auto a = hnav_sized<hnav_navigation_along>();
        if (hnav_ins_navigation_along(ins, seed, &a) != HNAV_OK) return;
        rows[place_] = a.latitude_rad;
        rows[place_ + 1] = a.longitude_rad;
        rows[place_ + 2] = a.height_m;
        std::memcpy(rows + velocity_, a.velocity_n_m_s, sizeof a.velocity_n_m_s);
        std::memcpy(rows + q_, a.q_nb, sizeof a.q_nb);
        std::memcpy(rows + euler_, a.euler_rad, sizeof a.euler_rad);
        rows[heading_] = a.euler_rad[2];
    }

private:
    enum Group { navigation_group, observed_group, innovation_group, count_group };
    static constexpr double anywhere_m = 1e7, any_speed_m_s = 1e4, any_bias = 1e3; // of what is not known

    struct Counts : hnav_diagnostics {
        std::uint64_t times_lost;
        double missed;
    };

    // Before the tilt is known there is no estimate, and any error is possible.
    static void show_nothing(hnav_navigation* n) {
        const auto now = *n;
        *n = hnav_sized<hnav_navigation>();
        n->t_s = now.t_s;
        n->phase = now.phase;
        n->at_rest = now.at_rest;
        n->q_nb[0] = 1;
        n->protection_heading_rad = M_PI;
        for (int i = 0; i < 3; ++i) {
            n->sigma_position_m[i] = anywhere_m;
            n->sigma_velocity_m_s[i] = any_speed_m_s;
            n->sigma_rotation_rad[i] = M_PI;
            if (i < 2) n->protection_m[i] = anywhere_m;
            n->sigma_gyro_bias_rad_s[i] = n->sigma_accel_bias_m_s2[i] = any_bias;
        }
    }

    template <auto field>
    void show(Table& table, const char* name, const char* unit, const char* display, const char* text) {
        navigation_.add<field>(table, rows::output(name, unit, display, text));
    }

    void describe_navigation(Table& table) {
        using namespace rows;
        using N = hnav_navigation;
        constexpr auto on_d_v = DependsOn::first_states;
        place_ = navigation_.add<&N::latitude_rad>(table,
                                                   flow("nav.latitude", "rad", "deg", on_d_v, "Latitude of the inertial sensor"));
        navigation_.add<&N::longitude_rad>(table, flow("nav.longitude", "rad", "deg", on_d_v, "Longitude"));
        navigation_.add<&N::height_m>(table, flow("nav.height", "m", "", on_d_v, "Height above the ellipsoid of WGS 84"));
        velocity_ =
            navigation_.add<&N::velocity_n_m_s>(table, flow("nav.velocity", "m/s", "", on_d_v, "Velocity north, east, down"));
        show<&N::sigma_position_m>(table, "nav.sigma_position", "m", "", "Standard deviation of the position north, east, down");
        show<&N::sigma_velocity_m_s>(table, "nav.sigma_velocity", "m/s", "",
                                     "Standard deviation of the velocity north, east, down");
    }

    void describe_attitude(Table& table) {
        using namespace rows;
        using N = hnav_navigation;
        constexpr auto on_all = DependsOn::all_states; // not on the velocity
        q_ = navigation_.add<&N::q_nb>(table, flow("att.q", "", "", on_all, "Attitude, body to north-east-down, scalar first"));
        euler_ = navigation_.add<&N::euler_rad>(
            table, flow("att.euler", "rad", "deg", on_all, "Roll, pitch, yaw (rotation order z y x); yaw is the true heading"));
        heading_ =
            navigation_.add(table, flow("att.heading", "rad", "deg", on_all, "True heading of body x, clockwise from north"),
                            [](const N& n, double* row) { *row = n.euler_rad[2]; });
        show<&N::sigma_rotation_rad>(table, "att.sigma", "rad", "deg",
                                     "Standard deviation of the rotation about north, east, down; the third is heading, "
                                     "spread over the whole circle");
    }

    void describe_biases(Table& table) {
        using N = hnav_navigation;
        show<&N::gyro_bias_rad_s>(table, "bias.gyro", "rad/s", "deg/s", "Gyro bias, body axes");
        show<&N::sigma_gyro_bias_rad_s>(table, "bias.gyro_sigma", "rad/s", "deg/s", "Standard deviation of the gyro bias");
        show<&N::accel_bias_m_s2>(table, "bias.accel", "m/s2", "", "Accelerometer bias, body axes");
        show<&N::sigma_accel_bias_m_s2>(table, "bias.accel_sigma", "m/s2", "", "Standard deviation of the accelerometer bias");
        show<&N::latency_s>(table, "gnss.latency", "s", "ms", "Estimated delay of the satellites behind their time stamps");
        show<&N::sigma_latency_s>(table, "gnss.latency_sigma", "s", "ms", "Standard deviation of that delay");
    }

    void describe_readiness(Table& table) {
        using namespace rows;
        using N = hnav_navigation;
        navigation_.add<&N::phase>(
            table, output("align.phase", {phase, nullptr, HNAV_INS_PHASE_NAVIGATING + 1}, "Where the filter stands"));
        const auto flag = [&](const char* name, const char* text) { return output(name, Type::boolean, text); };
        navigation_.add<&N::tilt_ready>(table, flag("align.tilt_ready", "Tilt: sigma below the limit, by information gained"));
        navigation_.add<&N::heading_ready>(table, flag("align.heading_ready", "Heading: likewise, and held"));
        navigation_.add<&N::velocity_ready>(table, flag("align.velocity_ready", "Velocity: likewise"));
        navigation_.add<&N::position_ready>(table, flag("align.position_ready", "Position: likewise"));
        navigation_.add<&N::at_rest>(table, flag("rest.detected", "The body stands"));
        navigation_.add<&N::heading_second_rad>(table,
                                                output("align.heading_second", "rad", "deg", "The strongest other heading"));
        navigation_.add<&N::heading_second_share>(
            table, output("align.heading_second_share", "", "", "Its probability; 0: there is none"));
        show<&N::protection_m>(table, "nav.protection", "m", "",
                               "Bounds of the horizontal and vertical error, exceeded for less than 1e-3 of the time");
        show<&N::protection_heading_rad>(table, "att.heading_protection", "rad", "deg", "Such a bound of the heading");
    }

    void describe_observed(Table& table) {
        using namespace rows;
        using O = hnav_observed;
        const auto nats = [&](const char* name, const char* text) { return output(name, "", "", text); };
        observed_.add<&O::by_rest>(table, nats("observed.by_rest", "Nats gained about the heading by standing still"));
        observed_.add<&O::by_speed>(table, nats("observed.by_speed", "By wheels"));
        observed_.add<&O::by_pressure>(table, nats("observed.by_pressure", "By heights"));
        observed_.add<&O::by_velocity>(table, nats("observed.by_velocity", "By velocities of the satellites"));
        observed_.add<&O::by_position>(table, nats("observed.by_position", "By their positions"));
        observed_.add<&O::by_heading>(table, nats("observed.by_heading", "By the heading aid"));
        observed_.add<&O::by_field>(table, nats("observed.by_field", "By the magnetometer"));
    }

    template <int sensor, int dimension>
    void describe_sensor(Table& table, const char* name, const char* unit) {
        using namespace rows;
        using I = hnav_innovation;
        auto& innovation = innovation_[sensor];
        const Variable v = output(Name("innov", name), unit, "", "Innovation of the last sample used: measured minus expected");
        const auto value = [](const I& i, double* rows) { std::memcpy(rows, i.value, dimension * sizeof(double)); };
        if (dimension == 1) innovation.add(table, v, value);
        else innovation.add_vector(table, v, dimension, value);
        innovation.template add<&I::nis>(
            table,
            output(Name("nis", name), "", "", "Normalised innovation squared of that sample; its expectation is the dimension"));
        describe_used<sensor>(table, name);
        counts_.add(table, output(Name("count", name, "_inflated"), Type::integer, "Of these, with inflated noise or left out"),
                    [](const Counts& c, double* row) { *row = static_cast<double>(c.gated[sensor]); });
    }

    template <int sensor>
    void describe_used(Table& table, const char* name) {
        counts_.add(table, rows::output(rows::Name("count", name, "_used"), Type::integer, "Samples used"),
                    [](const Counts& c, double* row) { *row = static_cast<double>(c.used[sensor]); });
    }

    void describe_counts(Table& table) {
        using namespace rows;
        if (model_info.clocks)
            counts_.add<&Counts::corrections>(
                table, clock("correction", Causality::output, "Ticks when samples have corrected the estimate"));
        describe_used<HNAV_SENSOR_GYRO>(table, "imu");
        describe_used<HNAV_SENSOR_REST>(table, "rest");
        counts_.add<&Counts::late>(table,
                                   output("count.late", Type::integer, "Samples refused: older than the committed estimate"));
        counts_.add<&Counts::non_finite>(table, output("count.non_finite", Type::integer, "Samples refused for their numbers"));
        counts_.add<&Counts::times_lost>(
            table, output("count.lost", Type::integer, "The start or the search for the heading began again"));
        counts_.add<&Counts::missed>(table, output("count.missed", Type::integer, "Samples that no communication point met"));
        counts_.add<&Counts::mean_nis>(
            table, output("nis.mean", "", "", "Mean of the last NIS over their dimensions; above 1 the sigmas are too small"));
    }

    static Choice phase(const void*, int k) {
        constexpr Choice phases[] = {
            {"waiting", "For rate and force"},
            {"levelling", "The first tilt is being found, or the first fix waited for"},
            {"any_heading", "Everything but the heading is estimated, and what there is to know of it"},
            {"navigating", "Everything is estimated"},
        };
        return phases[k];
    }

    int place_ = 0, velocity_ = 0, q_ = 0, euler_ = 0, heading_ = 0; // rows
    Outputs<hnav_navigation, navigation_group, 32> navigation_;
    Outputs<hnav_observed, observed_group> observed_;
    Outputs<hnav_innovation, innovation_group> innovation_[HNAV_SENSOR_COUNT];
    Outputs<Counts, count_group, 32> counts_;
};

} // namespace hnav::fmu
