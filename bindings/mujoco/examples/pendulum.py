"""A pendulum on the servo: what MuJoCo's joint does, and what the board measures and drives.

    python pendulum.py --plugin libsmart_actuator.so --out pendulum.svg
"""

import argparse
import os

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import mujoco
import numpy as np

MODEL = """
<mujoco>
  <option timestep="0.001"/>
  <extension>
    <plugin plugin="smart_actuator.servo"><instance name="servo"/></plugin>
    <plugin plugin="smart_actuator.readings">
      <instance name="board"><config key="servo" value="servo"/></instance>
    </plugin>
  </extension>
  <worldbody>
    <body>
      <joint name="hinge" axis="0 1 0"/>
      <geom type="capsule" fromto="0 0 0 0 0 -0.1" size="0.005" mass="0.01"/>
      <geom type="sphere" pos="0 0 -0.1" size="0.02" mass="0.1"/>
    </body>
  </worldbody>
  <actuator><plugin joint="hinge" plugin="smart_actuator.servo" instance="servo"/></actuator>
  <sensor><plugin plugin="smart_actuator.readings" instance="board"/></sensor>
</mujoco>
"""
COMMANDS_DEG = [0, 60, -90, 135, 0]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--plugin", default=os.environ.get("ACTUATOR_PLUGIN", ""))
    parser.add_argument("--out", default="pendulum.svg")
    arguments = parser.parse_args()
    mujoco.mj_loadPluginLibrary(arguments.plugin)
    model = mujoco.MjModel.from_xml_string(MODEL)
    data = mujoco.MjData(model)
    rows = []
    for command_deg in COMMANDS_DEG:
        data.ctrl[0] = np.radians(command_deg)
        for _ in range(1500):
            mujoco.mj_step(model, data)
            board = data.sensordata
            rows.append((command_deg, np.degrees(data.qpos[0]), board[3], board[6]))
    command, angle, duty, current = np.array(rows).T
    time_s = np.arange(len(rows)) * model.opt.timestep
    figure, axes = plt.subplots(3, 1, sharex=True, figsize=(7, 6), layout="constrained")
    axes[0].plot(time_s, command, "k--", lw=0.8, label="command")
    axes[0].plot(time_s, angle, label="joint")
    axes[0].set_ylabel("angle, deg")
    axes[0].legend()
    axes[1].plot(time_s, duty)
    axes[1].set_ylabel("duty, %")
    axes[2].plot(time_s, current)
    axes[2].set(ylabel="current, A", xlabel="time, s")
    figure.savefig(arguments.out)
    print(f"{arguments.out}: {angle[-1]:.2f} deg at the end, expected 0 within a count and the play")


if __name__ == "__main__":
    main()
