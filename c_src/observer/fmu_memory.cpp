#include "observer/fmu_memory.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace hnav::observer {

FmuMemory::~FmuMemory() {
    std::free(copy_);
    std::free(held_);
}

bool FmuMemory::create(FmiInstance& fmi, bool serialises) {
    serialises_ = serialises;
    if (free_copy(fmi, {}, 0) < 0 || fmi.get_state(copy_) != Answer::ok || fmi.set_state(*copy_) != Answer::ok) return false;
    if (!serialises) {
        fmi.free_state(copy_);
        return true;
    }
    std::size_t bytes = 0;
    constexpr std::size_t most = 1 << 24;
    if (fmi.state_bytes(*copy_, &bytes) != Answer::ok || bytes == 0 || bytes > most) return false;
    bytes_ = static_cast<int>((bytes + bytes / 4 + 7) / 8 * 8); // it may grow somewhat
    return true;
}

Answer FmuMemory::store(FmiInstance& fmi, const Holders& holders, int offset, double* numbers) {
    if (!serialises_) {
        const int i = free_copy(fmi, holders, offset);
        if (i < 0) return Answer::broken;
        numbers[0] = i + 1;
        return fmi.get_state(copy_ + i);
    }
    std::size_t bytes = 0;
    Answer done = fmi.get_state(copy_);
    if (done == Answer::ok) done = fmi.state_bytes(*copy_, &bytes);
    if (done != Answer::ok) return done;
    if (bytes > static_cast<std::size_t>(bytes_)) {
        std::snprintf(fmi.said, sizeof fmi.said, "its state has grown to %zu bytes", bytes);
        return Answer::broken;
    }
    std::fill_n(numbers, this->numbers(), 0.0);
    numbers[0] = static_cast<double>(bytes);
    return fmi.serialize(*copy_, numbers + 1, bytes);
}

Answer FmuMemory::load(FmiInstance& fmi, const double* numbers) {
    if (!serialises_) {
        const int i = static_cast<int>(numbers[0]) - 1;
        return i >= 0 && i < copies_ && copy_[i] ? fmi.set_state(copy_[i]) : Answer::broken;
    }
    if (!(numbers[0] > 0 && numbers[0] <= bytes_)) return Answer::broken;
    fmi.free_state(copy_);
    const Answer done = fmi.deserialize(numbers + 1, static_cast<std::size_t>(numbers[0]), copy_);
    return done == Answer::ok ? fmi.set_state(*copy_) : done;
}

void FmuMemory::forget(FmiInstance& fmi) {
    for (int i = 0; i < copies_; ++i) fmi.free_state(copy_ + i);
}

// A copy that nobody holds. Where all are held there are twice as many then; -1: no memory.
int FmuMemory::free_copy(FmiInstance& fmi, const Holders& holders, int offset) {
    const auto unused = [&] { return static_cast<int>(std::find(copy_, copy_ + copies_, nullptr) - copy_); };
    if (unused() == copies_ && holders.each) {
        struct Seen {
            bool* held;
            int copies, offset;
        } seen{held_, copies_, offset};
        std::fill_n(held_, copies_, false);
        holders.each(
            holders.context,
            [](void* visitor, const double* memory) {
                const auto* s = static_cast<const Seen*>(visitor);
                const double number = memory[s->offset];
                if (number >= 1 && number <= s->copies) s->held[static_cast<int>(number) - 1] = true;
            },
            &seen);
        for (int i = 0; i < copies_; ++i)
            if (!held_[i]) fmi.free_state(copy_ + i);
    }
    if (const int i = unused(); i < copies_) return i;
    const int more = std::max(16, 2 * copies_);
    auto** copy = static_cast<void**>(std::realloc(copy_, more * sizeof(void*)));
    if (copy) copy_ = copy;
    auto* held = copy ? static_cast<bool*>(std::realloc(held_, more * sizeof(bool))) : nullptr;
    if (!held) return -1;
    held_ = held;
    std::fill(copy_ + copies_, copy_ + more, nullptr);
    const int first = copies_;
    copies_ = more;
    return first;
}

} // namespace hnav::observer
