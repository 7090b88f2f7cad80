/* level.h: level, for a control loop of 0.02 s. Written by tegotae from a controller file;
   level.json describes it, README.md how to use it. */
#ifndef LEVEL_H
#define LEVEL_H

#include <stdbool.h>
#include <stdint.h>

/* As it was trained, limb 0: side_roll is root_roll, side_roll_rate is root_roll_rate,
   end_pitch is -root_pitch, side_yaw is root_yaw_rate, drives FL_foot_x and FL_foot_z; limb
   1: side_roll is -root_roll, side_roll_rate is -root_roll_rate, end_pitch is -root_pitch,
   side_yaw is root_yaw_rate, drives FR_foot_x and FR_foot_z; limb 2: side_roll is root_roll,
   side_roll_rate is root_roll_rate, end_pitch is root_pitch, side_yaw is root_yaw_rate,
   drives RL_foot_x and RL_foot_z; limb 3: side_roll is -root_roll, side_roll_rate is
   -root_roll_rate, end_pitch is root_pitch, side_yaw is root_yaw_rate, drives RR_foot_x and
   RR_foot_z. */

#define LEVEL_LIMBS 4
#define LEVEL_JOINTS 3 /* of a leg */
#define LEVEL_TICK_S 0.02f /* period of the control loop [s] */
#define LEVEL_OMEGA_RAD_PER_S 11.432299f /* frequency omega at start [rad/s] */
#define LEVEL_PHASE_RAD {0.0f, 3.1415927f, 3.1415927f, 0.0f} /* phases at start in training [rad] */

/* The state of one oscillator. */
typedef struct {
    float phase; /* rad, in [0, 2 pi) */
} level_oscillator;

/* All that one step hands to the next. */
typedef struct {
    level_oscillator oscillator[LEVEL_LIMBS];
    float omega_rad_per_s; /* frequency; may be changed between steps */
    uint32_t faults; /* steps that met what is no finite number; 1 from such a start */
} level_state;

/* What is measured at the start of a tick. */
typedef struct {
    float end_pitch_rad[LEVEL_LIMBS]; /* pitch of the body, up at the leg's end [rad] */
    float side_roll_rad[LEVEL_LIMBS]; /* roll of the body, up on the leg's side [rad] */
    float side_roll_rate_rad_per_s[LEVEL_LIMBS]; /* its rate [rad/s] */
    float side_yaw_rad[LEVEL_LIMBS]; /* yaw of the body, to the leg's side [rad] */
} level_inputs;

/* What is to be done during the tick. */
typedef struct {
    float foot_x_m[LEVEL_LIMBS]; /* where the foot shall be, from its place at rest [m] */
    float foot_z_m[LEVEL_LIMBS]; /* where the foot shall be, from its place at rest [m] */
    float feedback_rad_per_s[LEVEL_LIMBS]; /* Tegotae feedback f [rad/s] */
    float phase_rad[LEVEL_LIMBS]; /* phase at the start of the tick [rad] */
    bool fault; /* something was no finite number, see README.md */
} level_outputs;

#ifdef __cplusplus
extern "C" {
#endif

/* Make the state that a run begins with, at these phases [rad], which count modulo 2 pi; one
   that is no finite number counts as 0, and as a fault. */
void level_init(level_state *state, const float phase_rad[LEVEL_LIMBS]);

/* One tick: from what is measured at its start to what is done until its end. */
void level_step(level_state *state, const level_inputs *in, level_outputs *out);

/* The joints that put the feet where out has them, or as near as they reach: angles [rad],
   from the trunk on, or places of joints that slide [m]; of a leg with fewer joints the last
   are idle. */
/* They are
   FL_hip_joint, FL_thigh_joint, FL_calf_joint
   FR_hip_joint, FR_thigh_joint, FR_calf_joint
   RL_hip_joint, RL_thigh_joint, RL_calf_joint
   RR_hip_joint, RR_thigh_joint, RR_calf_joint
*/
void level_joints(const level_outputs *out, float joints[LEVEL_LIMBS][LEVEL_JOINTS]);

/* The ground's upward force on every foot [N], never negative, from the joints and the
   torques of their servos [N m]: -inv(J^T) tau of legs without mass. */
void level_loads(float joints[LEVEL_LIMBS][LEVEL_JOINTS],
    float torques[LEVEL_LIMBS][LEVEL_JOINTS], float loads_n[LEVEL_LIMBS]);

#ifdef __cplusplus
}
#endif

#endif /* LEVEL_H */
