// Of a function that few samples need: put in the place of its call it would slow down all the others, which save registers for
// it. The small build decides by size.
#pragma once

#include "base/small.hpp"

#ifdef HNAV_SMALL
#define HNAV_RARE
#else
#define HNAV_RARE __attribute__((noinline))
#endif
