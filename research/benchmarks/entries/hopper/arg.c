/* arg.c: ARG-rF-gF-both-w4. Written by tegotae from the code that its simulator runs. All
   numbers are float; nothing is allocated; there is no state but the caller's. */
#include "arg.h"

#include <float.h>
#include <math.h>

static const float TICK_S = ARG_TICK_S;
static const float MAX_FORCE_N = ARG_MAX_FORCE_N;
static const float SCALE_SPRING_FORCE = 0.981f; /* N: networks see spring_force over this */

typedef struct {
    struct {
        float sin_phase;
        float cos_phase;
        float bias;
        float output;
    } neuron[8];
} action_weights;

typedef struct {
    struct {
        float spring_force;
        float bias;
        float output;
    } neuron[8];
} reaction_weights;

typedef struct {
    struct {
        float sin_phase;
        float cos_phase;
        float spring_force;
        float bias;
        float output;
    } neuron[8];
} gain_weights;

typedef struct {
    action_weights action;
    reaction_weights reaction;
    gain_weights gain;
} unit_weights;

static const unit_weights WEIGHTS = {
    .action = {
        .neuron = {
            {
                .sin_phase = -0.80815506f, .cos_phase = 4.1317554f, .bias = -0.19279557f,
                    .output = -1.9875852f
            },
            {
                .sin_phase = 0.7786031f, .cos_phase = 5.429174f, .bias = 2.1533258f,
                    .output = 4.997941f
            },
            {
                .sin_phase = -2.98602f, .cos_phase = -4.0656266f, .bias = 2.1052315f,
                    .output = -2.202905f
            },
            {
                .sin_phase = 5.843936f, .cos_phase = -8.434642f, .bias = -1.0320586f,
                    .output = 1.6001849f
            },
            {
                .sin_phase = -0.6402428f, .cos_phase = 1.0000302f, .bias = 4.1308856f,
                    .output = 1.6829487f
            },
            {
                .sin_phase = -7.3216963f, .cos_phase = 3.0647638f, .bias = -1.8406305f,
                    .output = -3.1302254f
            },
            {
                .sin_phase = -1.031488f, .cos_phase = 0.38220206f, .bias = 3.16237f,
                    .output = -2.8495626f
            },
            {
                .sin_phase = 8.064732f, .cos_phase = 7.4534593f, .bias = -3.0867262f,
                    .output = -2.1012537f
            },
        },
    },
    .reaction = {
        .neuron = {
            {.spring_force = -1.8655336f, .bias = -2.8543127f, .output = 1.5396978f},
            {.spring_force = 4.123805f, .bias = -0.64442635f, .output = 1.059232f},
            {.spring_force = 3.7122815f, .bias = -2.1420698f, .output = -1.4547186f},
            {.spring_force = -7.0169044f, .bias = 0.007157963f, .output = -1.393574f},
            {.spring_force = -6.57606f, .bias = -0.7414099f, .output = 1.5125959f},
            {.spring_force = 0.8066973f, .bias = -4.9285336f, .output = 2.172829f},
            {.spring_force = 4.352534f, .bias = 5.2943897f, .output = 3.386465f},
            {.spring_force = 4.0778627f, .bias = 0.18176164f, .output = 1.287487f},
        },
    },
    .gain = {
        .neuron = {
            {
                .sin_phase = -2.2579844f, .cos_phase = 0.12087214f, .spring_force = 2.551169f,
                    .bias = -1.5067277f, .output = -2.4625533f
            },
            {
                .sin_phase = -0.120970845f, .cos_phase = 2.2308974f, .spring_force = 2.238473f,
                    .bias = -2.2710233f, .output = 0.32391036f
            },
            {
                .sin_phase = 3.50059f, .cos_phase = -3.8132682f, .spring_force = -1.7576709f,
                    .bias = -0.6032484f, .output = 0.05060626f
            },
            {
                .sin_phase = 4.0259852f, .cos_phase = -2.0522497f, .spring_force = 3.0129972f,
                    .bias = -3.5933197f, .output = 0.69643086f
            },
            {
                .sin_phase = 2.8200185f, .cos_phase = -1.5727187f, .spring_force = 4.8136015f,
                    .bias = -5.2252073f, .output = -3.5001657f
            },
            {
                .sin_phase = -1.8103985f, .cos_phase = -3.8992422f, .spring_force = 1.5065321f,
                    .bias = 7.308948f, .output = 5.134261f
            },
            {
                .sin_phase = 6.197453f, .cos_phase = 7.2567163f, .spring_force = 4.474123f,
                    .bias = 2.5905426f, .output = 1.7220328f
            },
            {
                .sin_phase = 2.2365716f, .cos_phase = -3.7387147f, .spring_force = -2.123986f,
                    .bias = 1.236172f, .output = 1.9174342f
            },
        },
    },
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
    const float integer = rintf(z_2);
    const float fraction = z_2 - integer;
    return 1.0f + ((((0.009570103f * fraction + 0.055917863f) * fraction + 0.24024744f) *
        fraction + 0.6931218f) * fraction + 0.9999993f) * float_of(shifted_left(bits_of(integer
        + 1.2583039e+07f), 23));
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
static arg_oscillator started(float phase)
{
    const float start = wrap_phase(phase);
    arg_oscillator result;
    result.phase = start;
    return result;
}

typedef struct {
    float sin_phase;
    float cos_phase;
} rhythm_result;

/* What the terms read of the oscillator. */
static rhythm_result rhythm(const arg_oscillator *o)
{
    const sin_cos_result sin_cos_2 = sin_cos(o->phase);
    rhythm_result result;
    result.sin_phase = sin_cos_2.first;
    result.cos_phase = sin_cos_2.second;
    return result;
}

/* The phase [rad]. */
static float phase_of(const arg_oscillator *o)
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
    const float value_4 = one_plus_exp2(2.88539f * w->neuron[3].bias + w->neuron[3].sin_phase *
        x + w->neuron[3].cos_phase * x_2);
    const float value_5 = one_plus_exp2(2.88539f * w->neuron[4].bias + w->neuron[4].sin_phase *
        x + w->neuron[4].cos_phase * x_2);
    const float value_6 = one_plus_exp2(2.88539f * w->neuron[5].bias + w->neuron[5].sin_phase *
        x + w->neuron[5].cos_phase * x_2);
    const float value_7 = one_plus_exp2(2.88539f * w->neuron[6].bias + w->neuron[6].sin_phase *
        x + w->neuron[6].cos_phase * x_2);
    const float value_8 = one_plus_exp2(2.88539f * w->neuron[7].bias + w->neuron[7].sin_phase *
        x + w->neuron[7].cos_phase * x_2);
    const add_ratio_result over_under = add_ratio(2.0f * w->neuron[0].output, value, 2.0f *
        w->neuron[1].output, value_2);
    const add_ratio_result over_under_2 = add_ratio(over_under.first, over_under.second, 2.0f *
        w->neuron[2].output, value_3);
    const add_ratio_result over_under_3 = add_ratio(over_under_2.first, over_under_2.second,
        2.0f * w->neuron[3].output, value_4);
    const add_ratio_result over_under_4 = add_ratio(over_under_3.first, over_under_3.second,
        2.0f * w->neuron[4].output, value_5);
    const add_ratio_result over_under_5 = add_ratio(over_under_4.first, over_under_4.second,
        2.0f * w->neuron[5].output, value_6);
    const add_ratio_result over_under_6 = add_ratio(2.0f * w->neuron[6].output, value_7, 2.0f *
        w->neuron[7].output, value_8);
    const float layer = w->neuron[0].output + w->neuron[1].output + w->neuron[2].output +
        w->neuron[3].output + w->neuron[4].output + w->neuron[5].output + w->neuron[6].output +
        w->neuron[7].output - (over_under_5.first / over_under_5.second + over_under_6.first /
        over_under_6.second);
    return layer;
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
    const float value_6 = one_plus_exp2(2.88539f * w->neuron[5].bias + w->neuron[5].spring_force
        * x);
    const float value_7 = one_plus_exp2(2.88539f * w->neuron[6].bias + w->neuron[6].spring_force
        * x);
    const float value_8 = one_plus_exp2(2.88539f * w->neuron[7].bias + w->neuron[7].spring_force
        * x);
    const add_ratio_result over_under = add_ratio(2.0f * w->neuron[0].output, value, 2.0f *
        w->neuron[1].output, value_2);
    const add_ratio_result over_under_2 = add_ratio(over_under.first, over_under.second, 2.0f *
        w->neuron[2].output, value_3);
    const add_ratio_result over_under_3 = add_ratio(over_under_2.first, over_under_2.second,
        2.0f * w->neuron[3].output, value_4);
    const add_ratio_result over_under_4 = add_ratio(over_under_3.first, over_under_3.second,
        2.0f * w->neuron[4].output, value_5);
    const add_ratio_result over_under_5 = add_ratio(over_under_4.first, over_under_4.second,
        2.0f * w->neuron[5].output, value_6);
    const add_ratio_result over_under_6 = add_ratio(2.0f * w->neuron[6].output, value_7, 2.0f *
        w->neuron[7].output, value_8);
    const float layer = w->neuron[0].output + w->neuron[1].output + w->neuron[2].output +
        w->neuron[3].output + w->neuron[4].output + w->neuron[5].output + w->neuron[6].output +
        w->neuron[7].output - (over_under_5.first / over_under_5.second + over_under_6.first /
        over_under_6.second);
    return layer;
}

/* G, the gain: A network with one tanh layer, sum_j v_j tanh(sum_i w_ji x_i + b_j),
   h*(inputs + 2) weights. */
static float gain_term(const gain_weights *w, const signals *s)
{
    const float x = 2.88539f * (s->sin_phase / 1.0f);
    const float x_2 = 2.88539f * (s->cos_phase / 1.0f);
    const float x_3 = 2.88539f * (s->spring_force / SCALE_SPRING_FORCE);
    const float value = one_plus_exp2(2.88539f * w->neuron[0].bias + w->neuron[0].sin_phase * x
        + w->neuron[0].cos_phase * x_2 + w->neuron[0].spring_force * x_3);
    const float value_2 = one_plus_exp2(2.88539f * w->neuron[1].bias + w->neuron[1].sin_phase *
        x + w->neuron[1].cos_phase * x_2 + w->neuron[1].spring_force * x_3);
    const float value_3 = one_plus_exp2(2.88539f * w->neuron[2].bias + w->neuron[2].sin_phase *
        x + w->neuron[2].cos_phase * x_2 + w->neuron[2].spring_force * x_3);
    const float value_4 = one_plus_exp2(2.88539f * w->neuron[3].bias + w->neuron[3].sin_phase *
        x + w->neuron[3].cos_phase * x_2 + w->neuron[3].spring_force * x_3);
    const float value_5 = one_plus_exp2(2.88539f * w->neuron[4].bias + w->neuron[4].sin_phase *
        x + w->neuron[4].cos_phase * x_2 + w->neuron[4].spring_force * x_3);
    const float value_6 = one_plus_exp2(2.88539f * w->neuron[5].bias + w->neuron[5].sin_phase *
        x + w->neuron[5].cos_phase * x_2 + w->neuron[5].spring_force * x_3);
    const float value_7 = one_plus_exp2(2.88539f * w->neuron[6].bias + w->neuron[6].sin_phase *
        x + w->neuron[6].cos_phase * x_2 + w->neuron[6].spring_force * x_3);
    const float value_8 = one_plus_exp2(2.88539f * w->neuron[7].bias + w->neuron[7].sin_phase *
        x + w->neuron[7].cos_phase * x_2 + w->neuron[7].spring_force * x_3);
    const add_ratio_result over_under = add_ratio(2.0f * w->neuron[0].output, value, 2.0f *
        w->neuron[1].output, value_2);
    const add_ratio_result over_under_2 = add_ratio(over_under.first, over_under.second, 2.0f *
        w->neuron[2].output, value_3);
    const add_ratio_result over_under_3 = add_ratio(over_under_2.first, over_under_2.second,
        2.0f * w->neuron[3].output, value_4);
    const add_ratio_result over_under_4 = add_ratio(over_under_3.first, over_under_3.second,
        2.0f * w->neuron[4].output, value_5);
    const add_ratio_result over_under_5 = add_ratio(over_under_4.first, over_under_4.second,
        2.0f * w->neuron[5].output, value_6);
    const add_ratio_result over_under_6 = add_ratio(2.0f * w->neuron[6].output, value_7, 2.0f *
        w->neuron[7].output, value_8);
    const float layer = w->neuron[0].output + w->neuron[1].output + w->neuron[2].output +
        w->neuron[3].output + w->neuron[4].output + w->neuron[5].output + w->neuron[6].output +
        w->neuron[7].output - (over_under_5.first / over_under_5.second + over_under_6.first /
        over_under_6.second);
    return layer;
}

/* T, the actuation: The sum of sector and reflex [N], clipped like either: F_a = (alpha
   while phi is in the sector, else 0) - s min(0, f). */
static float actuation_term(float feedback)
{
    return -smaller(feedback, 0.0f);
}

/* The Tegotae feedback f = G A' R [rad/s]. */
static float feedback_law(float action, float reaction, float gain)
{
    return gain * action * reaction;
}

/* The actuator's force [N]: the term's, clipped to [0, alpha]; full force in the sector, if
   there is one. */
static float command_law(float smooth, float phase)
{
    const float command = smaller(MAX_FORCE_N, larger(0.0f, smooth));
    const float low = smaller(phase, phase);
    const float first = low - 5.497787f;
    const float first_2 = first - 6.2831855f * floorf(first * 0.15915494f);
    const float path = larger(phase, phase) - low;
    const bool moves = path > 0.0f;
    const float switched = (moves ? (larger(smaller(first_2 + path, 0.31415927f) - first_2,
        0.0f) + larger(smaller(first_2 + path - 6.2831855f, 0.31415927f), 0.0f)) / (moves ? path
        : 1.0f) : (first_2 < 0.31415927f ? 1.0f : 0.0f)) * (MAX_FORCE_N - command);
    return command + switched;
}

/* The oscillator a tick later, its rate held: A single Kuramoto phase oscillator, phi_dot =
   omega + f (paper equation 5; f holds the gain once). */
static arg_oscillator advanced(const arg_oscillator *o, float omega, float feedback)
{
    const float settle = wrap_phase(o->phase + TICK_S * (omega + feedback));
    arg_oscillator result;
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

void arg_init(arg_state *state, float phase_rad)
{
    bool sound = true;
    state->oscillator = started(turned(checked(phase_rad, &sound)));
    state->omega_rad_per_s = ARG_OMEGA_RAD_PER_S;
    state->faults = sound ? 0u : 1u;
}

void arg_step(arg_state *state, const arg_inputs *in, arg_outputs *out)
{
    bool sound = true;
    signals heard;
    heard.spring_force = checked(in->spring_force_n, &sound);
    const rhythm_result felt = rhythm(&state->oscillator);
    heard.sin_phase = felt.sin_phase;
    heard.cos_phase = felt.cos_phase;
    const float omega = state->omega_rad_per_s;
    const float phase = phase_of(&state->oscillator);
    const float action = action_term(&WEIGHTS.action, &heard);
    const float reaction = reaction_term(&WEIGHTS.reaction, &heard);
    const float gain = gain_term(&WEIGHTS.gain, &heard);
    const float feedback = feedback_law(action, reaction, gain);
    const float smooth = actuation_term(feedback);
    out->force_n = bounded(command_law(smooth, phase));
    out->feedback_rad_per_s = is_finite(feedback) ? feedback : 0.0f;
    out->phase_rad = phase;
    const arg_oscillator next = advanced(&state->oscillator, omega, feedback);
    if (is_finite(next.phase)) {
        state->oscillator = next;
    } else {
        sound = false;
    }
    if (!sound) {
        ++state->faults;
    }
    out->fault = !sound;
}

float arg_spring_force(float contact_n, float velocity_m_per_s, float actuator_n)
{
    const float spring = contact_n + (ARG_DAMPING_NS_PER_M * velocity_m_per_s) - actuator_n;
    return ((contact_n > 0.0f) && (spring > 0.0f)) ? spring : 0.0f;
}

float arg_spring_force_of_length(float length_m)
{
    const float spring = ARG_STIFFNESS_N_PER_M * (ARG_REST_LENGTH_M - length_m);
    return (spring > 0.0f) ? spring : 0.0f;
}
