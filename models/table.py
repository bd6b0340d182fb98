#!/usr/bin/env python3
"""Writes the table of models/README.md, or with --check says whether it is that of the files."""

import pathlib
import re
import subprocess
import sys
import tempfile

FOLDER = pathlib.Path(__file__).parent
PAGE = FOLDER / "README.md"
MARKS = ("<!-- table.py writes this table -->\n", "<!-- end -->\n")
HEAD = (
    "| servo | model | fit (%) | rise (ms) | greatest rate (deg/s) | prediction | recordings "
    "| licence |"
)
#: What a file states of its servo, in comments.
STATED = ("servo", "prediction", "recordings", "licence")
#: The first line of `identify --parameters`.
FITTED = r"^# (\S+) fitted by actuator \S+: fit (\S+) %"
#: The step in which servos are compared, and the time in which all of them reach it.
STEP = ["--input", "pulse", "--set", "input.amplitude_deg=30", "--duration", "2", "--every", "20"]


def stated(path):
    found = dict(re.findall(r"^# (\w+): (.+)$", path.read_text(), re.MULTILINE))
    missing = [name for name in STATED if name not in found]
    if missing:
        sys.exit(f"{path}: no comment `# {missing[0]}: ...`, expected {', '.join(STATED)}")
    fitted = re.search(FITTED, path.read_text(), re.MULTILINE)
    if fitted is None:
        sys.exit(f"{path}: no line `# MODEL fitted by`, expected a file of `identify --parameters`")
    return found, *fitted.groups()


def response(path, actuator):
    """Rise time from 10 to 90 % of the last angle, ms, and greatest rate, deg/s, of a step without a load."""
    alone = ["--set", "pendulum_mass_kg=0"] if "pendulum_mass_kg" in path.read_text() else []
    with tempfile.TemporaryDirectory() as folder:
        csv = pathlib.Path(folder) / "step.csv"
        command = [*actuator, "simulate", "--parameters", str(path), *STEP, *alone, "--csv", str(csv)]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        lines = [line for line in csv.read_text().splitlines() if not line.startswith("#")]
    names = lines[0].split(",")
    at = lambda name: [float(line.split(",")[names.index(name)]) for line in lines[1:]]
    time_s, angle, command_deg = at("time_s"), at("angle_deg"), at("command_deg")
    last = angle[max(i for i, command in enumerate(command_deg) if command)]
    first = next(i for i, a in enumerate(angle) if a >= 0.1 * last)
    end = next(i for i, a in enumerate(angle) if a >= 0.9 * last)
    pairs = list(zip(time_s, angle))[first : end + 1]
    rate = max((b[1] - a[1]) / (b[0] - a[0]) for a, b in zip(pairs, pairs[1:]))
    return 1e3 * (time_s[end] - time_s[first]), rate


def row(path, actuator):
    about, model, fit = stated(path)
    rise_ms, rate_deg_s = response(path, actuator)
    stating = " | ".join(about[name] for name in STATED[1:])
    servo = f"[{about['servo']}]({path.name})"
    return f"| {servo} | {model} | {fit} | {rise_ms:.0f} | {rate_deg_s:.0f} | {stating} |"


def main():
    actuator = [word for word in sys.argv[1:] if word != "--check"]
    if not actuator:
        sys.exit("expected a command: models/table.py [--check] target/release/actuator")
    rows = [HEAD, "|---" * 8 + "|", *(row(path, actuator) for path in sorted(FOLDER.glob("*.toml")))]
    table = "".join(line + "\n" for line in rows)
    text = PAGE.read_text()
    before, rest = text.split(MARKS[0])
    after = rest.split(MARKS[1])[1]
    written = before + MARKS[0] + table + MARKS[1] + after
    if "--check" in sys.argv and written != text:
        sys.exit(f"{PAGE} is not that of the files, expected the output of models/table.py")
    PAGE.write_text(written)


if __name__ == "__main__":
    main()
