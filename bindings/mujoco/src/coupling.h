/*
 * The joints of all servos of a simulation, coupled by the mass matrix of MuJoCo.
 *
 * Written for the servos' joints alone, the equations of motion are
 *
 *     a = a0 + A F
 *
 * a: accelerations, a0: those without the servos, F: torques of the servos, A: the servos' block of
 * the inverse mass matrix, so that all other degrees of freedom move as they do in MuJoCo. Seen
 * from servo i, its load has the inertia 1/A_ii and is moved by everything else; the torques of the
 * other servos are those of their shafts at the beginning of the step, which is the instant at
 * which MuJoCo's integrators evaluate forces. With torques or accelerations of the step before, the
 * light links of an arm oscillate on their shafts.
 */
#ifndef COUPLING_H
#define COUPLING_H

#include <mujoco/mujoco.h>

/* One joint, for one step. All torques act on the joint. */
struct coupled_joint {
    /* Its degree of freedom. */
    int dof;
    /* Torques of the shaft and of constraints, Nm. */
    double shaft;
    double constraint;
    /* Written: inertia of the load, kg m^2, and the torque on it beside that of the servo, Nm. */
    double inertia;
    double torque;
};

/* Elements of memory for n joints among nv degrees of freedom. */
size_t coupling_memory(size_t nv, size_t n);

/* Fills inertia and torque of all joints, with that memory. */
void coupling_measure(const mjModel *m, mjData *d, struct coupled_joint *joints, int n,
                      mjtNum *memory);

/* Acceleration of joint i by a unit torque at joint j, in the memory that was filled. */
double coupling_compliance(const mjModel *m, const mjtNum *memory, int n, int i, int j);

/* The torque of the servo that gives its load the acceleration. */
double coupling_torque(const mjModel *m, const struct coupled_joint *joint, double acceleration);

#endif
