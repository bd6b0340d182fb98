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
 *
 * Servos whose load does not act on them demand accelerations for any torques. If such
 * servos move all degrees of freedom, their torques follow from the equations of motion,
 * F = M a - f, without the inverse.
 */
#ifndef COUPLING_H
#define COUPLING_H

#include <mujoco/mujoco.h>

/* One joint, for one step. All torques act on the joint, and accelerations are in rad/s^2. */
struct coupled_joint {
    /* Its degree of freedom. */
    int dof;
    /* Torques of the shaft and of constraints, Nm. */
    double shaft;
    double constraint;
    /* Written: inertia of the load, kg m^2, and the torque on it beside that of the servo, Nm. */
    double inertia;
    double torque;
    /* The acceleration that the servo demands. */
    double acceleration;
    /* Written by coupling_demand: the torque of the servo, Nm. */
    double servo;
};

/* Elements of memory for n joints among nv degrees of freedom. */
size_t coupling_memory(size_t nv, size_t n);

/* Fills inertia and torque of all joints, with that memory. */
void coupling_measure(const mjModel *m, mjData *d, struct coupled_joint *joints, int n,
                      mjtNum *memory);

/* Acceleration of joint i by a unit torque at joint j, in the memory that was filled. */
double coupling_compliance(const mjModel *m, const mjtNum *memory, int n, int i, int j);

/* Computes the torques of the servos from inertias and torques of their joints. */
void coupling_demand(const mjModel *m, struct coupled_joint *joints, int n);

/* The same for n joints that are all degrees of freedom, by the equations of motion. */
void coupling_demand_all(const mjModel *m, mjData *d, struct coupled_joint *joints, int n,
                         mjtNum *memory);

#endif
