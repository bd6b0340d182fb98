"""The FMUs that `actuator fmu` writes, in FMPy, against the traces of `actuator simulate`.

The environment names the program in ACTUATOR. Everything is compared bit for bit.
"""

import ctypes
import functools
import io
import os
import shutil
import subprocess
import tempfile
import time as clock
import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi2 import FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.fmi3 import FMU3Slave, fmi3IntermediateUpdateCallback
from fmpy.validation import validate_fmu

PROGRAM = os.environ["ACTUATOR"]
MODELS = {
    "black-box-1": [],
    "black-box-2": [],
    "grey-box": [],
    "board": [],
    "bench": ["--plant", "bench"],
}
COMMON = ["angle_deg", "rate_deg_s", "duty_pct", "angle_meas_deg", "rate_meas_deg_s"]
BENCH = ["current_a", "back_emf_v"]
TICK_S = 50e-6
DURATION_S = 1.2


def actuator(*arguments):
    run = subprocess.run([PROGRAM, *map(str, arguments)], check=True, capture_output=True, text=True)
    return run.stdout


def model_name(model):
    return "board" if model == "bench" else model


class Unit:
    """An FMU on the disk, unpacked."""

    def __init__(self, folder, model, *options):
        self.model = model
        self.path = Path(folder) / f"{model}{len(os.listdir(folder))}.fmu"
        actuator("fmu", "--out", self.path, "--model", model_name(model), *MODELS[model], *options)
        self.unpacked = extract(str(self.path), unzipdir=str(self.path.with_suffix("")))
        self.description = read_model_description(str(self.path))
        self.references = {v.name: v.valueReference for v in self.description.modelVariables}

    def outputs(self):
        return COMMON + (BENCH if self.model == "bench" else [])


class Instance:
    """A running FMU, and the messages to its logger."""

    def __init__(self, unit, guid=None, messages=None):
        self.unit = unit
        self.messages = [] if messages is None else messages
        self.callbacks = fmi2CallbackFunctions()
        self.callbacks.logger = fmi2CallbackLoggerTYPE(
            lambda _, name, status, category, text: self.messages.append(text.decode())
        )
        self.fmu = FMU2Slave(
            guid=guid or unit.description.guid,
            unzipDirectory=unit.unpacked,
            modelIdentifier=unit.description.coSimulation.modelIdentifier,
            instanceName="test",
        )
        self.fmu.instantiate(callbacks=self.callbacks)

    def initialize(self):
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        return self

    def set(self, name, value):
        self.fmu.setReal([self.unit.references[name]], [value])

    def get(self, names):
        return self.fmu.getReal([self.unit.references[name] for name in names])

    def run(self, step_ms, first=0, steps=None):
        """Steps with a seeded random command per 20 ms; returns time in ms and outputs."""
        rows = {}
        steps = steps or round(DURATION_S * 1e3 / step_ms)
        for i in range(first, first + steps):
            self.set("command_deg", COMMANDS[i * step_ms // 20])
            self.fmu.doStep(i * step_ms * 1e-3, step_ms * 1e-3)
            rows[(i + 1) * step_ms] = self.get(self.unit.outputs())
        return rows

    def close(self):
        self.fmu.terminate()
        self.fmu.freeInstance()


def held_before(signal):
    """The signal with each value until just before the next: FMPy interpolates inputs linearly."""
    ends = signal[:-1].copy()
    ends["time"] = signal["time"][1:] - 1e-7
    both = np.concatenate([signal, ends])
    return both[np.argsort(both["time"], kind="stable")]


COMMANDS = np.random.default_rng(1).uniform(-90.0, 90.0, 100)


def for_each_unit(test):
    """Runs a test on every FMU, also after a failure."""

    @functools.wraps(test)
    def run(self):
        for unit in self.units:
            with self.subTest(unit.model):
                test(self, unit)

    return run


class Fmus(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp()
        cls.units = [Unit(cls.folder, model) for model in MODELS]

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def simulated(self, unit, times_s, commands, *options):
        """The trace of every tick by `actuator simulate` for these commands."""
        file = Path(self.folder) / "command.csv"
        rows = "".join(f"{t!r},{c!r}\n" for t, c in zip(times_s.tolist(), commands.tolist()))
        file.write_text("t,command_deg\n" + rows)
        text = actuator(
            "simulate", model_name(unit.model), *MODELS[unit.model], "--input-file", file,
            "--duration", DURATION_S + 0.1, "--every", 1, "--csv", "-", *options,
        )
        return np.genfromtxt(io.StringIO(text), delimiter=",", names=True)

    def compare(self, unit, result, trace):
        """A row of the trace has the values after the PWM edge and the control step of its instant, an
        output of the FMU those before: values changed there are one tick earlier in the trace."""
        ticks = np.rint(result["time"] / TICK_S).astype(int)
        ticks, result = ticks[ticks > 0], result[ticks > 0]
        settled = trace["command_delayed_deg"][ticks] == trace["command_delayed_deg"][ticks - 1]
        self.assertGreater(settled.sum(), len(ticks) / 2)
        for name in unit.outputs():
            if model_name(unit.model) == "board":
                at_edge = name in ("duty_pct", "angle_meas_deg", "rate_meas_deg_s")
                expected, seen = trace[name][ticks - at_edge], result[name]
            else:
                # Rate and duty of the other models depend on the command at the same instant.
                expected, seen = trace[name][ticks][settled], result[name][settled]
            np.testing.assert_array_equal(seen, expected, err_msg=name)

    @for_each_unit
    def test_the_validation_reports_nothing(self, unit):
        self.assertEqual(validate_fmu(str(unit.path)), [])

    @for_each_unit
    def test_the_trace_is_that_of_the_simulator_whatever_the_communication_step(self, unit):
        for step_s in (1e-3, 4e-3, 10e-3):
            times_s = np.arange(round(DURATION_S / step_s) + 1) * step_s
            commands = COMMANDS[(times_s / 0.02 + 1e-6).astype(int)]
            trace = self.simulated(unit, times_s, commands)
            signal = np.array(
                list(zip(times_s, commands)),
                dtype=[("time", float), ("command_deg", float)],
            )
            result = simulate_fmu(
                str(unit.path), stop_time=DURATION_S, step_size=step_s,
                output_interval=step_s, input=signal, output=unit.outputs(),
            )
            self.assertEqual(len(result), len(times_s))
            self.compare(unit, result, trace)

    @for_each_unit
    def test_steps_of_1_and_4_and_10_ms_agree_where_they_meet(self, unit):
        runs = []
        for step_ms in (1, 4, 10):
            instance = Instance(unit).initialize()
            runs.append(instance.run(step_ms))
            instance.close()
        for other in runs[1:]:
            common = runs[0].keys() & other.keys()
            self.assertGreaterEqual(len(common), 120)
            for at in common:
                self.assertEqual(runs[0][at], other[at], at)

    def test_start_values_of_file_and_host_act_alike(self):
        changed = Unit(self.folder, "board", "--preset", "as-measured", "--set", "P=12")
        self.assertNotEqual(changed.description.guid, self.units[3].description.guid)
        values = {"motor_gain_up": 2.4, "motor_gain_down": 3.5, "position_gain": 12.0,
                  "motor_time_constant_s": 1 / 54}
        from_file = Instance(changed)
        from_host = Instance(self.units[3])
        for name, value in values.items():
            from_host.set(name, value)
        runs = [instance.initialize().run(4) for instance in (from_file, from_host)]
        self.assertEqual(*runs)
        times_s = np.arange(round(DURATION_S / 0.02)) * 0.02
        trace = self.simulated(changed, times_s, COMMANDS[: len(times_s)],
                               "--preset", "as-measured", "--set", "P=12")
        result = np.array(
            [(at * 1e-3, *row) for at, row in runs[0].items()],
            dtype=[(name, float) for name in ["time", *COMMON]],
        )
        self.compare(changed, result, trace)

    @for_each_unit
    def test_a_reset_leads_back_to_the_beginning(self, unit):
        instance = Instance(unit).initialize()
        first = instance.run(10)
        instance.fmu.reset()
        self.assertEqual(instance.initialize().run(10), first)
        instance.close()

    @for_each_unit
    def test_a_state_is_gone_back_to_and_taken_to_another_instance(self, unit):
        instance = Instance(unit).initialize()
        instance.run(4, steps=100)
        state = instance.fmu.getFMUstate()
        expected = instance.run(4, first=100, steps=100)
        instance.fmu.setFMUstate(state)
        self.assertEqual(instance.run(4, first=100, steps=100), expected)
        data = instance.fmu.serializeFMUstate(state)
        instance.fmu.freeFMUstate(state)
        instance.close()
        other = Instance(unit).initialize()
        other.fmu.setFMUstate(other.fmu.deSerializeFMUstate(data))
        self.assertEqual(other.run(4, first=100, steps=100), expected)
        for garbage in (data[:-1], data[:-1] + bytes([data[-1] ^ 1]), b"", bytes(5000)):
            with self.assertRaises(Exception):
                other.fmu.deSerializeFMUstate(garbage)
        other.close()

    @for_each_unit
    def test_eight_threads_run_eight_instances(self, unit):
        alone = Instance(unit).initialize().run(1)
        with ThreadPoolExecutor(8) as pool:
            runs = pool.map(lambda _: Instance(unit).initialize().run(1), range(8))
            for run in runs:
                self.assertEqual(run, alone)

    @for_each_unit
    def test_a_wrong_guid_is_refused_with_a_message(self, unit):
        messages = []
        with self.assertRaises(Exception):
            Instance(unit, guid="{00000000-0000-0000-0000-000000000000}", messages=messages)
        self.assertIn("{00000000-0000-0000-0000-000000000000}", messages[0])

    @for_each_unit
    def test_misuse_is_an_error_that_names_what_is_wrong_and_leaves_the_host_alive(self, unit):
        instance = Instance(unit)
        fmu = instance.fmu
        with self.assertRaises(Exception):
            fmu.doStep(0.0, 0.01)
        instance.initialize()
        for call, word in [
            (lambda: instance.set("command_deg", float("nan")), "command_deg"),
            (lambda: instance.set("command_deg", float("inf")), "command_deg"),
            (lambda: instance.set("angle_deg", 0.0), "angle_deg"),
            (lambda: instance.set("delay_s", 0.0), "delay_s"),
            (lambda: fmu.setReal([99999], [0.0]), "99999"),
            (lambda: fmu.getReal([99999]), "99999"),
            (lambda: fmu.getString([0]), "string"),
            (lambda: fmu.doStep(0.0, 0.0), "communicationStepSize"),
            (lambda: fmu.doStep(0.0, -0.01), "communicationStepSize"),
            (lambda: fmu.doStep(0.0, float("nan")), "communicationStepSize"),
            (lambda: fmu.doStep(1.0, 0.01), "currentCommunicationPoint"),
            (lambda: fmu.setFMUstate(ctypes.c_void_p(12345)), "state"),
            (fmu.enterInitializationMode, "phase"),
            (fmu.cancelStep, "step"),
        ]:
            with self.assertRaises(Exception):
                call()
            self.assertIn(word, instance.messages[-1])
        self.assertEqual(instance.get(["angle_deg"]), [0.0])
        fmu.doStep(0.0, 0.01)
        instance.close()

    @for_each_unit
    def test_fmi_3_gives_the_same_bits(self, unit):
        path = str(unit.path.with_suffix(".3.fmu"))
        actuator("fmu", "--fmi", "3", "--out", path, "--model", model_name(unit.model), *MODELS[unit.model])
        self.assertEqual(read_model_description(path, validate=True).fmiVersion, "3.0")
        times = np.arange(0.0, 1.0, 0.02)
        signals = np.array(list(zip(times, COMMANDS)), [("time", float), ("command_deg", float)])
        arguments = {"stop_time": 1.0, "output_interval": 0.01, "input": signals}
        start = {"delay_s": 0.01}
        two, three = (
            simulate_fmu(fmu, start_values=start, output=unit.outputs(), **arguments)
            for fmu in (str(unit.path), path)
        )
        for name in unit.outputs():
            self.assertEqual(two[name].tobytes(), three[name].tobytes(), name)
        self.assertGreater(np.ptp(three["angle_deg"]), 5.0)

    def test_model_exchange_finds_the_angle_of_co_simulation_within_the_tolerance_of_the_solver(self):
        # A command that is held for 20 ms: a step at each change, which FMPy makes an event.
        times = np.repeat(np.arange(0.0, DURATION_S, 0.02), 2)[1:]
        commands = np.repeat(COMMANDS[: len(times) // 2 + 1], 2)[: len(times)]
        steps = np.array(list(zip(times, commands)), [("time", float), ("command_deg", float)])
        held = steps[::2].copy()
        choices = {
            "black-box-1": [{}, {"position_limit_deg": 20.0}, {"host_period_s": 0.03}],
            "black-box-2": [{}, {"rate_limit_form": 1.0}, {"rate_limit_form": 2.0}, {"position_limit_deg": 20.0}],
            "grey-box": [{}, {"rate_limit_up_deg_s": 60.0}, {"position_limit_deg": 8.0}, {"delay_s": 0.0}],
        }
        for unit in self.units:
            for start in choices.get(unit.model, []):
                for version in (2, 3):
                    with self.subTest(unit.model, version=version, **start):
                        path = str(unit.path.with_suffix(f".{version}.exchange.fmu"))
                        actuator("fmu", "--fmi", version, "--out", path, "--model", unit.model)
                        run = functools.partial(
                            simulate_fmu, path, stop_time=DURATION_S, output_interval=0.004,
                            start_values=start, output=["angle_deg", "rate_deg_s"],
                        )
                        # Co-simulation takes a command at the step that begins with it.
                        expected = run(fmi_type="CoSimulation", input=held_before(held))
                        found = run(fmi_type="ModelExchange", input=steps, solver="CVode",
                                    relative_tolerance=1e-8, record_events=False)
                        np.testing.assert_allclose(found["time"], expected["time"], atol=1e-9)
                        difference = np.abs(found["angle_deg"] - expected["angle_deg"])
                        # Co-simulation applies to the grey box a tick of torque at its stop, and
                        # then takes the rate.
                        has_stop = unit.model == "grey-box" and "position_limit_deg" in start
                        self.assertLess(difference.max(), 0.01 if has_stop else 1e-4)
                        self.assertGreater(np.ptp(found["angle_deg"]), 10.0)

    def test_model_exchange_without_a_limit_is_the_solution_of_the_equation(self):
        # p (c - theta) with c = 5 deg from 0.1 s on: 5 deg (1 - exp(-30 t)) after the delay.
        unit = self.units[0]
        signal = np.array([(0.0, 0.0), (0.1, 0.0), (0.1, 5.0), (1.0, 5.0)], [("time", float), ("command_deg", float)])
        result = simulate_fmu(str(unit.path), fmi_type="ModelExchange", stop_time=0.6, output_interval=0.01,
                              input=signal, output=["angle_deg"], relative_tolerance=1e-9, record_events=False)
        after = np.maximum(result["time"] - 0.1 - 0.0175, 0.0)
        np.testing.assert_allclose(result["angle_deg"], 5.0 * (1.0 - np.exp(-30.0 * after)), atol=1e-6)

    @for_each_unit
    def test_a_long_step_of_fmi_3_is_interrupted_and_shows_its_progress(self, unit):
        path = str(unit.path.with_suffix(".early.fmu"))
        actuator("fmu", "--fmi", "3", "--out", path, "--model", model_name(unit.model), *MODELS[unit.model])
        description = read_model_description(path)
        reported = []

        def update(environment, time, set_requested, get_allowed, finished, can_return_early, early, early_time):
            reported.append((time, clock.monotonic()))
            if len(reported) == 10:
                early[0], early_time[0] = True, time

        fmu = FMU3Slave(guid=description.guid, unzipDirectory=extract(path), instanceName="test",
                        modelIdentifier=description.coSimulation.modelIdentifier)
        fmu.instantiate(earlyReturnAllowed=True, intermediateUpdate=fmi3IntermediateUpdateCallback(update))
        fmu.enterInitializationMode()
        fmu.exitInitializationMode()
        _, _, is_early, reached = fmu.doStep(0.0, 1e6)
        self.assertTrue(is_early)
        self.assertEqual(reached, reported[-1][0])
        self.assertLess(clock.monotonic() - reported[-1][1], 0.2)
        np.testing.assert_allclose([time for time, _ in reported], np.arange(1, 11) * 0.1, atol=1e-9)
        fmu.terminate()
        fmu.freeInstance()


if __name__ == "__main__":
    unittest.main()
