// A path that passes points at given times. Velocity and acceleration are continuous.
//
// Two quintic curves between neighbouring points: the path r(u), whose parameter u grows by the distance of the points, and
// u(t), which never decreases and rests at a repeated point. A body that stops therefore keeps its direction. Before the first
// point and after the last the body moves straight on.
#pragma once

#include "hnav/simulation.h"
#include "maths/earth.hpp"

#include <cstddef>

namespace hnav {

class Way {
public:
    // Error of the points, if any; point: the one concerned, from 1 on.
    enum class Fault { none, no_memory, not_finite, too_far, times, no_length, turns_back, too_steep };
    struct Made {
        Fault fault;
        std::size_t point;
    };
    // In Earth-fixed axes; tangent and bend are the derivatives by u, which changes with time by rate and its derivative.
    struct At {
        Vector3 position, tangent, bend;
        double rate, gain;
    };

    Way() = default;
    Way(const Way&) = delete;
    Way& operator=(const Way&) = delete;
    ~Way();

    // start: the place from which the points are measured.
    Made make(const earth::Place& start, const hnav_way_point* points, std::size_t count);
    explicit operator bool() const { return count_ > 0; }
    // position: from the start.
    At at(double s) const;
    // Displacement of a place from a start, north, east and up, as in points; false: on the other side of the globe.
    static bool seen_from(const earth::Place& start, const earth::Place& place, hnav_way_point* point);

    static constexpr double shortest_s = 1e-3, farthest_m = 1e6, same_m = 1e-3;

private:
    struct Node {
        double s, u, rate;
        Vector3 position, tangent, bend;
    };

    void place(const earth::Place& start, const hnav_way_point* points);
    void measure();
    void lean();
    Made check(const Vector3& start_e) const;
    std::size_t farther(std::size_t i, int step) const;
    At between(const Node& from, const Node& to, double s) const;

    Node* nodes_ = nullptr;
    std::size_t count_ = 0;
};

} // namespace hnav
