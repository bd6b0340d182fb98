/*
 * The smart actuator as an engine plugin of MuJoCo: an actuator whose force comes from the board's
 * own control step, its bridge, motor and gear train.
 *
 * The whole state of each servo is in `plugin_state`, so that mj_getState, mj_setState, resets and
 * rollouts have it. Each mjData has memory of its own for one step; nothing is shared by threads.
 */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "coupling.h"
#include "sensor.h"
#include "servo.h"

/* Rounding of a motion that nothing unforeseen has changed: angles of rad, rates of 1e2 rad/s. */
static const double ANGLE_ROUNDING_RAD = 1e-10, RATE_ROUNDING_RAD_S = 1e-7;

static const double DEG = 180.0 / mjPI;

/* All servos of a simulation. */
struct servos {
    int count;
    struct servo **servo;
    struct coupled_joint *joints;
    mjtNum *memory;
    /* Whether the length of the step was checked. */
    int is_checked;
};

/* A servo, with memory for one step. */
struct servo {
    struct servo_config config;
    /* Where its state begins, and the state at the end of the step. */
    int address;
    mjtNum *next;
    /* Its place among the servos, which the first of them owns. */
    int place;
    struct servos *all;
};

static struct servo *servo_of(const mjData *d, int instance)
{
    return (struct servo *)d->plugin_data[instance];
}

static struct actuator *actuator_in(mjtNum *state)
{
    return (struct actuator *)(state + SERVO_HEADER);
}

static int state_words(const struct servo_config *config)
{
    return SERVO_HEADER + (int)((config->size + sizeof(mjtNum) - 1) / sizeof(mjtNum));
}

static int nstate(const mjModel *m, int instance)
{
    struct servo_config config;
    struct actuator_why why;
    if (!servo_configure(m, instance, &config, &why)) {
        mju_warning("%s: %s", SERVO_PLUGIN, why.text);
        /* `init` then fails. */
        return 0;
    }
    return state_words(&config);
}

static void destroy(mjData *d, int instance)
{
    struct servo *servo = servo_of(d, instance);
    if (!servo)
        return;
    if (servo->place == 0 && servo->all) {
        free(servo->all->servo);
        free(servo->all->joints);
        free(servo->all->memory);
        free(servo->all);
    }
    free(servo->next);
    free(servo);
    d->plugin_data[instance] = 0;
}

/* The servos of a simulation, which all instances share; the first one makes the list. */
static int join(const mjModel *m, mjData *d, int instance, struct servo *servo)
{
    int count = 0, first = -1;
    for (int i = 0; i < m->nplugin; i++) {
        if (m->plugin[i] != m->plugin[instance])
            continue;
        if (first < 0)
            first = i;
        if (i == instance)
            servo->place = count;
        count++;
    }
    if (first != instance) {
        servo->all = servo_of(d, first)->all;
    } else {
        struct servos *all = calloc(1, sizeof *all);
        if (!all)
            return 0;
        servo->all = all;
        all->count = count;
        all->servo = calloc((size_t)count, sizeof *all->servo);
        all->joints = calloc((size_t)count, sizeof *all->joints);
        all->memory = calloc(2 * (size_t)m->nv * ((size_t)count + 1), sizeof *all->memory);
        if (!all->servo || !all->joints || !all->memory)
            return 0;
    }
    servo->all->servo[servo->place] = servo;
    servo->all->joints[servo->place].dof = servo->config.dof;
    return 1;
}

static void reset(const mjModel *m, mjtNum *state, void *data, int instance)
{
    (void)data;
    struct servo_config config;
    struct actuator_why why;
    if (!servo_configure(m, instance, &config, &why))
        return;
    memset(state, 0, (size_t)state_words(&config) * sizeof *state);
    actuator_start(actuator_in(state), config.size, &config.settings, &why);
}

static int init(const mjModel *m, mjData *d, int instance)
{
    struct actuator_why why;
    struct servo *servo = calloc(1, sizeof *servo);
    if (!servo)
        return -1;
    d->plugin_data[instance] = (uintptr_t)servo;
    servo->address = m->plugin_stateadr[instance];
    struct servo_config *config = &servo->config;
    if (!servo_configure(m, instance, config, &why) || !servo_attach(m, instance, config, &why)) {
        mju_warning("%s: %s", SERVO_PLUGIN, why.text);
        destroy(d, instance);
        return -1;
    }
    servo->next = calloc((size_t)state_words(config), sizeof *servo->next);
    mjtNum *state = d->plugin_state + servo->address;
    if (!servo->next || !join(m, d, instance, servo) ||
        actuator_start(actuator_in(state), config->size, &config->settings, &why)) {
        mju_warning("%s: %s", SERVO_PLUGIN, why.text);
        destroy(d, instance);
        return -1;
    }
    return 0;
}

/* Tells the actuator how its load has moved beyond what was predicted, and reads its shaft. */
static void show_motion(const mjData *d, struct servo *servo, struct coupled_joint *joint)
{
    const struct servo_config *config = &servo->config;
    mjtNum *next = servo->next;
    double angle = d->actuator_length[config->actuator];
    double rate = config->gear * d->qvel[config->dof];
    struct actuator *actuator = actuator_in(next);
    struct actuator_load load;
    if (!next[SERVO_STARTED]) {
        actuator_place(actuator, angle * DEG);
        next[SERVO_ANGLE] = angle;
    }
    double moved = angle - next[SERVO_ANGLE], accelerated = rate - next[SERVO_RATE];
    if (config->is_loaded &&
        (mju_abs(moved) > ANGLE_ROUNDING_RAD || mju_abs(accelerated) > RATE_ROUNDING_RAD_S))
        actuator_push_load(actuator, moved * DEG, next[SERVO_INERTIA] * accelerated);
    if (config->is_loaded && !actuator_read_load(actuator, &load))
        next[SERVO_SHAFT] = load.shaft_torque_nm * config->gear;
    joint->shaft = next[SERVO_SHAFT];
    joint->constraint = next[SERVO_CONSTRAINT];
}

/* Tells the actuator what acts on its load, as torque and inertia at its shaft. */
static void show_load(const mjModel *m, struct servo *servo, const struct coupled_joint *joint)
{
    mjtNum *next = servo->next;
    double gear = servo->config.gear, torque = joint->torque / gear;
    struct actuator *actuator = actuator_in(next);
    if (!servo->config.is_loaded)
        return;
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

/* Advances a copy of the state to the end of the step, and demands the acceleration of the
 * joint. */
static void predict(const mjModel *m, const mjData *d, struct servo *servo,
                    struct coupled_joint *joint)
{
    const struct servo_config *config = &servo->config;
    mjtNum *next = servo->next, step = m->opt.timestep;
    struct actuator_load load = {0.0, 0.0, 0.0};
    mjtNum ctrl = d->ctrl[config->actuator];
    if (m->actuator_ctrllimited[config->actuator]) {
        const mjtNum *range = m->actuator_ctrlrange + 2 * config->actuator;
        ctrl = mju_clip(ctrl, range[0], range[1]);
    }
    next[SERVO_STARTED] = 1;
    next[SERVO_TIME] += step;
    actuator_drive_to(actuator_in(next), config->input, config->scale * ctrl, next[SERVO_TIME]);
    actuator_read_load(actuator_in(next), &load);
    /* MuJoCo adds the acceleration to the rate, and the rate to the angle. */
    double angle = d->actuator_length[config->actuator];
    next[SERVO_ANGLE] = load.angle_deg / DEG;
    next[SERVO_RATE] = (next[SERVO_ANGLE] - angle) / step;
    joint->acceleration = (next[SERVO_RATE] / config->gear - d->qvel[config->dof]) / step;
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
        const struct servo_config *config = &all->servo[i]->config;
        double sum = 0.0, gear = config->gear;
        for (int j = 0; j < all->count; j++)
            sum += mju_abs(coupling_compliance(m, all->memory, all->count, all->joints, i, j));
        if (config->is_loaded && config->stiffness < 1e6)
            greatest = mju_max(greatest, config->stiffness * gear * gear * sum);
    }
    double phase = m->opt.timestep * mju_sqrt(greatest);
    if (phase > MOST_PHASE)
        mju_warning("%s: the shafts oscillate by up to %.2f rad in a timestep, expected %.1f at most: "
                    "shorten the timestep, or add armature to the joints of light links",
                    SERVO_PLUGIN, phase, MOST_PHASE);
}

/* The forces of all servos. */
static void compute_forces(const mjModel *m, mjData *d, struct servos *all)
{
    for (int i = 0; i < all->count; i++) {
        struct servo *servo = all->servo[i];
        memcpy(servo->next, d->plugin_state + servo->address,
               (size_t)state_words(&servo->config) * sizeof *servo->next);
        show_motion(d, servo, all->joints + i);
    }
    coupling_measure(m, d, all->joints, all->count, all->memory);
    if (!all->is_checked)
        check_step(m, all);
    for (int i = 0; i < all->count; i++) {
        struct servo *servo = all->servo[i];
        show_load(m, servo, all->joints + i);
        predict(m, d, servo, all->joints + i);
        double torque = coupling_torque(m, all->joints + i);
        d->actuator_force[servo->config.actuator] = torque / servo->config.gear;
        /* What is not known of a shaft is its last torque. */
        if (!servo->config.is_loaded)
            servo->next[SERVO_SHAFT] = torque;
    }
}

static void compute(const mjModel *m, mjData *d, int instance, int capability)
{
    const struct servo *servo = servo_of(d, instance);
    (void)capability;
    if (servo->place == 0)
        compute_forces(m, d, servo->all);
}

static void advance(const mjModel *m, mjData *d, int instance)
{
    (void)m;
    struct servo *servo = servo_of(d, instance);
    mjtNum *state = d->plugin_state + servo->address;
    servo->next[SERVO_CONSTRAINT] = d->qfrc_constraint[servo->config.dof];
    memcpy(state, servo->next, (size_t)state_words(&servo->config) * sizeof *state);
}

mjPLUGIN_LIB_INIT(smart_actuator)
{
    mjpPlugin plugin;
    mjp_defaultPlugin(&plugin);
    plugin.name = SERVO_PLUGIN;
    plugin.capabilityflags = mjPLUGIN_ACTUATOR;
    plugin.nattribute = SERVO_ATTRIBUTE_COUNT;
    plugin.attributes = SERVO_ATTRIBUTES;
    plugin.nstate = nstate;
    plugin.init = init;
    plugin.destroy = destroy;
    plugin.reset = reset;
    plugin.compute = compute;
    plugin.advance = advance;
    mjp_registerPlugin(&plugin);
    sensor_register();
}
