"""Whether the intervals of estimates hold for other data of the same servo."""

from itertools import combinations

import numpy as np

import smart_actuator as sa
from plain import Lag

#: Standard errors of a difference within which 95 % of the pairs are.
AGREES = 2.0
MODELS = ("black-box-1", "black-box-2", "servo-m1")


def of_program(run, model, window):
    """Estimates with standard errors by name, of what is called identifiable."""
    options = {} if window is None else {"window": window}
    try:
        found = sa.identify(run.path, models=model, **options)["models"][0]
    # The motor is off in that half.
    except ValueError:
        return {}
    error = lambda p: max(p["standard_error"] or 0.0, p["standard_error_coloured"] or 0.0)
    return {
        p["name"]: (p["estimate"], error(p))
        for p in found["parameters"]
        # Start and rate of a run are its own.
        if not p["fixed"] and p["identifiable"] and error(p) and not p["name"].startswith("initial_")
    }


def of_lag(run, _, window):
    part = slice(None)
    if window is not None:
        part = (run.time_s >= window[0]) & (run.time_s <= window[1])
    values, errors = Lag().search([run], [part])
    return {name: pair for name, pair in zip(Lag.NAMES, zip(values, errors)) if pair[1] > 0}


def agreeing(pairs):
    """The number of estimates in both of each pair, and how many agree."""
    apart = [
        abs(a[name][0] - b[name][0]) / np.hypot(a[name][1], b[name][1])
        for a, b in pairs
        for name in a.keys() & b.keys()
    ]
    return len(apart), int(np.sum(np.array(apart) <= AGREES))


def coverage(runs):
    """Rows of tool, and the pairs of halves and of recordings with how many of them agree."""
    tools = [("first-order lag", of_lag, None)]
    tools += [(model, of_program, model) for model in MODELS]
    if not all(run.servo for run in runs):
        tools = tools[:-1]
    for name, estimate, model in tools:
        halves = [[estimate(run, model, window) for window in run.halves()] for run in runs]
        whole = [estimate(run, model, None) for run in runs]
        yield name, *agreeing(halves), *agreeing(combinations(whole, 2))
