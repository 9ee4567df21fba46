/* Runs a filter over samples in one call, for an instruction counter that counts that call.
 *
 *     driver SAMPLES ROWS ahrs|hrekf run|smooth OUTPUTS [NAME=CHOICE ...]
 *
 * SAMPLES holds doubles: t_s (n), rate (n x 3), force (n x 3), field (n x 3). OUTPUTS: q or sigma. Names that changed are
 * macros of the command line that compiles this, as is SIZED where arrays of results begin with their size. */
#include "hnav/hnav.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int fail(const char *what) {
    fprintf(stderr, "driver: %s\n", what);
    return 1;
}

/* A choice by name into the options of a filter; nonzero when there is no such option or choice. */
static int choose(void *options, const char *filter, const char *setting) {
    const char *equals = strchr(setting, '=');
    const hnav_option_info *row;
    int32_t i, k;
    if (!equals) return 1;
    for (i = 0; (row = hnav_option(filter, i)) != NULL; ++i) {
        if (strlen(row->name) != (size_t)(equals - setting) || strncmp(row->name, setting, strlen(row->name)) != 0) continue;
        for (k = 0; k < row->choice_count; ++k)
            if (strcmp(row->choices[k], equals + 1) == 0) {
                memcpy((char *)options + row->offset, &k, sizeof k);
                return 0;
            }
    }
    return 1;
}

static double *read_doubles(FILE *file, size_t count) {
    double *values = malloc(count * sizeof *values);
    if (values && fread(values, sizeof *values, count, file) == count) return values;
    free(values);
    return NULL;
}

int main(int argc, char **argv) {
    hnav_ahrs_options ahrs = hnav_ahrs_defaults(HNAV_PRESET_DEFAULT);
    hnav_hrekf_options hrekf = hnav_hrekf_defaults(HNAV_PRESET_DEFAULT);
    hnav_run_input input;
    hnav_run_output output;
    hnav_filter *filter = NULL;
    hnav_status status;
    char message[400] = "";
    const int is_ahrs = argc > 3 && strcmp(argv[3], "ahrs") == 0;
    int i;
    if (argc < 6) return fail("SAMPLES ROWS ahrs|hrekf run|smooth q|sigma [NAME=CHOICE ...]");
    for (i = 6; i < argc; ++i)
        if (choose(is_ahrs ? (void *)&ahrs : (void *)&hrekf, argv[3], argv[i])) return fail(argv[i]);
    status = is_ahrs ? hnav_ahrs_create(&filter, &ahrs, message, sizeof message)
                     : hnav_hrekf_create(&filter, &hrekf, message, sizeof message);
    if (status != HNAV_OK) return fail(message);

    const size_t n = (size_t)atol(argv[2]);
    FILE *file = fopen(argv[1], "rb");
    if (!file) return fail("SAMPLES cannot be read");
    memset(&input, 0, sizeof input);
    memset(&output, 0, sizeof output);
#ifdef SIZED
    input.size = sizeof input;
    output.size = sizeof output;
#endif
    input.t_s = read_doubles(file, n);
    input.rate_b_rad_s = read_doubles(file, 3 * n);
    input.force_b_m_s2 = read_doubles(file, 3 * n);
    input.field_b_tesla = read_doubles(file, 3 * n);
    fclose(file);
    if (!input.field_b_tesla) return fail("SAMPLES ends early");
    output.q_nb = malloc(4 * n * sizeof(double));
    if (strcmp(argv[5], "sigma") == 0) output.sigma_rad = malloc(3 * n * sizeof(double));
    status = strcmp(argv[4], "smooth") == 0 ? hnav_filter_smooth(filter, n, &input, &output)
                                            : hnav_filter_run(filter, n, &input, &output, NULL);
    if (status != HNAV_OK) return fail(hnav_filter_message(filter));
    printf("%.17g\n", output.q_nb[4 * n - 1]);
    hnav_filter_destroy(filter);
    return 0;
}
