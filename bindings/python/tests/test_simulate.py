import csv
import doctest
import os
import pickle
import subprocess

import numpy as np
import pytest

import smart_actuator as sa

PROGRAM = os.environ.get("ACTUATOR", "actuator")


def of_the_program(*arguments):
    command = [PROGRAM, "simulate", *arguments, "--csv", "-"]
    output = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    header, *rows = csv.reader(output.splitlines())
    return dict(zip(header, np.array(rows, dtype=float).T))


def assert_same(trace, columns):
    assert list(trace) == list(columns)
    for name, column in columns.items():
        # To the last bit, the sign of zero included.
        assert trace[name].tobytes() == column.tobytes(), name


@pytest.mark.parametrize(
    "model, words",
    [
        ("board", {}),
        ("board", {"plant": "bench", "pwm": "switched", "seed": 7, "encoder_noise_deg": 0.1}),
        ("board", {"preset": "as-measured-retuned", "input": "3-2-1-1", "every": 7}),
        ("grey-box", {"preset": "asymmetric", "input": "ramp", "P": 16.0}),
        ("black-box-1", {"input": "chirp", "duration": 3.0}),
        ("black-box-2", {"input": "variable-step"}),
    ],
)
def test_a_trace_is_that_of_the_program_to_the_last_bit(model, words):
    options = {"plant", "preset", "input", "duration", "every", "seed", "pwm"}
    arguments = [model]
    for name, value in words.items():
        arguments += [f"--{name}", str(value)] if name in options else ["--set", f"{name}={value}"]
    assert_same(sa.simulate(model, **words), of_the_program(*arguments))


def test_arrays_of_command_and_load_are_taken_as_files_are(tmp_path):
    t = np.array([0.0, 0.1, 0.3, 0.30001, 1.0])
    command, load = np.array([0.0, 10.0, -5.5, 0.1, 3.0]), np.array([0.0, 0.1, -0.2, 0.3, 0.0])
    for name, column, values in [("c", "command_deg", command), ("l", "torque_nm", load)]:
        rows = "".join(f"{a!r},{b!r}\n" for a, b in zip(t.tolist(), values.tolist()))
        (tmp_path / name).write_text(f"time_s,{column}\n{rows}")
    trace = sa.simulate(plant="bench", command=(t, command), load=(t, load), every=1)
    files = ["--input-file", str(tmp_path / "c"), "--load-file", str(tmp_path / "l")]
    assert_same(trace, of_the_program("board", "--plant", "bench", "--every", "1", *files))


def test_parameters_of_the_input_are_those_of_the_program():
    trace = sa.simulate(input="sine", input_parameters={"amplitude_deg": 3.0}, duration=1.0)
    more = ["--input", "sine", "--set", "input.amplitude_deg=3", "--duration", "1"]
    assert_same(trace, of_the_program("board", *more))


def misaligned(values):
    buffer = np.zeros(8 * len(values) + 1, np.uint8)
    array = buffer[1:].view(np.float64)
    array[:] = values
    assert not array.flags.aligned
    return array


def read_only(values):
    array = np.array(values)
    array.flags.writeable = False
    return array


@pytest.mark.parametrize(
    "form",
    [
        list,
        misaligned,
        read_only,
        lambda v: np.array(v)[::-1].copy()[::-1],
        lambda v: np.array([v, v]).T[:, 0],
        lambda v: np.array(v, ">f8"),
        lambda v: np.array(v, np.float32),
        lambda v: np.array(v, np.int16),
    ],
)
def test_arrays_of_any_layout_are_brought_into_form(form):
    t, command = [0.0, 1.0, 2.0], [0.0, 30.0, -10.0]
    expected = sa.simulate(command=(t, command))
    assert_same(sa.simulate(command=(form(t), form(command))), expected.to_dict())
    gains = [2.0, 3.0, 4.0]
    runs = sa.monte_carlo({"motor_gain_up": form(gains)}, duration=0.5)
    assert np.array_equal(runs, sa.monte_carlo({"motor_gain_up": gains}, duration=0.5))


NAN = float("nan")


@pytest.mark.parametrize(
    "error, message, arguments",
    [
        (ValueError, "unknown model `bord`.*board", {"model": "bord"}),
        (ValueError, "unknown plant `table`.*first-order, bench", {"plant": "table"}),
        (ValueError, "applies to the model `board`", {"model": "grey-box", "plant": "bench"}),
        (ValueError, "`grey-box` has no bridge", {"model": "grey-box", "pwm": "switched"}),
        (ValueError, "unknown preset `paperr`", {"preset": "paperr"}),
        (ValueError, "unknown input `step`", {"input": "step"}),
        (ValueError, "unknown pwm `on`.*average, switched", {"pwm": "on"}),
        (KeyError, "`postion_gain`, did you mean `position_gain`", {"postion_gain": 1.0}),
        (KeyError, "input parameter `amp`", {"input_parameters": {"amp": 1.0}}),
        (ValueError, "position_gain is NaN, expected a number from", {"position_gain": NAN}),
        (ValueError, "position_gain is -1, expected a number from", {"position_gain": -1}),
        (ValueError, "position_gain is 1000.*expected a number", {"position_gain": 10**400}),
        (TypeError, "position_gain is '10', expected a number", {"position_gain": "10"}),
        (TypeError, "position_gain is None, expected a number", {"position_gain": None}),
        (ValueError, "position_min_deg is above", {"position_min_deg": 9, "position_max_deg": 1}),
        (ValueError, "duration is -1, expected", {"duration": -1}),
        (ValueError, "duration is NaN, expected", {"duration": NAN}),
        (ValueError, "every is 0, expected", {"every": 0}),
        (TypeError, "every is 2.5, expected an integer", {"every": 2.5}),
        (ValueError, "seed is -1, expected", {"seed": -1}),
        (ValueError, "seed is .*, expected", {"seed": 2**64}),
        (MemoryError, "shorten the duration", {"duration": 1e7, "every": 1}),
        (TypeError, "model is 3, expected a string", {"model": 3}),
        (ValueError, "a load applies to", {"load": ([0.0], [1.0])}),
        (ValueError, "expected one of them", {"input": "pulse", "command": ([0.0], [1.0])}),
        (TypeError, "command: expected a pair", {"command": 5}),
        (KeyError, "command has no column 'command_deg'", {"command": {"time_s": [0.0], "u": [1]}}),
        (TypeError, "progress is 'yes', expected", {"progress": "yes"}),
        (TypeError, "command, values: expected an array", {"command": ([0.0], ["x"])}),
        (TypeError, "command, values: expected an array", {"command": ([0.0], [1j])}),
        (ValueError, "command, values: expected an array", {"command": ([0.0], [[1.0], []])}),
        (ValueError, "one dimension", {"command": ([[0.0]], [[1.0]])}),
        (ValueError, "one dimension", {"command": (0.0, 1.0)}),
        (ValueError, "2 times and 1 values", {"command": ([0.0, 1.0], [1.0])}),
        (ValueError, "0 times and 0 values", {"command": ([], [])}),
        (ValueError, r"command: time_s\[1\] is NaN", {"command": ([0.0, NAN], [1.0, 2.0])}),
        (ValueError, r"command_deg\[0\] is inf", {"command": ([0.0], [float("inf")])}),
        (ValueError, r"time_s\[0\] is -1, expected a time", {"command": ([-1.0], [1.0])}),
        (ValueError, "do not decrease", {"command": ([1.0, 0.5], [1.0, 2.0])}),
        (ValueError, r"torque_nm\[0\] is NaN", {"plant": "bench", "load": ([0.0], [NAN])}),
    ],
)
def test_what_does_not_fit_is_named_with_what_was_expected(error, message, arguments):
    with pytest.raises(error, match=message):
        sa.simulate(**arguments)


def test_a_preset_with_a_warning_warns():
    with pytest.warns(UserWarning, match="37.4 deg/s") as warned:
        sa.simulate(preset="as-printed-strict", duration=0.1)
    assert warned[0].filename == __file__


def test_columns_are_items_and_attributes_with_units():
    trace = sa.simulate(plant="bench", duration=0.1)
    assert trace.angle_deg is trace["angle_deg"] and len(trace.time_s) == 100
    assert "angle_deg" in dir(trace) and "100 rows" in repr(trace)
    assert list(trace.to_dict()) == list(trace) == list(trace.units)
    expected = {"time_s": "s", "rate_deg_s": "deg/s", "duty_pct": "%", "current_a": "A"}
    expected |= {"back_emf_v": "V", "load_torque_nm": "Nm", "command_deg": "deg"}
    assert all(trace.units[name] == unit for name, unit in expected.items())
    assert all(trace.units.values())
    with pytest.raises(KeyError, match="no column 'angle'.*angle_deg"):
        trace["angle"]
    with pytest.raises(AttributeError, match="no column 'angle'"):
        trace.angle


def test_a_trace_goes_into_every_table_and_comes_back():
    import pandas
    import polars
    import pyarrow
    import pyarrow.interchange

    trace = sa.simulate(plant="bench", duration=0.1)
    frame = trace.to_pandas()
    assert frame.attrs["title"] == trace.title and frame.attrs["units"] == trace.units
    tables = [frame, pandas.DataFrame(trace), polars.DataFrame(trace), pyarrow.table(trace)]
    tables.append(pyarrow.table(pyarrow.RecordBatchReader.from_stream(trace).read_all()))
    for table in tables:
        names = table.column_names if isinstance(table, pyarrow.Table) else table.columns
        assert list(names) == list(trace)
        assert_same(trace, {name: np.asarray(table[name]) for name in names})
    exchanged = pyarrow.interchange.from_dataframe(trace)
    assert_same(trace, {name: exchanged[name].to_numpy() for name in trace})
    rows = trace.to_numpy()
    assert rows.shape == (100, len(trace))
    assert_same(trace, {name: rows[:, index].copy() for index, name in enumerate(trace)})


def test_a_trace_is_a_command_and_a_load():
    first = sa.simulate(plant="bench", input="sine", load=([0.0, 0.5], [0.0, 0.1]), every=1)
    again = sa.simulate(plant="bench", command=first, every=1)
    assert np.array_equal(first.command_deg, again.command_deg)
    loaded = sa.simulate(plant="bench", command=first.to_pandas(), load=first, every=1)
    pairs = {"command": first.command_deg, "load": first.load_torque_nm}
    pairs = {name: (first.time_s, values) for name, values in pairs.items()}
    assert_same(loaded, sa.simulate(plant="bench", every=1, **pairs))


def test_a_trace_can_be_pickled():
    trace = sa.simulate(duration=0.1)
    copy = pickle.loads(pickle.dumps(trace))
    assert_same(copy, trace.to_dict())
    assert copy.title == trace.title == "board on pulse"


def test_the_tables_say_what_there_is():
    gain = next(p for p in sa.parameters("board") if p["name"] == "position_gain")
    assert (gain["symbol"], gain["default"], gain["min"]) == ("P", 8.0, 0.0)
    assert all(p["meaning"] and p["source"] for p in sa.parameters("board", "bench"))
    assert {p["name"] for p in sa.presets()} > {"paper", "consistent", "as-measured"}
    pulse = next(i for i in sa.inputs() if i["name"] == "pulse")
    assert "amplitude_deg" in [p["name"] for p in pulse["parameters"]]
    assert sa.__version__.count(".") == 2


def test_the_example_of_the_package_holds():
    assert doctest.testmod(sa).failed == 0
