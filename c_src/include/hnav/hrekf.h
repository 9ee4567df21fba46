/* HREKF: the filter of the paper on the alignment of a strapdown system. It has the calls of filter.h, and those of ahrs.h except
 * hnav_filter_smooth. */
#ifndef HNAV_HREKF_H
#define HNAV_HREKF_H

#include "hnav/ahrs.h"
#include "hnav/options/hrekf.h"

#ifdef __cplusplus
extern "C" {
#endif

/* preset: HNAV_PRESET_DEFAULT or HNAV_PRESET_PAPER. */
HNAV_API hnav_hrekf_options hnav_hrekf_defaults(hnav_preset preset);
/* Makes an HREKF. On failure *filter is null and message (may be null) has the reason. */
HNAV_API hnav_status hnav_hrekf_create(hnav_filter** filter, const hnav_hrekf_options* options, char* message,
                                       size_t message_size);

/* The same in the caller's memory, without any allocation; requires solver = HNAV_SOLVER_CLOSED_FORM.
 * bytes: at least the result of hnav_hrekf_memory_bytes for the options (0 for invalid options), with any alignment.
 * The caller may reuse the memory when the filter is no longer used.
 * Errors beside those of create: SIZE, UNSUPPORTED (another solver). */
HNAV_API size_t hnav_hrekf_memory_bytes(const hnav_hrekf_options* options);
HNAV_API hnav_status hnav_hrekf_create_in(void* memory, size_t bytes, hnav_filter** filter, const hnav_hrekf_options* options,
                                          char* message, size_t message_size);

#ifdef __cplusplus
}
#endif

#endif /* HNAV_HREKF_H */
