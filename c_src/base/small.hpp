// The small build, for processors with little memory: the attitude filters by their closed forms, in memory owned by the
// caller. CMake sets HNAV_SMALL; sources test this constant by `if constexpr`.
#pragma once

namespace hnav {

#ifdef HNAV_SMALL
constexpr bool small_build = true;
#else
constexpr bool small_build = false;
#endif

} // namespace hnav

// Marks a function whose arguments the small build does not use: inlined it leaves no code for them.
#ifdef HNAV_SMALL
#define HNAV_SMALL_INLINE __attribute__((always_inline))
#else
#define HNAV_SMALL_INLINE
#endif
