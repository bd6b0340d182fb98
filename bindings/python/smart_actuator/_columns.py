"""Columns by name: of mappings, data frames, tables of Arrow and structured arrays."""

from __future__ import annotations

import os
from typing import Any, List, Mapping, Optional

import numpy as np


def is_single(value: object) -> bool:
    """Whether it is one recording: a file, or columns by name."""
    return isinstance(value, (str, bytes, os.PathLike)) or of(value) is not None


def of(value: Any) -> Optional[Mapping[Any, Any]]:
    """The columns by name; None where the value has no named columns.

    Of a data frame, those with real numbers, and dates as seconds since 1970: an index or a text
    beside them is left out.
    """
    if isinstance(value, Mapping):
        return value
    names = _names(value)
    if names is None:
        return None
    columns = {}
    for name in names:
        column = np.asarray(value[name])
        if column.dtype.kind == "M":
            column = (column - np.datetime64(0, "s")) / np.timedelta64(1, "s")
        if column.dtype.kind in "fiub":
            columns[name] = column
    return columns


def _names(value: Any) -> Optional[List[Any]]:
    if isinstance(value, np.ndarray):
        return None if value.dtype.names is None else list(value.dtype.names)
    # pandas, polars and others; then pyarrow, whose `columns` are the data.
    for attribute in ("column_names", "columns"):
        names = getattr(value, attribute, None)
        if names is not None and hasattr(value, "__getitem__"):
            return list(names)
    return None
