"""Identifies a recording, simulates it, and puts it into MuJoCo and Gymnasium: RECORDING PLUGIN."""
import sys
import gymnasium, matplotlib.pyplot as plt, mujoco, numpy as np, smart_actuator as sa
from smart_actuator.gymnasium import posterior

fit = sa.identify(sys.argv[1], models="black-box-2")["models"][0]
values = sa.fitted_parameters(fit)
trace = sa.simulate("black-box-2", command=([0.0, 0.5], [0.0, 40.0]), duration=1.5, **values)

mujoco.mj_loadPluginLibrary(sys.argv[2])
model = mujoco.MjModel.from_xml_string(f"""<mujoco><option timestep="0.001"/><extension>
  <plugin plugin="smart_actuator.servo"><instance name="s"><config key="model" value="black-box-2"/>
    <config key="parameters" value="{" ".join(f"{n} {v!r}" for n, v in values.items())}"/>
  </instance></plugin></extension>
  <worldbody><body><joint name="j" axis="0 1 0"/><geom size="0.02"/></body></worldbody>
  <actuator><plugin joint="j" plugin="smart_actuator.servo" instance="s"/></actuator></mujoco>""")
data, joint = mujoco.MjData(model), np.empty(1500)
for step in range(1500):
    joint[step], data.ctrl[0] = np.degrees(data.qpos[0]), np.radians(40.0 * (step >= 500))
    mujoco.mj_step(model, data)
print(f"MuJoCo is at most {np.abs(trace.angle_deg[:1500] - joint).max():.1e} deg off")

envs = gymnasium.make_vec("smart_actuator/Follow-v0", 8, vectorization_mode="vector_entry_point",
                          model="black-box-2", randomise=posterior(fit))
seen, _ = envs.reset(seed=0)
paths = [(seen := envs.step(seen[:, :1])[0])[:, 1] * 60 for _ in range(75)]
plt.plot(trace.time_s[:1500], trace.angle_deg[:1500], trace.time_s[:1500], joint, "--")
plt.plot(np.arange(75) * 0.02, paths, "0.7", linewidth=0.5)
plt.savefig("identify_and_simulate.svg")
