"""Validates arguments and converts them to the types of the compiled module."""

from __future__ import annotations

import operator
import warnings
from typing import Any, Iterable, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _columns, _native

#: Times in s, and values that are each held from their time on: a pair of arrays, or a trace, a
#: data frame or a mapping with their columns.
Points = Union[Tuple[ArrayLike, ArrayLike], Mapping[str, ArrayLike], Any]


def number(name: str, value: object) -> float:
    """``value`` as a float; text is rejected."""
    if not isinstance(value, (str, bytes, bytearray)):
        try:
            return float(value)  # type: ignore[arg-type]
        except (TypeError, ValueError):
            pass
        except OverflowError:
            raise ValueError(f"{name} is {value!r}, expected a number within float") from None
    raise TypeError(f"{name} is {value!r}, expected a number")


def whole(name: str, value: object, least: int = 0) -> int:
    """``value`` as an integer of at most 64 bits."""
    try:
        integer = operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        raise TypeError(f"{name} is {value!r}, expected an integer") from None
    if not least <= integer < 2**64:
        raise ValueError(f"{name} is {integer}, expected an integer from {least} to 2**64 - 1")
    return integer


def text(name: str, value: object) -> str:
    """``value``, which must be a string."""
    if isinstance(value, str):
        return value
    raise TypeError(f"{name} is {value!r}, expected a string")


def optional_text(name: str, value: object) -> Optional[str]:
    """``value``, which must be a string or None."""
    return None if value is None else text(name, value)


def array(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """``value`` as doubles, contiguous and aligned, which the arrays of Dask need not be."""
    expected = f"{name}: expected an array of real numbers"
    try:
        given = np.asanyarray(value)
    except ValueError as error:
        raise ValueError(f"{expected}: {error}") from None
    if given.dtype.kind not in "fiub" or np.ma.isMaskedArray(given):
        raise TypeError(f"{expected}, got {type(value).__name__} of {given.dtype}")
    # A copy is contiguous and aligned, and no other thread writes to it.
    return np.require(np.array(given, np.float64), np.float64, ["C", "A"])


def row(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """As :func:`array`, with one dimension."""
    found = array(name, value)
    if found.ndim != 1:
        raise ValueError(f"{name} has the shape {found.shape}, expected one dimension")
    return found


def names(name: str, values: Sequence[str]) -> list[str]:
    """``values`` as a list of names."""
    if isinstance(values, str) or not isinstance(values, Iterable):
        raise TypeError(f"{name} is {values!r}, expected a sequence of names")
    return [text(f"a name in {name}", value) for value in values]


def points(
    name: str, value: Optional[Points], column: str
) -> Optional[Tuple[NDArray[np.float64], ...]]:
    """Times and values as two one-dimensional arrays."""
    if value is None:
        return None
    columns = _columns.of(value)
    if columns is not None:
        for key in ("time_s", column):
            if key not in columns:
                names = ", ".join(map(str, columns))
                raise KeyError(f"{name} has no column {key!r}: the columns are {names}")
        value = columns["time_s"], columns[column]
    try:
        times, values = value
    except (TypeError, ValueError):
        raise TypeError(f"{name}: expected a pair of arrays, times in s and values") from None
    arrays = array(f"{name}, times", times), array(f"{name}, values", values)
    for each in arrays:
        if each.ndim != 1:
            raise ValueError(f"{name} has an array of shape {each.shape}, expected one dimension")
    return arrays


def pairs(parameters: Mapping[str, object], prefix: str = "") -> list[tuple[str, float]]:
    """Parameters by name with their values as floats."""
    if not isinstance(parameters, Mapping):
        raise TypeError(f"expected a mapping from names to values, got {parameters!r}")
    return [
        (prefix + text("name of a parameter", name), number(f"parameter {name}", value))
        for name, value in parameters.items()
    ]


def request(
    *,
    model: str,
    plant: Optional[str],
    preset: Optional[str],
    input: Optional[str],
    input_parameters: Optional[Mapping[str, float]],
    command: Optional[Points],
    duration: Optional[float],
    every: int,
    seed: int,
    pwm: str,
    load: Optional[Points],
    parameters: Mapping[str, object],
) -> dict[str, Any]:
    """The arguments of a run, for the compiled module."""
    if command is not None and (input is not None or input_parameters):
        raise ValueError("both an input by name and a command, expected one of them")
    warn(preset)
    return {
        "model": text("model", model),
        "plant": optional_text("plant", plant),
        "preset": optional_text("preset", preset),
        "input": optional_text("input", input),
        "command": points("command", command, "command_deg"),
        "load": points("load", load, "load_torque_nm"),
        "duration": None if duration is None else number("duration", duration),
        "every": whole("every", every, 1),
        "seed": whole("seed", seed),
        "pwm": text("pwm", pwm),
        "parameters": pairs(parameters) + pairs(input_parameters or {}, "input."),
    }


def warn(preset: Optional[str]) -> None:
    """Warns if results of the preset must not be shown without its warning."""
    for known in _native.presets():
        if known["name"] == preset and known["warning"]:
            warnings.warn(f"preset `{preset}`: {known['warning']}", UserWarning, stacklevel=4)
