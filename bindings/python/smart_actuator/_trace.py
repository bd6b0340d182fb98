"""The recording of a run."""

from __future__ import annotations

from typing import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

# A column is named after its unit; the longest ending counts.
_ENDINGS = {
    "_deg_s": "deg/s",
    "_deg": "deg",
    "_pct": "%",
    "_a": "A",
    "_v": "V",
    "_nm": "Nm",
}
_OTHERS = {"t": "s", "command": "deg", "command_delayed": "deg", "compare": "1/560 %"}


def _unit(column: str) -> str:
    endings = (unit for ending, unit in _ENDINGS.items() if column.endswith(ending))
    return _OTHERS.get(column) or next(endings, "")


class Trace(Mapping[str, NDArray[np.float64]]):
    """Columns of equal length by name, as items and as attributes.

    Row ``i`` is the state at its tick, after what the control and the PWM do at that instant and
    before the plant moves on. Every trace has

    - ``t``: time, s
    - ``command``, ``command_delayed``: the command, and what of it has arrived, deg
    - ``angle_deg``, ``rate_deg_s``: angle of the output shaft, deg, and its rate, deg/s
    - ``duty_pct``: duty of the bridge, %
    - ``angle_meas_deg``, ``rate_meas_deg_s``: what the board measures, deg and deg/s

    and that of a board also ``rate_command_deg_s`` (deg/s), ``compare`` (timer counts, 1/560 %)
    and, with the plant ``bench``, currents (A), voltages (V), torques (Nm) and angles within the
    gear train. :attr:`units` has them all.
    """

    def __init__(self, title: str, columns: Mapping[str, NDArray[np.float64]]) -> None:
        self._title = title
        self._columns = dict(columns)

    @property
    def title(self) -> str:
        """What was run, in a line."""
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
        # A copy in the making has no columns yet and must not look for them here.
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
