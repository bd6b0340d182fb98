"""Derivatives of a response by parameters and by the command."""

from __future__ import annotations

from typing import Mapping, Optional, Sequence, Tuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arguments, _native
from ._choices import FittedModelName
from ._progress import Progress, Report, reported

#: The name of the command among the names of parameters.
COMMAND = "command_deg"

#: The greatest number of derivatives by the command: one for each pair of a row and a command.
MOST_DERIVATIVES = 2**27


def sensitivity(
    model: FittedModelName,
    time_s: ArrayLike,
    command_deg: ArrayLike,
    by: Sequence[str],
    *,
    duty_pct: Optional[ArrayLike] = None,
    progress: Progress = False,
    **parameters: float,
) -> Tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]:
    """The angle of a model and its derivatives by parameters and by the command, exact to rounding.

    They are computed by dual numbers in the solver of :func:`identify`, with the instants of its
    events: where a limit begins to act they are one-sided.

    :param model: a model that can be identified: ``black-box-1``, ``black-box-2``,
        ``black-box-2-oscillator``, ``grey-box``, ``motor-m1`` to ``motor-m6`` (from a duty) and
        ``servo-m1`` to ``servo-m6``. The board computes in fixed point and has no derivatives.
    :param time_s: instants, s, of commands that are each held until the next.
    :param command_deg: commands, deg.
    :param by: names of parameters, and ``command_deg``. A gain and an offset on the command are
        ``gain`` and ``offset_deg`` of the black boxes.
    :param duty_pct: duty of a motor, %.
    :param progress: True for a bar on standard error, or a function that is called with the numbers
        of finished commands and of all; derivatives by parameters take no noticeable time.
    :param parameters: values; the others are defaults.
    :returns: the angle at each instant, deg, and its derivative by each parameter; that by
        ``command_deg`` has a row for each instant and a column for each command.
    """
    times, commands = (
        _arguments.row("time_s", time_s),
        _arguments.row("command_deg", command_deg),
    )
    duty = None if duty_pct is None else _arguments.row("duty_pct", duty_pct)
    names = _arguments.names("by", by)
    _arguments.text("model", model)
    # Each must be one of the model's.
    given = _arguments.pairs("parameters", parameters), False
    others = [name for name in names if name != COMMAND]
    angle, slopes = _native.sensitivity(model, times, commands, duty, given, others)
    found = dict(zip(others, slopes))
    with reported(progress, "commands") as report:
        if COMMAND in names:
            rows = list(range(len(times)))
            found[COMMAND] = _by_command(model, times, commands, rows, given, report)
    return angle, {name: found[name] for name in names}


def _by_command(
    model: str,
    time_s: NDArray[np.float64],
    command_deg: NDArray[np.float64],
    starts: list[int],
    values: tuple[list[tuple[str, float]], bool],
    report: Optional[Report],
) -> NDArray[np.float64]:
    """The derivatives at each instant by the commands that begin at these rows."""
    if model.startswith("motor-"):
        raise ValueError(f"{model} has no command: it is driven by a duty")
    if len(time_s) * len(starts) > MOST_DERIVATIVES:
        raise MemoryError(
            f"{len(time_s)} rows times {len(starts)} commands, expected {MOST_DERIVATIVES} at most"
        )
    return _native.command_sensitivity(model, time_s, command_deg, starts, values, report)


def of_run(
    model: str,
    settings: Mapping[str, float],
    time_s: NDArray[np.float64],
    command_deg: NDArray[np.float64],
    by: Sequence[str],
    points_s: Optional[NDArray[np.float64]],
    progress: Progress,
) -> dict[str, NDArray[np.float64]]:
    """The derivatives of a simulated run by parameters of the simulator, and by the commands that
    begin at ``points_s``."""
    # The simulator has more than the model.
    values = list(settings.items()), True
    others = [name for name in by if name != COMMAND]
    _, slopes = _native.sensitivity(model, time_s, command_deg, None, values, others)
    found = dict(zip(others, slopes))
    if COMMAND in by:
        if points_s is None:
            raise ValueError(f"gradients by {COMMAND}: expected a `command` of times and angles")
        if settings.get("host_period_s", 0.0) > 0.0:
            raise ValueError(f"gradients by {COMMAND}: expected host_period_s 0")
        # To nanoseconds, so that a time on a row is not beside it.
        rows = np.searchsorted(np.round(time_s, 9), np.round(points_s, 9))
        # The first command also applies before its time.
        rows[:1] = 0
        reached = rows[rows < len(time_s)]
        between = np.abs(time_s[reached] - points_s[: len(reached)]) > 1e-9
        between[1:] |= np.diff(reached) == 0
        if between[1:].any():
            late_s = points_s[1:][between[1 : len(reached)].argmax()]
            raise ValueError(
                f"gradients by {COMMAND}: the command at {late_s} s has no row of its own, "
                "expected `every` to divide the steps of the command"
            )
        by_command = np.zeros((len(time_s), len(rows)))
        with reported(progress, "commands") as report:
            by_command[:, : len(reached)] = _by_command(
                model, time_s, command_deg, reached.tolist(), values, report
            )
        found[COMMAND] = by_command
    return {name: found[name] for name in by}
