// Choice of the magnetic reference field.
//
// The heading refers to a reference field (horizontal and vertical intensity; its azimuth is north by definition). A magnet nearby, or a
// start in a distorted place, makes the measured field disagree with it. Two decisions are made here from the measured field in
// navigation axes and from time:
//
// * May this field correct the heading? The gate. A field whose intensities differ from the reference is rejected, for a time that grows
//   with the age of the reference; after that it is used with inflated noise.
// * Is the reference itself wrong? Evidence. For each candidate field the time for which it was measured is summed, with full weight while
//   the body turns (which reveals a magnet that moves with the body) and less at rest. A candidate with enough evidence against the
//   reference replaces it.
#pragma once

#include "base/instant.hpp"
#include "maths/rotation.hpp"

#include <cstdint>

namespace hnav {

// sqrt(x^2 + y^2) of numbers near one: std::hypot guards against overflow at ten times the cost.
template <class R>
inline R length(R x, R y) {
    return std::sqrt(x * x + y * y);
}

// A field in navigation axes.
template <class R>
struct MeanField {
    Vector3Of<R> n;
    R horizontal() const { return length(n[0], n[1]); }
    R azimuth_rad() const { return std::atan2(n[1], n[0]); }
};

enum class FieldVerdict {
    accept,
    reject,
    inflate, // outside the gate for so long that it is used with inflated noise
    begin_inflating // for the first time: the reference is estimated again
};

// Part of a filter's state: numbers of one kind only.
template <class R>
struct MagneticReference {
    R served_s; // time for which the field agreed with the reference
    R rejected_s; // time for which it was rejected, minus what later agreement has cancelled
    R evidence_s; // for the reference
    R heading_trust_s; // for the heading, across changes of reference
    R candidate[3], candidate_evidence_s, candidate_age_s;
    R inflating; // 1: fields outside the gate are used
    R changes; // number of changes of the reference

    // The gate for a mean field over T seconds. deviation: distance of the intensities from the reference.
    template <class Options>
    FieldVerdict judge(const Options& o, R deviation, R T) {
        if (deviation <= R(o.mag_gate)) {
            inflating = 0;
            rejected_s = std::fmax(R(0), rejected_s - T);
            served_s += T;
            return FieldVerdict::accept;
        }
        if (is_within(rejected_s, std::fmin(R(o.mag_gate_max_s), R(o.mag_gate_share) * served_s))) {
            rejected_s += T;
            return FieldVerdict::reject;
        }
        if (inflating > 0) return FieldVerdict::inflate;
        inflating = 1;
        served_s = rejected_s = 0;
        return FieldVerdict::begin_inflating;
    }

    // Gathers evidence. horizontal, down: the reference.
    template <class Options>
    void weigh(const Options& o, const MeanField<R>& field, R horizontal, R down, bool turning, R T) {
        const R seen_s = T * (turning ? 1 : R(o.still_weight));
        const R h = field.horizontal(), z = field.n[2];
        if (length(h - horizontal, z - down) < R(o.mag_gate)) {
            evidence_s += seen_s;
            heading_trust_s += seen_s;
        }
        Eigen::Map<Vector3Of<R>> mean(candidate);
        if (candidate_age_s > 0 && length(h - candidate_horizontal(), z - mean[2]) < R(o.candidate_radius) * candidate_unit()) {
            candidate_evidence_s += seen_s;
            candidate_age_s += T;
            mean += std::fmax(T / R(o.candidate_mean_s), T / candidate_age_s) * (field.n - mean);
        } else {
            mean = field.n;
            candidate_evidence_s = 0;
            candidate_age_s = T;
        }
        // A candidate that agrees with the reference is no alternative to it.
        if (length(candidate_horizontal() - horizontal, mean[2] - down) <= R(o.mag_gate)) candidate_evidence_s = 0;
    }

    template <class Options>
    bool candidate_wins(const Options& o) const {
        return has_passed(candidate_evidence_s, std::fmax(R(o.candidate_first_s), R(o.candidate_share) * evidence_s));
    }

    // Share of the candidate's azimuth by which the heading turns when the candidate wins: 0 for a heading that was confirmed for long, 1
    // for a new one.
    template <class Options>
    R distrust(const Options& o, R heading_variance) const {
        const R azimuth = candidate_azimuth_rad();
        const bool small = azimuth * azimuth <= R(o.turn_sigmas) * R(o.turn_sigmas) * heading_variance ||
                           std::fabs(azimuth) <= R(o.turn_min_rad);
        return small ? 0 : 1 - std::fmin(R(1), heading_trust_s / R(o.trust_s));
    }

    // The candidate becomes the reference.
    void take_candidate() {
        evidence_s = candidate_evidence_s;
        served_s = rejected_s = inflating = 0;
        ++changes;
    }

    // A reference that was estimated inside a shield or beside a magnet is not that of the Earth; on Earth intensities differ by less than
    // this factor.
    static bool is_another_unit(R strength) { return strength >= 4 || (strength <= R(0.25) && strength > 0); }
    // Properties of the candidate, and the unit of the field if it wins.
    R candidate_unit() const {
        const R strength = length(candidate_horizontal(), candidate[2]);
        return is_another_unit(strength) ? strength : 1;
    }

    R candidate_horizontal() const { return length(candidate[0], candidate[1]); }
    R candidate_azimuth_rad() const { return std::atan2(candidate[1], candidate[0]); }
};

} // namespace hnav
