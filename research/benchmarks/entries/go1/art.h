/* art.h: ART-rF-tphif-w8@go1, for a control loop of 0.02 s. Written by tegotae from a
   controller file; art.json describes it, README.md how to use it. */
#ifndef ART_H
#define ART_H

#include <stdbool.h>
#include <stdint.h>

/* As it was trained, limb 0: spring_force is FL_foot_force, drives FL_thigh; limb 1:
   spring_force is FL_foot_force, drives FL_calf; limb 2: spring_force is FR_foot_force,
   drives FR_thigh; limb 3: spring_force is FR_foot_force, drives FR_calf; limb 4:
   spring_force is RL_foot_force, drives RL_thigh; limb 5: spring_force is RL_foot_force,
   drives RL_calf; limb 6: spring_force is RR_foot_force, drives RR_thigh; limb 7:
   spring_force is RR_foot_force, drives RR_calf. */

#define ART_LIMBS 8
#define ART_TICK_S 0.02f /* period of the control loop [s] */
#define ART_OMEGA_RAD_PER_S 12.0f /* frequency omega at start [rad/s] */
#define ART_MAX_FORCE_N 1.0f /* largest force of an actuator alpha [N] */
#define ART_PHASE_RAD {0.0f, 0.0f, 3.1415927f, 3.1415927f, 3.1415927f, 3.1415927f, 0.0f, 0.0f} /* phases at start in training [rad] */

/* The state of one oscillator. */
typedef struct {
    float phase; /* rad, in [0, 2 pi) */
} art_oscillator;

/* All that one step hands to the next. */
typedef struct {
    art_oscillator oscillator[ART_LIMBS];
    float omega_rad_per_s; /* frequency; may be changed between steps */
    uint32_t faults; /* steps that met what is no finite number; 1 from such a start */
} art_state;

/* What is measured at the start of a tick. */
typedef struct {
    float spring_force_n[ART_LIMBS]; /* force of the leg's spring F_k, 0 in flight; not the force of contact [N] */
} art_inputs;

/* What is to be done during the tick. */
typedef struct {
    float force_n[ART_LIMBS]; /* force in [0, alpha], which is an action: art_action [N] */
    float feedback_rad_per_s[ART_LIMBS]; /* Tegotae feedback f [rad/s] */
    float phase_rad[ART_LIMBS]; /* phase at the start of the tick [rad] */
    bool fault; /* something was no finite number, see README.md */
} art_outputs;

#ifdef __cplusplus
extern "C" {
#endif

/* Make the state that a run begins with, at these phases [rad], which count modulo 2 pi; one
   that is no finite number counts as 0, and as a fault. */
void art_init(art_state *state, const float phase_rad[ART_LIMBS]);

/* One tick: from what is measured at its start to what is done until its end. */
void art_step(art_state *state, const art_inputs *in, art_outputs *out);

/* The action of a limb at a force, as the wiring of the training has it: rest + (push -
   rest) force / alpha. */
float art_action(int limb, float force_n);

#ifdef __cplusplus
}
#endif

#endif /* ART_H */
