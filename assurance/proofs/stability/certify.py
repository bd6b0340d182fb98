"""Finds the certificates that verify.py checks, and writes them.

Usage: certify.py TRACE FILE. Needs cvxpy and clarabel; nothing here is trusted. A cell for which no
certificate is found is divided, along its wider side; one that has become too small is reported.
"""

import json
import sys
from fractions import Fraction as F

import cvxpy
import numpy as np

from loop import STATES, matrices, vertices
from verify import holds, motors

SPREAD = F(7, 10), F(13, 10)
SCALE = 10**9
# Shares of the wanted duty that the limit may take away, the widest first.
SECTORS = [F(n, 100) for n in (90, 75, 60, 30)]
PRESETS = ["consistent", "as-measured-retuned"]


def scaled(matrix, by):
    return np.array([[float(x) for x in row] for row in matrix]) * by


def solve(gains, box, sector):
    """P and t for a cell, in units in which the states are of a size; `None` without a solution."""
    # Sizes of error, rate, duty, travel, filtered rate and integrator in a motion.
    size = np.array([10.0, 100.0, 50.0, 0.4, 100.0, 50.0])
    p = cvxpy.Variable((STATES, STATES), symmetric=True)
    t = cvxpy.Variable()
    margin = 1e-6
    limits = [p >> np.eye(STATES) * 1e-3, cvxpy.trace(p) <= 1e3, t >= 1e-6]
    for corner in vertices(box):
        a, b, c = matrices(gains, corner)
        a = np.array([[float(x) for x in row] for row in a]) * size[None, :] / size[:, None]
        b = (np.array([float(x) for x in b]) / size)[:, None] * 50.0
        c = (np.array([float(x) for x in c]) * size)[:, None] / 50.0
        cross = a.T @ p @ b - t * c
        corner_block = cvxpy.reshape(2 * t / float(sector), (1, 1), order="C") - b.T @ p @ b
        block = cvxpy.bmat([[p - a.T @ p @ a, cross], [cross.T, corner_block]])
        limits.append(block >> margin * np.eye(STATES + 1))
    # The greatest step: least weight of the angle's error against the duty that is wanted.
    problem = cvxpy.Problem(cvxpy.Minimize(p[0, 0]), limits)
    try:
        problem.solve(solver=cvxpy.CLARABEL)
    except cvxpy.SolverError:
        return None
    if p.value is None:
        return None
    value = p.value / size[:, None] / size[None, :]
    value = (value + value.T) / 2
    factor = 1 / value.max()
    return (value * factor).tolist(), float(t.value) * factor / 2500.0


def certificate(gains, steady, factor, pole):
    cell = {"factor": [str(x) for x in factor], "pole": [str(x) for x in pole]}
    for sector in SECTORS:
        found = solve(gains, motors(cell, steady), sector)
        if found is None:
            continue
        p, t = found
        entry = {
            **cell,
            "sector": str(sector),
            "scale": str(SCALE**2),
            "t": str(round(t * SCALE**2)),
            "p": [[str(round(x * SCALE**2)) for x in row] for row in p],
        }
        if holds(entry, gains, steady):
            return entry
    return None


def between(low, high, parts):
    """Ends of so many parts of the same ratio."""
    inner = [
        F(round(float(low) * (float(high / low)) ** (i / parts) * 1000), 1000)
        for i in range(1, parts)
    ]
    ends = [low, *inner, high]
    return list(zip(ends, ends[1:]))


def divide(gains, steady, factor, pole, depth, cells, lost):
    found = certificate(gains, steady, factor, pole)
    if found:
        print(
            f"  {shown(factor, pole)} sector {found['sector']}",
            flush=True,
        )
        cells.append(found)
    elif depth == 0:
        print(
            f"  LOST {shown(factor, pole)}",
            flush=True,
        )
        lost.append([list(map(float, factor)), list(map(float, pole))])
    else:
        halves = lambda ends: [(ends[0], middle(ends)), (middle(ends), ends[1])]
        if factor[1] / factor[0] > pole[1] / pole[0]:
            parts = [(f, pole) for f in halves(factor)]
        else:
            parts = [(factor, p) for p in halves(pole)]
        for f, p in parts:
            divide(gains, steady, f, p, depth - 1, cells, lost)


def shown(factor, pole):
    return " ".join(f"{float(ends[0]):.3f}..{float(ends[1]):.3f}" for ends in (factor, pole))


def middle(ends):
    return F(round(float(ends[0] * ends[1]) ** 0.5 * 1000), 1000)


def main(trace, file, only="", depth=4):
    presets = {}
    for line in open(trace):
        parts = line.split()
        if parts and parts[0] == "preset" and parts[3] != "inf":
            presets.setdefault(parts[1], {})[parts[2]] = F(parts[3])
    loops = []
    for preset in [only] if only else PRESETS:
        values = presets[preset]
        gains = [
            values[n]
            for n in (
                "position_gain",
                "proportional_gain",
                "integral_gain",
                "anti_windup_gain",
                "rate_filter",
            )
        ]
        pole = 1 / values["motor_time_constant_s"]
        steady = values["motor_gain_up"], values["motor_gain_down"]
        cells, lost = [], []
        print(preset, flush=True)
        for factor in between(SPREAD[0] ** 2, SPREAD[1] ** 2, 5):
            for part in between(pole * SPREAD[0] / SPREAD[1], pole * SPREAD[1] / SPREAD[0], 5):
                divide(gains, steady, factor, part, int(depth), cells, lost)
        if not lost:
            loops.append({"preset": preset, "cells": cells})
    write(file, loops)


def write(file, loops):
    """One certificate a line."""
    cells = lambda loop: ",\n".join(json.dumps(cell) for cell in loop["cells"])
    listed = ",\n".join(
        f'{{"preset": "{loop["preset"]}", "cells": [\n{cells(loop)}\n]}}' for loop in loops
    )
    with open(file, "w") as out:
        out.write(
            f'{{"spread": {json.dumps([str(x) for x in SPREAD])}, "loops": [\n{listed}\n]}}\n'
        )


if __name__ == "__main__":
    main(*sys.argv[1:])
