/* What is measured: one filter of a processor, a sample at a time. Each source beside this is one, or two by its defines. */
#ifndef CONTENDER_H
#define CONTENDER_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* interval_s: between samples. 0: it is ready. */
int contender_begin(double interval_s);
/* SI units. 0: taken, and q shows the attitude, or is as it was before there is one. */
int contender_step(double t_s, const double rate[3], const double force[3], const double field[3], double q[4]);
size_t contender_bytes(void); /* of memory that one filter takes */

#ifdef __cplusplus
}
#endif

#endif
