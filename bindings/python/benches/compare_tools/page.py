"""The page of the comparison."""

import datetime
import os
import pathlib
import platform
import subprocess
from importlib.metadata import version

import mujoco
import numpy as np

from recordings import BAM_STEP_S

PAGE = """# Other tools on the same recordings

`bindings/python/benches/compare_tools` has written this page: {date}, commit `{commit}`, {machine}.
With a load of {load:.1f} in the last quarter of an hour, times are longer than on an idle machine.

The {count} recordings are of a Robotis XL330 with a pendulum, from [BAM](https://github.com/Rhoban/bam);
they are not part of this repository: {names}.

## Prediction

Each recording is predicted by models that are fitted to the other ones. Mean absolute error of the
angle (deg), and the longest time of a fit (s):

| tool | {short} | mean | time |
|{rule}
{errors}

- **BAM** {bam} with its own simulation in steps of {step} ms. "As published" has the parameters that
  its authors have fitted to more recordings of the servo, these may be among them. "CMA-ES" minimises
  the mean absolute error, as BAM does, by `cma` {cma} with {evaluations} simulations of each recording;
  BAM itself takes 100,000 by default. BAM evaluates the simulations of a generation together.
- **MuJoCo** {mujoco} with `<dcmotor>`, Coulomb and viscous friction, steps of 1 ms; the controller of
  the servo, as BAM has it, sets the voltage. Its own `sysid.optimize` minimises the squares.
- **This program** fits the same friction models with delay and duty per error free; the time is that
  of all six, on all cores.

## The same optimum

One model, one recording, one cost (the squared error; the command held from sample to sample). All
simulate by this program; the other searches begin at its optimum times factors from 1/2 to 2, within
a box. "Simulations" counts those of a search. The time of this program includes starting values, the
search from eight of them, standard errors and tests of the residuals.

| model | recording | tool | error (deg rms) | time (s) | simulations |
|---|---|---|---|---|---|
{optima}

## Not run

- BAM's own search with its default of 100,000 simulations of each recording in each of {count} x 6 fits:
  {hours:.0f} hours at the rate of this page, and many times that in BAM, which simulates one set of
  parameters after the other.
- Recordings of BAM's other servos: this page is of the folder that the script was given.
"""


def commit():
    """The commit of the tree, with a word if it has been changed."""
    command = ["git", "describe", "--always", "--abbrev=12", "--dirty", "--exclude", "*"]
    folder = pathlib.Path(__file__).parent
    return subprocess.check_output(command, text=True, cwd=folder).strip()


def page(arguments, made_of, runs, errors, seconds, rows):
    def cells(name, found):
        longest = f"{max(seconds[name]):.1f}" if name in seconds else ""
        numbers = " | ".join(f"{error:.2f}" for error in [*found, np.mean(found)])
        return f"| {name} | {numbers} | {longest} |"

    stems = [run.path.stem for run in runs]
    ours = [name for name in errors if name.startswith("this program")]
    seconds = {**seconds, **dict.fromkeys(ours, seconds["this program, all six"])}
    return PAGE.format(
        date=datetime.date.today().isoformat(),
        commit=made_of,
        load=os.getloadavg()[2],
        hours=sum(sum(s) for n, s in seconds.items() if n.endswith("CMA-ES"))
        / 3600
        * 1e5
        / arguments.evaluations,
        machine=f"{os.cpu_count()} cores, {platform.machine()}, Python {platform.python_version()}",
        count=len(runs),
        names=", ".join(f"`{stem}`" for stem in stems),
        short=" | ".join(f"`{stem.split('_')[-1]}`" for stem in stems),
        rule="---|" * (len(runs) + 3),
        errors="\n".join(cells(name, found) for name, found in errors.items()),
        bam=version("better-actuator-models"),
        cma=version("cma"),
        mujoco=mujoco.__version__,
        step=round(1e3 * BAM_STEP_S),
        evaluations=arguments.evaluations,
        optima="\n".join(
            f"| {model} | `{run.path.stem.split('_')[-1]}` | {tool} | {rms:.4f} | {took:.2f} | {used or ''} |"
            for model, run, tool, rms, took, used in rows
        ),
    )
