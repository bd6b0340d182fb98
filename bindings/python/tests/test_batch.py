import numpy as np
import pytest

import smart_actuator as sa


@pytest.mark.parametrize("kind", [{}, {"plant": "bench"}, {"model": "grey-box"}])
def test_each_of_a_batch_moves_as_it_does_alone(kind):
    gains, delays = np.linspace(4.0, 9.0, 40), np.linspace(0.0, 0.03, 40)
    batch = sa.ActuatorBatch({"position_gain": gains, "delay_s": delays}, step_s=0.02, **kind)
    servos = [sa.Actuator(position_gain=g, delay_s=d, **kind) for g, d in zip(gains, delays)]
    rng = np.random.default_rng(0)
    for step in range(20):
        if step == 12:
            batch.replace([3, 30], {"position_gain": [5.0, 6.0], "delay_s": [0.01, 0.0]})
            servos[3] = sa.Actuator(position_gain=5.0, delay_s=0.01, **kind)
            servos[30] = sa.Actuator(position_gain=6.0, delay_s=0.0, **kind)
        commands = rng.uniform(-60, 60, len(batch))
        states = batch.step(commands)
        for i, servo in enumerate(servos):
            now = servo.advance(commands[i], seconds=0.02)
            expected = now.angle_deg, now.rate_deg_s, now.angle_meas_deg, now.rate_meas_deg_s
            assert tuple(states[i]) == expected


@pytest.mark.parametrize(
    "error, message, arguments",
    [
        (ValueError, "actuator 1: .*position_gain is -1", {"parameters": {"P": [8.0, -1.0]}}),
        (KeyError, "did you mean", {"parameters": {"positon_gain": [8.0]}}),
        (TypeError, "a count", {}),
        (ValueError, "2 values or one", {"parameters": {"P": [1.0, 2.0, 3.0]}, "count": 2}),
        (ValueError, "whole number of ticks", {"count": 2, "step_s": 1e-5}),
        (ValueError, "whole number of ticks", {"count": 2, "step_s": float("nan")}),
    ],
)
def test_a_batch_that_cannot_be_made_is_refused(error, message, arguments):
    with pytest.raises(error, match=message):
        sa.ActuatorBatch(**arguments)


def test_commands_of_another_shape_and_wrong_indices_are_refused():
    batch = sa.ActuatorBatch({"P": [8.0, 9.0]})
    with pytest.raises(ValueError, match="expected \\(2,\\)"):
        batch.step([1.0])
    for indices in ([2], [-1], [0, 0]):
        with pytest.raises(ValueError):
            batch.replace(indices, {"P": [8.0] * len(indices)})
    with pytest.raises(ValueError, match="expected"):
        batch.replace([0], {"tau": [0.1]})


def test_the_inputs_within_the_loops_drive_the_motor():
    servo = sa.Actuator(delay_s=0.0)
    assert servo.advance(40.0, seconds=2.0, input="rate").rate_deg_s == pytest.approx(40, abs=3)
    duty = servo.advance(-30.0, seconds=2.0, input="duty")
    # Fifteen time constants.
    assert duty.rate_deg_s == pytest.approx(-30 * 2.836, rel=1e-5)
    with pytest.raises(ValueError, match="no input `voltage`"):
        servo.advance(3.0, ticks=1, input="voltage")
    with pytest.raises(ValueError, match="unknown input `torque`"):
        servo.advance(3.0, ticks=1, input="torque")
    bench = sa.Actuator(plant="bench", delay_s=0.0)
    volts = bench.advance(3.0, seconds=0.5, input="voltage").angle_deg
    same = sa.Actuator(plant="bench", delay_s=0.0)
    assert same.advance(50.0, seconds=0.5, input="duty").angle_deg == volts


def test_an_inertia_as_a_signal_and_a_place():
    by_signal, by_parameter = (
        sa.Actuator(plant="bench"),
        sa.Actuator(plant="bench", load_inertia_kg_m2=2e-6 + 0.003),
    )
    by_signal.set_load_inertia(0.003)
    assert by_signal.advance(30.0, seconds=0.3) == by_parameter.advance(30.0, seconds=0.3)
    with pytest.raises(ValueError, match="inertia_kg_m2 is -1"):
        by_signal.set_load_inertia(-1)
    placed = sa.Actuator()
    placed.place(25.0)
    assert placed.advance(25.0, seconds=0.5).angle_deg == pytest.approx(25.0, abs=0.09)
