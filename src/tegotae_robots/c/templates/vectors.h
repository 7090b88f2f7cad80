#include "@prefix@.h"
#define NAME(x) @prefix@_ ## x
#define TICKS @ticks@
#define INIT(s) @prefix@_init(s@phases@)
static const float ROWS[TICKS][@columns_count@] = {
@rows@
};
static void put(@prefix@_state *state, @prefix@_inputs *in, const float *row)
{
    int k = 0;
    (void)state; (void)in;
% put
    for (int i = 0; i < @limbs@; ++i) { @place@ = row[k++]; }
% end put
}
static void stepped(@prefix@_state *state, const @prefix@_inputs *in, @prefix@_outputs *out)
{
    @prefix@_step(state, in, out);
% has_legs
    float joints[@PREFIX@_LIMBS][@PREFIX@_JOINTS];
    @prefix@_joints(out, joints);
    __asm__ volatile("" : : "r"(joints) : "memory");
% end has_legs
}
