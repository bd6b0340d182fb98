/* A long step reports its progress, ends within 0.2 s of an interrupt, and gives the same bits as one
 * that is not watched. */
#define _POSIX_C_SOURCE 199309L
#include "actuator.h"
#include "expect.h"

#include <signal.h>
#include <string.h>
#include <time.h>

struct progress {
    struct actuator *servo; /* Read during the step. */
    uint64_t calls, done, total, end_at;
};

static int32_t watch(void *data, uint64_t done, uint64_t total)
{
    struct progress *progress = (struct progress *)data;
    struct actuator_reading now;

    EXPECT(done > progress->done || total == 0);
    EXPECT(done <= total);
    EXPECT(actuator_read(progress->servo, &now) == ACTUATOR_ERROR_NONE);
    EXPECT(now.tick == done);
    progress->calls++;
    progress->done = done;
    progress->total = total;
    return done < progress->end_at;
}

static volatile sig_atomic_t is_interrupted;

static void interrupt(int signal_number)
{
    (void)signal_number;
    is_interrupted = 1;
}

/* When the signal was raised. */
struct stopwatch {
    struct timespec raised;
};

static double seconds_since(const struct timespec *then)
{
    struct timespec now;

    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)(now.tv_sec - then->tv_sec) + 1e-9 * (double)(now.tv_nsec - then->tv_nsec);
}

static int32_t until_interrupted(void *data, uint64_t done, uint64_t total)
{
    struct stopwatch *stopwatch = (struct stopwatch *)data;

    (void)total;
    if (is_interrupted)
        return 0;
    if (done == 10 * ACTUATOR_WATCH_TICKS) {
        clock_gettime(CLOCK_MONOTONIC, &stopwatch->raised);
        raise(SIGINT);
    }
    return 1;
}

static void start(struct actuator *servo, const char *plant)
{
    struct actuator_settings settings;
    struct actuator_why why;

    EXPECT(!actuator_settings_init(&settings, sizeof settings, "board", plant, &why));
    EXPECT(!actuator_start(servo, sizeof *servo, &settings, &why));
}

static void watched_steps(void)
{
    static struct actuator plain, watched;
    struct actuator_reading expected, found;
    const uint64_t ticks = 5 * ACTUATOR_WATCH_TICKS + 83;
    struct progress progress = {&watched, 0, 0, 0, UINT64_MAX};

    start(&plain, "bench");
    watched = plain;
    EXPECT(!actuator_drive(&plain, ACTUATOR_INPUT_POSITION, 60.0, ticks));
    EXPECT(!actuator_drive_watched(&watched, ACTUATOR_INPUT_POSITION, 60.0, ticks, watch, &progress));
    EXPECT(progress.calls == 6 && progress.done == ticks && progress.total == ticks);
    EXPECT(!actuator_read(&plain, &expected) && !actuator_read(&watched, &found));
    EXPECT(memcmp(&expected, &found, sizeof found) == 0);

    /* Interrupted after three parts, then continued without a watch. */
    start(&watched, "bench");
    progress.calls = progress.done = 0;
    progress.end_at = 3 * ACTUATOR_WATCH_TICKS;
    EXPECT(actuator_drive_watched(&watched, ACTUATOR_INPUT_POSITION, 60.0, ticks, watch, &progress)
           == ACTUATOR_ERROR_INTERRUPTED);
    EXPECT(!actuator_read(&watched, &found) && found.tick == progress.end_at);
    EXPECT(!actuator_drive_watched(&watched, ACTUATOR_INPUT_POSITION, 60.0,
                                   ticks - progress.end_at, NULL, NULL));
    EXPECT(!actuator_read(&watched, &found));
    EXPECT(memcmp(&expected, &found, sizeof found) == 0);

    /* A step that is done is not interrupted, not even one of no ticks. */
    start(&watched, "bench");
    progress.done = progress.end_at = 0;
    EXPECT(!actuator_drive_watched(&watched, ACTUATOR_INPUT_POSITION, 60.0, 0, watch, &progress));
    EXPECT(!actuator_drive_watched(&watched, ACTUATOR_INPUT_POSITION, 60.0, 1, watch, &progress));
}

static void an_interrupt_ends_an_hour(void)
{
    static struct actuator servo;
    struct stopwatch stopwatch;

    start(&servo, "bench");
    signal(SIGINT, interrupt);
    EXPECT(actuator_drive_watched(&servo, ACTUATOR_INPUT_POSITION, 60.0,
                                  ACTUATOR_LONGEST_STEP_TICKS, until_interrupted, &stopwatch)
           == ACTUATOR_ERROR_INTERRUPTED);
    EXPECT(seconds_since(&stopwatch.raised) < 0.2);
}

int main(void)
{
    watched_steps();
    an_interrupt_ends_an_hour();
    return failures != 0;
}
