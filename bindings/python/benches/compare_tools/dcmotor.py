"""MuJoCo's motor and system identification."""

import contextlib
import sys

import mujoco
import numpy as np
from bam import model as models
from bam.actuators import actuators
from mujoco import sysid


class DcMotor:
    """MuJoCo's <dcmotor> with friction at a pendulum, and the controller of the servo before it."""

    NAMES = ("kt", "R", "armature", "friction_base", "friction_viscous", "q_offset")

    def __init__(self, servo):
        self.servo = actuators[servo]()
        parameters = models.models["m1"]()
        parameters.set_actuator(self.servo)
        known = parameters.get_parameters()
        self.parameters = sysid.ParameterDict(
            {n: sysid.Parameter(n, known[n].value, known[n].min, known[n].max) for n in self.NAMES}
        )

    def angles(self, run, parameters):
        kt, resistance, armature, coulomb, viscous, offset = parameters
        log, servo = run.log, self.servo
        model = mujoco.MjModel.from_xml_string(f"""
            <mujoco><option timestep="0.001" gravity="0 0 -9.80665" integrator="implicitfast"/>
            <worldbody><body><joint name="j" axis="0 -1 0" damping="{viscous}" armature="{armature}"
            frictionloss="{coulomb}"/><inertial pos="0 0 -{log['length']}" mass="{log['mass']}"
            diaginertia="1e-9 1e-9 1e-9"/></body></worldbody><actuator>
            <dcmotor joint="j" motorconst="{kt}" resistance="{resistance}"/></actuator></mujoco>""")
        data = mujoco.MjData(model)
        data.qpos[0] = run.angle[0] + offset
        angles = np.empty(len(run.time_s))
        gain = log["kp"] * servo.error_gain
        limit = getattr(servo, "max_current", None) or np.inf
        for row, angle in enumerate(angles):
            angles[row] = data.qpos[0] - offset
            if row + 1 == len(angles):
                break
            # The limiter of the servo keeps the current below its limit where the supply can.
            rate, span = data.qvel[0], resistance * limit / log["vin"]
            centre = kt * rate / log["vin"]
            duty = np.clip(gain * (run.goal[row] - angles[row]), centre - span, centre + span)
            data.ctrl[0] = log["vin"] * np.clip(duty, -servo.max_pwm, servo.max_pwm)
            model.opt.disableactuator = 0 if run.is_on[row] else 1
            steps = round(run.time_s[row + 1] * 1000) - round(run.time_s[row] * 1000)
            if steps:
                mujoco.mj_step(model, data, steps)
        return angles

    def fit(self, runs):
        residual = lambda x, _: ([self.angles(run, x) - run.angle for run in runs], None, None)

        # The optimiser asks for several points at once, as columns.
        def residuals(x, parameters):
            points = np.atleast_2d(np.asarray(x).T)
            columns = [np.concatenate(residual(point, parameters)[0]) for point in points]
            return [np.array(columns).T if np.ndim(x) > 1 else columns[0]], None, None

        # It writes its iterations to standard output, where the page goes.
        with contextlib.redirect_stdout(sys.stderr):
            _, result = sysid.optimize(self.parameters, residuals, verbose=False)
        return np.ravel(result.x)
