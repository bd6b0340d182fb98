#include "motion.h"

#include <math.h>
#include <string.h>

/* Rounding of a motion that nothing unforeseen has changed: angles of rad, rates of 1e2 rad/s. */
static const double ANGLE_ROUNDING_RAD = 1e-10, RATE_ROUNDING_RAD_S = 1e-7;

static const double DEG = 180.0 / mjPI, RAD = mjPI / 180.0;

/* Continues from the state at the beginning of the step; before the first step the shaft is placed
 * where the joint is. */
static void restore(const mjData *d, struct servo *servo, mjtNum *state)
{
    double angle = d->actuator_length[servo->place.output];
    actuator_restore(servo->actuator, servo_saved(state));
    if (!state[SERVO_STARTED]) {
        actuator_place(servo->actuator, angle * DEG);
        servo->next[SERVO_ANGLE] = angle;
    }
}

/* Takes up what has moved the load beyond what was predicted, and reads the shaft. */
static void show_motion(const mjData *d, struct servo *servo)
{
    mjtNum *next = servo->next;
    struct actuator_load load;
    double rate = servo->place.gear * d->qvel[servo->place.dof];
    double moved = d->actuator_length[servo->place.output] - next[SERVO_ANGLE];
    double accelerated = rate - next[SERVO_RATE];
    if (fabs(moved) > ANGLE_ROUNDING_RAD || fabs(accelerated) > RATE_ROUNDING_RAD_S)
        actuator_push_load(servo->actuator, moved * DEG, next[SERVO_INERTIA] * accelerated);
    if (!actuator_read_load(servo->actuator, &load))
        next[SERVO_SHAFT] = load.shaft_torque_nm * servo->place.gear;
}

/* Begins the step of a servo. */
static void begin(mjData *d, struct servo *servo, struct coupled_joint *joint)
{
    mjtNum *state = d->plugin_state + servo->address;
    memcpy(servo->next, state, sizeof servo->next);
    if (servo->is_loaded) {
        restore(d, servo, state);
        show_motion(d, servo);
    }
    joint->shaft = servo->next[SERVO_SHAFT];
    joint->constraint = servo->next[SERVO_CONSTRAINT];
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

/* Advances to the end of the step; returns the angle of the load there, deg. One that is not loaded
 * continues from its state here, in one call. */
static double advance(const mjModel *m, const mjData *d, struct servo *servo, mjtNum *state,
                      double time)
{
    struct actuator *actuator = servo->actuator;
    struct actuator_load load = {0.0, 0.0, 0.0};
    int control = servo->place.control, is_refused;
    mjtNum ctrl = d->ctrl[control];
    if (m->actuator_ctrllimited[control]) {
        const mjtNum *range = m->actuator_ctrlrange + 2 * control;
        ctrl = mju_clip(ctrl, range[0], range[1]);
    }
    ctrl *= servo->scale;
    if (!servo->is_loaded && state[SERVO_STARTED]) {
        is_refused =
            actuator_drive_from(actuator, servo_saved(state), servo->input, ctrl, time, &load);
    } else {
        if (!servo->is_loaded)
            restore(d, servo, state);
        is_refused = actuator_drive_load_to(actuator, servo->input, ctrl, time, &load);
    }
    /* A command that the library refuses, such as NaN, leaves the load where it is. */
    if (is_refused)
        actuator_read_load(actuator, &load);
    return load.angle_deg;
}

/* Advances to the end of the step, and demands the acceleration of the joint that leads there. */
static void predict(const mjModel *m, const mjData *d, struct servo *servo, double rate_of_steps,
                    struct coupled_joint *joint)
{
    const struct servo_place *place = &servo->place;
    mjtNum *state = d->plugin_state + servo->address;
    double time = state[SERVO_TIME] + m->opt.timestep;
    double angle = advance(m, d, servo, state, time) * RAD;
    /* MuJoCo adds the acceleration to the rate, and the rate to the angle. */
    double rate = (angle - d->actuator_length[place->output]) * rate_of_steps;
    servo->next[SERVO_STARTED] = 1;
    servo->next[SERVO_TIME] = time;
    servo->next[SERVO_ANGLE] = angle;
    servo->next[SERVO_RATE] = rate;
    joint->acceleration = (rate * servo->inverse_gear - d->qvel[place->dof]) * rate_of_steps;
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
    if (all->moves_all) {
        for (int i = 0; i < n; i++)
            all->joints[i].constraint = d->plugin_state[all->servo[i].address + SERVO_CONSTRAINT];
    } else {
        for (int i = 0; i < n; i++)
            begin(d, all->servo + i, all->joints + i);
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
