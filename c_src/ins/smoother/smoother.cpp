#include "ins/smoother/smoother.hpp"

#include "base/instant.hpp"
#include "base/memory.hpp"
#include "ins/smoother/passes.hpp"

#include <algorithm>
#include <limits>

namespace hnav::ins {

Smoother::~Smoother() {
    for (void* block : {static_cast<void*>(main_), static_cast<void*>(before_), static_cast<void*>(nodes_),
                        static_cast<void*>(rows_), static_cast<void*>(flags_)})
        release_block(block);
}

bool Smoother::take_memory() {
    const std::size_t n = recording_.rows(), m = recording_.samples();
    std::size_t most = 1, sample = 0; // events of a row
    for (std::size_t i = 0; i < n; ++i) {
        const std::size_t first = sample;
        const double through_s = recording_.t_s(i) + sample_instant_s(recording_.t_s(i));
        while (sample < m && recording_.sample_s(sample) <= through_s) ++sample;
        most = std::max(most, sample - first);
    }
    const std::size_t checkpoints = n / piece_rows + m / piece_corrections + 2;
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

bool next_event(const Recording& recording, Place& p, Event* event) {
    const double row_s = recording.t_s(p.row);
    *event = {};
    if (p.sample == recording.samples() || recording.sample_s(p.sample) > row_s + sample_instant_s(row_s)) return false;
    event->t_s = recording.sample_s(p.sample);
    for (; p.sample < recording.samples() && recording.sample_s(p.sample) == event->t_s; ++p.sample) {
        if (event->has(recording.channel(p.sample))) break;
        event->add(recording.sample(p.sample));
        if (recording.begins_time_base(p.sample)) event->present |= new_time_base;
    }
    return true;
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
