"""What a type checker accepts."""

import pathlib
import subprocess
import sys
from typing import get_args

import pytest

import smart_actuator
import smart_actuator as sa
from smart_actuator import _choices, _parameter_names

GOOD = """
import smart_actuator as sa
trace = sa.simulate("board", plant="bench", position_gain=9.0, P=9.0, duration=1.0, progress=True)
servo = sa.Actuator("grey-box", delay_s=0.01)
servo.advance(1.0, seconds=1 / 240)
rate: float = servo.advance_to(1.0, 0.5).rate_deg_s
found = sa.identify([trace, "run.csv"], models=["black-box-1", "servo-m2"])["models"][0]
sa.identify(trace, models=found["name"])
sa.simulate("black-box-1", input="ramp", **sa.fitted_parameters(found))
fitted: sa.ModelParameters = sa.fitted_parameters(found)
sa.Actuator("black-box-1", **fitted)
for each in sa.inputs():
    sa.monte_carlo({"P": [8.0]}, input=each["name"])
sa.identify(trace.to_pandas())
sa.identify(trace, window=(0.0, 1.0), known={"gain": 1.0})
sa.identify([trace, trace], window=[None, (0.0, 1.0)], known=({"gain": 1.0}, None))
servo.advance(1.0, ticks=20, input="rate")
sa.ActuatorBatch(count=2, model="board", plant="bench")
sa.simulate(command=trace, progress=lambda done, total: print(done / total))
"""

BAD = [
    "sa.simulate(positon_gain=9.0)",
    "sa.Actuator(positon_gain=9.0)",
    "sa.monte_carlo({'P': [1.0]}, positon_gain=9.0)",
    "sa.simulate(position_gain='9')",
    "sa.Actuator().parameters['position_gain'] = 3",
    "sa.identify('run.csv', modles='black-box-1')",
    "sa.identify('run.csv', models='blackbox')",
    "sa.identify('run.csv', models=['black-box-1', 'board'])",
    "sa.sensitivity('board', [0.0], [1.0], ['gain'])",
    "fleet.identify('runs', out='fits', model='blackbox')",
    "sa.simulate('black-box-1', **{p['name']: p['estimate'] for p in found['parameters']})",
    "sa.identify('run.csv', window=[1.0])",
    "sa.identify('run.csv', known=['gain'])",
    "sa.identify('run.csv', loss='huber')",
    "sa.identify('run.csv', hold='first')",
    "sa.Actuator('bord')",
    "sa.simulate('board', plant='benc')",
    "sa.simulate('board', preset='papr')",
    "sa.simulate(pwm='switch')",
    "sa.simulate(input='3-2-1')",
    "sa.monte_carlo({'P': [1.0]}, input='3-2-1')",
    "sa.export('bam', input='3-2-1')",
    "sa.ActuatorBatch(count=2, model='bord')",
    "sa.to_control('grey-box', loop='close')",
    "sa.export('mujoco')",
    "sa.parameters('bord')",
    "sa.Actuator().advance(1.0)",
    "sa.Actuator().advance(1.0, ticks=1, seconds=0.1)",
    "sa.Actuator().advance(1.0, ticks=1, input='torque')",
    "sa.Actuator().advance_to(1.0)",
    "1.0 + sa.identify('run.csv')['models'][0]['parameters'][0]['estimate']",
]


@pytest.mark.parametrize(
    "names, call",
    [
        (_choices.ModelName, lambda name: sa.parameters(name)),
        (_choices.PlantName, lambda name: sa.parameters("board", name)),
        (_choices.FittedModelName, lambda name: sa.identify("missing.csv", models=name)),
        (_choices.InputName, lambda name: sa.simulate(input=name, duration=0.01)),
        (_choices.PwmName, lambda name: sa.Actuator(pwm=name)),
        (_choices.CommandName, lambda name: sa.Actuator(plant="bench").advance(0.0, ticks=1, input=name)),
        (_choices.LoopName, lambda name: sa.to_control(loop=name)),
        (_choices.TargetName, lambda name: sa.export(name)),
        (_choices.LossName, lambda name: sa.identify("missing.csv", loss=name)),
        (_choices.HoldName, lambda name: sa.identify("missing.csv", hold=name)),
        (_choices.DelimiterName, lambda name: sa.identify("missing.csv", delimiter=name)),
    ],
)
def test_the_choices_are_those_that_are_accepted(names, call):
    def is_accepted(name):
        try:
            call(name)
        except FileNotFoundError:
            pass
        except ValueError as error:
            return str(error)
        return True

    assert all(is_accepted(name) is True for name in get_args(names))
    listed = is_accepted("none of them").split("expected")[1].split(" of ")[0].replace(" or ", ", ")
    listed = {name.strip(" `.;") for name in listed.split(",")}
    assert set(get_args(names)) == listed


def test_the_presets_are_those_of_their_table():
    assert set(get_args(_choices.PresetName)) == {preset["name"] for preset in sa.presets()}


def test_the_names_of_the_parameters_are_current():
    path = pathlib.Path(smart_actuator.__file__).parent / "_parameters.py"
    assert path.read_text() == _parameter_names.source()


def test_a_type_checker_finds_misspelt_parameters(tmp_path):
    file = tmp_path / "use.py"
    lines = ["from smart_actuator import fleet", *BAD]
    file.write_text(GOOD + "\n".join(lines) + "\n")
    command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", tmp_path / "cache", file]
    found = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path).stdout
    first = GOOD.count("\n") + 1
    wrong = {int(line.split(":")[1]) for line in found.splitlines() if ": error:" in line}
    assert wrong == {first + 1 + index for index in range(len(BAD))}, found
