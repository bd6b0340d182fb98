"""What the table of a fleet shows: distributions, courses over time, and outliers."""

from __future__ import annotations

import html
import os
import pathlib
from datetime import datetime, timezone
from typing import Any, Callable, Dict, Iterator, List, Tuple, Union

import numpy as np

#: Distance from the median, in standard deviations estimated from the quartiles, of an outlier.
_OUTLIER = 5.0

#: Of a plot: the size of its field, and the place of the field's upper left corner.
_WIDTH, _HEIGHT, _LEFT, _TOP = 400, 110, 60, 5


def outliers(table: Any) -> Dict[str, List[str]]:
    """The recordings with an unusual value of a parameter among those of the joint, by its name."""
    found: Dict[str, List[str]] = {}
    for _, rows in _joints(table):
        for name, values in _parameters(rows).items():
            if paths := _unusual(rows, values):
                found.setdefault(name, []).extend(paths)
    return found


def _joints(table: Any) -> Iterator[Tuple[str, Any]]:
    """The rows of each joint, in their order: files have no joint, and are one group."""
    import pyarrow

    names = table["joint"].to_pylist()
    for name in dict.fromkeys(names):
        rows = table.filter(pyarrow.array([each == name for each in names]))
        keys = [(column, "ascending") for column in ("time", "path", "episode")]
        order = keys if name is None else keys[:1] + keys[2:]
        yield name or "", rows.sort_by(order)


def _unusual(rows: Any, values: Any) -> List[str]:
    centre, spread = _scale(values)
    off = np.abs(values - centre) > _OUTLIER * spread
    paths = [path for path, is_off in zip(rows["path"].to_pylist(), off) if is_off]
    return paths if spread > 0 else []


def _parameters(table: Any) -> Dict[str, Any]:
    """The values of each estimated parameter; NaN where it is not identifiable."""
    columns: Dict[str, Any] = {}
    for name in table.column_names:
        if name + "_error" in table.column_names:
            values = _numbers(table[name])
            known = _numbers(table[name + "_error"])
            columns[name] = np.where(np.isfinite(known), values, np.nan)
    return columns


def _numbers(column: Any) -> Any:
    return column.to_numpy(zero_copy_only=False).astype(float)


def _scale(values: Any) -> Tuple[float, float]:
    finite = values[np.isfinite(values)]
    if not len(finite):
        return np.nan, np.nan
    low, centre, high = np.percentile(finite, [25, 50, 75])
    # The quartiles of a normal distribution are 1.349 standard deviations apart.
    return float(centre), float(high - low) / 1.349


def page(table: Any, path: Union[str, "os.PathLike[str]"]) -> None:
    """Writes a page: of each parameter of each joint the distribution, the course and outliers.

    The course of a LeRobot data set is that over its episodes. Other recordings have the first date
    in their file, or else the time of the file.
    """
    failed = [row for row in table.to_pylist() if row["error"]]
    parts = [f"<h1>{len(table)} recordings, {len(failed)} without a fit</h1>"]
    for joint, rows in _joints(table):
        for name, values in _parameters(rows).items():
            centre, spread = _scale(values)
            unusual = "".join(f"<li>{html.escape(each)}</li>" for each in _unusual(rows, values))
            title = html.escape(f"{joint}: {name}" if joint else name)
            parts.append(
                f"<h2>{title}</h2>"
                f"<p>median {centre:.5g}, standard deviation {spread:.3g}</p>"
                f"{_histogram(values)}{_course(rows, values)}"
                + (f"<p>Outliers</p><ul>{unusual}</ul>" if unusual else "")
            )
    parts += [f"<p>{html.escape(row['path'])}: {html.escape(row['error'])}</p>" for row in failed]
    text = "<!doctype html><meta charset=utf-8><title>Fleet</title>" + "\n".join(parts)
    pathlib.Path(path).write_text(text, encoding="utf-8")


def _plot(content: str, caption: str, x: List[str], y: List[str]) -> str:
    """A plot with labels at the ends and in the middle of its axes."""
    right, bottom = _LEFT + _WIDTH, _TOP + _HEIGHT
    lines = f"M{_LEFT} {_TOP}V{bottom}H{right}"
    labels = ""
    for i, (below, beside) in enumerate(zip(x, y)):
        at_x, at_y = _LEFT + _WIDTH * i // 2, bottom - _HEIGHT * i // 2
        lines += f"M{at_x} {bottom}v4M{_LEFT} {at_y}h-4"
        labels += (
            f"<text x={at_x} y={bottom + 16} text-anchor=middle>{below}</text>"
            f"<text x={_LEFT - 6} y={at_y + 4} text-anchor=end>{beside}</text>"
        )
    middle = _LEFT + _WIDTH // 2
    return (
        f"<svg width={right + 50} height={bottom + 36} role=img font-size=11>"
        f'<title>{caption}</title>{content}<path d="{lines}" stroke=black fill=none />{labels}'
        f"<text x={middle} y={bottom + 32} text-anchor=middle>{caption}</text></svg>"
    )


def _histogram(values: Any) -> str:
    finite = values[np.isfinite(values)]
    counts, edges = np.histogram(finite, 40)
    most = max(1, counts.max())
    scale, width = _HEIGHT / most, _WIDTH / 40
    bars = (
        f"<rect x={_LEFT + width * i:.1f} y={_TOP + _HEIGHT - scale * n:.1f}"
        f" width={width - 1:.1f} height={scale * n:.1f} />"
        for i, n in enumerate(counts)
    )
    return _plot("".join(bars), "distribution", _labels(edges), _labels(np.array([0, most])))


def _course(rows: Any, values: Any) -> str:
    text: Callable[[float], str]
    if rows["episode"].null_count:
        caption, times, text = "over time", _numbers(rows["time"]), _date
    else:
        caption, times, text = "over the episodes", np.arange(float(len(rows))), _number
    known = np.isfinite(times) & np.isfinite(values)
    if not known.any():
        return ""
    x, y = times[known], values[known]
    place: Callable[[Any], Any] = lambda v: (v - v.min()) / (np.ptp(v) or 1.0)
    dots = (
        f"<circle cx={_LEFT + _WIDTH * a:.1f} cy={_TOP + _HEIGHT * (1 - b):.1f} r=2 />"
        for a, b in zip(place(x), place(y))
    )
    return _plot("".join(dots), caption, _labels(x, text), _labels(y))


def _number(value: float) -> str:
    return f"{value:.4g}"


def _date(seconds: float) -> str:
    return datetime.fromtimestamp(seconds, timezone.utc).strftime("%Y-%m-%d %H:%M")


def _labels(values: Any, text: Callable[[float], str] = _number) -> List[str]:
    low, high = float(values.min()), float(values.max())
    return [text(value) for value in (low, (low + high) / 2, high)]
