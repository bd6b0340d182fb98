import json
import os
import pathlib
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import smart_actuator as sa

PROGRAM = os.environ.get("ACTUATOR", "actuator")


def recording(model="black-box-1", input="pulse", noise_deg=0.05, seed=0, **parameters):
    trace = sa.simulate(model, input=input, every=80, **parameters)
    noise = np.random.default_rng(seed).normal(0.0, noise_deg, len(trace.time_s))
    return {
        "time_s": trace.time_s,
        "command_deg": trace.command_deg,
        "angle_deg": trace.angle_deg + noise,
    }


def estimates(found, model=0):
    return {each["name"]: each for each in found["models"][model]["parameters"]}


def test_arrays_give_back_the_parameters_that_made_them():
    found = sa.identify(recording(), models="black-box-1", starts=2)
    parameters = estimates(found)
    truth = {"pole_rad_s": 30.0, "delay_s": 0.0175, "rate_limit_up_deg_s": 240.0}
    for name, value in truth.items():
        # Four standard errors, which are exceeded with a probability of 1/16,000.
        error = parameters[name]["standard_error"]
        assert abs(parameters[name]["estimate"] - value) < 4.0 * error, name
    assert parameters["position_limit_deg"]["fixed"]
    assert found["models"][0]["fit_percent"] > 99.0


def test_the_warnings_of_the_result_are_raised():
    cut = {name: column[:60] for name, column in recording().items()}
    with pytest.warns(sa.FitWarning) as raised:
        found = sa.identify(cut, models=["black-box-1", "black-box-2"], starts=1)
    expected = [note["text"] for note in found["notes"]]
    for model in found["models"]:
        expected += [f"{model['name']}: {text}" for text in model["warnings"]]
        assert set(model["doubts"]) <= set(model["warnings"])
        assert model["intervals_hold"] == (not model["doubts"])
    assert expected and [str(warning.message) for warning in raised] == expected
    assert {warning.filename for warning in raised} == {__file__}


def test_what_is_asked_of_the_search_is_done():
    runs = [recording(seed=1), recording(seed=2, input="3-2-1-1")]
    found = sa.identify(
        runs,
        models=["black-box-1"],
        validate=recording(seed=3, input="ramp"),
        fix={"gain": 1.0},
        bound={"pole_rad_s": (1.0, 20.0)},
        own="offset_deg",
        starts=1,
    )
    parameters = estimates(found)
    assert parameters["gain"]["fixed"] and parameters["gain"]["estimate"] == 1.0
    assert parameters["pole_rad_s"]["bound"] == "high"
    offsets = [p for p in found["models"][0]["parameters"] if p["name"] == "offset_deg"]
    assert [p["experiment"] for p in offsets] == ["data[0]", "data[1]"]
    assert found["models"][0]["validation"][0]["name"] == "validate[0]"


def test_the_result_is_the_programs_json_bit_for_bit(tmp_path):
    path = tmp_path / "run.csv"
    columns = recording(seed=4)
    table = np.column_stack(list(columns.values()))
    np.savetxt(path, table, delimiter=",", header=",".join(columns), comments="", fmt="%.17g")
    command = [PROGRAM, "identify", path, "--json", "-", "--starts", "3", "--seed", "5"]
    printed = subprocess.run(command, check=True, capture_output=True).stdout
    assert sa.identify(path, starts=3, seed=5) == json.loads(printed)
    assert sa.identify(str(path), starts=3, seed=5, threads=1) == json.loads(printed)


@pytest.mark.parametrize("model", ["black-box-1", "black-box-2", "grey-box"])
def test_the_fitted_parameters_are_those_of_the_programs_file(model, tmp_path):
    path, file = tmp_path / "run.csv", tmp_path / "fitted.toml"
    sa.simulate(model, input="3-2-1-1", every=80).to_pandas().to_csv(path, index=False)
    # A fixed value is among them.
    given = {"delay_s": 0.02}
    options = ["--model", model, "--starts", "1", "--fix", "delay_s=0.02", "--parameters", file]
    subprocess.run([PROGRAM, "identify", path, *options], check=True, capture_output=True)
    written = file.read_text().split("[set]\n")[1].splitlines()
    lines = [line.split(" #")[0].split(" = ") for line in written]
    found = sa.identify(path, models=model, starts=1, fix=given)["models"][0]
    fitted = sa.fitted_parameters(found)
    assert fitted == {name: float(value) for name, value in lines}
    assert fitted["delay_s"] == 0.02 and "position_limit_deg" not in fitted
    assert sa.Actuator(model, **fitted).parameters.items() >= fitted.items()


def test_fitted_parameters_are_those_that_all_recordings_share():
    runs = [recording(seed=1), recording(seed=2, input="3-2-1-1")]
    found = sa.identify(runs, models="black-box-1", own="offset_deg", starts=1)["models"][0]
    assert set(sa.fitted_parameters(found)) & {"gain", "offset_deg"} == {"gain"}


def test_a_model_that_the_simulator_lacks_has_no_parameters_of_it():
    found = sa.identify(recording(), models="black-box-2-oscillator", starts=1)["models"][0]
    with pytest.raises(ValueError, match="model is black-box-2-oscillator, expected .* grey-box"):
        sa.fitted_parameters(found)


def test_a_parameter_that_is_not_identifiable_may_have_a_standard_error():
    # The example of the README: the large error makes the gain not identifiable.
    run = sa.simulate(
        "board", plant="bench", input="3-2-1-1", input_parameters={"amplitude_deg": 20.0}
    )
    found = estimates(sa.identify(run, models="black-box-2"))
    gain, limit = found["position_gain_per_s2"], found["position_limit_deg"]
    assert not gain["identifiable"] and gain["standard_error"] > 0.0
    assert gain["remark"] == "not identifiable" and gain["standard_error_coloured"] > 0.0
    assert limit["fixed"] and limit["estimate"] is limit["standard_error"] is None


@pytest.mark.parametrize(
    "error, message, more",
    [
        (KeyError, "unknown parameter `pole`", {"fix": {"pole": 30.0}}),
        (ValueError, "unknown model `black-box`", {"models": "black-box"}),
        (ValueError, "delay_s is held at 9", {"fix": {"delay_s": 9.0}}),
        (ValueError, "fix and free both name gain", {"fix": {"gain": 1.0}, "free": ["gain"]}),
        (ValueError, "bound pole_rad_s", {"bound": {"pole_rad_s": (2.0, 1.0)}}),
        (ValueError, "hold is `ramp`", {"hold": "ramp"}),
        (ValueError, "`length` is not a quantity", {"columns": {"length": "1"}}),
        (ValueError, "starts is 0", {"starts": 0}),
        (TypeError, "starts is 1.5", {"starts": 1.5}),
        (TypeError, "parameter gain is 'one'", {"fix": {"gain": "one"}}),
        (TypeError, "window is 3", {"window": 3}),
        (TypeError, r"window of data\[0\] is 3", {"validate": recording(), "window": [3, None]}),
        (ValueError, r"window of data\[0\] is \(2.0, 1.0\)", {"window": [(2.0, 1.0)]}),
        (ValueError, r"data\[0\]: .*0 samples", {"window": [(1e3, 2e3)]}),
        (ValueError, r"window has 2 items, expected 1, .*data\[0\]", {"window": [None, (0.0, 1.0)]}),
        (ValueError, r"known has 1 items, expected 2, .*validate\[0\]", {"validate": recording(), "known": [{}]}),
        (TypeError, r"known of data\[0\] is \(1, 2\)", {"known": [(1, 2)]}),
        (ValueError, r"data\[0\]: the known gain is NaN", {"known": [{"gain": float("nan")}]}),
        (KeyError, "unknown parameter `pole`", {"known": [{"pole": 30.0}]}),
    ],
)
def test_what_does_not_fit_is_named(error, message, more):
    with pytest.raises(error, match=message):
        sa.identify(recording(), **{"models": "black-box-1", **more})


def test_window_and_known_constants_of_each_recording_are_those_of_the_program(tmp_path):
    names = ["free.csv", "loaded.csv", "held-out.csv"]
    paths = [str(tmp_path / name) for name in names]
    for path, load in zip(paths, [0.0, 0.1, 0.05]):
        run = sa.simulate("board", plant="bench", every=80, load_torque_nm=load)
        run.to_pandas().to_csv(path, index=False)
    free, loaded, held_out = paths
    options = ["--model", "motor-m1", "--starts", "1", "--fix", "winding_resistance_ohm=7.7", "--fix", "supply_v=6"]
    of_each = [f"--window={loaded}@0:3", f"--window={held_out}@0.5:2.5"]
    of_each += [f"--known={loaded}@load_torque_nm=0.1", f"--known={held_out}@load_torque_nm=0.05"]
    command = [PROGRAM, "identify", free, loaded, "--validate", held_out, "--json", "-", *options]
    printed = subprocess.run([*command, *of_each], check=True, capture_output=True).stdout
    found = sa.identify(
        [free, loaded],
        validate=held_out,
        models="motor-m1",
        starts=1,
        fix={"winding_resistance_ohm": 7.7, "supply_v": 6},
        window=[None, (0.0, 3.0), (0.5, 2.5)],
        known=[None, {"load_torque_nm": 0.1}, {"load_torque_nm": 0.05}],
    )
    assert found == json.loads(printed)
    whole, cut = found["models"][0]["experiments"]
    assert whole["samples"] > cut["samples"] == 751
    assert found["models"][0]["validation"][0]["samples"] == 501


def test_a_window_of_one_recording_is_the_same_as_cutting_it():
    runs = [recording(seed=1), recording(seed=2, input="3-2-1-1")]
    inside = (runs[1]["time_s"] >= 0.5) & (runs[1]["time_s"] <= 2.0)
    cut = {name: column[inside] for name, column in runs[1].items()}
    options = {"models": "black-box-1", "starts": 1}
    by_hand = sa.identify([runs[0], cut], **options)
    assert sa.identify(runs, window=[None, (0.5, 2.0)], **options) == by_hand
    assert sa.identify(runs, window=(None, [0.5, 2.0]), **options) == by_hand
    assert sa.identify(runs, **options) != by_hand
    for pair in [(0.0, 1.0), [0.0, 1.0], np.array([0.0, 1.0])]:
        of_all = sa.identify(runs, window=pair, **options)
        assert of_all == sa.identify(runs, window=[(0.0, 1.0)] * 2, **options)


def test_known_constants_of_all_recordings_are_those_of_each():
    runs = [recording(seed=1), recording(seed=2, input="3-2-1-1")]
    options = {"models": "black-box-1", "starts": 1}
    of_all = sa.identify(runs, known={"pole_rad_s": 29.0}, **options)
    assert sa.identify(runs, known=[{"pole_rad_s": 29.0}] * 2, **options) == of_all
    poles = [p for p in of_all["models"][0]["parameters"] if p["name"] == "pole_rad_s"]
    assert all(p["estimate"] == 29.0 for p in poles)
    without = sa.identify(runs, **options)
    assert without != of_all
    assert sa.identify(runs, known=(None, {}), **options) == without


def test_recordings_that_are_none_are_named(tmp_path):
    run = recording()
    short = {name: column[:3] for name, column in run.items()}
    for error, message, data in [
        (ValueError, "data is empty", []),
        (ValueError, r"data\[0\]: .*3 samples", short),
        (ValueError, "the same in all samples", {**run, "angle_deg": np.zeros(len(run["time_s"]))}),
        (ValueError, r"data\[0\]: 1 samples with an angle", {**run, "time_s": run["time_s"] * 0}),
        (ValueError, "command_deg has 2 samples", {**run, "command_deg": [1.0, 2.0]}),
        (ValueError, r"data\[0\], angle_deg has the shape \(1, 2\)", {**run, "angle_deg": [[1, 2]]}),
        (KeyError, "no column of the angle.*angle_deg", {"time_s": [0.0], "command_deg": [0.0]}),
        (ValueError, "`angle` and `angle_deg` may both be the angle", {**run, "angle": run["angle_deg"]}),
        (TypeError, r"data\[1\] is 7", [run, 7]),
        (FileNotFoundError, "nowhere.csv", tmp_path / "nowhere.csv"),
    ]:
        with pytest.raises(error, match=message):
            sa.identify(data, models="black-box-1")
    bad = tmp_path / "bad.csv"
    bad.write_text("t,command_deg,angle_deg\n0,0,0\n1,0,x\n")
    with pytest.raises(ValueError, match=r"bad\.csv:3: column 3 \(`angle_deg`\)"):
        sa.identify(bad)


def test_what_the_package_and_the_program_write_is_the_same_recording(tmp_path):
    import pandas
    import polars
    import pyarrow

    trace = sa.simulate("board", input="3-2-1-1", every=20)
    expected = sa.identify(trace, models="black-box-1", starts=1)
    assert expected["models"][0]["fit_percent"] > 95.0
    units = {"time_s": ("time_ms", 1e3), "command_deg": ("command_mdeg", 1e3)}
    scaled = {units.get(n, (n, 1))[0]: c * units.get(n, (n, 1))[1] for n, c in trace.items()}
    for same in (
        dict(trace),
        trace.to_pandas(),
        trace.to_pandas().assign(label="a text"),
        polars.DataFrame(trace),
        pyarrow.table(trace),
        trace.to_pandas().to_records(index=False),
        [trace],
    ):
        assert sa.identify(same, models="black-box-1", starts=1) == expected, type(same)
    path = tmp_path / "run.csv"
    trace.to_pandas().to_csv(path, index=False)
    of_file = sa.identify(path, models="black-box-1", starts=1)["models"][0]["parameters"]
    assert [p["estimate"] for p in of_file] == [
        p["estimate"] for p in expected["models"][0]["parameters"]
    ]
    close = estimates(sa.identify(scaled, models="black-box-1", starts=1))
    for name, estimate in estimates(expected).items():
        if estimate["estimate"] is not None:
            assert close[name]["estimate"] == pytest.approx(estimate["estimate"], rel=1e-6)


def test_the_interpreter_is_free_during_a_search():
    counted = []

    def count():
        for _ in range(5):
            time.sleep(0.01)
            counted.append(time.monotonic())

    thread = threading.Thread(target=count)
    thread.start()
    sa.identify(recording(input="sine"), models=["black-box-2"], starts=8)
    thread.join()
    assert len(counted) == 5


def test_a_motor_that_is_driven_by_its_duty_needs_no_command():
    run = sa.simulate("board", plant="bench", input="3-2-1-1", every=80)
    columns = {name: run[name] for name in ("time_s", "duty_pct", "angle_meas_deg")}
    options = {"models": "motor-m1", "starts": 1, "fix": {"winding_resistance_ohm": 7.7, "supply_v": 6}}
    without, complete = sa.identify(columns, **options), sa.identify(run, **options)
    assert without["models"][0]["parameters"] == complete["models"][0]["parameters"]
    assert any("command" in note["text"] for note in without["notes"])
    with pytest.raises(KeyError, match="no column of the command"):
        sa.identify(columns, models=["motor-m1", "black-box-1"])


DATA = pathlib.Path(__file__).parents[3] / "identification/src/data/tests"


@pytest.mark.parametrize("suffix", ["parquet", "xlsx"])
def test_pandas_reads_what_the_package_does_not(suffix, tmp_path, monkeypatch):
    pandas = pytest.importorskip("pandas")
    pytest.importorskip({"parquet": "pyarrow", "xlsx": "openpyxl"}[suffix])
    file = tmp_path / f"run.{suffix}"
    frame = pandas.DataFrame(recording())
    frame.to_parquet(file) if suffix == "parquet" else frame.to_excel(file, index=False)
    of_file = sa.identify(file, models="black-box-1", starts=1)
    of_frame = sa.identify(frame, models="black-box-1", starts=1)
    # A workbook has 16 digits.
    key = "pole_rad_s"
    expected = pytest.approx(estimates(of_frame)[key]["estimate"], rel=1e-9)
    assert estimates(of_file)[key]["estimate"] == expected
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match=f"run.{suffix} .*pip install pandas"):
        sa.identify(file)
    broken = tmp_path / f"broken.{suffix}"
    monkeypatch.undo()
    broken.write_bytes(file.read_bytes()[:1000])
    with pytest.raises(ValueError, match=f"broken.{suffix}: .*expected a file that pandas"):
        sa.identify(broken)


def test_dates_of_a_data_frame_are_times():
    pandas = pytest.importorskip("pandas")
    run = recording()
    frame = pandas.DataFrame(run).rename(columns={"time_s": "time"})
    frame["time"] = pandas.to_datetime(1e9 + run["time_s"], unit="s")
    found = [sa.identify(each, models="black-box-1", starts=1) for each in (frame, run)]
    poles = [estimates(each)["pole_rad_s"]["estimate"] for each in found]
    # A float of seconds since 1970 has 0.1 us.
    assert poles[0] == pytest.approx(poles[1], rel=1e-3)


@pytest.mark.parametrize("name", ["table.h5", "bag.mcap", "table.xlsx"])
def test_what_nothing_reads_is_an_error_for_users_of_python(name, tmp_path):
    file = tmp_path / "run.dat"
    file.write_bytes((DATA / name).read_bytes())
    with pytest.raises(ValueError, match="expected a data frame .*pandas.read_parquet") as error:
        sa.identify(file)
    assert "cargo" not in str(error.value)
