"""Other tools and this one on the same recordings of servos, as docs/comparison.md.

    python3.12 -m venv venv
    venv/bin/pip install better-actuator-models==1.0.2 cma==4.5.0 "mujoco[sysid]==4.0.0" \\
        sysidentpy==0.9.0 dist/*.whl
    venv/bin/python bindings/python/benches/compare_tools SERVO... > docs/comparison.md

Each SERVO is a folder with recordings of one servo: of github.com/Rhoban/bam, such as
`data_raw/xl330`, or CSV as `actuator record` writes it. Each recording is predicted by models that
were fitted to all others of its folder. BAM and MuJoCo need the pendulum that BAM's recordings
state. `--evaluations` limits those of CMA-ES. All runs on one machine, one after the other; the
page has the date and the commit.
"""

import argparse
import pathlib
import sys
import time

from bam import model as bam

import smart_actuator as sa
from bam_models import Bam
from coverage import coverage
from dcmotor import DcMotor
from page import Servo, commit, page
from plain import Arx, Lag
from recordings import read
from searches import optima, search_by_cma

FRICTION_MODELS = [f"m{number}" for number in range(1, 7)]
BLACK_BOXES = ["black-box-1", "black-box-2"]


class Predictions:
    """Errors on each recording, and seconds for each fit, by tool."""

    def __init__(self):
        self.errors, self.seconds = {}, {}

    def add(self, tool, error, seconds=None):
        self.errors.setdefault(tool, []).append(error)
        if seconds is not None:
            self.seconds.setdefault(tool, []).append(seconds)
        print(tool, self.errors[tool], file=sys.stderr)

    def add_fit(self, tool, model, fitted, held_out):
        begun = time.perf_counter()
        best = model.fit(fitted)
        seconds = time.perf_counter() - begun
        self.add(tool, held_out.error_deg(model.angles(held_out, best)), seconds)

    def add_program(self, names, fitted, held_out):
        begun = time.perf_counter()
        paths = [run.path for run in fitted]
        found = sa.identify(paths, validate=held_out.path, models=names)["models"]
        seconds = time.perf_counter() - begun
        for model in found:
            error = model["validation"][0]["quality"]["mean_absolute_deg"]
            self.add(model["name"], error, seconds)

    def add_bam(self, name, fitted, held_out, evaluations):
        model = Bam(name, held_out.servo)
        motor = held_out.raw["motor"]
        if motor == held_out.servo:
            published = bam.load_model(motor_name=motor, model=name).get_parameters()
            values = [published[key].value for key in model.model.get_parameters()]
            self.add(f"BAM {name} published", model.error_deg(held_out, values))
        begun = time.perf_counter()
        cost = lambda sets: model.cost(fitted, sets)
        best = search_by_cma(cost, model.start, model.low, model.high, evaluations)
        seconds = time.perf_counter() - begun
        self.add(f"BAM {name} CMA-ES", model.error_deg(held_out, best), seconds)


def predictions(runs, evaluations):
    found = Predictions()
    for held_out in runs:
        fitted = [run for run in runs if run is not held_out]
        found.add_fit("first-order lag", Lag(), fitted, held_out)
        found.add_fit("ARX", Arx(), fitted, held_out)
        found.add_program(BLACK_BOXES, fitted, held_out)
        if all(run.servo for run in runs):
            found.add_fit("MuJoCo sysid", DcMotor(held_out.servo), fitted, held_out)
            for name in FRICTION_MODELS:
                found.add_bam(name, fitted, held_out, evaluations)
            found.add_program([f"servo-{name}" for name in FRICTION_MODELS], fitted, held_out)
    return found


def servo(folder, evaluations):
    paths = sorted(path for path in folder.iterdir() if path.suffix in (".json", ".csv"))
    if len(paths) < 2:
        sys.exit(f"{folder}: {len(paths)} recordings, expected two at least")
    runs = [read(path) for path in paths]
    found = predictions(runs, evaluations)
    searched = optima(evaluations, runs)
    return Servo(folder.name, runs, found.errors, found.seconds, list(coverage(runs)), searched)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("servo", type=pathlib.Path, nargs="+")
    parser.add_argument("--evaluations", type=int, default=2400)
    arguments = parser.parse_args()
    # As it is now: the run takes a while.
    made_of = commit()
    servos = [servo(folder, arguments.evaluations) for folder in arguments.servo]
    print(page(servos, made_of, arguments.evaluations), end="")


if __name__ == "__main__":
    main()
