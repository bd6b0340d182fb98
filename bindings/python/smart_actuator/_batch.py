"""Many actuators that are stepped together."""

from __future__ import annotations

from typing import TYPE_CHECKING, Mapping, Optional, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arguments, _native

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._parameters import ModelParameters

_TICKS_PER_SECOND = 20_000
#: The columns of the states.
STATES = ("angle_deg", "rate_deg_s", "angle_meas_deg", "rate_meas_deg_s")


class ActuatorBatch:
    """Many actuators of one model that are stepped together, on all cores.

    Each moves bit for bit as an :class:`Actuator` with its parameters; those with the first-order
    motor are computed side by side in vectors if a step is a whole number of control periods (4 ms).

    :param parameters: arrays by the name or symbol of a parameter, one value an actuator.
    :param count: how many, if no parameter differs.
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
        model: str = "board",
        plant: Optional[str] = None,
        preset: Optional[str] = None,
        seed: int = 0,
        threads: Optional[int] = None,
        **fixed: Unpack[ModelParameters],
    ) -> None:
        names, values = table(parameters or {}, count)
        ticks = _arguments.number("step_s", step_s) * _TICKS_PER_SECOND
        # Written so that NaN fails.
        if not (0.5 < ticks <= 1e9 and abs(ticks - round(ticks)) < 1e-6):
            raise ValueError(f"step_s is {step_s}, expected a whole number of ticks of 50 us")
        threads = 0 if threads is None else _arguments.whole("threads", threads, 1)
        _arguments.warn(preset)
        self._names, self._count = names, len(values)
        self._native = _native.ActuatorBatch(
            _arguments.text("model", model),
            _arguments.optional_text("plant", plant),
            _arguments.optional_text("preset", preset),
            _arguments.whole("seed", seed),
            _arguments.pairs(fixed),
            names,
            values,
            round(ticks),
            threads,
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
        given = np.ascontiguousarray(commands, dtype=np.float64)
        if given.shape != (self._count,):
            raise ValueError(f"commands of shape {given.shape}, expected ({self._count},)")
        self._native.step(given, self._states)
        return self._states

    def replace(
        self, indices: Sequence[int], parameters: Mapping[str, ArrayLike], seed: int = 0
    ) -> None:
        """Replaces some actuators with others at rest: the same parameters as those that differ
        between the actuators, one value for each index."""
        chosen = np.asarray(indices, dtype=np.int64)
        if chosen.ndim != 1 or np.any(chosen < 0) or np.any(chosen >= self._count):
            raise ValueError(f"indices are {indices}, expected some from 0 to {self._count - 1}")
        if sorted(parameters) != sorted(self._names):
            raise ValueError(f"parameters {sorted(parameters)}, expected {sorted(self._names)}")
        _, values = table({name: parameters[name] for name in self._names}, len(chosen))
        order = np.argsort(chosen, kind="stable")
        if np.any(np.diff(chosen[order]) == 0):
            raise ValueError("an index is there twice, expected each once")
        self._native.replace(chosen[order].tolist(), np.ascontiguousarray(values[order]), seed)
        self._states[chosen] = 0.0


def table(
    parameters: Mapping[str, ArrayLike], count: Optional[int]
) -> tuple[list[str], NDArray[np.float64]]:
    """Names, and a row of values an actuator."""
    names = [_arguments.text("name of a parameter", name) for name in parameters]
    columns = [_arguments.array(f"parameter {name}", parameters[name]) for name in names]
    if count is None:
        if not columns:
            raise TypeError("expected parameters that differ, or a count")
        count = max(column.size for column in columns)
    count = _arguments.whole("count", count)
    try:
        rows = [np.broadcast_to(column, (count,)) for column in columns]
    except ValueError:
        shapes = ", ".join(f"{n} {c.shape}" for n, c in zip(names, columns))
        raise ValueError(f"{shapes}, expected {count} values or one") from None
    return names, np.ascontiguousarray(np.array(rows).reshape(len(names), count).T)
