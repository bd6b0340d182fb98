"""Inside mj_step the board measures what the native board measures."""

import mujoco
import native
import numpy as np
import pytest
from models import MEASURED_ANGLE, link

SECONDS = 60.0
#: Of the link, and of the default horn of the bench, kg m^2.
LINK, HORN = 0.001, 2e-6
#: MuJoCo's radian in degrees, as the plugin computes it.
DEG = 180.0 / 3.14159265358979323846


@pytest.mark.parametrize("timestep, ticks", [(0.001, 20), (0.0005, 10), (0.00015, 3)])
@pytest.mark.parametrize("plant", ["bench", "first-order"])
def test_all_encoder_counts_of_a_minute_are_those_of_the_native_board(plant, timestep, ticks):
    model = link(timestep, LINK, plant=plant, option='gravity="0 0 0"')
    data = mujoco.MjData(model)
    parameters = {"delay_s": 0.0}
    if plant == "bench":
        parameters["load_inertia_kg_m2"] = HORN + LINK
    board = native.Actuator(plant, **parameters)
    # A fifth of the time for the finest step, which would take long.
    steps = round(SECONDS / timestep / (5 if ticks == 3 else 1))
    hold = round(0.4 / timestep)
    commands = np.random.default_rng(1).uniform(-1.5, 1.5, steps // hold + 1)
    measured, expected = np.empty((2, steps))
    for i in range(steps):
        data.ctrl[0] = commands[i // hold]
        mujoco.mj_step(model, data)
        expected[i] = board.advance(DEG * data.ctrl[0], ticks)[5]
        # The sensor shows the state at the start of a step.
        measured[i] = data.sensordata[MEASURED_ANGLE]
    assert len(np.unique(expected)) > 500
    assert np.array_equal(measured[1:], expected[:-1])


@pytest.mark.parametrize("name, level", [("rate", 1.2), ("duty", 40.0), ("voltage", -2.5)])
def test_the_inputs_within_the_loops_drive_the_motor(name, level):
    model = link(input=name, option='gravity="0 0 0"')
    data = mujoco.MjData(model)
    data.ctrl[0] = level
    # Five time constants, and before the stop at 180 deg.
    mujoco.mj_step(model, data, 700)
    # 283.6 deg/s at full duty and 6 V without friction, which takes at most 10 deg/s.
    expected = {"rate": level * DEG, "duty": 2.836 * level, "voltage": 283.6 / 6 * level}[name]
    before = data.qpos[0]
    mujoco.mj_step(model, data, 200)
    assert abs((data.qpos[0] - before) * DEG / 0.2 - expected) < 11


def test_a_servo_starts_where_its_joint_is():
    model = link(option='gravity="0 0 0"')
    data = mujoco.MjData(model)
    data.qpos[0] = data.ctrl[0] = 1.0
    mujoco.mj_step(model, data, 1000)
    # Within an encoder count, 0.0015 rad, and half the backlash, 0.0009 rad.
    assert abs(data.qpos[0] - 1.0) < 0.0025
