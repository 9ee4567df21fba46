/* From the reset of qemu's board to main: the unit for floating point on, files and text by semihosting. */
#include <stdint.h>
#include <stdlib.h>

extern char stack_top[];
extern void initialise_monitor_handles(void);
int main(void);

void begin(void);
void begin(void) {
    *(volatile uint32_t*)0xE000ED88 |= 0xFu << 20; /* CPACR: coprocessors 10 and 11 */
    __asm__ volatile("dsb\n\tisb");
    initialise_monitor_handles();
    exit(main());
}

/* A fault ends the run instead of hanging it. */
static void fault(void) {
    static const uint32_t internal_error[2] = {0x20024, 1};
    register uint32_t call __asm__("r0") = 0x20; /* SYS_EXIT_EXTENDED */
    register const uint32_t* what __asm__("r1") = internal_error;
    __asm__ volatile("bkpt 0xab" ::"r"(call), "r"(what) : "memory");
    for (;;) {
    }
}

__attribute__((section(".vectors"), used)) static void (*const vectors[16])(void) = {
    (void (*)(void))stack_top, begin, fault, fault, fault, fault, fault};

/* Asked for by the C library where there are no constructors. */
void _init(void);
void _init(void) {}
void _fini(void);
void _fini(void) {}
