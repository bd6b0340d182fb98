"""Recordings of BAM."""

import json

import numpy as np

DEG = 180.0 / np.pi
#: Step of BAM's simulation, s: the default of its `bam.process`.
BAM_STEP_S = 0.005


class Recording:
    """A recording of BAM, at its own instants and at even ones."""

    def __init__(self, path):
        self.path, self.raw = path, json.loads(path.read_text())
        entries = self.raw["entries"]
        column = lambda name: np.array([float(entry[name]) for entry in entries])
        self.time_s = column("timestamp") - entries[0]["timestamp"]
        self.angle, self.goal = column("position"), column("goal_position")
        self.is_on = column("torque_enable") > 0.5
        self.grid_s = np.arange(0.0, self.time_s[-1], BAM_STEP_S)
        even = lambda values: np.interp(self.grid_s, self.time_s, values)
        rows = zip(even(self.angle), even(column("speed")), even(self.goal), even(self.is_on) > 0.5)
        names = ("position", "speed", "goal_position", "torque_enable")
        self.log = {
            **{name: float(self.raw[name]) for name in ("mass", "length", "kp", "vin")},
            "arm_mass": float(self.raw.get("arm_mass", 0.0)),
            "dt": BAM_STEP_S,
            "entries": [dict(zip(names, row)) for row in rows],
        }

    def error_deg(self, angle):
        """Mean absolute error of a prediction at the instants of the samples, deg."""
        return float(np.mean(np.abs(angle - self.angle)) * DEG)
