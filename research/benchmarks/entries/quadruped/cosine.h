/* cosine.h: cos+range@quadruped-c, for a control loop of 0.008 s. Written by tegotae from a
   controller file; cosine.json describes it, README.md how to use it. */
#ifndef COSINE_H
#define COSINE_H

#include <stdbool.h>
#include <stdint.h>

#define COSINE_LIMBS 4
#define COSINE_TICK_S 0.008f /* period of the control loop [s] */
#define COSINE_OMEGA_RAD_PER_S 2.0f /* frequency omega at start [rad/s] */

/* The state of one oscillator. */
typedef struct {
    float phase; /* rad, in [0, 2 pi) */
} cosine_oscillator;

/* All that one step hands to the next. */
typedef struct {
    cosine_oscillator oscillator[COSINE_LIMBS];
    float omega_rad_per_s; /* frequency; may be changed between steps */
    uint32_t faults; /* steps that met what is no finite number; 1 from such a start */
} cosine_state;

/* What is measured at the start of a tick. */
typedef struct {
    float spring_force_n[COSINE_LIMBS]; /* force of the leg's spring F_k, 0 in flight; not the force of contact [N] */
} cosine_inputs;

/* What is to be done during the tick. */
typedef struct {
    float foot_x_m[COSINE_LIMBS]; /* where the foot shall be, from its place at rest [m] */
    float foot_z_m[COSINE_LIMBS]; /* where the foot shall be, from its place at rest [m] */
    float feedback_rad_per_s[COSINE_LIMBS]; /* Tegotae feedback f [rad/s] */
    float phase_rad[COSINE_LIMBS]; /* phase at the start of the tick [rad] */
    bool fault; /* something was no finite number, see README.md */
} cosine_outputs;

#ifdef __cplusplus
extern "C" {
#endif

/* Make the state that a run begins with, at these phases [rad], which count modulo 2 pi; one
   that is no finite number counts as 0, and as a fault. */
void cosine_init(cosine_state *state, const float phase_rad[COSINE_LIMBS]);

/* One tick: from what is measured at its start to what is done until its end. */
void cosine_step(cosine_state *state, const cosine_inputs *in, cosine_outputs *out);

#ifdef __cplusplus
}
#endif

#endif /* COSINE_H */
