/*
 * Prints the trace of an actuator, the bits of each number in hexadecimal.
 *
 * Usage: trace MODEL PLANT PRESET PWM SEED < steps
 * Each step is a line `input value ticks load_nm inertia_kg_m2`, the input a number of
 * `enum actuator_input`. After half of the steps the state is saved,
 * changed by other steps, and restored.
 */
#include "actuator.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void check(enum actuator_error error, const char *what)
{
    if (error != ACTUATOR_ERROR_NONE) {
        fprintf(stderr, "%s: %s\n", what, actuator_error_text(error));
        exit(1);
    }
}

static void print(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    printf(" %016" PRIx64, bits);
}

static void show(const struct actuator *actuator)
{
    struct actuator_reading r;
    struct actuator_load load;
    check(actuator_read(actuator, &r), "read");
    printf("%" PRIu64, r.tick);
    print(r.command_deg);
    print(r.angle_deg);
    print(r.rate_deg_s);
    print(r.duty_pct);
    print(r.angle_meas_deg);
    print(r.rate_meas_deg_s);
    print(r.current_a);
    print(r.back_emf_v);
    check(actuator_read_load(actuator, &load), "load");
    print(load.angle_deg);
    print(load.rate_deg_s);
    print(load.shaft_torque_nm);
    putchar('\n');
}

static void go_astray_and_back(struct actuator *actuator)
{
    static struct actuator kept; /* the delay is the default one */
    memcpy(&kept, actuator, sizeof kept);
    check(actuator_advance(actuator, -123.0, 4321), "astray");
    memcpy(actuator, &kept, sizeof kept);
}

int main(int argc, char **argv)
{
    static struct actuator actuator;
    struct actuator_settings settings;
    struct actuator_why why;
    double value, load_nm, inertia_kg_m2;
    int input;
    uint64_t ticks;
    int steps = 0;

    if (argc != 6 || actuator_abi_version() != ACTUATOR_ABI_VERSION)
        return 2;
    /* "-" is a model without a plant. */
    const char *plant = strcmp(argv[2], "-") == 0 ? NULL : argv[2];
    check(actuator_settings_init(&settings, sizeof settings, argv[1], plant, &why), why.text);
    check(actuator_settings_apply(&settings, argv[3], &why), why.text);
    check(actuator_settings_set_pwm(&settings, argv[4], &why), why.text);
    check(actuator_settings_set_seed(&settings, strtoull(argv[5], NULL, 10)), "seed");
    if (actuator_size(&settings) > sizeof actuator)
        return 3;
    check(actuator_start(&actuator, sizeof actuator, &settings, &why), why.text);
    show(&actuator);
    while (scanf("%d %lf %" SCNu64 " %lf %lf", &input, &value, &ticks, &load_nm, &inertia_kg_m2) == 5) {
        if (++steps == 20)
            go_astray_and_back(&actuator);
        check(actuator_set_load_nm(&actuator, load_nm), "load");
        check(actuator_set_load_inertia(&actuator, inertia_kg_m2), "inertia");
        check(actuator_push_load(&actuator, 1e-3 * value, 1e-4 * load_nm), "push");
        check(actuator_drive(&actuator, input, value, ticks), "drive");
        show(&actuator);
    }
    return 0;
}
