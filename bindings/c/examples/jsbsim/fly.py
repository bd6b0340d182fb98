"""A Cessna 172 climbs and holds its altitude with the smart actuator in its elevator.

Usage: fly.py LIBRARY

The autopilot is that of the aircraft; what it commands goes to the servo, and what the servo does goes to the elevator.
"""
import math
import sys
import tempfile

import servo

FRAME_S = 1 / 120
END_S = 240.0
START_FT, CLIMB_FT = 3000.0, 100.0

# Actuator of the elevator: a model with its parameters, or None for an ideal elevator without
# delay.
SERVOS = {
    "ideal": None,
    "board": ("board", {}),
    "black box 1": ("black-box-1", {}),
    # The motor gain as the paper prints it, 37.4 deg/s, and a delay that it does not have.
    "slow and late": ("board", {"motor_gain_up": 0.374, "motor_gain_down": 0.374, "delay_s": 0.8}),
}

# Maximum change of the altitude by a fast servo, ft: a tenth of the climb. A slow servo must change
# it by more, which proves that the servo is in the loop.
NEAR_FT = 0.1 * CLIMB_FT


def fly(library, folder, name, choice):
    """Flies; returns rows of time, s, altitude, ft, elevator command and elevator, deg."""
    fdm = servo.simulator(folder, name, FRAME_S)
    fdm["ic/h-sl-ft"], fdm["ic/vc-kts"] = START_FT, 100
    fdm["fcs/throttle-cmd-norm"], fdm["fcs/mixture-cmd-norm"] = 0.75, 0.9
    fdm.run_ic()
    fdm["propulsion/set-running"] = -1
    fdm["ap/attitude_hold"], fdm["ap/altitude_hold"] = 1, 1
    fdm["ap/altitude_setpoint"] = START_FT + CLIMB_FT
    device = choice and servo.Servo(library, choice[0], **choice[1])
    rows = []
    for frame in range(1, round(END_S / FRAME_S) + 1):
        time_s = frame * FRAME_S
        fdm.run()
        command_deg = math.degrees(fdm["fcs/elevator-control"])
        angle_deg = device.advance_to(command_deg, time_s) if device else command_deg
        fdm["servo/elevator-deg"] = angle_deg
        rows.append((time_s, fdm["position/h-sl-ft"], command_deg, angle_deg))
    return rows


def root_mean_square(values):
    return math.sqrt(sum(value * value for value in values) / len(values))


def main():
    with tempfile.TemporaryDirectory() as folder:
        name = servo.aircraft(folder)
        flights = {title: fly(sys.argv[1], folder, name, choice) for title, choice in SERVOS.items()}
    print(f"{'servo':<15}at the end, ft   off the ideal flight, ft at most   elevator off its command, deg rms")
    off_ft = {}
    for title, rows in flights.items():
        off_ft[title] = max(abs(row[1] - ideal[1]) for row, ideal in zip(rows, flights["ideal"]))
        off_deg = root_mean_square([command - angle for _, _, command, angle in rows])
        print(f"{title:<15}{rows[-1][1]:<17.1f}{off_ft[title]:<34.1f}{off_deg:.3f}")
    good = off_ft["board"] < NEAR_FT and off_ft["black box 1"] < NEAR_FT < off_ft["slow and late"]
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
