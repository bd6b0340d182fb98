/*
 * The smart actuator: the board's own control core and its models, stepped by the caller.
 *
 * Angles are in deg, rates in deg/s, times in s or in ticks of 50 us, torques in Nm, duties in %.
 * The library has no heap, no thread and no global state: all memory is the caller's.
 *
 * Every pointer must be null, or point to a whole object of its type, an actuator with a long delay
 * to all of its memory; texts end in a zero. Memory that is given to another function than
 * actuator_settings_init or actuator_start must be zeroed or filled by one of these two, that of a
 * state zeroed or filled by actuator_save. Null, misaligned pointers, zeroed memory, NaN and unknown
 * names give an error code. `why` may be null; otherwise it is always written.
 *
 * Different actuators may be used by different threads at once; one actuator by one at a time.
 * Snapshots are valid for the same build of the library.
 */

#ifndef ACTUATOR_H
#define ACTUATOR_H

/* Made from the Rust source by a test of bindings/c; do not edit. */

#include <stddef.h>
#include <stdint.h>

/**
 * Size of a sentence with the longest name, a value, its range and unit (at most 150 bytes: a
 * number usually has at most 24 characters); longer ones are truncated.
 */
#define ACTUATOR_WHY_SIZE 192

/**
 * Words of 8 bytes in `struct actuator_settings`: 824 bytes and room to grow.
 */
#define ACTUATOR_SETTINGS_WORDS 128

/**
 * Version of this interface: it changes with the layout or the meaning of anything in the header.
 */
#define ACTUATOR_ABI_VERSION 2

/**
 * Ticks in one second: a tick is 50 us.
 */
#define ACTUATOR_TICKS_PER_SECOND 20000

/**
 * The longest single step, ticks: an hour, which a PC computes in two minutes at most. A longer
 * step is refused, since it is most likely a wrong unit or an uninitialised time.
 */
#define ACTUATOR_LONGEST_STEP_TICKS 72000000

/**
 * The ticks between two calls of an `actuator_watch`: 0.1 s of the simulation, which a PC computes
 * in 4 ms at most.
 */
#define ACTUATOR_WATCH_TICKS 2000

/**
 * Words of 8 bytes in `struct actuator`.
 */
#define ACTUATOR_WORDS 800

/**
 * Size of `struct actuator`, bytes: sufficient for delays of up to 20 ms.
 */
#define ACTUATOR_SIZE 6400

/**
 * Alignment of `struct actuator` and `struct actuator_settings`, bytes, sufficient on every
 * target.
 */
#define ACTUATOR_ALIGNMENT 8

/**
 * Words of 8 bytes in `struct actuator_state`.
 */
#define ACTUATOR_STATE_WORDS 64

/**
 * The result of a call. Only `ACTUATOR_ERROR_NONE` is 0; a call with any other changes nothing,
 * unless the function states it.
 */
enum actuator_error {
  /**
   * Done.
   */
  ACTUATOR_ERROR_NONE = 0,
  /**
   * A pointer is null or misaligned.
   */
  ACTUATOR_ERROR_POINTER = 1,
  /**
   * A size is not that of this library, or the memory is smaller than an actuator with this
   * delay needs: `actuator_size` returns what it needs.
   */
  ACTUATOR_ERROR_SIZE = 2,
  /**
   * The memory does not hold initialised settings or a started actuator.
   */
  ACTUATOR_ERROR_NOT_READY = 3,
  /**
   * The name or the index does not exist.
   */
  ACTUATOR_ERROR_NAME = 4,
  /**
   * A parameter is NaN, out of its range, or in conflict with another one.
   */
  ACTUATOR_ERROR_PARAMETER = 5,
  /**
   * A command, a torque, an inertia or a motion is NaN, or out of its range.
   */
  ACTUATOR_ERROR_COMMAND = 6,
  /**
   * A time is NaN or in the past, or the step to it is longer than an hour.
   */
  ACTUATOR_ERROR_TIME = 7,
  /**
   * The model does not have this input.
   */
  ACTUATOR_ERROR_INPUT = 8,
  /**
   * The caller's `actuator_watch` has ended the step; the part of it that was done remains.
   */
  ACTUATOR_ERROR_INTERRUPTED = 9,
  /**
   * The state is that of an actuator with another model or delay.
   */
  ACTUATOR_ERROR_STATE = 10,
};

/**
 * The quantity that an actuator is commanded in.
 */
enum actuator_input {
  /**
   * Angle of the output shaft, deg: both loops are closed.
   */
  ACTUATOR_INPUT_POSITION = 0,
  /**
   * Rate of the output shaft, deg/s: the rate loop alone is closed.
   */
  ACTUATOR_INPUT_RATE = 1,
  /**
   * Duty of the bridge, %: no loop is closed.
   */
  ACTUATOR_INPUT_DUTY = 2,
  /**
   * Voltage at the motor's terminals, V; of the bench only.
   */
  ACTUATOR_INPUT_VOLTAGE = 3,
};

/**
 * A model, its plant and the values of their parameters. Opaque; it may be copied by assignment.
 */
struct actuator_settings {
  /**
   * Private to the library.
   */
  uint64_t opaque[ACTUATOR_SETTINGS_WORDS];
};

/**
 * The reason of a failure, as a sentence with the parameter and its range.
 */
struct actuator_why {
  /**
   * The sentence, terminated by a zero; empty on success.
   */
  char text[ACTUATOR_WHY_SIZE];
};

/**
 * A row of the parameter table, and the present value.
 */
struct actuator_parameter {
  /**
   * Present value, in its unit.
   */
  double value;
  /**
   * Default value, in its unit.
   */
  double default_value;
  /**
   * Least allowed value, in its unit.
   */
  double min;
  /**
   * Greatest allowed value, in its unit; infinite without a bound.
   */
  double max;
  /**
   * Its name.
   */
  char name[32];
  /**
   * The symbol of the paper; empty if it has none.
   */
  char symbol[16];
  /**
   * Its unit.
   */
  char unit[16];
  /**
   * Its meaning, in a sentence.
   */
  char meaning[192];
  /**
   * The source of the default.
   */
  char source[128];
};

/**
 * A named interpretation of the paper's numbers.
 */
struct actuator_preset {
  /**
   * Its name.
   */
  char name[32];
  /**
   * Its purpose, in a sentence.
   */
  char summary[192];
  /**
   * The warning that must accompany its results; empty for most.
   */
  char warning[128];
};

/**
 * An actuator with all of its state. Opaque. It contains no pointers: a copy by assignment or
 * memcpy is a snapshot, and copying it back restores it.
 *
 * An actuator with a longer delay is in a larger piece of memory, of which this struct is the
 * start: `actuator_size` returns the bytes that it needs, and a snapshot is a copy of them all.
 */
struct actuator {
  /**
   * Private to the library.
   */
  uint64_t opaque[ACTUATOR_WORDS];
};

/**
 * Angle and rate of the load: of the last body of the bench, which moves against the output within
 * the flexibility of the shaft, and of the output of the other models.
 */
struct actuator_load {
  /**
   * Angle, deg.
   */
  double angle_deg;
  /**
   * Rate, deg/s.
   */
  double rate_deg_s;
  /**
   * Torque of the shaft on the load, Nm; of the bench only.
   */
  double shaft_torque_nm;
};

/**
 * Is called during a long step with the caller's `data`, the ticks that are done and the ticks of
 * the whole step; returns 0 to end the step, any other number to continue.
 *
 * It may call every function of the library, for this actuator those that read it, or copy the
 * actuator. It must return: no C++ exception and no longjmp may leave it.
 */
typedef int32_t (*actuator_watch)(void *data, uint64_t done, uint64_t total);

/**
 * The outputs of an actuator. A quantity that the model does not have is zero; one that it does
 * not measure is the true value.
 */
struct actuator_reading {
  /**
   * Ticks of 50 us since the start.
   */
  uint64_t tick;
  /**
   * The command after the transport delay, deg.
   */
  double command_deg;
  /**
   * Angle of the output shaft, deg.
   */
  double angle_deg;
  /**
   * Its rate, deg/s.
   */
  double rate_deg_s;
  /**
   * Duty of the bridge, %.
   */
  double duty_pct;
  /**
   * Measured angle, deg.
   */
  double angle_meas_deg;
  /**
   * Measured rate, deg/s.
   */
  double rate_meas_deg_s;
  /**
   * Motor current, A; of the bench only.
   */
  double current_a;
  /**
   * Back-EMF, V; of the bench only.
   */
  double back_emf_v;
};

/**
 * The state of an actuator without its parameters: a third of `struct actuator` without a delay.
 * Opaque; it contains no pointers and may be copied as bytes.
 *
 * The commands in transit are behind it in a larger piece of memory, of which this struct is the
 * start: `actuator_state_size` returns the bytes of both.
 */
struct actuator_state {
  /**
   * Private to the library.
   */
  uint64_t opaque[ACTUATOR_STATE_WORDS];
};

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * The text of a code, in English; any number is accepted. The text is constant.
 */
const char *actuator_error_text(int32_t code);

/**
 * Fills `settings` with the defaults of a model. Previous content is overwritten; on failure the
 * settings are not ready.
 *
 * `size` is `sizeof *settings`. `model` is `black-box-1`, `black-box-2`, `grey-box` or `board`.
 * `plant` is the plant of the board, `first-order` or `bench`; null is `first-order` for the
 * board, and the only value that other models take.
 */
enum actuator_error actuator_settings_init(struct actuator_settings *settings,
                                           size_t size,
                                           const char *model,
                                           const char *plant,
                                           struct actuator_why *why);

/**
 * Sets a parameter of the model and plant, by name or symbol, in its unit.
 */
enum actuator_error actuator_settings_set(struct actuator_settings *settings,
                                          const char *name,
                                          double value,
                                          struct actuator_why *why);

/**
 * The present value of a parameter, by name or symbol, in its unit.
 */
enum actuator_error actuator_settings_get(const struct actuator_settings *settings,
                                          const char *name,
                                          double *value);

/**
 * Applies a preset of the model by name: it sets some parameters and keeps the others.
 */
enum actuator_error actuator_settings_apply(struct actuator_settings *settings,
                                            const char *preset,
                                            struct actuator_why *why);

/**
 * Sets how the bridge of the board is switched: `average` (the default) or
 * `switched`.
 */
enum actuator_error actuator_settings_set_pwm(struct actuator_settings *settings,
                                              const char *pwm,
                                              struct actuator_why *why);

/**
 * Sets the seed of the random numbers; the default is 0.
 */
enum actuator_error actuator_settings_set_seed(struct actuator_settings *settings, uint64_t seed);

/**
 * Parameter number `index` of the model and plant; `ACTUATOR_ERROR_NAME` beyond the last.
 */
enum actuator_error actuator_settings_parameter(const struct actuator_settings *settings,
                                                size_t index,
                                                struct actuator_parameter *parameter);

/**
 * Preset number `index` of the model; `ACTUATOR_ERROR_NAME` beyond the last. Number 0 changes
 * nothing: it is the model without a preset.
 */
enum actuator_error actuator_settings_preset(const struct actuator_settings *settings,
                                             size_t index,
                                             struct actuator_preset *preset);

/**
 * `ACTUATOR_ABI_VERSION` of the library: compare it with that of the header.
 */
uint32_t actuator_abi_version(void);

/**
 * Bytes that an actuator with these settings needs, at most `ACTUATOR_SIZE` for delays of up to
 * 20 ms; 0 if the settings are not initialised.
 */
size_t actuator_size(const struct actuator_settings *settings);

/**
 * Initialises an actuator with these settings, at rest at 0 deg and time 0. Previous content is
 * overwritten; on failure the actuator is not ready. The settings are not referenced afterwards.
 *
 * `size` is that of the memory at `actuator`, bytes: at least `actuator_size(settings)`, for which
 * `sizeof *actuator` is sufficient with a delay of up to 20 ms. Every call needs up to 16 KiB of
 * stack.
 */
enum actuator_error actuator_start(struct actuator *actuator,
                                   size_t size,
                                   const struct actuator_settings *settings,
                                   struct actuator_why *why);

/**
 * Advances by a number of ticks of 50 us with a constant command, deg.
 *
 * The first command is also the past of the delay line: only later ones are delayed.
 */
enum actuator_error actuator_advance(struct actuator *actuator, double command_deg, uint64_t ticks);

/**
 * Advances to the tick nearest to `time_s` after the start, s, with a constant command, deg.
 *
 * For simulations whose step is not a whole number of ticks, such as 1/120 s: the absolute time
 * prevents a drift between the two.
 */
enum actuator_error actuator_advance_to(struct actuator *actuator,
                                        double command_deg,
                                        double time_s);

/**
 * Advances by a number of ticks of 50 us with a constant value of an input, one of
 * `enum actuator_input`, in its unit.
 *
 * Sampling and delay of the test set-up apply to every input. A change of the input takes effect
 * immediately: its first value is also its past.
 */
enum actuator_error actuator_drive(struct actuator *actuator,
                                   int32_t input,
                                   double value,
                                   uint64_t ticks);

/**
 * As `actuator_drive`, to the tick nearest to `time_s` after the start, s.
 */
enum actuator_error actuator_drive_to(struct actuator *actuator,
                                      int32_t input,
                                      double value,
                                      double time_s);

/**
 * As `actuator_drive_to`, then as `actuator_read_load`: the step of a simulation that moves its
 * joint as the load has moved.
 */
enum actuator_error actuator_drive_load_to(struct actuator *actuator,
                                           int32_t input,
                                           double value,
                                           double time_s,
                                           struct actuator_load *load);

/**
 * As `actuator_drive`, and calls `watch` (unless it is null) after every `ACTUATOR_WATCH_TICKS`
 * ticks and at the end, so that the caller can show the progress of a long step and interrupt it.
 *
 * If `watch` returns 0 before the end, the result is `ACTUATOR_ERROR_INTERRUPTED`: the actuator is
 * at the tick that was reached (`actuator_read`) and can be advanced further. The numbers are
 * those of `actuator_drive`, to the last bit.
 */
enum actuator_error actuator_drive_watched(struct actuator *actuator,
                                           int32_t input,
                                           double value,
                                           uint64_t ticks,
                                           actuator_watch watch,
                                           void *data);

/**
 * Applies a torque to the load, Nm, from the next tick on, in addition to the parameter.
 * Only the bench has a load; the other models accept and ignore any finite torque.
 */
enum actuator_error actuator_set_load_nm(struct actuator *actuator, double torque_nm);

/**
 * Adds an inertia to the load, kg m^2, up to 1e3, from the next tick on, in addition to the
 * parameter. Only the bench has a load.
 */
enum actuator_error actuator_set_load_inertia(struct actuator *actuator, double inertia_kg_m2);

/**
 * Moves the load by an angle, deg, and an impulse, Nm s: what another simulation has found to act
 * on it beyond the torque that was set. Only the bench has a load.
 */
enum actuator_error actuator_push_load(struct actuator *actuator,
                                       double angle_deg,
                                       double impulse_nms);

/**
 * Places the shaft at an angle, deg, before the first tick; later it has no effect. The board's
 * encoder then measures it within half a turn.
 */
enum actuator_error actuator_place(struct actuator *actuator, double angle_deg);

/**
 * Reads the motion of the load.
 */
enum actuator_error actuator_read_load(const struct actuator *actuator, struct actuator_load *load);

/**
 * Reads the outputs.
 */
enum actuator_error actuator_read(const struct actuator *actuator,
                                  struct actuator_reading *reading);

/**
 * Bytes of the state of an actuator with these settings, at most `sizeof(struct actuator_state)`
 * without a delay; 0 if the settings are not initialised.
 */
size_t actuator_state_size(const struct actuator_settings *settings);

/**
 * Saves the state of an actuator in memory of `size` bytes, at least those of
 * `actuator_state_size`, which is zeroed or holds a saved state.
 */
enum actuator_error actuator_save(const struct actuator *actuator,
                                  struct actuator_state *state,
                                  size_t size);

/**
 * Continues from a saved state of this actuator, or of another one that was started with the same
 * settings: all that follows is the same to the last bit. Less time is needed than for a copy of
 * the struct.
 */
enum actuator_error actuator_restore(struct actuator *actuator, const struct actuator_state *state);

/**
 * As `actuator_restore`, then as `actuator_drive_load_to`: the whole step of a simulation whose
 * load does not act on the actuator.
 */
enum actuator_error actuator_drive_from(struct actuator *actuator,
                                        const struct actuator_state *state,
                                        int32_t input,
                                        double value,
                                        double time_s,
                                        struct actuator_load *load);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* ACTUATOR_H */
