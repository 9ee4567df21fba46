// The observer as a model of Filter<Model>: between samples x, d, the moving rows S of their transition matrix and the process
// noise Qd flow together; at a sample all its sensors correct P = Phi P Phi' + Qd. Equations (O1) to (O4) of docs/filter_observer.md.
//
//   x' = f(t, x, u, d, theta),  S' = A [S; rest of I],  Qd' = A Qd + Qd A' + Q        A = d(x', d')/dX
//
// The flow does not contain P, which stays positive semidefinite by the congruence; Phi and Qd have their own tolerances.
//
// In a plant with events the flow goes from guard to guard (crossing.cpp), P passes an event by its saltation matrix
// (saltation.cpp), and the estimate splits into parts if an event may or may not have occurred (hypotheses.cpp).
#pragma once

#include "estimation/absorption.hpp"
#include "hnav/options/observer.h"
#include "hybrid/model_concept.hpp"
#include "hybrid/propagator.hpp"
#include "maths/row_major.hpp"
#include "observer/linearisation.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace hnav {
class StiffSolver;
}

namespace hnav::observer {

// Numbers of an event of the plant: N before and after it, their slopes, the gradient of its guard, the saltation matrix Xi, P, the
// discrete state and the joint moments before it.
struct PassageMemory {
    PassageMemory(Arena& arena, const Problem& problem, const Layout& layout);

    double *X, *slope, *after, *slope_after, *gradient, *Xi, *P, *memory, *memory_after, *sides, *joint;
};

// An event of the plant and what it does to the estimate.
struct Passage : PassageMemory {
    explicit Passage(const PassageMemory& numbers) : PassageMemory(numbers) {}

    double elapsed = 0, next_event = 0, next_after = 0;
    double rate = 0; // of the indicator, along the flow
    double sigma_s = 0; // of the time of the event
    bool silent = false;
    bool derivable = true; // false: not passed, because it has no derivative
    bool shifts = false; // its time depends on X, by its guard
    bool is_newest = false; // it had an effect, and no later event
};

// Points of an interval without derivatives, as many pairs in the plane of the guards: see spread.cpp.
inline int spread_count(int N) { return N > 2 ? std::max(32, N) : 64; }
void make_spread(int N, double* plane);
// Parts of an interval: each of the old ones may split into max_parts.
constexpr int max_branches = max_parts * max_parts;
constexpr double smallest_weight = 1e-4; // of a part

// Scratch memory of a model, valid within a call. One for each filter.
class Workspace {
public:
    // Counts on an arena without memory. smooths: of a filter whose states keep their joint moments.
    Workspace(Arena& arena, const Problem& problem, bool smooths = false);

    const Layout layout; // computed once: needed at each evaluation of the flow
    Linearisation linearisation;
    // N; inputs; moving x N; N x N twice; for each part sensors x N, sensors, and of each sensor innovation and variance; N;
    // N x N.
    double *x, *u, *A, *Qd, *product, *H, *y, *nu, *variance, *gain, *P;
    double* cut; // N x N, a covariance during truncation

    // For a plant with events: parts of an interval; points of a step; values of indicators at both ends of a bracket and
    // inside, at five points of a step, and at the beginning; their gradients and rates.
    double *branches, *step_from, *step_to, *inside, *slope, *z, *z_low, *z_above, *z_inside, *z_first, *gradients, *rates,
        *probe, *slope_here;
    // Without derivatives: the part at the beginning of the interval and after its newest event, its S since then, a point that
    // is propagated from there, pairs of numbers for all points, gradients of two guards there and of the first open one at the beginning,
    // and the mean.
    double *beginning, *segment, *segment_S, *point, *plane, *guards, *open_guard, *spread_mean;
    double* first_memory; // discrete state at the start
    double* chattered_from; // N: where the covariance stopped to pass events
    int events_left = 0; // of the interval, for all parts and points together, however often it is tried
    // Five matrices N x N; a state for the creation of the stiff solver.
    double *matrices, *stiff_start;
    // Joint moments of the mean of points, M of joint.cpp (N x N), joint moments of a merger; twice N; N: a point along the columns of a root.
    double *joint, *joint_root, *joint_merged, *joint_row, *distances;
    PassageMemory passages[2];
};

// The last failure of the plant.
struct Trouble {
    bool any;
    Function function;
    Answer answer; // ok: a number that is not finite
    double t_s;
    char said[200]; // message of the plant
};

// What flows: a part of the state (null: the first) with its matrices, or a sigma point without.
struct FlowingPart {
    const double* part = nullptr;
    bool alone = false;
};

class Model {
public:
    using Piece = FlowingPart;
    using Event = RuntimeEvent;
    using State = RuntimeState;
    static constexpr bool has_closed_form = false, bounds_rate = false, reholds = false, turns_back = false;

    Model() = default;
    Model(Plant& plant, const Problem& problem, Workspace& work, StiffSolver& stiff, Trouble& trouble,
          const hnav_observer_options& options)
        : plant_(&plant), problem_(&problem), work_(&work), stiff_(&stiff), trouble_(&trouble), options_(options) {}

    int nx() const { return layout().nx; }
    // Inputs, sensors, and the start of the estimate: inputs of an instant therefore act before its sensors.
    int channels() const { return start_channel() + 1; }
    int values() const { return 1; }
    int sensor_channel(int sensor) const { return problem_->known + sensor; }
    int start_channel() const { return problem_->known + problem_->sensors; }
    std::size_t state_bytes() const { return static_cast<std::size_t>(layout().numbers) * sizeof(double); }

    void begin(State& s) const;
    bool flows(const State& s) const { return s.x()[layout().begun] != 0; }
    void open_interval() const;
    bool plausible(const State& s) const;
    void normalise(State&) const {}
    void before_flow(State&, const Event&) const {} // what begins with an interval begins where the state is first changed
    int flow(const State& s, const double* x, double* dx, const Piece& piece = {}) const;
    bool crosses() const { return problem_->sizes.events; }
    bool cross(State& s, double interval_s, Propagator& propagator) const;
    // For an integrator outside, which has brought the first part to t_s: the plant's events there; the time of its next time event
    // (infinite: none); its indicators at x.
    bool have_events_of_plant(State& s, double t_s, bool* any) const;
    // The plant may request an event at the end of a step: the state keeps the request until the event.
    bool step_outside_done(State& s, const double* x) const;
    bool wants_event(const State& s) const { return s.x()[layout().wants_event] != 0; }
    double next_event_of_plant_s(const State& s) const;
    bool indicators_at(const State& s, const double* x, double* z) const;
    // Steps of the explicit solver in an interval beyond which the plant is treated as stiff.
    static constexpr long max_explicit_steps = 500;
    bool by_points() const { return options_.propagation == HNAV_OBSERVER_PROPAGATION_SIGMA_POINTS || problem_->sizes.steps; }
    bool remembers() const { return problem_->sizes.memory > 0; }
    bool flow_by_points(State& s, double interval_s, Propagator& propagator) const;
    bool is_stiff(const State& s) const;
    bool flow_stiffly(State& s, double interval_s, Propagator& counts) const;
    // False: no memory.
    bool make_stiff_solver(long max_steps) const;
    void jump(State& s, const Event& event) const;
    void hold(State& s, double by_s) const;
    bool miss(State& s, const Event& event) const;
    void nominal(double* x) const;

    // N numbers each, of a state that may have flowed since its event; P is N x N. Null is not written.
    void estimate(const State& s, double* X, double* sigma, double* P) const;
    // Number of parts, weight of the largest, events of the plant so far in it and in the mean.
    struct Summary {
        int count;
        double largest, events, mean_events;
    };
    Summary parts(const State& s) const;

    // For a smoother, of X, untruncated, just after an event: mean (N) and covariance (N x N). With the instant before: how far the mean of X there moves
    // by what came since (N), its covariance then (N x N), and its covariance with X now (N x N, rows of the instant before).
    struct Joint {
        double *X, *P, *moved, *origin_P, *C;
    };
    void joint_moments(const State& s, const Joint& to) const;
    // Mean (N) and covariance (N x N) of an untruncated Gaussian become those of the estimate.
    void finish(double* X, double* P) const;

    // Counts of a sensor's health.
    const Check& check(const State& s, int sensor) const {
        return reinterpret_cast<const Check*>(s.x() + layout().checks)[sensor];
    }
    // Ready at the last correction, and every sigma is still below its limit.
    bool ready(const State& s) const;

    const Layout& layout() const { return work_->layout; }
    const Problem& problem() const { return *problem_; }

private:
    enum class Cause { guard, time, input };
    enum class Inside { was, is_now, is_not, failed };
    // missed: an indicator has turned back so close to its guard that a part of the Gaussian has crossed it.
    enum class Stop { end, guard, step, missed, failed };
    enum class Way { on, ended, spread, failed };
    // Parts of a state or of an interval, as estimation/mixture.hpp takes them.
    struct Parts {
        double* operator[](int i) const { return first + static_cast<std::ptrdiff_t>(i) * model.layout().part_numbers; }
        int count() const { return used; }
        double& weight(int i) { return (*this)[i][model.layout().weight]; }
        void drop(int i);
        void merge(int i, int j);
        double apart(int i, int j) const;
        bool alike(int i, int j) const { return model.alike((*this)[i], (*this)[j]); }

        const Model& model;
        double* first;
        int used;
    };
    // Events of one source, a guard or time, that follow each other too closely to end.
    struct Succession {
        int source = -2, length = 0;
        double last_s = 0;
    };
    // A part or a point during an interval, and its events.
    struct Run {
        Run(State& state, double length_s, const Workspace& work, Propagator* by = nullptr, Parts* parts = nullptr)
            : s(state), interval_s(length_s), propagator(by), made(parts), newest(work.passages[0]), present(work.passages[1]) {}

        State& s;
        double interval_s;
        Propagator* propagator; // null: nothing flows
        Parts* made; // this part, the last, and those that it splits into
        bool alone = false; // flow and events without matrices, for a sigma point
        bool outside = false; // an integrator outside has met an event: points cannot go back
        bool stiffly = false; // with the implicit solver now
        bool went_stiffly = false; // with the implicit solver at some time
        double stiff_step_s = 0; // step of the implicit solver that reached a guard
        bool derivable = true; // the event has a derivative
        int passed = 0; // events with an effect
        Succession succession;
        double open_until_s = 0; // since the beginning: until then some event may not have occurred
        Passage newest, present;
    };

    // An interval of a stiff plant, for the callbacks of its solver.
    struct StiffRun {
        static int flow(const void* context, double s, const double* x, double* dx);
        static int jacobian(const void* context, double s, const double* x, double* J);

        const Model* model;
        const State* s;
        const double* part;
        double begin_s;
    };

    // stiff.cpp
    int stiff_flow(const StiffRun& run, double s, const double* x, double* dx, double* J) const;
    bool add_matrices(double* part, double by_s, double usual_s) const;
    bool step(const State& s, double interval_s, double* x) const;
    bool step_of_mean(State& s, double interval_s, const double* mean) const;
    bool flow_one_point(State& s, double interval_s, Propagator& propagator, double* x) const;
    bool add_step(const StiffRun& run, double* part, double from_s, double to_s) const;
    void judge_stiffness(double* s, std::uint64_t taken, double length_s) const;
    bool go_until(const StiffRun& run, double* part, double length_s, bool with_matrices, double* x) const;
    Stop go_stiffly(Run& run, double* part, double length_s) const;
    bool go_to_guard(Run& run, const StiffRun& of, double* part, double from_s, double low_s, double* to_s) const;
    bool close_in(const Run& run, const StiffRun& of, const double* part, double from_s, double low_s, double* high_s) const;
    double fastest_rate_of_A() const;

    // observer_model.cpp
    void add_decays() const;
    Point point_at(const State& s, double t_s, const double* moving, const double* parameters) const;
    Point point(const State& s, const double* part, const double* x) const; // x: of a part, while it flows
    Point point_of(const State& s, double t_s, const double* X) const { return point_at(s, t_s, X, X + problem_->moving); }
    void flow_of_matrices(double usual_s, const double* x, double* dx) const;
    template <int fixed_moving, int fixed_N>
    void multiply_row(int i, const double* with, double* out) const;
    template <int fixed_moving, int fixed_N>
    void flow_of_sized(double usual_s, const double* x, double* dx) const;
    void expected(const double* part, double* X) const;
    void put(const double* X, double* part) const;
    double* expected_uncut(const double* flowed, const double* part, double* X) const;
    void place(double* X, const double* P, double* part) const;
    bool is_log(int i) const { return i >= problem_->moving && problem_->is_log[i - problem_->moving] != 0; }
    double to_unit(const State& s, int i) const;
    void leave_logarithms(double* X, double* P) const;
    void covariance(const State& s, const double* flowed, const double* held, double* P) const;
    void collect(const State& s, double* part) const;
    void begin_flow(double* part, double after_s) const;
    bool ask(Answer answer, Function function, double t_s, const double* values, int count) const;
    bool ask_A(Answer answer, double t_s) const;
    int parts_of(const State& s) const { return static_cast<int>(s.x()[layout().parts_used]); }
    double* part_of(State& s, int i) const { return s.x() + i * layout().part_numbers; }
    const double* part_of(const State& s, int i) const { return s.x() + i * layout().part_numbers; }
    Check& check(State& s, int sensor) const { return reinterpret_cast<Check*>(s.x() + layout().checks)[sensor]; }
    Parts parts_in(State& s) const { return {*this, s.x(), parts_of(s)}; }

    // joint.cpp
    bool smooths() const { return layout().joint_numbers > 0; }
    void open_joint(State& s) const;
    void flow_joint(double* part) const { move_joint(part + layout().S, problem_->moving, part); } // before S is reset
    void move_joint(const double* M, int rows, double* part) const;
    void correct_joint(double* part, const double* P, const double* h, double innovation, double variance) const;
    void cut_joint(const Passage& e, const double* k, double sd, double l, double q, double* part) const;
    void merge_joint(const double* part, const double* other, double share, const double* X, const double* Y) const;
    void condition_joint(const double* k, int c, const double* d, double sd) const;
    void place_point_joint(const double* distances, int columns, double* point) const;
    void begin_cubature_joint(const double* L, const double* part) const;
    void end_cubature_joint(const double* points, double* part) const;

    // corrections.cpp
    void collect_all(State& s) const;
    bool take_inputs(State& s, const Event& event, bool begins) const;
    bool linearise(State& s, const Event& event, int part) const;
    void innovate(State& s, const Event& event) const;
    void correct(State& s, const Event& event) const;
    double correct_part(State& s, const Event& event, int part, const double* inflation) const;
    double correct_by(double* P, double* moved, const double* h, double innovation, double variance) const;
    bool settle(State& s, double* part) const;
    void gate(State& s, const Event& event, double* inflation) const;
    double variance_factor(State& s, const Event& event, int sensor) const;
    void forget_time(State& s) const;
    void forget(State& s) const;
    void inflate(double* part, double since_s) const;
    double largest_variance(const double* P, const double* L, double* vector, double* next) const;
    void judge(State& s, const double* before) const;
    void earn_again(State& s) const;
    bool gather_information(State& s, const double* before) const;
    bool is_below_limits(const State& s) const;

    // holding.cpp
    void note_course(State& s, double interval_s) const;
    void end_interval(State& s) const;
    void course(const State& s, const double* part, double* dX) const;
    bool answers(const State& s, const double* X) const;
    void pull_back(const State& s, const double* part, double* X, double* P) const;

    // crossing.cpp
    bool cross_part(Run& run, double* part) const;
    Way cross_piece(Run& run, double* part, int* events) const;
    bool begin_part(Run& run, double* part, int* events) const;
    Stop flow_piece(Run& run, double* part, double length_s) const;
    Stop flow_until(Run& run, double* part, double length_s) const;
    Stop go_step_by_step(Run& run, double* part, double length_s) const;
    Stop go_after_failure(Run& run, double* part, double length_s) const;
    bool between(const Run& run, const double* part, double s, double* x) const;
    Stop end_of_step(const Run& run, const double* part) const;
    Stop look_between(const Run& run, const double* part, double from_s, double to_s, double* low_s, double* high_s) const;
    bool narrow(const Run& run, const double* part, double* low_s, double* high_s) const;
    bool look(const Run& run, const double* part, const double* x) const;
    bool polish(const Run& run, const double* part, double from_s, double low_s, double high_s) const;
    Stop look_at_turn(const Run& run, const double* part, double from_s, double to_s, int quarter, double* low_s,
                      double* high_s) const;
    bool turns_near(const Run& run, const double* part, int guard, double drift, bool* near) const;
    bool move_to_zero(const Run& run, const double* part, int guard, double way_s, double near_s) const;
    bool move(const Run& run, const double* part, double* x, double by_s) const;
    bool jump_part(Run& run, double* part, Cause cause, int count) const;
    bool may_go_on(Run& run, const double* part, int source, bool counts) const;
    void add_chatter(double* part) const;

    // saltation.cpp
    bool slope(const State& s, double t_s, const double* X, double* dX) const;
    bool indicators(const State& s, double t_s, const double* X, double* z) const;
    bool take_sides(const State& s, double* part, double t_s, const double* X) const;
    int first_changed(const double* part) const;
    bool gradients(const State& s, double t_s, const double* X, const double* dX) const;
    bool pass(Run& run, const double* part, double t_s, Cause cause, int guard, bool with_matrix) const;
    bool have_event(Run& run, double t_s, Cause cause, bool with_matrix) const;
    bool come_to_guard(Run& run, const double* part, double t_s, int guard) const;
    int choose_guard(const double* part, int guard, Passage& e) const;
    bool probe(const State& s, double t_s, Passage& e) const;
    bool one_probe(const State& s, double t_s, const Passage& e, int number, double by, double shift_s) const;
    void carry(const Passage& e, const double* P, double* part) const;
    bool turns_beyond(const Run& run, double t_s, int guard, double* beyond_sigma) const;
    int coinciding(const State& s, const double* part, int guard, const Passage& e) const;
    void give_up(Run& run, int guard, int another) const;
    bool changes_nothing(const Run& run, bool with_matrix) const;

    // spread.cpp
    // A guard within this distance of the turning point is hardly crossed or hardly missed.
    static constexpr double hardly_sigma = 3;
    struct Spread {
        const double *mean, *root;
        int columns;
        double weight; // of a point
    };
    // Within this distance it is not crossed for sure.
    static constexpr double near_sigma = 4;
    static constexpr double floor_step = 1e-6; // of a scale: a direction that a reset sets must stay correctable
    void note_guard(const double* S, const double* gradient, double* to) const;
    void note_open(Run& run) const;
    void begin_again() const;
    int root_along_guards(double* P, double* L) const;
    bool spread(Run& run, double* part) const;
    bool send(const Run& run, const Spread& of, int k, double side, double other) const;
    void gather(Parts& groups) const;
    bool close_groups(const Run& run, Parts& groups, double noise_s, double smallest) const;

    // hypotheses.cpp
    bool look_from_end(Run& run, const double* part) const;
    bool split_near_guard(Run& run, double* part) const;
    bool slope_leads_away(double after_s) const;
    bool spread_stiffly(Run& run, const double* part, bool uncertain) const;
    bool split_at_newest(Run& run, double* part) const;
    bool split_at_next(Run& run, double* part) const;
    double* part_after_jump(const Run& run, const double* part) const;
    double noise_along(int guard) const;
    bool is_led_by_noise(int guard, double variance) const;
    int guard_of_noise(const double* part, const double* P, double since_s, Absorption* crossed) const;
    bool split_by_noise(Run& run, double* part) const;
    bool have_event_on_guard(Run& run, double* part, int guard) const;
    void add_delay(const Passage& e, double since_s, double* part) const;
    bool reach(Run& run, const double* part, int guard, double* after_s) const;
    int next_guard(const double* part, const double* P, bool with_noise) const;
    bool split(const Run& run, double* waiting, double* jumped, const Passage& e, double distance, const double* J,
               const Absorption* by_noise = nullptr) const;
    Inside put_inside(const State& s, double* part, double t_s, double* X, const double* P) const;
    void keep(State& s, Parts& parts) const;
    void merge(double* part, const double* other) const;
    double apart(const double* part, const double* other) const;
    bool alike(const double* part, const double* other) const;
    bool equal_discrete(const double* part, const double* other) const;
    void fused(const State& s, double* X, double* P) const;

    Plant* plant_ = nullptr;
    const Problem* problem_ = nullptr;
    Workspace* work_ = nullptr;
    StiffSolver* stiff_ = nullptr;
    Trouble* trouble_ = nullptr;
    hnav_observer_options options_{};
};

inline Point Model::point_at(const State& s, double t_s, const double* moving, const double* parameters) const {
    const Problem& p = *problem_;
    std::copy_n(s.x() + layout().inputs, p.known, work_->u);
    std::copy_n(moving + p.n, p.sizes.unknown_inputs, work_->u + p.known);
    return {t_s, moving, work_->u, parameters};
}

inline Point Model::point(const State& s, const double* part, const double* x) const {
    const Layout& at = layout();
    return point_at(s, s.x()[at.t] + part[at.elapsed] + x[at.clock], x, part + at.parameters);
}

} // namespace hnav::observer
