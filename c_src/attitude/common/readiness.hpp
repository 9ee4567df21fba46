// When an estimate may be relied upon. A small sigma is not enough: it may be the sigma that the filter started with, or
// one that has shrunk without evidence. So an angle is ready when its sigma is below a limit and the corrections since
// the start have brought at least as much information as that limit stands for.
#pragma once

namespace hnav {

// Information about an angle that a correction brought, 1/rad^2, from its variances before and after.
inline double information_gained(double before, double after) { return after > 0 && before > after ? 1 / after - 1 / before : 0; }

inline bool angle_ready(double variance, double information, double limit_rad) {
    return variance < limit_rad * limit_rad && information > 1 / (limit_rad * limit_rad);
}

} // namespace hnav
