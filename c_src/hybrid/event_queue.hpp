// Time-sorted events, each with room for the state just after it.
//
// The events form a chain: base, solved, solved, ..., waiting, waiting. The base is the newest event that can no longer
// change; a state is solved when it follows from its predecessor. A sample that lands inside the chain takes the
// solution from its place onward back, so a late sample costs the events behind it and nothing else.
#pragma once

#include "hybrid/event.hpp"

#include <cstddef>

namespace hnav {

template <class State>
class EventQueue {
public:
    struct Slot {
        Event event;
        State after;
    };

    static std::size_t bytes(int capacity) { return capacity * (sizeof(Slot) + sizeof(int)); }

    // memory: bytes(capacity) bytes, aligned for doubles; stays the caller's.
    void create(void* memory, int capacity) {
        slots_ = static_cast<Slot*>(memory);
        order_ = reinterpret_cast<int*>(slots_ + capacity);
        capacity_ = capacity;
        for (int i = 0; i < capacity; ++i) order_[i] = i;
        clear();
    }

    void clear() { first_ = size_ = solved_ = 0; }

    int size() const { return size_; }
    int solved() const { return solved_; }
    bool full() const { return size_ == capacity_; }
    Slot& at(int i) { return slots_[order_[index(i)]]; }
    const Slot& at(int i) const { return slots_[order_[index(i)]]; }
    Slot& newest_solved() { return at(solved_ - 1); }
    const Slot& newest_solved() const { return at(solved_ - 1); }

    void mark_solved() { ++solved_; }

    // Puts a sample into the event of its time, or opens one. Events before `from` are closed. False: no room.
    bool insert(const Sample& sample, int from) {
        // Search from the newest end: almost every sample belongs there.
        int place = size_;
        while (place > from && at(place - 1).event.t_s > sample.t_s) --place;
        // A second sample of a channel at one time opens another event behind, so the first event that lacks it is it.
        int earliest = place;
        for (int i = place - 1; i >= from && at(i).event.t_s == sample.t_s && !at(i).event.has(sample.channel); --i) earliest = i;
        if (earliest < place) {
            at(earliest).event.add(sample);
            place = earliest;
        } else {
            if (full()) return false;
            open(place);
            at(place).event = Event::from(sample);
        }
        if (solved_ > place) solved_ = place;
        return true;
    }

    // Appends an event as it is; for loading.
    Slot& append() {
        open(size_);
        return at(size_ - 1);
    }

    // The freed slot is the next to be opened, while it is still in the cache.
    void remove_first() {
        const int freed = order_[first_];
        first_ = index(1);
        --size_;
        --solved_;
        order_[index(capacity_ - 1)] = order_[index(size_)];
        order_[index(size_)] = freed;
    }

    void remove(int place) {
        const int freed = order_[index(place)];
        for (int i = place; i + 1 < size_; ++i) order_[index(i)] = order_[index(i + 1)];
        order_[index(size_ - 1)] = freed;
        --size_;
        if (solved_ > place) solved_ = place;
    }

private:
    int index(int i) const {
        const int k = first_ + i;
        return k < capacity_ ? k : k - capacity_;
    }

    // Moves slot numbers, never slots: an insertion costs a few integers.
    void open(int place) {
        const int fresh = order_[index(size_)];
        for (int i = size_; i > place; --i) order_[index(i)] = order_[index(i - 1)];
        order_[index(place)] = fresh;
        ++size_;
    }

    Slot* slots_ = nullptr;
    int* order_ = nullptr; // ring of slot numbers in the order of time, then free ones
    int capacity_ = 0;
    int first_ = 0;
    int size_ = 0;
    int solved_ = 0;
};

} // namespace hnav
