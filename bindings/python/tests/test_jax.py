import numpy as np
import pytest

import smart_actuator as sa

jax = pytest.importorskip("jax", reason="the extra `jax` is not installed")

TIMES = np.arange(50) * 0.02


@pytest.fixture(autouse=True)
def double_precision():
    jax.config.update("jax_enable_x64", True)
    yield
    jax.config.update("jax_enable_x64", False)


def test_jax_differentiates_by_commands_and_parameters_through_other_operations():
    from smart_actuator.jax import response

    angle = response("grey-box", TIMES, by=["position_gain", "delay_s"])
    target = 10 * np.sin(3 * TIMES)

    def cost(command, values):
        return jax.numpy.mean((angle(jax.numpy.tanh(command) * 12, values) - target) ** 2)

    command, values = 0.3 * np.cos(2 * TIMES), np.array([7.0, 0.0175])
    slopes = jax.jit(jax.grad(cost, argnums=(0, 1)))(command, values)
    for argument, place in [(0, 0), (0, 17), (0, 49), (1, 0), (1, 1)]:
        step = np.zeros(len((command, values)[argument]))
        step[place] = 1e-5
        ends = [
            float(
                cost(command + sign * step, values)
                if argument == 0
                else cost(command, values + sign * step)
            )
            for sign in (1, -1)
        ]
        assert slopes[argument][place] == pytest.approx(
            (ends[0] - ends[1]) / 2e-5, abs=1e-6, rel=1e-6
        )


def test_a_descent_finds_the_command_of_a_wanted_motion():
    from smart_actuator.jax import response

    angle = response("black-box-1", TIMES, delay_s=0.0)
    target = angle(8 * np.sin(4 * TIMES), np.zeros(0))
    cost = jax.jit(lambda command: jax.numpy.sum((angle(command, np.zeros(0)) - target) ** 2))
    slope, command = jax.jit(jax.grad(cost)), np.zeros(len(TIMES))
    before = float(cost(command))
    # The step of a lag that reaches a third of its command within a sample.
    for _ in range(100):
        command = command - 0.4 * slope(command)
    assert float(cost(command)) < 1e-4 * before


def test_a_board_is_refused_by_name():
    from smart_actuator.jax import response

    with pytest.raises(Exception, match="`board` has no derivatives"):
        response("board", TIMES)(np.zeros(50), np.zeros(0)).block_until_ready()
