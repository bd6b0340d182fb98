"""Identification: from recordings to the parameters of models."""

from __future__ import annotations

import json
import os
import warnings
from typing import (
    TYPE_CHECKING,
    Any,
    Dict,
    Iterable,
    List,
    Mapping,
    Optional,
    Protocol,
    Sequence,
    Tuple,
    TypedDict,
    Union,
    cast,
    get_args,
)

from numpy.typing import ArrayLike

from . import _arguments, _columns, _files, _native
from ._choices import DelimiterName, FittedModelName, HoldName, LossName, ModelName
from ._progress import Progress, reported

if TYPE_CHECKING:
    from ._parameters import ModelParameters

#: A file, or its columns by name: a trace, a mapping, a data frame or a structured array.
Recording = Union[str, "os.PathLike[str]", Mapping[str, ArrayLike], "DataFrame"]

#: First and last time, s.
Window = Tuple[float, float]

#: A recording, its window and its known constants, for the compiled module.
_Run = Tuple[Any, Optional[Window], List[Tuple[str, float]]]


class DataFrame(Protocol):
    """A table with named columns, as those of pandas, polars and pyarrow."""

    def __getitem__(self, key: Any, /) -> Any: ...


class Estimate(TypedDict):
    """A parameter of a fitted model.

    ``estimate`` is None for a limit that does not act. ``standard_error`` is the Cramer-Rao bound
    for white residuals, ``standard_error_coloured`` that for correlated ones. Both are None for a
    parameter that is fixed, that is at its bound, or that the recordings show only in combination
    with others or not at all. All others have numbers, also where ``identifiable`` is False because
    the error is large, because another parameter has nearly the same effect, or because a simpler
    model fits as well. ``profile`` is the end of the 95 % interval of a parameter at its bound, and
    ``beyond_bound`` by how many standard errors it would be beyond that. ``remark`` says that it is given, at a bound or not identifiable, or that
    its interval may not hold. ``experiment`` is the recording whose own parameter it is, None if
    all recordings share it.
    """

    name: str
    unit: str
    estimate: Optional[float]
    standard_error: Optional[float]
    standard_error_coloured: Optional[float]
    at_bound: bool
    bound: Optional[str]
    bounds: List[Optional[float]]
    profile: Optional[float]
    beyond_bound: float
    identifiable: bool
    fixed: bool
    remark: str
    experiment: Optional[str]


class _Model(TypedDict):
    name: FittedModelName
    model: FittedModelName
    fit_percent: float
    parameters: List[Estimate]
    noise_deg: float
    samples: int
    aic: float
    bic: float
    warnings: List[str]


class FittedModel(_Model, total=False):
    """A fitted model.

    ``fit_percent`` is the normalised root mean square error as a fit, %, ``noise_deg`` the standard
    deviation of the residuals, deg, ``misfit`` compares them with the noise, and ``combinations``
    are what is known of parameters that are not identifiable alone. ``doubts`` are those of the
    ``warnings`` that say why the intervals of the estimates may not cover the true values.
    ``experiments`` and ``validation`` hold figures of merit and
    residual correlations of each recording.
    """

    quality: dict[str, Any]
    validation_quality: Optional[dict[str, Any]]
    cost_deg2: float
    effective_samples: float
    free_parameters: int
    command_is_held: bool
    command_may_be_held: bool
    begins_at_rest: bool
    misfit: dict[str, Any]
    combinations: List[dict[str, Any]]
    correlation: dict[str, Any]
    covariance: List[List[float]]
    covariance_coloured: List[List[float]]
    search: dict[str, Any]
    loss: dict[str, Any]
    doubts: List[str]
    intervals_hold: bool
    experiments: List[dict[str, Any]]
    validation: List[dict[str, Any]]


class Identification(TypedDict):
    """The content of the file that `actuator identify --json` writes."""

    program: str
    version: str
    models: List[FittedModel]
    second_opinion: dict[str, Any]
    notes: List[dict[str, Any]]


class FitWarning(UserWarning):
    """A doubt about a recording or a fit; :func:`identify` also returns it in ``warnings``."""


def identify(
    data: Union[Recording, Sequence[Recording]],
    *,
    models: Union[FittedModelName, Sequence[FittedModelName]] = (
        "black-box-1",
        "black-box-2",
        "grey-box",
    ),
    validate: Union[Recording, Sequence[Recording]] = (),
    fix: Optional[Mapping[str, float]] = None,
    free: Union[str, Sequence[str]] = (),
    bound: Optional[Mapping[str, Tuple[float, float]]] = None,
    start: Optional[Mapping[str, float]] = None,
    own: Union[str, Sequence[str]] = (),
    share: Union[str, Sequence[str]] = (),
    starts: int = 8,
    seed: int = 0,
    loss: LossName = "auto",
    columns: Optional[Mapping[str, str]] = None,
    joint: Optional[str] = None,
    rate_hz: Optional[float] = None,
    delimiter: Optional[DelimiterName] = None,
    window: Union[None, Window, Sequence[Optional[Window]]] = None,
    keep_clipped: bool = False,
    keep_bad: bool = False,
    hold: Optional[HoldName] = None,
    known: Union[None, Mapping[str, float], Sequence[Optional[Mapping[str, float]]]] = None,
    threads: Optional[int] = None,
    progress: Progress = False,
) -> Identification:
    """Fits models to recordings by output error, and estimates the uncertainty of each parameter.

    The global interpreter lock is released during the search; an interrupt ends it. Doubts about
    recordings and fits are warnings of the category :class:`FitWarning`.

    :param data: a recording, or several that one set of parameters is fitted to: files as `actuator
        identify` takes them, Parquet and ``.xlsx`` by pandas, or traces, mappings, data frames and
        structured arrays with the columns ``time_s``, ``command_deg`` and ``angle_meas_deg`` or
        ``angle_deg``, and optionally ``rate_meas_deg_s``, ``duty_pct`` (%), ``current_a`` and
        ``supply_v`` (V). Names and units of columns are found as in files: ``angle_rad`` and
        ``current_ma`` are known as well, other columns are left out. NaN marks a missing value.
    :param models: the models to fit.
    :param validate: recordings that are predicted by the fitted models, but not fitted.
    :param fix: parameters that are held, with their values.
    :param free: parameters to estimate that are held by default.
    :param bound: lower and upper bounds of parameters.
    :param start: values at which the search starts.
    :param own: parameters that have a value of their own for each recording.
    :param share: parameters that have one value for all recordings.
    :param starts: number of starting points of the search, 1 to 1000.
    :param seed: of the starting points.
    :param loss: how residuals count: ``squares``, ``robust`` (Student's distribution), or ``auto``,
        squares unless isolated residuals decide the fit.
    :param columns: the columns by quantity, as ``{"angle": "pos:rad"}``.
    :param joint: the joint of a robot whose columns have its name.
    :param rate_hz: rate of samples at equal intervals, Hz, without a time or with a wrong one.
    :param delimiter: between two fields: ``comma``, ``semicolon``, ``tab`` or ``blanks``.
    :param window: first and last time that are used, s: one pair for all recordings, or a sequence
        with a pair, or None for all of its times, for each recording of ``data`` and then for each
        of ``validate``.
    :param keep_clipped: also compares samples at which the angle of a file is saturated.
    :param keep_bad: also compares samples of a file that look like faults of the sensor or the link.
    :param hold: ``zero`` if the command is constant between two samples, ``smooth`` if it changes;
        by default as the samples show.
    :param known: known constants of the runs by the name of a parameter, which ends in its unit,
        such as ``{"pendulum_mass_kg": 0.5}``: one mapping for all recordings, or a sequence with a
        mapping or None for each, in the order of ``window``.
    :param threads: number of threads; by default one per core.
    :param progress: True for a bar on standard error, or a function that is called with the numbers
        of fitted models and of all models.
    :raises KeyError: a parameter that no model has, a column that is missing.
    :raises OSError: a file that cannot be read.
    :raises ImportError: a file that pandas would read.
    :raises ValueError: a file of another format, with the line; a recording that cannot be used; a
        value out of range; an unknown model.
    :raises TypeError: an argument of another type.
    """
    fitted, held_out = _runs(data, validate, window, known)
    chosen = _names("models", models)
    if not chosen:
        raise ValueError("models is empty, expected at least one model")
    reading = {
        "columns": [(a, _text("columns", b)) for a, b in _arguments.items("columns", columns)],
        "joint": _arguments.optional_text("joint", joint),
        "rate_hz": None if rate_hz is None else _arguments.within("rate_hz", rate_hz, 1e-3, 1e9, "Hz"),
        "delimiter": _arguments.optional_text("delimiter", delimiter),
        "keep_clipped": _arguments.flag("keep_clipped", keep_clipped),
        "keep_bad": _arguments.flag("keep_bad", keep_bad),
        "hold": _arguments.optional_text("hold", hold),
    }
    search = {
        "models": chosen,
        "fix": _arguments.pairs("fix", fix),
        "free": _names("free", free),
        "bound": [(n, *_pair(f"bound {n}", b)) for n, b in _arguments.items("bound", bound)],
        "start": _arguments.pairs("start", start),
        "own": _names("own", own),
        "share": _names("share", share),
        "starts": _arguments.whole("starts", starts, 1, 1000),
        "seed": _arguments.whole("seed", seed),
        "loss": _text("loss", loss),
        "threads": _arguments.thread_count(threads),
    }
    with reported(progress, "models") as report:
        text = _native.identify(fitted, held_out, reading, search, report)
    found: Identification = json.loads(text)
    for note in found["notes"]:
        warnings.warn(note["text"], FitWarning, stacklevel=2)
    for model in found["models"]:
        for doubt in model["warnings"]:
            warnings.warn(f"{model['name']}: {doubt}", FitWarning, stacklevel=2)
    return found


def fitted_parameters(model: FittedModel) -> ModelParameters:
    """The estimates of a fitted model as parameters of the same model of the simulator.

    ``simulate("black-box-2", **fitted_parameters(model))`` runs it. They are the values that
    `actuator identify --parameters` writes: those that were given are among them. Left out are
    parameters that the simulator lacks, those that have a value for each recording, and limits that
    do not act.

    :param model: one of the ``models`` of the result of :func:`identify`.
    :raises ValueError: a model that the simulator does not have by this name. That file has the
        parameters of the bench for a motor, and the gains for ``black-box-2-oscillator``.
    :raises TypeError: an argument of another type.
    """
    if not isinstance(model, Mapping) or not {"model", "parameters"} <= set(model):
        shown = _arguments.shown(model)
        raise TypeError(f'model is {shown}, expected identify(...)["models"][0]')
    name = model["model"]
    simulated = [each for each in get_args(ModelName) if each in get_args(FittedModelName)]
    if name not in simulated:
        raise ValueError(f"model is {name}, expected a fitted one of {', '.join(simulated)}")
    known = {row["name"] for row in _native.parameters(name, None)}
    values = {
        p["name"]: p["estimate"]
        for p in model["parameters"]
        if p["name"] in known and p["experiment"] is None and p["estimate"] is not None
    }
    return cast("ModelParameters", values)


_text = _arguments.text


def _names(name: str, value: Union[str, Sequence[str]]) -> List[str]:
    return _arguments.names(name, [value] if isinstance(value, str) else value)


def _pair(name: str, value: object) -> Tuple[float, float]:
    try:
        low, high = cast(Tuple[float, float], value)
    except (TypeError, ValueError):
        raise TypeError(f"{name} is {_arguments.shown(value)}, expected a pair of numbers") from None
    pair = _arguments.number(name, low), _arguments.number(name, high)
    # Written so that NaN fails.
    if not pair[0] < pair[1]:
        raise ValueError(f"{name} is {_arguments.shown(value)}, expected the smaller number first")
    return pair


def _runs(
    data: object, validate: object, window: object, known: object
) -> Tuple[List[_Run], List[_Run]]:
    """The recordings to fit and those to predict, with the options that each may have of its own."""
    given = _recordings("data", data)
    count = len(given)
    if not count:
        raise ValueError("data is empty, expected at least one recording")
    given.update(_recordings("validate", validate))
    windows = _of_each("window", window, list(given))
    constants = _of_each("known", known, list(given))
    runs = [
        (recording, None if pair is None else _pair(of, pair), _arguments.pairs(*named))
        for recording, (of, pair), named in zip(given.values(), windows, constants)
    ]
    return runs[:count], runs[count:]


def _of_each(name: str, value: Any, recordings: List[str]) -> List[Tuple[str, Any]]:
    """The value of an argument for each recording, with the name that it has in messages.

    A sequence of pairs, mappings or None has one for each recording; anything else is for all.
    """
    if not isinstance(value, Sequence) or not any(map(_may_be_one, value)):
        return [(name, value)] * len(recordings)
    if len(value) != len(recordings):
        shown = _arguments.shown(recordings)
        raise ValueError(
            f"{name} has {len(value)} items, expected {len(recordings)}, one for each of {shown}"
        )
    return [(f"{name} of {recording}", item) for recording, item in zip(recordings, value)]


def _may_be_one(item: object) -> bool:
    """Whether an item of a sequence may be the value of a recording: None, a pair or a mapping."""
    return item is None or (isinstance(item, Iterable) and not isinstance(item, (str, bytes)))


def _recordings(name: str, value: object) -> Dict[str, Any]:
    """The recordings of an argument by their names in messages."""
    if _columns.is_single(value):
        each: List[Any] = [value]
    elif isinstance(value, Iterable):
        each = list(value)
    else:
        raise TypeError(f"{name} is {_arguments.shown(value)}, expected a recording or several")
    named = [(f"{name}[{index}]", one) for index, one in enumerate(each)]
    return {own: _recording(own, one) for own, one in named}


def _recording(name: str, value: object) -> Any:
    if isinstance(value, (str, os.PathLike)):
        value = _files.read(os.fspath(value))
        if isinstance(value, str):
            return value
    named = _columns.of(value)
    if named is None:
        raise TypeError(f"{name} is {_arguments.shown(value)}, expected a file, a mapping of arrays or a data frame")
    columns = {}
    for key, column in named.items():
        array = _arguments.array(f"{name}, {key}", column)
        if array.ndim != 1:
            raise ValueError(f"{name}, {key} has the shape {array.shape}, expected one dimension")
        columns[_text(f"{name}, name of a column", key)] = array
    return columns
