#include "observer/fmu_memory.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace hnav::observer {

FmuMemory::~FmuMemory() { std::free(copy_); }

bool FmuMemory::create(FmiInstance& fmi, bool serialises) {
    serialises_ = serialises;
    if (free_copy(fmi, {}, 0) < 0 || fmi.get_state(&copy_->state) != Answer::ok || fmi.set_state(copy_->state) != Answer::ok)
        return false;
    if (!serialises) {
        fmi.free_state(&copy_->state);
        return true;
    }
    std::size_t bytes = 0;
    constexpr std::size_t most = 1 << 24;
    if (fmi.state_bytes(copy_->state, &bytes) != Answer::ok || bytes == 0 || bytes > most) return false;
    bytes_ = static_cast<int>((bytes + bytes / 4 + 7) / 8 * 8); // reserve for growth
    return true;
}

Answer FmuMemory::store(FmiInstance& fmi, const Holders& holders, int offset, double* numbers) {
    if (!serialises_) {
        const int i = free_copy(fmi, holders, offset);
        if (i < 0) return Answer::broken;
        numbers[0] = i + 1;
        return fmi.get_state(&copy_[i].state);
    }
    std::size_t bytes = 0;
    Answer done = fmi.get_state(&copy_->state);
    if (done == Answer::ok) done = fmi.state_bytes(copy_->state, &bytes);
    if (done != Answer::ok) return done;
    if (bytes > static_cast<std::size_t>(bytes_)) {
        std::snprintf(fmi.said, sizeof fmi.said, "its state has grown to %zu bytes", bytes);
        return Answer::broken;
    }
    std::fill_n(numbers, this->numbers(), 0.0);
    numbers[0] = static_cast<double>(bytes);
    return fmi.serialize(copy_->state, numbers + 1, bytes);
}

Answer FmuMemory::load(FmiInstance& fmi, const double* numbers) {
    if (!serialises_) {
        const int i = place_of(numbers[0]);
        return i >= 0 && copy_[i].state ? fmi.set_state(copy_[i].state) : Answer::broken;
    }
    if (!(numbers[0] > 0 && numbers[0] <= bytes_)) return Answer::broken;
    fmi.free_state(&copy_->state);
    const Answer done = fmi.deserialize(numbers + 1, static_cast<std::size_t>(numbers[0]), &copy_->state);
    return done == Answer::ok ? fmi.set_state(copy_->state) : done;
}

void FmuMemory::hold(const double* numbers, int by) {
    const int i = serialises_ ? -1 : place_of(numbers[0]);
    if (i >= 0) copy_[i].held = std::max(0, copy_[i].held + by);
}

void FmuMemory::forget(FmiInstance& fmi) {
    for (int i = 0; i < copies_; ++i) fmi.free_state(&copy_[i].state);
}

void FmuMemory::free_unheld(FmiInstance& fmi, const Holders& holders, int offset) {
    struct Seen {
        const FmuMemory* memory;
        int offset;
    } seen{this, offset};
    for (int i = 0; i < copies_; ++i) copy_[i].seen = false;
    holders.each(
        holders.context,
        [](void* visitor, const double* memory) {
            const auto* s = static_cast<const Seen*>(visitor);
            if (const int i = s->memory->place_of(memory[s->offset]); i >= 0) s->memory->copy_[i].seen = true;
        },
        &seen);
    for (int i = 0; i < copies_; ++i)
        if (!copy_[i].seen && copy_[i].held == 0) fmi.free_state(&copy_[i].state);
}

// A copy without a holder. If all are held, their number is doubled; -1: no memory.
int FmuMemory::free_copy(FmiInstance& fmi, const Holders& holders, int offset) {
    const auto unused = [&] {
        return static_cast<int>(std::find_if(copy_, copy_ + copies_, [](const Copy& c) { return !c.state; }) - copy_);
    };
    if (unused() == copies_ && holders.each) free_unheld(fmi, holders, offset);
    if (const int i = unused(); i < copies_) return i;
    const int more = std::max(16, 2 * copies_), first = copies_;
    auto* copy = static_cast<Copy*>(std::realloc(copy_, more * sizeof(Copy)));
    if (!copy) return -1;
    copy_ = copy;
    std::fill(copy_ + copies_, copy_ + more, Copy{});
    copies_ = more;
    return first;
}

} // namespace hnav::observer
