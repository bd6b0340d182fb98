import json
import os
import subprocess

import numpy as np
import pytest

import smart_actuator as sa

control = pytest.importorskip("control")


@pytest.mark.parametrize("model", ["black-box-1", "black-box-2", "grey-box"])
def test_the_step_response_is_that_of_the_simulator_without_limits(model):
    system = sa.to_control(model)
    limits = {} if model == "grey-box" else {
        "rate_limit_up_deg_s": np.inf,
        "rate_limit_down_deg_s": np.inf,
    }
    trace = sa.simulate(model, command=([0.0], [2.0]), duration=0.6, every=20, **limits)
    _, angle = control.step_response(system, trace.time_s)
    # Of 2 deg; the solver of python-control interpolates to 1e-9.
    assert np.abs(2 * np.ravel(angle) - trace.angle_deg).max() < 1e-6


def test_the_margins_are_those_of_the_closed_form():
    # The zero of the regulator cancels the pole of the motor: 8 x 28.36/(s (s + 28.36)).
    gain_margin, phase_margin, _, crossover = control.margin(sa.to_control("grey-box", loop="open"))
    assert gain_margin == np.inf
    w = crossover
    assert abs(8 * 28.36 / (1j * w * (1j * w + 28.36))) == pytest.approx(1, rel=1e-6)
    assert phase_margin == pytest.approx(90 - np.degrees(np.arctan(w / 28.36)), abs=1e-4)
    with_delay = control.margin(sa.to_control("board", loop="open", pade=3))
    assert with_delay[1] < phase_margin - 2


#: rad/s.
FREQUENCIES = np.geomspace(0.1, 300.0, 40)


def assert_response(system, expected):
    found = np.array([complex(system(1j * w)) for w in FREQUENCIES])
    exact = np.array([expected(1j * w) for w in FREQUENCIES])
    assert np.abs(found / exact - 1).max() < 1e-9


def test_bode_of_every_loop_is_that_of_its_closed_form():
    assert_response(sa.to_control("black-box-1", pole_rad_s=17.0), lambda s: 17 / (s + 17))
    second = sa.to_control("black-box-2", position_gain_per_s2=300.0, rate_gain_per_s=25.0)
    assert_response(second, lambda s: 300 / (s**2 + 25 * s + 300))
    given = {"P": 6.0, "Kp": 0.9, "Ki": 12.0, "Kup": 2.5, "Kdn": 3.5, "tau": 0.09}
    motor = lambda s: 3.0 / (0.09 * s + 1)
    regulator = lambda s: 0.9 + 12 / s
    rate = lambda s: regulator(s) * motor(s) / (1 + regulator(s) * motor(s))
    opened = lambda s: 6 * rate(s) / s
    loops = {"motor": motor, "rate": rate, "open": opened, "closed": lambda s: opened(s) / (1 + opened(s))}
    for loop, expected in loops.items():
        assert_response(sa.to_control("grey-box", loop=loop, **given), expected)


def test_gain_margin_and_phase_margin_with_a_delay_are_those_of_the_closed_form():
    # The open loop is 8 x 28.36/(s (s + 28.36)); the sampled control delays it by 6 ms.
    found = control.margin(sa.to_control("board", loop="open", pade=6))
    lag = lambda w: np.pi / 2 + np.arctan(w / 28.36) + 0.006 * w
    low, high = 1.0, 400.0
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if lag(middle) < np.pi else (low, middle)
    gain_margin = low * abs(1j * low + 28.36) / (8 * 28.36)
    # The board's own parameters are those of the grey box to single precision; Pade of order 6.
    assert found[0] == pytest.approx(gain_margin, rel=1e-4)
    assert found[1] == pytest.approx(180 - np.degrees(lag(found[3])), abs=1e-3)


def test_a_loop_that_the_model_does_not_have_is_refused():
    with pytest.raises(ValueError, match="expected closed of black-box-1"):
        sa.to_control("black-box-1", loop="rate")


@pytest.mark.skipif("ACTUATOR" not in os.environ, reason="no program")
def test_the_code_of_a_tuning_has_its_margins(tmp_path):
    code, result = tmp_path / "loops.py", tmp_path / "result.json"
    subprocess.run([os.environ["ACTUATOR"], "tune", "--code", code, "--json", result], check=True)
    names, tuning = {}, json.loads(result.read_text())
    exec(code.read_text(), names)
    assert names["proportional_gain"] == tuning["gains"]["proportional_gain"]
    def at(margin):
        angle = 2j * np.pi * tuning[margin]["frequency_hz"] * names["period_s"]
        return tuning[margin]["value"], names["open_loop"](np.exp(angle))

    # Polynomials in z of poles near 1 lose some digits.
    phase_deg, value = at("phase_margin_deg")
    assert abs(value) == pytest.approx(1, abs=1e-5)
    assert np.degrees(np.angle(-value)) == pytest.approx(phase_deg, abs=1e-3)
    gain_db, value = at("gain_margin_db")
    assert -20 * np.log10(abs(value)) == pytest.approx(gain_db, abs=1e-3)
    assert names["closed_loop"](1 + 1e-9) == pytest.approx(1, abs=1e-4)
