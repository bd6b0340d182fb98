#!/usr/bin/env python3
"""Our fits against scipy.optimize.least_squares on the same model, data and start.

    python3 identification/benches/against_scipy.py [PROGRAM]

PROGRAM is the example `fit_speed`; without it, it is built. Needs numpy, scipy and a C compiler.
scipy gets the model compiled (exact between limits, `rivals.c`) and, for black box 1, in Python. All run in this one run on this one machine; each number is the best
of several. Fails where an optimum differs in the first six digits or a ratio falls short.
"""
import ctypes
import json
import math
import pathlib
import subprocess
import sys
import tempfile
import time

import numpy as np
from scipy.optimize import least_squares

HERE = pathlib.Path(__file__).parent
DIGITS = 1e-6
LEAST_RATIO = {"compiled": 10.0, "Python": 100.0}
LOWEST = {"delay_s": 0.0, "gain": -20.0, "offset_deg": -32000.0}


def lag(y, target, h, pole, up, down):
    limit = up if target > y else -down
    reach, far = limit / pole, target - y
    if abs(far) > abs(reach):
        t = (far - reach) / limit
        if t >= h:
            return y + limit * h
        y += limit * t
        h -= t
    return target - (target - y) * math.exp(-pole * h)


def black_box_1(p, time_s, step_t, step, first):
    """Black box 1 as `rivals.c` has it, line by line."""
    pole, delay, up, down, gain, offset = p
    x, now, target, j = 0.0, time_s[0], gain * first + offset, 0
    y = np.empty(len(time_s))
    for i, t in enumerate(time_s):
        while j < len(step_t) and step_t[j] + delay <= t:
            x = lag(x, target, step_t[j] + delay - now, pole, up, down)
            now = step_t[j] + delay
            target = gain * step[j] + offset
            j += 1
        x = lag(x, target, t - now, pole, up, down)
        now = t
        y[i] = x
    return y


def compiled(directory):
    """The rivals as functions of parameters and recording."""
    library = directory / "rivals.so"
    subprocess.run(
        ["cc", "-O3", "-march=native", "-ffast-math", "-shared", "-fPIC", "-o", library,
         HERE / "rivals.c", "-lm"], check=True)
    library = ctypes.CDLL(str(library))
    pointer = ctypes.POINTER(ctypes.c_double)

    def function(name):
        raw = getattr(library, name)
        raw.restype = None
        raw.argtypes = [pointer, ctypes.c_int, pointer, ctypes.c_int, pointer, pointer,
                        ctypes.c_double, pointer]

        def simulate(p, time_s, step_t, step, first):
            y = np.empty(len(time_s))
            at = lambda a: a.ctypes.data_as(pointer)
            p = np.ascontiguousarray(p)
            raw(at(p), len(time_s), at(time_s), len(step_t), at(step_t), at(step), first, at(y))
            return y
        return simulate
    models = ["black-box-1", "black-box-2", "grey-box"]
    return {model: function(model.replace("-", "_")) for model in models}


def fit(simulate, data, start, names, fixed, repeats):
    """scipy's optimum and the time of the best of several fits, ms."""
    time_s, command, angle = (np.ascontiguousarray(c) for c in data.T)
    jumps = np.flatnonzero(np.diff(command)) + 1
    step_t, step = time_s[jumps].copy(), command[jumps].copy()
    low = [LOWEST.get(name, 1e-3) for name in names]
    fixed = np.array(fixed)

    def residual(p):
        # Fixed parameters follow the estimated ones.
        p = np.concatenate([p, fixed]) if len(fixed) else p
        return simulate(p, time_s, step_t, step, command[0]) - angle
    best = math.inf
    for _ in range(repeats):
        began = time.perf_counter()
        found = least_squares(
            residual, start,
            bounds=(low, np.inf), x_scale="jac", ftol=1e-12, xtol=1e-12, gtol=1e-12)
        best = min(best, (time.perf_counter() - began) * 1e3)
    return found, best


def main():
    failures = 0
    with tempfile.TemporaryDirectory() as directory:
        directory = pathlib.Path(directory)
        program = sys.argv[1:2] or ["cargo", "run", "--quiet", "--release", "-p", "identification",
                                    "--example", "fit_speed", "--"]
        ours = subprocess.run([*program, str(directory)], check=True, capture_output=True, text=True)
        fast = compiled(directory)
        print(f"{'model':12} {'rival':9} {'ours ms':>9} {'scipy ms':>9} {'ratio':>7} {'worst digit':>12}")
        for line in ours.stdout.splitlines():
            own = json.loads(line)
            if own["model"] not in fast or not own["file"]:
                print(f"{own['model']:12} {'-':9} {own['ms']:9.3f}   ({own['samples']} samples)")
                continue
            data = np.loadtxt(directory / own["file"], delimiter=",", skiprows=1)
            names = [p["name"] for p in own["parameters"]]
            start = np.array([p["start"] for p in own["parameters"]])
            rivals = [("compiled", fast[own["model"]], 7)]
            if own["model"] == "black-box-1":
                rivals.append(("Python", black_box_1, 3))
            for rival, simulate, repeats in rivals:
                found, ms = fit(simulate, data, start, names, own["fixed"], repeats)
                mine = np.array([p["estimate"] for p in own["parameters"]])
                # An offset near zero counts in degrees.
                worst = np.max(np.abs(mine - found.x) / np.maximum(np.abs(found.x), 1e-2))
                ratio = ms / own["ms"]
                is_good = worst < DIGITS and ratio >= LEAST_RATIO[rival]
                failures += not is_good
                mark = "" if is_good else "  FAILS"
                print(f"{own['model']:12} {rival:9} {own['ms']:9.3f} {ms:9.3f} {ratio:7.1f} {worst:12.1e}{mark}")
                if found.cost < own["cost"] * (1 - 1e-9):
                    failures += 1
                    print(f"  scipy's cost is lower: {found.cost} against {own['cost']}")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
