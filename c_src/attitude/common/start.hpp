// Gathers the samples that an attitude filter starts from.
#pragma once

#include "attitude/common/estimate.hpp"
#include "attitude/common/first_attitude.hpp"
#include "hybrid/event.hpp"

namespace hnav {

enum class StartMode { triad, attitude, heading };

struct StartSettings {
    StartMode mode = StartMode::triad;
    Quaternion q{1, 0, 0, 0};
    double heading_rad = 0; // magnetic
    std::uint64_t samples = 1;
    double sigma_heading = 0;
    double field_wait_s = std::numeric_limits<double>::infinity(); // after that, start without a field
};

// Part of a filter's state: doubles and 64-bit integers only.
struct StartSamples {
    double sum[2][3]; // force, field
    double aid, aid_sigma; // heading
    double first_s;
    std::uint64_t count[2];
    std::uint64_t has_aid;

    void clear() {
        *this = {};
        first_s = nan;
    }

    Vector3 force() const { return Vector3(sum[0]) / static_cast<double>(count[0]); }
    Vector3 field() const { return Vector3(sum[1]) / static_cast<double>(count[1]); }

    // Adds the samples of an event. True once an attitude follows from them, with the sigma of its heading.
    bool add(const Event& event, const StartSettings& settings, Quaternion* q, double* heading_sigma) {
        if (std::isnan(first_s)) first_s = event.t_s;
        for (int k = 0; k < 2; ++k) {
            const int c = accel + k;
            if (!event.has(c) || count[k] >= settings.samples) continue;
            for (int i = 0; i < 3; ++i) sum[k][i] += event.value[c][i];
            ++count[k];
        }
        if (event.has(heading)) {
            aid = event.value[heading][0];
            aid_sigma = event.value[heading][1];
            has_aid = 1;
        }

        *heading_sigma = settings.sigma_heading;
        if (settings.mode == StartMode::attitude) {
            *q = settings.q;
            return true;
        }
        const bool force_known = count[0] >= settings.samples;
        if (!force_known || !(force().norm() > 0)) return false;
        if (settings.mode == StartMode::heading) {
            *q = level_with_heading(force(), settings.heading_rad);
            return true;
        }
        if (has_aid) {
            *q = level_with_heading(force(), aid);
            *heading_sigma = aid_sigma;
            return true;
        }
        if (!has_field(settings)) {
            if (!(event.t_s - first_s >= settings.field_wait_s)) return false;
            *q = level_with_heading(force(), 0);
            *heading_sigma = M_PI / std::sqrt(3.0); // any heading is as likely as any other
            return true;
        }
        if (triad(force(), field(), q)) return true;
        const double began = first_s; // no heading in these samples: wait for better ones
        clear();
        first_s = began;
        return false;
    }

    bool has_field(const StartSettings& settings) const { return count[1] >= settings.samples && Vector3(sum[1]).norm() > 0; }
};

} // namespace hnav
