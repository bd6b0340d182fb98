"""The plugin of MuJoCo in the wheel: its servo in MuJoCo is that of the package."""

import numpy as np
import pytest

import smart_actuator as sa

mujoco = pytest.importorskip("mujoco")

MODEL = """<mujoco><option timestep="0.001"/><extension>
  <plugin plugin="smart_actuator.servo"><instance name="s"><config key="model" value="black-box-2"/></instance></plugin>
  </extension><worldbody><body><joint name="j" axis="0 1 0"/><geom size="0.02"/></body></worldbody>
  <actuator><plugin joint="j" plugin="smart_actuator.servo" instance="s"/></actuator></mujoco>"""


def test_the_servo_of_the_plugin_moves_as_that_of_the_package():
    mujoco.mj_loadPluginLibrary(sa.mujoco_plugin())
    model = mujoco.MjModel.from_xml_string(MODEL)
    data, joint = mujoco.MjData(model), np.empty(600)
    for step in range(600):
        joint[step], data.ctrl[0] = np.degrees(data.qpos[0]), np.radians(40.0 * (step >= 100))
        mujoco.mj_step(model, data)
    trace = sa.simulate("black-box-2", command=([0.0, 0.1], [0.0, 40.0]), duration=0.6)
    assert joint.max() > 30.0
    assert np.abs(trace.angle_deg[:600] - joint).max() < 1e-9


def test_another_version_of_mujoco_is_refused_by_name(monkeypatch):
    monkeypatch.setattr("importlib.metadata.version", lambda name: "3.1.0")
    with pytest.raises(ImportError, match="mujoco is 3.1.0, expected mujoco==4"):
        sa.mujoco_plugin()
