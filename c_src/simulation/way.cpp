#include "simulation/way.hpp"

#include "base/memory.hpp"

#include <algorithm>
#include <cmath>

namespace hnav {
namespace {

// Value and two derivatives at both ends of [0, 1].
template <class T>
struct End {
    T value, slope, curve;
};

template <class T>
End<T> fifth_order(const End<T>& from, const End<T>& to, double x) {
    const T step = to.value - from.value - from.slope - 0.5 * from.curve, turn = to.slope - from.slope - from.curve,
            bend = to.curve - from.curve;
    const T c3 = 10 * step - 4 * turn + 0.5 * bend, c4 = -15 * step + 7 * turn - bend, c5 = 6 * step - 3 * turn + 0.5 * bend;
    return {from.value + x * (from.slope + x * (0.5 * from.curve + x * (c3 + x * (c4 + x * c5)))),
            from.slope + x * (from.curve + x * (3 * c3 + x * (4 * c4 + x * 5 * c5))),
            from.curve + x * (6 * c3 + x * (12 * c4 + x * 20 * c5))};
}

bool is_finite(const hnav_way_point& p) {
    return std::isfinite(p.t_s) && std::isfinite(p.north_m) && std::isfinite(p.east_m) && std::isfinite(p.up_m);
}

Way::Fault fault_of(const hnav_way_point* points, std::size_t i) {
    const hnav_way_point& p = points[i];
    if (!is_finite(p)) return Way::Fault::not_finite;
    if (std::hypot(p.north_m, p.east_m) > Way::farthest_m || std::fabs(p.up_m) > Way::farthest_m) return Way::Fault::too_far;
    if (i > 0 && !(p.t_s - points[i - 1].t_s >= Way::shortest_s)) return Way::Fault::times;
    return Way::Fault::none;
}

} // namespace

Way::~Way() { release_block(nodes_); }

Way::Made Way::make(const earth::Place& start, const hnav_way_point* points, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i)
        if (const Fault fault = fault_of(points, i); fault != Fault::none) return {fault, i + 1};
    if (count < 2) return {Fault::no_length, count};
    if (count > PTRDIFF_MAX / sizeof(Node)) return {Fault::no_memory, 0};
    nodes_ = static_cast<Node*>(take_block(count * sizeof(Node)));
    if (!nodes_) return {Fault::no_memory, 0};
    count_ = count;
    place(start, points);
    measure();
    if (!(nodes_[count_ - 1].u > 0)) return {Fault::no_length, count};
    lean();
    return check(earth::position_of(start));
}

// North and east are measured in the horizontal plane of the start, height along the vertical of the point.
void Way::place(const earth::Place& start, const hnav_way_point* points) {
    const Vector3 start_e = earth::position_of(start);
    const Matrix3 level = earth::axes_at(start);
    for (std::size_t i = 0; i < count_; ++i) {
        const hnav_way_point& p = points[i];
        earth::Place there = earth::place_of(start_e + level * Vector3(p.north_m, p.east_m, 0));
        there.height_m = start.height_m + p.up_m;
        nodes_[i].s = p.t_s;
        nodes_[i].position = earth::position_of(there) - start_e;
    }
}

// Intersection of the vertical of the place with the level of the start.
bool Way::seen_from(const earth::Place& start, const earth::Place& place, hnav_way_point* point) {
    const Matrix3 level = earth::axes_at(start);
    const Vector3 down = earth::axes_at(place).col(2), below = level.col(2);
    const double along = down.dot(below);
    if (!(along > 0.01)) return false;
    const Vector3 off = earth::position_of({place.latitude_rad, place.longitude_rad, start.height_m}) - earth::position_of(start);
    const Vector3 crossing = level.transpose() * (off - off.dot(below) / along * down);
    point->north_m = crossing[0];
    point->east_m = crossing[1];
    point->up_m = place.height_m - start.height_m;
    return true;
}

// The parameter and its rate at the points: the harmonic mean is at most twice the slower of both sides, which keeps the parameter
// increasing, and 0 beside a rest.
void Way::measure() {
    const auto speed = [this](std::size_t i) { return (nodes_[i + 1].u - nodes_[i].u) / (nodes_[i + 1].s - nodes_[i].s); };
    for (std::size_t i = 1; i < count_; ++i) {
        const double length = (nodes_[i].position - nodes_[i - 1].position).norm();
        if (length < same_m) nodes_[i].position = nodes_[i - 1].position;
        nodes_[i].u = nodes_[i - 1].u + (length < same_m ? 0 : length);
    }
    for (std::size_t i = 0; i < count_; ++i) {
        const double before = speed(i > 0 ? i - 1 : 0), after = speed(i + 1 < count_ ? i : count_ - 2);
        nodes_[i].rate = before > 0 && after > 0 ? 2 * before * after / (before + after) : 0;
    }
}

// The next point at another position, in steps of 1 or -1; i itself if there is none.
std::size_t Way::farther(std::size_t i, int step) const {
    std::size_t k = i;
    while (nodes_[k].u == nodes_[i].u) {
        if (step < 0 ? k == 0 : k + 1 == count_) return i;
        k += static_cast<std::size_t>(step);
    }
    return k;
}

// Tangents and bends are those of the parabola through a point and both its neighbours; a path begins and ends straight.
void Way::lean() {
    for (std::size_t i = 0; i < count_; ++i) {
        Node& n = nodes_[i];
        if (i > 0 && n.u == nodes_[i - 1].u) {
            n.tangent = nodes_[i - 1].tangent;
            n.bend = nodes_[i - 1].bend;
            continue;
        }
        const Node &before = nodes_[farther(i, -1)], &after = nodes_[farther(i, 1)];
        const double h0 = n.u - before.u, h1 = after.u - n.u;
        const Vector3 c0 = h0 > 0 ? Vector3((n.position - before.position) / h0) : Vector3::Zero();
        const Vector3 c1 = h1 > 0 ? Vector3((after.position - n.position) / h1) : Vector3::Zero();
        const bool inside = h0 > 0 && h1 > 0;
        n.tangent = inside ? Vector3((h1 * c0 + h0 * c1) / (h0 + h1)) : Vector3(c0 + c1);
        n.bend = inside ? Vector3(2 / (h0 + h1) * (c1 - c0)) : Vector3::Zero();
    }
}

// A body that points along its path needs a path with a direction that is not straight up.
Way::Made Way::check(const Vector3& start_e) const {
    constexpr double slowest = 0.1, least_level = 0.1;
    constexpr int parts = 16;
    for (std::size_t i = 1; i < count_; ++i)
        for (int k = 0; k <= parts; ++k) {
            const double s = nodes_[i - 1].s + (nodes_[i].s - nodes_[i - 1].s) * k / parts;
            const At seen = between(nodes_[i - 1], nodes_[i], s);
            const double length = seen.tangent.norm();
            if (!(length > slowest)) return {Fault::turns_back, i + (2 * k > parts)};
            const Vector3 down = earth::axes_at(earth::place_of(start_e + seen.position)).col(2);
            if (!(down.cross(seen.tangent).norm() > least_level * length)) return {Fault::too_steep, i};
        }
    return {Fault::none, 0};
}

Way::At Way::between(const Node& from, const Node& to, double s) const {
    const double T = to.s - from.s, length = to.u - from.u;
    if (!(length > 0)) return {from.position, from.tangent, from.bend, 0, 0};
    const End<double> u =
        fifth_order<double>({from.u, T * from.rate, 0}, {to.u, T * to.rate, 0}, std::clamp((s - from.s) / T, 0.0, 1.0));
    const double square = length * length;
    const End<Vector3> r =
        fifth_order<Vector3>({from.position, length * from.tangent, square * from.bend},
                             {to.position, length * to.tangent, square * to.bend}, (u.value - from.u) / length);
    return {r.value, r.slope / length, r.curve / square, u.slope / T, u.curve / (T * T)};
}

Way::At Way::at(double s) const {
    const Node &first = nodes_[0], &last = nodes_[count_ - 1];
    for (const Node* end : {&first, &last})
        if (end == &first ? s <= first.s : s >= last.s)
            return {end->position + end->tangent * (end->rate * (s - end->s)), end->tangent, Vector3::Zero(), end->rate, 0};
    const Node* after = std::upper_bound(nodes_, nodes_ + count_, s, [](double value, const Node& n) { return value < n.s; });
    return between(after[-1], *after, s);
}

} // namespace hnav
