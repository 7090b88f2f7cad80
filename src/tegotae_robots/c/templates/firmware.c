/* Counts what the ticks of a controller take, on an emulated microcontroller. */
#include <stdint.h>

#include "vectors.h"

typedef void (*stepper)(NAME(state) *, const NAME(inputs) *, NAME(outputs) *);

extern uint32_t stack_top;
void reset(void);

__attribute__((section(".vectors"), used)) static const uintptr_t VECTORS[16] = {
    (uintptr_t)&stack_top, (uintptr_t)&reset,
};

#define SYSTICK ((volatile uint32_t *)0xE000E010u) /* control, reload, value */
#define COPROCESSORS (*(volatile uint32_t *)0xE000ED88u)
#define STACK_BYTES 4096u
#define PATTERN 0xA5A5A5A5u

static uint32_t called(uint32_t operation, const void *argument)
{
    register uint32_t r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

static void print(uint32_t value)
{
    char text[12];
    int at = 11;
    text[at] = '\0';
    text[--at] = ' ';
    do {
        text[--at] = (char)('0' + value % 10u);
        value /= 10u;
    } while (value > 0u);
    called(0x04u, &text[at]);
}

static __attribute__((noinline)) void idle(
    NAME(state) *state, const NAME(inputs) *in, NAME(outputs) *out)
{
    __asm__ volatile("" : : "r"(state), "r"(in), "r"(out) : "memory");
}

static __attribute__((noinline)) uint32_t counted(stepper step)
{
    NAME(state) state;
    NAME(inputs) in;
    NAME(outputs) out;
    INIT(&state);
    SYSTICK[2] = 0u;
    const uint32_t from = SYSTICK[2];
    for (int i = 0; i < TICKS; ++i) {
        put(&state, &in, ROWS[i]);
        step(&state, &in, &out);
    }
    return (from - SYSTICK[2]) & 0xFFFFFFu;
}

/* How deep the stack gets, in bytes, seen by what it writes over. */
static __attribute__((noinline)) uint32_t deepest(stepper step)
{
    NAME(state) state;
    NAME(inputs) in;
    NAME(outputs) out;
    volatile uint32_t *here;
    uint32_t untouched = 0u;
    INIT(&state);
    __asm__ volatile("mov %0, sp" : "=r"(here));
    volatile uint32_t *end = here - STACK_BYTES / 4u;
    for (volatile uint32_t *p = end; p < here; ++p) {
        *p = PATTERN;
    }
    for (int i = 0; i < TICKS; ++i) {
        put(&state, &in, ROWS[i]);
        step(&state, &in, &out);
    }
    while (end + untouched < here && end[untouched] == PATTERN) {
        ++untouched;
    }
    return STACK_BYTES - 4u * untouched;
}

void reset(void)
{
#if defined(__ARM_FP)
    COPROCESSORS |= 0xFu << 20;
    __asm__ volatile("dsb\n isb");
#endif
    SYSTICK[1] = 0xFFFFFFu;
    SYSTICK[0] = 5u;
#if WITH_STEP
    const stepper step = stepped;
#else
    const stepper step = idle;
#endif
    print(TICKS);
    print(counted(step));
    print(counted(idle));
    print(sizeof(NAME(state)) + sizeof(NAME(inputs)) + sizeof(NAME(outputs)));
    print(deepest(step));
    called(0x18u, (const void *)0x20026u);
    for (;;) {
    }
}
