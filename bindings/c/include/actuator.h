/*
 * The smart actuator: the board's own control core and its models, stepped by the caller.
 *
 * Angles are in deg, rates in deg/s, times in s or in ticks of 50 us, torques in Nm, duties in %.
 * The library has no heap, no thread and no global state: all memory is the caller's.
 *
 * Every pointer must be null, or point to a whole object of its type; texts end in a zero. Memory
 * that is given to another function than actuator_settings_init or actuator_start must be zeroed
 * or filled by one of these two. Null, misaligned pointers, zeroed memory, NaN and unknown names
 * give an error code. `why` may be null; otherwise it is always written.
 *
 * Different actuators may be used by different threads at once; one actuator by one at a time.
 * Snapshots are valid within one process.
 */

#ifndef ACTUATOR_H
#define ACTUATOR_H

/* Made from the Rust source by a test of bindings/c; do not edit. */

#include <stddef.h>
#include <stdint.h>

/**
 * Room for a sentence about the longest name, its value, range and unit (at most 150 bytes: a
 * number has at most 24 characters where it is not absurd); what is longer is cut.
 */
#define ACTUATOR_WHY_SIZE 192

/**
 * Words of 8 bytes in `struct actuator_settings`: 824 bytes and room to grow.
 */
#define ACTUATOR_SETTINGS_WORDS 128

/**
 * Version of this interface: it changes with the layout or the meaning of anything in the header.
 */
#define ACTUATOR_ABI_VERSION 1

/**
 * Ticks in one second: a tick is 50 us.
 */
#define ACTUATOR_TICKS_PER_SECOND 20000

/**
 * The longest single step, ticks: an hour, which a PC computes in two minutes at the most. More is
 * rather a wrong unit, or a time that nobody set.
 */
#define ACTUATOR_LONGEST_STEP_TICKS 72000000

/**
 * Words of 8 bytes in `struct actuator`: 20,000 are the delay line, whose range ends at 1 s.
 */
#define ACTUATOR_WORDS 20480

/**
 * Size of `struct actuator`, bytes.
 */
#define ACTUATOR_SIZE 163840

/**
 * Alignment of `struct actuator` and `struct actuator_settings`, bytes, which is enough anywhere.
 */
#define ACTUATOR_ALIGNMENT 8

/**
 * What became of a call. Only `ACTUATOR_ERROR_NONE` is 0; after any other nothing has changed,
 * unless the function says otherwise.
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
   * A size is not that of this library: header and library are of different versions. Nothing
   * was touched.
   */
  ACTUATOR_ERROR_SIZE = 2,
  /**
   * The memory holds no settings or no started actuator.
   */
  ACTUATOR_ERROR_NOT_READY = 3,
  /**
   * Nothing has this name or this index.
   */
  ACTUATOR_ERROR_NAME = 4,
  /**
   * A parameter is NaN, outside its range, or at odds with another one.
   */
  ACTUATOR_ERROR_PARAMETER = 5,
  /**
   * A command or a torque is NaN or infinite.
   */
  ACTUATOR_ERROR_COMMAND = 6,
  /**
   * A time is NaN or in the past, or the step to it is longer than an hour.
   */
  ACTUATOR_ERROR_TIME = 7,
};

/**
 * A model, its plant and the values of their parameters. Opaque; it may be copied by assignment.
 */
struct actuator_settings {
  /**
   * Not for the caller.
   */
  uint64_t opaque[ACTUATOR_SETTINGS_WORDS];
};

/**
 * Why a call failed, in a sentence that names the parameter and its range.
 */
struct actuator_why {
  /**
   * The sentence, ended by a zero; empty where nothing failed.
   */
  char text[ACTUATOR_WHY_SIZE];
};

/**
 * What is known of one parameter, and its present value.
 */
struct actuator_parameter {
  /**
   * Present value, in its unit.
   */
  double value;
  /**
   * Value unless somebody says otherwise, in its unit.
   */
  double default_value;
  /**
   * The least value that it takes, in its unit.
   */
  double min;
  /**
   * The greatest value that it takes, in its unit; infinite where there is no bound.
   */
  double max;
  /**
   * Its name.
   */
  char name[32];
  /**
   * The short symbol of the paper; empty where there is none.
   */
  char symbol[16];
  /**
   * Its unit.
   */
  char unit[16];
  /**
   * What it is, in a sentence.
   */
  char meaning[192];
  /**
   * Where the default comes from.
   */
  char source[128];
};

/**
 * A named reading of the paper's numbers.
 */
struct actuator_preset {
  /**
   * Its name.
   */
  char name[32];
  /**
   * What it is for, in a sentence.
   */
  char summary[192];
  /**
   * What must be said wherever its results are shown; empty for most.
   */
  char warning[128];
};

/**
 * An actuator with all of its state. Opaque. It points to nothing: a copy by assignment or memcpy
 * is a snapshot, and copying it back restores it.
 */
struct actuator {
  /**
   * Not for the caller.
   */
  uint64_t opaque[ACTUATOR_WORDS];
};

/**
 * What can be seen of an actuator. What a model does not have is zero; what it does not measure
 * is its true value.
 */
struct actuator_reading {
  /**
   * Ticks of 50 us since the start.
   */
  uint64_t tick;
  /**
   * The command that has arrived behind the delay, deg.
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

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * What a code means, in English; any number may be asked for. The text is constant.
 */
const char *actuator_error_text(int32_t code);

/**
 * Fills `settings` with the defaults of a model; whatever was there is overwritten, and where it
 * fails the settings are not ready.
 *
 * `size` is `sizeof *settings`. `model` is `black-box-1`, `black-box-2`, `grey-box` or `board`.
 * `plant` is what the board drives, `first-order` or `bench`; null is `first-order`.
 */
enum actuator_error actuator_settings_init(struct actuator_settings *settings,
                                           size_t size,
                                           const char *model,
                                           const char *plant,
                                           struct actuator_why *why);

/**
 * Sets a parameter of the chosen model and plant, by name or by symbol, in its unit.
 */
enum actuator_error actuator_settings_set(struct actuator_settings *settings,
                                          const char *name,
                                          double value,
                                          struct actuator_why *why);

/**
 * The present value of a parameter, by name or by symbol, in its unit.
 */
enum actuator_error actuator_settings_get(const struct actuator_settings *settings,
                                          const char *name,
                                          double *value);

/**
 * Applies a preset of the chosen model by name: it sets some parameters and leaves the others.
 */
enum actuator_error actuator_settings_apply(struct actuator_settings *settings,
                                            const char *preset,
                                            struct actuator_why *why);

/**
 * How the bridge of the board is switched: `average` (unless somebody says otherwise) or
 * `switched`.
 */
enum actuator_error actuator_settings_set_pwm(struct actuator_settings *settings,
                                              const char *pwm,
                                              struct actuator_why *why);

/**
 * The seed of all that is random; 0 unless somebody says otherwise.
 */
enum actuator_error actuator_settings_set_seed(struct actuator_settings *settings, uint64_t seed);

/**
 * Parameter number `index` of the chosen model and plant; `ACTUATOR_ERROR_NAME` beyond the last.
 */
enum actuator_error actuator_settings_parameter(const struct actuator_settings *settings,
                                                size_t index,
                                                struct actuator_parameter *parameter);

/**
 * Preset number `index` of the chosen model; `ACTUATOR_ERROR_NAME` beyond the last. Number 0
 * changes nothing: it is what the model is without a preset.
 */
enum actuator_error actuator_settings_preset(const struct actuator_settings *settings,
                                             size_t index,
                                             struct actuator_preset *preset);

/**
 * `ACTUATOR_ABI_VERSION` of the library: compare it with that of the header.
 */
uint32_t actuator_abi_version(void);

/**
 * `ACTUATOR_SIZE` of the library, bytes.
 */
size_t actuator_size(void);

/**
 * Puts an actuator of these settings at rest at zero, time zero. Whatever was there is
 * overwritten; where it fails the actuator is not ready. The settings are needed no longer.
 *
 * `size` is `sizeof *actuator`. The call needs 500 KiB of stack; the others need 16 KiB.
 */
enum actuator_error actuator_start(struct actuator *actuator,
                                   size_t size,
                                   const struct actuator_settings *settings,
                                   struct actuator_why *why);

/**
 * Moves by so many ticks of 50 us with this command held, deg.
 *
 * The first command is taken to have stood there for ever: the delay begins with the second.
 */
enum actuator_error actuator_advance(struct actuator *actuator, double command_deg, uint64_t ticks);

/**
 * Moves to the tick nearest to `time_s` after the start, s, with this command held, deg.
 *
 * For simulations whose step is no whole number of ticks, 1/120 s say: the absolute time keeps
 * the two from drifting apart.
 */
enum actuator_error actuator_advance_to(struct actuator *actuator,
                                        double command_deg,
                                        double time_s);

/**
 * Puts a torque on the load from the next PWM period on, Nm, beside that of the parameters. Only
 * the bench has a load; the other models take any finite torque and do not feel it.
 */
enum actuator_error actuator_set_load_nm(struct actuator *actuator, double torque_nm);

/**
 * What can be seen now.
 */
enum actuator_error actuator_read(const struct actuator *actuator,
                                  struct actuator_reading *reading);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* ACTUATOR_H */
