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


def test_a_loop_that_the_model_does_not_have_is_refused():
    with pytest.raises(ValueError, match="expected closed of black-box-1"):
        sa.to_control("black-box-1", loop="rate")
