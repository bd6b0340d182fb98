"""One instance of the plugin may be several servos."""

import mujoco
import native
import numpy as np
import pytest
from models import MEASURED_ANGLE, arm, link, shared
from test_exact import DEG
from test_state import run


@pytest.mark.parametrize("plant", ["bench", "first-order"])
def test_servos_of_one_instance_move_as_those_of_their_own_instances(plant):
    paths = [
        run(model, mujoco.MjData(model), 400)
        for model in (arm(is_shared=True, plant=plant), arm(plant=plant))
    ]
    assert np.array_equal(*paths)


@pytest.mark.parametrize("plant", ["bench", "first-order"])
def test_the_state_of_an_instance_is_that_of_all_its_servos(plant):
    model = arm(is_shared=True, plant=plant)
    first, second = mujoco.MjData(model), mujoco.MjData(model)
    run(model, first, 300)
    run(model, second, 50, seed=4)
    mujoco.mj_copyData(second, model, first)
    assert np.array_equal(run(model, first, 200, seed=1), run(model, second, 200, seed=1))
    mujoco.mj_resetData(model, first)
    again = mujoco.MjData(model)
    assert np.array_equal(run(model, first, 200), run(model, again, 200))


def test_the_servos_of_an_instance_have_different_noise():
    model = arm(is_shared=True, parameters="delay_s 0 encoder_noise_deg 1", plant="first-order")
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 40)
    assert len(np.unique(data.sensordata.reshape(6, 8)[:, MEASURED_ANGLE])) > 3


def test_the_short_name_is_the_same_plugin():
    xml = """<mujoco><option gravity="0 0 0"/>{}<worldbody><body><joint name="j0" axis="0 1 0"/>
        <inertial pos="0 0 0" mass="1" diaginertia=".001 .001 .001"/></body></worldbody>{}</mujoco>"""
    names = [("sas", "sar"), ("smart_actuator.servo", "smart_actuator.readings")]
    models = [mujoco.MjModel.from_xml_string(xml.format(*shared(1, *name))) for name in names]
    assert np.array_equal(*(run(model, mujoco.MjData(model), 300) for model in models))


def test_servos_beside_an_actuator_with_two_inputs_have_their_own_commands():
    instances, moved = shared(2, plant="first-order")
    bodies = "".join(
        f'<body><joint name="j{i}" axis="0 1 0"/><inertial pos="0 0 0" mass="1" '
        'diaginertia=".001 .001 .001"/></body>'
        for i in range(3)
    )
    motor = '<actuator><dcmotor joint="j2" motorconst="1" resistance="8" input="pos vel" '
    motor += 'controller="1 0 1"/>'
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option gravity="0 0 0" timestep="0.001"/>{instances}<worldbody>{bodies}'
        f"</worldbody>{moved.replace('<actuator>', motor)}</mujoco>"
    )
    data = mujoco.MjData(model)
    boards = [native.Actuator("first-order", delay_s=0.0) for _ in range(2)]
    commands = [0.7, -0.4]
    data.ctrl[-2:] = commands
    assert model.nu == 4 and model.nactuator == 3
    for _ in range(500):
        mujoco.mj_step(model, data)
        expected = [
            board.advance(DEG * command, 20)[5] for board, command in zip(boards, commands)
        ]
    mujoco.mj_forward(model, data)
    assert np.array_equal(data.sensordata.reshape(2, 8)[:, MEASURED_ANGLE], expected)


def test_an_instance_without_actuators_is_refused():
    instances, _ = shared(1)
    with pytest.raises(ValueError, match="expected an actuator"):
        mujoco.MjModel.from_xml_string(f"<mujoco>{instances}</mujoco>")


def test_unloaded_servos_move_an_arm_exactly_as_their_boards():
    model = arm(is_shared=True, plant="first-order")
    data = mujoco.MjData(model)
    boards = [native.Actuator("first-order", delay_s=0.0) for _ in range(6)]
    rng = np.random.default_rng(2)
    for i in range(2000):
        if i % 200 == 0:
            data.ctrl[:] = rng.uniform(-1, 1, 6)
        mujoco.mj_step(model, data)
        expected = [
            board.advance(DEG * command, 20)[2] for board, command in zip(boards, data.ctrl)
        ]
        assert np.degrees(data.qpos) == pytest.approx(expected, abs=1e-9)


def test_the_sensor_has_eight_elements_for_each_servo():
    assert link().nsensordata == 8
    assert arm(is_shared=True).nsensordata == 48
