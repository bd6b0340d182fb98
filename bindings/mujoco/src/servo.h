/*
 * One servo of a MuJoCo model: its configuration, and the layout of its state.
 *
 * The servo is an actuator of the C library whose load is a joint of MuJoCo. Before each step of
 * MuJoCo the library computes where the load will be at the end of it, under the torque and the
 * inertia that act at the joint, and the force of the actuator is the one that moves the joint
 * there (coupling.c). Whatever else moves the joint meanwhile, such as a contact, is returned to
 * the library before the next step as a motion and an impulse of the load.
 */
#ifndef SERVO_H
#define SERVO_H

#include <mujoco/mujoco.h>
#include <stddef.h>

#include "actuator.h"

/* The name of the plugin. */
#define SERVO_PLUGIN "smart_actuator.servo"

/* The part of the state in front of that of the actuator, in mjtNum. */
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
    /* Torque and inertia that the servo was told, at its shaft, Nm and kg m^2. */
    SERVO_TORQUE,
    SERVO_INERTIA,
    /* Torque of MuJoCo's constraints on the joint in the last step, Nm. */
    SERVO_CONSTRAINT,
    /* Words of the state before the actuator. */
    SERVO_HEADER
};

/* What does not change during a simulation. */
struct servo_config {
    struct actuator_settings settings;
    /* One of enum actuator_input, and how many of its units are one of `ctrl`. */
    int input;
    double scale;
    /* Whether the load acts on the motion: for the bench alone; and the stiffness between its motor
     * and the joint, Nm/rad, infinite if it is rigid. */
    int is_loaded;
    double stiffness;
    /* Bytes of the actuator. */
    size_t size;
    /* The actuator of MuJoCo, and the degree of freedom of its joint. */
    int actuator;
    int dof;
    /* Angle of the servo over that of the joint. */
    double gear;
};

/* Reads the configuration of an instance. On an error it writes a sentence and returns 0. */
int servo_configure(const mjModel *m, int instance, struct servo_config *config,
                    struct actuator_why *why);

/* Finds the actuator and the joint of an instance, likewise. */
int servo_attach(const mjModel *m, int instance, struct servo_config *config,
                 struct actuator_why *why);

/* The attributes of the configuration. */
extern const char *const SERVO_ATTRIBUTES[];
extern const int SERVO_ATTRIBUTE_COUNT;

#endif
