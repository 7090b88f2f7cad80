/* arg.h: ARG-rF-gF-both-w4, for a control loop of 0.002 s. Written by tegotae from a
   controller file; arg.json describes it, README.md how to use it. */
#ifndef ARG_H
#define ARG_H

#include <stdbool.h>
#include <stdint.h>

#define ARG_LIMBS 1
#define ARG_TICK_S 0.002f /* period of the control loop [s] */
#define ARG_OMEGA_RAD_PER_S 4.0f /* frequency omega at start [rad/s] */
#define ARG_MAX_FORCE_N 4.0f /* largest force of an actuator alpha [N] */
#define ARG_STIFFNESS_N_PER_M 5.0f /* stiffness of a leg k [N/m] */
#define ARG_DAMPING_NS_PER_M 0.2f /* damping of a leg c [N s/m] */
#define ARG_REST_LENGTH_M 1.0f /* length of a leg at rest l0 [m] */

/* The state of one oscillator. */
typedef struct {
    float phase; /* rad, in [0, 2 pi) */
} arg_oscillator;

/* All that one step hands to the next. */
typedef struct {
    arg_oscillator oscillator;
    float omega_rad_per_s; /* frequency; may be changed between steps */
    uint32_t faults; /* steps that met what is no finite number; 1 from such a start */
} arg_state;

/* What is measured at the start of a tick. */
typedef struct {
    float spring_force_n; /* force of the leg's spring F_k, 0 in flight; not the force of contact [N] */
} arg_inputs;

/* What is to be done during the tick. */
typedef struct {
    float force_n; /* force of the actuator, in [0, alpha]; send 0 while the foot is in the air [N] */
    float feedback_rad_per_s; /* Tegotae feedback f [rad/s] */
    float phase_rad; /* phase at the start of the tick [rad] */
    bool fault; /* something was no finite number, see README.md */
} arg_outputs;

#ifdef __cplusplus
extern "C" {
#endif

/* Make the state that a run begins with, at these phases [rad], which count modulo 2 pi; one
   that is no finite number counts as 0, and as a fault. */
void arg_init(arg_state *state, float phase_rad);

/* One tick: from what is measured at its start to what is done until its end. */
void arg_step(arg_state *state, const arg_inputs *in, arg_outputs *out);

/* The spring's force F_k [N] from the force of contact, such as that of a load cell under
   the foot: F_k = F_contact + c v - F_a, v being the velocity of the hip upwards. 0 without
   contact. The law wants this one; fed with the force of contact it hops differently. */
float arg_spring_force(float contact_n, float velocity_m_per_s, float actuator_n);

/* The spring's force F_k [N] from the length of the leg: k (l0 - l), and 0 beyond l0. */
float arg_spring_force_of_length(float length_m);

#ifdef __cplusplus
}
#endif

#endif /* ARG_H */
