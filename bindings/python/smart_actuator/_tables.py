"""What there is to choose from."""

from __future__ import annotations

from typing import List, Optional, TypedDict

from . import _arguments, _native


class Parameter(TypedDict):
    """What is known of a parameter; ``symbol`` is empty where there is none."""

    name: str
    symbol: str
    unit: str
    min: float
    max: float
    default: float
    source: str
    meaning: str


class Preset(TypedDict):
    """A reading of the paper: the ``values`` of the parameters that are not at their defaults."""

    name: str
    summary: str
    warning: Optional[str]
    models: List[str]
    values: dict[str, float]


class Input(TypedDict):
    """A standard command."""

    name: str
    summary: str
    parameters: List[Parameter]


def parameters(model: str = "board", plant: Optional[str] = None) -> List[Parameter]:
    """Every parameter of a model with its unit, range, default and where that comes from."""
    plant = _arguments.optional_text("plant", plant)
    return _native.parameters(_arguments.text("model", model), plant)


def presets() -> List[Preset]:
    """Every preset with its models; the first that names a model is that model's default."""
    return _native.presets()


def inputs() -> List[Input]:
    """Every standard input with its parameters."""
    return _native.inputs()
