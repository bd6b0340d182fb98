"""A smart RC-servo actuator: the board's control core, the models of the paper, and campaigns.

Angles are in degrees, rates in deg/s, times in seconds, duties in percent, torques in Nm; names
end in their unit. One tick is 50 us. Results are bit-identical to those of the program ``actuator``.

>>> import smart_actuator as sa
>>> trace = sa.simulate("board", input="pulse", every=20)
>>> float(trace.angle_deg.max().round(2))
89.97
"""

from ._native import __version__
from ._batch import ActuatorBatch
from ._control import to_control
from ._export import Export, export
from ._identify import (
    Estimate,
    FitWarning,
    FittedModel,
    Identification,
    fitted_parameters,
    identify,
)
from ._mujoco import mujoco_plugin
from ._parameters import ModelParameters
from ._sensitivity import sensitivity
from ._simulate import monte_carlo, simulate
from ._stepped import Actuator, Reading
from ._tables import inputs, parameters, presets
from ._trace import Trace

__all__ = [
    "Actuator",
    "ActuatorBatch",
    "Estimate",
    "Export",
    "FitWarning",
    "FittedModel",
    "Identification",
    "ModelParameters",
    "Reading",
    "Trace",
    "__version__",
    "export",
    "fitted_parameters",
    "identify",
    "inputs",
    "monte_carlo",
    "mujoco_plugin",
    "parameters",
    "presets",
    "sensitivity",
    "simulate",
    "to_control",
]
