// A sample and the event it belongs to. This layer has times and channels; the model defines what a channel measures.
//
// All samples of one instant form one event: the model corrects with them together, so the order of their arrival has no
// effect. The model also defines the number of channels and of values of a reading, at compile time (FixedEvent) or at
// creation (RuntimeEvent). Events contain eight-byte numbers only, so that they can be saved bytewise.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace hnav {

constexpr int max_channels = 63; // bits of Event::present; the last one marks the begin of a new time base
constexpr std::uint64_t new_time_base = std::uint64_t{1} << max_channels;

template <int channels, int values>
struct FixedEvent {
    static_assert(channels <= max_channels);
    static constexpr int channel_count = channels;

    // One reading of one channel. Channels are numbered in the order in which simultaneous samples take effect.
    struct Sample {
        double t_s;
        int channel;
        double value[values];
    };

    double t_s;
    std::uint64_t present; // bit c: channel c has a sample
    double value[channels][values];

    bool has(int channel) const { return (present >> channel) & 1u; }
    bool begins_time_base() const { return (present & new_time_base) != 0; }

    void add(const Sample& sample) {
        present |= std::uint64_t{1} << sample.channel;
        std::memcpy(value[sample.channel], sample.value, sizeof sample.value);
    }
};

// The head of an event; its values, the same number for each channel, follow it in memory.
class RuntimeEvent {
public:
    struct Sample {
        double t_s;
        int channel;
        const double* value; // number of values of a reading
    };

    double t_s;
    std::uint64_t present;
    std::uint64_t values; // of one reading

    static std::size_t bytes(int channels, int values) {
        return sizeof(RuntimeEvent) + static_cast<std::size_t>(channels) * static_cast<std::size_t>(values) * sizeof(double);
    }

    static constexpr int channel_count = max_channels;

    bool has(int channel) const { return (present >> channel) & 1u; }
    bool begins_time_base() const { return (present & new_time_base) != 0; }
    const double* value(int channel) const { return reinterpret_cast<const double*>(this + 1) + channel * values; }

    void add(const Sample& sample) {
        present |= std::uint64_t{1} << sample.channel;
        std::memcpy(const_cast<double*>(value(sample.channel)), sample.value, values * sizeof(double));
    }
};

} // namespace hnav
