// Vehicles over the turning Earth: motion of a car, an aircraft, a ship, a body at rest or one on a given path, and the readings of
// error-free inertial sensors. All quantities except course and position are functions of time in closed form; these two are
// integrated. On a given path the position is a function of time too, and the integrated one equals it.
//
// Velocity and attitude are drawn in level axes that move with the vehicle, and converted to north-east-down for output.
#pragma once

#include "hnav/simulation.h"
#include "maths/earth.hpp"
#include "simulation/random.hpp"
#include "simulation/way.hpp"

namespace hnav {

class Vehicle {
public:
    // Integrated states: the displacement from the start in Earth-fixed axes, and the course in the level axes.
    struct State {
        Vector3 displacement_m;
        double course_rad;
    };

    struct Seen {
        earth::Place place;
        Vector3 velocity_n, rate_b, force_b, field_b;
        Quaternion q_nb;
    };

    Vehicle(const hnav_vehicle_options& options, double start_s);

    // For the kind way; its times count from the start on.
    Way::Made follow(const hnav_way_point* points, std::size_t count) { return way_.make(start_place_, points, count); }

    State start() const { return way_ ? State{way_.at(0).position, course_rad_} : State{Vector3::Zero(), course_rad_}; }
    State flow(double t_s, const State& x) const;
    // By fourth-order Runge-Kutta in equal steps of at most longest_step_s, forward or backward.
    State carry(double from_s, const State& x, double to_s) const;
    Seen seen(double t_s, const State& x) const;

    static constexpr double longest_step_s = 0.03125;

private:
    // A signal and its derivative.
    struct Signal {
        double value, rate;
    };
    // Motion of the body at an instant, in its level axes.
    struct Motion {
        Signal speed, climb, heave, roll, pitch; // climb: angle of the way above the level; heave: velocity down
        double turn_rad_s;
    };
    // In Earth-fixed axes, against the Earth.
    struct Body {
        earth::Place place;
        Matrix3 axes_n, axes_b; // north, east, down and the axes of the body, as columns
        Vector3 position, velocity, acceleration, rate;
    };
    // Levels that are each held for a while, with smooth transitions.
    struct Stairs {
        double mean_s, spread_s, blend_s;
        double (*level)(double first, double second); // of two numbers that are uniform in [0, 1)
    };

    Motion motion(double s) const;
    Motion of_kind(double s) const;
    Motion car(double s) const;
    Motion aircraft(double s) const;
    Motion ship(double s) const;
    Motion rest(double s) const;
    RandomStream stream(int signal) const;
    Signal stairs(double s, int signal, const Stairs& stairs) const;
    Signal sway(double s, int signal, double size, double haste) const;
    Signal vibration(double s, int signal, int order) const;
    Signal wave(double s, int signal, double low, double high, double shortest_s, double longest_s) const;

    Vector3 velocity_in_level(const Motion& m, double course_rad) const;
    // Rotation of the level axes relative to the Earth.
    Vector3 level_rate(const earth::Place& place, const Matrix3& axes_n, const Vector3& velocity_e) const;
    Body body(double t_s, const State& x) const;
    Body body_on_way(double t_s) const;
    void feel(const Body& body, double weight, Seen* seen) const;

    hnav_vehicle_kind kind_;
    std::uint64_t seed_;
    double start_s_, sway_, vibration_m_s2_, mean_over_s_, course_rad_;
    Way way_;
    earth::Place start_place_;
    Matrix3 axes_e_; // level axes of the start
    Vector3 position_e_; // of the start
    Vector3 field_n_;
};

} // namespace hnav
