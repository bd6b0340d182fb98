"""What a type checker accepts."""

import pathlib
import subprocess
import sys

import smart_actuator
from smart_actuator import _parameter_names

GOOD = """
import smart_actuator as sa
trace = sa.simulate("board", plant="bench", position_gain=9.0, P=9.0, duration=1.0, progress=True)
servo = sa.Actuator("grey-box", delay_s=0.01)
servo.advance(1.0, seconds=1 / 240)
rate: float = servo.advance_to(1.0, 0.5).rate_deg_s
sa.identify([trace, "run.csv"], models="black-box-1")
sa.identify(trace.to_pandas())
sa.identify(trace, window=(0.0, 1.0), known={"gain": 1.0})
sa.identify([trace, trace], window=[None, (0.0, 1.0)], known=({"gain": 1.0}, None))
sa.simulate(command=trace, progress=lambda done, total: print(done / total))
"""

BAD = [
    "sa.simulate(positon_gain=9.0)",
    "sa.Actuator(positon_gain=9.0)",
    "sa.monte_carlo({'P': [1.0]}, positon_gain=9.0)",
    "sa.simulate(position_gain='9')",
    "sa.Actuator().parameters['position_gain'] = 3",
    "sa.identify('run.csv', modles='black-box-1')",
    "sa.identify('run.csv', window=[1.0])",
    "sa.identify('run.csv', known=['gain'])",
]


def test_the_names_of_the_parameters_are_current():
    path = pathlib.Path(smart_actuator.__file__).parent / "_parameters.py"
    assert path.read_text() == _parameter_names.source()


def test_a_type_checker_finds_misspelt_parameters(tmp_path):
    file = tmp_path / "use.py"
    lines = ["import smart_actuator as sa", *BAD]
    file.write_text(GOOD + "\n".join(lines) + "\n")
    command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", tmp_path / "cache", file]
    found = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path).stdout
    first = GOOD.count("\n") + 1
    wrong = {int(line.split(":")[1]) for line in found.splitlines() if ": error:" in line}
    assert wrong == {first + 1 + index for index in range(len(BAD))}, found
