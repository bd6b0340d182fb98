/*
 * The settings of an instance of the plugin, and the servos that have them.
 *
 * A servo is an actuator of the C library whose load is a joint of MuJoCo. Before each step of
 * MuJoCo the library computes where the load will be at the end of it, under the torque and the
 * inertia that act at the joint, and the force of the actuator is the one that moves the joint
 * there (coupling.c). Any other motion of the joint, such as by a contact, is returned to
 * the library before the next step as a motion and an impulse of the load.
 */
#ifndef SERVO_H
#define SERVO_H

#include <mujoco/mujoco.h>
#include <stddef.h>

#include "actuator.h"

/* The name of the plugin, and a short one: MuJoCo reads the name of a plugin to its end whenever it
 * looks one up, seven times per instance and step, which takes 30 ns more for the long one. */
#define SERVO_PLUGIN "smart_actuator.servo"
#define SERVO_PLUGIN_SHORT "sas"

/* What all servos of an instance have in common. */
struct servo_config {
    struct actuator_settings settings;
    /* The seed of the first servo; each has one of its own, in the order of the actuators. */
    unsigned long long seed;
    /* One of enum actuator_input, and how many of its units are one of `ctrl`. */
    int input;
    double scale;
    /* Whether the load acts on the motion: for the bench alone; and the stiffness between its motor
     * and the joint, Nm/rad, infinite if it is rigid. */
    int is_loaded;
    double stiffness;
};

/* Addresses of a servo in a model. */
struct servo_place {
    /* Its control and the output of its actuator. */
    int control;
    int output;
    /* The degree of freedom of its joint. */
    int dof;
    /* Angle of the servo over that of the joint. */
    double gear;
};

/* Whether the plugin of an instance is that of servos. */
int servo_is(const mjModel *m, int instance);

/* Reads the configuration of an instance. On an error it writes a sentence and returns 0. */
int servo_configure(const mjModel *m, int instance, struct servo_config *config,
                    struct actuator_why *why);

/* The number of actuators of an instance. */
int servo_count(const mjModel *m, int instance);

/* The place of one of them, counted from 0. On an error it writes a sentence and returns 0. */
int servo_find(const mjModel *m, int instance, int index, struct servo_place *place,
               struct actuator_why *why);

/* Starts one of them, in memory of `actuator_size(settings)` bytes. */
int servo_start(const struct servo_config *config, int index, struct actuator *actuator,
                struct actuator_why *why);

/* The attributes of the configuration. */
extern const char *const SERVO_ATTRIBUTES[];
extern const int SERVO_ATTRIBUTE_COUNT;

#endif
