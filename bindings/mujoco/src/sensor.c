/*
 * What a servo measures and what its motor does, as a sensor of MuJoCo. A plugin of its own, so
 * that a simulation without sensors does not pay for them.
 */
#include "sensor.h"

#include <string.h>

#include "servo.h"

/* Elements: command, deg; angle, deg; rate, deg/s; duty, %; measured angle, deg; measured rate,
 * deg/s; current, A; back-EMF, V. */
enum { ELEMENTS = 8 };

static const char *const ATTRIBUTES[] = {"servo"};

/* The instance of the servo, or -1. */
static int servo_instance(const mjModel *m, int instance)
{
    const char *name = mj_getPluginConfig(m, instance, "servo");
    int servo = name ? mj_name2id(m, mjOBJ_PLUGIN, name) : -1;
    const mjpPlugin *plugin = servo < 0 ? NULL : mjp_getPluginAtSlot(m->plugin[servo]);
    return plugin && strcmp(plugin->name, SERVO_PLUGIN) == 0 ? servo : -1;
}

static int nstate(const mjModel *m, int instance)
{
    (void)m, (void)instance;
    return 0;
}

static int nsensordata(const mjModel *m, int instance, int sensor)
{
    (void)m, (void)instance, (void)sensor;
    return ELEMENTS;
}

static int init(const mjModel *m, mjData *d, int instance)
{
    int servo = servo_instance(m, instance);
    if (servo < 0) {
        mju_warning("smart_actuator.readings: the key `servo` names no instance of " SERVO_PLUGIN);
        return -1;
    }
    d->plugin_data[instance] = (uintptr_t)servo;
    return 0;
}

static void reset(const mjModel *m, mjtNum *state, void *data, int instance)
{
    (void)m, (void)state, (void)data, (void)instance;
}

static void compute(const mjModel *m, mjData *d, int instance, int capability)
{
    int address = m->plugin_stateadr[d->plugin_data[instance]] + SERVO_HEADER;
    struct actuator_reading now;
    (void)capability;
    if (actuator_read((const struct actuator *)(d->plugin_state + address), &now))
        return;
    const mjtNum sensed[ELEMENTS] = {now.command_deg,    now.angle_deg,       now.rate_deg_s,
                                     now.duty_pct,       now.angle_meas_deg,  now.rate_meas_deg_s,
                                     now.current_a,      now.back_emf_v};
    for (int i = 0; i < m->nsensor; i++) {
        if (m->sensor_type[i] == mjSENS_PLUGIN && m->sensor_plugin[i] == instance)
            mju_copy(d->sensordata + m->sensor_adr[i], sensed, ELEMENTS);
    }
}

void sensor_register(void)
{
    mjpPlugin plugin;
    mjp_defaultPlugin(&plugin);
    plugin.name = "smart_actuator.readings";
    plugin.capabilityflags = mjPLUGIN_SENSOR;
    plugin.needstage = mjSTAGE_POS;
    plugin.nattribute = 1;
    plugin.attributes = ATTRIBUTES;
    plugin.nstate = nstate;
    plugin.nsensordata = nsensordata;
    plugin.init = init;
    plugin.reset = reset;
    plugin.compute = compute;
    mjp_registerPlugin(&plugin);
}
