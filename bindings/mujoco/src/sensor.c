/*
 * What the servos of an instance measure and what their motors do, as a sensor of MuJoCo. A plugin
 * of its own, so that a simulation without sensors does not pay for them.
 */
#include "sensor.h"

#include <stdint.h>
#include <stdlib.h>

#include "servos.h"

/* Elements of a servo: command, deg; angle, deg; rate, deg/s; duty, %; measured angle, deg;
 * measured rate, deg/s; current, A; back-EMF, V. */
enum { ELEMENTS = 8 };

#define SENSOR_PLUGIN "smart_actuator.readings"
/* As that of the servos. */
#define SENSOR_PLUGIN_SHORT "sar"

static const char *const ATTRIBUTES[] = {"servo"};

/* Where the states are, and an actuator to read them with. */
struct readings {
    int address;
    int words;
    int count;
    struct actuator *actuator;
};

/* The instance of the servos, or -1. */
static int servo_instance(const mjModel *m, int instance)
{
    const char *name = mj_getPluginConfig(m, instance, "servo");
    int servo = name ? mj_name2id(m, mjOBJ_PLUGIN, name) : -1;
    return servo_is(m, servo) ? servo : -1;
}

static int nstate(const mjModel *m, int instance)
{
    (void)m, (void)instance;
    return 0;
}

static int nsensordata(const mjModel *m, int instance, int sensor)
{
    int servo = servo_instance(m, instance);
    (void)sensor;
    /* `init` fails if there is none. */
    return servo < 0 ? ELEMENTS : ELEMENTS * servo_count(m, servo);
}

static void destroy(mjData *d, int instance)
{
    struct readings *readings = (struct readings *)d->plugin_data[instance];
    if (readings)
        free(readings->actuator);
    free(readings);
    d->plugin_data[instance] = 0;
}

static int init(const mjModel *m, mjData *d, int instance)
{
    int servo = servo_instance(m, instance);
    struct servo_config config;
    struct actuator_why why;
    if (servo < 0) {
        mju_warning(SENSOR_PLUGIN ": the key `servo` names no instance of " SERVO_PLUGIN);
        return -1;
    }
    struct readings *readings = calloc(1, sizeof *readings);
    d->plugin_data[instance] = (uintptr_t)readings;
    if (!readings || !servo_configure(m, servo, &config, &why))
        return -1;
    readings->address = m->plugin_stateadr[servo];
    readings->words = servos_words(&config);
    readings->count = servo_count(m, servo);
    readings->actuator = malloc(actuator_size(&config.settings));
    if (readings->actuator && servo_start(&config, 0, readings->actuator, &why))
        return 0;
    destroy(d, instance);
    return -1;
}

static void reset(const mjModel *m, mjtNum *state, void *data, int instance)
{
    (void)m, (void)state, (void)data, (void)instance;
}

static void read(const mjData *d, const struct readings *readings, int servo, mjtNum *sensed)
{
    mjtNum *state = d->plugin_state + readings->address + servo * readings->words;
    struct actuator_reading now;
    if (actuator_restore(readings->actuator, servo_saved(state)) ||
        actuator_read(readings->actuator, &now))
        return;
    const mjtNum elements[ELEMENTS] = {now.command_deg,    now.angle_deg,       now.rate_deg_s,
                                       now.duty_pct,       now.angle_meas_deg,  now.rate_meas_deg_s,
                                       now.current_a,      now.back_emf_v};
    mju_copy(sensed, elements, ELEMENTS);
}

static void compute(const mjModel *m, mjData *d, int instance, int capability)
{
    const struct readings *readings = (const struct readings *)d->plugin_data[instance];
    (void)capability;
    for (int i = 0; i < m->nsensor; i++) {
        if (m->sensor_type[i] != mjSENS_PLUGIN || m->sensor_plugin[i] != instance)
            continue;
        for (int servo = 0; servo < readings->count; servo++)
            read(d, readings, servo, d->sensordata + m->sensor_adr[i] + ELEMENTS * servo);
    }
}

static void register_as(const char *name)
{
    mjpPlugin plugin;
    mjp_defaultPlugin(&plugin);
    plugin.name = name;
    plugin.capabilityflags = mjPLUGIN_SENSOR;
    plugin.needstage = mjSTAGE_POS;
    plugin.nattribute = 1;
    plugin.attributes = ATTRIBUTES;
    plugin.nstate = nstate;
    plugin.nsensordata = nsensordata;
    plugin.init = init;
    plugin.destroy = destroy;
    plugin.reset = reset;
    plugin.compute = compute;
    mjp_registerPlugin(&plugin);
}

void sensor_register(void)
{
    register_as(SENSOR_PLUGIN);
    register_as(SENSOR_PLUGIN_SHORT);
}
