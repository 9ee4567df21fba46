// The small build, for processors with little memory: the attitude filters by their closed forms, in memory of the caller's.
// CMake says which build this is (HNAV_SMALL); sources ask here, by `if constexpr`.
#pragma once

namespace hnav {

#ifdef HNAV_SMALL
constexpr bool small_build = true;
#else
constexpr bool small_build = false;
#endif

} // namespace hnav

// Of a function whose arguments the small build does not use: put in the place of its call it leaves none of them behind.
#ifdef HNAV_SMALL
#define HNAV_SMALL_INLINE __attribute__((always_inline))
#else
#define HNAV_SMALL_INLINE
#endif
