// The discrete state of an FMU as numbers: its serialised state if it supports that, otherwise the number of a copy in the FMU.
// Copies without a holder are reused.
#pragma once

#include "observer/fmi_instance.hpp"

namespace hnav::observer {

class FmuMemory {
public:
    ~FmuMemory();

    // Queries the size from the instance. False: not supported.
    bool create(FmiInstance& fmi, bool serialises);
    int numbers() const { return serialises_ ? 1 + bytes_ / 8 : 1; }
    bool serialises() const { return serialises_; }

    // The present state of the instance.
    Answer store(FmiInstance& fmi, const Holders& holders, int offset, double* numbers);
    Answer load(FmiInstance& fmi, const double* numbers);
    // By 1 or -1: a holder outside the list, such as a snapshot, begins or ends to hold it.
    void hold(const double* numbers, int by);
    // The instance and its copies end.
    void forget(FmiInstance& fmi);

private:
    int free_copy(FmiInstance& fmi, const Holders& holders, int offset);
    void free_unheld(FmiInstance& fmi, const Holders& holders, int offset);
    int place_of(double number) const { return number >= 1 && number <= copies_ ? static_cast<int>(number) - 1 : -1; }

    bool serialises_ = false;
    int bytes_ = 0; // size of a serialised state
    struct Copy {
        void* state;
        int held; // by snapshots
        bool seen; // by a holder
    };
    Copy* copy_ = nullptr; // by number - 1; serialised ones pass through the first
    int copies_ = 0;
};

} // namespace hnav::observer
