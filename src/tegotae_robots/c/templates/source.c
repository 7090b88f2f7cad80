/** @prefix@.c: @title@. Written by tegotae from the code that its simulator runs. All numbers are
    float; nothing is allocated; there is no state but the caller's. */
#include "@prefix@.h"

#include <float.h>
#include <math.h>
% has_legs
#include <string.h>
% end has_legs

% own_constants
static const float @name@ = @value@;@comment@
% end own_constants

@weights@

% hears
/* All that the terms of a unit may read. */
typedef struct {
% signals
    float @name@;@comment@
% end signals
} signals;
% end hears

% has_legs
/* A leg in the axes of the trunk, its lengths over LENGTH_M. */
typedef struct {
    float axis[@joints@][3];   /* of every joint, from the trunk on */
    float anchor[@joints@][3]; /* a point on each axis */
    float slides[@joints@];    /* 1 of a joint that slides, 0 of one that turns */
    float foot[3];
    float low[@joints@];       /* limits, from the start on */
    float high[@joints@];
    float start[@joints@];     /* joints at rest [rad or m] */
    float unit[@joints@];      /* of a joint's number [rad or m] */
} leg_geometry;

static const float LENGTH_M = @length@;
static const leg_geometry LEGS[@limbs@] = {
@table@
};
% end has_legs

@functions@

% checks
/* The number itself; 0 for what is no finite number, which is told. */
static float checked(float x, bool *sound)
{
    const bool known = is_finite(x);
    *sound = *sound && known;
    return known ? x : 0.0f;
}
% end checks

% oscillates
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
% end oscillates

% pushes
/* A force in [0, alpha], whatever comes; 0 for what is no number. */
static float bounded(float force)
{
    return (force > 0.0f) ? ((force < MAX_FORCE_N) ? force : MAX_FORCE_N) : 0.0f;
}
% end pushes
% no pushes
/* A place of the foot; that at rest for what is no finite number. */
static float bounded(float place)
{
    return is_finite(place) ? place : 0.0f;
}
% end pushes

void @prefix@_init(@prefix@_state *state@at_phase@)
{
% oscillates
    bool sound = true;
% units
    state->oscillator@several?[unit]@ = @started@;
% end units
    state->omega_rad_per_s = @PREFIX@_OMEGA_RAD_PER_S;
    state->faults = sound ? 0u : 1u;
% end oscillates
% no oscillates
    state->faults = 0u;
% end oscillates
}

void @prefix@_step(@prefix@_state *state, const @prefix@_inputs *in, @prefix@_outputs *out)
{
    bool sound = true;
% hears
    signals heard@of_limbs@;
% end hears
% no senses
    (void)in;
% end senses
% units
% senses
    heard@several?[unit]@.@name@ = checked(in->@member@@limb@, &sound);
% end senses
% felt
    @statement@
% end felt
% end units
% coupled
    const coupling_result pulls = @coupling@;
    const float pulled@of_limbs@ = {@pulls@};
% end coupled
% units
% reads_omega
    const float omega = state->omega_rad_per_s;
% end reads_omega
% has_phase
    const float phase = @phase_of@;
% end has_phase
% terms
    const float @role@ = @call@;
% end terms
    const float feedback = @feedback_law@;
% averages
    const float reached = @phase_after@;
% end averages
% commanding
    @statement@
% end commanding
    out->feedback_rad_per_s@limb@ = is_finite(feedback) ? feedback : 0.0f;
% has_phase
    out->phase_rad@limb@ = phase;
% end has_phase
% oscillates
    const @prefix@_oscillator next = @advanced@;
    if (@next_is_finite@) {
        state->oscillator@several?[unit]@ = next;
    } else {
        sound = false;
    }
% end oscillates
% end units
    if (!sound) {
        ++state->faults;
    }
    out->fault = !sound;
}

% has_spring
float @prefix@_spring_force(float contact_n, float velocity_m_per_s, float actuator_n)
{
    const float spring = contact_n + (@PREFIX@_DAMPING_NS_PER_M * velocity_m_per_s) - actuator_n;
    return ((contact_n > 0.0f) && (spring > 0.0f)) ? spring : 0.0f;
}

float @prefix@_spring_force_of_length(float length_m)
{
    const float spring = @PREFIX@_STIFFNESS_N_PER_M * (@PREFIX@_REST_LENGTH_M - length_m);
    return (spring > 0.0f) ? spring : 0.0f;
}
% end has_spring

% has_action
/* The action at no force, and at full force. */
static const float REST@number_of_limbs@ = @rests@;
static const float PUSH@number_of_limbs@ = @full_pushes@;

float @prefix@_action(@several?int limb, @float force_n)
{
    return REST@several?[limb]@ + ((PUSH@several?[limb]@ - REST@several?[limb]@) * (force_n / MAX_FORCE_N));
}
% end has_action

% has_legs
/* A place over the leg's length, within which feet are commanded. */
static float over_length(float place_m)
{
    return fminf(fmaxf(place_m / LENGTH_M, -1.0f), 1.0f);
}

void @prefix@_joints(const @prefix@_outputs *out, float joints[@PREFIX@_LIMBS][@PREFIX@_JOINTS])
{
    for (int i = 0; i < @PREFIX@_LIMBS; ++i) {
        const leg_geometry *leg = &LEGS[i];
        const float wanted[3] = {@places@};
        float moved[@joints@] = {0.0f};
% has_closed_form
        const direct_result found = direct(leg, wanted);
        memcpy(moved, &found, sizeof moved);
% end has_closed_form
        const int steps = @has_closed_form?(found.there > 0.0f) ? 0 : @@steps@;
        for (int n = 0; n < steps; ++n) {
            const nearer_result next = nearer(leg, wanted, moved);
            memcpy(moved, &next, sizeof moved);
        }
        for (int k = 0; k < @joints@; ++k) {
            joints[i][k] = leg->start[k] + (leg->unit[k] * moved[k]);
        }
    }
}

void @prefix@_loads(float joints[@PREFIX@_LIMBS][@PREFIX@_JOINTS],
    float torques[@PREFIX@_LIMBS][@PREFIX@_JOINTS], float loads_n[@PREFIX@_LIMBS])
{
    for (int i = 0; i < @PREFIX@_LIMBS; ++i) {
        const leg_geometry *leg = &LEGS[i];
        float moved[@joints@];
        float torque[@joints@];
        for (int k = 0; k < @joints@; ++k) {
            moved[k] = (joints[i][k] - leg->start[k]) / leg->unit[k];
            torque[k] = torques[i][k] / ((leg->slides[k] > 0.0f) ? 1.0f : LENGTH_M);
        }
        const float upward = load(leg, moved, torque);
        loads_n[i] = (upward > 0.0f) ? upward : 0.0f;
    }
}
% end has_legs

% has_odometry
void @prefix@_command(@prefix@_inputs *in, float forward, float left, float yaw_rate,
    float heading_error)
{
    const float towards = 2.0f * remainderf(heading_error, 6.2831853f);
    float speed = 0.0f;
    yaw_rate += fminf(fmaxf(towards, -1.0f), 1.0f);
    for (int i = 0; i < @PREFIX@_LIMBS; ++i) {
        in->commanded_x_m_per_s[i] = forward - (yaw_rate * LENGTH_M * LEGS[i].foot[1]);
        in->commanded_y_m_per_s[i] = left + (yaw_rate * LENGTH_M * LEGS[i].foot[0]);
        speed = fmaxf(speed, hypotf(in->commanded_x_m_per_s[i], in->commanded_y_m_per_s[i]));
    }
    for (int i = 0; i < @PREFIX@_LIMBS; ++i) {
        in->commanded_speed_m_per_s[i] = speed;
    }
}

void @prefix@_odometry(@prefix@_inputs *in, float joints[@PREFIX@_LIMBS][@PREFIX@_JOINTS],
    float rates[@PREFIX@_LIMBS][@PREFIX@_JOINTS], const float turning[3])
{
    motion_result feet[@PREFIX@_LIMBS];
    float lowest = 1e9f;
    for (int i = 0; i < @PREFIX@_LIMBS; ++i) {
        const leg_geometry *leg = &LEGS[i];
        float moved[@joints@];
        float over[@joints@];
        for (int k = 0; k < @joints@; ++k) {
            moved[k] = (joints[i][k] - leg->start[k]) / leg->unit[k];
            over[k] = rates[i][k] / leg->unit[k];
        }
        feet[i] = motion(leg, moved, over);
        lowest = fminf(lowest, feet[i].foot_z);
    }
    float share = 1e-9f;
    float forward = 0.0f;
    float left = 0.0f;
    for (int i = 0; i < @PREFIX@_LIMBS; ++i) {
        const motion_result foot = feet[i];
        const float above = (foot.foot_z - lowest) / @stands@;
        const float rises = ((@rolling@ * foot.velocity_z) + (turning[0] * foot.foot_y) - (turning[1] * foot.foot_x)) / @rises@;
        const float stands = expf(-(above * above) - (rises * rises));
        share += stands;
        forward -= stands * ((@rolling@ * foot.velocity_x) + (turning[1] * foot.foot_z) - (turning[2] * foot.foot_y));
        left -= stands * ((@rolling@ * foot.velocity_y) + (turning[2] * foot.foot_x) - (turning[0] * foot.foot_z));
    }
    for (int i = 0; i < @PREFIX@_LIMBS; ++i) {
        in->odometry_x_m_per_s[i] = LENGTH_M * ((forward / share) - (turning[2] * LEGS[i].foot[1]));
        in->odometry_y_m_per_s[i] = LENGTH_M * ((left / share) + (turning[2] * LEGS[i].foot[0]));
    }
}
% end has_odometry
