#include "coupling.h"

/* The memory: a force and an acceleration for each degree of freedom, then the matrix A, then rows
 * of an intermediate matrix. */
struct parts {
    mjtNum *force;
    mjtNum *acceleration;
    mjtNum *compliance;
    mjtNum *half;
};

static struct parts parts_of(mjtNum *memory, size_t nv, size_t n)
{
    return (struct parts){memory, memory + nv, memory + 2 * nv, memory + 2 * nv + n * n};
}

size_t coupling_memory(size_t nv, size_t n)
{
    return 2 * nv + n * n + n * nv;
}

/* Forces that do not depend on accelerations, without those of actuators: those of MuJoCo's
 * `qfrc_smooth`, which is computed after the actuators. */
static void smooth_force(const mjModel *m, mjData *d, mjtNum *force)
{
    for (int i = 0; i < m->nv; i++)
        force[i] = d->qfrc_passive[i] - d->qfrc_bias[i] + d->qfrc_applied[i];
    for (int body = 1; body < m->nbody; body++) {
        const mjtNum *wrench = d->xfrc_applied + 6 * body;
        if (wrench[0] || wrench[1] || wrench[2] || wrench[3] || wrench[4] || wrench[5])
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

/* The column of the inverse of L' at a degree of freedom, where the mass matrix is L' D L: nonzero
 * for itself and for those that carry its body. */
static void half_solve(const mjModel *m, const mjData *d, int dof, mjtNum *column)
{
    mju_zero(column, m->nv);
    column[dof] = 1.0;
    const int *carriers = m->M_colind + m->M_rowadr[dof];
    for (int k = m->M_rownnz[dof] - 1; k >= 0; k--) {
        int row = carriers[k], address = m->M_rowadr[row];
        /* The last element of a row is the diagonal. */
        for (int e = 0; e < m->M_rownnz[row] - 1; e++)
            column[m->M_colind[address + e]] -= d->qLD[address + e] * column[row];
    }
}

/* Fills the matrix A. Zeros between joints that do not act on each other are exact. */
static void measure_compliance(const mjModel *m, const mjData *d,
                               const struct coupled_joint *joints, int n, struct parts parts)
{
    int nv = m->nv;
    for (int i = 0; i < n; i++) {
        mjtNum *row = parts.half + i * nv;
        half_solve(m, d, joints[i].dof, row);
        for (int j = 0; j <= i; j++) {
            const mjtNum *other = parts.half + j * nv;
            /* None is nonzero above its own degree of freedom. */
            int end = joints[i].dof < joints[j].dof ? joints[i].dof : joints[j].dof;
            mjtNum sum = 0.0;
            for (int k = 0; k <= end; k++)
                sum += row[k] * other[k] * d->qLDiagInv[k];
            parts.compliance[n * i + j] = parts.compliance[n * j + i] = sum;
        }
    }
}

void coupling_measure(const mjModel *m, mjData *d, struct coupled_joint *joints, int n,
                      mjtNum *memory)
{
    struct parts parts = parts_of(memory, (size_t)m->nv, (size_t)n);
    smooth_force(m, d, parts.force);
    for (int i = 0; i < n; i++)
        parts.force[joints[i].dof] += joints[i].constraint;
    if (m->nv == 1) {
        parts.compliance[0] = d->qLDiagInv[0];
        parts.acceleration[0] = parts.force[0] * d->qLDiagInv[0];
    } else {
        measure_compliance(m, d, joints, n, parts);
        mj_solveM(m, d, parts.acceleration, parts.force, 1);
    }
    for (int i = 0; i < n; i++) {
        const mjtNum *row = parts.compliance + n * i;
        double acceleration = parts.acceleration[joints[i].dof];
        for (int j = 0; j < n; j++)
            acceleration += j == i ? 0.0 : row[j] * joints[j].shaft;
        joints[i].inertia = 1.0 / row[i];
        joints[i].torque = joints[i].inertia * acceleration;
    }
}

double coupling_compliance(const mjModel *m, const mjtNum *memory, int n, int i, int j)
{
    return memory[2 * m->nv + n * i + j];
}

void coupling_demand(const mjModel *m, struct coupled_joint *joints, int n)
{
    for (int i = 0; i < n; i++) {
        struct coupled_joint *joint = joints + i;
        double inertia = joint->inertia + implicit_inertia(m, joint->dof);
        joint->servo = inertia * joint->acceleration - joint->torque;
    }
}

void coupling_demand_all(const mjModel *m, mjData *d, struct coupled_joint *joints, int n,
                         mjtNum *memory)
{
    struct parts parts = parts_of(memory, (size_t)m->nv, (size_t)n);
    mjtNum *inertial = parts.half;
    smooth_force(m, d, parts.force);
    for (int i = 0; i < n; i++)
        parts.acceleration[joints[i].dof] = joints[i].acceleration;
    if (m->nv == 1)
        inertial[0] = d->M[0] * parts.acceleration[0];
    else
        mj_mulM(m, d, inertial, parts.acceleration);
    for (int i = 0; i < n; i++) {
        int dof = joints[i].dof;
        double damping = implicit_inertia(m, dof) * joints[i].acceleration;
        joints[i].servo = inertial[dof] + damping - parts.force[dof] - joints[i].constraint;
    }
}
