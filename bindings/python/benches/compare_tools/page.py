"""The page of the comparison."""

import datetime
import os
import pathlib
import platform
import subprocess
from importlib.metadata import version
from typing import NamedTuple

import mujoco
import numpy as np

from recordings import BAM_STEP_S
from searches import TOOLS

PAGE = """# Other tools on the same recordings

`bindings/python/benches/compare_tools` has written this page: {date}, commit `{commit}`, {machine},
load {load:.1f}: times are longer than on an idle machine. The recordings are of servos with a pendulum, from
[BAM](https://github.com/Rhoban/bam); the command takes folders with recordings of others:
`python3 bindings/python/benches/compare_tools FOLDER ...`.

## Prediction

Each recording is predicted by models that are fitted to the other ones of the servo. Mean absolute
error of the angle (deg), and the longest time of a fit (s):
{predictions}
- **First-order lag**: gain, offset, delay and time constant by scipy. **ARX** by SysIdentPy {sysidentpy}:
  two lags of angle and command on even samples, simulated freely.
- **BAM** {bam} with its own simulation in steps of {step} ms. "Published" are the parameters that its
  authors have fitted to more recordings, perhaps these among them. "CMA-ES" minimises the mean
  absolute error, as BAM does, by `cma` {cma} with {evaluations} simulations of each recording, where BAM
  takes 100,000 by default.
- **MuJoCo** {mujoco}: `sysid.optimize` of a `<dcmotor>` with Coulomb and viscous friction, steps of
  1 ms and BAM's controller of the servo.
- **Black boxes and servo models** are those of this program, the latter with delay and duty per error
  free. The time is that of both black boxes, or of all six friction models, on all cores.

## Intervals

Pairs of estimates of one parameter, from the halves of each recording and from two recordings: the
share (%) within two standard errors of their difference, 95 if the errors hold.

| servo | tool | pairs of halves | agree | pairs of recordings | agree |
|---|---|---|---|---|---|
{coverage}

## The same optimum

Error (deg rms) and time (s) with one model, recording and cost: the squared error. All simulate by
this program; the other searches begin at its optimum times factors from 1/2 to 2, within a box. The
time of this program includes eight searches, standard errors and tests of the residuals.

| model | recording | {tools} |
|---|---|{rules}
{optima}
"""


class Servo(NamedTuple):
    name: str
    runs: list
    errors: dict
    seconds: dict
    coverage: list
    optima: list


def commit():
    """The commit of the tree, with a word if it has been changed."""
    command = ["git", "describe", "--always", "--abbrev=12", "--dirty", "--exclude", "*"]
    folder = pathlib.Path(__file__).parent
    return subprocess.check_output(command, text=True, cwd=folder).strip()


def short(run):
    return f"`{run.path.stem.split('_')[-1]}`"


def predictions(servo):
    def row(name, found):
        longest = f"{max(servo.seconds[name]):.1f}" if name in servo.seconds else ""
        numbers = " | ".join(f"{error:.2f}" for error in [*found, np.mean(found)])
        return f"| {name} | {numbers} | {longest} |"

    head = f"| {servo.name} | {' | '.join(map(short, servo.runs))} | mean | time |"
    rule = "|" + "---|" * (len(servo.runs) + 3)
    return "\n".join(["", head, rule, *(row(*item) for item in servo.errors.items()), ""])


def coverage(servo):
    share = lambda count, agreeing: f"{count} | " + (f"{100 * agreeing / count:.0f}" if count else "-")
    for tool, *numbers in servo.coverage:
        yield f"| {servo.name} | {tool} | {share(*numbers[:2])} | {share(*numbers[2:])} |"


def optima(servo):
    for model, run, found in servo.optima:
        numbers = " | ".join(f"{rms:.4f}, {took:.2f}" for rms, took in found)
        yield f"| {model} | {short(run)} | {numbers} |"


def page(servos, made_of, evaluations):
    lines = lambda rows: "\n".join(row for servo in servos for row in rows(servo))
    return PAGE.format(
        date=datetime.date.today().isoformat(),
        commit=made_of,
        load=os.getloadavg()[2],
        machine=f"{os.cpu_count()} cores, {platform.machine()}, Python {platform.python_version()}",
        predictions="".join(map(predictions, servos)),
        coverage=lines(coverage),
        optima=lines(optima),
        tools=" | ".join(TOOLS),
        rules="---|" * len(TOOLS),
        bam=version("better-actuator-models"),
        cma=version("cma"),
        sysidentpy=version("sysidentpy"),
        mujoco=mujoco.__version__,
        step=round(1e3 * BAM_STEP_S),
        evaluations=evaluations,
    )
