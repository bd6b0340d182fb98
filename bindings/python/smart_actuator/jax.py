"""A model's response as a function that jax differentiates; needs the extra ``jax``."""

from __future__ import annotations

from importlib import import_module
from typing import Any, Callable, Sequence, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arguments
from ._choices import FittedModelName
from ._sensitivity import COMMAND, sensitivity


def response(
    model: FittedModelName, time_s: ArrayLike, by: Sequence[str] = (), **parameters: float
) -> Callable[[Any, Any], Any]:
    """The angle of a model at ``time_s`` as a function of its commands and of parameters.

    Its derivatives are those of :func:`sensitivity`, exact to rounding, in reverse mode:
    ``jax.grad`` and ``jax.jit`` take it. jax computes in single precision unless
    ``jax_enable_x64`` is set.

    :param model: a model of :func:`sensitivity` with a command.
    :param time_s: instants, s, of the commands, each held until the next.
    :param by: the parameters that the function takes.
    :param parameters: values of others; the rest are defaults.
    :returns: ``angle_deg = function(command_deg, values)`` with arrays of the length of ``time_s``,
        and ``values`` in the order of ``by``.
    """
    # Without its types, which the extra has and a check without it lacks.
    jax: Any = import_module("jax")
    times, names = _arguments.row("time_s", time_s), _arguments.names("by", by)
    # An error of the arguments is raised here, and not within a call of jax.
    checked: dict[str, Any] = {**parameters}
    sensitivity(model, times, np.zeros(len(times)), names, **checked)

    def evaluated(
        commands: NDArray[Any], values: NDArray[Any], columns: Sequence[str]
    ) -> tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]:
        given: dict[str, Any] = {**parameters, **dict(zip(names, map(float, np.asarray(values))))}
        return sensitivity(model, times, np.asarray(commands), columns, **given)

    def angle_of(commands: NDArray[Any], values: NDArray[Any]) -> NDArray[Any]:
        return evaluated(commands, values, [])[0].astype(commands.dtype)

    def slopes_of(commands: NDArray[Any], values: NDArray[Any]) -> tuple[NDArray[Any], ...]:
        angle, slopes = evaluated(commands, values, [COMMAND, *names])
        columns = [slopes[name] for name in names]
        by_values = np.stack(columns, axis=1) if names else np.zeros((len(times), 0))
        # As jax has the arguments: single precision by default.
        return tuple(each.astype(commands.dtype) for each in (angle, slopes[COMMAND], by_values))

    def shape(commands: Any, *sizes: int) -> Any:
        return jax.ShapeDtypeStruct((len(times), *sizes), commands.dtype)

    def plain(commands: Any, values: Any) -> Any:
        call = (angle_of, shape(commands), commands, values)
        return jax.pure_callback(*call, vmap_method="sequential")

    def forward(commands: Any, values: Any) -> Any:
        shapes = shape(commands), shape(commands, len(times)), shape(commands, len(names))
        call = (slopes_of, shapes, commands, values)
        angle, *slopes = jax.pure_callback(*call, vmap_method="sequential")
        return angle, slopes

    def backward(slopes: Any, weights: Any) -> Any:
        by_command, by_values = slopes
        return weights @ by_command, weights @ by_values

    function = jax.custom_vjp(plain)
    function.defvjp(forward, backward)
    return cast(Callable[[Any, Any], Any], function)
