/** @prefix@.h: @title@, for a control loop of @tick@ s. Written by tegotae from a controller file;
    @prefix@.json describes it, README.md how to use it. */
#ifndef @PREFIX@_H
#define @PREFIX@_H

#include <stdbool.h>
#include <stdint.h>

% wired
/** As it was trained, @wiring@. */

% end wired
#define @PREFIX@_LIMBS @limbs@
% has_legs
#define @PREFIX@_JOINTS @joints@ /* of a leg */
% end has_legs
% constants
#define @PREFIX@_@name@ @value@ /* @what@ */
% end constants

% oscillates
/* The state of one oscillator. */
typedef struct {
% state
    float @name@;@comment@
% end state
} @prefix@_oscillator;

% end oscillates
/* All that one step hands to the next. */
typedef struct {
% oscillates
    @prefix@_oscillator oscillator@of_limbs@;
    float omega_rad_per_s; /* frequency; may be changed between steps */
% end oscillates
    uint32_t faults; /* steps that met what is no finite number; 1 from such a start */
} @prefix@_state;

/* What is measured at the start of a tick. */
typedef struct {
% senses
    float @member@@of_limbs@; /* @what@ [@unit@] */
% end senses
% no senses
    float unused; /* this controller senses nothing */
% end senses
} @prefix@_inputs;

/* What is to be done during the tick. */
typedef struct {
% commands
    float @member@@of_limbs@; /* @what@ [@unit@] */
% end commands
    float feedback_rad_per_s@of_limbs@; /* Tegotae feedback f [rad/s] */
% has_phase
    float phase_rad@of_limbs@; /* phase at the start of the tick [rad] */
% end has_phase
    bool fault; /* something was no finite number, see README.md */
} @prefix@_outputs;

#ifdef __cplusplus
extern "C" {
#endif

% oscillates
/** Make the state that a run begins with, at these phases [rad], which count modulo 2 pi; one that
    is no finite number counts as 0, and as a fault. */
% end oscillates
% no oscillates
/* Make the state that a run begins with. */
% end oscillates
void @prefix@_init(@prefix@_state *state@at_phase@);

/* One tick: from what is measured at its start to what is done until its end. */
void @prefix@_step(@prefix@_state *state, const @prefix@_inputs *in, @prefix@_outputs *out);

% has_legs
/** The joints that put the feet where out has them, or as near as they reach: angles [rad], from the
    trunk on, or places of joints that slide [m]; of a leg with fewer joints the last are idle. */
/* They are
% legs
   @names@
% end legs
*/
void @prefix@_joints(const @prefix@_outputs *out, float joints[@PREFIX@_LIMBS][@PREFIX@_JOINTS]);

/** The ground's upward force on every foot [N], never negative, from the joints and the torques of
    their servos [N m]: -inv(J^T) tau of legs without mass. */
void @prefix@_loads(float joints[@PREFIX@_LIMBS][@PREFIX@_JOINTS],
    float torques[@PREFIX@_LIMBS][@PREFIX@_JOINTS], float loads_n[@PREFIX@_LIMBS]);

% end has_legs
% has_odometry
/** Command the robot: forward and to the left [m/s], and turning to the left [rad/s]. It turns to
    a heading, too, if it is given by how much that is to the left of its own [rad]; else 0. */
void @prefix@_command(@prefix@_inputs *in, float forward, float left, float yaw_rate,
    float heading_error);

/** Leg odometry: the velocity of the trunk over every foot, from the joints, their rates [rad/s],
    and a gyroscope in the axes of the trunk [rad/s]. */
void @prefix@_odometry(@prefix@_inputs *in, float joints[@PREFIX@_LIMBS][@PREFIX@_JOINTS],
    float rates[@PREFIX@_LIMBS][@PREFIX@_JOINTS], const float turning[3]);

% end has_odometry
% has_action
/** The action of a limb at a force, as the wiring of the training has it: rest + (push - rest)
    force / alpha. */
float @prefix@_action(@several?int limb, @float force_n);

% end has_action
% has_spring
/** The spring's force F_k [N] from the force of contact, such as that of a load cell under the
    foot: F_k = F_contact + c v - F_a, v being the velocity of the hip upwards. 0 without contact.
    The law wants this one; fed with the force of contact it hops differently. */
float @prefix@_spring_force(float contact_n, float velocity_m_per_s, float actuator_n);

/* The spring's force F_k [N] from the length of the leg: k (l0 - l), and 0 beyond l0. */
float @prefix@_spring_force_of_length(float length_m);

% end has_spring
#ifdef __cplusplus
}
#endif

#endif /* @PREFIX@_H */
