// Marks a function that few samples need: inlined it would slow down the others by saving registers for it. In the small
// build the compiler decides by size.
#pragma once

#include "base/small.hpp"

#ifdef HNAV_SMALL
#define HNAV_RARE
#else
#define HNAV_RARE __attribute__((noinline))
#endif
