/*
 * The time of a step of MuJoCo with a servo, a <dcmotor>, a plugin with a constant force, or no
 * actuator at a joint, all with the same options: step LIBRARY.
 *
 * In C, since the Python package installs a clock that takes a third of each step. The models take
 * turns, so that other load of the machine affects all alike; the least of many rounds is shown.
 */
#include <mujoco/mujoco.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { ROUNDS = 200, STEPS = 1000, MOST = 16 };

struct candidate {
    const char *name;
    const char *plugin;
    const char *actuator;
};

#define SERVO(config)                                                                   \
    "<extension><plugin plugin='smart_actuator.servo'><instance name='s'>"               \
    "<config key='parameters' value='delay_s 0" config "'/></instance></plugin></extension>"
#define MODEL(model, config)                                                            \
    "<extension><plugin plugin='smart_actuator.servo'><instance name='s'>"               \
    "<config key='model' value='board'/><config key='plant' value='" model "'/>"         \
    "<config key='parameters' value='delay_s 0" config "'/></instance></plugin></extension>"
#define PLUGIN "<plugin joint='j' plugin='smart_actuator.servo' instance='s'/>"
#define MOTOR "<dcmotor joint='j' motorconst='1.158' resistance='7.7' "

static const struct candidate CANDIDATES[] = {
    {"no actuator", "", ""},
    {"dcmotor, voltage", "", MOTOR "/>"},
    {"dcmotor, position and rate loop", "", MOTOR "input='pos' controller='10 1 0.1'/>"},
    {"dcmotor, loops, winding, cogging", "",
     MOTOR "input='pos' controller='10 1 0.1' inductance='0.001' cogging='0.01 6 0'/>"},
    {"plugin with a constant force",
     "<extension><plugin plugin='constant'><instance name='s'/></plugin></extension>",
     "<plugin joint='j' plugin='constant' instance='s'/>"},
    {"servo, first-order motor", MODEL("first-order", ""), PLUGIN},
    {"servo, bench, rigid shaft", MODEL("bench", " shaft_stiffness_nm_deg inf"), PLUGIN},
    {"servo, bench", MODEL("bench", ""), PLUGIN},
};
enum { COUNT = sizeof CANDIDATES / sizeof *CANDIDATES };

static double seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* A plugin without state: what MuJoCo itself needs for any plugin that moves a joint. */
static int no_state(const mjModel *m, int instance)
{
    (void)m, (void)instance;
    return 0;
}

static void reset(const mjModel *m, mjtNum *state, void *data, int instance)
{
    (void)m, (void)state, (void)data, (void)instance;
}

static void compute(const mjModel *m, mjData *d, int instance, int capability)
{
    (void)m, (void)instance, (void)capability;
    d->actuator_force[0] = 0.1;
}

static void register_constant(void)
{
    mjpPlugin plugin;
    mjp_defaultPlugin(&plugin);
    plugin.name = "constant";
    plugin.capabilityflags = mjPLUGIN_ACTUATOR;
    plugin.nstate = no_state;
    plugin.reset = reset;
    plugin.compute = compute;
    mjp_registerPlugin(&plugin);
}

static mjModel *compile(const struct candidate *candidate)
{
    char text[2000], error[500] = "";
    snprintf(text, sizeof text,
             "<mujoco><option timestep='0.001'/>%s<worldbody><body><joint name='j' axis='0 1 0'/>"
             "<inertial pos='0 0 -.05' mass='.1' diaginertia='1e-3 1e-3 1e-3'/></body></worldbody>"
             "<actuator>%s</actuator></mujoco>",
             candidate->plugin, candidate->actuator);
    mjSpec *spec = mj_parseXMLString(text, NULL, error, sizeof error);
    mjModel *m = spec ? mj_compile(spec, NULL) : NULL;
    if (!m) {
        fprintf(stderr, "%s: %s %s\n", candidate->name, error, spec ? mjs_getError(spec) : "");
        exit(1);
    }
    mj_deleteSpec(spec);
    return m;
}

int main(int count, char **arguments)
{
    mjModel *models[COUNT];
    mjData *data[COUNT];
    double least[COUNT];
    if (count != 2)
        return 2;
    mj_loadPluginLibrary(arguments[1]);
    register_constant();
    for (int i = 0; i < COUNT; i++) {
        models[i] = compile(CANDIDATES + i);
        data[i] = mj_makeData(models[i]);
        least[i] = 1e9;
    }
    for (int round = 0; round < ROUNDS; round++) {
        for (int i = 0; i < COUNT; i++) {
            if (models[i]->nu)
                data[i]->ctrl[0] = round % 2 ? 0.5 : -0.5;
            double start = seconds();
            for (int step = 0; step < STEPS; step++)
                mj_step(models[i], data[i]);
            least[i] = mju_min(least[i], (seconds() - start) / STEPS);
        }
    }
    for (int i = 0; i < COUNT; i++)
        printf("%-34s %6.0f ns, of it the actuator %6.0f ns\n", CANDIDATES[i].name, 1e9 * least[i],
               1e9 * (least[i] - least[0]));
    return 0;
}
