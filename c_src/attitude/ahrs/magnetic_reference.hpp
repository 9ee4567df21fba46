// Which magnetic field to believe in.
//
// The filter steers by a reference field (horizontal and vertical intensity; its azimuth is north by definition). A magnet
// nearby, or a start in a distorted place, makes the field disagree with it. Two questions are answered here from the
// field in navigation axes, as the filter sees it, and from time alone:
//
// * May this field correct the heading? The gate. A field whose intensities lie away from the reference is turned away,
//   for a time that grows with the time for which the reference has served; after that the filter gives in, softly.
// * Is the reference itself the odd one out? Evidence. Each field that comes by gathers the time for which it was seen,
//   counted fully while the body turns (a magnet that moves with the body then shows) and less at rest. When a candidate
//   has gathered enough against the reference, it takes its place.
#pragma once

#include "maths/rotation.hpp"

#include <cstdint>

namespace hnav {

struct MagneticReferenceSettings {
    double gate;            // distance of the intensities, in units of the field
    double gate_longest_s;  // a field is turned away no longer than this
    double gate_share;      // ... and no longer than this multiple of the time for which the reference served
    double turning_rad_s;   // the body turns
    double still_weight;    // of a second at rest, as evidence
    double candidate_radius; // fields within it of the candidate are the candidate
    double candidate_mean_s; // the candidate is a mean over this time
    double candidate_first_s; // evidence to take the place of a reference that has none
    double candidate_share;  // ... else this share of the reference's evidence
    double trust_s;          // evidence after which the heading is not given up for a new field
    double heading_least_rad; // smaller changes of azimuth do not turn the heading
    double heading_sigmas;    // nor those within so many sigma
    double heading_added_rad; // sigma added to a heading that was turned
};

// sqrt(x^2 + y^2) of numbers near one: std::hypot guards against overflow at ten times the cost.
inline double length(double x, double y) { return std::sqrt(x * x + y * y); }

// A field in navigation axes.
struct MeanField {
    Vector3 n;
    double horizontal() const { return length(n[0], n[1]); }
    double azimuth_rad() const { return std::atan2(n[1], n[0]); }
};

// Part of a filter's state: doubles only.
struct MagneticReference {
    double served_s;    // time for which the field agreed with the reference
    double refused_s;   // time for which it was turned away, less what has been forgiven
    double evidence_s;  // for the reference
    double heading_trust_s; // for the heading, whatever reference it came from
    double candidate[3], candidate_evidence_s, candidate_age_s;
    double given_in; // 1: the gate is open although the field lies outside
    double adopted;  // references taken, the first not counted

    enum class Verdict { accept, refuse, give_in, give_in_now };

    // The gate for a mean field that stands for T seconds. deviation: distance of the intensities from the reference.
    Verdict judge(const MagneticReferenceSettings& set, double deviation, double T) {
        if (deviation <= set.gate) {
            given_in = 0;
            refused_s = std::fmax(0, refused_s - T);
            served_s += T;
            return Verdict::accept;
        }
        if (refused_s < std::fmin(set.gate_longest_s, set.gate_share * served_s)) {
            refused_s += T;
            return Verdict::refuse;
        }
        if (given_in > 0) return Verdict::give_in;
        given_in = 1;
        served_s = refused_s = 0;
        return Verdict::give_in_now;
    }

    // Gathers evidence. horizontal, down: the reference.
    void weigh(const MagneticReferenceSettings& set, const MeanField& field, double horizontal, double down, bool turning,
               double T) {
        const double seen_s = T * (turning ? 1 : set.still_weight);
        const double h = field.horizontal(), z = field.n[2];
        if (length(h - horizontal, z - down) < set.gate) {
            evidence_s += seen_s;
            heading_trust_s += seen_s;
        }
        Eigen::Map<Vector3> mean(candidate);
        if (candidate_age_s > 0 && length(h - candidate_horizontal(), z - mean[2]) < set.candidate_radius) {
            candidate_evidence_s += seen_s;
            candidate_age_s += T;
            mean += std::fmax(T / set.candidate_mean_s, T / candidate_age_s) * (field.n - mean);
        } else {
            mean = field.n;
            candidate_evidence_s = 0;
            candidate_age_s = T;
        }
    }

    bool candidate_wins(const MagneticReferenceSettings& set, double horizontal, double down) const {
        const double needed_s = std::fmax(set.candidate_first_s, set.candidate_share * evidence_s);
        return candidate_evidence_s > needed_s && length(candidate_horizontal() - horizontal, candidate[2] - down) > set.gate;
    }

    // Share of the candidate's azimuth by which the heading is held to be wrong, when the candidate wins: none for a
    // heading that has been confirmed for long, all for a fresh one.
    double distrust(const MagneticReferenceSettings& set, double heading_variance) const {
        const double azimuth = candidate_azimuth_rad();
        const bool small = azimuth * azimuth <= set.heading_sigmas * set.heading_sigmas * heading_variance ||
                           std::fabs(azimuth) <= set.heading_least_rad;
        return small ? 0 : 1 - std::fmin(1, heading_trust_s / set.trust_s);
    }

    // The candidate becomes the reference, whoever steers by it.
    void adopt_candidate() {
        evidence_s = candidate_evidence_s;
        served_s = refused_s = given_in = 0;
        ++adopted;
    }

    double candidate_horizontal() const { return length(candidate[0], candidate[1]); }
    double candidate_azimuth_rad() const { return std::atan2(candidate[1], candidate[0]); }
};

} // namespace hnav
