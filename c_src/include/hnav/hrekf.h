/* HREKF: the filter of the paper on the alignment of a strapdown system. Its calls are those of filter.h and, but for hnav_filter_smooth,
 * those of ahrs.h. */
#ifndef HNAV_HREKF_H
#define HNAV_HREKF_H

#include "hnav/ahrs.h"
#include "hnav/options/hrekf.h"

#ifdef __cplusplus
extern "C" {
#endif

/* preset: HNAV_PRESET_DEFAULT or HNAV_PRESET_PAPER. */
HNAV_API hnav_hrekf_options hnav_hrekf_defaults(hnav_preset preset);
/* Makes an HREKF. On failure *filter is null and the reason stands in message (may be null). */
HNAV_API hnav_status hnav_hrekf_create(hnav_filter** filter, const hnav_hrekf_options* options, char* message,
                                       size_t message_size);

/* The same in memory of the caller's, by the closed form alone (solver = HNAV_SOLVER_CLOSED_FORM): nothing is taken from
 * elsewhere, now or later. bytes: at least those that the call before tells for the options, of any alignment; it tells 0 for
 * options that make no filter. The memory is the caller's again when the filter is no longer used. Errors beside those of
 * create: SIZE, UNSUPPORTED (another solver). */
HNAV_API size_t hnav_hrekf_memory_bytes(const hnav_hrekf_options* options);
HNAV_API hnav_status hnav_hrekf_create_in(void* memory, size_t bytes, hnav_filter** filter, const hnav_hrekf_options* options,
                                          char* message, size_t message_size);

#ifdef __cplusplus
}
#endif

#endif /* HNAV_HREKF_H */
