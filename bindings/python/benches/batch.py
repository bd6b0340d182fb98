"""The speed of monte_carlo against that of the native batch: 1,000 actuators for 60 s each.

`python batch.py PROGRAM`, PROGRAM is what `cargo bench -p host-sim --no-run` builds. Runs of
both alternate, so that other load of the machine affects both alike.
"""

import re
import statistics
import subprocess
import sys
import time

import numpy as np

import smart_actuator as sa

ACTUATORS = 1000
SECONDS = 60.0
ROUNDS = 3


def own(every):
    """Simulated seconds per second, the median of some rounds."""
    spread = np.linspace(0.9, 1.1, ACTUATORS)
    parameters = {
        "motor_gain_up": 2.836 * spread,
        "motor_gain_down": 2.836 * spread,
        "motor_time_constant_s": spread / 7.586,
    }

    def seconds():
        start = time.perf_counter()
        sa.monte_carlo(
            parameters,
            input="variable-step",
            input_parameters={"dwell_s": 4.0},
            duration=SECONDS,
            every=every,
        )
        return time.perf_counter() - start

    return ACTUATORS * SECONDS / statistics.median(seconds() for _ in range(ROUNDS))


def native(program):
    """Simulated seconds per second of the native batch, at 1 ms and at 50 us."""
    output = subprocess.run([program, "--bench"], check=True, capture_output=True, text=True)
    find = r"figure 1,000 boards[^:]*: %s = ([\d.]+) s/s"
    return [float(re.search(find % step, output.stdout)[1]) for step in ("1 ms", "50 us")]


def main():
    before = [own(20), own(1)]
    there = native(sys.argv[1])
    after = [own(20), own(1)]
    for step, native_speed, *speeds in zip(("1 ms", "50 us"), there, before, after):
        speed = statistics.mean(speeds)
        print(
            f"{step} steps: {speed:,.0f} simulated seconds per second, natively "
            f"{native_speed:,.0f}: {speed / native_speed:.2f}"
        )


if __name__ == "__main__":
    main()
