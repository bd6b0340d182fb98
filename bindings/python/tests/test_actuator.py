import copy
import pickle
import threading

import numpy as np
import pytest

import smart_actuator as sa

KINDS = [
    {"model": "board"},
    {"model": "board", "plant": "bench", "seed": 3, "encoder_noise_deg": 0.2, "P": 12.0},
    {"model": "grey-box", "preset": "as-printed"},
    {"model": "black-box-1"},
    {"model": "black-box-2", "delay_s": 0.1},
]


def moved(servo):
    """Readings during a motion that has not settled."""
    readings = [servo.advance(40.0, ticks=1), servo.advance(40.0, seconds=0.0333)]
    return [*readings, servo.advance(-25.0, ticks=977), servo.advance(10.0, ticks=200)]


@pytest.mark.parametrize("kind", KINDS)
def test_steps_lead_where_the_recorded_run_leads(kind):
    t, command = [0.0, 0.5, 0.7], [20.0, -10.0, 5.0]
    trace = sa.simulate(**kind, command=(t, command), duration=1.0, every=7)
    servo = sa.Actuator(**kind)
    for row, time in enumerate(trace.time_s):
        # A row is the state after the PWM edge at its tick; the step ends just before the edge.
        tick = round(time * 20_000)
        while servo.tick < tick:
            now = command[np.searchsorted(t, servo.time + 1e-9, side="right") - 1]
            reading = servo.advance(now, ticks=1)
        if tick:
            assert reading.angle_deg == trace.angle_deg[row], time
            # The rate of black box 1 jumps with its command, which is already applied in a row.
            if kind["model"] != "black-box-1":
                assert reading.rate_deg_s == trace.rate_deg_s[row], time


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    "keep", [copy.copy, copy.deepcopy, lambda servo: pickle.loads(pickle.dumps(servo))]
)
def test_a_copy_continues_exactly_and_alone(kind, keep):
    servo = sa.Actuator(**kind)
    moved(servo)
    kept = keep(servo)
    assert kept.time == servo.time and kept.parameters == servo.parameters
    expected = moved(servo)
    assert moved(kept) == expected


@pytest.mark.parametrize("kind", KINDS)
def test_a_snapshot_leads_back_exactly(kind):
    servo = sa.Actuator(**kind)
    at_rest = servo.snapshot()
    first = moved(servo)
    later = servo.snapshot()
    onward = moved(servo)
    servo.restore(later)
    assert moved(servo) == onward
    servo.restore(at_rest)
    assert moved(servo) == first


def test_a_snapshot_of_another_or_a_damaged_one_is_refused_and_changes_nothing():
    servo = sa.Actuator()
    servo.advance(10.0, ticks=500)
    before = servo.reading()
    with pytest.raises(ValueError, match="another model, seed or parameters"):
        servo.restore(sa.Actuator(P=11.0).snapshot())
    snapshot = servo.snapshot()
    for place in range(0, len(snapshot), 97):
        damaged = bytearray(snapshot)
        damaged[place] ^= 0x10
        with pytest.raises(ValueError, match="not a snapshot"):
            servo.restore(bytes(damaged))
    for cut in (b"", snapshot[:3], snapshot[:-1], b"\0\0\0\0"):
        with pytest.raises(ValueError, match="not a snapshot"):
            servo.restore(cut)
    with pytest.raises(TypeError, match="expected bytes"):
        servo.restore("snapshot")
    assert servo.reading() == before


def test_a_torque_on_the_load_holds_the_bench_back():
    free, held = sa.Actuator(plant="bench"), sa.Actuator(plant="bench")
    held.set_load_torque(-0.3)
    ends = [servo.advance(60.0, seconds=0.2).angle_deg for servo in (free, held)]
    assert ends[1] < ends[0] - 1.0
    with pytest.raises(ValueError, match="a load torque applies to"):
        sa.Actuator().set_load_torque(0.1)


NAN = float("nan")


@pytest.mark.parametrize(
    "error, message, arguments",
    [
        (ValueError, "command_deg is NaN, expected", {"command_deg": NAN, "ticks": 1}),
        (ValueError, "command_deg is inf, expected", {"command_deg": float("inf"), "ticks": 1}),
        (TypeError, "command_deg is 'a', expected", {"command_deg": "a", "ticks": 1}),
        (TypeError, "either ticks or seconds", {"command_deg": 1.0}),
        (TypeError, "either ticks or seconds", {"command_deg": 1.0, "ticks": 1, "seconds": 1.0}),
        (ValueError, "ticks is -1, expected", {"command_deg": 1.0, "ticks": -1}),
        (TypeError, "ticks is 1.5, expected", {"command_deg": 1.0, "ticks": 1.5}),
        (ValueError, "command_deg is 1e308, expected an angle from -32768", {"command_deg": 1e308, "ticks": 1}),
        (ValueError, "command_deg is 32768, expected", {"command_deg": 32768.0, "seconds": 1.0}),
        (ValueError, "expected 200000000000 at most", {"command_deg": 1.0, "ticks": 2**63}),
        (ValueError, "seconds is -0.1, expected", {"command_deg": 1.0, "seconds": -0.1}),
        (ValueError, "seconds is nan, expected", {"command_deg": 1.0, "seconds": NAN}),
        (ValueError, "seconds is 1e\\+308, expected", {"command_deg": 1.0, "seconds": 1e308}),
    ],
)
def test_a_step_that_cannot_be_taken_is_refused_and_moves_nothing(error, message, arguments):
    servo = sa.Actuator()
    with pytest.raises(error, match=message):
        servo.advance(**arguments)
    assert servo.tick == 0


@pytest.mark.parametrize("step_s", [1 / 240, 1 / 120, 1 / 60, 1e-5, 1 / 3, np.float32(0.01)])
def test_steps_of_any_length_do_not_drift(step_s):
    servo, to = sa.Actuator(), sa.Actuator()
    for number in range(1, 2001):
        reading = servo.advance(30.0, seconds=step_s)
        # Half a tick of 50 us, and rounding.
        assert abs(reading.time_s - number * float(step_s)) <= 25.0001e-6
        assert reading == to.advance_to(30.0, number * float(step_s))


def test_a_copy_keeps_the_time_of_its_caller():
    servo = sa.Actuator()
    servo.advance(10.0, seconds=20e-6)
    again = pickle.loads(pickle.dumps(servo))
    assert servo.tick == again.tick == 0
    for each in (servo, again, copy.copy(servo)):
        each.advance(10.0, seconds=20e-6)
        assert each.tick == 1


def test_an_actuator_does_not_go_back_in_time():
    servo = sa.Actuator()
    servo.advance_to(5.0, 0.5)
    with pytest.raises(ValueError, match="time_s is 0.4, the actuator is at 0.5 s"):
        servo.advance_to(5.0, 0.4)
    with pytest.raises(ValueError, match="time_s is nan, expected a time"):
        servo.advance_to(5.0, NAN)
    assert servo.advance_to(5.0, 0.5).time_s == 0.5


def test_parameters_are_read_only():
    with pytest.raises(TypeError, match="does not support item assignment"):
        sa.Actuator().parameters["position_gain"] = 3


def test_a_torque_that_is_no_number_is_refused():
    with pytest.raises(ValueError, match="torque_nm is NaN"):
        sa.Actuator(plant="bench").set_load_torque(NAN)
    with pytest.raises(ValueError, match="torque_nm is 1000, expected a torque from -100 to 100"):
        sa.Actuator(plant="bench").set_load_torque(1e3)


def test_parameters_are_checked_as_for_a_run():
    with pytest.raises(KeyError, match="did you mean `position_gain`"):
        sa.Actuator(postion_gain=1.0)
    with pytest.raises(ValueError, match="position_gain is -1"):
        sa.Actuator(position_gain=-1.0)


def test_an_actuator_says_what_it_is():
    servo = sa.Actuator(plant="bench", seed=5, P=12.5)
    assert (servo.model, servo.plant, servo.pwm, servo.seed) == ("board", "bench", "average", 5)
    assert servo.parameters["position_gain"] == 12.5
    assert repr(servo) == "<Actuator board on bench at 0.0 s: 0.000 deg>"
    assert sa.Actuator("grey-box").plant is None
    assert servo.reading()._fields[2] == "angle_deg"


def test_threads_that_share_an_actuator_take_turns():
    servo, alone = sa.Actuator(plant="bench"), sa.Actuator(plant="bench")
    barrier = threading.Barrier(4)

    def step():
        barrier.wait()
        for _ in range(300):
            servo.advance(30.0, ticks=7)
            servo.reading()
            copy.copy(servo)

    threads = [threading.Thread(target=step) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert servo.reading() == alone.advance(30.0, ticks=4 * 300 * 7)
