#include "motion.h"

#include <math.h>
#include <string.h>

/* Rounding of a motion that nothing unforeseen has changed: angles of rad, rates of 1e2 rad/s. */
static const double ANGLE_ROUNDING_RAD = 1e-10, RATE_ROUNDING_RAD_S = 1e-7;

static const double DEG = 180.0 / mjPI, RAD = mjPI / 180.0;

/* Continues from the state at the beginning of the step, with what has moved the load since beyond
 * what was predicted, and reads the shaft. */
static void begin(mjData *d, struct servo *servo, struct coupled_joint *joint)
{
    mjtNum *next = servo->next, *state = d->plugin_state + servo->address;
    struct actuator *actuator = servo->actuator;
    memcpy(next, state, SERVO_HEADER * sizeof *next);
    actuator_restore(actuator, servo_saved(state));
    double angle = d->actuator_length[servo->place.output];
    if (!next[SERVO_STARTED]) {
        actuator_place(actuator, angle * DEG);
        next[SERVO_ANGLE] = angle;
    }
    if (servo->is_loaded) {
        double rate = servo->place.gear * d->qvel[servo->place.dof];
        double moved = angle - next[SERVO_ANGLE], accelerated = rate - next[SERVO_RATE];
        struct actuator_load load;
        if (fabs(moved) > ANGLE_ROUNDING_RAD || fabs(accelerated) > RATE_ROUNDING_RAD_S)
            actuator_push_load(actuator, moved * DEG, next[SERVO_INERTIA] * accelerated);
        if (!actuator_read_load(actuator, &load))
            next[SERVO_SHAFT] = load.shaft_torque_nm * servo->place.gear;
    }
    joint->shaft = next[SERVO_SHAFT];
    joint->constraint = next[SERVO_CONSTRAINT];
}

/* Tells the actuator what acts on its load, as torque and inertia at its shaft. */
static void show_load(const mjModel *m, struct servo *servo, const struct coupled_joint *joint)
{
    mjtNum *next = servo->next;
    double gear = servo->place.gear, torque = joint->torque / gear;
    struct actuator *actuator = servo->actuator;
    if (!next[SERVO_STARTED])
        next[SERVO_TORQUE] = torque;
    /* The torque is held during a step, but changes in the middle between two instants at which
     * MuJoCo evaluates it: half of its change belongs to the step before. */
    if (torque != next[SERVO_TORQUE])
        actuator_push_load(actuator, 0.0, 0.5 * m->opt.timestep * (torque - next[SERVO_TORQUE]));
    next[SERVO_TORQUE] = torque;
    next[SERVO_INERTIA] = joint->inertia / (gear * gear);
    /* The range of the library. */
    actuator_set_load_nm(actuator, mju_clip(torque, -100.0, 100.0));
    actuator_set_load_inertia(actuator, next[SERVO_INERTIA]);
}

/* Advances to the end of the step, and demands the acceleration of the joint that leads there. */
static void predict(const mjModel *m, const mjData *d, struct servo *servo, double rate_of_steps,
                    struct coupled_joint *joint)
{
    const struct servo_place *place = &servo->place;
    mjtNum *next = servo->next, ctrl = d->ctrl[place->control];
    struct actuator_load load = {0.0, 0.0, 0.0};
    if (m->actuator_ctrllimited[place->control]) {
        const mjtNum *range = m->actuator_ctrlrange + 2 * place->control;
        ctrl = mju_clip(ctrl, range[0], range[1]);
    }
    next[SERVO_STARTED] = 1;
    next[SERVO_TIME] += m->opt.timestep;
    /* A command that the library refuses, such as NaN, leaves the load where it is. */
    if (actuator_drive_load_to(servo->actuator, servo->input, servo->scale * ctrl,
                               next[SERVO_TIME], &load))
        actuator_read_load(servo->actuator, &load);
    /* MuJoCo adds the acceleration to the rate, and the rate to the angle. */
    next[SERVO_ANGLE] = load.angle_deg * RAD;
    next[SERVO_RATE] = (next[SERVO_ANGLE] - d->actuator_length[place->output]) * rate_of_steps;
    joint->acceleration =
        (next[SERVO_RATE] * servo->inverse_gear - d->qvel[place->dof]) * rate_of_steps;
}

/* Warns once if the shafts of an arm oscillate too fast for the step. Gershgorin: no mode is faster
 * than the row of A with the greatest sum allows. The phase per step at which an arm becomes
 * unstable was found by experiment; a single servo is exact at any. */
static void check_step(const mjModel *m, struct servos *all)
{
    static const double MOST_PHASE = 0.8;
    double greatest = 0.0;
    all->is_checked = 1;
    for (int i = 0; i < all->count && all->count > 1; i++) {
        const struct servo *servo = all->servo + i;
        double sum = 0.0, gear = servo->place.gear;
        for (int j = 0; j < all->count; j++)
            sum += mju_abs(coupling_compliance(m, all->memory, all->count, i, j));
        if (servo->is_loaded && servo->stiffness < 1e6)
            greatest = mju_max(greatest, servo->stiffness * gear * gear * sum);
    }
    double phase = m->opt.timestep * mju_sqrt(greatest);
    if (phase > MOST_PHASE)
        mju_warning("%s: the shafts oscillate by up to %.2f rad in a timestep, expected %.1f at most: "
                    "shorten the timestep, or add armature to the joints of light links",
                    SERVO_PLUGIN, phase, MOST_PHASE);
}

void motion_compute(const mjModel *m, mjData *d, struct servos *all)
{
    double rate_of_steps = 1.0 / m->opt.timestep;
    int n = all->count;
    for (int i = 0; i < n; i++)
        begin(d, all->servo + i, all->joints + i);
    if (!all->moves_all) {
        coupling_measure(m, d, all->joints, n, all->memory);
        if (!all->is_checked)
            check_step(m, all);
    }
    for (int i = 0; i < n; i++) {
        if (all->servo[i].is_loaded)
            show_load(m, all->servo + i, all->joints + i);
        predict(m, d, all->servo + i, rate_of_steps, all->joints + i);
    }
    if (all->moves_all)
        coupling_demand_all(m, d, all->joints, n, all->memory);
    else
        coupling_demand(m, all->joints, n);
    for (int i = 0; i < n; i++) {
        struct servo *servo = all->servo + i;
        double torque = all->joints[i].servo;
        d->actuator_force[servo->place.output] = torque * servo->inverse_gear;
        /* What is not known of a shaft is its last torque. */
        if (!servo->is_loaded)
            servo->next[SERVO_SHAFT] = torque;
    }
}

void motion_advance(mjData *d, const struct instance *mine)
{
    for (int i = mine->first; i < mine->first + mine->count; i++) {
        struct servo *servo = mine->all->servo + i;
        mjtNum *state = d->plugin_state + servo->address;
        memcpy(state, servo->next, sizeof servo->next);
        state[SERVO_CONSTRAINT] = d->qfrc_constraint[servo->place.dof];
        actuator_save(servo->actuator, servo_saved(state), servo->size);
    }
}
