// Forward: runs the filter over the rows and keeps checkpoints; runs a piece between two checkpoints again and keeps its
// corrections as nodes.
#include "ins/smoother/passes.hpp"

namespace hnav::ins {

// Prepares an event of a second pass. The first fixes get wide sigmas, because a gate cannot find an outlier among them. At the end of
// the pass a correction is forced, so that the covariance is propagated there.
void Smoother::prepare(const Way& way, Event& event, State& s) {
    if (!way.again) return;
    constexpr double usual_m_s = 1;
    const double wide[] = {usual_m_s, way.model.options().start_sigma_position_m};
    for (const int channel : {velocity, position})
        for (int i = 3; i < 6 && event.has(channel) && event.t_s < way.settled_s[channel]; ++i)
            event.value[channel][i] = std::hypot(event.value[channel][i], wide[channel == position]);
    if (event.t_s >= way.until_s) s.last_correction_s = -std::numeric_limits<double>::infinity();
}

// Returns false if a second pass lost the state or contradicts the samples: then the first one is better.
bool Smoother::go_forward(Way& way, const Place& from, State& s, bool writes) {
    Event event;
    std::uint64_t corrections = 0;
    const std::uint64_t lost = s.times_lost;
    const double begin_s = s.last_event_s;
    std::size_t since = 0;
    way.count = 0;
    for (Place p = from; p.row < recording_.rows(); ++p.row) {
        if (way.count == 0 || p.row - since >= piece_rows || s.corrections - corrections >= piece_corrections) {
            way.checkpoints[way.count++] = {p, s};
            since = p.row;
            corrections = s.corrections;
        }
        while (next_event(recording_, p, &event)) {
            prepare(way, event, s);
            step_over(way.model, s, event);
            if (way.again && (s.phase != Phase::navigating || s.times_lost != lost || s.inconsistent_s >= begin_s)) return false;
            if (event.t_s >= way.until_s) return true;
        }
        if (!writes) continue;
        State shown = s;
        const double ahead_s = look_ahead(way.model, recording_.t_s(p.row), shown);
        flags_[p.row] = recording_.write(p.row, shown, ahead_s);
    }
    return !way.again;
}

// Processes an event. Returns true if there was a correction while navigating, which the next node then holds.
bool Smoother::step_to_node(const Way& way, State& s, Event& event, std::size_t next_sample, std::size_t nodes) {
    Node& node = nodes_[nodes];
    Model model = way.model;
    const bool navigated = s.phase == Phase::navigating;
    const std::uint64_t corrections = s.corrections, lost = s.times_lost;
    model.record_corrections(&node.step);
    prepare(way, event, s);
    step_over(model, s, event);
    if (s.phase != Phase::navigating || (navigated && s.corrections == corrections)) return false;
    node.state = s;
    node.sample = next_sample;
    node.linked = navigated && s.times_lost == lost;
    return true;
}

// A second pass begins with the sensor errors only, at its first event.
std::size_t Smoother::begin_once_more(const Checkpoint& begin) {
    nodes_[0].state = begin.state;
    nodes_[0].linked = false;
    nodes_[0].sample = begin.place.sample;
    return 1;
}

// Runs a piece again and keeps its corrections as nodes, and its rows up to the first correction of the next piece. Returns the number
// of nodes.
std::size_t Smoother::go_through(const Way& way, std::size_t piece) {
    const Checkpoint& begin = way.checkpoints[piece];
    const std::size_t end_row = piece + 1 < way.count ? way.checkpoints[piece + 1].place.row : recording_.rows();
    State s = begin.state;
    rows_of_piece_ = 0;
    std::size_t nodes = way.again && piece == 0 ? begin_once_more(begin) : 0;
    Event event;
    for (Place p = begin.place; p.row < recording_.rows() && rows_of_piece_ < 2 * piece_rows; ++p.row) {
        while (next_event(recording_, p, &event)) {
            const bool corrected = step_to_node(way, s, event, p.sample, nodes);
            if (p.row >= end_row && (corrected || s.phase != Phase::navigating)) return nodes;
            if (!corrected) continue;
            ++nodes;
            if (event.t_s >= way.until_s) return nodes;
        }
        note_row(way.model, s, p.row, s.phase == Phase::navigating ? nodes : 0);
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

} // namespace hnav::ins
