"""Searches for the optimum of a cost."""

import time

import cma
from mujoco import minimize
import numpy as np
from scipy.optimize import least_squares

import smart_actuator as sa
from recordings import DEG

SEED = 1
TOOLS = ["this program", "scipy", "MuJoCo", "CMA-ES"]


def search_by_cma(cost, start, low, high, evaluations):
    """CMA-ES with restarts of growing populations; the best point."""
    scaled = (np.asarray(start) - low) / (high - low)
    best, best_cost, used, size = None, np.inf, 0, 24
    while used < evaluations:
        options = {"bounds": [0, 1], "seed": SEED + used, "verbose": -9, "popsize": size}
        search = cma.CMAEvolutionStrategy(np.clip(scaled, 0.02, 0.98), 0.25, options)
        while not search.stop() and used < evaluations:
            points = search.ask()
            search.tell(points, list(cost(low + np.array(points) * (high - low))))
            used += len(points)
        if search.result.fbest < best_cost:
            best, best_cost = low + search.result.xbest * (high - low), search.result.fbest
        size *= 2
        scaled = np.random.default_rng(SEED + used).uniform(0.1, 0.9, len(low))
    return best


def optima(evaluations, runs):
    """The same model, recording and cost by several searches: rows of model, recording, and rms and time by tool."""
    of_servo = [run for run in runs if run.servo and run.is_on.all()]
    pairs = [(model, run) for run in of_servo[:1] for model in ("black-box-2", "servo-m1")]
    return [(model, run, optima_of(model, run, evaluations)) for model, run in pairs]


def optima_of(model, run, evaluations):
    goal_deg, angle_deg = run.goal * DEG, run.angle * DEG
    data = {"time_s": run.time_s, "command_deg": goal_deg, "angle_deg": angle_deg}
    known = {"pendulum_mass_kg": run.log["mass"], "pendulum_length_m": run.log["length"]}
    known = {**known, "supply_v": run.log["vin"]} if model == "servo-m1" else {}
    begun = time.perf_counter()
    fit = sa.identify(data, models=model, fix=known, hold="zero", loss="squares")["models"][0]
    took = time.perf_counter() - begun
    rows = [(fit["experiments"][0]["quality"]["rms_deg"], took)]
    fixed = {
        p["name"]: p["estimate"]
        for p in fit["parameters"]
        if p["fixed"] and p["estimate"] is not None
    }
    free = [p for p in fit["parameters"] if not p["fixed"]]
    names = [p["name"] for p in free]
    found = np.array([p["estimate"] for p in free])
    limits = np.array([[-np.inf if end is None else end for end in p["bounds"]] for p in free])
    # The others get more than this program: a box, and a start within a factor of 2.
    reach = 8 * np.maximum(np.abs(found), 1e-3)
    low = np.where(limits[:, 0] < 0, -reach, np.maximum(limits[:, 0], found / 8))
    high = np.minimum(np.where(limits[:, 1] > 0, limits[:, 1], np.inf), reach)
    factors = 2.0 ** np.random.default_rng(SEED).uniform(-1, 1, len(free))
    start = np.clip(found * factors, low + 1e-3 * (high - low), high - 1e-3 * (high - low))

    def residuals(x):
        values = {**fixed, **dict(zip(names, map(float, x)))}
        return sa.sensitivity(model, run.time_s, goal_deg, [], **values)[0] - angle_deg

    rms = lambda x: float(np.sqrt(np.mean(residuals(x) ** 2)))
    for tool in TOOLS[1:]:
        begun = time.perf_counter()
        if tool == "scipy":
            best = least_squares(residuals, start, bounds=(low, high), x_scale="jac").x
        elif tool == "MuJoCo":
            many = lambda x: np.array([residuals(point) for point in np.atleast_2d(x.T)]).T
            bounds = [low[:, None], high[:, None]]
            best = np.ravel(
                minimize.least_squares(start[:, None], many, bounds, verbose=0, x_scale="jac")[0]
            )
        else:
            cost = lambda sets: [rms(x) for x in sets]
            best = search_by_cma(cost, start, low, high, evaluations)
        took = time.perf_counter() - begun
        rows.append((rms(best), took))
    return rows
