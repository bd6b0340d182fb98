"""The friction models of BAM in its own simulation."""

import numpy as np
from bam import model as models
from bam.actuators import actuators
from bam.parameter import Parameter
from bam.simulate import Simulator

from recordings import BAM_STEP_S, DEG


class Population(Parameter):
    """A parameter with a value for each simulation. BAM adds to values in place: a copy for each use."""

    @property
    def value(self):
        return np.copy(self.values)

    @value.setter
    def value(self, values):
        self.values = values


class Bam:
    """A friction model of BAM in its own simulation, for many sets of parameters at once."""

    def __init__(self, name, servo):
        self.model = models.models[name]()
        self.model.set_actuator(actuators[servo]())
        for name, p in self.model.get_parameters().items():
            setattr(self.model, name, Population(p.value, p.min, p.max, p.optimize))
        self.free = list(self.model.get_parameters().values())
        self.low = np.array([p.min for p in self.free])
        self.high = np.array([p.max for p in self.free])
        self.start = np.array([p.value for p in self.free])

    def angles(self, runs, sets):
        """Angles, rad, by run, instant and set."""
        shape = (len(sets), len(runs))
        spread = lambda values: np.broadcast_to(values, shape).ravel()
        for parameter, column in zip(self.free, np.transpose(sets)):
            parameter.value = spread(column[:, None])
        rows = min(len(run.log["entries"]) for run in runs)
        batch = {
            key: spread([run.log[key] for run in runs]) for key in runs[0].log if key != "entries"
        }
        batch["dt"] = BAM_STEP_S
        batch["entries"] = [
            {key: spread([run.log["entries"][row][key] for run in runs]) for key in entry}
            for row, entry in enumerate(runs[0].log["entries"][:rows])
        ]
        found = Simulator(self.model).rollout_log(batch, simulate_control=True)[0]
        return np.moveaxis(np.array(found).reshape(rows, *shape), (0, 1, 2), (1, 2, 0))

    def cost(self, runs, sets):
        """The mean absolute error that BAM minimises, deg, of each set."""
        angles = self.angles(runs, sets)
        rows = angles.shape[1]
        measured = np.array([[e["position"] for e in run.log["entries"][:rows]] for run in runs])
        return np.mean(np.abs(angles - measured[:, :, None]), axis=(0, 1)) * DEG

    def error_deg(self, run, parameters):
        return run.error_deg(
            np.interp(run.time_s, run.grid_s, self.angles([run], [parameters])[0, :, 0])
        )
