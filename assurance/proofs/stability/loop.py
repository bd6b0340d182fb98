"""The sampled loop between two limits, in exact rational bounds.

State at a control step: angle error e (deg), rate w (deg/s), duty of the last period d (%), travel
in the last period g (deg), filtered rate h (deg/s), integrator x (%). With r = -P e, the step
computes

    h+ = h + alpha (g/T - h)      v = Kp (r - h+) + x      u = v limited
    x+ = x + T (Ki (r - h+) + Kaw (u - v))

and the motor K p/(s + p) turns with d until the PWM edge after DELAY, then with u. Written with the
part psi = v - u that the limit takes away: state+ = A state - B psi, v = C state.

Numbers are intervals (least, greatest) of Fractions, as the motor is only known within its box.
"""

from fractions import Fraction as F

PERIOD = F(4, 1000)
DELAY = F(1, 1000)
STATES = 6
# Denominator of the bounds: rounding outwards to it keeps the arithmetic of the check fast.
GRID = 1 << 40


def down(x):
    return F((x.numerator * GRID) // x.denominator, GRID)


def up(x):
    return -down(-x)


class Interval:
    def __init__(self, low, high=None):
        self.low, self.high = F(low), F(low if high is None else high)

    def __add__(self, other):
        other = as_interval(other)
        return Interval(self.low + other.low, self.high + other.high)

    __radd__ = __add__

    def __neg__(self):
        return Interval(-self.high, -self.low)

    def __sub__(self, other):
        return self + (-as_interval(other))

    def __rsub__(self, other):
        return as_interval(other) - self

    def __mul__(self, other):
        other = as_interval(other)
        ends = [a * b for a in (self.low, self.high) for b in (other.low, other.high)]
        return Interval(min(ends), max(ends))

    __rmul__ = __mul__

    def rounded(self):
        return Interval(down(self.low), up(self.high))

    @property
    def middle(self):
        return (self.low + self.high) / 2


def as_interval(value):
    return value if isinstance(value, Interval) else Interval(value)


def exp_minus(x):
    """Bounds of exp(-x) for 0 <= x <= 1: an alternating series ends above and below its sum."""
    total, term = F(0), F(1)
    for n in range(1, 20):
        total += term
        term *= -x / n
    return Interval(min(total, total + term), max(total, total + term))


def monotone(f, pole):
    """The range of a function that grows or falls over the poles, of its bounds at both ends."""
    ends = [f(pole.low), f(pole.high)]
    return Interval(min(e.low for e in ends), max(e.high for e in ends)).rounded()


def entries(gain, pole):
    """The entries that depend on the motor, over its box: all are monotone in the pole.

    stay = exp(-p T); of a duty that acts for a time t the rate gets 1 - exp(-p t) and the angle
    t - (1 - exp(-p t))/p, each times K; what acted first is the whole less what acted last.
    """
    late = PERIOD - DELAY
    stay = monotone(lambda p: exp_minus(p * PERIOD), pole)
    travel = monotone(lambda p: (1 - exp_minus(p * PERIOD)) * (1 / p), pole)
    new_rate = monotone(lambda p: 1 - exp_minus(p * late), pole)
    # (1 - exp(-p D)) exp(-p (T - D)): its derivative has one sign as p T < 1.
    old_rate = monotone(lambda p: exp_minus(p * late) - exp_minus(p * PERIOD), pole)
    new_angle = monotone(lambda p: late - (1 - exp_minus(p * late)) * (1 / p), pole)
    old_angle = monotone(
        lambda p: DELAY - (exp_minus(p * late) - exp_minus(p * PERIOD)) * (1 / p), pole
    )
    return [stay, travel] + [
        (x * gain).rounded() for x in (new_rate, old_rate, new_angle, old_angle)
    ]


def matrices(gains, motor):
    """A, B, C for one choice of the entries; `gains` are P, Kp, Ki, Kaw, alpha."""
    position, proportional, integral, anti_windup, alpha = gains
    stay, travel, new_rate, old_rate, new_angle, old_angle = motor
    h = [F(0), F(0), F(0), alpha / PERIOD, 1 - alpha, F(0)]
    error = [-position * (i == 0) - h[i] for i in range(STATES)]
    v = [proportional * error[i] + (i == 5) for i in range(STATES)]
    angle = [travel * (i == 1) + old_angle * (i == 2) + new_angle * v[i] for i in range(STATES)]
    a = [
        [(i == 0) + angle[i] for i in range(STATES)],
        [stay * (i == 1) + old_rate * (i == 2) + new_rate * v[i] for i in range(STATES)],
        v,
        angle,
        h,
        [(i == 5) + PERIOD * integral * error[i] for i in range(STATES)],
    ]
    b = [new_angle, new_rate, F(1), new_angle, F(0), PERIOD * anti_windup]
    return a, b, v


def vertices(box):
    """All corners of a box of intervals."""
    corners = [[]]
    for interval in box:
        ends = {interval.low, interval.high}
        corners = [corner + [end] for corner in corners for end in sorted(ends)]
    return corners
