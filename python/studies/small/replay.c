/* Filters a file of samples, on this machine or in qemu:  replay SAMPLES ROWS ANSWERS
 *
 * SAMPLES holds doubles: t_s (n), rate (n x 3), force (n x 3), field (n x 3). ANSWERS gets n x 4. Prints the bytes of a filter
 * and of the stack that it used, there. qemu has no arguments: there they are samples.bin, rows.txt and answers.bin. */
#include "contender.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { max_rows = 20000, painted = 64 * 1024 };
static double samples[10 * max_rows], answers[4 * max_rows];

/* The stack below its caller is painted before the filter runs; what has lost its paint was used. Here nothing else runs beside
 * the program, which a system would not allow. */
#ifdef __arm__
static volatile unsigned char* painted_end;

static void paint(void) {
    painted_end = (unsigned char*)__builtin_frame_address(0) - 64;
    for (size_t i = 1; i <= painted; ++i) painted_end[-(ptrdiff_t)i] = 0xa5;
}

static size_t used_stack(void) {
    size_t unused = 0;
    while (unused < painted && painted_end[(ptrdiff_t)unused - painted] == 0xa5) ++unused;
    return painted - unused;
}
#else
static void paint(void) {}
static size_t used_stack(void) { return 0; }
#endif

__attribute__((noinline)) static int run(size_t n) {
    const double *rate = samples + n, *force = samples + 4 * n, *field = samples + 7 * n;
    double q[4] = {1, 0, 0, 0};
    int status = contender_begin((samples[n - 1] - samples[0]) / (double)(n - 1));
    for (size_t k = 0; status == 0 && k < n; ++k) {
        status = contender_step(samples[k], rate + 3 * k, force + 3 * k, field + 3 * k, q);
        memcpy(answers + 4 * k, q, sizeof q);
    }
    return status;
}

static int replay(const char* samples_file, size_t n, const char* answers_file) {
    if (n < 2 || n > max_rows) return 2;
    FILE* file = fopen(samples_file, "rb");
    if (!file || fread(samples, sizeof(double), 10 * n, file) != 10 * n) return 3;
    fclose(file);
    paint();
    const int status = run(n);
    const size_t stack = used_stack();
    if (status != 0) return 100 + status;
    file = fopen(answers_file, "wb");
    if (!file || fwrite(answers, sizeof(double), 4 * n, file) != 4 * n || fclose(file) != 0) return 4;
    printf("%lu %lu\n", (unsigned long)contender_bytes(), (unsigned long)stack);
    return 0;
}

#ifdef __arm__
int main(void) {
    char rows[16] = "";
    FILE* file = fopen("rows.txt", "r");
    if (!file || !fgets(rows, sizeof rows, file)) return 1;
    fclose(file);
    return replay("samples.bin", strtoul(rows, NULL, 10), "answers.bin");
}
#else
int main(int argc, char** argv) { return argc == 4 ? replay(argv[1], strtoul(argv[2], NULL, 10), argv[3]) : 1; }
#endif
