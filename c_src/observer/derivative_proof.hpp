// Checks a plant's derivatives: each block is compared with central differences at the start and at four points within three
// sigma of it. A wrong block is named and replaced by differences. Example: the Reference FMU VanDerPol returns 0 for a
// derivative of 1.
#pragma once

#include "observer/linearisation.hpp"

namespace hnav::observer {

struct BlockProof {
    bool offered, exact;
    int row, column; // of the worst element: of the function, and of X
    double stated, measured; // its value by the plant and by differences
};

struct DerivativeProof {
    BlockProof block[functions][variables];
    bool repeatable; // repeated evaluations agree bit for bit, after others in between
    bool memoryless; // they agree to ten digits; otherwise the values depend on earlier calls
};

// work: 2 * rows * N doubles for the larger number of rows, then N + sizes.inputs + sizes.states.
int proof_doubles(const Problem& problem);

// Evaluates only derivatives that the plant offers. False: the plant fails at the start; why has the reason.
bool prove(Plant& plant, const Problem& problem, Linearisation& linearisation, double start_s, double* work,
           DerivativeProof* proof, Refusal& why);

} // namespace hnav::observer
