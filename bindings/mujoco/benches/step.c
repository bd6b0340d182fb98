/*
 * The time that an actuator adds to a step of MuJoCo: servos beside <dcmotor>s with the same
 * effects, at one joint and at the six of an arm, with each integrator: step LIBRARY.
 *
 * In C, since the Python package installs a clock that takes a third of each step. The models take
 * turns, so that other load of the machine affects all alike; the least of many rounds is shown.
 */
#include <mujoco/mujoco.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { ROUNDS = 100, STEPS = 1000, JOINTS = 6, TEXT = 8000 };

/* What is compared: the plugin with its instance, if it is one, and an actuator at joint %d. */
struct candidate {
    const char *name;
    const char *plugin;
    const char *actuator;
};

#define SERVOS(plant, parameters)                                                       \
    "<extension><plugin plugin='sas'><instance name='s'><config key='plant' value='"     \
    plant "'/><config key='parameters' value='delay_s 0" parameters                      \
    "'/></instance></plugin></extension>"
#define SERVO "<plugin joint='j%d' plugin='sas' instance='s'/>"
#define RIGID " shaft_stiffness_nm_deg inf"
#define MOTOR "<dcmotor joint='j%d' motorconst='1.158' resistance='7.7' "
/* Gains, no limit of the command's rate, limits of the integrator and of the voltage. */
#define LOOPS "input='pos' controller='10 1 0.1 0 5 6' "
#define WINDING "inductance='0.001' "
/* Stiffness and damping of the bristles, Coulomb and static friction, Stribeck rate. */
#define FRICTION "lugre='1000 1 0.03 0.045 0.2' "

static const struct candidate CANDIDATES[] = {
    {"no actuator", "", ""},
    {"a plugin that is a spring",
     "<extension><plugin plugin='spr'><instance name='s'/></plugin></extension>",
     "<plugin joint='j%d' plugin='spr' instance='s'/>"},
    {"dcmotor, voltage", "", MOTOR "/>"},
    {"dcmotor, loops", "", MOTOR LOOPS "/>"},
    {"servo, first-order motor", SERVOS("first-order", ""), SERVO},
    {"dcmotor, loops, winding, friction", "", MOTOR LOOPS WINDING FRICTION "/>"},
    {"servo, bench, rigid gears",
     SERVOS("bench", RIGID " gear_stiffness_nm_deg inf backlash_deg 0"), SERVO},
    {"servo, bench, rigid shaft", SERVOS("bench", RIGID), SERVO},
    {"servo, bench", SERVOS("bench", ""), SERVO},
};
enum { COUNT = sizeof CANDIDATES / sizeof *CANDIDATES };

static double seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* A plugin without state, and with a name as short as that of the servos: what MuJoCo itself needs
 * for a plugin that moves joints. */
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
    (void)instance, (void)capability;
    for (int i = 0; i < m->nu; i++)
        d->actuator_force[i] = 1.5 * (d->ctrl[i] - d->qpos[i]) - 0.2 * d->qvel[i];
}

static void register_spring(void)
{
    mjpPlugin plugin;
    mjp_defaultPlugin(&plugin);
    plugin.name = "spr";
    plugin.capabilityflags = mjPLUGIN_ACTUATOR;
    plugin.nstate = no_state;
    plugin.reset = reset;
    plugin.compute = compute;
    mjp_registerPlugin(&plugin);
}

static void append(char *text, const char *format, int joint, const char *axis)
{
    size_t length = strlen(text);
    snprintf(text + length, TEXT - length, format, joint, axis);
}

static mjModel *compile(const struct candidate *candidate, int joints, const char *integrator)
{
    static const char *const AXES[JOINTS] = {"0 1 0", "0 0 1", "0 1 0", "1 0 0", "0 1 0", "1 0 0"};
    char text[TEXT], error[500] = "";
    snprintf(text, sizeof text, "<mujoco><option timestep='0.001' integrator='%s'/>%s<worldbody>",
             integrator, candidate->plugin);
    for (int i = 0; i < joints; i++)
        append(text,
               "<body pos='0 0 -.08'><joint name='j%d' axis='%s' armature='1e-3'/><inertial "
               "pos='0 0 -.04' mass='.05' diaginertia='3e-5 3e-5 3e-5'/>",
               i, AXES[i]);
    for (int i = 0; i < joints; i++)
        append(text, "</body>", 0, "");
    append(text, "</worldbody><actuator>", 0, "");
    for (int i = 0; i < joints; i++)
        append(text, candidate->actuator, i, "");
    append(text, "</actuator></mujoco>", 0, "");
    mjSpec *spec = mj_parseXMLString(text, NULL, error, sizeof error);
    mjModel *m = spec ? mj_compile(spec, NULL) : NULL;
    if (!m) {
        fprintf(stderr, "%s: %s %s\n", candidate->name, error, spec ? mjs_getError(spec) : "");
        exit(1);
    }
    mj_deleteSpec(spec);
    return m;
}

static void compare(int joints, const char *integrator)
{
    mjModel *models[COUNT];
    mjData *data[COUNT];
    double least[COUNT];
    for (int i = 0; i < COUNT; i++) {
        models[i] = compile(CANDIDATES + i, joints, integrator);
        data[i] = mj_makeData(models[i]);
        least[i] = 1e9;
    }
    for (int round = 0; round < ROUNDS; round++) {
        for (int i = 0; i < COUNT; i++) {
            for (int u = 0; u < models[i]->nu; u++)
                data[i]->ctrl[u] = round % 2 ? 0.5 : -0.5;
            double start = seconds();
            for (int step = 0; step < STEPS; step++)
                mj_step(models[i], data[i]);
            least[i] = mju_min(least[i], (seconds() - start) / STEPS);
        }
    }
    printf("\n%s, joints: %d, ns a step: %.0f; each actuator adds\n", integrator, joints,
           1e9 * least[0]);
    for (int i = 0; i < COUNT; i++) {
        if (i > 0)
            printf("%-36s %6.0f\n", CANDIDATES[i].name, 1e9 * (least[i] - least[0]) / joints);
        mj_deleteData(data[i]);
        mj_deleteModel(models[i]);
    }
}

int main(int count, char **arguments)
{
    if (count != 2)
        return 2;
    mj_loadPluginLibrary(arguments[1]);
    register_spring();
    for (int joints = 1; joints <= JOINTS; joints += JOINTS - 1) {
        compare(joints, "Euler");
        compare(joints, "implicitfast");
    }
    return 0;
}
