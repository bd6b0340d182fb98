"""Progress of long calls."""

from __future__ import annotations

import contextlib
import sys
from typing import Any, Callable, Iterator, Optional, Union

#: Is called with what is done and the total: simulated seconds, runs or models.
Report = Callable[[float, float], Any]

#: ``True`` shows a bar on standard error, by ``tqdm`` where it is installed; a function is called
#: about twenty times a second.
Progress = Union[bool, Report]


@contextlib.contextmanager
def reported(progress: Progress, unit: str) -> Iterator[Optional[Report]]:
    """The function to call during the work; None without a report of progress."""
    if progress is False or progress is None:
        yield None
    elif progress is not True:
        if not callable(progress):
            raise TypeError(f"progress is {progress!r}, expected a bool or a function")
        yield progress
    else:
        bar = _bar(unit)
        try:
            yield bar.show
        finally:
            bar.close()


class _Line:
    """A line on standard error."""

    def __init__(self, unit: str) -> None:
        self._unit = unit

    def show(self, done: float, total: float) -> None:
        sys.stderr.write(f"\r{done:.4g} of {total:.4g} {self._unit}")
        sys.stderr.flush()

    def close(self) -> None:
        sys.stderr.write("\n")


class _Tqdm:
    """A bar of tqdm."""

    def __init__(self, unit: str, tqdm: Any) -> None:
        self._bar = tqdm(unit=f" {unit}")

    def show(self, done: float, total: float) -> None:
        self._bar.total = total
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        self._bar.close()


def _bar(unit: str) -> Union[_Line, _Tqdm]:
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return _Line(unit)
    return _Tqdm(unit, tqdm)
