"""The speed of a vector environment's batch against that of the native batch: 10,000 actuators.

`python vector.py PROGRAM`, PROGRAM is what `cargo bench -p host-sim --no-run` builds. Runs of both
alternate, so that other load of the machine affects both alike.
"""

import statistics
import sys
import time

import numpy as np

import smart_actuator as sa
from batch import native

ACTUATORS = 10_000
STEP_S = 0.02
STEPS = 100
ROUNDS = 5


def own():
    """Simulated seconds per second with its own command for each actuator in each step."""
    spread = np.linspace(0.9, 1.1, ACTUATORS)
    batch = sa.ActuatorBatch(
        {
            "motor_gain_up": 2.836 * spread,
            "motor_gain_down": 2.836 * spread,
            "motor_time_constant_s": spread / 7.586,
        },
        step_s=STEP_S,
    )
    commands = np.random.default_rng(0).uniform(-60, 60, (STEPS, ACTUATORS))

    def seconds():
        start = time.perf_counter()
        for command in commands:
            batch.step(command)
        return time.perf_counter() - start

    seconds()
    return ACTUATORS * STEPS * STEP_S / statistics.median(seconds() for _ in range(ROUNDS))


def main():
    before = own()
    _, there = native(sys.argv[1])
    speed = statistics.mean([before, own()])
    print(
        f"{speed:,.0f} simulated seconds per second with steps of {STEP_S} s, the native batch of "
        f"50 us {there:,.0f}: {speed / there:.2f}"
    )


if __name__ == "__main__":
    main()
