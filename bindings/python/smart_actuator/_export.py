"""Models as actuators of other simulators."""

from __future__ import annotations

from typing import TYPE_CHECKING, List, Mapping, Optional, TypedDict

from . import _arguments, _native
from ._choices import InputName, ModelName, PlantName, PresetName, TargetName

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._parameters import ModelParameters


class Export(TypedDict):
    """The file for a simulator, the input of the validation, to which it is not fitted, the error
    against the model on it (deg rms), the standard deviation of the model's response to it (deg),
    and what is lost."""

    text: str
    validation: str
    error_deg: float
    spread_deg: float
    lost: List[str]


def export(
    to: TargetName,
    model: ModelName = "board",
    *,
    plant: Optional[PlantName] = None,
    preset: Optional[PresetName] = None,
    input: InputName = "3-2-1-1",
    input_parameters: Optional[Mapping[str, float]] = None,
    step_s: Optional[float] = None,
    **parameters: Unpack[ModelParameters],
) -> Export:
    """A model as the actuator of another simulator.

    The law of that actuator, in steps of its simulator, is fitted to the response of the model,
    without a load, on an input followed by ``log-chirp`` of the same amplitude, or by ``3-2-1-1``
    after a chirp. Its error is that on ``variable-step`` of this amplitude, or on ``3-2-1-1`` where
    it is fitted to ``variable-step``.

    :param to: the simulator and its actuator.
    :param model: as for :func:`simulate`, as are ``plant``, ``preset`` and ``parameters``.
    :param input: the first input of the fit by name, with ``input_parameters``.
    :param step_s: period of the simulator, s; by default the usual one.
    :raises ValueError: a model that the target cannot represent; else as :func:`simulate`.
    """
    request = _arguments.request(
        model=model,
        plant=plant,
        preset=preset,
        input=input,
        input_parameters=input_parameters,
        command=None,
        duration=None,
        every=20,
        seed=0,
        pwm="average",
        load=None,
        parameters=parameters,
    )
    step = None if step_s is None else _arguments.number("step_s", step_s)
    return _native.export(_arguments.text("to", to), request, step)
