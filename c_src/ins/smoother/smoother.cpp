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

Smoothing smooth(const Model& model, Recording& recording) {
    Smoother smoother(model, recording);
    if (!smoother.take_memory()) return Smoothing::out_of_memory;
    if (recording.rows() > 0) smoother.run();
    return Smoothing::done;
}

} // namespace hnav::ins
