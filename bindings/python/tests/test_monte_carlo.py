import multiprocessing
import pathlib
import re
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import smart_actuator as sa

EXAMPLE = pathlib.Path(__file__).parents[1] / "examples" / "dask_campaign.py"


def ends(trace):
    angle, rate = trace.angle_deg, trace.rate_deg_s
    return (angle.min(), angle.max(), rate.min(), rate.max(), angle[-1], rate[-1])


@pytest.mark.parametrize("every", [1, 20])
@pytest.mark.parametrize("plant", [None, "bench"])
def test_each_run_has_the_extremes_of_its_trace(plant, every):
    gains, amplitudes = np.array([8.0, 10.0, 12.0]), np.array([[3.0], [60.0]])
    varied = {"P": gains, "input.amplitude_deg": amplitudes}
    same = {"plant": plant, "duration": 1.2, "every": every, "delay_s": 0.01}
    runs = sa.monte_carlo(varied, **same)
    assert runs.shape == (2, 3)
    for index, run in np.ndenumerate(runs):
        amplitude = {"amplitude_deg": amplitudes[index[0], 0]}
        trace = sa.simulate(input_parameters=amplitude, P=gains[index[1]], **same)
        assert run.item() == ends(trace)


def test_commands_and_loads_go_for_all_runs():
    t, command, load = [0.0, 0.1, 0.5], [0.0, 30.0, 5.0], [0.0, -0.2, 0.2]
    same = {"plant": "bench", "command": (t, command), "load": (t, load), "duration": 0.8}
    runs = sa.monte_carlo({"P": [9.0, 11.0]}, **same)
    assert [run.item() for run in runs] == [ends(sa.simulate(P=p, **same)) for p in (9.0, 11.0)]


def test_the_number_of_threads_changes_nothing():
    gains = np.linspace(5.0, 15.0, 200)
    runs = [sa.monte_carlo({"P": gains}, duration=0.5, threads=n) for n in (None, 1, 3)]
    assert np.array_equal(runs[0], runs[1]) and np.array_equal(runs[0], runs[2])


def test_no_runs_and_a_single_one_have_their_shapes():
    assert sa.monte_carlo({"P": []}).shape == (0,)
    assert sa.monte_carlo({"P": 10.0}, duration=0.1).shape == ()


@pytest.mark.parametrize(
    "error, message, varied, more",
    [
        (KeyError, "run 0: unknown parameter `Q`", {"Q": [1.0]}, {}),
        (KeyError, "input parameter `amp`", {"input.amp": [1.0]}, {}),
        (ValueError, "run 1: parameter position_gain is NaN", {"P": [1.0, np.nan]}, {}),
        (ValueError, "run 150: parameter position_gain", {"P": [1.0] * 150 + [-1.0]}, {}),
        (ValueError, r"P \(2,\), Ki \(3,\), expected shapes that broadcast", {"P": [1, 2], "Ki": [1, 2, 3]}, {}),
        (TypeError, "parameter P: expected an array", {"P": ["a"]}, {}),
        (TypeError, "parameter P: expected an array", {"P": np.ma.array([1.0], mask=[1])}, {}),
        (TypeError, "expected a mapping", [1.0], {}),
        (TypeError, "expected a mapping", {}, {}),
        (TypeError, "expected a string", {1: [1.0]}, {}),
        (ValueError, "threads is 0, expected", {"P": [1.0]}, {"threads": 0}),
        (ValueError, "threads is 100000, expected", {"P": [1.0]}, {"threads": 100_000}),
        (ValueError, "every is 0, expected", {"P": [1.0]}, {"every": 0}),
    ],
)
def test_what_does_not_fit_is_named_with_its_run(error, message, varied, more):
    with pytest.raises(error, match=message):
        sa.monte_carlo(varied, duration=0.01, **more)


def test_other_threads_run_meanwhile():
    done = threading.Event()
    arguments = ({"P": np.full(400, 10.0)},)
    work = {"duration": 60.0, "every": 1, "threads": 1}
    worker = threading.Thread(target=lambda: (sa.monte_carlo(*arguments, **work), done.set()))
    worker.start()
    beats = 0
    while not done.is_set():
        time.sleep(0.001)
        beats += 1
    worker.join()
    # With a blocked interpreter there would be one or two; on a loaded machine each wait is longer.
    assert beats > 5


def campaign(_):
    return sa.monte_carlo({"P": [9.0, 10.0]}, duration=0.5)


@pytest.mark.skipif(sys.platform != "linux", reason="fork")
# jax, which other tests import, warns of every fork.
@pytest.mark.filterwarnings("ignore:os.fork:RuntimeWarning")
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_a_forked_process_has_threads_of_its_own():
    here = campaign(None)
    with multiprocessing.get_context("fork").Pool(2) as pool:
        for there in pool.map_async(campaign, range(4)).get(timeout=60):
            assert np.array_equal(here, there)


def test_dask_gives_what_a_serial_run_gives():
    command = [sys.executable, str(EXAMPLE), "600"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert "600 runs: the results are equal" in done.stdout
    # The speed-up depends on the load of the machine.
    print(done.stdout)
    assert float(re.search(r"speed-up ([\d.]+)", done.stdout)[1]) > 0
