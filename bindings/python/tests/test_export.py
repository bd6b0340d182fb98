"""The exported actuators in their own simulators.

Each simulator responds to the validation input, to which the file is not fitted, as the file says:
its error against the model is the stated one. The numbers of a file have six digits, Newton has
single precision, and the rest of a digit is printed: 1 % of the error and 1e-3 deg are far above
all of them.
"""

import json
import os
import pathlib
import re
import subprocess

import numpy as np
import pytest

import smart_actuator as sa

MODELS = [("black-box-1", None), ("board", "bench")]


def validation(model, plant, step_s):
    """Command and angle of the model at the steps of a simulator, deg."""
    ticks = round(step_s / 50e-6)
    steps = {"scale": 20.0 / 120.0}
    trace = sa.simulate(model, plant=plant, input="variable-step", input_parameters=steps, every=1)
    # The command of the file changes at the steps of the simulator only.
    rows = np.arange(0, len(trace.time_s), ticks) if abs(ticks * 50e-6 - step_s) < 1e-12 else None
    if rows is None:
        count = int(trace.time_s[-1] / step_s) + 1
        rows = np.ceil(np.arange(count) * step_s / 50e-6 - 1e-6).astype(int)
    times, command = trace.time_s[rows], trace.command_deg[rows]
    held = sa.simulate(model, plant=plant, command=(times, command), duration=trace.time_s[-1], every=1)
    return command, np.interp(np.arange(len(rows)) * step_s, held.time_s, held.angle_deg)


def compare(to, model, plant, respond):
    found = sa.export(to, model, plant=plant)
    step_s = float(re.search(r"in steps of ([0-9.e-]+) s", found["text"])[1])
    step_s = {0.00833333: 1 / 120}.get(step_s, step_s)
    command, angle = validation(model, plant, step_s)
    error = np.sqrt(np.mean((respond(found["text"], command) - angle) ** 2))
    assert found["validation"] == "variable-step"
    assert error == pytest.approx(found["error_deg"], rel=0.01, abs=1e-3)


@pytest.mark.parametrize("model, plant", MODELS)
@pytest.mark.parametrize("to", ["mujoco-position", "mujoco-dcmotor"])
def test_mujoco(to, model, plant):
    mujoco = pytest.importorskip("mujoco")

    def respond(text, command):
        compiled = mujoco.MjModel.from_xml_string(text)
        compiled.opt.gravity = 0.0
        data, angles = mujoco.MjData(compiled), []
        for target in np.radians(command):
            angles.append(data.qpos[0])
            data.ctrl[0] = target
            mujoco.mj_step(compiled, data)
        return np.degrees(angles)

    compare(to, model, plant, respond)


@pytest.mark.parametrize("model, plant", MODELS)
def test_newton(model, plant):
    newton = pytest.importorskip("newton")
    pytest.importorskip("mujoco_warp")
    import warp

    def respond(text, command):
        names = {}
        exec(text, names)
        builder = newton.ModelBuilder(gravity=(0, 0, 0))
        link = builder.add_link(mass=1e-6, inertia=warp.mat33(1e-9 * np.eye(3, dtype=np.float32)))
        joint = builder.add_joint_revolute(-1, link, axis=(0, 0, 1), **names["SERVO"])
        builder.add_articulation([joint])
        built = builder.finalize(device="cpu")
        solver = newton.solvers.SolverMuJoCo(
            built, use_mujoco_cpu=True, integrator="implicitfast", disable_contacts=True
        )
        now, after, control, angles = built.state(), built.state(), built.control(), []
        delay = names["DELAY_STEPS"]
        for target in np.radians(np.concatenate([np.full(delay, command[0]), command])[: len(command)]):
            angles.append(now.joint_q.numpy()[0])
            control.joint_target_q.assign(np.array([target], np.float32))
            solver.step(now, after, control, None, 0.002)
            now, after = after, now
        return np.degrees(angles)

    compare("newton", model, plant, respond)


@pytest.mark.parametrize("model, plant", MODELS)
def test_jsbsim(model, plant, tmp_path):
    jsbsim = pytest.importorskip("jsbsim")
    aircraft = tmp_path / "aircraft" / "bench"
    aircraft.mkdir(parents=True)
    frame = """<fdm_config name="bench" version="2.0" release="ALPHA"><fileheader/>
        <metrics/><mass_balance><ixx>1</ixx><iyy>1</iyy><izz>1</izz><emptywt>1</emptywt></mass_balance>
        <ground_reactions/><propulsion/><aerodynamics/>%s</fdm_config>"""

    def respond(text, command):
        (aircraft / "bench.xml").write_text(frame % text)
        plane = jsbsim.FGFDMExec(str(tmp_path))
        plane.set_debug_level(0)
        plane.set_dt(1 / 120)
        assert plane.load_model("bench")
        plane.run_ic()
        angles = []
        for target in command:
            plane["servo/command-deg"] = target
            plane.run()
            angles.append(plane["servo/angle-deg"])
        return np.array(angles)

    compare("jsbsim", model, plant, respond)


@pytest.mark.parametrize("model, plant", MODELS)
def test_bam(model, plant, tmp_path):
    bam = pytest.importorskip("bam.model")
    from bam.simulate import Simulator

    def respond(text, command):
        file = tmp_path / "servo.json"
        file.write_text(text)
        servo = json.loads(text)
        log = {"dt": 0.002, "kp": servo["kp"], "vin": servo["vin"], "mass": 0, "arm_mass": 0, "length": 0}
        log["entries"] = [
            {"position": 0.0, "speed": 0.0, "goal_position": goal, "torque_enable": True}
            for goal in np.radians(command)
        ]
        simulator = Simulator(bam.load_model(str(file)))
        return np.degrees(simulator.rollout_log(log, simulate_control=True)[0])

    compare("bam", model, plant, respond)


def test_python_control():
    import control

    names = {}
    quick = {"rate_limit_up_deg_s": 1e5, "rate_limit_down_deg_s": 1e5, "delay_s": 0.0, "pole_rad_s": 17.0}
    exec(sa.export("python-control", "black-box-1", **quick)["text"], names)
    trace = sa.simulate("black-box-1", command=([0.0], [2.0]), duration=0.6, every=20, **quick)
    _, angle = control.step_response(names["servo"], trace.time_s)
    # The fit is within 1e-4 deg of the model, in steps and a sweep of ten times the amplitude.
    assert np.abs(2 * np.ravel(angle) - trace.angle_deg).max() < 1e-4


def test_what_is_lost_and_what_cannot_be_exported():
    assert "backlash" in sa.export("mujoco-position", plant="bench")["lost"]
    with pytest.raises(ValueError, match="matlab cannot represent this model"):
        sa.export("matlab", "black-box-1", input="variable-step")
    with pytest.raises(ValueError, match="expected mujoco-position"):
        sa.export("mujoco")


@pytest.mark.skipif("ACTUATOR" not in os.environ, reason="no program")
@pytest.mark.parametrize("name", ["m1", "m6"])
def test_a_servo_of_bam_moves_as_in_bam(name, tmp_path):
    bam = pytest.importorskip("bam.model")
    from bam.simulate import Simulator

    file = pathlib.Path(bam.__file__).parent / "params" / "mx64" / f"{name}.json"
    trace = tmp_path / "trace.csv"
    command = [os.environ["ACTUATOR"], "simulate", "--parameters", file, "--input", "3-2-1-1", "--csv", trace]
    subprocess.run(command, check=True)
    run = np.genfromtxt(trace, delimiter=",", names=True)
    log = {"dt": 0.001, "kp": 32, "vin": 15.0, "mass": 0, "arm_mass": 0, "length": 0}
    log["entries"] = [
        {"position": 0.0, "speed": 0.0, "goal_position": goal, "torque_enable": True}
        for goal in np.radians(run["command_deg"])
    ]
    expected = np.degrees(Simulator(bam.load_model(str(file))).rollout_log(log, simulate_control=True)[0])
    error = run["angle_deg"] - expected
    # The board controls every 4 ms from counts of 0.09 deg, BAM here every ms: that is 6 ms of
    # delay at most 400 deg/s, during a tenth of the run.
    assert np.sqrt(np.mean(error**2)) < 0.8
