"""Recordings of BAM, and tables with the columns of this project."""

import csv
import json

import numpy as np

DEG = 180.0 / np.pi
#: Step of BAM's simulation, s: the default of its `bam.process`.
BAM_STEP_S = 0.005
#: Servos in BAM's recordings, and the class of BAM that simulates them.
BAM_SERVOS = {"xl330": "xl330", "sts3250": "sts3215", "sts3215": "sts3215"}


def read(path):
    return OfBam(path) if path.suffix == ".json" else Recording(path, *columns(path))


def columns(path):
    """Time, s, command and angle, rad, of CSV as `actuator record` and `simulate` write it."""
    with path.open(newline="") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    angle = next(name for name in ("angle_meas_deg", "angle_deg") if name in rows[0])
    of = lambda name: np.array([float(row[name]) for row in rows])
    return of("time_s"), of("command_deg") / DEG, of(angle) / DEG


class Recording:
    """A recording at its own instants: time, s, command and angle, rad."""

    servo = None

    def __init__(self, path, time_s, goal, angle):
        self.path, self.time_s, self.goal, self.angle = path, time_s - time_s[0], goal, angle
        self.is_on = np.ones(len(angle), bool)

    def error_deg(self, angle):
        """Mean absolute error of a prediction at the instants of the samples, deg."""
        return float(np.mean(np.abs(angle - self.angle)) * DEG)

    def halves(self):
        middle, end = self.time_s[len(self.time_s) // 2], self.time_s[-1]
        return [(0.0, middle), (middle, end)]


class OfBam(Recording):
    """A recording of BAM, at its own instants and at even ones."""

    def __init__(self, path):
        self.raw = json.loads(path.read_text())
        entries = self.raw["entries"]
        column = lambda name: np.array([float(entry[name]) for entry in entries])
        super().__init__(path, column("timestamp"), column("goal_position"), column("position"))
        self.servo = BAM_SERVOS.get(self.raw["motor"])
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
