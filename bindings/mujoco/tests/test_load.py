"""What acts on a joint acts on the motor, and the reverse."""

import os
import pathlib
import subprocess

import mujoco
import numpy as np
import pytest
from models import ANGLE, CURRENT, DUTY, arm, link, pendulum


def settle(model, data, command, seconds):
    data.ctrl[:] = command
    mujoco.mj_step(model, data, round(seconds / model.opt.timestep))


def test_the_servo_carries_the_weight_of_a_pendulum():
    model = pendulum()
    data = mujoco.MjData(model)
    settle(model, data, 1.2, 2.0)
    forces, angles, currents = [], [], []
    for _ in range(2000):
        mujoco.mj_step(model, data)
        forces.append(data.actuator_force[0])
        angles.append(data.qpos[0])
        currents.append(data.sensordata[CURRENT])
    weight = 0.2 * 9.80665 * 0.1 * np.sin(np.mean(angles))
    # The mean of two seconds, in which the loop hunts around a count: its momentum of
    # 0.002 kg m^2 x 0.1 rad/s is a ten-thousandth of the impulse of the weight.
    assert np.mean(forces) == pytest.approx(weight, rel=1e-3)
    # 1.158 Nm/A: friction of up to 0.03 Nm and what the load adds to it carry the rest.
    assert 0.05 < np.mean(currents) * 1.158 < 0.25


def test_an_applied_torque_slows_the_motor_as_that_of_the_native_bench_does():
    rates = []
    for torque in (0.0, -0.2):
        model = link(input="duty")
        data = mujoco.MjData(model)
        data.qfrc_applied[0] = torque
        # Five time constants, and before the stop at 180 deg.
        settle(model, data, 60.0, 0.7)
        before = data.qpos[0]
        settle(model, data, 60.0, 0.2)
        rates.append((data.qpos[0] - before) / 0.2)
    # Slope of rate over torque: R/(n k)^2 and viscous friction, 1/0.1763 rad/s/Nm; the friction of
    # the gears does not depend on the load in this model.
    assert rates[0] - rates[1] == pytest.approx(0.2 / 0.1763, rel=0.02)


def test_a_stop_of_mujoco_blocks_the_shaft_and_the_board_measures_it():
    model = link(joint='limited="true" range="-30 30"', option='gravity="0 0 0"')
    data = mujoco.MjData(model)
    settle(model, data, 1.2, 1.5)
    # MuJoCo's limit yields by 0.9 Nm over its stiffness; gears and shaft by 1 deg/(Nm/76 Nm/rad).
    assert 29.5 < np.degrees(data.qpos[0]) < 31.5
    assert 29.5 < data.sensordata[ANGLE] < 32.5
    assert data.sensordata[DUTY] == 100.0
    # The stall current, 6 V/7.7 ohm.
    assert data.sensordata[CURRENT] == pytest.approx(6 / 7.7, rel=0.02)
    assert data.actuator_force[0] == pytest.approx(0.9, rel=0.05)


def path_of_an_arm(timestep):
    """Angles after eight commands at random, every 20 ms, deg, and the last deviations, deg."""
    model = arm(timestep=timestep, mass=0.05)
    data = mujoco.MjData(model)
    rng = np.random.default_rng(0)
    path = []
    for _ in range(8):
        command = rng.uniform(-0.8, 0.8, 6)
        for _ in range(35):
            settle(model, data, command, 0.02)
            path.append(np.degrees(data.qpos))
    return np.array(path), np.degrees(data.qpos - command)


def test_an_arm_of_six_joints_follows_and_converges_with_the_step():
    paths, ends = zip(*(path_of_an_arm(timestep) for timestep in (0.001, 0.0005, 0.00025)))
    # 0.7 s after steps of up to 92 deg the integrator has not settled under the weight of the arm:
    # up to 2.2 deg in 60 paths whose starts differ by 1e-9 rad.
    assert np.abs(ends).max() < 4.0
    # All joints move in the first 0.1 s: half the step gives half the error of a method of first
    # order, here at most two thirds of it.
    coarse, fine = (np.abs(a[:5] - b[:5]).max() for a, b in zip(paths, paths[1:]))
    assert 0 < fine < coarse * 2 / 3 and coarse < 0.05
    # Later the loops hunt around a count with a phase that 1e-9 rad at the start changes (and so
    # does the processor): two paths of one step then differ by up to 0.18 deg in the mean.
    for path in paths[1:]:
        assert np.abs(path - paths[0]).mean() < 0.36


def test_an_arm_that_hits_the_floor_stays_where_it_is():
    model = arm(floor=True)
    data = mujoco.MjData(model)
    settle(model, data, [0, 1.9, 0.3, 0, 0, 0], 4.0)
    assert data.ncon > 0
    assert np.abs(data.qvel).max() < 1.0
    assert data.actuator_force == pytest.approx(np.clip(data.actuator_force, -2, 2))


def test_a_step_that_is_too_long_for_an_arm_is_reported(capfd):
    model = arm(timestep=0.004)
    mujoco.mj_step(model, mujoco.MjData(model))
    assert "shorten the timestep" in capfd.readouterr().err


@pytest.mark.parametrize(
    "message, attributes",
    [
        ("model", {"model": "bord"}),
        ("position_gain", {"parameters": "position_gain -1"}),
        ("postion_gain", {"parameters": "postion_gain 1"}),
        ("expected a number", {"parameters": "position_gain one"}),
        ("names and values", {"parameters": "position_gain"}),
        ("expected position, rate", {"input": "torque"}),
        ("whole number", {"seed": "-1"}),
        ("whole number", {"seed": "1.5"}),
        ("preset", {"preset": "none-such"}),
        ("integrator", {"option": 'integrator="RK4"'}),
        ("gear", {"actuator": 'gear="0"'}),
    ],
)
def test_a_configuration_that_cannot_be_simulated_is_refused(message, attributes):
    with pytest.raises(ValueError, match=message):
        link(**attributes)


def test_a_gear_turns_servo_and_joint_in_proportion():
    model = link(actuator='gear="2"', option='gravity="0 0 0"')
    data = mujoco.MjData(model)
    settle(model, data, 1.0, 1.5)
    assert abs(2 * data.qpos[0] - 1.0) < 0.004


def test_what_the_program_writes_is_a_servo_with_its_parameters(tmp_path):
    (tmp_path / "fitted.toml").write_text(
        'model = "board"\nplant = "bench"\n[set]\nsupply_v = 3.0\ndelay_s = 0.0\n'
    )
    subprocess.run(
        [os.environ["ACTUATOR"], "mujoco", "--parameters", "fitted.toml", "--joint", "hinge"]
        + ["--out", "servo.xml"],
        cwd=tmp_path,
        check=True,
    )
    (tmp_path / "model.xml").write_text(
        '<mujoco><include file="servo.xml"/><worldbody><body><joint name="hinge" axis="0 1 0"/>'
        '<geom size="0.01"/></body></worldbody></mujoco>'
    )
    model = mujoco.MjModel.from_xml_path(str(pathlib.Path(tmp_path) / "model.xml"))
    data = mujoco.MjData(model)
    settle(model, data, 3.0, 0.7)
    # Half of the rate of 6 V, 283.6 deg/s.
    assert 120 < np.degrees(data.qvel[0]) < 142
