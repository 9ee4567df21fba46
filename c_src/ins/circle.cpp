#include "ins/circle.hpp"

#include <cmath>
#include <utility>

namespace hnav::ins {
namespace {

// Half the squared distance of u(alpha) from m, in units of S, and its derivatives.
struct Distance {
    double m[2], i00, i01, i11;

    double at(double alpha) const {
        const double x = std::cos(alpha) - m[0], y = std::sin(alpha) - m[1];
        return 0.5 * (i00 * x * x + 2 * i01 * x * y + i11 * y * y);
    }
    void derivatives(double alpha, double* first, double* second) const {
        const double c = std::cos(alpha), s = std::sin(alpha), x = c - m[0], y = s - m[1];
        const double gx = i00 * x + i01 * y, gy = i01 * x + i11 * y;
        *first = -gx * s + gy * c;
        *second = i00 * s * s - 2 * i01 * s * c + i11 * c * c - gx * c - gy * s;
    }
};

struct Mode {
    double alpha, distance, width;
};

constexpr int grid = 128;
constexpr double step = 2 * M_PI / grid;

// A harmonic of second order has at most two minima, and a grid of this kind sees both; Newton sharpens them.
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

int find_modes(const Distance& distance, Mode* modes) {
    double value[grid];
    for (int k = 0; k < grid; ++k) value[k] = distance.at(k * step);
    int count = 0;
    for (int k = 0; k < grid && count < 2; ++k)
        if (value[k] < value[(k + grid - 1) % grid] && value[k] <= value[(k + 1) % grid])
            modes[count++] = sharpened(distance, k * step);
    if (count == 0) modes[count++] = {0, distance.at(0), M_PI};
    if (count == 2 && modes[1].distance < modes[0].distance) std::swap(modes[0], modes[1]);
    return count;
}

// Masses of the modes and the second moment about the first, over a grid about `centre`; points belong to the nearest mode.
struct Moments {
    double mass[2] = {0, 0}, square = 0, chord[3] = {0, 0, 0};

    void add(const Distance& distance, const Mode* modes, int count, double centre, double half_width, int points) {
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

} // namespace

Circle heading_on_circle(const double* m, const double S[2][2]) {
    const double determinant = S[0][0] * S[1][1] - S[0][1] * S[0][1];
    if (!(determinant > 0)) return {std::atan2(m[1], m[0]), 0, 0, 0, {0, 0, 0}};
    const Distance distance{{m[0], m[1]}, S[1][1] / determinant, -S[0][1] / determinant, S[0][0] / determinant};
    Mode modes[2];
    const int count = find_modes(distance, modes);
    Moments moments;
    const double broadest = count == 2 ? std::fmax(modes[0].width, modes[1].width) : modes[0].width;
    if (broadest > 0.1) {
        moments.add(distance, modes, count, 0, M_PI, 2 * grid);
    } else {
        for (int k = 0; k < count; ++k) moments.add(distance, modes, count, modes[k].alpha, 8 * modes[k].width, 64);
    }
    const double mass = moments.mass[0] + moments.mass[1];
    const double second_rad = count == 2 ? std::remainder(modes[1].alpha, 2 * M_PI) : 0;
    const double* c = moments.chord;
    return {std::remainder(modes[0].alpha, 2 * M_PI),
            std::sqrt(moments.square / mass),
            second_rad,
            moments.mass[1] / mass,
            {c[0] / mass, c[1] / mass, c[2] / mass}};
}

} // namespace hnav::ins
