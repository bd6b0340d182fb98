/* The control law of model-core's cascade in single precision, written in C with CMSIS-DSP: the PI is
 * the recurrence of arm_pid_f32 with Kd = 0 (CMSIS-DSP, arm_math.h), its output limited to the duty
 * limits and fed back as the recurrence's last output. The inputs are those of
 * firmware/boards/f427/src/control_law.rs. */

#include <stdbool.h>
#include <stdint.h>

#define TURN 4096
#define COUNT_DEG (360.0f / TURN)
#define PERIOD_S 0.004f
#define POSITION_GAIN 8.0f
#define KP 1.3182177f
#define KI 10.0f
#define RATE_FILTER 0.4f
#define COUNTS_PER_PERCENT 560.0f

/* arm_pid_instance_f32. */
struct pid { float a0, a1, a2, state[3]; };

/* What the cascade has as coefficients. */
struct gains {
    float position_gain, position_min, position_max, rate_up, rate_down;
    float feed_forward, duty_limit, duty_step, rate_filter;
};

struct state {
    struct pid pid;
    int32_t turned, last_count, periods;
    bool known;
    float rate, duty, remainder;
    bool position_limited, rate_limited, duty_limited, slew_limited;
};

static const struct gains GAINS = {
    POSITION_GAIN, -32768.0f, 32767.0f, 131072.0f, 131072.0f, 0.0f, 100.0f, 200.0f, RATE_FILTER,
};

volatile int32_t COMPARE;

static inline float within(float value, float low, float high)
{
    return value < low ? low : value > high ? high : value;
}

/* arm_pid_f32. */
static inline float pid(struct pid *s, float in)
{
    float out = s->a0 * in + s->a1 * s->state[0] + s->a2 * s->state[1] + s->state[2];
    s->state[1] = s->state[0];
    s->state[0] = in;
    s->state[2] = out;
    return out;
}

static bool is_valid(uint32_t word)
{
    uint32_t parity = word ^ word >> 16;
    parity ^= parity >> 8;
    parity ^= parity >> 4;
    parity = 0x6996u >> (parity & 15) & 1;
    return !parity && (word & 0x38) == 0x20;
}

static void observe(struct state *s, const struct gains *g, uint32_t word)
{
    s->periods += s->periods < 100;
    if (!is_valid(word))
        return;
    int32_t count = (int32_t)(word >> 6);
    int32_t moved = s->known ? ((count - s->last_count + TURN / 2) & (TURN - 1)) - TURN / 2
                             : ((count + TURN / 2) & (TURN - 1)) - TURN / 2;
    float raw = s->known ? (float)moved * COUNT_DEG / (PERIOD_S * (float)s->periods) : 0.0f;
    s->turned += moved;
    s->last_count = count;
    s->known = true;
    s->periods = 0;
    s->rate += g->rate_filter * (raw - s->rate);
}

static int32_t regulate(struct state *s, const struct gains *g, float command)
{
    float target = within(command, g->position_min, g->position_max);
    float requested = g->position_gain * (target - (float)s->turned * COUNT_DEG);
    float rate_command = within(requested, -g->rate_down, g->rate_up);
    s->position_limited = target != command;
    s->rate_limited = rate_command != requested;

    float unlimited = pid(&s->pid, rate_command - s->rate) + g->feed_forward * rate_command;
    float limited = within(unlimited, -g->duty_limit, g->duty_limit);
    float slewed = within(limited, s->duty - g->duty_step, s->duty + g->duty_step);
    float duty = within(slewed, -g->duty_limit, g->duty_limit);
    s->duty_limited = limited != unlimited;
    s->slew_limited = duty != limited;
    s->pid.state[2] = duty - g->feed_forward * rate_command;
    s->duty = duty;

    /* First-order noise shaping. */
    float exact = duty * COUNTS_PER_PERCENT + s->remainder;
    int32_t counts = (int32_t)(exact + (exact < 0 ? -0.5f : 0.5f));
    s->remainder = exact - (float)counts;
    return counts;
}

__attribute__((noipa)) int32_t control_law(struct state *s, uint32_t word, float command)
{
    observe(s, &GAINS, word);
    return regulate(s, &GAINS, command);
}

struct inputs { uint32_t word; float command; };

__attribute__((noipa)) struct inputs stimulus(uint32_t step)
{
    uint32_t phase = step % 500;
    uint32_t count = ((phase < 250 ? phase : 500 - phase) * 8 / 5 - 200) & (TURN - 1);
    uint32_t word = count << 6 | 1u << 5;
    word |= (uint32_t)__builtin_popcount(word) & 1;
    return (struct inputs){ word, step / 200 % 2 == 0 ? 20.0f : -20.0f };
}

int main(void)
{
    static struct state state;
    /* Kd = 0; the integral takes the error of the period before, as the cascade's does (arm_pid_init_f32
     * gives it that of now). */
    state.pid = (struct pid){ KP, KI * PERIOD_S - KP, 0.0f, { 0 } };
    for (uint32_t step = 0;; step++) {
        struct inputs inputs = stimulus(step);
        COMPARE = control_law(&state, inputs.word, inputs.command);
    }
}

extern uint32_t STACK_TOP;

void reset(void)
{
    /* The floating point unit, then the program; nothing is initialised but by code. */
    *(volatile uint32_t *)0xE000ED88 |= 0xF << 20;
    __asm volatile("dsb\n\tisb");
    main();
}

__attribute__((section(".vectors"), used)) static void *const VECTORS[] = { &STACK_TOP, reset };
