/* Every misuse by a caller returns the error code that the header documents. */
#include "actuator.h"
#include "expect.h"

#include <math.h>
#include <string.h>

#define EXPECT_ERROR(name, call) EXPECT((call) == ACTUATOR_ERROR_##name)

static struct actuator actuator;
static struct actuator_settings settings;
static struct actuator_why why;

static void memory_that_holds_nothing(void)
{
    struct actuator_parameter parameter;
    struct actuator_preset preset;
    struct actuator_reading reading;
    double value;

    EXPECT_ERROR(NOT_READY, actuator_settings_set(&settings, "P", 1.0, &why));
    EXPECT(strlen(why.text) > 0);
    EXPECT_ERROR(NOT_READY, actuator_settings_get(&settings, "P", &value));
    EXPECT_ERROR(NOT_READY, actuator_settings_apply(&settings, "consistent", NULL));
    EXPECT_ERROR(NOT_READY, actuator_settings_set_pwm(&settings, "switched", NULL));
    EXPECT_ERROR(NOT_READY, actuator_settings_set_seed(&settings, 1));
    EXPECT_ERROR(NOT_READY, actuator_settings_parameter(&settings, 0, &parameter));
    EXPECT_ERROR(NOT_READY, actuator_settings_preset(&settings, 0, &preset));
    EXPECT_ERROR(NOT_READY, actuator_start(&actuator, sizeof actuator, &settings, NULL));
    EXPECT_ERROR(NOT_READY, actuator_advance(&actuator, 0.0, 1));
    EXPECT_ERROR(NOT_READY, actuator_advance_to(&actuator, 0.0, 1.0));
    EXPECT_ERROR(NOT_READY, actuator_drive(&actuator, ACTUATOR_INPUT_RATE, 0.0, 1));
    EXPECT_ERROR(NOT_READY, actuator_drive_to(&actuator, ACTUATOR_INPUT_RATE, 0.0, 1.0));
    EXPECT_ERROR(NOT_READY, actuator_set_load_inertia(&actuator, 0.0));
    EXPECT_ERROR(NOT_READY, actuator_push_load(&actuator, 0.0, 0.0));
    EXPECT_ERROR(NOT_READY, actuator_drive_watched(&actuator, 0, 0.0, 1, NULL, NULL));
    EXPECT(actuator_size(&settings) == 0);
    EXPECT_ERROR(NOT_READY, actuator_set_load_nm(&actuator, 0.0));
    EXPECT_ERROR(NOT_READY, actuator_read(&actuator, &reading));
    /* Settings and arbitrary bytes are not accepted as an actuator. */
    memset(&actuator, 0xff, sizeof actuator);
    EXPECT_ERROR(NOT_READY, actuator_read(&actuator, &reading));
}

static void pointers(void)
{
    size_t size = sizeof settings;
    void *odd = (char *)&actuator + 1;

    EXPECT_ERROR(POINTER, actuator_settings_init(NULL, size, "board", NULL, &why));
    EXPECT_ERROR(POINTER, actuator_settings_init(&settings, size, NULL, NULL, &why));
    EXPECT_ERROR(SIZE, actuator_settings_init(&settings, size - 8, "board", NULL, &why));
    EXPECT_ERROR(NONE, actuator_settings_init(&settings, size, "board", NULL, &why));
    EXPECT(strlen(why.text) == 0);
    EXPECT_ERROR(POINTER, actuator_settings_set(NULL, "P", 1.0, NULL));
    EXPECT_ERROR(POINTER, actuator_settings_set(&settings, NULL, 1.0, NULL));
    EXPECT_ERROR(POINTER, actuator_settings_get(&settings, "P", NULL));
    EXPECT_ERROR(POINTER, actuator_settings_apply(&settings, NULL, NULL));
    EXPECT_ERROR(POINTER, actuator_settings_set_pwm(&settings, NULL, NULL));
    EXPECT_ERROR(POINTER, actuator_settings_set_seed(NULL, 0));
    EXPECT_ERROR(POINTER, actuator_settings_parameter(&settings, 0, NULL));
    EXPECT_ERROR(POINTER, actuator_settings_preset(&settings, 0, NULL));
    EXPECT_ERROR(POINTER, actuator_start(NULL, sizeof actuator, &settings, NULL));
    EXPECT_ERROR(POINTER, actuator_start(odd, sizeof actuator, &settings, NULL));
    EXPECT_ERROR(POINTER, actuator_start(&actuator, sizeof actuator, NULL, NULL));
    EXPECT_ERROR(SIZE, actuator_start(&actuator, 8, &settings, NULL));
    EXPECT_ERROR(SIZE, actuator_start(&actuator, actuator_size(&settings) - 1, &settings, NULL));
    EXPECT_ERROR(POINTER, actuator_drive(NULL, ACTUATOR_INPUT_DUTY, 0.0, 1));
    EXPECT_ERROR(POINTER, actuator_drive_watched(NULL, ACTUATOR_INPUT_DUTY, 0.0, 1, NULL, NULL));
    EXPECT_ERROR(POINTER, actuator_drive_to(NULL, ACTUATOR_INPUT_DUTY, 0.0, 1.0));
    EXPECT_ERROR(POINTER, actuator_set_load_inertia(NULL, 0.0));
    EXPECT_ERROR(POINTER, actuator_push_load(NULL, 0.0, 0.0));
    EXPECT_ERROR(POINTER, actuator_read_load(NULL, NULL));
    EXPECT(actuator_size(NULL) == 0);
    EXPECT_ERROR(POINTER, actuator_advance(NULL, 0.0, 1));
    EXPECT_ERROR(POINTER, actuator_advance_to(NULL, 0.0, 1.0));
    EXPECT_ERROR(POINTER, actuator_set_load_nm(NULL, 0.0));
    EXPECT_ERROR(POINTER, actuator_read(NULL, NULL));
    EXPECT_ERROR(POINTER, actuator_read(odd, NULL));
}

static void names_and_values(void)
{
    double value = 0.0;
    char endless[1000];

    EXPECT_ERROR(NAME, actuator_settings_init(&settings, sizeof settings, "bord", NULL, &why));
    EXPECT(strstr(why.text, "`bord`") != NULL);
    EXPECT_ERROR(NOT_READY, actuator_settings_set_seed(&settings, 0));
    EXPECT_ERROR(NAME, actuator_settings_init(&settings, sizeof settings, "board", "desk", &why));
    EXPECT_ERROR(NONE, actuator_settings_init(&settings, sizeof settings, "board", NULL, &why));
    EXPECT_ERROR(NAME, actuator_settings_set(&settings, "pole", 30.0, &why));
    EXPECT(strstr(why.text, "`pole`") != NULL);
    EXPECT_ERROR(NAME, actuator_settings_set(&settings, "", 30.0, &why));
    EXPECT_ERROR(NAME, actuator_settings_set(&settings, "\xff\xfe", 30.0, &why));
    memset(endless, 'x', sizeof endless);
    endless[sizeof endless - 1] = 0;
    EXPECT_ERROR(NAME, actuator_settings_set(&settings, endless, 30.0, &why));
    EXPECT(strlen(why.text) == ACTUATOR_WHY_SIZE - 1);
    EXPECT_ERROR(NAME, actuator_settings_get(&settings, "pole", &value));
    EXPECT_ERROR(NAME, actuator_settings_apply(&settings, "as-printed", &why));
    EXPECT_ERROR(NAME, actuator_settings_set_pwm(&settings, "sometimes", &why));
    EXPECT_ERROR(NONE, actuator_settings_set(&settings, "P", 16.0, &why));
    EXPECT_ERROR(PARAMETER, actuator_settings_set(&settings, "P", NAN, &why));
    EXPECT(strstr(why.text, "position_gain is NaN") != NULL);
    EXPECT_ERROR(PARAMETER, actuator_settings_set(&settings, "P", -HUGE_VAL, NULL));
    EXPECT_ERROR(NONE, actuator_settings_get(&settings, "position_gain", &value));
    EXPECT(value == 16.0);
}

static void time_and_commands(void)
{
    struct actuator_reading before, after;

    EXPECT_ERROR(NONE, actuator_start(&actuator, sizeof actuator, &settings, &why));
    EXPECT_ERROR(NONE, actuator_advance_to(&actuator, 10.0, 1.0 / 120.0));
    EXPECT_ERROR(NONE, actuator_read(&actuator, &before));
    EXPECT(before.tick == 167);
    EXPECT_ERROR(COMMAND, actuator_advance(&actuator, NAN, 1));
    EXPECT_ERROR(COMMAND, actuator_advance_to(&actuator, HUGE_VAL, 1.0));
    EXPECT_ERROR(COMMAND, actuator_set_load_nm(&actuator, -HUGE_VAL));
    EXPECT_ERROR(COMMAND, actuator_set_load_inertia(&actuator, -1.0));
    EXPECT_ERROR(COMMAND, actuator_push_load(&actuator, NAN, 0.0));
    EXPECT_ERROR(COMMAND, actuator_drive(&actuator, ACTUATOR_INPUT_DUTY, NAN, 1));
    EXPECT_ERROR(INPUT, actuator_drive(&actuator, ACTUATOR_INPUT_VOLTAGE, 1.0, 1));
    EXPECT_ERROR(INPUT, actuator_drive(&actuator, 4, 1.0, 1));
    EXPECT_ERROR(INPUT, actuator_drive(&actuator, -1, 1.0, 1));
    EXPECT_ERROR(TIME, actuator_advance(&actuator, 0.0, UINT64_MAX));
    EXPECT_ERROR(TIME, actuator_drive_watched(&actuator, 0, 0.0, UINT64_MAX, NULL, NULL));
    EXPECT_ERROR(COMMAND, actuator_drive_watched(&actuator, 0, NAN, 1, NULL, NULL));
    EXPECT_ERROR(INPUT, actuator_drive_watched(&actuator, 4, 0.0, 1, NULL, NULL));
    EXPECT_ERROR(TIME, actuator_advance_to(&actuator, 0.0, NAN));
    EXPECT_ERROR(TIME, actuator_advance_to(&actuator, 0.0, -1.0));
    EXPECT_ERROR(TIME, actuator_advance_to(&actuator, 0.0, 0.0));
    EXPECT_ERROR(TIME, actuator_advance_to(&actuator, 0.0, HUGE_VAL));
    EXPECT_ERROR(NONE, actuator_read(&actuator, &after));
    EXPECT(memcmp(&before, &after, sizeof before) == 0);
    /* After a failed initialisation there is no valid actuator. */
    EXPECT_ERROR(POINTER, actuator_start(&actuator, sizeof actuator, NULL, NULL));
    EXPECT_ERROR(NOT_READY, actuator_advance(&actuator, 0.0, 1));
}

static void long_delays(void)
{
    static uint64_t memory[20000 + ACTUATOR_WORDS];
    struct actuator *delayed = (struct actuator *)memory;
    struct actuator_reading reading;

    EXPECT(actuator_size(&settings) <= sizeof actuator);
    EXPECT_ERROR(NONE, actuator_settings_set(&settings, "delay_s", 1.0, &why));
    EXPECT(actuator_size(&settings) > 20000 * 8 && actuator_size(&settings) <= sizeof memory);
    EXPECT_ERROR(SIZE, actuator_start(&actuator, sizeof actuator, &settings, &why));
    EXPECT_ERROR(NOT_READY, actuator_advance(&actuator, 0.0, 1));
    EXPECT_ERROR(NONE, actuator_start(delayed, sizeof memory, &settings, &why));
    EXPECT_ERROR(NONE, actuator_advance(delayed, 0.0, 1));
    EXPECT_ERROR(NONE, actuator_advance(delayed, 10.0, 20000));
    EXPECT_ERROR(NONE, actuator_read(delayed, &reading));
    EXPECT(reading.command_deg == 0.0);
    EXPECT_ERROR(NONE, actuator_advance(delayed, 10.0, 1));
    EXPECT_ERROR(NONE, actuator_read(delayed, &reading));
    EXPECT(reading.command_deg == 10.0);
}

/* The angle after half a second at a command, deg. */
static double angle_at(struct actuator *servo, double command_deg)
{
    struct actuator_reading reading = {0};

    EXPECT_ERROR(NONE, actuator_advance(servo, command_deg, 10000));
    EXPECT_ERROR(NONE, actuator_read(servo, &reading));
    return reading.angle_deg;
}

static void states(const char *plant, double delay_s)
{
    static uint64_t memory[ACTUATOR_STATE_WORDS + 400], before[ACTUATOR_STATE_WORDS + 400];
    struct actuator_state *state = (struct actuator_state *)memory;
    struct actuator_load load, other;
    double time_s, angle;
    size_t size;

    memset(memory, 0, sizeof memory);
    EXPECT_ERROR(NONE, actuator_settings_init(&settings, sizeof settings, "board", plant, &why));
    EXPECT_ERROR(NONE, actuator_settings_set(&settings, "delay_s", delay_s, &why));
    size = actuator_state_size(&settings);
    EXPECT(size <= sizeof memory && size < actuator_size(&settings));
    EXPECT(delay_s > 0.0 || size <= sizeof *state);
    EXPECT_ERROR(NONE, actuator_start(&actuator, sizeof actuator, &settings, &why));
    EXPECT_ERROR(NOT_READY, actuator_restore(&actuator, state));
    EXPECT_ERROR(POINTER, actuator_save(&actuator, NULL, size));
    EXPECT_ERROR(SIZE, actuator_save(&actuator, state, size - 1));
    angle_at(&actuator, 30.0);
    EXPECT_ERROR(NONE, actuator_save(&actuator, state, size));
    memcpy(before, memory, sizeof memory);
    angle = angle_at(&actuator, -20.0);
    EXPECT_ERROR(NONE, actuator_restore(&actuator, state));
    EXPECT(angle_at(&actuator, -20.0) == angle);
    /* Over what is there, with the same state as before. */
    EXPECT_ERROR(NONE, actuator_save(&actuator, state, size));
    EXPECT_ERROR(NONE, actuator_restore(&actuator, (struct actuator_state *)before));
    EXPECT(angle_at(&actuator, -20.0) == angle);

    for (time_s = 1.001; time_s < 1.1; time_s += 0.001) {
        EXPECT_ERROR(NONE, actuator_drive_from(&actuator, state, 0, 45.0, time_s, &load));
        EXPECT_ERROR(NONE, actuator_restore(&actuator, state));
        EXPECT_ERROR(NONE, actuator_drive_to(&actuator, 0, 45.0, time_s));
        EXPECT_ERROR(NONE, actuator_read_load(&actuator, &other));
        EXPECT(load.angle_deg == other.angle_deg && load.rate_deg_s == other.rate_deg_s);
        EXPECT(load.shaft_torque_nm == other.shaft_torque_nm);
        EXPECT_ERROR(NONE, actuator_save(&actuator, state, size));
    }
    EXPECT_ERROR(TIME, actuator_drive_from(&actuator, state, 0, 45.0, 0.0, &load));
    EXPECT_ERROR(TIME, actuator_drive_from(&actuator, state, 0, 45.0, 1e9, &load));
    EXPECT_ERROR(TIME, actuator_drive_load_to(&actuator, 0, 45.0, NAN, &load));
    EXPECT_ERROR(COMMAND, actuator_drive_from(&actuator, state, 0, NAN, 2.0, &load));
    EXPECT_ERROR(INPUT, actuator_drive_from(&actuator, state, 9, 1.0, 2.0, &load));
    EXPECT_ERROR(POINTER, actuator_drive_from(&actuator, state, 0, 1.0, 2.0, NULL));
    EXPECT_ERROR(POINTER, actuator_drive_load_to(&actuator, 0, 1.0, 2.0, NULL));

    EXPECT_ERROR(NONE, actuator_settings_init(&settings, sizeof settings, "grey-box", NULL, &why));
    EXPECT_ERROR(NONE, actuator_start(&actuator, sizeof actuator, &settings, &why));
    EXPECT_ERROR(STATE, actuator_restore(&actuator, state));
}

static void lists(void)
{
    struct actuator_parameter parameter;
    struct actuator_preset preset;
    size_t parameters = 0, presets = 0;

    while (actuator_settings_parameter(&settings, parameters, &parameter) == ACTUATOR_ERROR_NONE) {
        EXPECT(parameter.min <= parameter.default_value);
        EXPECT(parameter.default_value <= parameter.max);
        EXPECT(strlen(parameter.meaning) > 0);
        parameters++;
    }
    while (actuator_settings_preset(&settings, presets, &preset) == ACTUATOR_ERROR_NONE)
        presets++;
    EXPECT(parameters > 20);
    EXPECT(presets > 3);
    EXPECT_ERROR(NAME, actuator_settings_parameter(&settings, SIZE_MAX, &parameter));
    EXPECT_ERROR(NAME, actuator_settings_preset(&settings, SIZE_MAX, &preset));
}

int main(void)
{
    for (int code = -1; code <= 11; code++)
        EXPECT(strlen(actuator_error_text(code)) > 0);
    EXPECT(strcmp(actuator_error_text(INT32_MIN), "unknown error") == 0);
    memory_that_holds_nothing();
    pointers();
    names_and_values();
    time_and_commands();
    long_delays();
    lists();
    states("first-order", 0.0);
    states("bench", 0.0);
    states("first-order", 0.0175);
    return failures != 0;
}
