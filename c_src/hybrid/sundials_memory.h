// Included before every file of SUNDIALS that hnav builds (cmake/sundials.cmake): replaces its memory functions. For the
// reason see sundials_memory.hpp.
#ifndef HNAV_SUNDIALS_MEMORY_H
#define HNAV_SUNDIALS_MEMORY_H

#include <stdlib.h>

#ifdef __cplusplus
extern "C" {
#endif

void* hnav_sundials_malloc(size_t bytes);
void* hnav_sundials_calloc(size_t count, size_t bytes);
void* hnav_sundials_realloc(void* piece, size_t bytes);
void hnav_sundials_free(void* piece);

#ifdef __cplusplus
}
#else
#define malloc hnav_sundials_malloc
#define calloc hnav_sundials_calloc
#define realloc hnav_sundials_realloc
#define free hnav_sundials_free
#endif

#endif
