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

PAGE = """# Other tools on the same recordings

`bindings/python/benches/compare_tools` has written this page: {date}, commit `{commit}`, {machine}.
With a load of {load:.1f} in the last quarter of an hour, times are longer than on an idle machine.
The same command takes folders with recordings of other servos.

The recordings are of servos with a pendulum, from [BAM](https://github.com/Rhoban/bam); they are not
part of this repository.

## Prediction

Each recording is predicted by models that are fitted to the other ones of the servo. Mean absolute
error of the angle (deg), and the longest time of a fit (s):
{predictions}
- **First-order lag**: gain, offset, delay and time constant by scipy. **ARX** by SysIdentPy {sysidentpy}:
  two lags of angle and command on even samples, simulated freely.
- **BAM** {bam} with its own simulation in steps of {step} ms. "As published" has the parameters that
  its authors have fitted to more recordings of the servo, these may be among them. "CMA-ES" minimises
  the mean absolute error, as BAM does, by `cma` {cma} with {evaluations} simulations of each recording;
  BAM itself takes 100,000 by default. BAM evaluates the simulations of a generation together.
- **MuJoCo** {mujoco} with `<dcmotor>`, Coulomb and viscous friction, steps of 1 ms; the controller of
  the servo, as BAM has it, sets the voltage. Its own `sysid.optimize` minimises the squares.
- **This program**: its friction models have delay and duty per error free. The time is that of all
  its black boxes, or of all six friction models, on all cores.

## Intervals

Pairs of estimates of one parameter, from the halves of each recording and from two recordings of a
servo: the share (%) that is within two standard errors of their difference, of 95 % if the errors
hold.

| servo | tool | pairs of halves | agree | pairs of recordings | agree |
|---|---|---|---|---|---|
{coverage}

## The same optimum

One model, one recording, one cost (the squared error; the command held from sample to sample). All
simulate by this program; the other searches begin at its optimum times factors from 1/2 to 2, within
a box. "Simulations" counts those of a search. The time of this program includes starting values, the
search from eight of them, standard errors and tests of the residuals.

| model | recording | tool | error (deg rms) | time (s) | simulations |
|---|---|---|---|---|---|
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
    for model, run, tool, rms, took, used in servo.optima:
        yield f"| {model} | {short(run)} | {tool} | {rms:.4f} | {took:.2f} | {used or ''} |"


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
        bam=version("better-actuator-models"),
        cma=version("cma"),
        sysidentpy=version("sysidentpy"),
        mujoco=mujoco.__version__,
        step=round(1e3 * BAM_STEP_S),
        evaluations=evaluations,
    )
