"""Black box 1 as a JSBSim system against the C library.

Usage: compare.py LIBRARY
"""
import sys
import tempfile

import servo

# Steps up and down that reach both rate limits: time, s, and command, deg.
STEPS = [(0.1, 90.0), (1.0, -60.0), (2.0, 5.0), (2.5, 0.0)]
END_S = 3.0
RATE_LIMIT_DEG_S = 350.0


def command_deg(time_s):
    return next((command for start, command in reversed(STEPS) if time_s >= start - 1e-9), 0.0)


def tolerance_deg(frame_s):
    """Tolerance between the system and the model, deg.

    At full rate a shift in time by a frame makes RATE_LIMIT * frame. JSBSim's delay of 17.5 ms is rounded down to whole
    frames and short by one more: at most two. The trapezoid of its integrator meets a step half a frame late. And the
    loop, closed a frame late, bends from the limit into its exponential 1/e of a frame apart.
    """
    return (2.0 + 0.5 + 0.37) * RATE_LIMIT_DEG_S * frame_s


def differences(library, folder, name, frame_s):
    """The largest differences from the model, deg: of the system, and of JSBSim's lag with a rate limit."""
    fdm = servo.simulator(folder, name, frame_s)
    fdm["ic/h-sl-ft"], fdm["ic/vc-kts"] = 3000, 100
    fdm.run_ic()
    # The delay line of the system is initially zero, like that of the model after a first command
    # of 0.
    model = servo.Servo(library, "black-box-1")
    system = lag = 0.0
    for frame in range(1, round(END_S / frame_s) + 1):
        command = command_deg((frame - 1) * frame_s)
        fdm["servo/command-deg"] = command
        fdm.run()
        angle = model.advance_to(command, frame * frame_s)
        system = max(system, abs(fdm["servo/angle-deg"] - angle))
        lag = max(lag, abs(fdm["servo/lag-angle-deg"] - angle))
    return system, lag


def main():
    failed = False
    with tempfile.TemporaryDirectory() as folder:
        name = servo.aircraft(folder)
        print("frame, s   system, deg   allowed, deg   lag and rate limit, deg")
        for frames in (120, 1000, 4000):
            system, lag = differences(sys.argv[1], folder, name, 1 / frames)
            allowed = tolerance_deg(1 / frames)
            failed |= not system <= allowed
            print(f"1/{frames:<9}{system:<14.3f}{allowed:<15.3f}{lag:.3f}")
    # The error of JSBSim's own lag does not decrease with the frame time.
    failed |= not lag > 1.0
    return failed


if __name__ == "__main__":
    sys.exit(main())
