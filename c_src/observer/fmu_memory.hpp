// What an FMU remembers, in numbers: its serialised state where it can do that, otherwise the number of a copy that the FMU keeps.
// Copies that nobody holds any more are used again.
#pragma once

#include "observer/fmi_instance.hpp"

namespace hnav::observer {

class FmuMemory {
public:
    ~FmuMemory();

    // Learns from the instance how large it is. False: the instance cannot do it.
    bool create(FmiInstance& fmi, bool serialises);
    int numbers() const { return serialises_ ? 1 + bytes_ / 8 : 1; }
    bool serialises() const { return serialises_; }

    // The instance as it is now.
    Answer store(FmiInstance& fmi, const Holders& holders, int offset, double* numbers);
    Answer load(FmiInstance& fmi, const double* numbers);
    // The instance ends, and its copies with it.
    void forget(FmiInstance& fmi);

private:
    int free_copy(FmiInstance& fmi, const Holders& holders, int offset);

    bool serialises_ = false;
    int bytes_ = 0; // room for a serialised state
    void** copy_ = nullptr; // by number - 1; serialised ones pass through the first
    bool* held_ = nullptr;
    int copies_ = 0;
};

} // namespace hnav::observer
