// The passes of the smoother over a recording, and its memory. Only files of this folder include this header.
//
//     smoother.cpp        allocates all memory; order of passes: forward over the recording, then backward; the events of a
//                         recording and the filter's step over one, which all passes use, so that they produce the same bits
//     forward.cpp         runs the filter and keeps checkpoints; runs a piece between two checkpoints again and keeps its corrections
//                         as nodes
//     backward.cpp        from node to node backwards (hindsight.hpp), piece by piece; writes the rows between two nodes
//     before_heading.cpp  at the correction that found the heading: filters the part before it again, in a pass of its own
#pragma once

#include "ins/smoother/hindsight.hpp"
#include "ins/smoother/smoother.hpp"

namespace hnav::ins {

constexpr std::size_t piece_rows = 1024, piece_corrections = 256; // upper limits of a piece

// The next row and the next sample of a pass.
struct Place {
    std::size_t row, sample;
};

// The next event up to the time of the row; p.sample moves on. Returns false if there is none.
bool next_event(const Recording& recording, Place& p, Event* event);
// As in Filter: an event that leads to an unsound state is ignored.
void step_over(const Model& model, State& s, const Event& event);
// Propagates a state to a time after its last event. Returns the interval in s.
double look_ahead(const Model& model, double to_s, State& s);

class Smoother {
public:
    Smoother(const Model& model, Recording& recording) : model_(model), recording_(recording) {}
    ~Smoother();
    Smoother(const Smoother&) = delete;
    Smoother& operator=(const Smoother&) = delete;

    bool take_memory();
    void run();

private:
    // The begin of a piece.
    struct Checkpoint {
        Place place;
        State state;
    };
    // A correction while navigating.
    struct Node {
        State state;
        Step step;
        std::size_t sample; // the first one after it
        bool linked; // the estimate continues from the node before it
    };
    struct RowOfPiece {
        std::size_t row;
        std::size_t nodes; // number of nodes up to its time
        double t_s, x[nx];
    };
    // A pass over some rows until the event at until_s: its filter and checkpoints.
    struct Way {
        Model model;
        Checkpoint* checkpoints;
        std::size_t count;
        double until_s;
        bool again; // the second pass, before the heading was found
        double settled_s[channel_count] = {};
    };
    // The correction after the present one, which the backward pass has already processed.
    struct Later {
        bool known;
        double t_s;
        Step step;
        Hindsight hindsight; // before the samples of that time
    };

    // forward.cpp
    static void prepare(const Way& way, Event& event, State& s);
    bool step_to_node(const Way& way, State& s, Event& event, std::size_t next_sample, std::size_t nodes);
    std::size_t begin_once_more(const Checkpoint& begin);
    bool go_forward(Way& way, const Place& from, State& s, bool writes);
    std::size_t go_through(const Way& way, std::size_t piece);
    void note_row(const Model& model, const State& s, std::size_t row, std::size_t nodes);

    // backward.cpp
    static bool now_from(const State& filtered, const Later& later, Hindsight* now);
    void go_back(const Way& way, const Target* target);
    void write_rows(std::size_t k, const Hindsight& now, const Later& later, std::size_t* rows);
    void write_row(const State& node, const RowOfPiece& row, const Hindsight& now, const Later& later);

    // before_heading.cpp
    bool go_back_before(const Node& found, const Hindsight& hindsight, std::size_t piece);
    bool find_begin(const State& found, std::size_t piece, Place* place, State* s);
    void carry_back(State& s, std::size_t next_sample, double to_s);
    double place_at_first_fix(State& s, std::size_t sample) const;
    double time_of_fix(int channel, std::size_t sample, int count) const;

    Model model_;
    Recording& recording_;
    Checkpoint *main_ = nullptr, *before_ = nullptr;
    Node* nodes_ = nullptr;
    RowOfPiece* rows_ = nullptr;
    unsigned char* flags_ = nullptr; // ready flags of the filter, for each row
    unsigned char earned_ = 0; // ready flags of this row or later ones, up to a loss
    std::size_t rows_of_piece_ = 0;
};

} // namespace hnav::ins
