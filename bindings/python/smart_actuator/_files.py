"""Files that pandas reads: the compiled module has no formats of others."""

from __future__ import annotations

import os
import zipfile
from typing import Any

#: The first bytes of a file, its suffix where they are not enough, pandas' function, its package.
_FORMATS = (
    (b"PAR1", "", "read_parquet", "pyarrow"),
    (b"PK\3\4", ".xlsx", "read_excel", "openpyxl"),
)


def read(path: str) -> Any:
    """The file as a data frame; the path itself where pandas is not needed."""
    try:
        with open(path, "rb") as file:
            head = file.read(4)
    except OSError:
        # A folder, or no file: the compiled module says so.
        return path
    for first, suffix, function, package in _FORMATS:
        if head == first and path.lower().endswith(suffix):
            return _by_pandas(path, function, package)
    return path


def _by_pandas(path: str, function: str, package: str) -> Any:
    try:
        import pandas

        return getattr(pandas, function)(path)
    except ImportError:
        raise ImportError(
            f"{path} is read by pandas and {package}, expected both: pip install pandas {package}"
        ) from None
    except (ValueError, KeyError, zipfile.BadZipFile) as error:
        raise ValueError(f"{path}: {error}, expected a file that pandas.{function} reads") from None
