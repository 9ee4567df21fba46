// Time-sorted events, each with room for the state just after it.
//
// The events form a chain: base, solved, solved, ..., waiting, waiting. The base is the newest event that can no longer
// change; a state is solved when it follows from its predecessor. A sample that lands inside the chain takes the
// solution from its place onward back, so a late sample costs the events behind it and nothing else.
#pragma once

#include "base/instant.hpp"
#include "hybrid/sizes.hpp"

#include <algorithm>

namespace hnav {

// Sizes: see sizes.hpp. It is a base class, so that sizes known at compile time take no memory.
template <class Sizes>
class EventQueue : private Sizes {
public:
    using Event = typename Sizes::Event;
    using State = typename Sizes::State;

    // There are fewer states than events: the states of solved events, which are consecutive, form a ring; the free one
    // behind them is for the caller.
    static constexpr bool has_ring = Sizes::states > 0;

    static std::size_t bytes(const Sizes& sizes, int capacity) {
        return static_cast<std::size_t>(capacity) * sizes.event_bytes() +
               static_cast<std::size_t>(states_for(capacity)) * (sizes.state_bytes() + sizeof(std::uint64_t)) +
               static_cast<std::size_t>(places_for(capacity)) * sizeof(unsigned char*);
    }

    // memory: zeros of the given size, aligned for doubles; owned by the caller. Of a large queue only what is used is touched.
    void create(void* memory, const Sizes& sizes, int capacity) {
        static_cast<Sizes&>(*this) = sizes;
        auto* const slots = static_cast<unsigned char*>(memory);
        ring_ = slots + static_cast<std::size_t>(capacity) * slot_bytes();
        tags_ = reinterpret_cast<std::uint64_t*>(ring_ + Sizes::states * this->state_bytes());
        order_ = reinterpret_cast<unsigned char**>(tags_ + Sizes::states);
        capacity_ = capacity;
        last_place_ = places_for(capacity) - 1;
        first_ = 0;
        for (int i = 0; i < capacity; ++i) order_[i] = slots + static_cast<std::size_t>(i) * slot_bytes();
        clear();
    }

    void clear() { size_ = solved_ = first_state_ = 0; }

    const Sizes& sizes() const { return *this; }
    int size() const { return size_; }
    int solved() const { return solved_; }
    bool full() const { return size_ == capacity_; }
    Event& event(int i) { return *reinterpret_cast<Event*>(slot(i)); }
    const Event& event(int i) const { return *reinterpret_cast<const Event*>(slot(i)); }
    State& after(int i) { return *reinterpret_cast<State*>(state_place(i)); }
    const State& after(int i) const { return *reinterpret_cast<const State*>(state_place(i)); }

    // A number that stays with the slot of the state after an event, for the caller's use; initially 0.
    std::uint64_t& tag(int i) {
        if constexpr (has_ring) return tags_[ring_index(i)];
        else return *reinterpret_cast<std::uint64_t*>(state_place(i) + this->state_bytes());
    }

    void mark_solved() { ++solved_; }

    // Puts a sample into the event of its instant, or opens an event, whose time is the earliest stamp of its samples, so
    // that their order has no effect. Events before `from` are closed. Null: no room.
    Event* insert(const typename Event::Sample& sample, double t_s, int from) {
        const double near_s = sample_instant_s(t_s);
        // The most frequent case: the sample belongs to the newest event, the only one of its time.
        if (size_ > from && solved_ < size_) {
            Event& newest = event(size_ - 1);
            if (newest.t_s == t_s && !newest.has(sample.channel) && event(size_ - 2).t_s < t_s - near_s) {
                newest.add(sample);
                return &newest;
            }
        }
        // Searches from the newest end.
        int place = size_;
        while (place > from && event(place - 1).t_s > t_s + near_s) --place;
        // A second sample of a channel at one instant opens another event behind; the sample goes into the first event that
        // lacks its channel.
        int earliest = place;
        for (int i = place - 1; i >= from && event(i).t_s >= t_s - near_s && !event(i).has(sample.channel); --i) earliest = i;
        if (earliest < place) {
            place = earliest;
            event(place).t_s = not_before(place, std::min(event(place).t_s, t_s));
        } else {
            if (full()) return nullptr;
            open(place);
            Sizes::clear(event(place), not_before(place, t_s));
        }
        event(place).add(sample);
        if (solved_ > place) solved_ = place;
        return &event(place);
    }

    // Opens the place behind the last event; the caller writes its event and state.
    void append() { open(size_); }

    // The freed slot is opened next, while it is still in the cache.
    void remove_first() {
        unsigned char* const freed = order_[first_];
        first_ = index(1);
        if constexpr (has_ring) first_state_ = ring_index(1);
        --size_;
        --solved_;
        order_[index(capacity_ - 1)] = order_[index(size_)];
        order_[index(size_)] = freed;
    }

    void remove(int place) {
        unsigned char* const freed = order_[index(place)];
        for (int i = place; i + 1 < size_; ++i) order_[index(i)] = order_[index(i + 1)];
        order_[index(size_ - 1)] = freed;
        --size_;
        if (solved_ > place) solved_ = place;
    }

private:
    static int states_for(int capacity) { return has_ring ? Sizes::states : capacity; }
    // A power of two, so that a mask wraps an index.
    static int places_for(int capacity) {
        int places = 1;
        while (places < capacity) places *= 2;
        return places;
    }
    // An event; behind it its state and tag, if there are as many states as events.
    std::size_t slot_bytes() const { return this->event_bytes() + (has_ring ? 0 : this->state_bytes() + sizeof(std::uint64_t)); }
    unsigned char* slot(int i) const { return order_[index(i)]; }

    int ring_index(int i) const { return (first_state_ + i) % Sizes::states; }
    unsigned char* state_place(int i) const {
        if constexpr (has_ring) return ring_ + ring_index(i) * this->state_bytes();
        else return slot(i) + this->event_bytes();
    }

    int index(int i) const { return (first_ + i) & last_place_; }

    // Clamps the time of an event at this place to that of the one before.
    double not_before(int place, double t_s) const { return place > 0 ? std::max(event(place - 1).t_s, t_s) : t_s; }

    // Moves pointers, never slots.
    void open(int place) {
        unsigned char* const fresh = order_[index(size_)];
        for (int i = size_; i > place; --i) order_[index(i)] = order_[index(i - 1)];
        order_[index(place)] = fresh;
        ++size_;
    }

    unsigned char* ring_ = nullptr; // of states, if there is one
    std::uint64_t* tags_ = nullptr; // of its states
    unsigned char** order_ = nullptr; // ring of slots in the order of time, then free ones
    int capacity_ = 0;
    int last_place_ = 0; // in order_
    int first_ = 0;
    int first_state_ = 0; // of the base, in the ring
    int size_ = 0;
    int solved_ = 0;
};

} // namespace hnav
