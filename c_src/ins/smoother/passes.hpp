// The ways of the smoother through a recording, and what it keeps of them. Nobody but the smoother's own files includes this.
//
//     smoother.cpp        memory for all of it, taken once; the order: forward through the whole, then back
//     forward.cpp         the filter through rows, a state kept from time to time; a piece between two of them once more, every correction of
//                         it kept as a node
//     backward.cpp        from node to node backwards (hindsight.hpp), piece after piece, and the rows between two nodes
//     before_heading.cpp  where the nodes come to the correction that found the heading: the part before it once more, by a way of its own
#pragma once

#include "ins/smoother/hindsight.hpp"
#include "ins/smoother/recorded_events.hpp"

namespace hnav::ins {

constexpr std::size_t piece_rows = 1024, piece_corrections = 256; // a piece is no longer than the one and the other

class Smoother {
public:
    Smoother(const Model& model, Recording& recording) : model_(model), recording_(recording) {}
    ~Smoother();
    Smoother(const Smoother&) = delete;
    Smoother& operator=(const Smoother&) = delete;

    bool take_memory();
    void run();

private:
    // Where a piece begins.
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

    // forward.cpp
    static void prepare(const Way& way, Event& event, State& s);
    bool step_to_node(const Way& way, State& s, Event& event, std::size_t row, std::size_t nodes);
    std::size_t begin_once_more(const Way& way, const Checkpoint& begin);
    bool go_forward(Way& way, const Place& from, State s, bool writes);
    std::size_t go_through(const Way& way, std::size_t piece);
    void note_row(const Model& model, const State& s, std::size_t row, std::size_t nodes);

    // backward.cpp
    void go_back(const Way& way, const Target* target);
    void write_rows(std::size_t k, const Hindsight& now, const Later& later, std::size_t* rows);
    void write_row(const State& node, const RowOfPiece& row, const Hindsight& now, const Later& later);

    // before_heading.cpp
    bool go_back_before(const Node& found, const Hindsight& hindsight, std::size_t piece);
    bool find_begin(const State& found, std::size_t piece, Place* place, State* s);
    void carry_back(State& s, std::size_t row, double to_s);
    double place_at_first_fix(State& s, std::size_t aid) const;
    double time_of_fix(int channel, std::size_t aid, int count) const;

    Model model_;
    Recording& recording_;
    Checkpoint *main_ = nullptr, *before_ = nullptr;
    Node* nodes_ = nullptr;
    RowOfPiece* rows_ = nullptr;
    unsigned char* flags_ = nullptr; // what the filter called ready, row by row
    unsigned char earned_ = 0; // in this row or later, since something was lost
    std::size_t rows_of_piece_ = 0;
};

} // namespace hnav::ins
