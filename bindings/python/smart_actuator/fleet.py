"""Identification of many recordings on all cores or on a Dask cluster: a table with a row a fit.

>>> from smart_actuator import fleet
>>> table = fleet.identify(sorted(pathlib.Path("runs").glob("*.csv")), out="fits")  # doctest: +SKIP
>>> fleet.page(table, "fleet.html")  # doctest: +SKIP

Needs pyarrow. A fit that fails is a row with its ``error``.
"""

from __future__ import annotations

import concurrent.futures
import html
import json
import multiprocessing
import os
import pathlib
import warnings
from typing import Any, Callable, Dict, Iterable, Iterator, List, NamedTuple, Optional, Sequence, Union

import numpy as np

from ._choices import FittedModelName
from ._identify import FitWarning, identify as _identify

Path = Union[str, "os.PathLike[str]"]
Row = Dict[str, Any]

#: Fits in one file of the table: what is lost where a campaign is interrupted.
_ROWS_PER_FILE = 64

#: Distance from the median, in standard deviations estimated from the quartiles, of an outlier.
_OUTLIER = 5.0


class _Recording(NamedTuple):
    """A file, or a joint in an episode of a LeRobot data set."""

    path: str
    episode: Optional[int] = None
    joint: Optional[str] = None

    @property
    def name(self) -> str:
        return self.path if self.joint is None else f"{self.path}: episode {self.episode}, {self.joint}"


def identify(
    paths: Union[Path, Iterable[Path]],
    *,
    out: Path,
    model: FittedModelName = "black-box-1",
    client: Any = None,
    processes: Optional[int] = None,
    **options: Any,
) -> Any:
    """Fits a model to each recording, and returns a ``pyarrow.Table`` with a row a recording.

    :param paths: files, as :func:`smart_actuator.identify` takes them, or folders with LeRobot data
        sets, of which each joint in each episode is a recording.
    :param out: a folder for the rows, files of Parquet. Recordings that have a row in it are not
        fitted again: an interrupted campaign goes on.
    :param client: a ``dask.distributed.Client``, on whose workers the fits run.
    :param processes: number of processes without a client; by default one per core.
    :param options: those of :func:`smart_actuator.identify`.
    """
    folder = pathlib.Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    done = set(_read(folder)["path"].to_pylist()) if any(folder.glob("*.parquet")) else set()
    all_paths = [paths] if isinstance(paths, (str, os.PathLike)) else paths
    given = dict.fromkeys(one for path in all_paths for one in _recordings(str(os.fspath(path))))
    left = [recording for recording in given if recording.name not in done]
    number = len(list(folder.glob("*.parquet")))
    for rows in _chunks(_rows(left, {"models": model, **options}, client, processes)):
        _write(rows, folder / f"{number:06d}.parquet")
        number += 1
    return _read(folder)


def _recordings(path: str) -> List[_Recording]:
    if not os.path.isdir(path):
        return [_Recording(path)]
    import pyarrow.compute
    import pyarrow.parquet

    data = pyarrow.parquet.read_table(os.path.join(path, "data"), columns=["episode_index"])
    episodes = sorted(pyarrow.compute.unique(data["episode_index"]).to_pylist())
    return [_Recording(path, episode, joint) for episode in episodes for joint in _joints(path)]


def _joints(folder: str) -> List[str]:
    with open(os.path.join(folder, "meta", "info.json"), encoding="utf-8") as file:
        names = json.load(file)["features"]["observation.state"]["names"]
    return list(next(iter(names.values()))) if isinstance(names, dict) else list(names)


def _data(recording: _Recording) -> Any:
    if recording.joint is None:
        return recording.path
    import pyarrow.parquet

    columns = ("timestamp", "action", "observation.state")
    rows = pyarrow.parquet.read_table(
        os.path.join(recording.path, "data"),
        columns=list(columns),
        filters=[("episode_index", "=", recording.episode)],
    )
    time_s, command, angle = (np.array(rows[name].to_pylist(), float) for name in columns)
    place = _joints(recording.path).index(recording.joint)
    return {"time_s": time_s, "command_deg": command[:, place], "angle_deg": angle[:, place]}


def fit(recording: _Recording, options: Dict[str, Any]) -> Row:
    """The row of a recording."""
    row: Row = {"path": recording.name, "time": None, "error": None}
    try:
        row["time"] = os.stat(recording.path).st_mtime
        # Thousands of recordings have more warnings than anybody reads.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", FitWarning)
            found = _identify(_data(recording), threads=1, **options)["models"][0]
    except (OSError, ValueError, KeyError) as error:
        return {**row, "error": str(error)}
    row.update(model=found["name"], fit_percent=found["fit_percent"], noise_deg=found["noise_deg"])
    for p in found["parameters"]:
        if p["experiment"] is None and not p["fixed"]:
            row[p["name"]] = p["estimate"]
            row[p["name"] + "_error"] = p["standard_error_coloured"] if p["identifiable"] else None
    return row


def _rows(left: List[_Recording], options: Dict[str, Any], client: Any, processes: Optional[int]) -> Iterator[Row]:
    if client is not None:
        import distributed

        completed: Any = distributed.as_completed
        futures = client.map(fit, left, options=options, pure=False)
        yield from (future.result() for future in completed(futures))
        return
    # A fork of a program with threads may hang.
    pool = concurrent.futures.ProcessPoolExecutor(processes, multiprocessing.get_context("spawn"))
    with pool:
        futures = [pool.submit(fit, recording, options) for recording in left]
        try:
            yield from (future.result() for future in concurrent.futures.as_completed(futures))
        finally:
            pool.shutdown(wait=True, cancel_futures=True)


def _chunks(rows: Iterator[Row]) -> Iterator[List[Row]]:
    chunk: List[Row] = []
    try:
        for row in rows:
            chunk.append(row)
            if len(chunk) == _ROWS_PER_FILE:
                yield chunk
                chunk = []
    except KeyboardInterrupt:
        if chunk:
            yield chunk
        raise
    if chunk:
        yield chunk


def _write(rows: List[Row], path: pathlib.Path) -> None:
    import pyarrow
    import pyarrow.parquet

    names = dict.fromkeys(name for row in rows for name in row)
    texts = ("path", "error", "model")
    columns = {
        name: pyarrow.array([row.get(name) for row in rows], pyarrow.string() if name in texts else pyarrow.float64())
        for name in names
    }
    # Whole or not at all: an interrupted campaign leaves no cut file.
    part = path.with_suffix(".part")
    pyarrow.parquet.write_table(pyarrow.table(columns), part)
    part.rename(path)


def _read(folder: pathlib.Path) -> Any:
    import pyarrow
    import pyarrow.parquet

    files = sorted(folder.glob("*.parquet"))
    tables = [pyarrow.parquet.read_table(file) for file in files]
    return pyarrow.concat_tables(tables, promote_options="default") if tables else pyarrow.table({"path": []})


def outliers(table: Any) -> Dict[str, List[str]]:
    """The recordings with an unusual value of a parameter, by its name."""
    found: Dict[str, List[str]] = {}
    for name, values in _parameters(table).items():
        centre, spread = _scale(values)
        off = np.abs(values - centre) > _OUTLIER * spread
        paths = [path for path, is_off in zip(table["path"].to_pylist(), off) if is_off]
        if paths and spread > 0:
            found[name] = paths
    return found


def _parameters(table: Any) -> Dict[str, Any]:
    """The values of each estimated parameter; NaN where it is not identifiable."""
    columns: Dict[str, Any] = {}
    for name in table.column_names:
        if name + "_error" in table.column_names:
            values = table[name].to_numpy(zero_copy_only=False).astype(float)
            known = table[name + "_error"].to_numpy(zero_copy_only=False).astype(float)
            columns[name] = np.where(np.isfinite(known), values, np.nan)
    return columns


def _scale(values: Any) -> "tuple[float, float]":
    finite = values[np.isfinite(values)]
    if not len(finite):
        return np.nan, np.nan
    low, centre, high = np.percentile(finite, [25, 50, 75])
    # The quartiles of a normal distribution are 1.349 standard deviations apart.
    return float(centre), float(high - low) / 1.349


def page(table: Any, path: Path) -> None:
    """Writes a page: the distribution of each parameter, its course over time, and the outliers.

    The time of a recording is that of its file.
    """
    unusual = outliers(table)
    failed = [row for row in table.to_pylist() if row["error"]]
    parts = [f"<h1>{len(table)} recordings, {len(failed)} without a fit</h1>"]
    times = table["time"].to_numpy(zero_copy_only=False).astype(float)
    for name, values in _parameters(table).items():
        centre, spread = _scale(values)
        named = "".join(f"<li>{html.escape(path)}</li>" for path in unusual.get(name, []))
        parts.append(
            f"<h2>{html.escape(name)}</h2><p>median {centre:.5g}, standard deviation {spread:.3g}</p>"
            f"{_histogram(values)}{_course(times, values)}" + (f"<p>Outliers</p><ul>{named}</ul>" if named else "")
        )
    parts += [f"<p>{html.escape(row['path'])}: {html.escape(row['error'])}</p>" for row in failed]
    text = "<!doctype html><meta charset=utf-8><title>Fleet</title>" + "\n".join(parts)
    pathlib.Path(path).write_text(text, encoding="utf-8")


def _svg(content: str, caption: str) -> str:
    return f'<svg width=400 height=120 role=img><title>{caption}</title>{content}</svg>'


def _histogram(values: Any) -> str:
    counts, _ = np.histogram(values[np.isfinite(values)], 40)
    scale = 110 / max(1, counts.max(initial=0))
    bars = (f'<rect x={10 * i} y={115 - scale * n:.1f} width=9 height={scale * n:.1f} />' for i, n in enumerate(counts))
    return _svg("".join(bars), "distribution")


def _course(times: Any, values: Any) -> str:
    known = np.isfinite(times) & np.isfinite(values)
    place: Callable[[Any], Any] = lambda v: (v - v.min(initial=np.inf)) / (np.ptp(v) or 1.0) if len(v) else v
    points: Sequence[Any] = list(zip(place(times[known]), place(values[known])))
    dots = (f'<circle cx={5 + 390 * x:.1f} cy={115 - 110 * y:.1f} r=2 />' for x, y in points)
    return _svg("".join(dots), "over time")
