#!/usr/bin/env python3
"""One command sequence through every way to the actuator: the angles are equal to the last bit.

    compare.py PROGRAM C_LIBRARY SCRIPT

The ways are the program `actuator` (Rust), the Python package, the FMU in FMPy, the C library, and the script for
browsers (wasm) in node. The angle is read after each millisecond of two seconds, in which the command changes at random ticks.
"""
import ctypes
import io
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from smart_actuator import Actuator

HERE = Path(__file__).parent
MODELS = {
    "black-box-1": ("black-box-1", None),
    "black-box-2": ("black-box-2", None),
    "grey-box": ("grey-box", None),
    "board": ("board", "first-order"),
    "board on the bench": ("board", "bench"),
}
MILLISECONDS, TICKS = 2000, 20


def commands():
    """A command for each millisecond, deg: held, stepped, some too far to be followed."""
    random = np.random.default_rng(3211)
    levels = random.uniform(-150.0, 150.0, MILLISECONDS)
    held = np.maximum.accumulate(np.where(random.random(MILLISECONDS) < 0.01, np.arange(MILLISECONDS), 0))
    return levels[held]


COMMANDS = commands()


def options(model, plant):
    return [model] if plant is None else [model, "--plant", plant]


def rust(program, model, plant, folder):
    file = folder / "command.csv"
    rows = "".join(f"{ms / 1000!r},{command!r}\n" for ms, command in enumerate(COMMANDS.tolist()))
    file.write_text("t,command_deg\n" + rows)
    # One millisecond more, for the row at the end of the last one.
    run = subprocess.run(
        [program, "simulate", *options(model, plant), "--input-file", file, "--csv", "-",
         "--duration", repr(MILLISECONDS / 1000 + 0.001)],
        check=True, capture_output=True, text=True)
    return np.genfromtxt(io.StringIO(run.stdout), delimiter=",", names=True)["angle_deg"][1:]


def python(model, plant):
    actuator = Actuator(model) if plant is None else Actuator(model, plant=plant)
    return np.array([actuator.advance(command, ticks=TICKS).angle_deg for command in COMMANDS.tolist()])


def fmu(program, model, plant, folder):
    path = folder / "actuator.fmu"
    chosen = ["--model", model] + ([] if plant is None else ["--plant", plant])
    subprocess.run([program, "fmu", "--out", path, *chosen], check=True, capture_output=True)
    description = read_model_description(str(path))
    references = {variable.name: variable.valueReference for variable in description.modelVariables}
    unit = FMU2Slave(
        guid=description.guid, unzipDirectory=extract(str(path), unzipdir=str(folder / "unit")),
        modelIdentifier=description.coSimulation.modelIdentifier, instanceName="one")
    unit.instantiate()
    unit.setupExperiment(startTime=0.0)
    unit.enterInitializationMode()
    unit.exitInitializationMode()
    angles = []
    for ms, command in enumerate(COMMANDS.tolist()):
        unit.setReal([references["command_deg"]], [command])
        unit.doStep(ms / 1000, 0.001)
        angles += unit.getReal([references["angle_deg"]])
    unit.terminate()
    unit.freeInstance()
    return np.array(angles)


def c(library, model, plant):
    lib = ctypes.CDLL(library)
    lib.actuator_size.restype = ctypes.c_size_t
    settings = (ctypes.c_uint64 * 128)()
    names = model.encode(), None if plant is None else plant.encode()
    assert lib.actuator_settings_init(settings, ctypes.c_size_t(1024), *names, None) == 0
    size = lib.actuator_size(settings)
    actuator = (ctypes.c_uint64 * (size // 8))()
    assert lib.actuator_start(actuator, ctypes.c_size_t(size), settings, None) == 0
    # struct actuator_reading: a tick, then doubles, of which the second is the angle.
    reading, angles = (ctypes.c_double * 9)(), []
    for command in COMMANDS.tolist():
        assert lib.actuator_advance(actuator, ctypes.c_double(command), ctypes.c_uint64(TICKS)) == 0
        assert lib.actuator_read(actuator, reading) == 0
        angles.append(reading[2])
    return np.array(angles)


def wasm(script, model, plant):
    request = f"model={model}&every={TICKS}" + ("" if plant is None else f"&plant={plant}")
    # Each held for TICKS ticks; one more, for the row at the end of the last one.
    held = np.append(COMMANDS, COMMANDS[-1])
    run = subprocess.run(
        ["node", HERE / "follow.mjs", script, request], input="\n".join(map(repr, held.tolist())),
        check=True, capture_output=True, text=True)
    return np.array(run.stdout.split(), dtype=float)[1:]


def main():
    program, library, script = sys.argv[1:]
    for name, (model, plant) in MODELS.items():
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            ways = {
                "Rust": rust(program, model, plant, folder),
                "Python": python(model, plant),
                "FMU": fmu(program, model, plant, folder),
                "C": c(library, model, plant),
                "wasm": wasm(script, model, plant),
            }
        first = ways["Rust"]
        assert np.ptp(first) > 20.0, f"{name}: hardly moves"
        for way, angles in ways.items():
            assert angles.shape == (MILLISECONDS,), f"{name}, {way}: {angles.shape}"
            # No zero has two signs here: text of a number has none.
            differ = np.flatnonzero((angles + 0.0).view(np.uint64) != (first + 0.0).view(np.uint64))
            assert differ.size == 0, f"{name}, {way}: {angles[differ[0]]!r} for {first[differ[0]]!r} at {differ[0] + 1} ms"
        print(f"{name}: {', '.join(ways)} agree in {MILLISECONDS} angles, bit for bit")


if __name__ == "__main__":
    main()
