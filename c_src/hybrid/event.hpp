// A sample and the event it belongs to. This layer has time and channels; what a channel measures is the model's.
//
// All samples of one instant are one event: the model corrects them together, so the order of their arrival cannot matter.
// How many channels there are and how many values a reading has is the model's too, known when it is compiled (FixedEvent)
// or only when it is made (RuntimeEvent). Events hold eight-byte numbers only, so that they are saved as they stand.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace hnav {

constexpr int max_channels = 63; // bits of Event::present; the last one says that a new time base begins
constexpr std::uint64_t new_time_base = std::uint64_t{1} << max_channels;

template <int channels, int values>
struct FixedEvent {
    static_assert(channels <= max_channels);
    static constexpr int channel_count = channels;

    // One reading of one channel. Channels are numbered in the order in which samples of equal time are to act.
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

// The head of an event whose values, as many for each channel, stand behind it in memory.
class RuntimeEvent {
public:
    struct Sample {
        double t_s;
        int channel;
        const double* value; // as many as a reading has
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
