// Are a plant's derivatives derivatives? Each block is compared with central differences at the start and at four points
// in its three sigma; one that lies is named, and done by differences from then on. Plants that answer 0 for a derivative of 1 are
// on the market.
#pragma once

#include "observer/linearisation.hpp"

namespace hnav::observer {

struct BlockProof {
    bool offered, exact;
    int row, column; // of the worst element: of the function, among all that is estimated
    double told, measured; // there
};

struct DerivativeProof {
    BlockProof block[functions][variables];
    bool repeatable; // the same question has the same answer, bit for bit, after others
    bool memoryless; // the same to ten digits: otherwise the plant remembers
};

// work: 2 * rows * N doubles for the larger number of rows, then N + sizes.inputs + sizes.states.
int proof_doubles(const Problem& problem);

// Asks only what the plant offers. False: the plant has no answer at the start; why says which.
bool prove(Plant& plant, const Problem& problem, Linearisation& linearisation, double start_s, double* work,
           DerivativeProof* proof, Refusal& why);

} // namespace hnav::observer
