#include "ins/circle.hpp"

#include <cmath>
#include <utility>

namespace hnav::ins {
namespace {

// Minus the logarithm of a density on the circle: half the squared distance of u(alpha) from m, normalised by S, plus that of
// alpha from an external heading, normalised by its variance.
struct Distance {
    double m[2], i00, i01, i11;
    double external_rad, information, offset; // information 0: there is no external heading

    double at(double alpha) const {
        const double x = std::cos(alpha) - m[0], y = std::sin(alpha) - m[1], off = std::remainder(alpha - external_rad, 2 * M_PI);
        return 0.5 * (i00 * x * x + 2 * i01 * x * y + i11 * y * y + information * off * off) + offset;
    }
    void derivatives(double alpha, double* first, double* second) const {
        const double c = std::cos(alpha), s = std::sin(alpha), x = c - m[0], y = s - m[1];
        const double gx = i00 * x + i01 * y, gy = i01 * x + i11 * y;
        *first = -gx * s + gy * c + information * std::remainder(alpha - external_rad, 2 * M_PI);
        *second = i00 * s * s - 2 * i01 * s * c + i11 * c * c - gx * c - gy * s + information;
    }
};

struct Mode {
    double alpha, distance, width;
};

constexpr int grid = 128;
constexpr double step = 2 * M_PI / grid;

// The distance is a harmonic of second order with at most two minima. The grid finds both; Newton's method refines them.
Mode sharpened(const Distance& distance, double alpha) {
    const double from = alpha;
    double first, second;
    for (int i = 0; i < 6; ++i) {
        distance.derivatives(alpha, &first, &second);
        if (!(second > 0)) break;
        alpha -= std::fmax(-0.5 * step, std::fmin(0.5 * step, first / second));
    }
    if (!(std::fabs(alpha - from) <= 1.5 * step)) alpha = from;
    distance.derivatives(alpha, &first, &second);
    const double width = second > 0 ? 1 / std::sqrt(second) : M_PI;
    return {alpha, distance.at(alpha), width};
}

// One density with its two highest modes, the higher one first.
struct Part {
    Distance distance;
    Mode modes[2];
    int count = 0;

    explicit Part(const Distance& of) : distance(of) {
        double value[grid];
        for (int k = 0; k < grid; ++k) value[k] = distance.at(k * step);
        for (int k = 0; k < grid; ++k)
            if (value[k] < value[(k + grid - 1) % grid] && value[k] <= value[(k + 1) % grid]) add(sharpened(distance, k * step));
        if (count == 0) add({distance.information > 0 ? distance.external_rad : 0, distance.at(0), M_PI});
    }
    void add(const Mode& mode) {
        if (count == 2 && !(mode.distance < modes[1].distance)) return;
        modes[count < 2 ? count++ : 1] = mode;
        if (count == 2 && modes[1].distance < modes[0].distance) std::swap(modes[0], modes[1]);
    }
    double broadest() const { return count == 2 ? std::fmax(modes[0].width, modes[1].width) : modes[0].width; }
};

// Probability mass of each mode and second moment about the first mode, summed over grids. A point belongs to the nearest mode.
struct Moments {
    Mode modes[2]; // of all parts
    int count;
    double mass[2] = {0, 0}, square = 0, chord[3] = {0, 0, 0};

    void add(const Part& part) {
        if (part.broadest() > 0.1) return add(part.distance, 0, M_PI, 2 * grid);
        for (int k = 0; k < part.count; ++k) add(part.distance, part.modes[k].alpha, 8 * part.modes[k].width, 64);
    }
    void add(const Distance& distance, double centre, double half_width, int points) {
        const double width = 2 * half_width / points;
        for (int k = 0; k < points; ++k) {
            const double alpha = centre - half_width + (k + 0.5) * width;
            const double off = std::remainder(alpha - modes[0].alpha, 2 * M_PI);
            const bool second = count == 2 && std::fabs(std::remainder(alpha - modes[1].alpha, 2 * M_PI)) < std::fabs(off);
            const double p = std::exp(modes[0].distance - distance.at(alpha)) * width;
            mass[second] += p;
            square += p * off * off;
            const double x = std::cos(off) - 1, y = std::sin(off);
            chord[0] += p * x * x;
            chord[1] += p * x * y;
            chord[2] += p * y * y;
        }
    }
};

// The highest mode of both parts, and the next highest one that is not the same mode as it appears in the other part.
Moments about(const Part& wrong, const Part& right) {
    Moments moments;
    const Part& first = right.modes[0].distance < wrong.modes[0].distance ? right : wrong;
    moments.modes[0] = first.modes[0];
    moments.count = 1;
    for (const Part* part : {&wrong, &right})
        for (int k = 0; k < part->count; ++k) {
            const Mode& mode = part->modes[k];
            const double off = std::fabs(std::remainder(mode.alpha - first.modes[0].alpha, 2 * M_PI));
            const bool same = part != &first && off < std::fmin(0.5 * M_PI, 3 * (mode.width + first.modes[0].width));
            if (&mode == &first.modes[0] || same || (moments.count == 2 && !(mode.distance < moments.modes[1].distance)))
                continue;
            moments.modes[1] = mode;
            moments.count = 2;
        }
    return moments;
}

} // namespace

// Probability that an external heading is wrong by any angle. It limits the weight of external headings against motion to a dozen
// nats. Chosen: with a larger value the uniform part alone would spread a correct heading by more than heading_found_rad.
constexpr double wrong_share = 1e-4;

Circle heading_on_circle(const double* m, const double S[2][2], const ExternalHeading& external) {
    const double determinant = S[0][0] * S[1][1] - S[0][1] * S[0][1];
    if (!(determinant > 0)) return {std::atan2(m[1], m[0]), 0, 0, 0, {0, 0, 0}};
    const double likelihood =
        (1 - wrong_share) / wrong_share * std::sqrt(2 * M_PI * external.information); // relative to the uniform part
    Distance distance{
        {m[0], m[1]}, S[1][1] / determinant, -S[0][1] / determinant, S[0][0] / determinant, external.alpha_rad, 0, 0};
    const Part wrong(distance);
    distance.information = external.information;
    distance.offset = -std::log(likelihood);
    const Part right = external.information > 0 ? Part(distance) : wrong;
    Moments moments = about(wrong, right);
    moments.add(wrong);
    if (external.information > 0) moments.add(right);
    const double mass = moments.mass[0] + moments.mass[1];
    const double second_rad = moments.count == 2 ? std::remainder(moments.modes[1].alpha, 2 * M_PI) : 0;
    const double* c = moments.chord;
    return {std::remainder(moments.modes[0].alpha, 2 * M_PI),
            std::sqrt(moments.square / mass),
            second_rad,
            moments.mass[1] / mass,
            {c[0] / mass, c[1] / mass, c[2] / mass}};
}

} // namespace hnav::ins
