"""Tables of the models, parameters, presets and inputs."""

from __future__ import annotations

from typing import List, Optional, TypedDict

from . import _arguments, _native
from ._choices import InputName, ModelName, PlantName, PresetName


class Parameter(TypedDict):
    """A row of a parameter table; ``symbol`` is empty if the parameter has none."""

    name: str
    symbol: str
    unit: str
    min: float
    max: float
    default: float
    source: str
    meaning: str


class Preset(TypedDict):
    """An interpretation of the paper: the ``values`` of parameters that differ from their defaults."""

    name: PresetName
    summary: str
    warning: Optional[str]
    models: List[str]
    values: dict[str, float]


class Input(TypedDict):
    """A standard input."""

    name: InputName
    summary: str
    parameters: List[Parameter]


def parameters(model: ModelName = "board", plant: Optional[PlantName] = None) -> List[Parameter]:
    """Every parameter of a model with its unit, range, default and source."""
    return _native.parameters(
        _arguments.text("model", model), _arguments.optional_text("plant", plant)
    )


def presets() -> List[Preset]:
    """Every preset with its models. The default of a model is the first preset that lists it."""
    return _native.presets()


def inputs() -> List[Input]:
    """Every standard input with its parameters."""
    return _native.inputs()
