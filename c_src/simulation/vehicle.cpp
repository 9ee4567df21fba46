#include "simulation/vehicle.hpp"

#include "simulation/streams.hpp"

namespace hnav {
namespace {

const Vector3 earth_rate{0, 0, earth::rate_rad_s};

// Streams of a vehicle. A separate stream: the course at the start.
enum SignalNumber {
    course_chance,
    speed_signal,
    turn_signal,
    roll_signal,
    pitch_signal,
    heave_signal,
    mean_speed_chance,
    vibrations
};

double between(double low, double high, double chance) { return low + (high - low) * chance; }

// One of so many numbers.
template <int count>
double one_of(const double (&numbers)[count], double chance) {
    return numbers[static_cast<int>(count * chance)];
}

// In n axes x, y, z of a rotation by roll, then pitch, then course: columns are the body's.
Matrix3 turned(double roll, double pitch, double course) {
    const double cr = std::cos(roll), sr = std::sin(roll), cp = std::cos(pitch), sp = std::sin(pitch), cy = std::cos(course),
                 sy = std::sin(course);
    Matrix3 R;
    R << cp * cy, sr * sp * cy - cr * sy, cr * sp * cy + sr * sy, //
        cp * sy, sr * sp * sy + cr * cy, cr * sp * sy - sr * cy,  //
        -sp, sr * cp, cr * cp;
    return R;
}

} // namespace

Vehicle::Vehicle(const hnav_vehicle_options& o, double start_s)
    : kind_(static_cast<hnav_vehicle_kind>(o.kind)),
      seed_(static_cast<std::uint64_t>(o.seed)),
      start_s_(start_s),
      sway_(o.sway),
      vibration_m_s2_(o.vibration_m_s2),
      mean_over_s_(o.mean_over_s),
      start_place_{o.latitude_rad, o.longitude_rad, o.height_m} {
    axes_e_ = earth::axes_at(start_place_);
    position_e_ = earth::position_of(start_place_);
    course_rad_ = o.heading_rad + o.heading_unknown_rad * (2 * stream(course_chance).uniform(0) - 1);
    const double dip = o.field_dip_rad, declination = o.declination_rad;
    field_n_ = o.field_strength_tesla *
               Vector3(std::cos(dip) * std::cos(declination), std::cos(dip) * std::sin(declination), std::sin(dip));
}

// ------------------------------------------------------------------------------------------------ signals

RandomStream Vehicle::stream(int signal) const { return {seed_, streams::vehicle + static_cast<std::uint64_t>(signal)}; }

Vehicle::Signal Vehicle::stairs(double s, int signal, const Stairs& stairs) const {
    const RandomStream random = stream(signal);
    // Numbers of a level: two words of its block for the level, one for the time at which it begins. Indices before the start
    // exist too, since a mean reaches back.
    const auto chance = [&](double k, unsigned word) { return random.uniform(4 * static_cast<std::uint64_t>(k + 4) + word); };
    const auto begin_s = [&](double k) { return stairs.mean_s * k + stairs.spread_s * (2 * chance(k, 2) - 1); };
    const auto level = [&](double k) { return stairs.level(chance(k, 0), chance(k, 1)); };
    double k = std::floor(s / stairs.mean_s) + 1;
    while (begin_s(k) > s) k -= 1;
    const double x = (s - begin_s(k)) / stairs.blend_s, to = level(k);
    if (x >= 1) return {to, 0};
    const double step = to - level(k - 1); // of fifth order: two derivatives vanish at both ends
    return {to - step * (1 - x * x * x * (10 + x * (6 * x - 15))), step * 30 * x * x * (1 - x) * (1 - x) / stairs.blend_s};
}

// A sum of sines from a tenth of a hertz to several hertz, times haste.
Vehicle::Signal Vehicle::sway(double s, int signal, double size, double haste) const {
    const RandomStream random = stream(signal);
    constexpr double hertz[] = {0.15, 0.4, 1.1, 3.0};
    Signal sum{0, 0};
    for (unsigned i = 0; i < 4; ++i) {
        const double w = 2 * M_PI * haste * hertz[i], phase = 2 * M_PI * random.uniform(i);
        const double amplitude = sway_ * size * between(0.5, 1.5, random.uniform(4 + i));
        sum.value += amplitude * std::sin(w * s + phase);
        sum.rate += amplitude * w * std::cos(w * s + phase);
    }
    return sum;
}

// Sines of random phase; their derivative of this order, first or second, has the given root mean square.
Vehicle::Signal Vehicle::vibration(double s, int signal, int order) const {
    const RandomStream random = stream(vibrations + signal);
    constexpr double hertz[] = {11.3, 19.7, 31.1, 43.9};
    Signal sum{0, 0};
    for (unsigned i = 0; i < 4; ++i) {
        const double w = 2 * M_PI * hertz[i], phase = 2 * M_PI * random.uniform(i);
        const double amplitude = vibration_m_s2_ / std::sqrt(2.0) / (order == 1 ? w : w * w);
        sum.value += amplitude * std::sin(w * s + phase);
        sum.rate += amplitude * w * std::cos(w * s + phase);
    }
    return sum;
}

// One sine of random amplitude, period and phase.
Vehicle::Signal Vehicle::wave(double s, int signal, double low, double high, double shortest_s, double longest_s) const {
    const RandomStream random = stream(signal);
    const double amplitude = sway_ * between(low, high, random.uniform(0)), phase = 2 * M_PI * random.uniform(1);
    const double w = 2 * M_PI / between(shortest_s, longest_s, random.uniform(2));
    return {amplitude * std::sin(w * s + phase), amplitude * w * std::cos(w * s + phase)};
}

// ------------------------------------------------------------------------------------------------ kinds

Vehicle::Motion Vehicle::motion(double s) const {
    Motion m = of_kind(s);
    if (!(vibration_m_s2_ > 0)) return m;
    Signal* const shaken[] = {&m.speed, &m.heave, &m.roll, &m.pitch};
    for (int i = 0; i < 4; ++i) {
        const Signal more = vibration(s, i, i < 2 ? 1 : 2);
        shaken[i]->value += more.value;
        shaken[i]->rate += more.rate;
    }
    return m;
}

Vehicle::Motion Vehicle::of_kind(double s) const {
    switch (kind_) {
    case HNAV_VEHICLE_CAR: return car(s);
    case HNAV_VEHICLE_AIRCRAFT: return aircraft(s);
    case HNAV_VEHICLE_SHIP: return ship(s);
    default: return rest(s);
    }
}

// Stops, starts and turns as in a town.
Vehicle::Motion Vehicle::car(double s) const {
    Motion m{};
    constexpr auto speed = [](double first, double) {
        constexpr double levels[] = {0, 4, 8, 12, 15};
        return one_of(levels, first);
    };
    constexpr auto turn = [](double first, double second) {
        constexpr double sides[] = {0, 0, 0, 1, -1};
        return one_of(sides, first) * between(0.1, 0.35, second);
    };
    m.speed = stairs(s, speed_signal, {13, 3.5, 6, speed});
    // Turns and sways in proportion to speed; no motion at rest.
    const double v = m.speed.value, size = std::sqrt(v * v + 25);
    const Signal moving{v / size, m.speed.rate * 25 / (size * size * size)};
    const auto while_moving = [&](const Signal& a) {
        return Signal{a.value * moving.value, a.rate * moving.value + a.value * moving.rate};
    };
    m.turn_rad_s = stairs(s, turn_signal, {5.5, 1.25, 2, turn}).value * moving.value;
    m.roll = while_moving(sway(s, roll_signal, 0.004, 0.3));
    m.pitch = while_moving(sway(s, pitch_signal, 0.004, 0.3));
    return m;
}

// Banks into its turns, climbs and sinks.
Vehicle::Motion Vehicle::aircraft(double s) const {
    Motion m{};
    constexpr auto change = [](double first, double) { return between(-5, 5, first); };
    constexpr auto bank = [](double first, double second) {
        constexpr double sides[] = {0, 0, 1, -1};
        return one_of(sides, first) * between(0.1, 0.6, second);
    };
    constexpr auto pitch = [](double first, double) { return between(-0.1, 0.15, first); };
    m.speed = stairs(s, speed_signal, {20, 5, 6, change});
    m.speed.value += between(25, 85, stream(mean_speed_chance).uniform(0));
    m.roll = stairs(s, roll_signal, {19, 5.5, 4, bank});
    m.pitch = m.climb = stairs(s, pitch_signal, {17.5, 3.75, 6, pitch});
    m.turn_rad_s = earth::standard_gravity_m_s2 * std::tan(m.roll.value) / m.speed.value;
    return m;
}

// Slow, in a swell.
Vehicle::Motion Vehicle::ship(double s) const {
    Motion m{};
    constexpr auto speed = [](double first, double) { return between(2, 9, first); };
    constexpr auto turn = [](double first, double second) {
        constexpr double sides[] = {0, 1, -1};
        return one_of(sides, first) * between(0.01, 0.04, second);
    };
    m.speed = stairs(s, speed_signal, {60, 15, 30, speed});
    m.turn_rad_s = stairs(s, turn_signal, {40, 10, 10, turn}).value;
    m.roll = wave(s, roll_signal, 0.02, 0.12, 7, 12);
    m.pitch = wave(s, pitch_signal, 0.01, 0.05, 5, 9);
    m.heave = wave(s, heave_signal, 0.2, 0.6, 7, 9);
    return m;
}

// Rests on a support that sways by millimetres.
Vehicle::Motion Vehicle::rest(double s) const {
    Motion m{};
    m.speed = sway(s, speed_signal, 2e-3, 1);
    m.roll = sway(s, roll_signal, 3e-4, 1);
    m.pitch = sway(s, pitch_signal, 3e-4, 1);
    m.turn_rad_s = sway(s, turn_signal, 3e-4, 1).rate;
    return m;
}

// ------------------------------------------------------------------------------------------------ flow

Vector3 Vehicle::velocity_in_level(const Motion& m, double course_rad) const {
    const double ahead = m.speed.value * std::cos(m.climb.value);
    return {ahead * std::cos(course_rad), ahead * std::sin(course_rad), m.heave.value - m.speed.value * std::sin(m.climb.value)};
}

Vector3 Vehicle::level_rate(const earth::Place& place, const Matrix3& axes_n, const Vector3& velocity_e) const {
    const double sine = std::sin(place.latitude_rad), w2 = 1 - earth::eccentricity2 * sine * sine;
    const double across_m = earth::equator_m / std::sqrt(w2), along_m = across_m * (1 - earth::eccentricity2) / w2;
    const Vector3 v = axes_n.transpose() * velocity_e, start = axes_e_.col(2), down = axes_n.col(2);
    const Vector3 change =
        -v[0] / (along_m + place.height_m) * axes_n.col(0) - v[1] / (across_m + place.height_m) * axes_n.col(1);
    const auto half_way = [&](double scalar, const Vector3& d) {
        const Vector3 across = start.cross(d);
        return Quaternion{scalar + start.dot(d), across[0], across[1], across[2]};
    };
    const Quaternion q = half_way(1, down), dq = half_way(0, change);
    return 2 / q.squaredNorm() * multiply(dq, conjugate(q)).tail<3>();
}

Vehicle::State Vehicle::flow(double t_s, const State& x) const {
    if (way_) {
        const Way::At now = way_.at(t_s - start_s_);
        return {now.rate * now.tangent, 0};
    }
    const Motion m = motion(t_s - start_s_);
    const Vector3 down = earth::axes_at(earth::place_of(position_e_ + x.displacement_m)).col(2);
    return {earth::carried_axes(axes_e_, down) * velocity_in_level(m, x.course_rad), m.turn_rad_s};
}

Vehicle::State Vehicle::carry(double from_s, const State& x, double to_s) const {
    if (way_) return {way_.at(to_s - start_s_).position, x.course_rad};
    const int steps = static_cast<int>(std::ceil(std::fabs(to_s - from_s) / longest_step_s * (1 - 1e-12)));
    const auto ahead = [](const State& at, double h, const State& slope) {
        return State{at.displacement_m + h * slope.displacement_m, at.course_rad + h * slope.course_rad};
    };
    State now = x;
    for (int i = 0; i < steps; ++i) {
        const double h = (to_s - from_s) / steps, t_s = from_s + i * h;
        const State a = flow(t_s, now), b = flow(t_s + h / 2, ahead(now, h / 2, a)), c = flow(t_s + h / 2, ahead(now, h / 2, b)),
                    d = flow(t_s + h, ahead(now, h, c));
        now = ahead(ahead(ahead(ahead(now, h / 6, a), h / 3, b), h / 3, c), h / 6, d);
    }
    return now;
}

// ------------------------------------------------------------------------------------------------ truth

// It points along its path and does not bank.
Vehicle::Body Vehicle::body_on_way(double t_s) const {
    const Way::At now = way_.at(t_s - start_s_);
    Body b;
    b.position = position_e_ + now.position;
    b.place = earth::place_of(b.position);
    b.axes_n = earth::axes_at(b.place);
    b.velocity = now.rate * now.tangent;
    b.acceleration = now.rate * now.rate * now.bend + now.gain * now.tangent;

    // A unit vector and its derivative, from a vector of any length and its derivative.
    const auto unit = [](const Vector3& v, const Vector3& change, Vector3* e, Vector3* slope) {
        const double length = v.norm();
        *e = v / length;
        *slope = (change - e->dot(change) * *e) / length;
    };
    const Vector3 down = b.axes_n.col(2), falling = level_rate(b.place, b.axes_n, b.velocity).cross(down);
    Vector3 axis[3], slope[3];
    unit(now.tangent, now.rate * now.bend, &axis[0], &slope[0]);
    unit(down.cross(axis[0]), falling.cross(axis[0]) + down.cross(slope[0]), &axis[1], &slope[1]);
    axis[2] = axis[0].cross(axis[1]);
    slope[2] = slope[0].cross(axis[1]) + axis[0].cross(slope[1]);
    b.rate.setZero();
    for (int i = 0; i < 3; ++i) {
        b.axes_b.col(i) = axis[i];
        b.rate += 0.5 * axis[i].cross(slope[i]);
    }
    return b;
}

Vehicle::Body Vehicle::body(double t_s, const State& x) const {
    if (way_) return body_on_way(t_s);
    const Motion m = motion(t_s - start_s_);
    Body b;
    b.position = position_e_ + x.displacement_m;
    b.place = earth::place_of(b.position);
    b.axes_n = earth::axes_at(b.place);
    const Matrix3 level = earth::carried_axes(axes_e_, b.axes_n.col(2));
    const Vector3 in_level = velocity_in_level(m, x.course_rad);
    b.velocity = level * in_level;
    const Vector3 rate_of_level = level_rate(b.place, b.axes_n, b.velocity);

    const double cc = std::cos(m.climb.value), sc = std::sin(m.climb.value);
    const double ahead = m.speed.rate * cc - m.speed.value * sc * m.climb.rate, course = m.turn_rad_s;
    const Vector3 gained{ahead * std::cos(x.course_rad) - course * in_level[1],
                         ahead * std::sin(x.course_rad) + course * in_level[0],
                         m.heave.rate - m.speed.rate * sc - m.speed.value * cc * m.climb.rate};
    b.acceleration = level * gained + rate_of_level.cross(b.velocity);

    const double roll = m.roll.value, pitch = m.pitch.value;
    b.axes_b = level * turned(roll, pitch, x.course_rad);
    // Roll turns about body x, pitch about the axis before it, course about the vertical.
    const Vector3 own{m.roll.rate - course * std::sin(pitch),
                      m.pitch.rate * std::cos(roll) + course * std::cos(pitch) * std::sin(roll),
                      course * std::cos(pitch) * std::cos(roll) - m.pitch.rate * std::sin(roll)};
    b.rate = rate_of_level + b.axes_b * own;
    return b;
}

Vehicle::Seen Vehicle::seen(double t_s, const State& x) const {
    const Body b = body(t_s, x);
    Seen seen;
    seen.place = b.place;
    seen.velocity_n = b.axes_n.transpose() * b.velocity;
    const Matrix3 R_nb = b.axes_n.transpose() * b.axes_b;
    seen.q_nb = quaternion_from_matrix(R_nb);
    seen.field_b = R_nb.transpose() * field_n_;
    seen.rate_b = seen.force_b = Vector3::Zero();
    if (!(mean_over_s_ > 0)) {
        feel(b, 1, &seen);
        return seen;
    }
    // By Gauss quadrature with three points, whose error is 2e-4 of a vibration of 44 Hz over 10 ms. Integrating sensors miss the
    // coning part of the turn, which filters add.
    constexpr double instants[][2] = {
        {0.5 - 0.3872983346207417, 5.0 / 18}, {0.5, 8.0 / 18}, {0.5 + 0.3872983346207417, 5.0 / 18}};
    for (const auto& [back, weight] : instants) {
        const double then_s = t_s - back * mean_over_s_;
        feel(body(then_s, carry(t_s, x, then_s)), weight, &seen);
    }
    return seen;
}

// Instantaneous readings of sensors, added with a weight.
void Vehicle::feel(const Body& b, double weight, Seen* seen) const {
    seen->rate_b += weight * (b.axes_b.transpose() * (earth_rate + b.rate));
    seen->force_b +=
        weight * (b.axes_b.transpose() * (b.acceleration + 2 * earth_rate.cross(b.velocity) - earth::gravity_at(b.position)));
}

} // namespace hnav
