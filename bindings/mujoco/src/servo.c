/* The configuration of an instance. */
#include "servo.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *const SERVO_ATTRIBUTES[] = {"model", "plant", "preset", "pwm", "seed", "input",
                                        "parameters"};
const int SERVO_ATTRIBUTE_COUNT = sizeof SERVO_ATTRIBUTES / sizeof *SERVO_ATTRIBUTES;

/* A name of an input, and its units in one of `ctrl`, which has those of MuJoCo: rad and rad/s. */
struct input {
    const char *name;
    int input;
    double scale;
};

static const struct input INPUTS[] = {
    {"position", ACTUATOR_INPUT_POSITION, 180.0 / mjPI},
    {"rate", ACTUATOR_INPUT_RATE, 180.0 / mjPI},
    {"duty", ACTUATOR_INPUT_DUTY, 1.0},
    {"voltage", ACTUATOR_INPUT_VOLTAGE, 1.0},
};

static int refuse(struct actuator_why *why, const char *what, const char *value)
{
    snprintf(why->text, sizeof why->text, "%s: `%s`", what, value);
    return 0;
}

/* An attribute, or NULL where it is absent or empty. */
static const char *attribute(const mjModel *m, int instance, const char *name)
{
    const char *text = mj_getPluginConfig(m, instance, name);
    return text && *text ? text : NULL;
}

static int configure_input(const mjModel *m, int instance, struct servo_config *config,
                           struct actuator_why *why)
{
    const char *name = attribute(m, instance, "input");
    for (size_t i = 0; i < sizeof INPUTS / sizeof *INPUTS; i++) {
        if (strcmp(name ? name : "position", INPUTS[i].name) == 0) {
            config->input = INPUTS[i].input;
            config->scale = INPUTS[i].scale;
            return 1;
        }
    }
    return refuse(why, "input: expected position, rate, duty or voltage", name);
}

static int configure_seed(const mjModel *m, int instance, struct servo_config *config,
                          struct actuator_why *why)
{
    const char *text = attribute(m, instance, "seed");
    char *end = NULL;
    config->seed = 0;
    if (!text)
        return 1;
    errno = 0;
    config->seed = strtoull(text, &end, 10);
    if (*end || errno || *text == '-')
        return refuse(why, "seed: expected a whole number", text);
    return 1;
}

/* Sets the parameters, a list of names and values with spaces between them. */
static int configure_parameters(const char *list, struct servo_config *config,
                                struct actuator_why *why)
{
    static const char SPACE[] = " \t\r\n";
    char name[64], number[64];
    while (list && *(list += strspn(list, SPACE))) {
        char *const words[] = {name, number};
        for (int i = 0; i < 2; i++) {
            size_t length = strcspn(list, SPACE);
            if (length == 0 || length >= sizeof name)
                return refuse(why, "parameters: expected names and values in turn", list);
            memcpy(words[i], list, length);
            words[i][length] = 0;
            list += length;
            list += strspn(list, SPACE);
        }
        char *end = NULL;
        double value = strtod(number, &end);
        if (*end)
            return refuse(why, "parameters: expected a number", number);
        if (actuator_settings_set(&config->settings, name, value, why))
            return 0;
    }
    return 1;
}

int servo_configure(const mjModel *m, int instance, struct servo_config *config,
                    struct actuator_why *why)
{
    struct actuator_settings *settings = &config->settings;
    const char *model = attribute(m, instance, "model"), *plant = attribute(m, instance, "plant");
    const char *preset = attribute(m, instance, "preset"), *pwm = attribute(m, instance, "pwm");
    const char *board = model ? model : "board";
    if (!plant && strcmp(board, "board") == 0)
        plant = "bench";
    if (actuator_settings_init(settings, sizeof *settings, board, plant, why))
        return 0;
    if (preset && actuator_settings_apply(settings, preset, why))
        return 0;
    if (pwm && actuator_settings_set_pwm(settings, pwm, why))
        return 0;
    config->is_loaded = plant && strcmp(plant, "bench") == 0;
    if (!configure_seed(m, instance, config, why) || !configure_input(m, instance, config, why) ||
        !configure_parameters(attribute(m, instance, "parameters"), config, why))
        return 0;
    double gears = 0.0, shaft = 0.0;
    actuator_settings_get(settings, "gear_stiffness_nm_deg", &gears);
    actuator_settings_get(settings, "shaft_stiffness_nm_deg", &shaft);
    config->stiffness = 180.0 / mjPI / (1.0 / gears + 1.0 / shaft);
    return 1;
}

int servo_is(const mjModel *m, int instance)
{
    const mjpPlugin *plugin = instance < 0 ? NULL : mjp_getPluginAtSlot(m->plugin[instance]);
    return plugin && (strcmp(plugin->name, SERVO_PLUGIN) == 0 ||
                      strcmp(plugin->name, SERVO_PLUGIN_SHORT) == 0);
}

int servo_count(const mjModel *m, int instance)
{
    int count = 0;
    for (int i = 0; i < m->nactuator; i++)
        count += m->actuator_plugin[i] == instance;
    return count;
}

int servo_find(const mjModel *m, int instance, int index, struct servo_place *place,
               struct actuator_why *why)
{
    int actuator = 0;
    for (int left = index; actuator < m->nactuator; actuator++) {
        if (m->actuator_plugin[actuator] == instance && left-- == 0)
            break;
    }
    if (actuator == m->nactuator)
        return refuse(why, "an instance is one or several servos", "expected an actuator with it");
    int joint = m->actuator_trnid[2 * actuator];
    if (m->actuator_trntype[actuator] != mjTRN_JOINT || m->jnt_type[joint] != mjJNT_HINGE)
        return refuse(why, "a servo turns a hinge", "expected the transmission `joint`");
    place->control = m->actuator_ctrladr[actuator];
    place->output = m->actuator_outadr[actuator];
    place->dof = m->jnt_dofadr[joint];
    place->gear = m->actuator_gear[6 * place->output];
    if (place->gear == 0.0)
        return refuse(why, "gear", "0");
    if (m->opt.integrator == mjINT_RK4)
        return refuse(why, "integrator: expected one that evaluates each step once", "RK4");
    return 1;
}

int servo_start(const struct servo_config *config, int index, struct actuator *actuator,
                struct actuator_why *why)
{
    struct actuator_settings settings = config->settings;
    actuator_settings_set_seed(&settings, config->seed + (unsigned long long)index);
    return actuator_start(actuator, actuator_size(&settings), &settings, why) ==
           ACTUATOR_ERROR_NONE;
}
