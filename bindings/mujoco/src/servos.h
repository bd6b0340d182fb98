/*
 * All servos of a simulation, in memory of one mjData; nothing is shared by threads.
 *
 * The state of each servo is in `plugin_state`, one after the other for those of an instance. Here
 * are what does not change, and the state at the end of a step until MuJoCo has taken the step.
 */
#ifndef SERVOS_H
#define SERVOS_H

#include "coupling.h"
#include "servo.h"

/* The part of a state in front of that of the actuator, in mjtNum. */
enum servo_state {
    /* Simulated time, s. */
    SERVO_TIME,
    /* 0 until the first step. */
    SERVO_STARTED,
    /* Angle and rate that the joint has if nothing unforeseen moved it, rad and rad/s. */
    SERVO_ANGLE,
    SERVO_RATE,
    /* Torque of the servo's shaft on the joint, Nm. */
    SERVO_SHAFT,
    /* Torque and inertia that were set in the servo, at its shaft, Nm and kg m^2. */
    SERVO_TORQUE,
    SERVO_INERTIA,
    /* Torque of MuJoCo's constraints on the joint in the last step, Nm. */
    SERVO_CONSTRAINT,
    /* Words of the state before the actuator. */
    SERVO_HEADER
};

/* A servo. */
struct servo {
    struct servo_place place;
    /* Of its configuration. */
    int input;
    int is_loaded;
    double scale;
    double stiffness;
    /* Joint angle per servo angle. */
    double inverse_gear;
    /* Where its state begins in `plugin_state`, and the bytes of the actuator's part. */
    int address;
    size_t size;
    /* The state at the end of the step. */
    mjtNum next[SERVO_HEADER];
    struct actuator *actuator;
};

/* All servos of a simulation. */
struct servos {
    int count;
    struct servo *servo;
    struct coupled_joint *joints;
    mjtNum *memory;
    /* Whether they determine the motion of all degrees of freedom. */
    int moves_all;
    /* Whether the length of the step was checked. */
    int is_checked;
};

/* The servos of an instance, which are neighbours in the list that all instances share. */
struct instance {
    struct servos *all;
    int first;
    int count;
    /* Whether it frees the list. */
    int is_owner;
};

static inline struct instance *instance_of(const mjData *d, int instance)
{
    return (struct instance *)d->plugin_data[instance];
}

/* The part of a state that is the actuator's. */
static inline struct actuator_state *servo_saved(mjtNum *state)
{
    return (struct actuator_state *)(state + SERVO_HEADER);
}

/* Words of the state of one servo with this configuration. */
int servos_words(const struct servo_config *config);

/* Writes the state at rest of the servos of an instance. On an error it writes a sentence and
 * returns 0. */
int servos_reset(const mjModel *m, int instance, mjtNum *state, struct actuator_why *why);

/* Makes the servos of an instance, likewise; the first instance makes the list. */
int servos_create(const mjModel *m, mjData *d, int instance, struct actuator_why *why);

/* Frees them. */
void servos_destroy(mjData *d, int instance);

#endif
