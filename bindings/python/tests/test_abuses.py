"""Abuses of the package by seed: each raises an exception that names what is wrong."""

import random

import numpy as np
import pytest

import smart_actuator as sa

NAN, INF = float("nan"), float("inf")

#: Values that are no number.
NO_NUMBER = ["1", "", None, [], {}, 1j, object(), b"1", np.array([1.0, 2.0])]
#: Values that are no text.
NO_TEXT = [1, 1.5, b"board", [], ("board",), object()]
#: Values that are no table of times and values.
NO_POINTS = [5, "ab", [], [1.0], ([0.0], [1.0], [2.0]), ([0.0], ["x"]), ([0.0], [1j])]
NO_POINTS += [([NAN], [1.0]), ([0.0], [NAN]), ([0.0], [INF]), ([-1.0], [0.0]), ([1.0, 0.5], [1, 2])]
NO_POINTS += [([0.0, 1.0], [1.0]), ([], []), ([[0.0]], [[1.0]]), ([0.0], [1e6]), ([1e9], [0.0])]
NO_POINTS += [{"time_s": [0.0]}, {"t": [0.0], "u": [1.0]}, {}, np.zeros((3, 3)), object()]

MODEL = [*NO_TEXT, None, "", "bord", "Board", "grey_box"]
SEED = [-1, 1.5, 2**64, "1", NAN, [], None]
PARAMETER = [*NO_NUMBER, NAN, INF, -INF, -1.0, 1e9, 10**400]

#: Of each function the arguments with values that it refuses.
RUN = {
    "model": MODEL,
    "plant": [*NO_TEXT, "", "table", "Bench"],
    "preset": [*NO_TEXT, "", "paperr", "paper"],
    "input": [*NO_TEXT, "", "step"],
    "input_parameters": [5, "a", [1], {"amp": 1.0}, {"amplitude_deg": "5"}, {"amplitude_deg": NAN}],
    "command": NO_POINTS,
    "load": [*NO_POINTS, ([0.0], [0.1])],
    "duration": [*(v for v in NO_NUMBER if v is not None), NAN, INF, 0.0, -1.0, 1e8],
    "every": [0, -1, 1.5, "1", NAN, 2**64, None, []],
    "seed": SEED,
    "pwm": [*NO_TEXT, None, "", "on", "Switched"],
    "position_gain": PARAMETER,
    "P": PARAMETER,
    "postion_gain": [1.0],
    "no_such_name": [1.0],
}
SWEEP = [5, [1.0], "P", {}, {1: [1.0]}, {"Q": [1.0]}, {"P": ["a"]}, {"P": [NAN]}, {"P": [-1.0]}]
SWEEP += [{"P": [1.0, 2.0], "Ki": [1.0, 2.0, 3.0]}, {"input.x": [1.0]}, {"P": None}, None]


def run():
    return {"time_s": np.arange(100) * 0.01, "command_deg": np.ones(100), "angle_deg": np.ones(100)}


#: A recording that can be identified.
GOOD = dict(sa.simulate("black-box-1", every=400))
GOOD = {name: GOOD[name] for name in ("time_s", "command_deg", "angle_deg")}
DATA = [5, None, [], {}, object(), "", "none.csv", ".", b"x", [GOOD, 7], {"time_s": [0.0]}, run()]
DATA += [{**GOOD, "time_s": -GOOD["time_s"]}, {**GOOD, "time_s": "x"}, {**GOOD, "angle_deg": 1.0}]
DATA += [{**GOOD, "angle_deg": [1.0]}, {**GOOD, "angle_deg": GOOD["angle_deg"] * NAN}]
DATA += [{**GOOD, "angle_deg": GOOD["angle_deg"] + INF}, {**GOOD, "command_deg": [[1.0]]}, np.ones(3)]
DATA += [{**GOOD, 5: GOOD["time_s"]}, {name: column[:3] for name, column in GOOD.items()}]
NAMED = [5, "gain", {"x": 1.0}, {"gain": "1"}, {"gain": NAN}, {1: 1.0}]
IDENTIFY = {
    "data": DATA,
    # None are needed, and a model predicts one that does not move.
    "validate": [DATA[0], DATA[1], *DATA[4:11], *DATA[12:]],
    "models": [5, None, "", "black-box", ["x"], [5], b"black-box-1"],
    "fix": [*NAMED, {"pole_rad_s": -1.0}],
    "free": [5, "x", ["x"], [5]],
    "bound": [5, "gain", {"x": (0.0, 1.0)}, {"gain": 1.0}, {"gain": (2.0, 1.0)}, {"gain": (NAN, 1)}],
    "start": NAMED,
    "own": [5, "x", [5]],
    "share": [5, "x", [5]],
    "starts": [0, -1, 1001, 1.5, "1", None, NAN],
    "seed": SEED,
    "loss": [5, "", "huber", None],
    "columns": [5, "a", {"length": "1"}, {"angle": "none"}, {"angle": 5}, {"angle": "angle_deg:mile"}],
    "delimiter": [5, "", ";", "semi"],
    "window": [3, "ab", (1.0,), (2.0, 1.0), (NAN, 1.0), ("a", "b"), (1e3, 2e3)],
    "hold": [5, "", "ramp"],
    "known": [5, "a", {"pendulum_mass_kg": "1"}, {5: 1.0}],
    "threads": [0, -1, 1.5, "1"],
    "progress": ["yes", 5, []],
    "modles": ["black-box-1"],
}
ROWS = [5, "a", None, [], [[0.0]], [0.0, INF, 1.0], [0.0, 1.0], object()]
SENSITIVITY = {
    "model": [*NO_TEXT, None, "", "board", "motor-m1"],
    "time_s": [*ROWS, [1.0, 0.5, 0.2], [NAN, 1.0, 2.0]],
    "command_deg": [*ROWS, [1e300] * 3],
    "by": [5, None, ["x"], [5], "pole_rad_s", [NAN]],
    "duty_pct": [5, "a", [1.0], [[1.0, 1.0, 1.0]]],
    "pole_rad_s": [*NO_NUMBER, NAN, -1.0, 1e9],
    "position_gain": [1.0],
}
STEP = {
    "command_deg": [*NO_NUMBER, NAN, INF, 1e308, -40000.0],
    "seconds": [*(v for v in NO_NUMBER if v is not None), NAN, INF, -0.1, 1e8],
    "ticks": [-1, 1.5, "1", NAN, 2**64, 2**63],
    "second": [1.0],
}


def identify(**words):
    words = {"data": GOOD, "models": "black-box-1", "starts": 1, **words}
    return sa.identify(words.pop("data"), **words)


def sensitivity(**words):
    words = {"model": "black-box-1", "by": ["pole_rad_s", "command_deg"], **words}
    times, commands = words.pop("time_s", [0.0, 0.1, 0.2]), words.pop("command_deg", [0.0, 1.0, 1.0])
    return sa.sensitivity(words.pop("model"), times, commands, words.pop("by"), **words)


def advance(**words):
    step = {"command_deg": 1.0, **words}
    if not {"ticks", "seconds", "second"} & set(step):
        step["ticks"] = 1
    return sa.Actuator().advance(step.pop("command_deg"), **step)


def monte_carlo(**words):
    return sa.monte_carlo(words.pop("parameters", {"P": [8.0]}), **{"duration": 0.01, **words})


def simulate(**words):
    return sa.simulate(**{"duration": 0.01, **words})


def advance_to(**words):
    return sa.Actuator().advance_to(words.get("command_deg", 1.0), words.get("time_s", 0.1))


ACTUATOR = {name: RUN[name] for name in ("model", "plant", "preset", "seed", "pwm", "P", "no_such_name")}
CALLS = [
    (simulate, {**RUN, "progress": ["yes", 5], "gradients": [5, "pole_rad_s", [5], ["x"]]}),
    (monte_carlo, {**RUN, "parameters": SWEEP, "threads": [0, -1, 1.5, "1", 10**5]}),
    (sa.Actuator, ACTUATOR),
    (identify, IDENTIFY),
    (sensitivity, SENSITIVITY),
    (advance, STEP),
    (advance_to, {"command_deg": STEP["command_deg"], "time_s": [None, *STEP["seconds"]]}),
    (lambda **w: sa.parameters(**w), {"model": MODEL, "plant": [5, "", "table"]}),
    (lambda **w: sa.Actuator(plant="bench").set_load_torque(w["nm"]), {"nm": [*NO_NUMBER, NAN, 1e3]}),
    (lambda **w: sa.Actuator().restore(w["state"]), {"state": [None, "", b"", b"abcd", 5, bytes(999)]}),
]
ALL = [(f, name, value) for f, names in CALLS for name, values in names.items() for value in values]


@pytest.mark.parametrize("seed", range(240))
def test_an_abuse_is_refused_with_a_reason(seed):
    call, name, value = random.Random(seed).choice(ALL)
    with pytest.raises((ValueError, TypeError, KeyError, OSError)) as raised:
        call(**{name: value})
    message = str(raised.value)
    assert 0 < len(message) < 2000, message


def test_without_an_abuse_each_call_succeeds():
    for call, _ in CALLS[:7]:
        call()
    assert len(ALL) > 400
