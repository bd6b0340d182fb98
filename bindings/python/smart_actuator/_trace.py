"""The recording of a run."""

from __future__ import annotations

from typing import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

# The unit of a column is the suffix of its name; the longest suffix applies.
_SUFFIXES = {
    "_deg_s": "deg/s",
    "_deg": "deg",
    "_pct": "%",
    "_a": "A",
    "_v": "V",
    "_nm": "Nm",
}
_OTHERS = {"t": "s", "command": "deg", "command_delayed": "deg", "compare": "1/560 %"}


def _unit(column: str) -> str:
    units = (unit for suffix, unit in _SUFFIXES.items() if column.endswith(suffix))
    return _OTHERS.get(column) or next(units, "")


class Trace(Mapping[str, NDArray[np.float64]]):
    """Columns of equal length by name, as items and as attributes.

    Row ``i`` is the state at its tick, after the updates of control and PWM at that instant and
    before the plant is stepped. Every trace has

    - ``t``: time, s
    - ``command``, ``command_delayed``: the command, and the command behind the transport delay, deg
    - ``angle_deg``, ``rate_deg_s``: angle of the output shaft, deg, and its rate, deg/s
    - ``duty_pct``: duty of the bridge, %
    - ``angle_meas_deg``, ``rate_meas_deg_s``: angle and rate as the board measures them

    and that of a board also ``rate_command_deg_s`` (deg/s), ``compare`` (timer counts, 1/560 %)
    and, with the plant ``bench``, currents (A), voltages (V), torques (Nm) and angles within the
    gear train. :attr:`units` lists all of them.
    """

    def __init__(self, title: str, columns: Mapping[str, NDArray[np.float64]]) -> None:
        self._title = title
        self._columns = dict(columns)

    @property
    def title(self) -> str:
        """Model and input of the run."""
        return self._title

    @property
    def units(self) -> dict[str, str]:
        """The unit of each column."""
        return {name: _unit(name) for name in self._columns}

    def to_dict(self) -> dict[str, NDArray[np.float64]]:
        """The columns as a dictionary, for instance for ``pandas.DataFrame``."""
        return dict(self._columns)

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        try:
            return self._columns[name]
        except KeyError:
            raise KeyError(f"no column {name!r}, expected one of {', '.join(self)}") from None

    def __getattr__(self, name: str) -> NDArray[np.float64]:
        # An instance that is being copied has no columns yet: looking them up would recurse.
        columns = self.__dict__.get("_columns", {})
        if name in columns:
            column: NDArray[np.float64] = columns[name]
            return column
        raise AttributeError(f"no column {name!r}, expected one of {', '.join(columns)}")

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        """The number of columns."""
        return len(self._columns)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._columns]

    def __repr__(self) -> str:
        rows = len(self["t"])
        return f"<Trace of {self._title}: {rows} rows of {', '.join(self)}>"
