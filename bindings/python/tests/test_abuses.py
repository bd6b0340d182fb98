"""Abuses of the package by seed: each raises an exception that names what is wrong."""

import random
import time

import numpy as np
import pytest

import smart_actuator as sa

gymnasium = pytest.importorskip("gymnasium")
pytest.importorskip("control")
pytest.importorskip("jax")

from smart_actuator.gymnasium import ActuatorEnv, ActuatorVectorEnv, posterior  # noqa: E402
from smart_actuator.jax import response  # noqa: E402

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

#: Values that are no mapping of names to numbers: those that are false as well.
NO_MAPPING = [0, False, "", "a", [], [1], (), object(), np.zeros(0), {1: 1.0}, {"x": "a"}]
#: Values that are no flag.
NO_FLAG = [None, 0, 1, "", "yes", [], object()]

MODEL = [*NO_TEXT, None, "", "bord", "Board", "grey_box", "\udc80", "a\0b", "x" * 500]
SEED = [-1, 1.5, 2**64, "1", NAN, [], None]
THREADS = [0, -1, 1.5, "1", NAN, [], 2**31, 2**62, 2**64]
PARAMETER = [*NO_NUMBER, NAN, INF, -INF, -1.0, 1e9, 10**400]

#: Of each function the arguments with values that it refuses.
RUN = {
    "model": MODEL,
    "plant": [*NO_TEXT, "", "table", "Bench"],
    "preset": [*NO_TEXT, "", "paperr", "paper", np.zeros(3), "\udc80"],
    "input": [*NO_TEXT, "", "step"],
    "input_parameters": [*NO_MAPPING, {"amp": 1.0}, {"amplitude_deg": "5"}, {"amplitude_deg": NAN}],
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
NAMED = [*NO_MAPPING, 5, "gain", {"x": 1.0}, {"gain": "1"}, {"gain": NAN}, {1: 1.0}]
WINDOW = [3, "ab", (1.0,), (2.0, 1.0), (NAN, 1.0), ("a", "b"), (1e3, 2e3), [], ["ab"], [(2.0, 1.0)]]
WINDOW += [[(1.0,)], [(1e3, 2e3)], [None, None], [{}], [(0.0, 1.0), 3], [[(0.0, 1.0)]], np.zeros((2, 2))]
KNOWN = [*NO_MAPPING, {"pendulum_mass_kg": "1"}, {"x": 1.0}, {"gain": NAN}, {"gain": INF}, [{"x": 1.0}]]
KNOWN += [[{"gain": NAN}], [{}, {}], [None, 5], [(1.0, 2.0)], ["gain"], [[{}]], [{"gain": "1"}]]
IDENTIFY = {
    "data": DATA,
    # None are needed, and a model predicts one that does not move.
    "validate": [DATA[0], DATA[1], *DATA[4:11], *DATA[12:]],
    "models": [5, None, [], {}, "", "black-box", ["x"], [5], b"black-box-1"],
    "fix": [*NAMED, {"pole_rad_s": -1.0}],
    "free": [5, None, "x", ["x"], [5]],
    "bound": [5, "gain", {"x": (0.0, 1.0)}, {"gain": 1.0}, {"gain": (2.0, 1.0)}, {"gain": (NAN, 1)}],
    "start": NAMED,
    "own": [5, "x", [5]],
    "share": [5, "x", [5]],
    "starts": [0, -1, 1001, 1.5, "1", None, NAN],
    "seed": SEED,
    "loss": [5, "", "huber", None],
    "columns": [5, "a", {"length": "1"}, {"angle": "none"}, {"angle": 5}, {"angle": "angle_deg:mile"}],
    "delimiter": [5, "", ";", "semi"],
    "keep_clipped": NO_FLAG,
    "keep_bad": NO_FLAG,
    "window": WINDOW,
    "hold": [5, "", "ramp"],
    "known": KNOWN,
    "threads": THREADS,
    "progress": ["yes", 5, []],
    "modles": ["black-box-1"],
}
ROWS = [5, "a", None, [], [[0.0]], [0.0, INF, 1.0], [0.0, 1.0], object()]
SENSITIVITY = {
    "model": [*NO_TEXT, None, "", "board", "motor-m1"],
    "time_s": [*ROWS, [1.0, 0.5, 0.2], [NAN, 1.0, 2.0]],
    "command_deg": [*ROWS, [1e300] * 3],
    "progress": ["yes", 5, []],
    "by": [5, None, ["x"], [5], "pole_rad_s", [NAN]],
    "duty_pct": [5, "a", [1.0], [[1.0, 1.0, 1.0]]],
    "pole_rad_s": [*NO_NUMBER, NAN, -1.0, 1e9],
    "position_gain": [1.0],
}
STEP = {
    "input": [*NO_TEXT, None, "", "torque", "\udc80"],
    "command_deg": [*NO_NUMBER, NAN, INF, 1e308, -40000.0],
    "seconds": [*(v for v in NO_NUMBER if v is not None), NAN, INF, -0.1, 1e8],
    "ticks": [-1, 1.5, "1", NAN, 2**64, 2**63],
    "second": [1.0],
}


#: A model that is fitted to it.
FITTED = sa.identify(GOOD, models="black-box-1", starts=1)["models"][0]
COUNT = [0, -1, 1.5, "1", NAN, [], 2**31, 2**62, 2**64]
BATCH = {
    "parameters": [*(v for v in NO_MAPPING if v is not None), {}, {"P": []}, {"Q": [1.0]}, {"P": ["a"]}],
    "count": COUNT,
    "step_s": [*NO_NUMBER, NAN, INF, 0.0, -0.02, 1e-5, 1e9],
    "threads": THREADS,
    **{name: RUN[name] for name in ("model", "plant", "preset", "seed", "P", "no_such_name")},
}
COMMANDS = [None, 5.0, [], [1.0], ["1", "2"], [None, 1.0], [1j, 1.0], np.ma.array([1.0, 2.0], mask=[0, 1])]
REPLACED = {
    "indices": [None, 5, [3], [-1], [0.5], [NAN], [1j], ["0"], [0, 0], [[0]], [2**62], object()],
    "parameters": [*NO_MAPPING, None, {}, {"Ki": [1.0]}, {"P": [1.0, 2.0]}, {"P": [NAN]}],
    "seed": SEED,
}
VECTOR = {
    "num_envs": COUNT,
    "randomise": [0, False, "", [], {}, 5],
    "amplitude_deg": [*NO_NUMBER, NAN, INF, 0.0, -1.0, 1e9],
    "steps": [0, -1, 1.5, "1", NAN, INF, []],
    "step_s": [NAN, 0.0, "1", []],
    "jump": [*NO_NUMBER, NAN, INF, -0.1, 1.1],
    "threads": THREADS,
    "model": MODEL,
    "no_such_name": [1.0],
}
ACTIONS = [None, "1", [NAN, 0.0], [INF, 0.0], [1.0], [[0.0], [0.0], [0.0]], [1j, 0.0], object()]
POSTERIOR = {
    "fitted": [None, 5, "", [], {}, {"model": "black-box-1"}, np.zeros(3), object()],
    "widen": [*NO_NUMBER, NAN, INF, -1.0, 1e300],
    "only": [5, "pole_rad_s", ["x"], [5], ["position_limit_deg"]],
}
#: Models that the simulator does not have.
NOT_SIMULATED = ["motor-m1", "black-box-2-oscillator", "board", 5, None]
FITS = [*POSTERIOR["fitted"], *({**FITTED, "model": each} for each in NOT_SIMULATED)]
CONTROL = {
    "model": [*NO_TEXT, None, "", "bord", "motor-m1"],
    "preset": RUN["preset"],
    "loop": [*NO_TEXT, None, "", "opened"],
    "pade": [-1, 1.5, "1", NAN, None, 21, 2**31, 2**62],
    "P": PARAMETER,
    "no_such_name": [1.0],
}
JAX = {
    "model": [*NO_TEXT, None, "", "board", "motor-m1"],
    "time_s": [5, "a", None, [[0.0]], [0.0, INF], [1.0, 0.5], object()],
    "by": [5, None, "pole_rad_s", ["x"], [5]],
    "pole_rad_s": [*NO_NUMBER, NAN, -1.0, 1e9],
}


def batch(**words):
    default = {} if {"parameters", "count"} & set(words) else {"count": 2}
    return sa.ActuatorBatch(**default, **words)


def replace(**words):
    several = sa.ActuatorBatch({"P": [7.0, 8.0, 9.0]})
    several.replace(**{"indices": [1], "parameters": {"P": [7.5]}, **words})


def vector(**words):
    environments = ActuatorVectorEnv(**{"num_envs": 2, **words})
    environments.reset(seed=1)
    environments.step(np.zeros((environments.num_envs, 1)))


def acted(**words):
    environments = ActuatorVectorEnv(2)
    environments.reset(seed=words.get("seed", 0))
    environments.step(words.get("actions", np.zeros((2, 1))))


def one(**words):
    environment = ActuatorEnv()
    environment.reset(seed=0)
    environment.step(words.get("action", np.zeros(1)))


def drawn(**words):
    sampler = posterior(**{"fitted": FITTED, **words})
    return sampler(np.random.default_rng(0), 3)


def differentiable(**words):
    return response(**{"model": "black-box-1", "time_s": [0.0, 0.1, 0.2], **words})


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
    (monte_carlo, {**RUN, "parameters": SWEEP, "threads": THREADS}),
    (sa.Actuator, ACTUATOR),
    (identify, IDENTIFY),
    (sensitivity, SENSITIVITY),
    (advance, STEP),
    (advance_to, {"command_deg": STEP["command_deg"], "time_s": [None, *STEP["seconds"]]}),
    (batch, BATCH),
    (lambda **w: sa.ActuatorBatch(count=2).step(w.get("commands", [1.0, 2.0])), {"commands": COMMANDS}),
    (replace, REPLACED),
    (vector, VECTOR),
    (acted, {"actions": ACTIONS, "seed": [-1, 1.5, "1", [], [1], (1, 2, 3)]}),
    (one, {"action": [NAN, INF, [1.0, 2.0], "1", None]}),
    (drawn, POSTERIOR),
    (lambda **w: sa.fitted_parameters(**{"model": FITTED, **w}), {"model": FITS}),
    (sa.to_control, CONTROL),
    (differentiable, JAX),
    (lambda **w: sa.Actuator().place(w.get("angle_deg", 1.0)), {"angle_deg": [*NO_NUMBER, NAN, INF, 1e9]}),
    (lambda **w: sa.parameters(**w), {"model": MODEL, "plant": [5, "", "table"]}),
    (lambda **w: sa.Actuator(plant="bench").set_load_torque(w["nm"]), {"nm": [*NO_NUMBER, NAN, 1e3]}),
    (
        lambda **w: sa.Actuator(plant="bench").set_load_inertia(w["inertia_kg_m2"]),
        {"inertia_kg_m2": [*NO_NUMBER, NAN, INF, -1.0]},
    ),
    (lambda **w: sa.Actuator().restore(w["state"]), {"state": [None, "", b"", b"abcd", 5, bytes(999)]}),
]
ALL = [(f, name, value) for f, names in CALLS for name, values in names.items() for value in values]


@pytest.mark.parametrize("seed", range(400))
def test_an_abuse_is_refused_with_a_reason(seed):
    call, name, value = random.Random(seed).choice(ALL)
    began = time.monotonic()
    with pytest.raises((ValueError, TypeError, KeyError, OSError)) as raised:
        call(**{name: value})
    assert time.monotonic() - began < 5.0
    message = str(raised.value)
    assert 0 < len(message) < 2000, message
    reasons = ("expected", name, "cannot read", "No such file", "Is a directory", "not a snapshot")
    assert any(text in message for text in reasons), message


def test_without_an_abuse_each_call_succeeds():
    for call, _ in CALLS[:17]:
        call()
    assert len(ALL) > 800


def test_an_actuator_that_has_moved_is_not_placed():
    servo = sa.Actuator()
    servo.advance(5.0, ticks=1)
    with pytest.raises(ValueError, match="expected a place before the first step"):
        servo.place(10.0)


def test_a_file_is_named_once(tmp_path):
    path = tmp_path / "run.csv"
    path.write_text("time_s,command_deg,angle_deg\n0,0,0\n")
    with pytest.raises(ValueError, match="is fitted twice"):
        sa.identify([path, tmp_path / "." / "run.csv"], models="black-box-1")
    with pytest.raises(ValueError, match="validates and is there already"):
        sa.identify(path, validate=path, models="black-box-1")
