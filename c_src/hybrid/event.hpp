// A sample and the event it belongs to. This layer knows time and channels; what a channel measures is the model's.
#pragma once

#include <cstdint>
#include <cstring>

namespace hnav {

constexpr int event_channels = 4;
constexpr int event_values = 3;

// One reading of one channel. Channels are numbered in the order in which samples of equal time are to act.
struct Sample {
    double t_s;
    int channel;
    double value[event_values];
};

// All samples of one instant: the model corrects them together, so the order of their arrival cannot matter.
// Eight-byte members only, so that events can be saved as plain numbers.
struct Event {
    double t_s;
    std::uint64_t present; // bit c: channel c has a sample
    double value[event_channels][event_values];

    bool has(int channel) const { return (present >> channel) & 1u; }

    void add(const Sample& sample) {
        present |= std::uint64_t{1} << sample.channel;
        std::memcpy(value[sample.channel], sample.value, sizeof sample.value);
    }

    static Event from(const Sample& sample) {
        Event event{};
        event.t_s = sample.t_s;
        event.add(sample);
        return event;
    }
};

} // namespace hnav
