/* test_@prefix@.c: @rows_count@ ticks of a run of the simulator, one by one through
   the C, and inputs that are no numbers. Exit status 0 if all is as it should be. */
#include "@prefix@.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
% has_legs
#include <string.h>
% end has_legs

#define ROWS @rows_count@
#define COLUMNS @columns_count@
#define TOLERANCE @tolerance@
#define BADS 6

% starts_at_phases
static const float PHASES[@PREFIX@_LIMBS] = {0.0f};

% end starts_at_phases
/* @columns@. */
static const float GOLDEN[ROWS][COLUMNS] = {
@rows@
};

/* The largest size of each column. */
static const float SIZE[COLUMNS] = {
@sizes@
};

static const float BAD[BADS] = {NAN, INFINITY, -INFINITY, FLT_MAX, -FLT_MAX, 1.0e30f};

static float worse(float a, float b)
{
    return (b <= a) ? a : b;
}

/* The error of a number, relative to the golden one or to its column. */
static float error(float found, const float *row, int k)
{
    const float golden = fabsf(row[k]);
    return fabsf(found - row[k]) / ((golden > SIZE[k]) ? golden : SIZE[k]);
}

% turns
/* The same of an angle, of which whole turns do not count. */
static float around(float found, const float *row, int k)
{
    const float turn = 6.2831855f;
    float gap = fabsf(found - row[k]);
    gap = (turn - gap < gap) ? fabsf(turn - gap) : gap;
    return gap / turn;
}

% end turns
static float vector(const float *row)
{
    @prefix@_state state;
    @prefix@_inputs in = {@nothing@};
    @prefix@_outputs out;
    float worst = 0.0f;
    int k = 0;
    @prefix@_init(&state@phases@);
% put
    for (int i = 0; i < @PREFIX@_LIMBS; ++i) {
        @place@ = row[k++];
    }
% end put
    @prefix@_step(&state, &in, &out);
% compared
    for (int i = 0; i < @PREFIX@_LIMBS; ++i) {
        worst = worse(worst, @by@(@place@, row, k)); ++k;
    }
% end compared
    return out.fault ? INFINITY : worst;
}

static bool bounded(void)
{
    @prefix@_state state;
    @prefix@_inputs in = {@nothing@};
    @prefix@_outputs out;
    bool held = true;
% no senses
    (void)BAD;
% end senses
    @prefix@_init(&state@phases@);
    for (int turn = 0; turn < 100; ++turn) {
        for (int n = 0; n < BADS; ++n) {
% senses
            for (int i = 0; i < @PREFIX@_LIMBS; ++i) {
                in.@member@@several?[i]@ = BAD[(i + n) % BADS];
            }
% end senses
            @prefix@_step(&state, &in, &out);
% commands
            for (int i = 0; i < @PREFIX@_LIMBS; ++i) {
                held = held && (out.@member@@several?[i]@ >= @low@) && (out.@member@@several?[i]@ <= @high@);
            }
% end commands
        }
    }
    return held;
}

% has_legs
#define PLACES @PREFIX@_LIMBS * @commands_count@
#define ANGLES @PREFIX@_LIMBS * @PREFIX@_JOINTS

/* Places of feet, joints, torques of their servos, and loads, all leg by leg. */
static const float GOLDEN_LEGS[@leg_rows_count@][PLACES + 2 * (ANGLES) + @PREFIX@_LIMBS] = {
@leg_rows@
};

static float legs(const float *row)
{
    @prefix@_outputs out;
    float joints[@PREFIX@_LIMBS][@PREFIX@_JOINTS];
    float torques[@PREFIX@_LIMBS][@PREFIX@_JOINTS];
    float loads_n[@PREFIX@_LIMBS];
    float worst = 0.0f;
    int k = 0;
% commands
    for (int i = 0; i < @PREFIX@_LIMBS; ++i) {
        out.@member@@several?[i]@ = row[k++];
    }
% end commands
    @prefix@_joints(&out, joints);
    for (int i = 0; i < ANGLES; ++i) {
        worst = worse(worst, fabsf((&joints[0][0])[i] - row[k++]));
    }
    memcpy(joints, row + (PLACES), sizeof joints);
    memcpy(torques, row + k, sizeof torques);
    k += ANGLES;
    @prefix@_loads(joints, torques, loads_n);
    for (int i = 0; i < @PREFIX@_LIMBS; ++i, ++k) {
        worst = worse(worst, fabsf(loads_n[i] - row[k]) / (1.0f + row[k]));
    }
    return worst;
}

% end has_legs
int main(void)
{
    float worst = 0.0f;
    for (int i = 0; i < ROWS; ++i) {
        worst = worse(worst, vector(GOLDEN[i]));
    }
    printf("%d golden vectors, largest error %.2g (allowed %.2g)\n", ROWS, (double)worst,
        (double)TOLERANCE);
% has_legs
    float furthest = 0.0f;
    for (int i = 0; i < @leg_rows_count@; ++i) {
        furthest = worse(furthest, legs(GOLDEN_LEGS[i]));
    }
    printf("%d places of feet, largest error %.2g rad (allowed %.2g)\n", @leg_rows_count@,
        (double)furthest, (double)TOLERANCE);
    worst = worse(worst, furthest);
% end has_legs
    const bool held = bounded();
    printf("outputs of inputs that are no numbers: %s\n", held ? "bounded" : "OUT OF RANGE");
    return ((worst <= TOLERANCE) && held) ? 0 : 1;
}
