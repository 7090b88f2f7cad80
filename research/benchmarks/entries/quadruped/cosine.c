/* cosine.c: cos+range@quadruped-c. Written by tegotae from the code that its simulator runs.
   All numbers are float; nothing is allocated; there is no state but the caller's. */
#include "cosine.h"

#include <float.h>
#include <math.h>

static const float TICK_S = COSINE_TICK_S;

typedef struct {
    float offset;
} action_weights;

typedef struct {
    float sigma;
} gain_weights;

typedef struct {
    action_weights action;
    gain_weights gain;
} unit_weights;

static const unit_weights WEIGHTS = {
    .action = {.offset = 0.28458595f},
    .gain = {.sigma = 1.2888787f},
};

/* All that the terms of a unit may read. */
typedef struct {
    float spring_force; /* N */
    float sin_phase;
    float cos_phase;
} signals;

/* The larger of two; not a number, if one of them is none. */
static float larger(float a, float b)
{
    return ((a > b) || (a != a)) ? a : b;
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
static cosine_oscillator started(float phase)
{
    const float start = wrap_phase(phase);
    cosine_oscillator result;
    result.phase = start;
    return result;
}

typedef struct {
    float sin_phase;
    float cos_phase;
} rhythm_result;

/* What the terms read of the oscillator. */
static rhythm_result rhythm(const cosine_oscillator *o)
{
    const sin_cos_result sin_cos_2 = sin_cos(o->phase);
    rhythm_result result;
    result.sin_phase = sin_cos_2.first;
    result.cos_phase = sin_cos_2.second;
    return result;
}

/* The phase [rad]. */
static float phase_of(const cosine_oscillator *o)
{
    return o->phase;
}

/* A', the action: A'(phi) = -(cos phi + o) with a trained offset o, the action of the ORC
   oscillators. */
static float action_term(const action_weights *w, const signals *s)
{
    return -(s->cos_phase + w->offset);
}

/* R, the reaction: R(s) = S(s) = F_k, the spring force [N] (paper equation 2 and [24],
   [30]). */
static float reaction_term(const signals *s)
{
    return s->spring_force;
}

/* G, the gain: G = sigma, one trained number (paper equation 2). */
static float gain_term(const gain_weights *w)
{
    return w->sigma;
}

typedef struct {
    float foot_x;
    float foot_z;
} actuation_term_result;

/* T, the actuation: The foot goes round two half ellipses, backwards while it presses down
   (Owaki et al. 2013): x = -B cos(phi + delta), z = A sin phi if sin phi > 0, else A' sin
   phi. */
static actuation_term_result actuation_term(const signals *s)
{
    actuation_term_result result;
    result.foot_x = -0.2f * (0.921061f * s->cos_phase - 0.38941833f * s->sin_phase);
    result.foot_z = (s->sin_phase > 0.0f ? 0.12f : 0.03f) * s->sin_phase;
    return result;
}

/* The Tegotae feedback f = G A' R [rad/s]. */
static float feedback_law(float action, float reaction, float gain)
{
    return gain * action * reaction;
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
static cosine_oscillator advanced(const cosine_oscillator *o, float omega, float feedback)
{
    const float settle = wrap_phase(o->phase + TICK_S * (omega + feedback));
    cosine_oscillator result;
    result.phase = settle;
    return result;
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

void cosine_init(cosine_state *state, const float phase_rad[COSINE_LIMBS])
{
    bool sound = true;
    for (int unit = 0; unit < COSINE_LIMBS; ++unit) {
        state->oscillator[unit] = started(turned(checked(phase_rad[unit], &sound)));
    }
    state->omega_rad_per_s = COSINE_OMEGA_RAD_PER_S;
    state->faults = sound ? 0u : 1u;
}

void cosine_step(cosine_state *state, const cosine_inputs *in, cosine_outputs *out)
{
    bool sound = true;
    signals heard[COSINE_LIMBS];
    for (int unit = 0; unit < COSINE_LIMBS; ++unit) {
        heard[unit].spring_force = checked(in->spring_force_n[unit], &sound);
        const rhythm_result felt = rhythm(&state->oscillator[unit]);
        heard[unit].sin_phase = felt.sin_phase;
        heard[unit].cos_phase = felt.cos_phase;
    }
    for (int unit = 0; unit < COSINE_LIMBS; ++unit) {
        const float omega = state->omega_rad_per_s;
        const float phase = phase_of(&state->oscillator[unit]);
        const float action = action_term(&WEIGHTS.action, &heard[unit]);
        const float reaction = reaction_term(&heard[unit]);
        const float gain = gain_term(&WEIGHTS.gain);
        const float feedback = feedback_law(action, reaction, gain);
        const actuation_term_result smooth = actuation_term(&heard[unit]);
        const command_law_result said = command_law(smooth.foot_x, smooth.foot_z);
        out->foot_x_m[unit] = bounded(said.foot_x);
        out->foot_z_m[unit] = bounded(said.foot_z);
        out->feedback_rad_per_s[unit] = is_finite(feedback) ? feedback : 0.0f;
        out->phase_rad[unit] = phase;
        const cosine_oscillator next = advanced(&state->oscillator[unit], omega, feedback);
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
