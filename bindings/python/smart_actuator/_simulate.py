"""Single runs and campaigns."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Mapping, Optional, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arguments, _native
from ._arguments import Points
from ._choices import InputName, ModelName, PlantName, PresetName, PwmName
from ._progress import Progress, reported
from ._sensitivity import of_run
from ._trace import Trace

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._parameters import ModelParameters

#: The fields that :func:`monte_carlo` returns for each run.
EXTREMES = np.dtype(
    [
        (name, np.float64)
        for name in (
            "least_angle_deg",
            "greatest_angle_deg",
            "least_rate_deg_s",
            "greatest_rate_deg_s",
            "last_angle_deg",
            "last_rate_deg_s",
        )
    ]
)


def simulate(
    model: ModelName = "board",
    *,
    plant: Optional[PlantName] = None,
    preset: Optional[PresetName] = None,
    input: Optional[InputName] = None,
    input_parameters: Optional[Mapping[str, float]] = None,
    command: Optional[Points] = None,
    duration: Optional[float] = None,
    every: int = 20,
    seed: int = 0,
    pwm: PwmName = "average",
    load: Optional[Points] = None,
    progress: Progress = False,
    gradients: Sequence[str] = (),
    **parameters: Unpack[ModelParameters],
) -> Trace:
    """Runs a model on an input and records it. An interrupt ends it.

    :param model: ``board`` (the board's fixed-point control around a motor), ``grey-box``,
        ``black-box-1`` or ``black-box-2``.
    :param plant: the plant behind the board: ``first-order`` (default) or ``bench``.
    :param preset: an interpretation of the paper; :func:`presets` lists them.
    :param input: an input by name; :func:`inputs` lists them. ``pulse`` unless there is a
        ``command``.
    :param input_parameters: parameters of the input by name, such as ``{"amplitude_deg": 5.0}``.
    :param command: in place of ``input``: times, s, and commands, deg, each held until the next; or
        a trace, a data frame or a mapping with the columns ``time_s`` and ``command_deg``.
    :param duration: how long to run, s, up to 1e7; by default as long as the input.
    :param every: ticks of 50 us between rows. 20 is 1 ms.
    :param seed: of the random numbers.
    :param pwm: ``average`` or ``switched``.
    :param load: times, s, and torques on the load of the bench, Nm; or columns ``time_s`` and
        ``load_torque_nm``.
    :param progress: True for a bar on standard error, or a function that is called with the
        simulated time and that of the whole run, s.
    :param gradients: parameters by which the angle is differentiated, of a black box or the grey
        box, and ``command_deg`` for the angles of ``command``: :attr:`Trace.gradients`. The command
        counts as held between the rows, so that ``every`` must divide its steps.
    :param parameters: of the model, by name or symbol; :func:`parameters` lists them with units.
    :raises KeyError: a parameter that does not exist.
    :raises ValueError: a value out of range or in conflict with another, or an unknown name.
    :raises TypeError: an argument of another type.
    :raises MemoryError: more than 2**29 numbers.
    """
    request = _arguments.request(
        model=model,
        plant=plant,
        preset=preset,
        input=input,
        input_parameters=input_parameters,
        command=command,
        duration=duration,
        every=every,
        seed=seed,
        pwm=pwm,
        load=load,
        parameters=parameters,
    )
    differentiated = _arguments.names("gradients", gradients)
    with reported(progress, "s") as report:
        trace = Trace(*_native.simulate(request, report))
    if differentiated:
        actuator = _native.Actuator(model, plant, preset, seed, pwm, request["parameters"])
        values = actuator.settings["parameters"]
        points_s = None if request["command"] is None else request["command"][0]
        rows = trace["time_s"], trace["command_deg"]
        slopes = of_run(model, values, *rows, differentiated, points_s, progress)
        trace.gradients.update(slopes)
    return trace


def monte_carlo(
    parameters: Mapping[str, ArrayLike],
    *,
    model: ModelName = "board",
    plant: Optional[PlantName] = None,
    preset: Optional[PresetName] = None,
    input: Optional[InputName] = None,
    input_parameters: Optional[Mapping[str, float]] = None,
    command: Optional[Points] = None,
    duration: Optional[float] = None,
    every: int = 20,
    seed: int = 0,
    pwm: PwmName = "average",
    load: Optional[Points] = None,
    threads: Optional[int] = None,
    progress: Progress = False,
    **fixed: Unpack[ModelParameters],
) -> NDArray[Any]:
    """Runs a model once for each element of parameter arrays, on all cores.

    The global interpreter lock is released during the runs; an interrupt ends them.

    :param parameters: arrays by the name or symbol of a parameter, broadcast against each other;
        a parameter of the input is called ``input.NAME``.
    :param every: ticks of 50 us between two evaluated samples of a run; 20 (1 ms) is fastest.
    :param threads: number of threads; by default one per core. Use 1 within a distributed engine
        that has a worker on each core.
    :param progress: True for a bar on standard error, or a function that is called with the numbers
        of finished runs and of all runs.
    :param fixed: parameters that are the same in all runs.
    :returns: an array of the broadcast shape with the fields ``least_angle_deg``,
        ``greatest_angle_deg``, ``least_rate_deg_s``, ``greatest_rate_deg_s``, ``last_angle_deg``
        and ``last_rate_deg_s``: extremes and final state of each run.
    :raises ValueError: also for arrays that do not broadcast; an error of one run names the run.

    The other arguments and exceptions are those of :func:`simulate`.
    """
    request = _arguments.request(
        model=model,
        plant=plant,
        preset=preset,
        input=input,
        input_parameters=input_parameters,
        command=command,
        duration=duration,
        every=every,
        seed=seed,
        pwm=pwm,
        load=load,
        parameters=fixed,
    )
    if not isinstance(parameters, Mapping) or not parameters:
        raise TypeError("parameters: expected a mapping from names to arrays, at least one")
    arrays_by_name = _arguments.items("parameters", parameters)
    names = [name for name, _ in arrays_by_name]
    arrays = [_arguments.array(f"parameter {name}", value) for name, value in arrays_by_name]
    try:
        arrays = list(np.broadcast_arrays(*arrays))
    except ValueError:
        shapes = ", ".join(f"{name} {a.shape}" for name, a in zip(names, arrays))
        raise ValueError(f"parameters are {shapes}, expected shapes that broadcast") from None
    values = np.stack([a.ravel() for a in arrays], axis=1)
    count = _arguments.thread_count(threads)
    with reported(progress, "runs") as report:
        ends = _native.monte_carlo(request, names, values, count, report)
    return ends.view(EXTREMES).reshape(arrays[0].shape)
