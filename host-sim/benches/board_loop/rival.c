/* The rivals of the benchmark: the board's loop (reference semantics S9) in double precision, as a
 * C programmer would write it: plainly (-DPLAIN), with tuned loops (-DSTEPPED), with the closed
 * form of this project's own program, or in steps of 1 ms without looking at anything (-DBARE).
 *
 * usage: rival ACTUATORS THREADS
 * prints: seconds of the run, then a sum over what it saw, so that nothing can be left out
 *
 * All others look at angle and rate at every 50 us and follow their ends. With tuned loops, the
 * duty is known to hold for a millisecond: the loops are nested, everything stays in registers, and
 * one multiplication is on the critical path of a step. With the closed form, the steps of a
 * millisecond do not depend on each other, and the compiler makes vectors of them. */
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { SECONDS = 60, TICKS = SECONDS * 20000, DELAY = 350 };
static const double H = 50e-6, T = 4e-3, LSB = 360.0 / 4096.0;
static const double LEVELS[14] = {0, 30, -20, 60, -60, 90, -45, 120, -120, 45, 0, 10, -10, 0};

typedef struct { double kup, kdn, tau; } Motor;
typedef struct { double low_angle, high_angle, low_rate, high_rate; } Ends;

/* 4 s a level, the last one held. */
static double command(long tick) {
    long level = tick < 0 ? 0 : tick / 80000;
    return LEVELS[level < 13 ? level : 13];
}

static double limit(double x, double low, double high) {
    return x < low ? low : x > high ? high : x;
}

static double less(double a, double b) { return a < b ? a : b; }
static double more(double a, double b) { return a > b ? a : b; }

typedef struct { double x, rh; long last; int started; } Control;

static double control(Control *s, double theta, double c) {
    long count = (long)floor(theta / LSB + 0.5);
    long d = s->started ? ((count - s->last + 2048) & 4095) - 2048 : 0;
    s->started = 1;
    s->last = count;
    s->rh += 0.4 * (d * LSB / T - s->rh);
    double e = 8.0 * (c - count * LSB) - s->rh;
    double v = 10.0 / 7.586 * e + s->x;
    double u = limit(v, -100.0, 100.0);
    s->x += T * (10.0 * e + 7.586 * (u - v));
    return u;
}

#ifdef PLAIN
static Ends simulate(Motor m) {
    Control s = {0};
    Ends r = {1e9, -1e9, 1e9, -1e9};
    double theta = 0, w = 0, pending = 0, active = 0, E = exp(-H / m.tau);
    for (long i = 0; i < TICKS; i++) {
        if (i % 20 == 0) active = pending;
        if (i % 80 == 0) pending = control(&s, theta, command(i - DELAY));
        r.low_angle = less(theta, r.low_angle);
        r.high_angle = more(theta, r.high_angle);
        r.low_rate = less(w, r.low_rate);
        r.high_rate = more(w, r.high_rate);
        double winf = (active > 0 ? m.kup : m.kdn) * active;
        theta += winf * H + (w - winf) * m.tau * (1 - E);
        w = winf + (w - winf) * E;
        if (theta > 180 || theta < -180) {
            theta = limit(theta, -180, 180);
            if (theta * w > 0) w = 0;
        }
    }
    return r;
}
#elif defined BARE
static Ends simulate(Motor m) {
    Control s = {0};
    const double H20 = 20 * H, E = exp(-H20 / m.tau), travel = m.tau * (1 - E);
    double theta = 0, w = 0, pending = 0;
    for (long i = 0; i < TICKS; i += 80) {
        double winf = (pending > 0 ? m.kup : m.kdn) * pending;
        pending = control(&s, theta, command(i - DELAY));
        for (int period = 0; period < 4; period++) {
            if (period == 1) winf = (pending > 0 ? m.kup : m.kdn) * pending;
            theta += winf * H20 + (w - winf) * travel;
            w = winf + (w - winf) * E;
            if (fabs(theta) > 180) {
                theta = limit(theta, -180, 180);
                if (theta * w > 0) w = 0;
            }
        }
    }
    return (Ends){theta, theta, w, w};
}
#elif defined STEPPED
static Ends simulate(Motor m) {
    Control s = {0};
    Ends r = {1e9, -1e9, 1e9, -1e9};
    const double E = exp(-H / m.tau), travel = m.tau * (1 - E);
    double theta = 0, w = 0, pending = 0;
    for (long i = 0; i < TICKS; i += 80) {
        const double active = pending;
        pending = control(&s, theta, command(i - DELAY));
        double winf = (active > 0 ? m.kup : m.kdn) * active;
        for (int period = 0; period < 4; period++) {
            if (period == 1) winf = (pending > 0 ? m.kup : m.kdn) * pending;
            const double step = winf * H;
            double excess = w - winf;
            for (int tick = 0; tick < 20; tick++) {
                const double rate = winf + excess;
                r.low_angle = less(theta, r.low_angle);
                r.high_angle = more(theta, r.high_angle);
                r.low_rate = less(rate, r.low_rate);
                r.high_rate = more(rate, r.high_rate);
                theta += step + excess * travel;
                excess *= E;
                if (__builtin_expect(fabs(theta) > 180, 0)) {
                    theta = limit(theta, -180, 180);
                    if (theta * (winf + excess) > 0) excess = -winf;
                }
            }
            w = winf + excess;
        }
    }
    return r;
}
#else
static Ends simulate(Motor m) {
    enum { LANES = 4 };
    Control s = {0};
    double decay[21], time[21], low_angle[LANES], high_angle[LANES], low_rate[LANES], high_rate[LANES];
    for (int j = 0; j <= 20; j++) {
        time[j] = j * H;
        decay[j] = expm1(-time[j] / m.tau);
    }
    for (int l = 0; l < LANES; l++) {
        low_angle[l] = low_rate[l] = 1e9;
        high_angle[l] = high_rate[l] = -1e9;
    }
    double theta = 0, w = 0, pending = 0;
    for (long i = 0; i < TICKS; i += 80) {
        const double active = pending;
        pending = control(&s, theta, command(i - DELAY));
        double winf = (active > 0 ? m.kup : m.kdn) * active;
        for (int period = 0; period < 4; period++) {
            if (period == 1) winf = (pending > 0 ? m.kup : m.kdn) * pending;
            const double excess = w - winf, lag = m.tau * excess;
            if (__builtin_expect(fabs(theta) + (fabs(w) + fabs(winf)) * 21 * H >= 180, 0)) {
                for (int tick = 0; tick < 20; tick++) {
                    low_angle[0] = less(theta, low_angle[0]);
                    high_angle[0] = more(theta, high_angle[0]);
                    low_rate[0] = less(w, low_rate[0]);
                    high_rate[0] = more(w, high_rate[0]);
                    const double e = w - winf;
                    theta += winf * H - m.tau * e * decay[1];
                    w += e * decay[1];
                    if (fabs(theta) > 180) {
                        theta = limit(theta, -180, 180);
                        if (theta * w > 0) w = 0;
                    }
                }
                continue;
            }
            for (int j = 0; j < 20; j += LANES)
                for (int l = 0; l < LANES; l++) {
                    const double angle = theta + winf * time[j + l] - lag * decay[j + l];
                    const double rate = w + excess * decay[j + l];
                    low_angle[l] = less(angle, low_angle[l]);
                    high_angle[l] = more(angle, high_angle[l]);
                    low_rate[l] = less(rate, low_rate[l]);
                    high_rate[l] = more(rate, high_rate[l]);
                }
            theta += winf * time[20] - lag * decay[20];
            w += excess * decay[20];
        }
    }
    Ends r = {1e9, -1e9, 1e9, -1e9};
    for (int l = 0; l < LANES; l++) {
        r.low_angle = less(low_angle[l], r.low_angle);
        r.high_angle = more(high_angle[l], r.high_angle);
        r.low_rate = less(low_rate[l], r.low_rate);
        r.high_rate = more(high_rate[l], r.high_rate);
    }
    return r;
}
#endif

typedef struct { long first, end, actuators; double sum; } Share;

static void *run(void *argument) {
    Share *share = argument;
    for (long k = share->first; k < share->end; k++) {
        /* Gain and time constant spread by +-10 %. */
        double spread = share->actuators > 1 ? 0.9 + 0.2 * k / (share->actuators - 1) : 1.0;
        Ends ends = simulate((Motor){2.836 * spread, 2.836 * spread, spread / 7.586});
        share->sum += ends.low_angle + ends.high_angle + ends.low_rate + ends.high_rate;
    }
    return NULL;
}

int main(int argc, char **argv) {
    long actuators = argc > 1 ? atol(argv[1]) : 1, threads = argc > 2 ? atol(argv[2]) : 1;
    pthread_t *ids = malloc(threads * sizeof *ids);
    Share *shares = calloc(threads, sizeof *shares);
    struct timespec start, end;
    clock_gettime(CLOCK_MONOTONIC, &start);
    for (long t = 0; t < threads; t++) {
        shares[t] = (Share){actuators * t / threads, actuators * (t + 1) / threads, actuators, 0};
        pthread_create(&ids[t], NULL, run, &shares[t]);
    }
    double sum = 0;
    for (long t = 0; t < threads; t++) {
        pthread_join(ids[t], NULL);
        sum += shares[t].sum;
    }
    clock_gettime(CLOCK_MONOTONIC, &end);
    double seconds = (end.tv_sec - start.tv_sec) + 1e-9 * (end.tv_nsec - start.tv_nsec);
    printf("%.9f %.9f\n", seconds, sum);
    return 0;
}
