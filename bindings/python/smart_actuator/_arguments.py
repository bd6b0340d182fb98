"""Validates arguments and converts them to the types of the compiled module."""

from __future__ import annotations

import operator
import reprlib
import warnings
from typing import Any, Iterable, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _columns, _native

#: Times in s, and values that are each held from their time on: a pair of arrays, or a trace, a
#: data frame or a mapping with their columns.
Points = Union[Tuple[ArrayLike, ArrayLike], Mapping[str, ArrayLike], Any]


#: The most threads of a call.
_MOST_THREADS = 1024

_shown = reprlib.Repr()
_shown.maxstring = _shown.maxother = 200


def shown(value: object) -> str:
    """``value`` in a message, shortened."""
    return _shown.repr(value)


def number(name: str, value: object) -> float:
    """``value`` as a float; text is rejected."""
    if not isinstance(value, (str, bytes, bytearray)):
        try:
            return float(value)  # type: ignore[arg-type]
        except (TypeError, ValueError):
            pass
        except OverflowError:
            raise ValueError(f"{name} is {shown(value)}, expected a number within float") from None
    raise TypeError(f"{name} is {shown(value)}, expected a number")


def within(name: str, value: object, low: float, high: float, unit: str = "") -> float:
    """``value`` as a float from ``low`` to ``high``."""
    given = number(name, value)
    # Written so that NaN fails.
    if low <= given <= high:
        return given
    raise ValueError(f"{name} is {given:g}, expected a number from {low:g} to {high:g} {unit}".rstrip())


def flag(name: str, value: object) -> bool:
    """``value``, which must be True or False."""
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    raise TypeError(f"{name} is {shown(value)}, expected True or False")


def whole(name: str, value: object, least: int = 0, most: int = 2**64 - 1) -> int:
    """``value`` as an integer from ``least`` to ``most``."""
    try:
        integer = operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        raise TypeError(f"{name} is {shown(value)}, expected an integer") from None
    if not least <= integer <= most:
        last = "2**64 - 1" if most == 2**64 - 1 else most
        raise ValueError(f"{name} is {shown(integer)}, expected an integer from {least} to {last}")
    return integer


def thread_count(value: Optional[int]) -> int:
    """The argument ``threads``; 0 for one thread per core."""
    return 0 if value is None else whole("threads", value, 1, _MOST_THREADS)


def text(name: str, value: object) -> str:
    """``value``, which must be a string."""
    if not isinstance(value, str):
        raise TypeError(f"{name} is {shown(value)}, expected a string")
    try:
        value.encode()
    except UnicodeEncodeError:
        raise ValueError(f"{name} is {shown(value)}, expected valid Unicode") from None
    return value


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
        raise TypeError(f"{name} is {shown(values)}, expected a sequence of names")
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


def items(name: str, value: Optional[Mapping[str, Any]]) -> list[tuple[str, Any]]:
    """The items of the argument ``name``, a mapping from names or None."""
    if value is None:
        return []
    if not isinstance(value, Mapping):
        raise TypeError(f"{name} is {shown(value)}, expected a mapping from names to values")
    return [(text(f"a name in {name}", key), each) for key, each in value.items()]


def pairs(
    name: str, parameters: Optional[Mapping[str, object]], prefix: str = ""
) -> list[tuple[str, float]]:
    """The parameters of the argument ``name`` with their values as floats."""
    return [
        (prefix + key, number(f"parameter {key}", value))
        for key, value in items(name, parameters)
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
    of_input = pairs("input_parameters", input_parameters, "input.")
    if command is not None and (input is not None or of_input):
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
        "parameters": pairs("parameters", parameters) + of_input,
    }


def warn(preset: Optional[str]) -> None:
    """Warns if results of the preset must not be shown without its warning."""
    preset = optional_text("preset", preset)
    for known in _native.presets():
        if known["name"] == preset and known["warning"]:
            warnings.warn(f"preset `{preset}`: {known['warning']}", UserWarning, stacklevel=4)
