"""The recording of a run."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict, List, Mapping

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pandas as _pandas

# The unit of a column is the suffix of its name; the longest suffix applies.
_SUFFIXES = {
    "_deg_s": "deg/s",
    "_deg": "deg",
    "_pct": "%",
    "_counts": "1/560 %",
    "_nm": "Nm",
    "_a": "A",
    "_v": "V",
    "_s": "s",
}


def _unit(column: str) -> str:
    units = (unit for suffix, unit in _SUFFIXES.items() if column.endswith(suffix))
    return next(units, "")


class Trace(Dict[str, NDArray[np.float64]]):
    """Columns of equal length by name, as items and as attributes.

    A trace is a dictionary: ``pandas.DataFrame(trace)``, ``polars.DataFrame(trace)``,
    ``pyarrow.table(trace)`` and :func:`identify` take it as it is. Its columns have the names of
    the files that ``actuator simulate`` writes. Row ``i`` is the state at its tick, after the
    updates of control and PWM at that instant and before the plant is stepped. Every trace has

    - ``time_s``: time, s
    - ``command_deg``, ``command_delayed_deg``: the command, and the command behind the transport
      delay, deg
    - ``angle_deg``, ``rate_deg_s``: angle of the output shaft, deg, and its rate, deg/s
    - ``duty_pct``: duty of the bridge, %
    - ``angle_meas_deg``, ``rate_meas_deg_s``: angle and rate as the board measures them

    and that of a board also ``rate_command_deg_s`` (deg/s), ``compare_counts`` (1/560 %) and, with
    the plant ``bench``, currents (A), voltages (V), torques (Nm) and angles within the gear train.
    :attr:`units` lists all of them.
    """

    def __init__(self, title: str, columns: Mapping[str, NDArray[np.float64]]) -> None:
        super().__init__(columns)
        self._title = title
        self._gradients: Dict[str, NDArray[np.float64]] = {}

    @property
    def title(self) -> str:
        """Model and input of the run."""
        return self._title

    @property
    def units(self) -> Dict[str, str]:
        """The unit of each column."""
        return {name: _unit(name) for name in self}

    @property
    def gradients(self) -> Dict[str, NDArray[np.float64]]:
        """Derivatives of the angle by parameters, in deg per unit of each, that
        :func:`simulate` was called for; by ``command_deg`` a column for each command."""
        return self._gradients

    def to_dict(self) -> Dict[str, NDArray[np.float64]]:
        """The columns as a plain dictionary."""
        return dict(self)

    def to_numpy(self) -> NDArray[np.float64]:
        """A row for each instant and a column for each name, in their order."""
        return np.column_stack(list(self.values()))

    def to_pandas(self) -> _pandas.DataFrame:
        """A data frame, with :attr:`title` and :attr:`units` in its ``attrs``."""
        import pandas

        frame = pandas.DataFrame(dict(self))
        frame.attrs.update(title=self.title, units=self.units)
        return frame

    def __dataframe__(self, nan_as_null: bool = False, allow_copy: bool = True) -> Any:
        """The interchange object of the dataframe protocol, by ``pyarrow``."""
        import pyarrow

        return pyarrow.table(dict(self)).__dataframe__(nan_as_null, allow_copy)

    def __arrow_c_stream__(self, requested_schema: object = None) -> object:
        """The stream of the Arrow PyCapsule interface, by ``pyarrow``."""
        import pyarrow

        return pyarrow.table(dict(self)).__arrow_c_stream__(requested_schema)

    def __missing__(self, name: str) -> NDArray[np.float64]:
        raise KeyError(f"no column {name!r}, expected one of {', '.join(self)}")

    def __getattr__(self, name: str) -> NDArray[np.float64]:
        if name in self:
            return self[name]
        raise AttributeError(f"no column {name!r}, expected one of {', '.join(self)}")

    def __dir__(self) -> List[str]:
        return [*super().__dir__(), *self]

    def __repr__(self) -> str:
        rows = len(next(iter(self.values()), ()))
        return f"<Trace of {self._title}: {rows} rows of {', '.join(self)}>"
