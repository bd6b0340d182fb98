"""Many actuators that are stepped together."""

from __future__ import annotations

from typing import TYPE_CHECKING, Mapping, Optional

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arguments, _native
from ._choices import ModelName, PlantName, PresetName

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._parameters import ModelParameters

_TICKS_PER_SECOND = 20_000
#: The columns of the states.
STATES = ("angle_deg", "rate_deg_s", "angle_meas_deg", "rate_meas_deg_s")

#: The most actuators, which take some gigabytes.
_MOST_ACTUATORS = 2**20


class ActuatorBatch:
    """Many actuators of one model that are stepped together, on all cores.

    Each moves bit for bit as an :class:`Actuator` with its parameters; those with the first-order
    motor are computed side by side in vectors if a step is a whole number of control periods (4 ms).

    :param parameters: arrays by the name or symbol of a parameter, one value an actuator.
    :param count: how many, if no parameter differs; at most 2**20.
    :param step_s: time of a step, s, a whole number of ticks of 50 us.
    :param seed: of the random numbers; actuator ``i`` has ``seed + i``.
    :param threads: number of threads; by default one per core.
    :param fixed: parameters that are the same for all.

    The other arguments are those of :func:`simulate`.
    """

    def __init__(
        self,
        parameters: Optional[Mapping[str, ArrayLike]] = None,
        *,
        count: Optional[int] = None,
        step_s: float = 0.02,
        model: ModelName = "board",
        plant: Optional[PlantName] = None,
        preset: Optional[PresetName] = None,
        seed: int = 0,
        threads: Optional[int] = None,
        **fixed: Unpack[ModelParameters],
    ) -> None:
        if count is not None:
            _arguments.whole("count", count, 1, _MOST_ACTUATORS)
        names, values = table(parameters, count)
        if not 1 <= len(values) <= _MOST_ACTUATORS:
            raise ValueError(f"parameters of {len(values)} actuators, expected 1 to {_MOST_ACTUATORS}")
        ticks = _arguments.number("step_s", step_s) * _TICKS_PER_SECOND
        # Written so that NaN fails.
        if not (0.5 < ticks <= 1e9 and abs(ticks - round(ticks)) < 1e-6):
            raise ValueError(f"step_s is {step_s}, expected a whole number of ticks of 50 us")
        _arguments.warn(preset)
        self._names, self._count = names, len(values)
        self._native = _native.ActuatorBatch(
            _arguments.text("model", model),
            _arguments.optional_text("plant", plant),
            _arguments.optional_text("preset", preset),
            _arguments.whole("seed", seed),
            _arguments.pairs("parameters", fixed),
            names,
            values,
            round(ticks),
            _arguments.thread_count(threads),
        )
        self._states = np.zeros((self._count, len(STATES)))

    def __len__(self) -> int:
        return self._count

    @property
    def states(self) -> NDArray[np.float64]:
        """A row an actuator: angle, deg, rate, deg/s, and both as measured. Overwritten by steps."""
        return self._states

    def step(self, commands: ArrayLike) -> NDArray[np.float64]:
        """Steps all actuators with a command each, deg, and returns :attr:`states`.

        In place of a command that is not finite the last one holds.
        """
        given = _arguments.array("commands", commands)
        if given.shape != (self._count,):
            raise ValueError(f"commands of shape {given.shape}, expected ({self._count},)")
        self._native.step(given, self._states)
        return self._states

    def replace(
        self, indices: ArrayLike, parameters: Mapping[str, ArrayLike], seed: int = 0
    ) -> None:
        """Replaces some actuators with others at rest: the same parameters as those that differ
        between the actuators, one value for each index."""
        row = _arguments.row("indices", indices)
        chosen = row.astype(np.int64) if np.all(np.abs(row) < 2**53) else np.full(row.shape, -1)
        if np.any(chosen != row) or np.any(chosen < 0) or np.any(chosen >= self._count):
            shown = _arguments.shown(indices)
            raise ValueError(f"indices are {shown}, expected integers from 0 to {self._count - 1}")
        given = sorted(name for name, _ in _arguments.items("parameters", parameters))
        if given != sorted(self._names):
            raise ValueError(f"parameters are of {given}, expected {sorted(self._names)}")
        seed = _arguments.whole("seed", seed)
        _, values = table({name: parameters[name] for name in self._names}, len(chosen))
        order = np.argsort(chosen, kind="stable")
        if np.any(np.diff(chosen[order]) == 0):
            raise ValueError("an index is there twice, expected each once")
        self._native.replace(chosen[order].tolist(), np.ascontiguousarray(values[order]), seed)
        self._states[chosen] = 0.0


def table(
    parameters: Optional[Mapping[str, ArrayLike]], count: Optional[int]
) -> tuple[list[str], NDArray[np.float64]]:
    """Names, and a row of values an actuator."""
    given = _arguments.items("parameters", parameters)
    names = [name for name, _ in given]
    columns = [_arguments.array(f"parameter {name}", value) for name, value in given]
    if count is None:
        if not columns:
            raise TypeError("neither parameters nor a count, expected parameters that differ or a count")
        count = max(column.size for column in columns)
    try:
        rows = [np.broadcast_to(column, (count,)) for column in columns]
    except ValueError:
        shapes = ", ".join(f"{n} {c.shape}" for n, c in zip(names, columns))
        raise ValueError(f"parameters are {shapes}, expected {count} values or one") from None
    return names, np.ascontiguousarray(np.array(rows).reshape(len(names), count).T)
