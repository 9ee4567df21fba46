// What a measurement weighs that lies beyond its gate, by over = NIS / limit > 1. A product names its law:
//
//   noise        R <- over R                                observer
//   innovation   S <- over S                                HREKF, headings of the AHRS: the NIS becomes the limit (Chang 2014)
//   redescending H P H' <- over H P H', R <- over^2 R       INS: the influence falls with the distance. Positions 100 m off for 10 s
//                move a simulated car by 1.6 m with it and by 8.8 m with `noise`; for 60 s, accepted, by 1.8 and 47 m
//   rejected     nothing is learnt                          the field of the AHRS, for a limited time
//
// None rejects for good: a filter that does never finds that it was wrong. The limits are NIS, with a chi-square distribution of as many
// degrees of freedom as the measurement has rows.
#pragma once

namespace hnav {

// NIS / limit beyond the gate, 1 within; a limit of 0 is no gate.
template <class R>
inline R beyond_gate(R nis, R limit) {
    return limit > 0 && nis > limit ? nis / limit : R(1);
}

// The limit for so many rows, from that for three: 99.9 % of chi square with 1, 2, 3 degrees of freedom are 10.8, 13.8, 16.3.
inline double gate_for_rows(int rows, double limit_of_three) {
    constexpr double share[] = {0.66, 0.85, 1};
    return share[rows - 1] * limit_of_three;
}

} // namespace hnav
