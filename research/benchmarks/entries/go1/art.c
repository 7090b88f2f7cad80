/* art.c: ART-rF-tphif-w8@go1. Written by tegotae from the code that its simulator runs. All
   numbers are float; nothing is allocated; there is no state but the caller's. */
#include "art.h"

#include <float.h>
#include <math.h>

static const float TICK_S = ART_TICK_S;
static const float MAX_FORCE_N = ART_MAX_FORCE_N;
static const float SCALE_SPRING_FORCE = 31.0f; /* N: networks see spring_force over this */
static const float SCALE_FEEDBACK = 6.0f; /* rad/s: networks see feedback over this */

typedef struct {
    struct {
        float sin_phase;
        float cos_phase;
        float bias;
        float output;
    } neuron[3];
} action_weights;

typedef struct {
    struct {
        float spring_force;
        float bias;
        float output;
    } neuron[5];
} reaction_weights;

typedef struct {
    float sigma;
} gain_weights;

typedef struct {
    struct {
        float sin_phase;
        float cos_phase;
        float feedback;
        float bias;
        float output;
    } neuron[4];
} actuation_weights;

typedef struct {
    action_weights action;
    reaction_weights reaction;
    gain_weights gain;
    actuation_weights actuation;
} unit_weights;

static const unit_weights WEIGHTS[2] = {
    {
    .action = {
        .neuron = {
            {
                .sin_phase = -1.0052886f, .cos_phase = -0.39718628f, .bias = -1.9797833f,
                    .output = 0.9056239f
            },
            {
                .sin_phase = -0.65548205f, .cos_phase = 0.09807135f, .bias = 1.1355609f,
                    .output = 0.8653243f
            },
            {
                .sin_phase = -0.8879355f, .cos_phase = -0.22429581f, .bias = 0.53220516f,
                    .output = 0.12874272f
            },
        },
    },
    .reaction = {
        .neuron = {
            {.spring_force = -0.98253345f, .bias = 0.53706986f, .output = 1.8360208f},
            {.spring_force = -0.26310778f, .bias = -2.8624036f, .output = 0.24474356f},
            {.spring_force = -0.14431477f, .bias = -1.8785229f, .output = 0.46159506f},
            {.spring_force = -0.56995845f, .bias = 0.9096701f, .output = 3.0331602f},
            {.spring_force = 3.6932461f, .bias = -0.92433107f, .output = 0.84184575f},
        },
    },
    .gain = {.sigma = -1.7963871f},
    .actuation = {
        .neuron = {
            {
                .sin_phase = -3.6229875f, .cos_phase = -0.65778387f, .feedback = 0.31021637f,
                    .bias = -1.0365057f, .output = -1.072179f
            },
            {
                .sin_phase = 1.3859044f, .cos_phase = 0.10226555f, .feedback = 1.6379212f,
                    .bias = -3.0346947f, .output = -3.9593863f
            },
            {
                .sin_phase = 0.017004468f, .cos_phase = 1.6540828f, .feedback = 1.6294868f,
                    .bias = 0.15914643f, .output = 1.878771f
            },
            {
                .sin_phase = -0.17017436f, .cos_phase = 0.21006352f, .feedback = 1.8392451f,
                    .bias = -0.36660558f, .output = -0.5423611f
            },
        },
    },
},
    {
    .action = {
        .neuron = {
            {
                .sin_phase = -0.05877699f, .cos_phase = 0.5375844f, .bias = 1.9953798f,
                    .output = 0.36733717f
            },
            {
                .sin_phase = 0.2811239f, .cos_phase = -1.2149401f, .bias = -0.37591305f,
                    .output = -0.5438644f
            },
            {
                .sin_phase = 0.70463264f, .cos_phase = -0.45137757f, .bias = 2.4281442f,
                    .output = 2.862945f
            },
        },
    },
    .reaction = {
        .neuron = {
            {.spring_force = -0.821118f, .bias = 0.48618776f, .output = 0.32918486f},
            {.spring_force = -0.50533986f, .bias = 1.2770803f, .output = -1.583117f},
            {.spring_force = -2.2776453f, .bias = -0.75351834f, .output = 0.35848343f},
            {.spring_force = 1.1102637f, .bias = 0.35820597f, .output = 0.105534546f},
            {.spring_force = -1.2927654f, .bias = -0.19137791f, .output = -1.5856978f},
        },
    },
    .gain = {.sigma = 0.4743656f},
    .actuation = {
        .neuron = {
            {
                .sin_phase = 0.55973023f, .cos_phase = -1.8441824f, .feedback = 0.85503423f,
                    .bias = 0.56319314f, .output = 1.0815455f
            },
            {
                .sin_phase = 1.1541557f, .cos_phase = 1.0196148f, .feedback = -0.65461606f,
                    .bias = -1.9776917f, .output = -0.69667137f
            },
            {
                .sin_phase = -0.9782445f, .cos_phase = -1.9061376f, .feedback = 1.5017822f,
                    .bias = 0.8738214f, .output = -0.24693808f
            },
            {
                .sin_phase = 0.26948124f, .cos_phase = -0.2823195f, .feedback = -2.0078566f,
                    .bias = 0.35271117f, .output = -1.3893286f
            },
        },
    },
}
};

/* Which of these each unit has. */
static const int SET[8] = {0, 1, 0, 1, 0, 1, 0, 1};

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

/* By so many bits further left, of less than 32. */
static int32_t shifted_left(int32_t a, int32_t by)
{
    return (int32_t)((uint32_t)a << (uint32_t)by);
}

/* The bits of a float. */
static int32_t bits_of(float x)
{
    const union { float x; int32_t bits; } both = {.x = x};
    return both.bits;
}

/* The float of these bits. */
static float float_of(int32_t bits)
{
    const union { int32_t bits; float x; } both = {.bits = bits};
    return both.x;
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

/* 1 + 2z in float32, of z kept within 20.5. */
static float one_plus_exp2(float z)
{
    const float z_2 = smaller(20.5f, larger(-20.5f, z));
    const float whole = rintf(z_2);
    const float rest = z_2 - whole;
    return 1.0f + ((((0.009570103f * rest + 0.055917863f) * rest + 0.24024744f) * rest +
        0.6931218f) * rest + 0.9999993f) * float_of(shifted_left(bits_of(whole +
        1.2583039e+07f), 23));
}

typedef struct {
    float first;
    float second;
} add_ratio_result;

/* Numerator and denominator of the sum of two ratios, without a division. */
static add_ratio_result add_ratio(float over, float under, float numerator, float denominator)
{
    add_ratio_result result;
    result.first = over * denominator + numerator * under;
    result.second = under * denominator;
    return result;
}

/* The oscillator at a phase [rad]. */
static art_oscillator started(float phase)
{
    const float start = wrap_phase(phase);
    art_oscillator result;
    result.phase = start;
    return result;
}

typedef struct {
    float sin_phase;
    float cos_phase;
} rhythm_result;

/* What the terms read of the oscillator. */
static rhythm_result rhythm(const art_oscillator *o)
{
    const sin_cos_result sin_cos_2 = sin_cos(o->phase);
    rhythm_result result;
    result.sin_phase = sin_cos_2.first;
    result.cos_phase = sin_cos_2.second;
    return result;
}

/* The phase [rad]. */
static float phase_of(const art_oscillator *o)
{
    return o->phase;
}

/* A', the action: A network with one tanh layer, sum_j v_j tanh(sum_i w_ji x_i + b_j),
   h*(inputs + 2) weights. */
static float action_term(const action_weights *w, const signals *s)
{
    const float x = 2.88539f * (s->sin_phase / 1.0f);
    const float x_2 = 2.88539f * (s->cos_phase / 1.0f);
    const float value = one_plus_exp2(2.88539f * w->neuron[0].bias + w->neuron[0].sin_phase * x
        + w->neuron[0].cos_phase * x_2);
    const float value_2 = one_plus_exp2(2.88539f * w->neuron[1].bias + w->neuron[1].sin_phase *
        x + w->neuron[1].cos_phase * x_2);
    const float value_3 = one_plus_exp2(2.88539f * w->neuron[2].bias + w->neuron[2].sin_phase *
        x + w->neuron[2].cos_phase * x_2);
    const add_ratio_result over_under = add_ratio(2.0f * w->neuron[0].output, value, 2.0f *
        w->neuron[1].output, value_2);
    const add_ratio_result over_under_2 = add_ratio(over_under.first, over_under.second, 2.0f *
        w->neuron[2].output, value_3);
    return w->neuron[0].output + w->neuron[1].output + w->neuron[2].output - over_under_2.first
        / over_under_2.second;
}

/* R, the reaction: A network with one tanh layer, sum_j v_j tanh(sum_i w_ji x_i + b_j),
   h*(inputs + 2) weights. */
static float reaction_term(const reaction_weights *w, const signals *s)
{
    const float x = 2.88539f * (s->spring_force / SCALE_SPRING_FORCE);
    const float value = one_plus_exp2(2.88539f * w->neuron[0].bias + w->neuron[0].spring_force *
        x);
    const float value_2 = one_plus_exp2(2.88539f * w->neuron[1].bias + w->neuron[1].spring_force
        * x);
    const float value_3 = one_plus_exp2(2.88539f * w->neuron[2].bias + w->neuron[2].spring_force
        * x);
    const float value_4 = one_plus_exp2(2.88539f * w->neuron[3].bias + w->neuron[3].spring_force
        * x);
    const float value_5 = one_plus_exp2(2.88539f * w->neuron[4].bias + w->neuron[4].spring_force
        * x);
    const add_ratio_result over_under = add_ratio(2.0f * w->neuron[0].output, value, 2.0f *
        w->neuron[1].output, value_2);
    const add_ratio_result over_under_2 = add_ratio(over_under.first, over_under.second, 2.0f *
        w->neuron[2].output, value_3);
    const add_ratio_result over_under_3 = add_ratio(over_under_2.first, over_under_2.second,
        2.0f * w->neuron[3].output, value_4);
    const add_ratio_result over_under_4 = add_ratio(over_under_3.first, over_under_3.second,
        2.0f * w->neuron[4].output, value_5);
    return w->neuron[0].output + w->neuron[1].output + w->neuron[2].output + w->neuron[3].output
        + w->neuron[4].output - over_under_4.first / over_under_4.second;
}

/* G, the gain: G = sigma, one trained number (paper equation 2). */
static float gain_term(const gain_weights *w)
{
    return w->sigma;
}

/* T, the actuation: A learned actuation T: a network whose output is the force [N]. */
static float actuation_term(const actuation_weights *w, const signals *s, float feedback)
{
    const float x = 2.88539f * (s->sin_phase / 1.0f);
    const float x_2 = 2.88539f * (s->cos_phase / 1.0f);
    const float x_3 = 2.88539f * (feedback / SCALE_FEEDBACK);
    const float value = one_plus_exp2(2.88539f * w->neuron[0].bias + w->neuron[0].sin_phase * x
        + w->neuron[0].cos_phase * x_2 + w->neuron[0].feedback * x_3);
    const float value_2 = one_plus_exp2(2.88539f * w->neuron[1].bias + w->neuron[1].sin_phase *
        x + w->neuron[1].cos_phase * x_2 + w->neuron[1].feedback * x_3);
    const float value_3 = one_plus_exp2(2.88539f * w->neuron[2].bias + w->neuron[2].sin_phase *
        x + w->neuron[2].cos_phase * x_2 + w->neuron[2].feedback * x_3);
    const float value_4 = one_plus_exp2(2.88539f * w->neuron[3].bias + w->neuron[3].sin_phase *
        x + w->neuron[3].cos_phase * x_2 + w->neuron[3].feedback * x_3);
    const add_ratio_result over_under = add_ratio(2.0f * w->neuron[0].output, value, 2.0f *
        w->neuron[1].output, value_2);
    const add_ratio_result over_under_2 = add_ratio(over_under.first, over_under.second, 2.0f *
        w->neuron[2].output, value_3);
    const add_ratio_result over_under_3 = add_ratio(over_under_2.first, over_under_2.second,
        2.0f * w->neuron[3].output, value_4);
    return w->neuron[0].output + w->neuron[1].output + w->neuron[2].output + w->neuron[3].output
        - over_under_3.first / over_under_3.second;
}

/* The Tegotae feedback f = G A' R [rad/s]. */
static float feedback_law(float action, float reaction, float gain)
{
    return gain * action * reaction;
}

/* The actuator's force [N]: the term's, clipped to [0, alpha]; full force in the sector, if
   there is one. */
static float command_law(float smooth)
{
    return smaller(MAX_FORCE_N, larger(0.0f, smooth));
}

/* The oscillator a tick later, its rate held: A single Kuramoto phase oscillator, phi_dot =
   omega + f (paper equation 5; f holds the gain once). */
static art_oscillator advanced(const art_oscillator *o, float omega, float feedback)
{
    const float settle = wrap_phase(o->phase + TICK_S * (omega + feedback));
    art_oscillator result;
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

/* A force in [0, alpha], whatever comes; 0 for what is no number. */
static float bounded(float force)
{
    return (force > 0.0f) ? ((force < MAX_FORCE_N) ? force : MAX_FORCE_N) : 0.0f;
}

void art_init(art_state *state, const float phase_rad[ART_LIMBS])
{
    bool sound = true;
    for (int unit = 0; unit < ART_LIMBS; ++unit) {
        state->oscillator[unit] = started(turned(checked(phase_rad[unit], &sound)));
    }
    state->omega_rad_per_s = ART_OMEGA_RAD_PER_S;
    state->faults = sound ? 0u : 1u;
}

void art_step(art_state *state, const art_inputs *in, art_outputs *out)
{
    bool sound = true;
    signals heard[ART_LIMBS];
    for (int unit = 0; unit < ART_LIMBS; ++unit) {
        heard[unit].spring_force = checked(in->spring_force_n[unit], &sound);
        const rhythm_result felt = rhythm(&state->oscillator[unit]);
        heard[unit].sin_phase = felt.sin_phase;
        heard[unit].cos_phase = felt.cos_phase;
    }
    for (int unit = 0; unit < ART_LIMBS; ++unit) {
        const float omega = state->omega_rad_per_s;
        const float phase = phase_of(&state->oscillator[unit]);
        const float action = action_term(&WEIGHTS[SET[unit]].action, &heard[unit]);
        const float reaction = reaction_term(&WEIGHTS[SET[unit]].reaction, &heard[unit]);
        const float gain = gain_term(&WEIGHTS[SET[unit]].gain);
        const float feedback = feedback_law(action, reaction, gain);
        const float smooth = actuation_term(&WEIGHTS[SET[unit]].actuation, &heard[unit], feedback);
        out->force_n[unit] = bounded(command_law(smooth));
        out->feedback_rad_per_s[unit] = is_finite(feedback) ? feedback : 0.0f;
        out->phase_rad[unit] = phase;
        const art_oscillator next = advanced(&state->oscillator[unit], omega, feedback);
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

/* The action at no force, and at full force. */
static const float REST[8] = {0.6f, -2.1f, 0.6f, -2.1f, 0.6f, -2.1f, 0.6f, -2.1f};
static const float PUSH[8] = {1.2f, -1.5f, 1.2f, -1.5f, 1.2f, -1.5f, 1.2f, -1.5f};

float art_action(int limb, float force_n)
{
    return REST[limb] + ((PUSH[limb] - REST[limb]) * (force_n / MAX_FORCE_N));
}
