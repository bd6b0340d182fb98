"""An arm of six servos draws a circle, computed by MuJoCo's own Jacobian.

    python arm.py --plugin libsmart_actuator.so --out arm.svg
"""

import argparse
import os

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import mujoco
import numpy as np

AXES = ["0 0 1", "0 1 0", "0 1 0", "1 0 0", "0 1 0", "0 0 1"]
LENGTHS_M = [0.05, 0.12, 0.12, 0.05, 0.05, 0.04]
# Lower than those of the board, which are for a servo without a load: with the inertia of the arm
# behind the backlash of the gears the loops would hunt.
GAINS = "proportional_gain 0.3 integral_gain 2 position_gain 5"
START = np.array([0.0, 0.5, 1.0, 0.0, 0.6, 0.0])
RADIUS_M, PERIOD_S, SECONDS = 0.04, 4.0, 10.0


def model():
    # One instance for all six, which have the same parameters.
    servos = f'<instance name="s"><config key="parameters" value="{GAINS}"/></instance>'
    bodies, base = "", 0.05
    for i, (axis, length) in enumerate(zip(AXES, LENGTHS_M)):
        bodies += (
            f'<body pos="0 0 {base}"><joint name="j{i}" axis="{axis}" armature="2e-4"/>'
            f'<geom type="capsule" fromto="0 0 0 0 0 {length}" size=".012" mass=".04"/>'
        )
        base = length
    bodies += f'<site name="tip" pos="0 0 {base}"/>' + "</body>" * 6
    actuators = "".join(
        f'<plugin joint="j{i}" plugin="smart_actuator.servo" instance="s"/>' for i in range(6)
    )
    return mujoco.MjModel.from_xml_string(f"""
        <mujoco><option timestep="0.001"><flag contact="disable"/></option>
        <extension><plugin plugin="smart_actuator.servo">{servos}</plugin></extension>
        <worldbody>{bodies}</worldbody><actuator>{actuators}</actuator></mujoco>""")


def target(start, time_s):
    """A circle in the plane across the arm, which begins at its start."""
    phase = 2 * np.pi * time_s / PERIOD_S
    return start + RADIUS_M * np.array([0.0, np.sin(phase), np.cos(phase) - 1.0])


def follow(plan, jacobian, joints, target_xyz):
    """Joint angles nearer to a place of the tip: damped least squares, without servos."""
    plan_model, plan_data = plan
    for _ in range(5):
        plan_data.qpos[:] = joints
        mujoco.mj_kinematics(plan_model, plan_data)
        mujoco.mj_comPos(plan_model, plan_data)
        mujoco.mj_jacSite(plan_model, plan_data, jacobian, None, 0)
        error = target_xyz - plan_data.site_xpos[0]
        damped = jacobian @ jacobian.T + 1e-6 * np.eye(3)
        joints = joints + jacobian.T @ np.linalg.solve(damped, error)
    return joints


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--plugin", default=os.environ.get("ACTUATOR_PLUGIN", ""))
    parser.add_argument("--out", default="arm.svg")
    arguments = parser.parse_args()
    mujoco.mj_loadPluginLibrary(arguments.plugin)
    arm = model()
    data, plan = mujoco.MjData(arm), mujoco.MjData(arm)
    data.qpos[:] = joints = START
    mujoco.mj_forward(arm, data)
    start, jacobian = data.site_xpos[0].copy(), np.zeros((3, 6))
    rows = []
    for step in range(round(SECONDS / arm.opt.timestep)):
        target_xyz = target(start, data.time)
        # The host of the paper commands every 20 ms.
        if step % 20 == 0:
            joints = follow((arm, plan), jacobian, joints, target_xyz)
            data.ctrl[:] = joints
        mujoco.mj_step(arm, data)
        rows.append(np.r_[data.time, target_xyz, data.site_xpos[0], data.actuator_force])
    rows = np.array(rows)
    error_mm = 1e3 * np.linalg.norm(rows[:, 1:4] - rows[:, 4:7], axis=1)
    figure, axes = plt.subplots(1, 2, figsize=(9, 4), layout="constrained")
    axes[0].plot(1e3 * rows[:, 2], 1e3 * rows[:, 3], "k--", lw=0.8, label="command")
    axes[0].plot(1e3 * rows[:, 5], 1e3 * rows[:, 6], label="tip")
    axes[0].set(xlabel="y, mm", ylabel="z, mm", aspect="equal", title="path of the tip")
    axes[0].legend()
    axes[1].plot(rows[:, 0], rows[:, 7:])
    axes[1].set(xlabel="time, s", ylabel="torque of the servos, Nm", title="six servos")
    figure.savefig(arguments.out)
    print(f"{arguments.out}: the tip is {error_mm[2000:].mean():.1f} mm off on average")


if __name__ == "__main__":
    main()
