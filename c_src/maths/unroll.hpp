// Loops over sizes known when compiled, triangles above all, which compilers leave as loops unless told: a third of the
// instructions. Not where code is to be small.
#pragma once

#ifdef __OPTIMIZE_SIZE__
#define HNAV_UNROLL
#else
#define HNAV_UNROLL _Pragma("GCC unroll 16")
#endif
