#include "observer/live_plants.hpp"

#include "base/hash.hpp"
#include "base/memory.hpp"
#include "base/spin_lock.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace hnav::observer {
namespace {

// Trial: Euler steps, each about a hundredth of the states, and steps to times that the plant has announced.
constexpr int steps = 40, leaps = 3;
constexpr double step = 0.01, longest_step_s = 1e-3, longest_leap_s = 10;
// Equal values, for plants whose repeated evaluations differ in their last digits.
constexpr double same = 1e-9;

template <class T>
struct Owned {
    T* object = nullptr;
    ~Owned() { end(); }
    void end() {
        if (object) object->destroy();
        object = nullptr;
    }
};

// One instance, stepped from the start of its plan.
class Walk {
public:
    // Numbers of a step: states, derivatives, sensors, statuses, time of the next event.
    static int numbers_of(const PlantSizes& sizes) { return 2 * sizes.states + sizes.outputs + 2; }
    static int answers_of(const PlantSizes& sizes) { return steps * numbers_of(sizes); }
    // Bytes of all steps, followed by the present states and inputs.
    static std::size_t bytes_of(const PlantSizes& sizes) {
        return (answers_of(sizes) + sizes.states + sizes.inputs) * sizeof(double);
    }

    Walk(FmuPlant& plant, const Plan& plan, double start_s, double* to)
        : plant_(plant),
          plan_(plan),
          t_s_(start_s),
          next_s_(plant.first_event_s()),
          answers_(to),
          x_(to + answers_of(plan.sizes)),
          u_(x_ + plan.sizes.states) {
        const PlantSizes& sizes = plan.sizes;
        std::copy_n(plan.start, sizes.states, x_);
        std::copy_n(plan.input_start, sizes.known_inputs(), u_);
        std::copy_n(plan.start + sizes.states, sizes.unknown_inputs, u_ + sizes.known_inputs());
    }

    void go_to(int until) {
        while (done_ < until) go_on();
    }

private:
    Point here() const { return {t_s_, x_, u_, plan_.start + plan_.sizes.states + plan_.sizes.unknown_inputs}; }

    void go_on() {
        const PlantSizes& sizes = plan_.sizes;
        double* out = answers_ + done_++ * numbers_of(sizes);
        if (plant_.sizes.events && (next_s_ <= t_s_ || done_ % 5 == 0)) leap();
        double *dx = out + sizes.states, *y = dx + sizes.states;
        const Answer of_dx = plant_.evaluate(Function::derivatives, here(), dx);
        const Answer of_y = plant_.evaluate(Function::outputs, here(), y);
        y[sizes.outputs] = 10 * int(of_dx) + int(of_y);
        y[sizes.outputs + 1] = next_s_;
        double h_s = longest_step_s;
        for (int i = 0; i < sizes.states; ++i)
            if (dx[i] != 0) h_s = std::min(h_s, step * std::max(std::fabs(x_[i]), plan_.nominal[i]) / std::fabs(dx[i]));
        for (int i = 0; i < sizes.states; ++i) out[i] = x_[i] += h_s * dx[i];
        const bool leaps_on = next_s_ - t_s_ < longest_leap_s && leapt_ < leaps;
        t_s_ = leaps_on ? std::max(next_s_, t_s_) : t_s_ + h_s;
    }

    void leap() {
        ++leapt_;
        if (plant_.event(here(), x_, &next_s_) != Answer::ok) next_s_ = HUGE_VAL;
    }

    FmuPlant& plant_;
    const Plan& plan_;
    double t_s_, next_s_;
    int done_ = 0, leapt_ = 0;
    double *answers_, *x_, *u_;
};

bool differ(double a, double b) {
    return !(a == b || (std::isnan(a) && std::isnan(b)) || std::fabs(a - b) <= same * (std::fabs(a) + std::fabs(b)));
}

// False: why names the first value that differs.
bool agree(const Plan& plan, const double* alone, const double* beside, Refusal& why) {
    const int numbers = Walk::numbers_of(plan.sizes), n = plan.sizes.states, sensors = plan.sizes.outputs;
    for (int k = 0; k < steps * numbers; ++k) {
        if (!differ(alone[k], beside[k])) continue;
        const int of = k % numbers;
        const char* what = of < n                 ? "state"
                           : of < 2 * n           ? "derivative"
                           : of < 2 * n + sensors ? "sensor"
                                                  : "next event or answer";
        const int index = of < 2 * n ? of % n : of < 2 * n + sensors ? of - 2 * n : of - 2 * n - sensors;
        return why.refuse(Refusal::plant,
                          "%.60s does not bear a second instance in one process: its %s %d is %.9g alone, %.9g beside another; "
                          "delete the other observer first (it may be disturbed now), or use a process for each",
                          plan.identifier, what, index, alone[k], beside[k]);
    }
    return true;
}

// Two instances beside the existing ones, the second made while the first is stepped, compared with a single instance.
bool leave_each_other_alone(const char* folder, Plan& plan, const LivePlant::Way& way, Refusal& why) {
    const Block of_first(Walk::bytes_of(plan.sizes)), of_second(Walk::bytes_of(plan.sizes));
    if (!of_first.doubles() || !of_second.doubles())
        return why.refuse(Refusal::plant, "no memory for a trial of %s", plan.identifier);
    Owned<FmuPlant> one{FmuPlant::open(folder, plan, way.start_s, why)};
    if (!one.object) return false;
    Walk first(*one.object, plan, way.start_s, of_first.doubles());
    first.go_to(steps / 4);
    Owned<FmuPlant> other{FmuPlant::open(folder, plan, way.start_s, why)};
    if (!other.object) return false;
    Walk second(*other.object, plan, way.start_s, of_second.doubles());
    for (int k = steps / 4; k < steps; ++k) {
        second.go_to(k);
        first.go_to(std::min(k, 3 * steps / 4));
    }
    second.go_to(steps);
    other.end();
    first.go_to(steps);
    return agree(plan, way.answers, of_first.doubles(), why) && agree(plan, way.answers, of_second.doubles(), why);
}

SpinLock one_at_a_time;

// Before a further instance is used.
bool may_be_second(const char* folder, std::uint64_t token, Refusal& why) {
    if (LivePlant::has_passed(token)) return true;
    auto* plan = make_object<Plan>();
    if (!plan) return why.refuse(Refusal::plant, "no memory for a plan");
    const LivePlant::Way way = LivePlant::way_of(token, plan);
    const bool may = !way.answers || leave_each_other_alone(folder, *plan, way, why);
    if (may && way.answers) LivePlant::pass(token);
    release_block(way.answers);
    destroy_object(plan);
    return may;
}

} // namespace

FmuPlant* open_beside_others(const char* folder, Plan& plan, double start_s, Refusal& why) {
    const SpinLock::Held held(one_at_a_time);
    // FMUs of both versions may share a token.
    const std::uint64_t token = hash(plan.token, std::strlen(plan.token), hash(&plan.fmi, sizeof plan.fmi));
    const bool is_first = !LivePlant::lives(token);
    if (!is_first && plan.once) {
        why.refuse(Refusal::plant, "%s can exist only once in a process, and an observer of it is there: delete that first",
                   plan.identifier);
        return nullptr;
    }
    if (!is_first && !may_be_second(folder, token, why)) return nullptr;
    FmuPlant* plant = FmuPlant::open(folder, plan, start_s, why);
    if (!plant) return nullptr;
    LivePlant::Way way;
    if (is_first && !plan.once && !plan.never_freed) {
        way = {plant->plan(), start_s, nullptr, Walk::answers_of(plan.sizes)};
        way.answers = static_cast<double*>(take_block(Walk::bytes_of(plan.sizes)));
        if (way.answers) Walk(*plant, *way.plan, start_s, way.answers).go_to(steps);
        if (!plant->back_at_start() && !plant->go_to_start(why)) {
            release_block(way.answers);
            plant->destroy();
            return nullptr;
        }
    }
    plant->live.enter(token, way);
    return plant;
}

} // namespace hnav::observer
