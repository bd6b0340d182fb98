"""The models as systems of python-control."""

from __future__ import annotations

from typing import Any, Optional

import numpy as np

from . import _arguments, _native
from ._choices import LoopName, ModelName, PresetName

#: Of an approximation of a delay: a higher one is lost in rounding.
_HIGHEST_ORDER = 20


def _values(model: str, preset: Optional[PresetName], given: dict[str, float]) -> dict[str, float]:
    _arguments.warn(preset)
    plant = "first-order" if model == "board" else None
    actuator = _native.Actuator(model, plant, preset, 0, "average", _arguments.pairs("parameters", given))
    return actuator.settings["parameters"]


def to_control(
    model: ModelName = "grey-box",
    *,
    preset: Optional[PresetName] = None,
    loop: LoopName = "closed",
    pade: int = 0,
    **parameters: float,
) -> Any:
    """The linear part of a model, without limits, as a system of python-control (optional).

    ``control.margin(sa.to_control(loop="open"))`` are the margins of the position loop,
    ``control.bode_plot(sa.to_control())`` is its response.

    :param model: ``black-box-1``, ``black-box-2``, ``grey-box``, or ``board``: its loops in
        continuous time around the first-order motor, with the mean delay of the sampled control:
        1.5 control periods for the hold and the computation with ``pade``.
    :param preset: as for :func:`simulate`, as are ``parameters``.
    :param loop: ``closed`` (command to angle), ``open`` (position error to angle; of grey box and
        board), ``rate`` (commanded rate to rate; likewise) or ``motor`` (duty to rate; likewise).
    :param pade: order of an approximation of the transport delay ``delay_s`` at the command, up to
        20; the delay is left out for 0.
    :returns: a ``control.TransferFunction`` in deg and s.
    """
    import control

    _arguments.text("loop", loop)
    given = _values(_arguments.text("model", model), preset, parameters)
    order = _arguments.whole("pade", pade, 0, _HIGHEST_ORDER)
    s = control.tf("s")
    if model == "black-box-1":
        systems = {"closed": given["gain"] * given["pole_rad_s"] / (s + given["pole_rad_s"])}
    elif model == "black-box-2":
        position, rate = given["position_gain_per_s2"], given["rate_gain_per_s"]
        systems = {"closed": given.get("gain", 1.0) * position / (s**2 + rate * s + position)}
    else:
        gain = 0.5 * (given["motor_gain_up"] + given["motor_gain_down"])
        motor = gain / (given["motor_time_constant_s"] * s + 1)
        regulator = given["proportional_gain"] + given["integral_gain"] / s
        # By polynomials, so that no common factors appear.
        rate = control.feedback(regulator * motor, 1)
        open_loop = given["position_gain"] * rate / s
        if model == "board":
            sampled = control.tf(*control.pade(1.5 * 0.004, max(order, 1)))
            open_loop = open_loop * sampled if order else open_loop
        systems = {
            "motor": motor,
            "rate": rate,
            "open": open_loop,
            "closed": control.feedback(open_loop, 1),
        }
    if loop not in systems:
        raise ValueError(f"loop is {loop!r}, expected {', '.join(sorted(systems))} of {model}")
    system = systems[loop]
    if order and loop == "closed" and given["delay_s"] > 0:
        system = system * control.tf(*control.pade(given["delay_s"], order))
    system = control.minreal(system, verbose=False)
    # The coefficients as numbers, not arrays of them.
    return control.tf(np.ravel(system.num[0][0]), np.ravel(system.den[0][0]))
