// Unrolled loops over compile-time sizes, mainly triangles, which compilers do not unroll by themselves: saves a third of the
// instructions. Off in the small build.
#pragma once

#ifdef __OPTIMIZE_SIZE__
#define HNAV_UNROLL
#else
#define HNAV_UNROLL _Pragma("GCC unroll 16")
#endif
