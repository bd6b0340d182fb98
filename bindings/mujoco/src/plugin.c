/*
 * The smart actuator as an engine plugin of MuJoCo: an actuator whose force comes from the board's
 * own control step, its bridge, motor and gear train.
 *
 * The whole state of each servo is in `plugin_state`, so that mj_getState, mj_setState, resets and
 * rollouts have it.
 */
#include "motion.h"
#include "sensor.h"
#include "servos.h"

static int nstate(const mjModel *m, int instance)
{
    struct servo_config config;
    struct actuator_why why;
    if (!servo_configure(m, instance, &config, &why)) {
        mju_warning("%s: %s", SERVO_PLUGIN, why.text);
        /* `init` then fails. */
        return 0;
    }
    return servos_words(&config) * servo_count(m, instance);
}

static void destroy(mjData *d, int instance)
{
    servos_destroy(d, instance);
}

static void reset(const mjModel *m, mjtNum *state, void *data, int instance)
{
    struct actuator_why why;
    (void)data;
    servos_reset(m, instance, state, &why);
}

static int init(const mjModel *m, mjData *d, int instance)
{
    struct actuator_why why = {"no memory"};
    if (servos_create(m, d, instance, &why))
        return 0;
    mju_warning("%s: %s", SERVO_PLUGIN, why.text);
    servos_destroy(d, instance);
    return -1;
}

static void compute(const mjModel *m, mjData *d, int instance, int capability)
{
    const struct instance *mine = instance_of(d, instance);
    (void)capability;
    if (mine->is_owner)
        motion_compute(m, d, mine->all);
}

static void advance(const mjModel *m, mjData *d, int instance)
{
    (void)m;
    motion_advance(d, instance_of(d, instance));
}

static void register_as(const char *name)
{
    mjpPlugin plugin;
    mjp_defaultPlugin(&plugin);
    plugin.name = name;
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
}

mjPLUGIN_LIB_INIT(smart_actuator)
{
    register_as(SERVO_PLUGIN);
    register_as(SERVO_PLUGIN_SHORT);
    sensor_register();
}
