/* A program that does nothing but filter: its size is what a filter adds to a processor, with all that it calls. */
#include "contender.h"

static volatile double sample[10], attitude[4];

void _exit(int status);
void bare(void);

void bare(void) {
    contender_begin(sample[0]);
    for (;;) {
        double s[10], q[4] = {1, 0, 0, 0};
        for (int i = 0; i < 10; ++i) s[i] = sample[i];
        contender_step(s[0], s + 1, s + 4, s + 7, q);
        for (int i = 0; i < 4; ++i) attitude[i] = q[i];
    }
}

/* What a C++ runtime asks for when there is no system. */
void _exit(int status) {
    (void)status;
    for (;;) {
    }
}
