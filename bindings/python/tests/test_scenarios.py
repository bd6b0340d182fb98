"""The package accepts and refuses the scenarios that every front end does."""

from pathlib import Path

import pytest

import smart_actuator as sa

CASES = [
    line.split(" ", 1)
    for line in (Path(__file__).parents[3] / "tests/scenarios.txt").read_text().splitlines()
    if not line.startswith("#")
]
OPTIONS = {"model", "plant", "preset", "input", "pwm"}


def number(text):
    try:
        return int(text)
    except ValueError:
        return float(text)


@pytest.mark.parametrize("verdict, scenario", CASES)
def test_a_scenario_is_accepted_or_refused_as_everywhere(verdict, scenario):
    arguments, of_input = {"duration": 0.01}, {}
    for key, value in (entry.split("=") for entry in scenario.split("&")):
        if key.startswith("input."):
            of_input[key.removeprefix("input.")] = number(value)
        else:
            key = {"duration_s": "duration"}.get(key, key)
            arguments[key] = value if key in OPTIONS else number(value)
    if verdict == "accept":
        sa.simulate(input_parameters=of_input, **arguments)
    else:
        with pytest.raises((KeyError, TypeError, ValueError)):
            sa.simulate(input_parameters=of_input, **arguments)
