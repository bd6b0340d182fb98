"""Checks the certificates of `certificates.json` in exact rational arithmetic.

Usage: verify.py TRACE [FILE]; TRACE is the output of the program `trace`, which has the presets.
Each certificate is a matrix P, a multiplier t and a sector for a cell of the box of motors. For
every corner of the cell's entries the matrix

    P - A'PA           A'PB - t C'
    (A'PB - t C')'     2 t/sector - B'PB

has to be positive definite. It is a constant less (A, -B)'P(A, -B) and so concave in A and B, and C
is the same for all motors: the corners decide for the cell. Then state' P state falls in every step
in which the limit takes away between nothing and the share `sector` of the duty wanted.
"""

import json
import sys
from fractions import Fraction as F

from loop import STATES, Interval, entries, matrices, vertices


def is_positive_definite(matrix):
    """By elimination: all pivots are positive."""
    m, n = [row[:] for row in matrix], len(matrix)
    for i in range(n):
        if m[i][i] <= 0:
            return False
        for j in range(i + 1, n):
            if m[j][i] == 0:
                continue
            factor = m[j][i] / m[i][i]
            for k in range(i, n):
                m[j][k] -= factor * m[i][k]
    return True


def decrease(p, t, sector, a, b, c):
    """The matrix that has to be positive definite."""
    n = range(STATES)
    pa = [[sum(p[i][k] * a[k][j] for k in n) for j in n] for i in n]
    pb = [sum(p[i][k] * b[k] for k in n) for i in n]
    m = [[p[i][j] - sum(a[k][i] * pa[k][j] for k in n) for j in n] for i in n]
    cross = [sum(a[k][i] * pb[k] for k in n) - t * c[i] for i in n]
    corner = 2 * t / sector - sum(b[k] * pb[k] for k in n)
    return [m[i] + [cross[i]] for i in n] + [cross + [corner]]


def motors(certificate, steady):
    """The box of entries of a cell. `steady` are the steady rates per duty in both directions:
    between them the loop may change at any step, so that one cell has both."""
    factor, pole = ([F(x) for x in certificate[name]] for name in ("factor", "pole"))
    return entries(Interval(factor[0] * min(steady), factor[1] * max(steady)), Interval(*pole))


def holds(certificate, gains, steady):
    """Whether a certificate holds for its whole cell."""
    p = [[F(x) / F(certificate["scale"]) for x in row] for row in certificate["p"]]
    if any(p[i][j] != p[j][i] for i in range(STATES) for j in range(STATES)):
        return False
    t, sector = F(certificate["t"]) / F(certificate["scale"]), F(certificate["sector"])
    if t <= 0 or not 0 < sector <= 1 or not is_positive_definite(p):
        return False
    return all(
        is_positive_definite(decrease(p, t, sector, *matrices(gains, corner)))
        for corner in vertices(motors(certificate, steady))
    )


def covers(cells, factor, pole):
    """Whether cells cover a box: each of the rectangles between all their ends lies within one."""
    factors = sorted({F(end) for cell in cells for end in cell["factor"]} | set(factor))
    poles = sorted({F(end) for cell in cells for end in cell["pole"]} | set(pole))
    for f in zip(factors, factors[1:]):
        for p in zip(poles, poles[1:]):
            if f[1] <= factor[0] or f[0] >= factor[1] or p[1] <= pole[0] or p[0] >= pole[1]:
                continue
            within = lambda inner, outer: F(outer[0]) <= inner[0] and inner[1] <= F(outer[1])
            if not any(within(f, cell["factor"]) and within(p, cell["pole"]) for cell in cells):
                return False
    return True


def region(certificate, gains, steady, duty_limit):
    """The greatest step of the angle from rest, deg, for which the limit takes away no more than
    the sector from then on: with |v| <= limit/(1 - sector) all over the ellipsoid through the step.
    """
    p = [[F(x) / F(certificate["scale"]) for x in row] for row in certificate["p"]]
    sector = F(certificate["sector"])
    if sector == 1:
        return None
    c = matrices(gains, vertices(motors(certificate, steady))[0])[2]
    # c' P^-1 c by solving P y = c.
    n = range(STATES)
    m = [p[i][:] + [c[i]] for i in n]
    for i in n:
        for j in n:
            if j != i:
                factor = m[j][i] / m[i][i]
                m[j] = [x - factor * y for x, y in zip(m[j], m[i])]
    y = [m[i][STATES] / m[i][i] for i in n]
    level = (duty_limit / (1 - sector)) ** 2 / sum(c[i] * y[i] for i in n)
    return float(level / p[0][0]) ** 0.5


def follows(gains, steady, pole, angles):
    """The greatest difference, in counts, between the loop of the code and this model of it, which
    has no encoder: both are given a step from rest that no limit acts on."""
    box = entries(Interval(steady[0]), Interval(pole))
    a, _, _ = matrices(gains, [interval.middle for interval in box])
    a = [[float(x) for x in row] for row in a]
    held, *angles = angles
    state, worst = [-held, 0.0, 0.0, 0.0, 0.0, 0.0], 0.0
    for angle in angles:
        state = [sum(x * y for x, y in zip(row, state)) for row in a]
        worst = max(worst, abs(state[0] + held - angle))
    return worst / (360 / 4096)


def loop_of(values):
    """Gains, steady rates and pole of a preset."""
    names = (
        "position_gain",
        "proportional_gain",
        "integral_gain",
        "anti_windup_gain",
        "rate_filter",
    )
    steady = values["motor_gain_up"], values["motor_gain_down"]
    return [values[name] for name in names], steady, 1 / values["motor_time_constant_s"]


def main(trace, file):
    presets, motions = {}, {}
    for line in open(trace):
        parts = line.split()
        if parts and parts[0] == "motion":
            motions[parts[1]] = [float(x) for x in parts[2:]]
        if parts and parts[0] == "preset" and parts[3] != "inf":
            presets.setdefault(parts[1], {})[parts[2]] = F(parts[3])
    document = json.load(open(file))
    for name, angles in motions.items():
        values = presets[name]
        gains, steady, pole = loop_of(values)
        counts = follows(gains, steady, pole, angles)
        # What the encoder hides. Another delay of the duty, of 3 ms, is 0.57 counts off.
        assert counts <= 0.5, f"{name}: the model is {counts:.2f} counts off the code"
        print(f"{name}: the model follows the code within {counts:.2f} counts")
    for loop in document["loops"]:
        values = presets[loop["preset"]]
        gains, steady, pole = loop_of(values)
        low, high = (F(x) for x in document["spread"])
        # Gain and supply multiply to the steady rate, pole and inertia to the pole.
        cells = loop["cells"]
        assert covers(
            cells, (low**2, high**2), (pole * low / high, pole * high / low)
        ), f"{loop['preset']}: the cells leave motors out"
        for cell in cells:
            assert holds(
                cell, gains, steady
            ), f"{loop['preset']}: no certificate for {cell['factor']}, {cell['pole']}"
        # Planted: each has to be refused.
        assert not holds(
            dict(cells[0], t="-" + cells[0]["t"]), gains, steady
        ), "a negative multiplier is taken"
        assert not holds(
            cells[0], gains, [4 * x for x in steady]
        ), "a motor four times as strong is taken"
        assert not covers(
            cells[1:], (low**2, high**2), (pole * low / high, pole * high / low)
        ), "a gap is not seen"
        least = min(region(cell, gains, steady, values["duty_limit_pct"]) for cell in cells)
        print(f"{loop['preset']}: {len(cells)} certificates hold; steps up to {least:.1f} deg")


if __name__ == "__main__":
    import pathlib

    default = pathlib.Path(__file__).with_name("certificates.json")
    main(sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else default)
