// Detects samples in another unit, because an FMU receives numbers without units: of an inertial sensor in g or deg/s, or without gravity,
// from the direction of gravity; of a magnetometer, by the strength of the field of the Earth.
#pragma once

#include <cmath>
#include <cstring>

namespace hnav::fmu {

// Eight-byte numbers, saved bytewise. A finding is a sentence for the log; the samples are used unchanged.
class UnitCheck {
public:
    // m/s2 or g; sensor axes.
    void take_force(const double* force) {
        if (decided() || !std::isfinite(force[0] + force[1] + force[2])) return;
        for (int i = 0; i < 3; ++i) force_[i] += force[i];
        forces_ += 1;
    }

    // Rate in rad/s or deg/s, held since the sample before.
    void take_rate(double t_s, const double* rate) {
        if (decided() || !std::isfinite(rate[0] + rate[1] + rate[2])) return;
        if (has_rate_ != 0)
            for (int i = 0; i < 3; ++i) angle_[i] += 0.5 * (rate[i] + rate_[i]) * (t_s - rate_s_);
        std::memcpy(rate_, rate, sizeof rate_);
        rate_s_ = t_s;
        if (has_rate_ == 0 || t_s < begin_s_) begin_s_ = t_s;
        has_rate_ = 1;
        if (t_s - begin_s_ >= window_s - 1e-9 && forces_ > 0) end_window();
    }

    // The finding, or null if there is none.
    const char* finding() const {
        if (found_ == is_g) return "accel.force has a strength near 1 m/s2: this looks like g; multiply it by 9.80665";
        if (found_ == has_no_gravity)
            return "accel.force has a mean strength far below 9.8 m/s2 and no constant one: this looks like an acceleration without gravity; "
                   "connect the specific force, (0, 0, -9.81) at rest with z down";
        if (found_ == is_deg_s)
            return "gyro.rate: gravity turned 57 times less than the rates say: this looks like deg/s; multiply it by 0.0174533";
        return nullptr;
    }

private:
    static constexpr double window_s = 0.1;
    static constexpr double enough = 50; // windows
    static constexpr double most = 6000; // windows, ten minutes: a body that has not tilted by then is not judged
    static constexpr double least_turn = 0.01; // rad, RMS of a window: above the noise of any accelerometer's mean
    static constexpr double sure = 0.85; // correlation between the rotation of gravity and the integrated rates
    static constexpr double undecided = 0, plausible = 1, is_g = 2, is_deg_s = 3, has_no_gravity = 4;
    static constexpr double weak = 5; // m/s2; chosen: only a fall has half of gravity for seconds
    static constexpr double steady = 0.5; // chosen: largest standard deviation of the strength of gravity in g, by its mean

    bool decided() const { return found_ != undecided; }

    void end_window() {
        const double size = std::sqrt(force_[0] * force_[0] + force_[1] * force_[1] + force_[2] * force_[2]);
        double middle[3], unit[3];
        for (int i = 0; i < 3; ++i) {
            unit[i] = size > 0 ? force_[i] / size : 0;
            middle[i] = 0.5 * (angle_[i] + angle_before_[i]); // between the middles of two windows
        }
        if (windows_ > 0) compare(unit, middle);
        windows_ += 1;
        strength_ += size / forces_;
        strength2_ += (size / forces_) * (size / forces_);
        std::memcpy(unit_, unit, sizeof unit_);
        std::memcpy(angle_before_, angle_, sizeof angle_before_);
        std::memset(angle_, 0, sizeof angle_);
        std::memset(force_, 0, sizeof force_);
        forces_ = 0;
        begin_s_ = rate_s_;
        if (windows_ >= enough) decide();
    }

    // A direction that is constant in space changes in body axes by d = v x theta, where theta is the small rotation of the
    // body.
    void compare(const double* unit, const double* angle) {
        for (int i = 0; i < 3; ++i) {
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            const double said = unit_[j] * angle[k] - unit_[k] * angle[j], seen = unit[i] - unit_[i];
            said2_ += said * said;
            seen2_ += seen * seen;
            both_ += said * seen;
        }
    }

    void decide() {
        const double mean = strength_ / windows_, spread2 = strength2_ / windows_ - mean * mean;
        if (mean < weak) {
            found_ = mean > 0.5 && mean < 2 && spread2 < steady * steady * mean * mean ? is_g : has_no_gravity;
            return;
        }
        if (seen2_ > least_turn * least_turn * windows_ && both_ > sure * std::sqrt(said2_ * seen2_)) {
            const double scale = both_ / said2_ * (180 / M_PI);
            found_ = scale > 0.5 && scale < 2 ? is_deg_s : plausible;
        }
        if (windows_ >= most && !decided()) found_ = plausible;
    }

    double begin_s_ = 0, rate_s_ = 0, has_rate_ = 0, forces_ = 0, windows_ = 0;
    double rate_[3] = {}, angle_[3] = {}, angle_before_[3] = {}; // rad, of this window and the one before
    double force_[3] = {}, unit_[3] = {}; // sum of this window; direction in the previous one
    double strength_ = 0, strength2_ = 0; // sum over windows, and of the squares
    double said2_ = 0, seen2_ = 0, both_ = 0;
    double found_ = undecided;
};

// The same for the field of Ahrs and Hrekf; Ins takes it in any unit. No heading of Ahrs becomes ready with another strength.
class FieldUnitCheck {
public:
    void take(const double* field) {
        const double strength = std::sqrt(field[0] * field[0] + field[1] * field[1] + field[2] * field[2]);
        if (samples_ == enough || !std::isfinite(strength)) return;
        strength_ += strength / enough;
        samples_ += 1;
    }

    // The finding, or null if there is none. by_strength: a heading is ready by the strength of the earth's field only; Hrekf takes a
    // unit vector as well.
    const char* finding(bool by_strength) const {
        // 22 to 67 uT, and more for the scale error of an uncalibrated sensor.
        if (samples_ < enough) return nullptr;
        if (by_strength && is_within(0.9, 1.1))
            return "mag.field has a strength of 1: this looks like a direction, by which no heading becomes ready; multiply it by 5e-5";
        if (is_within(15, 100)) return "mag.field has a strength of 15 to 100: this looks like uT; multiply it by 1e-6";
        if (is_within(150, 1000)) return "mag.field has a strength of 150 to 1000: this looks like mG; multiply it by 1e-7";
        if (is_within(0.15, 0.8)) return "mag.field has a strength of 0.15 to 0.8: this looks like gauss; multiply it by 1e-4";
        if (is_within(15e3, 100e3)) return "mag.field has a strength of 15000 to 100000: this looks like nT; multiply it by 1e-9";
        return nullptr;
    }

private:
    static constexpr double enough = 50; // samples

    bool is_within(double least, double most) const { return strength_ > least && strength_ < most; }

    double strength_ = 0, samples_ = 0; // mean
};

} // namespace hnav::fmu
