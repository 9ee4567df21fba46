// A way through points that are met at their times. Velocity and acceleration are continuous.
//
// Two things of fifth order between neighbouring points: the curve r(u), whose parameter u grows by the distance of the points, and
// u(t), which never runs back and does not move where a point comes twice. So a body that stops keeps its direction. Before the first
// point and after the last the body goes straight on.
#pragma once

#include "hnav/simulation.h"
#include "maths/earth.hpp"

#include <cstddef>

namespace hnav {

class Way {
public:
    // What is wrong with points, if anything; point: the one behind it, from 1 on.
    enum class Fault { none, no_memory, not_finite, too_far, times, no_length, turns_back, too_steep };
    struct Made {
        Fault fault;
        std::size_t point;
    };
    // In Earth-fixed axes; tangent and bend are the derivatives by u, which the time changes by rate and its derivative.
    struct At {
        Vector3 position, tangent, bend;
        double rate, gain;
    };

    Way() = default;
    Way(const Way&) = delete;
    Way& operator=(const Way&) = delete;
    ~Way();

    // start: the place that the points tell their distance from.
    Made make(const earth::Place& start, const hnav_way_point* points, std::size_t count);
    explicit operator bool() const { return count_ > 0; }
    // position: from the start.
    At at(double s) const;
    // How far a place lies from a start, north, east and up, as points tell it; false: on the other side of the globe.
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
