#include "ins/smoother.hpp"

#include "base/memory.hpp"

#include <algorithm>

namespace hnav::ins {
namespace {

constexpr std::size_t piece_rows = 1024, piece_corrections = 256;
constexpr double linear_rad = 0.005; // a heading about which everything may be linearised

// ------------------------------------------------------------------------------------------------ one step back

// P as D L L' D over the rows that it knows anything of, D the sigmas.
struct Factors {
    int n;
    double inverse_sigma[errors], L[errors][errors];
    bool positive = true;

    explicit Factors(const Covariance& P) : n(P.n) {
        for (int i = 0; i < n; ++i) inverse_sigma[i] = P[i][i] > 0 ? 1 / std::sqrt(P[i][i]) : 0;
        for (int i = 0; i < n; ++i)
            for (int j = 0; j <= i; ++j) {
                double sum = i == j ? 1 : P[i][j] * inverse_sigma[i] * inverse_sigma[j];
                for (int k = 0; k < j; ++k) sum -= L[i][k] * L[j][k];
                positive = positive && (i != j || sum > 1e-14);
                L[i][j] = i == j ? std::sqrt(sum) : sum / L[j][j];
            }
    }

    // P^-1 W, in its place.
    void solve(Covariance& W) const {
        scale(W);
        for (int i = 0; i < n; ++i) {
            for (int k = 0; k < i; ++k) take(L[i][k], W[k], W[i]);
            for (int j = 0; j < n; ++j) W[i][j] /= L[i][i];
        }
        for (int i = n; i-- > 0;) {
            for (int k = i + 1; k < n; ++k) take(L[k][i], W[k], W[i]);
            for (int j = 0; j < n; ++j) W[i][j] /= L[i][i];
        }
        scale(W);
    }

private:
    void scale(Covariance& W) const {
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) W[i][j] *= inverse_sigma[i];
    }
    void take(double share, const double* of, double* from) const {
        for (int j = 0; j < n; ++j) from[j] -= share * of[j];
    }
};

// Phi P.
Covariance carried(const Transition& t, const Covariance& P) {
    const int n = P.n;
    Covariance W = P;
    for (int i = 0; i < moved; ++i) {
        for (int j = 0; j < n; ++j) W[i][j] = 0;
        for (int k = 0; k < movers; ++k) {
            const double m = t.M[i][k];
            if (m == 0) continue;
            for (int j = 0; j < n; ++j) W[i][j] += m * P[k][j];
        }
    }
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < n; ++j) W[row_colour + i][j] *= t.colour_kept[i];
    if (n == errors)
        for (int j = 0; j < n; ++j) W[row_direction][j] *= t.direction_kept;
    return W;
}

// What hindsight adds to an estimate of the filter, and its covariance.
struct Hindsight {
    double error[errors];
    Covariance P;
};

// P + X' (S - B) X and X' e, of P and e before a step and S after it.
bool step_back(const Step& step, const Hindsight& after, Hindsight* now) {
    const int n = step.before.n;
    now->P.extend(n); // before the first sample of a magnetometer
    Covariance X = carried(step.transition, now->P), D{}, DX{};
    const int told = std::min(n, after.P.n);
    const Factors before(step.before);
    if (!before.positive) return false;
    before.solve(X);
    for (int i = 0; i < n; ++i) {
        now->error[i] = 0;
        for (int j = 0; j < told && i < told; ++j) D[i][j] = after.P[i][j] - step.before[i][j];
    }
    for (int i = 0; i < n; ++i)
        for (int k = 0; k < n; ++k) {
            now->error[i] += X[k][i] * after.error[k];
            for (int j = 0; j < n; ++j) DX[i][j] += D[i][k] * X[k][j];
        }
    for (int k = 0; k < n; ++k)
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) now->P[i][j] += X[k][i] * DX[k][j];
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < i; ++j) now->P[i][j] = now->P[j][i] = 0.5 * (now->P[i][j] + now->P[j][i]);
    return true;
}

// ------------------------------------------------------------------------------------------------ errors of states

Quaternion turned(const double* phi, const Quaternion& q) { return multiply(rotation_quaternion(vec(phi)), q); }

// Vectors of errors, and their covariance, in axes turned by C.
void turn(const Matrix3& C, Hindsight& h) {
    for (const int row : {row_d, row_v, row_phi, row_colour}) {
        vec(h.error + row) = Vector3(C * vec(h.error + row));
        turn_rows(h.P, row, C);
    }
}

// The same state in other axes.
void place_in(const State& axes, State& s) {
    const Matrix3 C = mat(axes.axes).transpose() * mat(s.axes);
    const Vector3 e = vec(s.anchor_e) - vec(axes.anchor_e);
    vec(s.x) = mat(axes.axes).transpose() * e + C * vec(s.x);
    vec(s.x + 3) = Vector3(C * vec(s.x + 3));
    vec(s.colour) = Vector3(C * vec(s.colour));
    quat(s.x + 6) = multiply(quaternion_from_matrix(C), quat(s.x + 6));
}

// What `to` differs by from `from`, in the axes of the latter. Where a state has no offset of the pressure yet there is none to tell.
void difference(const State& to, const State& from, double* error) {
    State s = to;
    place_in(from, s);
    vec(error + row_d) = vec(s.x) - vec(from.x);
    vec(error + row_v) = vec(s.x + 3) - vec(from.x + 3);
    vec(error + row_phi) = rotation_vector(multiply(quat(s.x + 6), conjugate(quat(from.x + 6))));
    vec(error + row_gyro) = vec(s.gyro_bias) - vec(from.gyro_bias);
    vec(error + row_accel) = vec(s.accel_bias) - vec(from.accel_bias);
    vec(error + row_gyro_scale) = vec(s.gyro_scale) - vec(from.gyro_scale);
    vec(error + row_colour) = vec(s.colour) - vec(from.colour);
    error[row_u] = error[row_u + 1] = 0;
    error[row_latency] = s.latency - from.latency;
    error[row_offset] = std::isfinite(s.offset + from.offset) ? s.offset - from.offset : 0;
    error[row_scale] = s.scale - from.scale;
    for (int i = 0; i < 2; ++i) error[row_mount + i] = s.mount[i] - from.mount[i];
    const double same_unit = s.field_unit == from.field_unit ? 1 : 0;
    vec(error + row_iron) = same_unit * (vec(s.iron) - vec(from.iron));
    error[row_strength] = same_unit * (s.strength - from.strength);
    error[row_direction] = same_unit * (s.direction - from.direction);
}

// ------------------------------------------------------------------------------------------------ forward

struct Place {
    std::size_t row, aid;
};

struct Checkpoint {
    Place place;
    State state;
};

// A correction while navigating, and how it came about.
struct Node {
    State state;
    Step step;
    std::size_t row; // in which it happened
    bool linked; // there is one before it that it goes on from
};

struct RowOfPiece {
    std::size_t row;
    std::size_t nodes; // up to its time
    double t_s, x[nx];
};

// As Filter does it: an event that leads to no sound state is left out.
void step_over(const Model& model, State& s, const Event& event) {
    const State before = s;
    model.before_flow(s, event);
    const double interval_s = event.t_s - before.last_event_s;
    if (interval_s > 0 && std::isfinite(interval_s) && model.flows(s)) model.flow_exactly(s, interval_s);
    model.jump(s, event);
    double sum = 0;
    for (const double x : s.x) sum += x * x;
    if (!std::isfinite(sum) || !model.plausible(s)) s = before;
}

// Brings a state to a time after its last event; answers how far that is.
double look_ahead(const Model& model, double to_s, State& s) {
    const double ahead_s = to_s - s.last_event_s;
    if (!(ahead_s > 0) || std::isinf(ahead_s)) return 0;
    if (model.flows(s)) model.flow_exactly(s, ahead_s);
    return ahead_s;
}

// Another state of the same time, with hindsight.
struct Target {
    State state;
    Covariance P;
};

class Smoother {
public:
    Smoother(const Model& model, Recording& recording) : model_(model), recording_(recording) {}
    ~Smoother() {
        for (void* block : {static_cast<void*>(main_), static_cast<void*>(before_), static_cast<void*>(nodes_),
                            static_cast<void*>(rows_), static_cast<void*>(flags_)})
            release_block(block);
    }
    Smoother(const Smoother&) = delete;
    Smoother& operator=(const Smoother&) = delete;

    bool take_memory();
    void run();

private:
    // A way through some rows, until the event at until_s: its filter, and states on the way.
    struct Way {
        Model model;
        Checkpoint* checkpoints;
        std::size_t count;
        double until_s;
        bool again; // before the heading was found, once more
        double settled_s[channel_count] = {};
    };
    // The correction after the one that is gone back to.
    struct Later {
        bool known;
        double t_s;
        Step step;
        Hindsight hindsight; // before the samples of that time
    };

    bool next_event(Place& p, std::size_t row, Event* event);
    static void prepare(const Way& way, Event& event, State& s);
    bool step_to_node(const Way& way, State& s, Event& event, std::size_t row, std::size_t nodes);
    std::size_t begin_once_more(const Way& way, const Checkpoint& begin);
    bool go_forward(Way& way, const Place& from, State s, bool writes);
    std::size_t go_through(const Way& way, std::size_t piece);
    void note_row(const Model& model, const State& s, std::size_t row, std::size_t nodes);
    void go_back(const Way& way, const Target* target);
    bool go_back_before(const Node& found, const Hindsight& hindsight, std::size_t piece);
    bool find_begin(const State& found, std::size_t piece, Place* place, State* s);
    void carry_back(State& s, std::size_t row, double to_s);
    double place_at_first_fix(State& s, std::size_t aid) const;
    double time_of_fix(int channel, std::size_t aid, int count) const;
    void write_rows(std::size_t k, const Hindsight& now, const Later& later, std::size_t* rows);
    void write_row(const State& node, const RowOfPiece& row, const Hindsight& now, const Later& later);

    Model model_;
    Recording& recording_;
    Checkpoint *main_ = nullptr, *before_ = nullptr;
    Node* nodes_ = nullptr;
    RowOfPiece* rows_ = nullptr;
    unsigned char* flags_ = nullptr; // what the filter called ready, row by row
    unsigned char earned_ = 0; // in this row or later, since something was lost
    std::size_t rows_of_piece_ = 0;
};

bool Smoother::take_memory() {
    const std::size_t n = recording_.rows(), m = recording_.aids();
    std::size_t most = 1, aid = 0; // events of a row
    for (std::size_t i = 0; i < n; ++i) {
        const std::size_t first = aid;
        while (aid < m && recording_.aid(aid).t_s <= recording_.t_s(i)) ++aid;
        most = std::max(most, aid - first + 1);
    }
    const std::size_t checkpoints = n / piece_rows + (n + m) / piece_corrections + 2;
    main_ = static_cast<Checkpoint*>(take_block(checkpoints * sizeof(Checkpoint)));
    before_ = static_cast<Checkpoint*>(take_block(checkpoints * sizeof(Checkpoint)));
    nodes_ = static_cast<Node*>(take_block((piece_corrections + most + 2) * sizeof(Node)));
    rows_ = static_cast<RowOfPiece*>(take_block((2 * piece_rows + 1) * sizeof(RowOfPiece)));
    flags_ = static_cast<unsigned char*>(take_block(n));
    return main_ && before_ && nodes_ && rows_ && flags_;
}

// The next event up to the time of the row, whose own sample of rate and force acts with the first event of its time; false: there
// is none.
bool Smoother::next_event(Place& p, std::size_t row, Event* event) {
    const double row_s = recording_.t_s(row);
    const bool has_aid = p.aid < recording_.aids() && recording_.aid(p.aid).t_s <= row_s;
    *event = {};
    event->t_s = has_aid ? recording_.aid(p.aid).t_s : row_s;
    Sample sample;
    if (p.row == row && event->t_s == row_s) {
        ++p.row;
        if (recording_.imu_sample(row, &sample)) event->add(sample);
    }
    while (p.aid < recording_.aids() && recording_.aid(p.aid).t_s == event->t_s && !event->has(recording_.aid(p.aid).channel))
        event->add(recording_.aid(p.aid++));
    return event->present != 0;
}

// The last event of a way is one at which the covariance follows. The first fixes count little: a gate does not see which of them lies
// far off.
void Smoother::prepare(const Way& way, Event& event, State& s) {
    if (!way.again) return;
    constexpr double usual_m_s = 1;
    const double wide[] = {usual_m_s, way.model.settings().sigma_first_fix_m};
    for (const int channel : {velocity, position})
        for (int i = 3; i < 6 && event.has(channel) && event.t_s < way.settled_s[channel]; ++i)
            event.value[channel][i] = std::hypot(event.value[channel][i], wide[channel == position]);
    if (event.t_s >= way.until_s) s.last_correction_s = -std::numeric_limits<double>::infinity();
}

// False: the way led astray.
bool Smoother::go_forward(Way& way, const Place& from, State s, bool writes) {
    Event event;
    std::uint64_t corrections = 0;
    const std::uint64_t lost = s.times_lost;
    std::size_t since = 0;
    way.count = 0;
    for (Place p = from; p.row < recording_.rows();) {
        const std::size_t row = p.row;
        if (way.count == 0 || row - since >= piece_rows || s.corrections - corrections >= piece_corrections) {
            way.checkpoints[way.count++] = {p, s};
            since = row;
            corrections = s.corrections;
        }
        while (next_event(p, row, &event)) {
            prepare(way, event, s);
            step_over(way.model, s, event);
            if (way.again && (s.phase != Phase::navigating || s.times_lost != lost)) return false;
            if (event.t_s >= way.until_s) return true;
        }
        if (!writes) continue;
        State shown = s;
        const double ahead_s = look_ahead(way.model, recording_.t_s(row), shown);
        flags_[row] = recording_.write(row, shown, ahead_s);
    }
    return !way.again;
}

// Over an event; true: there was a correction while navigating, and the next node tells of it.
bool Smoother::step_to_node(const Way& way, State& s, Event& event, std::size_t row, std::size_t nodes) {
    Node& node = nodes_[nodes];
    Model model = way.model;
    const bool navigated = s.phase == Phase::navigating;
    const std::uint64_t corrections = s.corrections, lost = s.times_lost;
    model.tell_steps(&node.step);
    prepare(way, event, s);
    step_over(model, s, event);
    if (s.phase != Phase::navigating || (navigated && s.corrections == corrections)) return false;
    node.state = s;
    node.row = row;
    node.linked = navigated && s.times_lost == lost;
    return true;
}

// A way once more begins with what is known of the sensors alone, and with the row of the event that it begins with.
std::size_t Smoother::begin_once_more(const Way& way, const Checkpoint& begin) {
    nodes_[0].state = begin.state;
    nodes_[0].linked = false;
    nodes_[0].row = begin.place.row;
    if (begin.place.row > 0 && recording_.t_s(begin.place.row - 1) == begin.state.last_event_s)
        note_row(way.model, begin.state, begin.place.row - 1, 1);
    return 1;
}

// The piece once more, with its corrections, and its rows up to the first correction of the next piece. Answers how many corrections
// there are.
std::size_t Smoother::go_through(const Way& way, std::size_t piece) {
    const Checkpoint& begin = way.checkpoints[piece];
    const std::size_t end_row = piece + 1 < way.count ? way.checkpoints[piece + 1].place.row : recording_.rows();
    State s = begin.state;
    rows_of_piece_ = 0;
    std::size_t nodes = way.again && piece == 0 ? begin_once_more(way, begin) : 0;
    Event event;
    for (Place p = begin.place; p.row < recording_.rows() && rows_of_piece_ < 2 * piece_rows;) {
        const std::size_t row = p.row;
        while (next_event(p, row, &event)) {
            const bool corrected = step_to_node(way, s, event, row, nodes);
            if (row >= end_row && (corrected || s.phase != Phase::navigating)) return nodes;
            if (!corrected) continue;
            ++nodes;
            if (event.t_s >= way.until_s) return nodes;
        }
        note_row(way.model, s, row, s.phase == Phase::navigating ? nodes : 0);
    }
    return nodes;
}

void Smoother::note_row(const Model& model, const State& s, std::size_t row, std::size_t nodes) {
    RowOfPiece& noted = rows_[rows_of_piece_++];
    State shown = s;
    look_ahead(model, recording_.t_s(row), shown);
    noted.row = row;
    noted.nodes = nodes;
    noted.t_s = recording_.t_s(row);
    std::copy(shown.x, shown.x + nx, noted.x);
}

// ------------------------------------------------------------------------------------------------ backward

// What the target is more than the state of a node.
Hindsight seen_from(const State& node, const Target& target) {
    Hindsight h{{}, target.P};
    turn(mat(node.axes).transpose() * mat(target.state.axes), h);
    difference(target.state, node, h.error);
    return h;
}

// Before the samples of a step that led to a state, in the axes before its anchor moved.
Hindsight before_samples(const Step& step, Hindsight h, const State& after) {
    turn(mat(step.axes).transpose() * mat(after.axes), h);
    const Vector3 phi = vec(h.error + row_phi);
    const Quaternion q = turned(phi.data(), rotation_quaternion(vec(step.change + row_phi)));
    for (int i = 0; i < errors; ++i) h.error[i] += step.change[i];
    vec(h.error + row_phi) = rotation_vector(q);
    return h;
}

void Smoother::go_back(const Way& way, const Target* target) {
    Later later{};
    bool told = false, tried = false; // a way once more has told the rest of what led here; has been tried
    for (std::size_t piece = way.count; piece-- > 0;) {
        std::size_t nodes = go_through(way, piece), rows = rows_of_piece_;
        while (nodes > 0) {
            const Node& node = nodes_[--nodes];
            const bool linked = node.linked;
            if (!told) {
                Hindsight now{{}, Covariance::of(node.state)};
                if (target) now = seen_from(node.state, *target);
                else if (later.known) later.known = step_back(later.step, later.hindsight, &now);
                target = nullptr;
                write_rows(nodes, now, later, &rows);
                later = {linked, node.state.last_event_s, node.step, before_samples(node.step, now, node.state)};
                const bool wide = node.state.P[packed(row_phi + 2, row_phi + 2)] > linear_rad * linear_rad;
                if (!way.model.settings().state_given && (!linked || (wide && !tried))) {
                    told = go_back_before(Node(node), now, piece);
                    tried = true;
                    go_through(way, piece);
                }
            }
            if (linked) continue;
            told = tried = false;
            later.known = false;
            earned_ = 0;
        }
    }
}

// The part before the heading was found, and known well enough to linearise about it. False: it could not be filtered again.
bool Smoother::go_back_before(const Node& found, const Hindsight& hindsight, std::size_t piece) {
    Place place;
    State begin, later = found.state;
    if (!find_begin(found.state, piece, &place, &begin)) return false;
    add_error(hindsight.error, later);
    const Target target{later, hindsight.P};
    carry_back(later, found.row, begin.last_event_s);
    const double known_s = place_at_first_fix(later, place.aid) - begin.last_event_s;
    Settings settings = model_.settings();
    settings.state_given = true;
    Way way{Model(settings), before_, 0, found.state.last_event_s, true, {}};
    for (const int channel : {velocity, position}) way.settled_s[channel] = time_of_fix(channel, place.aid, 5);
    if (!go_forward(way, place, way.model.once_more(begin, later, known_s), false)) return false;
    go_back(way, &target);
    return true;
}

// Where the search for the heading began that has found it.
bool Smoother::find_begin(const State& found, std::size_t piece, Place* place, State* s) {
    const auto within = [&found](const State& state) {
        return state.times_lost == found.times_lost && state.phase != Phase::waiting &&
               state.last_event_s >= found.levelling.began_s;
    };
    while (piece > 0 && within(main_[piece].state)) --piece;
    *place = main_[piece].place;
    *s = main_[piece].state;
    Event event;
    while (place->row < recording_.rows()) {
        const std::size_t row = place->row;
        while (next_event(*place, row, &event)) {
            step_over(model_, *s, event);
            if (within(*s)) return s->phase != Phase::navigating;
        }
    }
    return false;
}

// Carried back for long a velocity is off by much, and a place by more: those of the first fixes from an aid on are near enough. Answers
// the time of the place.
double Smoother::place_at_first_fix(State& s, std::size_t aid) const {
    double at_s = s.last_event_s;
    bool has_place = model_.settings().place_given, has_velocity = false;
    if (has_place) vec(s.x).setZero();
    vec(s.x + 3).setZero();
    for (; aid < recording_.aids() && recording_.aid(aid).t_s <= s.last_event_s && !(has_place && has_velocity); ++aid) {
        const Sample& fix = recording_.aid(aid);
        const earth::Place place{fix.value[0], fix.value[1], fix.value[2]};
        if (fix.channel == position && !has_place) {
            vec(s.x) = mat(s.axes).transpose() * (earth::position_of(place) - vec(s.anchor_e));
            at_s = fix.t_s;
            has_place = true;
        } else if (fix.channel == velocity && !has_velocity) {
            const Vector3 v(fix.value[0], fix.value[1], std::isnan(fix.value[2]) ? 0 : fix.value[2]);
            vec(s.x + 3) = mat(s.axes).transpose() * (mat(s.fix_axes) * v);
            has_velocity = true;
        }
    }
    return at_s;
}

// Of so many fixes from an aid on the last.
double Smoother::time_of_fix(int channel, std::size_t aid, int count) const {
    for (; aid < recording_.aids(); ++aid)
        if (recording_.aid(aid).channel == channel && --count == 0) return recording_.aid(aid).t_s;
    return -std::numeric_limits<double>::infinity();
}

// By rate and force alone, from a correction in this row back to an earlier time.
void Smoother::carry_back(State& s, std::size_t row, double to_s) {
    const bool backward_hold = model_.settings().backward_hold;
    double now_s = s.last_event_s;
    vec(s.coning).setZero();
    vec(s.sculling).setZero();
    Sample sample;
    for (std::size_t i = row + 1; i-- > 0 && now_s > to_s;) {
        if (!recording_.imu_sample(i, &sample)) continue;
        const double until_s = std::fmax(to_s, std::fmin(now_s, sample.t_s));
        const auto hold = [&] {
            vec(s.rate) = vec(sample.value);
            vec(s.force) = vec(sample.value + 3);
        };
        if (!backward_hold) hold();
        model_.flow_exactly(s, until_s - now_s);
        if (backward_hold) hold();
        now_s = until_s;
    }
    quat(s.x + 6).normalize();
}

// ------------------------------------------------------------------------------------------------ rows

// Those between this correction and the next.
void Smoother::write_rows(std::size_t k, const Hindsight& now, const Later& later, std::size_t* rows) {
    for (; *rows > 0; --*rows) {
        const RowOfPiece& row = rows_[*rows - 1];
        if (row.nodes != 0 && row.nodes != k + 1) return;
        if (row.nodes == 0) continue;
        earned_ |= flags_[row.row];
        if (later.known) write_row(nodes_[k].state, row, now, later);
    }
}

// Hindsight changes little from one correction to the next: what lies between is between them.
void Smoother::write_row(const State& node, const RowOfPiece& row, const Hindsight& now, const Later& later) {
    const double share = std::fmin(1, std::fmax(0, (row.t_s - node.last_event_s) / (later.t_s - node.last_event_s)));
    double error[errors];
    for (int i = 0; i < errors; ++i) error[i] = now.error[i] + share * (later.hindsight.error[i] - now.error[i]);
    State s = node;
    std::copy(row.x, row.x + nx, s.x);
    add_error(error, s);
    SmoothedRow out{};
    Navigation& n = out.navigation;
    const Matrix3 to_north = show_motion(s, mat(s.axes), &n);
    const auto sigma = [&](int row) {
        return sigmas_along(to_north, (1 - share) * now.P.block(row, row) + share * later.hindsight.P.block(row, row));
    };
    n.sigma_position = sigma(row_d);
    n.sigma_velocity = sigma(row_v);
    n.sigma_rotation = sigma(row_phi);
    out.gyro_bias = vec(s.gyro_bias);
    out.accel_bias = vec(s.accel_bias);
    const Settings& settings = model_.settings();
    const double lie = std::sqrt(std::fmax(1, node.nis_mean));
    const auto ready = [&](int flag, double largest, double limit) {
        return (earned_ >> flag & 1) != 0 && largest * lie < limit;
    };
    n.tilt_ready = ready(0, n.sigma_rotation.head<2>().maxCoeff(), settings.ready_tilt);
    n.heading_ready = ready(1, n.sigma_rotation[2], settings.ready_heading);
    n.velocity_ready = ready(2, n.sigma_velocity.maxCoeff(), settings.ready_velocity);
    n.position_ready = ready(3, n.sigma_position.head<2>().maxCoeff(), settings.ready_position);
    recording_.write(row.row, out);
}

void Smoother::run() {
    State s{};
    model_.begin(s);
    Way way{model_, main_, 0, std::numeric_limits<double>::infinity(), false, {}};
    go_forward(way, {0, 0}, s, true);
    go_back(way, nullptr);
}

} // namespace

Smoothing smooth(const Model& model, Recording& recording) {
    Smoother smoother(model, recording);
    if (!smoother.take_memory()) return Smoothing::out_of_memory;
    if (recording.rows() > 0) smoother.run();
    return Smoothing::done;
}

} // namespace hnav::ins
