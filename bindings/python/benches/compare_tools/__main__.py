"""Other tools and this one on the same recordings of servos, as docs/comparison.md.

    python3.12 -m venv venv
    venv/bin/pip install better-actuator-models==1.0.2 cma==4.5.0 "mujoco[sysid]==4.0.0" dist/*.whl
    venv/bin/python bindings/python/benches/compare_tools RECORDINGS > docs/comparison.md

RECORDINGS is the folder of a servo of github.com/Rhoban/bam, such as `data_raw/xl330`. Each
recording is predicted by models that were fitted to all others. `--evaluations` limits those of
CMA-ES. All runs on one machine, one after the other; the page has the date and the commit.
"""

import argparse
import pathlib
import sys
import time

from bam import model as bam

import smart_actuator as sa
from bam_models import Bam
from dcmotor import DcMotor
from page import commit, page
from recordings import Recording
from searches import optima, search_by_cma

FRICTION_MODELS = [f"m{number}" for number in range(1, 7)]


def this_program(fitted, held_out):
    """The models of this program: error by model, and the time for all."""
    names = [f"servo-{name}" for name in FRICTION_MODELS]
    begun = time.perf_counter()
    found = sa.identify([run.path for run in fitted], validate=held_out.path, models=names)[
        "models"
    ]
    seconds = time.perf_counter() - begun
    errors = [model["validation"][0]["quality"]["mean_absolute_deg"] for model in found]
    return {model["name"]: error for model, error in zip(found, errors)}, seconds


def predictions(arguments, runs):
    """Errors on each recording by models fitted to the others, and seconds for each fit."""
    errors, seconds = {}, {}
    for held_out in runs:
        fitted = [run for run in runs if run is not held_out]
        for name in FRICTION_MODELS:
            published = bam.load_model(motor_name="xl330", model=name).get_parameters()
            model = Bam(name)
            values = [published[key].value for key in model.model.get_parameters()]
            errors.setdefault(f"BAM {name}, as published", []).append(
                model.error_deg(held_out, values)
            )
            begun = time.perf_counter()
            best, _ = search_by_cma(
                lambda sets: model.cost(fitted, sets),
                model.start,
                model.low,
                model.high,
                arguments.evaluations,
            )
            seconds.setdefault(f"BAM {name}, CMA-ES", []).append(time.perf_counter() - begun)
            errors.setdefault(f"BAM {name}, CMA-ES", []).append(model.error_deg(held_out, best))
            print(held_out.path.name, name, errors, file=sys.stderr)
        motor, begun = DcMotor(), time.perf_counter()
        best = motor.fit(fitted)
        seconds.setdefault("MuJoCo, dcmotor and sysid", []).append(time.perf_counter() - begun)
        angles = motor.angles(held_out, best)
        errors.setdefault("MuJoCo, dcmotor and sysid", []).append(held_out.error_deg(angles))
        found, taken = this_program(fitted, held_out)
        for name, error in found.items():
            errors.setdefault(f"this program, {name}", []).append(error)
        seconds.setdefault("this program, all six", []).append(taken)
    return errors, seconds


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("recordings", type=pathlib.Path)
    parser.add_argument("--evaluations", type=int, default=4000)
    arguments = parser.parse_args()
    paths = sorted(arguments.recordings.glob("*.json"))
    if len(paths) < 2:
        sys.exit(f"{arguments.recordings}: {len(paths)} recordings, expected two at least")
    # As it is now: the run takes a while.
    made_of = commit()
    runs = [Recording(path) for path in paths]
    errors, seconds = predictions(arguments, runs)
    print(page(arguments, made_of, runs, errors, seconds, optima(arguments, runs)), end="")


if __name__ == "__main__":
    main()
