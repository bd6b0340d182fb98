#include "coupling.h"

/* Forces that do not depend on accelerations, without those of actuators: those of MuJoCo's
 * `qfrc_smooth`, which is computed after the actuators. */
static void smooth_force(const mjModel *m, mjData *d, mjtNum *force)
{
    mju_sub(force, d->qfrc_passive, d->qfrc_bias, m->nv);
    mju_addTo(force, d->qfrc_applied, m->nv);
    for (int body = 1; body < m->nbody; body++) {
        const mjtNum *wrench = d->xfrc_applied + 6 * body;
        if (!mju_isZero(wrench, 6))
            mj_applyFT(m, d, wrench, wrench + 3, d->xipos + 3 * body, body, force);
    }
}

/* Implicit damping of a degree of freedom: MuJoCo's integrators add it to the mass matrix. */
static mjtNum implicit_inertia(const mjModel *m, int dof)
{
    if (m->opt.integrator == mjINT_EULER && (m->opt.disableflags & mjDSBL_EULERDAMP))
        return 0.0;
    return m->opt.timestep * m->dof_damping[dof];
}

void coupling_measure(const mjModel *m, mjData *d, struct coupled_joint *joints, int n,
                      mjtNum *memory)
{
    int nv = m->nv;
    /* Row 0: the free acceleration; row 1 + j: the acceleration by a unit torque at joint j. */
    mjtNum *force = memory, *response = memory + (size_t)nv * (n + 1);
    smooth_force(m, d, force);
    mju_zero(force + nv, nv * n);
    for (int j = 0; j < n; j++)
        force[nv * (j + 1) + joints[j].dof] = 1.0;
    mj_solveM(m, d, response, force, n + 1);
    for (int i = 0; i < n; i++) {
        struct coupled_joint *joint = joints + i;
        double acceleration = response[joint->dof];
        for (int j = 0; j < n; j++) {
            double torque = joints[j].constraint + (j == i ? 0.0 : joints[j].shaft);
            acceleration += coupling_compliance(m, memory, n, joints, i, j) * torque;
        }
        joint->inertia = 1.0 / coupling_compliance(m, memory, n, joints, i, i);
        joint->torque = joint->inertia * acceleration;
    }
}

double coupling_compliance(const mjModel *m, const mjtNum *memory, int n,
                           const struct coupled_joint *joints, int i, int j)
{
    const mjtNum *response = memory + (size_t)m->nv * (n + 1);
    return response[m->nv * (j + 1) + joints[i].dof];
}

double coupling_torque(const mjModel *m, const struct coupled_joint *joint)
{
    return (joint->inertia + implicit_inertia(m, joint->dof)) * joint->acceleration - joint->torque;
}
