// The motion of a three-axis turntable in closed form: angles, rates, and the readings of error-free sensors on it.
//
// A motion consists of smooth pieces with corners between them, where the rate jumps. Pieces are numbered, so that an
// integrator that steps across a corner can continue the piece smoothly beyond its end.
#pragma once

#include "base/instant.hpp"
#include "maths/rotation.hpp"

#include <limits>

namespace hnav {

enum class Motion { constant, step, sine, triangle };

struct AxisState {
    double angle_rad, rate_rad_s;
};

struct AxisMotion {
    Motion kind = Motion::constant;
    double angle_rad = 0, amplitude_rad = 0, rate_rad_s = 1, period_s = 1, start_s = 0;

    static constexpr double before_start = -1;
    static constexpr double corners_apart_s = 1e-6; // minimum, chosen: limits the number of events

    // The piece at t. A corner belongs to the piece that follows, also when rounding puts t just before it: a sample at a
    // corner must not depend on the rounding of an importer's time.
    double piece(double t_s) const {
        if (still()) return before_start;
        const double s = t_s - start_s + instant_s(t_s, 0.01);
        if (s < 0) return before_start;
        switch (kind) {
        case Motion::step: return s < quarter_s() ? 0 : 1;
        case Motion::triangle: return std::floor(0.5 * (s / quarter_s() + 1));
        default: return 0;
        }
    }

    AxisState at(double t_s, double piece) const {
        if (piece == before_start) return {angle_rad, 0};
        const double s = t_s - start_s, way = std::copysign(rate_rad_s, amplitude_rad);
        switch (kind) {
        case Motion::step:
            if (piece > 0) return {angle_rad + amplitude_rad, 0};
            return {angle_rad + way * s, way};
        case Motion::sine: {
            const double w = 2 * M_PI / period_s;
            return {angle_rad + amplitude_rad * std::sin(w * s), amplitude_rad * w * std::cos(w * s)};
        }
        case Motion::triangle: {
            // Piece p passes the middle at 2 p quarters, up when p is even.
            const double rate = std::fmod(piece, 2) == 0 ? way : -way;
            return {angle_rad + rate * (s - 2 * piece * quarter_s()), rate};
        }
        default: return {angle_rad, 0};
        }
    }

    // From the middle to the end at the given rate.
    double quarter_s() const { return std::fabs(amplitude_rad) / rate_rad_s; }

    bool has_corners() const { return !still() && (kind == Motion::step || kind == Motion::triangle); }

    // Where the piece ends; infinity for the last.
    double corner_s(double piece) const {
        if (still()) return std::numeric_limits<double>::infinity();
        if (piece == before_start) return start_s;
        if (kind == Motion::step && piece == 0) return start_s + quarter_s();
        if (kind == Motion::triangle) return start_s + (2 * piece + 1) * quarter_s();
        return std::numeric_limits<double>::infinity();
    }

private:
    bool still() const { return kind == Motion::constant || amplitude_rad == 0; }
};

struct Truth {
    Quaternion q; // body to north-east-down
    Vector3 rate, force, field;
};

struct TurntableMotion {
    AxisMotion axes[3]; // roll, pitch, yaw: innermost first
    Vector3 force_n{0, 0, -9.80665}, field_n{0, 0, 0};

    struct Pieces {
        double of[3];
    };

    Pieces pieces(double t_s) const { return {{axes[0].piece(t_s), axes[1].piece(t_s), axes[2].piece(t_s)}}; }

    double next_corner_s(double t_s) const {
        double next = std::numeric_limits<double>::infinity();
        for (const AxisMotion& axis : axes) next = std::fmin(next, axis.corner_s(axis.piece(t_s)));
        return next;
    }

    Truth at(double t_s, const Pieces& pieces) const {
        AxisState a[3];
        for (int i = 0; i < 3; ++i) a[i] = axes[i].at(t_s, pieces.of[i]);
        const double roll = a[0].angle_rad, pitch = a[1].angle_rad;
        Truth truth;
        const auto turn = [](int axis, double angle) {
            Quaternion q(std::cos(0.5 * angle), 0, 0, 0);
            q[axis + 1] = std::sin(0.5 * angle);
            return q;
        };
        truth.q = multiply(turn(2, a[2].angle_rad), multiply(turn(1, pitch), turn(0, roll)));
        // Each axis turns the frame carried by the outer ones (Titterton and Weston, Strapdown Inertial Navigation
        // Technology, 2nd ed., section 3.6.3, solved for the body rate).
        const double d_roll = a[0].rate_rad_s, d_pitch = a[1].rate_rad_s, d_yaw = a[2].rate_rad_s;
        truth.rate = {d_roll - d_yaw * std::sin(pitch), d_pitch * std::cos(roll) + d_yaw * std::cos(pitch) * std::sin(roll),
                      -d_pitch * std::sin(roll) + d_yaw * std::cos(pitch) * std::cos(roll)};
        see(&truth);
        return truth;
    }

    // Force and field in the attitude of the truth.
    void see(Truth* truth) const {
        const Matrix3 C_bn = rotation_matrix(truth->q).transpose();
        truth->force = C_bn * force_n;
        truth->field = C_bn * field_n;
    }
};

} // namespace hnav
