// What timed programs ask: the time that this thread has had of a processor, whatever else the machine does.
#pragma once

#include <time.h>

inline double cpu_s() {
    timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}
