"""Derivatives of a response by parameters."""

from __future__ import annotations

from typing import Mapping, Optional, Sequence, Tuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arguments, _native


def sensitivity(
    model: str,
    time_s: ArrayLike,
    command_deg: ArrayLike,
    by: Sequence[str],
    *,
    duty_pct: Optional[ArrayLike] = None,
    **parameters: float,
) -> Tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]:
    """The angle of a model and its derivatives by parameters, exact to rounding.

    They are computed by dual numbers in the solver of :func:`identify`, with the instants of its
    events: where a limit begins to act they are one-sided.

    :param model: a model that can be identified: ``black-box-1``, ``black-box-2``,
        ``black-box-2-oscillator``, ``grey-box``, ``motor-m1`` to ``motor-m6`` (from a duty) and
        ``servo-m1`` to ``servo-m6``. The board computes in fixed point and has no derivatives.
    :param time_s: instants, s, of commands that are each held until the next.
    :param command_deg: commands, deg.
    :param by: names of parameters. A gain and an offset on the command are ``gain`` and
        ``offset_deg`` of the black boxes.
    :param duty_pct: duty of a motor, %.
    :param parameters: values; the others are defaults.
    :returns: the angle at each instant, deg, and its derivative by each parameter.
    """
    times, commands = (
        _arguments.array("time_s", time_s),
        _arguments.array("command_deg", command_deg),
    )
    duty = None if duty_pct is None else _arguments.array("duty_pct", duty_pct)
    names = [_arguments.text("name of a parameter", name) for name in by]
    angle, slopes = _native.sensitivity(
        _arguments.text("model", model), times, commands, duty, _arguments.pairs(parameters), names
    )
    return angle, dict(zip(names, slopes))


def of_run(
    model: str,
    settings: Mapping[str, float],
    time_s: NDArray[np.float64],
    command_deg: NDArray[np.float64],
    by: Sequence[str],
) -> dict[str, NDArray[np.float64]]:
    """The derivatives of a simulated run by parameters of the simulator."""
    names = [_arguments.text("gradient", name) for name in by]
    _, slopes = _native.sensitivity(model, time_s, command_deg, None, list(settings.items()), names)
    return dict(zip(names, slopes))
