#include "ins/smoother/smoother.hpp"

#include "base/memory.hpp"
#include "ins/smoother/passes.hpp"

#include <algorithm>

namespace hnav::ins {

Smoother::~Smoother() {
    for (void* block : {static_cast<void*>(main_), static_cast<void*>(before_), static_cast<void*>(nodes_),
                        static_cast<void*>(rows_), static_cast<void*>(flags_)})
        release_block(block);
}

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

void Smoother::run() {
    State s{};
    model_.begin(s);
    Way way{model_, main_, 0, std::numeric_limits<double>::infinity(), false, {}};
    go_forward(way, {0, 0}, s, true);
    go_back(way, nullptr);
}

bool next_event(Recording& recording, Place& p, std::size_t row, Event* event) {
    const double row_s = recording.t_s(row);
    const bool has_aid = p.aid < recording.aids() && recording.aid(p.aid).t_s <= row_s;
    *event = {};
    event->t_s = has_aid ? recording.aid(p.aid).t_s : row_s;
    Sample sample;
    if (p.row == row && event->t_s == row_s) {
        ++p.row;
        if (recording.imu_sample(row, &sample)) event->add(sample);
    }
    while (p.aid < recording.aids() && recording.aid(p.aid).t_s == event->t_s && !event->has(recording.aid(p.aid).channel))
        event->add(recording.aid(p.aid++));
    return event->present != 0;
}

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

double look_ahead(const Model& model, double to_s, State& s) {
    const double ahead_s = to_s - s.last_event_s;
    if (!(ahead_s > 0) || std::isinf(ahead_s)) return 0;
    if (model.flows(s)) model.flow_exactly(s, ahead_s);
    return ahead_s;
}

Smoothing smooth(const Model& model, Recording& recording) {
    Smoother smoother(model, recording);
    if (!smoother.take_memory()) return Smoothing::out_of_memory;
    if (recording.rows() > 0) smoother.run();
    return Smoothing::done;
}

} // namespace hnav::ins
