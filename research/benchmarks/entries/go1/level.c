/* level.c: level. Written by tegotae from the code that its simulator runs. All numbers are
   float; nothing is allocated; there is no state but the caller's. */
#include "level.h"

#include <float.h>
#include <math.h>
#include <string.h>

static const float TICK_S = LEVEL_TICK_S;

typedef struct {
    float stride_m;
    float lift_m;
    float press_m;
    float shift_rad;
    float roll_m;
    float roll_rate_ms;
    float pitch_m;
    float yaw;
} actuation_weights;

typedef struct {
    actuation_weights actuation;
} unit_weights;

static const unit_weights WEIGHTS = {
    .actuation = {
        .stride_m = 0.25924504f, .lift_m = 0.32593545f, .press_m = 0.039552495f,
            .shift_rad = 0.44496825f, .roll_m = 0.033115976f, .roll_rate_ms = 0.25121632f,
            .pitch_m = -0.28379995f, .yaw = 0.0f
    },
};

/* All that the terms of a unit may read. */
typedef struct {
    float end_pitch; /* rad */
    float side_roll; /* rad */
    float side_roll_rate; /* rad/s */
    float side_yaw; /* rad */
    float sin_phase;
    float cos_phase;
} signals;

/* A leg in the axes of the trunk, its lengths over LENGTH_M. */
typedef struct {
    float axis[3][3];   /* of every joint, from the trunk on */
    float anchor[3][3]; /* a point on each axis */
    float slides[3];    /* 1 of a joint that slides, 0 of one that turns */
    float foot[3];
    float low[3];       /* limits, from the start on */
    float high[3];
    float start[3];     /* joints at rest [rad or m] */
    float unit[3];      /* of a joint's number [rad or m] */
} leg_geometry;

static const float LENGTH_M = 0.506f;
static const leg_geometry LEGS[4] = {
    {{{1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}, {0.0f, 1.0f, 0.0f}}, {{0.37173912f, 0.092391305f,
        0.0f}, {0.37173912f, 0.25049406f, 0.0f}, {0.04199875f, 0.25049406f, -0.26166585f}},
        {0.0f, 0.0f, 0.0f}, {0.37173912f, 0.25049406f, -0.5233317f}, {-0.863f, -1.586f,
        -1.018f}, {0.863f, 3.601f, 0.912f}, {0.0f, 0.9f, -1.8f}, {1.0f, 1.0f, 1.0f}},
    {{{1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}, {0.0f, 1.0f, 0.0f}}, {{0.37173912f, -0.092391305f,
        0.0f}, {0.37173912f, -0.25049406f, 0.0f}, {0.04199875f, -0.25049406f, -0.26166585f}},
        {0.0f, 0.0f, 0.0f}, {0.37173912f, -0.25049406f, -0.5233317f}, {-0.863f, -1.586f,
        -1.018f}, {0.863f, 3.601f, 0.912f}, {0.0f, 0.9f, -1.8f}, {1.0f, 1.0f, 1.0f}},
    {{{1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}, {0.0f, 1.0f, 0.0f}}, {{-0.37173912f, 0.092391305f,
        0.0f}, {-0.37173912f, 0.25049406f, 0.0f}, {-0.7014795f, 0.25049406f, -0.26166585f}},
        {0.0f, 0.0f, 0.0f}, {-0.37173912f, 0.25049406f, -0.5233317f}, {-0.863f, -1.586f,
        -1.018f}, {0.863f, 3.601f, 0.912f}, {0.0f, 0.9f, -1.8f}, {1.0f, 1.0f, 1.0f}},
    {{{1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}, {0.0f, 1.0f, 0.0f}}, {{-0.37173912f,
        -0.092391305f, 0.0f}, {-0.37173912f, -0.25049406f, 0.0f}, {-0.7014795f, -0.25049406f,
        -0.26166585f}}, {0.0f, 0.0f, 0.0f}, {-0.37173912f, -0.25049406f, -0.5233317f}, {-0.863f,
        -1.586f, -1.018f}, {0.863f, 3.601f, 0.912f}, {0.0f, 0.9f, -1.8f}, {1.0f, 1.0f, 1.0f}}
};

/* The larger of two; not a number, if one of them is none. */
static float larger(float a, float b)
{
    return ((a > b) || (a != a)) ? a : b;
}

/* The smaller of two; not a number, if one of them is none. */
static float smaller(float a, float b)
{
    return ((a < b) || (a != a)) ? a : b;
}

/* The sum, modulo 2^32. */
static int32_t sum_of(int32_t a, int32_t b)
{
    return (int32_t)((uint32_t)a + (uint32_t)b);
}

/* The bits of a float. */
static int32_t bits_of(float x)
{
    const union { float x; int32_t bits; } both = {.x = x};
    return both.bits;
}

/* Whether it is a number, and not an infinite one. */
static bool is_finite(float x)
{
    return (x <= FLT_MAX) && (x >= -FLT_MAX);
}

/* The phase [rad] modulo 2 pi, in [0, 2 pi). */
static float wrap_phase(float phase)
{
    const float wrapped = phase - 6.2831855f * floorf(phase * 0.15915494f);
    return wrapped >= 6.2831855f ? 0.0f : larger(wrapped, 0.0f);
}

typedef struct {
    float first;
    float second;
} sin_cos_result;

/* Sine and cosine of an angle [rad], any shape. */
static sin_cos_result sin_cos(float angle)
{
    const float quadrant = rintf(angle * 0.63661975f);
    const float r = angle - quadrant * 1.5703125f - quadrant * 0.0004838268f;
    const float r2 = r * r;
    const float sine = r + r * r2 * (-0.16666667f + r2 * (0.008333334f + r2 * (-0.0001984127f +
        r2 * 2.7557319e-06f)));
    const float cosine = 1.0f + r2 * (-0.5f + r2 * (0.041666668f + r2 * (-0.0013888889f + r2 *
        2.4801588e-05f)));
    const int32_t last_bits = bits_of(quadrant + 1.2582912e+07f);
    const bool swap = (last_bits & 1) == 1;
    sin_cos_result result;
    result.first = (((last_bits & 2) == 0) ? 1.0f : -1.0f) * (swap ? cosine : sine);
    result.second = (((sum_of(last_bits, 1) & 2) == 0) ? 1.0f : -1.0f) * (swap ? sine : cosine);
    return result;
}

/* The oscillator at a phase [rad]. */
static level_oscillator started(float phase)
{
    const float start = wrap_phase(phase);
    level_oscillator result;
    result.phase = start;
    return result;
}

typedef struct {
    float sin_phase;
    float cos_phase;
} rhythm_result;

/* What the terms read of the oscillator. */
static rhythm_result rhythm(const level_oscillator *o)
{
    const sin_cos_result sin_cos_2 = sin_cos(o->phase);
    rhythm_result result;
    result.sin_phase = sin_cos_2.first;
    result.cos_phase = sin_cos_2.second;
    return result;
}

/* The phase [rad]. */
static float phase_of(const level_oscillator *o)
{
    return o->phase;
}

typedef struct {
    float foot_x;
    float foot_z;
} actuation_term_result;

/* T, the actuation: A place of the foot in SI [m]. */
static actuation_term_result actuation_term(const actuation_weights *w, const signals *s)
{
    const float values = s->sin_phase / 1.0f;
    actuation_term_result result;
    result.foot_x = 0.265f * (-w->stride_m * (cosf(w->shift_rad) * (s->cos_phase / 1.0f) -
        sinf(w->shift_rad) * values) * (1.0f + w->yaw * (s->side_yaw / 1.0f)));
    result.foot_z = 0.265f * ((values > 0.0f ? w->lift_m : w->press_m) * values + (w->roll_m *
        (s->side_roll / 1.0f) + w->roll_rate_ms * (s->side_roll_rate / 6.097561f)) + w->pitch_m
        * (s->end_pitch / 1.0f));
    return result;
}

/* There is no Tegotae feedback. */
static float feedback_law(void)
{
    return 0.0f;
}

typedef struct {
    float foot_x;
    float foot_z;
} command_law_result;

/* Where the foot shall be [m]. */
static command_law_result command_law(float smooth_foot_x, float smooth_foot_z)
{
    command_law_result result;
    result.foot_x = smooth_foot_x;
    result.foot_z = smooth_foot_z;
    return result;
}

/* The oscillator a tick later, its rate held: A single Kuramoto phase oscillator, phi_dot =
   omega + f (paper equation 5; f holds the gain once). */
static level_oscillator advanced(const level_oscillator *o, float omega, float feedback)
{
    const float settle = wrap_phase(o->phase + TICK_S * (omega + feedback));
    level_oscillator result;
    result.phase = settle;
    return result;
}

typedef struct {
    float joint_0;
    float joint_1;
    float joint_2;
} nearer_result;

/* Joints one step nearer to where they put the foot: damped least squares. */
static nearer_result nearer(const leg_geometry *leg, const float *wanted, const float *moved)
{
    const float angle = (1.0f - leg->slides[2]) * moved[2];
    const float turned_2 = sinf(angle);
    const float value = leg->foot[0] + -1.0f * leg->anchor[2][0];
    const float value_2 = leg->foot[1] + -1.0f * leg->anchor[2][1];
    const float value_3 = leg->foot[2] + -1.0f * leg->anchor[2][2];
    const float cross = leg->axis[2][1] * value_3 - leg->axis[2][2] * value_2;
    const float cross_2 = leg->axis[2][2] * value - leg->axis[2][0] * value_3;
    const float cross_3 = leg->axis[2][0] * value_2 - leg->axis[2][1] * value;
    const float turned_3 = 1.0f - cosf(angle);
    const float value_4 = value + turned_2 * cross + turned_3 * (leg->axis[2][1] * cross_3 -
        leg->axis[2][2] * cross_2);
    const float value_5 = value_2 + turned_2 * cross_2 + turned_3 * (leg->axis[2][2] * cross -
        leg->axis[2][0] * cross_3);
    const float value_6 = value_3 + turned_2 * cross_3 + turned_3 * (leg->axis[2][0] * cross_2 -
        leg->axis[2][1] * cross);
    const float foot = leg->slides[2] * moved[2];
    const float moves = 1.0f - leg->slides[2];
    const float value_7 = moves * (leg->axis[2][1] * value_6 - leg->axis[2][2] * value_5) +
        leg->slides[2] * leg->axis[2][0];
    const float value_8 = moves * (leg->axis[2][2] * value_4 - leg->axis[2][0] * value_6) +
        leg->slides[2] * leg->axis[2][1];
    const float value_9 = moves * (leg->axis[2][0] * value_5 - leg->axis[2][1] * value_4) +
        leg->slides[2] * leg->axis[2][2];
    const float angle_2 = (1.0f - leg->slides[1]) * moved[1];
    const float turned_4 = sinf(angle_2);
    const float turned_5 = cosf(angle_2);
    const float value_10 = leg->anchor[2][0] + 1.0f * value_4 + foot * leg->axis[2][0] + -1.0f *
        leg->anchor[1][0];
    const float value_11 = leg->anchor[2][1] + 1.0f * value_5 + foot * leg->axis[2][1] + -1.0f *
        leg->anchor[1][1];
    const float value_12 = leg->anchor[2][2] + 1.0f * value_6 + foot * leg->axis[2][2] + -1.0f *
        leg->anchor[1][2];
    const float cross_4 = leg->axis[1][1] * value_12 - leg->axis[1][2] * value_11;
    const float cross_5 = leg->axis[1][2] * value_10 - leg->axis[1][0] * value_12;
    const float cross_6 = leg->axis[1][0] * value_11 - leg->axis[1][1] * value_10;
    const float turned_6 = 1.0f - turned_5;
    const float value_13 = value_10 + turned_4 * cross_4 + turned_6 * (leg->axis[1][1] * cross_6
        - leg->axis[1][2] * cross_5);
    const float value_14 = value_11 + turned_4 * cross_5 + turned_6 * (leg->axis[1][2] * cross_4
        - leg->axis[1][0] * cross_6);
    const float value_15 = value_12 + turned_4 * cross_6 + turned_6 * (leg->axis[1][0] * cross_5
        - leg->axis[1][1] * cross_4);
    const float foot_2 = leg->slides[1] * moved[1];
    const float moves_2 = 1.0f - leg->slides[1];
    const float value_16 = moves_2 * (leg->axis[1][1] * value_15 - leg->axis[1][2] * value_14) +
        leg->slides[1] * leg->axis[1][0];
    const float value_17 = moves_2 * (leg->axis[1][2] * value_13 - leg->axis[1][0] * value_15) +
        leg->slides[1] * leg->axis[1][1];
    const float value_18 = moves_2 * (leg->axis[1][0] * value_14 - leg->axis[1][1] * value_13) +
        leg->slides[1] * leg->axis[1][2];
    const float cross_7 = leg->axis[1][1] * value_9 - leg->axis[1][2] * value_8;
    const float cross_8 = leg->axis[1][2] * value_7 - leg->axis[1][0] * value_9;
    const float cross_9 = leg->axis[1][0] * value_8 - leg->axis[1][1] * value_7;
    const float turned_7 = 1.0f - turned_5;
    const float value_19 = value_7 + turned_4 * cross_7 + turned_7 * (leg->axis[1][1] * cross_9
        - leg->axis[1][2] * cross_8);
    const float value_20 = value_8 + turned_4 * cross_8 + turned_7 * (leg->axis[1][2] * cross_7
        - leg->axis[1][0] * cross_9);
    const float value_21 = value_9 + turned_4 * cross_9 + turned_7 * (leg->axis[1][0] * cross_8
        - leg->axis[1][1] * cross_7);
    const float angle_3 = (1.0f - leg->slides[0]) * moved[0];
    const float turned_8 = sinf(angle_3);
    const float turned_9 = cosf(angle_3);
    const float value_22 = leg->anchor[1][0] + 1.0f * value_13 + foot_2 * leg->axis[1][0] +
        -1.0f * leg->anchor[0][0];
    const float value_23 = leg->anchor[1][1] + 1.0f * value_14 + foot_2 * leg->axis[1][1] +
        -1.0f * leg->anchor[0][1];
    const float value_24 = leg->anchor[1][2] + 1.0f * value_15 + foot_2 * leg->axis[1][2] +
        -1.0f * leg->anchor[0][2];
    const float cross_10 = leg->axis[0][1] * value_24 - leg->axis[0][2] * value_23;
    const float cross_11 = leg->axis[0][2] * value_22 - leg->axis[0][0] * value_24;
    const float cross_12 = leg->axis[0][0] * value_23 - leg->axis[0][1] * value_22;
    const float turned_10 = 1.0f - turned_9;
    const float value_25 = value_22 + turned_8 * cross_10 + turned_10 * (leg->axis[0][1] *
        cross_12 - leg->axis[0][2] * cross_11);
    const float value_26 = value_23 + turned_8 * cross_11 + turned_10 * (leg->axis[0][2] *
        cross_10 - leg->axis[0][0] * cross_12);
    const float value_27 = value_24 + turned_8 * cross_12 + turned_10 * (leg->axis[0][0] *
        cross_11 - leg->axis[0][1] * cross_10);
    const float foot_3 = leg->slides[0] * moved[0];
    const float moves_3 = 1.0f - leg->slides[0];
    const float value_28 = moves_3 * (leg->axis[0][1] * value_27 - leg->axis[0][2] * value_26) +
        leg->slides[0] * leg->axis[0][0];
    const float value_29 = moves_3 * (leg->axis[0][2] * value_25 - leg->axis[0][0] * value_27) +
        leg->slides[0] * leg->axis[0][1];
    const float value_30 = moves_3 * (leg->axis[0][0] * value_26 - leg->axis[0][1] * value_25) +
        leg->slides[0] * leg->axis[0][2];
    const float cross_13 = leg->axis[0][1] * value_18 - leg->axis[0][2] * value_17;
    const float cross_14 = leg->axis[0][2] * value_16 - leg->axis[0][0] * value_18;
    const float cross_15 = leg->axis[0][0] * value_17 - leg->axis[0][1] * value_16;
    const float turned_11 = 1.0f - turned_9;
    const float value_31 = value_16 + turned_8 * cross_13 + turned_11 * (leg->axis[0][1] *
        cross_15 - leg->axis[0][2] * cross_14);
    const float value_32 = value_17 + turned_8 * cross_14 + turned_11 * (leg->axis[0][2] *
        cross_13 - leg->axis[0][0] * cross_15);
    const float value_33 = value_18 + turned_8 * cross_15 + turned_11 * (leg->axis[0][0] *
        cross_14 - leg->axis[0][1] * cross_13);
    const float cross_16 = leg->axis[0][1] * value_21 - leg->axis[0][2] * value_20;
    const float cross_17 = leg->axis[0][2] * value_19 - leg->axis[0][0] * value_21;
    const float cross_18 = leg->axis[0][0] * value_20 - leg->axis[0][1] * value_19;
    const float turned_12 = 1.0f - turned_9;
    const float value_34 = value_19 + turned_8 * cross_16 + turned_12 * (leg->axis[0][1] *
        cross_18 - leg->axis[0][2] * cross_17);
    const float value_35 = value_20 + turned_8 * cross_17 + turned_12 * (leg->axis[0][2] *
        cross_16 - leg->axis[0][0] * cross_18);
    const float value_36 = value_21 + turned_8 * cross_18 + turned_12 * (leg->axis[0][0] *
        cross_17 - leg->axis[0][1] * cross_16);
    const float value_37 = wanted[0] + -1.0f * (leg->anchor[0][0] + 1.0f * value_25 + foot_3 *
        leg->axis[0][0]);
    const float value_38 = wanted[1] + -1.0f * (leg->anchor[0][1] + 1.0f * value_26 + foot_3 *
        leg->axis[0][1]);
    const float value_39 = wanted[2] + -1.0f * (leg->anchor[0][2] + 1.0f * value_27 + foot_3 *
        leg->axis[0][2]);
    const float dot = value_28 * value_37 + value_29 * value_38 + value_30 * value_39;
    const float nearer_2 = (((moved[0] <= leg->low[0]) & (dot < 0.0f)) | ((moved[0] >=
        leg->high[0]) & (dot > 0.0f))) ? 0.0f : 1.0f;
    const float value_40 = nearer_2 * value_28;
    const float value_41 = nearer_2 * value_29;
    const float value_42 = nearer_2 * value_30;
    const float dot_2 = value_31 * value_37 + value_32 * value_38 + value_33 * value_39;
    const float nearer_3 = (((moved[1] <= leg->low[1]) & (dot_2 < 0.0f)) | ((moved[1] >=
        leg->high[1]) & (dot_2 > 0.0f))) ? 0.0f : 1.0f;
    const float value_43 = nearer_3 * value_31;
    const float value_44 = nearer_3 * value_32;
    const float value_45 = nearer_3 * value_33;
    const float dot_3 = value_34 * value_37 + value_35 * value_38 + value_36 * value_39;
    const float nearer_4 = (((moved[2] <= leg->low[2]) & (dot_3 < 0.0f)) | ((moved[2] >=
        leg->high[2]) & (dot_3 > 0.0f))) ? 0.0f : 1.0f;
    const float value_46 = nearer_4 * value_34;
    const float value_47 = nearer_4 * value_35;
    const float value_48 = nearer_4 * value_36;
    const float step = 0.5f * (value_37 * value_37 + value_38 * value_38 + value_39 * value_39)
        + 1e-04f;
    const float entry = value_40 * value_40 + value_43 * value_43 + value_46 * value_46 + step *
        1.0f;
    const float entry_2 = value_40 * value_41 + value_43 * value_44 + value_46 * value_47;
    const float entry_3 = value_40 * value_42 + value_43 * value_45 + value_46 * value_48;
    const float entry_4 = value_41 * value_40 + value_44 * value_43 + value_47 * value_46;
    const float entry_5 = value_41 * value_41 + value_44 * value_44 + value_47 * value_47 + step
        * 1.0f;
    const float entry_6 = value_41 * value_42 + value_44 * value_45 + value_47 * value_48;
    const float entry_7 = value_42 * value_40 + value_45 * value_43 + value_48 * value_46;
    const float entry_8 = value_42 * value_41 + value_45 * value_44 + value_48 * value_47;
    const float entry_9 = value_42 * value_42 + value_45 * value_45 + value_48 * value_48 + step
        * 1.0f;
    const float damped = 1.0f / (entry * (entry_5 * entry_9 - entry_6 * entry_8) + entry_2 *
        (entry_6 * entry_7 - entry_4 * entry_9) + entry_3 * (entry_4 * entry_8 - entry_5 *
        entry_7));
    const float value_49 = damped * ((entry_5 * entry_9 - entry_6 * entry_8) * value_37 +
        (entry_6 * entry_7 - entry_4 * entry_9) * value_38 + (entry_4 * entry_8 - entry_5 *
        entry_7) * value_39);
    const float value_50 = damped * ((entry_8 * entry_3 - entry_9 * entry_2) * value_37 +
        (entry_9 * entry - entry_7 * entry_3) * value_38 + (entry_7 * entry_2 - entry_8 * entry)
        * value_39);
    const float value_51 = damped * ((entry_2 * entry_6 - entry_3 * entry_5) * value_37 +
        (entry_3 * entry_4 - entry * entry_6) * value_38 + (entry * entry_5 - entry_2 * entry_4)
        * value_39);
    nearer_result result;
    result.joint_0 = smaller(leg->high[0], larger(leg->low[0], moved[0] + (value_40 * value_49 +
        value_41 * value_50 + value_42 * value_51)));
    result.joint_1 = smaller(leg->high[1], larger(leg->low[1], moved[1] + (value_43 * value_49 +
        value_44 * value_50 + value_45 * value_51)));
    result.joint_2 = smaller(leg->high[2], larger(leg->low[2], moved[2] + (value_46 * value_49 +
        value_47 * value_50 + value_48 * value_51)));
    return result;
}

/* The ground's upward force on the foot, that holds a leg without mass. */
static float load(const leg_geometry *leg, const float *moved, const float *torque)
{
    const float angle = (1.0f - leg->slides[2]) * moved[2];
    const float turned_2 = sinf(angle);
    const float value = leg->foot[0] + -1.0f * leg->anchor[2][0];
    const float value_2 = leg->foot[1] + -1.0f * leg->anchor[2][1];
    const float value_3 = leg->foot[2] + -1.0f * leg->anchor[2][2];
    const float cross = leg->axis[2][1] * value_3 - leg->axis[2][2] * value_2;
    const float cross_2 = leg->axis[2][2] * value - leg->axis[2][0] * value_3;
    const float cross_3 = leg->axis[2][0] * value_2 - leg->axis[2][1] * value;
    const float turned_3 = 1.0f - cosf(angle);
    const float value_4 = value + turned_2 * cross + turned_3 * (leg->axis[2][1] * cross_3 -
        leg->axis[2][2] * cross_2);
    const float value_5 = value_2 + turned_2 * cross_2 + turned_3 * (leg->axis[2][2] * cross -
        leg->axis[2][0] * cross_3);
    const float value_6 = value_3 + turned_2 * cross_3 + turned_3 * (leg->axis[2][0] * cross_2 -
        leg->axis[2][1] * cross);
    const float foot = leg->slides[2] * moved[2];
    const float moves = 1.0f - leg->slides[2];
    const float value_7 = moves * (leg->axis[2][1] * value_6 - leg->axis[2][2] * value_5) +
        leg->slides[2] * leg->axis[2][0];
    const float value_8 = moves * (leg->axis[2][2] * value_4 - leg->axis[2][0] * value_6) +
        leg->slides[2] * leg->axis[2][1];
    const float value_9 = moves * (leg->axis[2][0] * value_5 - leg->axis[2][1] * value_4) +
        leg->slides[2] * leg->axis[2][2];
    const float angle_2 = (1.0f - leg->slides[1]) * moved[1];
    const float turned_4 = sinf(angle_2);
    const float turned_5 = cosf(angle_2);
    const float value_10 = leg->anchor[2][0] + 1.0f * value_4 + foot * leg->axis[2][0] + -1.0f *
        leg->anchor[1][0];
    const float value_11 = leg->anchor[2][1] + 1.0f * value_5 + foot * leg->axis[2][1] + -1.0f *
        leg->anchor[1][1];
    const float value_12 = leg->anchor[2][2] + 1.0f * value_6 + foot * leg->axis[2][2] + -1.0f *
        leg->anchor[1][2];
    const float cross_4 = leg->axis[1][1] * value_12 - leg->axis[1][2] * value_11;
    const float cross_5 = leg->axis[1][2] * value_10 - leg->axis[1][0] * value_12;
    const float cross_6 = leg->axis[1][0] * value_11 - leg->axis[1][1] * value_10;
    const float turned_6 = 1.0f - turned_5;
    const float value_13 = value_10 + turned_4 * cross_4 + turned_6 * (leg->axis[1][1] * cross_6
        - leg->axis[1][2] * cross_5);
    const float value_14 = value_11 + turned_4 * cross_5 + turned_6 * (leg->axis[1][2] * cross_4
        - leg->axis[1][0] * cross_6);
    const float value_15 = value_12 + turned_4 * cross_6 + turned_6 * (leg->axis[1][0] * cross_5
        - leg->axis[1][1] * cross_4);
    const float foot_2 = leg->slides[1] * moved[1];
    const float moves_2 = 1.0f - leg->slides[1];
    const float value_16 = moves_2 * (leg->axis[1][1] * value_15 - leg->axis[1][2] * value_14) +
        leg->slides[1] * leg->axis[1][0];
    const float value_17 = moves_2 * (leg->axis[1][2] * value_13 - leg->axis[1][0] * value_15) +
        leg->slides[1] * leg->axis[1][1];
    const float value_18 = moves_2 * (leg->axis[1][0] * value_14 - leg->axis[1][1] * value_13) +
        leg->slides[1] * leg->axis[1][2];
    const float cross_7 = leg->axis[1][1] * value_9 - leg->axis[1][2] * value_8;
    const float cross_8 = leg->axis[1][2] * value_7 - leg->axis[1][0] * value_9;
    const float cross_9 = leg->axis[1][0] * value_8 - leg->axis[1][1] * value_7;
    const float turned_7 = 1.0f - turned_5;
    const float value_19 = value_7 + turned_4 * cross_7 + turned_7 * (leg->axis[1][1] * cross_9
        - leg->axis[1][2] * cross_8);
    const float value_20 = value_8 + turned_4 * cross_8 + turned_7 * (leg->axis[1][2] * cross_7
        - leg->axis[1][0] * cross_9);
    const float value_21 = value_9 + turned_4 * cross_9 + turned_7 * (leg->axis[1][0] * cross_8
        - leg->axis[1][1] * cross_7);
    const float angle_3 = (1.0f - leg->slides[0]) * moved[0];
    const float turned_8 = sinf(angle_3);
    const float turned_9 = cosf(angle_3);
    const float value_22 = leg->anchor[1][0] + 1.0f * value_13 + foot_2 * leg->axis[1][0] +
        -1.0f * leg->anchor[0][0];
    const float value_23 = leg->anchor[1][1] + 1.0f * value_14 + foot_2 * leg->axis[1][1] +
        -1.0f * leg->anchor[0][1];
    const float value_24 = leg->anchor[1][2] + 1.0f * value_15 + foot_2 * leg->axis[1][2] +
        -1.0f * leg->anchor[0][2];
    const float cross_10 = leg->axis[0][1] * value_24 - leg->axis[0][2] * value_23;
    const float cross_11 = leg->axis[0][2] * value_22 - leg->axis[0][0] * value_24;
    const float cross_12 = leg->axis[0][0] * value_23 - leg->axis[0][1] * value_22;
    const float turned_10 = 1.0f - turned_9;
    const float value_25 = value_22 + turned_8 * cross_10 + turned_10 * (leg->axis[0][1] *
        cross_12 - leg->axis[0][2] * cross_11);
    const float value_26 = value_23 + turned_8 * cross_11 + turned_10 * (leg->axis[0][2] *
        cross_10 - leg->axis[0][0] * cross_12);
    const float value_27 = value_24 + turned_8 * cross_12 + turned_10 * (leg->axis[0][0] *
        cross_11 - leg->axis[0][1] * cross_10);
    const float moves_3 = 1.0f - leg->slides[0];
    const float value_28 = moves_3 * (leg->axis[0][1] * value_27 - leg->axis[0][2] * value_26) +
        leg->slides[0] * leg->axis[0][0];
    const float value_29 = moves_3 * (leg->axis[0][2] * value_25 - leg->axis[0][0] * value_27) +
        leg->slides[0] * leg->axis[0][1];
    const float value_30 = moves_3 * (leg->axis[0][0] * value_26 - leg->axis[0][1] * value_25) +
        leg->slides[0] * leg->axis[0][2];
    const float cross_13 = leg->axis[0][1] * value_18 - leg->axis[0][2] * value_17;
    const float cross_14 = leg->axis[0][2] * value_16 - leg->axis[0][0] * value_18;
    const float cross_15 = leg->axis[0][0] * value_17 - leg->axis[0][1] * value_16;
    const float turned_11 = 1.0f - turned_9;
    const float value_31 = value_16 + turned_8 * cross_13 + turned_11 * (leg->axis[0][1] *
        cross_15 - leg->axis[0][2] * cross_14);
    const float value_32 = value_17 + turned_8 * cross_14 + turned_11 * (leg->axis[0][2] *
        cross_13 - leg->axis[0][0] * cross_15);
    const float value_33 = value_18 + turned_8 * cross_15 + turned_11 * (leg->axis[0][0] *
        cross_14 - leg->axis[0][1] * cross_13);
    const float cross_16 = leg->axis[0][1] * value_21 - leg->axis[0][2] * value_20;
    const float cross_17 = leg->axis[0][2] * value_19 - leg->axis[0][0] * value_21;
    const float cross_18 = leg->axis[0][0] * value_20 - leg->axis[0][1] * value_19;
    const float turned_12 = 1.0f - turned_9;
    const float value_34 = value_19 + turned_8 * cross_16 + turned_12 * (leg->axis[0][1] *
        cross_18 - leg->axis[0][2] * cross_17);
    const float value_35 = value_20 + turned_8 * cross_17 + turned_12 * (leg->axis[0][2] *
        cross_16 - leg->axis[0][0] * cross_18);
    const float value_36 = value_21 + turned_8 * cross_18 + turned_12 * (leg->axis[0][0] *
        cross_17 - leg->axis[0][1] * cross_16);
    const float pushed = -torque[0];
    const float pushed_2 = -torque[1];
    const float pushed_3 = -torque[2];
    const float entry = value_28 * value_28 + value_31 * value_31 + value_34 * value_34 +
        1e-04f;
    const float entry_2 = value_28 * value_29 + value_31 * value_32 + value_34 * value_35;
    const float entry_3 = value_28 * value_30 + value_31 * value_33 + value_34 * value_36;
    const float entry_4 = value_29 * value_28 + value_32 * value_31 + value_35 * value_34;
    const float entry_5 = value_29 * value_29 + value_32 * value_32 + value_35 * value_35 +
        1e-04f;
    const float entry_6 = value_29 * value_30 + value_32 * value_33 + value_35 * value_36;
    const float entry_7 = value_30 * value_28 + value_33 * value_31 + value_36 * value_34;
    const float entry_8 = value_30 * value_29 + value_33 * value_32 + value_36 * value_35;
    const float entry_9 = value_30 * value_30 + value_33 * value_33 + value_36 * value_36 +
        1e-04f;
    const float dot = (entry_2 * entry_6 - entry_3 * entry_5) * (pushed * value_28 + 1.0f *
        (pushed_2 * value_31) + 1.0f * (pushed_3 * value_34)) + (entry_3 * entry_4 - entry *
        entry_6) * (pushed * value_29 + 1.0f * (pushed_2 * value_32) + 1.0f * (pushed_3 *
        value_35));
    const float value_37 = 1.0f / (entry * (entry_5 * entry_9 - entry_6 * entry_8) + entry_2 *
        (entry_6 * entry_7 - entry_4 * entry_9) + entry_3 * (entry_4 * entry_8 - entry_5 *
        entry_7)) * (dot + (entry * entry_5 - entry_2 * entry_4) * (pushed * value_30 + 1.0f *
        (pushed_2 * value_33) + 1.0f * (pushed_3 * value_36)));
    return value_37;
}

/* The number itself; 0 for what is no finite number, which is told. */
static float checked(float x, bool *sound)
{
    const bool known = is_finite(x);
    *sound = *sound && known;
    return known ? x : 0.0f;
}

/* The small angle of a finite one, which whole turns are taken from. A turn is a little less than
   its float. fmodf would do, but takes two kilobytes of a small controller's flash. */
static float turned(float phase)
{
    const float turn = 6.28318548f;
    float left = fabsf(phase);
    float over = 0.0f;
    float turns = turn;
    while (turns <= 0.5f * left) {
        turns *= 2.0f;
    }
    while (turns >= turn) {
        if (left >= turns) {
            left -= turns;
            over += 2.78275e-8f * turns;
        }
        turns *= 0.5f;
    }
    left += over;
    return (phase < 0.0f) ? -left : left;
}

/* A place of the foot; that at rest for what is no finite number. */
static float bounded(float place)
{
    return is_finite(place) ? place : 0.0f;
}

void level_init(level_state *state, const float phase_rad[LEVEL_LIMBS])
{
    bool sound = true;
    for (int unit = 0; unit < LEVEL_LIMBS; ++unit) {
        state->oscillator[unit] = started(turned(checked(phase_rad[unit], &sound)));
    }
    state->omega_rad_per_s = LEVEL_OMEGA_RAD_PER_S;
    state->faults = sound ? 0u : 1u;
}

void level_step(level_state *state, const level_inputs *in, level_outputs *out)
{
    bool sound = true;
    signals heard[LEVEL_LIMBS];
    for (int unit = 0; unit < LEVEL_LIMBS; ++unit) {
        heard[unit].end_pitch = checked(in->end_pitch_rad[unit], &sound);
        heard[unit].side_roll = checked(in->side_roll_rad[unit], &sound);
        heard[unit].side_roll_rate = checked(in->side_roll_rate_rad_per_s[unit], &sound);
        heard[unit].side_yaw = checked(in->side_yaw_rad[unit], &sound);
        const rhythm_result felt = rhythm(&state->oscillator[unit]);
        heard[unit].sin_phase = felt.sin_phase;
        heard[unit].cos_phase = felt.cos_phase;
    }
    for (int unit = 0; unit < LEVEL_LIMBS; ++unit) {
        const float omega = state->omega_rad_per_s;
        const float phase = phase_of(&state->oscillator[unit]);
        const float feedback = feedback_law();
        const actuation_term_result smooth = actuation_term(&WEIGHTS.actuation, &heard[unit]);
        const command_law_result said = command_law(smooth.foot_x, smooth.foot_z);
        out->foot_x_m[unit] = bounded(said.foot_x);
        out->foot_z_m[unit] = bounded(said.foot_z);
        out->feedback_rad_per_s[unit] = is_finite(feedback) ? feedback : 0.0f;
        out->phase_rad[unit] = phase;
        const level_oscillator next = advanced(&state->oscillator[unit], omega, feedback);
        if (is_finite(next.phase)) {
            state->oscillator[unit] = next;
        } else {
            sound = false;
        }
    }
    if (!sound) {
        ++state->faults;
    }
    out->fault = !sound;
}

/* A place over the leg's length, which no foot is further off than. */
static float over_length(float place_m)
{
    return fminf(fmaxf(place_m / LENGTH_M, -1.0f), 1.0f);
}

void level_joints(const level_outputs *out, float joints[LEVEL_LIMBS][LEVEL_JOINTS])
{
    for (int i = 0; i < LEVEL_LIMBS; ++i) {
        const leg_geometry *leg = &LEGS[i];
        const float wanted[3] = {leg->foot[0] + over_length(out->foot_x_m[i]), leg->foot[1], leg->foot[2] + over_length(out->foot_z_m[i])};
        float moved[3] = {0.0f};
        for (int n = 0; n < 8; ++n) {
            const nearer_result next = nearer(leg, wanted, moved);
            memcpy(moved, &next, sizeof moved);
        }
        for (int k = 0; k < 3; ++k) {
            joints[i][k] = leg->start[k] + (leg->unit[k] * moved[k]);
        }
    }
}

void level_loads(float joints[LEVEL_LIMBS][LEVEL_JOINTS],
    float torques[LEVEL_LIMBS][LEVEL_JOINTS], float loads_n[LEVEL_LIMBS])
{
    for (int i = 0; i < LEVEL_LIMBS; ++i) {
        const leg_geometry *leg = &LEGS[i];
        float moved[3];
        float torque[3];
        for (int k = 0; k < 3; ++k) {
            moved[k] = (joints[i][k] - leg->start[k]) / leg->unit[k];
            torque[k] = torques[i][k] / ((leg->slides[k] > 0.0f) ? 1.0f : LENGTH_M);
        }
        const float upward = load(leg, moved, torque);
        loads_n[i] = (upward > 0.0f) ? upward : 0.0f;
    }
}
