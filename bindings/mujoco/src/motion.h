/* A step of all servos: from the state of MuJoCo to the forces of their actuators. */
#ifndef MOTION_H
#define MOTION_H

#include "servos.h"

/* Computes the forces, and the states at the end of the step. */
void motion_compute(const mjModel *m, mjData *d, struct servos *all);

/* Takes the step of the servos of an instance: their states are those at its end. */
void motion_advance(mjData *d, const struct instance *mine);

#endif
