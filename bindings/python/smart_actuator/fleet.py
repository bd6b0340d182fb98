"""Identification of many recordings on all cores or on a Dask cluster: a table with a row a fit.

>>> from smart_actuator import fleet
>>> table = fleet.identify(sorted(pathlib.Path("runs").glob("*.csv")), out="fits")  # doctest: +SKIP
>>> fleet.page(table, "fleet.html")  # doctest: +SKIP

Needs pyarrow. A fit that fails is a row with its ``error``, and is tried again by the next call.
"""

from __future__ import annotations

import concurrent.futures
import hashlib
import json
import multiprocessing
import os
import pathlib
import re
import tempfile
import warnings
from datetime import datetime, timezone
from typing import Any, Dict, Iterable, Iterator, List, NamedTuple, Optional, Tuple, Union

import numpy as np

from ._choices import FittedModelName
from ._fleet_page import outliers, page
from ._identify import FitWarning, identify as _identify
from ._native import __version__

__all__ = ["fit", "identify", "outliers", "page"]

Path = Union[str, "os.PathLike[str]"]
Row = Dict[str, Any]

#: Fits in one file of the table: what is lost where a campaign is interrupted.
_ROWS_PER_FILE = 64

#: A date with a time of day at the start of a file.
_DATE = re.compile(rb"\d{4}-\d\d-\d\d[T ]\d\d:\d\d:\d\d")

#: The bytes of a file in which it is looked for: a header and a row.
_HEAD = 4096

#: Columns of the table with texts, and with whole numbers; others have real numbers.
_TEXTS = ("path", "state", "joint", "model", "error")
_WHOLE = ("episode",)


class _Recording(NamedTuple):
    """A file, or a joint in an episode of a LeRobot data set."""

    path: str
    #: Changes with the content.
    state: str
    episode: Optional[int] = None
    joint: Optional[str] = None

    @property
    def name(self) -> str:
        if self.joint is None:
            return self.path
        return f"{self.path}: episode {self.episode}, {self.joint}"


def identify(
    paths: Union[Path, Iterable[Path]],
    *,
    out: Optional[Path] = None,
    model: FittedModelName = "black-box-1",
    client: Any = None,
    processes: Optional[int] = None,
    **options: Any,
) -> Any:
    """Fits a model to each recording, and returns a ``pyarrow.Table`` with a row a recording.

    :param paths: files, as :func:`smart_actuator.identify` takes them, or folders with LeRobot data
        sets, of which each joint in each episode is a recording.
    :param out: a folder that keeps the rows, files of Parquet. A recording that has a row there is
        not fitted again, so that an interrupted campaign goes on, unless its file, the model, the
        options or the version of this package are others.
    :param client: a ``dask.distributed.Client``, on whose workers the fits run.
    :param processes: number of processes without a client; by default one per core.
    :param options: those of :func:`smart_actuator.identify`.
    """
    if out is None:
        with tempfile.TemporaryDirectory() as folder:
            return identify(
                paths, out=folder, model=model, client=client, processes=processes, **options
            )
    all_options = {"models": model, **options}
    all_paths = [paths] if isinstance(paths, (str, os.PathLike)) else paths
    given = list(dict.fromkeys(one for path in all_paths for one in _recordings(os.fspath(path))))
    rows = _Rows(pathlib.Path(out), _digest(__version__, all_options))
    done = rows.fitted()
    left = [recording for recording in given if (recording.name, recording.state) not in done]
    for chunk in _chunks(_rows(left, all_options, client, processes)):
        rows.add(chunk)
    return rows.of(given)


def _digest(*parts: Any) -> str:
    text = json.dumps(parts, sort_keys=True, default=repr)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _recordings(path: str) -> List[_Recording]:
    if not os.path.isdir(path):
        return [_Recording(path, _state([path]))]
    import pyarrow.compute
    import pyarrow.parquet

    data = pyarrow.parquet.read_table(os.path.join(path, "data"), columns=["episode_index"])
    episodes = sorted(pyarrow.compute.unique(data["episode_index"]).to_pylist())
    state = _state(sorted(pathlib.Path(path).glob("data/**/*")))
    return [
        _Recording(path, state, episode, joint) for episode in episodes for joint in _joints(path)
    ]


def _state(files: Iterable[Path]) -> str:
    try:
        found = [(str(file), os.stat(file)) for file in files]
    except OSError:
        # The fit says so.
        return ""
    return _digest([(name, of.st_size, of.st_mtime_ns) for name, of in found])


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


def _time(path: str) -> float:
    """The first date in a file, else the time of the file itself, s since 1970."""
    if not os.path.isdir(path):
        with open(path, "rb") as file:
            found = _DATE.search(file.read(_HEAD))
        if found:
            date = datetime.fromisoformat(found[0].decode())
            return date.replace(tzinfo=timezone.utc).timestamp()
    return os.stat(path).st_mtime


def fit(recording: _Recording, options: Dict[str, Any]) -> Row:
    """The row of a recording."""
    row: Row = {
        "path": recording.name,
        "state": recording.state,
        "joint": recording.joint,
        "episode": recording.episode,
        "time": None,
        "error": None,
    }
    try:
        row["time"] = _time(recording.path)
        # Thousands of recordings have more warnings than anybody reads.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", FitWarning)
            found = _identify(_data(recording), threads=1, **options)["models"][0]
    except (OSError, ValueError, KeyError, ImportError) as error:
        return {**row, "error": str(error)}
    row.update(model=found["name"], fit_percent=found["fit_percent"], noise_deg=found["noise_deg"])
    for p in found["parameters"]:
        if p["experiment"] is None and not p["fixed"]:
            row[p["name"]] = p["estimate"]
            row[p["name"] + "_error"] = p["standard_error_coloured"] if p["identifiable"] else None
    return row


def _rows(
    left: List[_Recording], options: Dict[str, Any], client: Any, processes: Optional[int]
) -> Iterator[Row]:
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


class _Rows:
    """The rows of fits with the same options in a folder."""

    def __init__(self, folder: pathlib.Path, options: str) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self.folder, self.options = folder, options

    def files(self) -> List[pathlib.Path]:
        return sorted(self.folder.glob(f"{self.options}-*.parquet"))

    def table(self) -> Any:
        import pyarrow
        import pyarrow.parquet

        tables = [pyarrow.parquet.read_table(file) for file in self.files()]
        return pyarrow.concat_tables(tables, promote_options="default") if tables else _table([])

    def fitted(self) -> "set[Tuple[str, str]]":
        rows = self.table().select(["path", "state", "error"]).to_pylist()
        return {(row["path"], row["state"]) for row in rows if row["error"] is None}

    def of(self, recordings: List[_Recording]) -> Any:
        """The last row of each recording."""
        table = self.table()
        names = zip(table["path"].to_pylist(), table["state"].to_pylist())
        last = {name: index for index, name in enumerate(names)}
        return table.take([last[recording.name, recording.state] for recording in recordings])

    def add(self, rows: List[Row]) -> None:
        import pyarrow.parquet

        path = self.folder / f"{self.options}-{len(self.files()):06d}.parquet"
        # Whole or not at all: an interrupted campaign leaves no cut file.
        part = path.with_suffix(".part")
        pyarrow.parquet.write_table(_table(rows), part)
        part.rename(path)


def _table(rows: List[Row]) -> Any:
    import pyarrow

    types = dict.fromkeys(_TEXTS, pyarrow.string())
    types.update(dict.fromkeys(_WHOLE, pyarrow.int64()))
    names = dict.fromkeys([*_TEXTS, *_WHOLE, "time", *(name for row in rows for name in row)])
    columns = {
        name: pyarrow.array([row.get(name) for row in rows], types.get(name, pyarrow.float64()))
        for name in names
    }
    return pyarrow.table(columns)
