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
    // By 1 or -1: somebody who is none of the holders holds it once more, or less.
    void hold(const double* numbers, int by);
    // The instance ends, and its copies with it.
    void forget(FmiInstance& fmi);

private:
    int free_copy(FmiInstance& fmi, const Holders& holders, int offset);
    void free_unheld(FmiInstance& fmi, const Holders& holders, int offset);
    int place_of(double number) const { return number >= 1 && number <= copies_ ? static_cast<int>(number) - 1 : -1; }

    bool serialises_ = false;
    int bytes_ = 0; // room for a serialised state
    struct Copy {
        void* state;
        int held; // from outside
        bool seen; // at a holder
    };
    Copy* copy_ = nullptr; // by number - 1; serialised ones pass through the first
    int copies_ = 0;
};

} // namespace hnav::observer
