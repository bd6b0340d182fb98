/* The models as compiled rivals: exact between their limits, for a command of steps.
 * p: the parameters in the order of the example `fit_speed`; y: angles at n samples t. */
#include <math.h>

/* Of first order: exact pieces of exponential and straight line. */
static double lag(double y, double target, double h, double pole, double up, double down) {
    double limit = target > y ? up : -down;
    double reach = limit / pole;              /* distance at which the limit lets go */
    double far = target - y;
    if (fabs(far) > fabs(reach)) {
        double t = (far - reach) / limit;
        if (t >= h) return y + limit * h;
        y += limit * t;
        h -= t;
    }
    return target - (target - y) * exp(-pole * h);
}

void black_box_1(const double *p, int n, const double *t, int m, const double *step_t,
                 const double *step, double first, double *y) {
    double pole = p[0], delay = p[1], up = p[2], down = p[3], gain = p[4], offset = p[5];
    double x = 0.0, now = t[0], target = gain * first + offset;
    int j = 0;
    for (int i = 0; i < n; i++) {
        while (j < m && step_t[j] + delay <= t[i]) {
            x = lag(x, target, step_t[j] + delay - now, pole, up, down);
            now = step_t[j] + delay;
            target = gain * step[j++] + offset;
        }
        x = lag(x, target, t[i] - now, pole, up, down);
        now = t[i];
        y[i] = x;
    }
}

/* Of second order: the damped oscillator, its limited integrator, and the times between. */
static void free_motion(double A, double B, double e, double w, double h, double *e1, double *w1) {
    /* e = target - angle: e'' + B e' + A e = 0, e' = -w */
    double s = 0.5 * B, d = A - s * s, v = -w, E = exp(-s * h), c, sn;
    if (d > 1e-9) { double r = sqrt(d); c = cos(r * h); sn = sin(r * h) / r; }
    else if (d < -1e-9) { double r = sqrt(-d); c = cosh(r * h); sn = sinh(r * h) / r; }
    else { c = 1.0; sn = h; }
    *e1 = E * (e * c + (v + s * e) * sn);
    *w1 = -E * (v * c - (s * v + A * e) * sn);
}

static void oscillator(double *x, double *w, double target, double h, const double *p) {
    double A = p[0], B = p[1], up = p[3], down = p[4];
    for (int k = 0; k < 16 && h > 0.0; k++) {
        double e = target - *x, a = A * e - B * *w;
        if ((*w >= up && a > 0.0) || (*w <= -down && a < 0.0)) {
            *w = *w > 0.0 ? up : -down;
            double t = (A * e - B * *w) / (A * *w); /* until the acceleration turns */
            if (t >= h) { *x += *w * h; return; }
            *x += *w * t;
            h -= t;
            double e2 = target - *x, e1, w1;       /* past the turn for certain */
            free_motion(A, B, e2, *w, h, &e1, &w1);
            if (w1 <= up && w1 >= -down) { *x = target - e1; *w = w1; return; }
            continue;
        }
        double e1, w1;
        free_motion(A, B, e, *w, h, &e1, &w1);
        if (w1 <= up && w1 >= -down) { *x = target - e1; *w = w1; return; }
        double limit = w1 > up ? up : -down, lo = 0.0, hi = h;
        double f = w1 - limit, t = h;
        for (int i = 0; i < 60 && hi - lo > 1e-15; i++) { /* Newton, kept within brackets */
            double slope = A * e1 - B * w1;
            if ((f > 0.0) == (limit > 0.0)) hi = t; else lo = t;
            double next = t - f / slope;
            t = next > lo && next < hi ? next : 0.5 * (lo + hi);
            free_motion(A, B, e, *w, t, &e1, &w1);
            f = w1 - limit;
            if (fabs(f) < 1e-11) break;
        }
        *x = target - e1;
        *w = limit;
        h -= t;
    }
}

void black_box_2(const double *p, int n, const double *t, int m, const double *step_t,
                 const double *step, double first, double *y) {
    double delay = p[2], gain = p[5], offset = p[6];
    double x = 0.0, w = 0.0, now = t[0], target = gain * first + offset;
    int j = 0;
    for (int i = 0; i < n; i++) {
        while (j < m && step_t[j] + delay <= t[i]) {
            oscillator(&x, &w, target, step_t[j] + delay - now, p);
            now = step_t[j] + delay;
            target = gain * step[j++] + offset;
        }
        oscillator(&x, &w, target, t[i] - now, p);
        now = t[i];
        y[i] = x;
    }
}

/* The grey box: motor, PI rate loop, P position loop, limit of the duty. Affine within each of four
 * modes of the duty; the series of the exponential is summed until it stands. */
enum { STATES = 3, WIDTH = 5, DUTIES = 4, TERMS = 24 }; /* a row: states, command, one */
enum { POSITIVE, NEGATIVE, FULL, REVERSE };

typedef struct {
    double a[STATES][WIDTH];
    double demand[WIDTH];
} affine;

static void taylor(const affine *m, double *x, double command, double h) {
    double term[STATES], next[STATES];
    for (int i = 0; i < STATES; i++) term[i] = x[i];
    for (int k = 0; k < TERMS; k++) {
        double factor = h / (k + 1), size = 0.0;
        for (int i = 0; i < STATES; i++) {
            next[i] = k ? 0.0 : m->a[i][3] * command + m->a[i][4];
            for (int j = 0; j < STATES; j++) next[i] += m->a[i][j] * term[j];
        }
        for (int i = 0; i < STATES; i++) {
            term[i] = next[i] * factor;
            x[i] += term[i];
            size += fabs(term[i]);
        }
        if (size < 1e-15) return;
    }
}

static double demand(const affine *m, const double *x, double command) {
    const double *d = m->demand;
    return d[0] * x[0] + d[1] * x[1] + d[2] * x[2] + d[3] * command + d[4];
}

/* By how much a demand lies outside of its mode, and the mode there. */
static double outside(int mode, double v, double limit, int *next) {
    switch (mode) {
    case POSITIVE: *next = v < 0.5 * limit ? NEGATIVE : FULL; return fmax(-v, v - limit);
    case NEGATIVE: *next = v > -0.5 * limit ? POSITIVE : REVERSE; return fmax(v, -v - limit);
    case FULL: *next = POSITIVE; return limit - v;
    default: *next = NEGATIVE; return v + limit;
    }
}

static void servo(affine *modes, int *mode, double *x, double command, double h, double limit) {
    for (int k = 0; k < 16 && h > 0.0; k++) {
        affine *m = &modes[*mode];
        double end[STATES] = {x[0], x[1], x[2]}, from[STATES] = {x[0], x[1], x[2]};
        int next;
        taylor(m, end, command, h);
        if (outside(*mode, demand(m, end, command), limit, &next) <= 1e-9) {
            for (int i = 0; i < STATES; i++) x[i] = end[i];
            return;
        }
        double lo = 0.0, hi = h, below = outside(*mode, demand(m, x, command), limit, &(int){0});
        double above = outside(*mode, demand(m, end, command), limit, &(int){0}), t = h;
        int side = 0;
        for (int i = 0; i < 60 && hi - lo > 1e-15; i++) { /* Illinois */
            t = (lo * above - hi * below) / (above - below);
            for (int j = 0; j < STATES; j++) end[j] = from[j];
            taylor(m, end, command, t);
            double f = outside(*mode, demand(m, end, command), limit, &next);
            if (fabs(f) < 1e-11) break;
            if (f > 0.0) { hi = t; above = f; if (side == 1) below *= 0.5; side = 1; }
            else { lo = t; below = f; if (side == -1) above *= 0.5; side = -1; }
        }
        outside(*mode, demand(m, end, command), limit, &next);
        for (int i = 0; i < STATES; i++) x[i] = end[i];
        *mode = next;
        h -= t;
    }
}

void grey_box(const double *p, int n, const double *t, int m, const double *step_t,
              const double *step, double first, double *y) {
    double delay = p[3], prop = p[4], integral = p[5], position = p[6], windup = p[7], limit = p[8];
    affine modes[DUTIES] = {0};
    for (int mode = 0; mode < DUTIES; mode++) {
        affine *s = &modes[mode];
        double gain = mode == POSITIVE || mode == FULL ? p[0] : p[1];
        double level = mode == FULL ? limit : -limit;
        double error[WIDTH] = {-position, -1.0, 0.0, position, 0.0};
        for (int j = 0; j < WIDTH; j++) {
            int is_limited = mode >= FULL;
            s->demand[j] = prop * error[j] + (j == 2);
            double duty = is_limited ? (j == 4 ? level : 0.0) : s->demand[j];
            s->a[0][j] = j == 1;
            s->a[1][j] = (gain * duty - (j == 1)) / p[2];
            s->a[2][j] = integral * error[j] + windup * (duty - s->demand[j]);
        }
    }
    double x[STATES] = {0.0}, now = t[0], command = first;
    int j = 0, mode = POSITIVE;
    for (int i = 0; i < n; i++) {
        while (j < m && step_t[j] + delay <= t[i]) {
            servo(modes, &mode, x, command, step_t[j] + delay - now, limit);
            now = step_t[j] + delay;
            command = step[j++];
            double v = demand(&modes[POSITIVE], x, command);
            mode = v > limit ? FULL : v < -limit ? REVERSE : v > 0.0 ? POSITIVE : NEGATIVE;
        }
        servo(modes, &mode, x, command, t[i] - now, limit);
        now = t[i];
        y[i] = x[0];
    }
}
