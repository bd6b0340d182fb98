import numpy as np
import pytest

import smart_actuator as sa

STEP = (np.array([0.0, 0.1, 0.5]), np.array([0.0, 4.0, -3.0]))


def differences(model, name, value, relative=1e-5, **fixed):
    """Central differences of the simulator's trace."""
    step = relative * max(abs(value), 1e-3)
    ends = [
        sa.simulate(model, command=STEP, duration=0.9, every=20, **{**fixed, name: value + s})
        for s in (step, -step)
    ]
    return (ends[0].angle_deg - ends[1].angle_deg) / (2 * step)


@pytest.mark.parametrize(
    "model, name, value",
    [
        ("black-box-1", "pole_rad_s", 15.0),
        ("black-box-1", "gain", 0.9),
        ("black-box-1", "offset_deg", 0.4),
        ("black-box-2", "position_gain_per_s2", 300.0),
        ("black-box-2", "rate_gain_per_s", 25.0),
        ("grey-box", "position_gain", 7.0),
        ("grey-box", "proportional_gain", 1.2),
        ("grey-box", "integral_gain", 9.0),
        ("grey-box", "motor_time_constant_s", 0.12),
    ],
)
def test_derivatives_agree_with_differences_of_the_simulator_where_it_is_smooth(model, name, value):
    # Without active limits, and with a delay of a whole number of rows.
    fixed = {"delay_s": 0.02}
    if model != "grey-box":
        fixed.update(rate_limit_up_deg_s=np.inf, rate_limit_down_deg_s=np.inf)
    trace = sa.simulate(
        model, command=STEP, duration=0.9, every=20, gradients=[name], **{**fixed, name: value}
    )
    expected = differences(model, name, value, **fixed)
    scale = np.abs(expected).max()
    assert scale > 0
    assert np.abs(trace.gradients[name] - expected).max() < 1e-6 * scale


UNLIMITED = {"rate_limit_up_deg_s": np.inf, "rate_limit_down_deg_s": np.inf}


@pytest.mark.parametrize(
    "model, fixed", [("black-box-1", UNLIMITED), ("black-box-2", UNLIMITED), ("grey-box", {})]
)
def test_derivatives_by_the_command_agree_with_differences_of_the_simulator(model, fixed):
    # A delay that is no multiple of a row, a level that remains, and a command after the end.
    times, angles = np.array([0.0, 0.1, 0.2, 0.5, 2.0]), np.array([1.0, 4.0, 4.0, -3.0, 7.0])
    fixed = {"delay_s": 0.0175, "duration": 0.9, "every": 20, **fixed}
    trace = sa.simulate(model, command=(times, angles), gradients=["command_deg"], **fixed)
    found = trace.gradients["command_deg"]
    assert found.shape == (len(trace.time_s), 5)
    for k in range(5):
        # Without limits the response is linear: differences are exact for any step.
        step = 0.25 * (np.arange(5) == k)
        ends = [sa.simulate(model, command=(times, angles + s), **fixed) for s in (step, -step)]
        expected = (ends[0].angle_deg - ends[1].angle_deg) / 0.5
        assert np.abs(found[:, k] - expected).max() < 1e-6
    assert found[-1, :4].sum() == pytest.approx(1.0, abs=0.02) and not found[:, 4].any()


@pytest.mark.parametrize("model", ["black-box-2", "grey-box", "servo-m1"])
def test_derivatives_by_the_command_agree_with_differences_across_limits(model):
    times = np.arange(0.0, 0.6, 0.02)
    command = np.where(times < 0.3, 30.0, -20.0) + np.sin(9 * times)
    angle, slopes = sa.sensitivity(model, times, command, ["command_deg"])
    for k in (0, 7, 17):
        step = 1e-5 * (np.arange(len(times)) == k)
        ends = [sa.sensitivity(model, times, command + s, [])[0] for s in (step, -step)]
        expected = (ends[0] - ends[1]) / 2e-5
        assert np.abs(slopes["command_deg"][:, k] - expected).max() < 1e-6


def test_a_gradient_by_the_command_needs_one_with_a_row_for_each():
    with pytest.raises(ValueError, match="expected a `command`"):
        sa.simulate("black-box-1", gradients=["command_deg"])
    for times in ([0, 1e-3, 1], [0, 0.02, 0.02]):
        with pytest.raises(ValueError, match=f"command at {times[1]} s has no row|at 0.02 s has no"):
            sa.simulate("grey-box", command=(times, [1, 2, 3]), every=400, gradients=["command_deg"])
    with pytest.raises(ValueError, match="motor-m1 has no command"):
        sa.sensitivity("motor-m1", [0, 1], [0, 1], ["command_deg"], duty_pct=[0, 1])
    with pytest.raises(MemoryError, match="rows times"):
        rows = np.arange(20_000.0)
        sa.sensitivity("black-box-1", rows, rows % 7, ["command_deg"])


def test_derivatives_agree_with_differences_across_a_rate_limit():
    # The limit ends at an instant that depends on the parameter: its derivative is that of the
    # event.
    trace = sa.simulate(
        "black-box-1", command=([0.0], [60.0]), duration=1.0, gradients=["rate_limit_up_deg_s"]
    )
    ends = [
        sa.simulate("black-box-1", command=([0.0], [60.0]), duration=1.0, rate_limit_up_deg_s=v)
        for v in (240.01, 239.99)
    ]
    expected = (ends[0].angle_deg - ends[1].angle_deg) / 0.02
    # The simulator does not locate the event within a tick: 50 us x 240 deg/s x p dt of slope.
    assert np.abs(trace.gradients["rate_limit_up_deg_s"] - expected).max() < 1e-4


@pytest.mark.parametrize("model", ["servo-m1", "servo-m6"])
def test_derivatives_of_servos_with_friction_agree_with_their_own_differences(model):
    times = np.arange(0.0, 1.0, 0.005)
    command = 40 * np.sin(4 * times)
    # While it moves, friction is smooth.
    by = ["duty_per_error_pct_deg", "motor_inertia_kg_m2"]
    angle, slopes = sa.sensitivity(model, times, command, by)
    assert np.ptp(angle) > 10
    default = {"duty_per_error_pct_deg": 10.0}
    step = 1e-5
    ends = [
        sa.sensitivity(model, times, command, by, duty_per_error_pct_deg=default[by[0]] + s)[0]
        for s in (step, -step)
    ]
    expected = (ends[0] - ends[1]) / (2 * step)
    close = np.abs(slopes[by[0]] - expected) < 1e-4 * np.abs(expected).max() + 1e-9
    # Not at the instants at which it sticks.
    assert close.mean() > 0.9


def test_what_has_no_derivative_is_named():
    with pytest.raises(ValueError, match="`board` has no derivatives"):
        sa.simulate("board", gradients=["position_gain"])
    with pytest.raises(KeyError, match="no parameter `poll`"):
        sa.simulate("black-box-1", gradients=["poll"])
