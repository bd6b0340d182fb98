#!/usr/bin/env python3
"""LeRobot's SO-101 leader and follower on simulated servos, from the setup of the motors to an overload.

    lerobot_arms.py target/release/actuator [--seconds 60] [--plot docs/lerobot.svg]

Needs LeRobot 0.6.0, which is too large for CI (docs/lerobot.md). Torques on the shafts stand for the
hands that move an arm: they are set from the positions that LeRobot reads.
"""
import argparse
import builtins
import math
import pathlib
import subprocess
import tempfile
import time

import lerobot.motors.motors_bus as motors_bus
from lerobot.robots.so_follower import SO101Follower, SO101FollowerConfig
from lerobot.teleoperators.so_leader import SO101Leader, SO101LeaderConfig

from plot import plot

RATE_HZ, COUNTS_PER_RAD = 60.0, 4096 / math.tau
HALF_RANGE_RAD = 1.5  # of a joint while it is calibrated
AMPERE_PER_COUNT = 0.0065
OVERLOAD = 0x28  # bits of the status: current and load


class Arm:
    """Six servos on a terminal, and what happens to them."""

    def __init__(self, program, folder, name):
        self.path = str(folder / name)
        command = [program, "serve", "--protocol", "sts3215", "--nodes", "6", "--pty", "--link", self.path]
        self.process = subprocess.Popen(
            command + ["--servo-faults", "-"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        print(self.process.stdout.readline().strip())

    def fault(self, *lines):
        self.process.stdin.write("".join(line + "\n" for line in lines))
        self.process.stdin.flush()

    def all_faults(self, text):
        self.fault(*(f"{servo} {text}" for servo in range(1, 7)))
        time.sleep(0.1)

    def push(self, errors_rad):
        """A hand on each shaft: a spring of 3 Nm/rad, of at most 0.6 Nm."""
        torques = [min(max(3.0 * error, -0.6), 0.6) for error in errors_rad]
        self.fault(*(f"{servo} load {torque:.3f}" for servo, torque in enumerate(torques, start=1)))


def set_up(device, arm):
    """As the motors leave the factory, all with the ID 1; connected one by one, as LeRobot asks for it."""
    arm.all_faults("id 1")
    arm.all_faults("vanish")
    connected = []

    def connect(prompt):
        servo = next(m.id for name, m in device.bus.motors.items() if f"'{name}'" in prompt)
        arm.fault(*(f"{other} vanish" for other in connected), f"{servo} return")
        time.sleep(0.1)
        connected.append(servo)

    builtins.input = connect
    device.setup_motors()
    arm.all_faults("return")
    device.bus.disconnect()
    assert connected == [6, 5, 4, 3, 2, 1], connected


def calibrate(device, arm):
    """Connects, and moves all joints by hand through their ranges while LeRobot records them."""
    start = []

    def entered():
        positions = device.bus.sync_read("Present_Position", normalize=False)
        now = time.monotonic()
        start[:] = start or [now]
        angle = HALF_RANGE_RAD * math.sin(now - start[0])
        arm.push([angle - (count - 2048) / COUNTS_PER_RAD for count in positions.values()])
        return now - start[0] > math.tau

    motors_bus.enter_pressed, builtins.input = entered, lambda *_: ""
    device.connect(calibrate=True)
    arm.push([0.0] * 6)
    assert device.is_calibrated
    for name, joint in device.calibration.items():
        turned = (joint.range_max - joint.range_min) / COUNTS_PER_RAD
        assert name == "wrist_roll" or 2.8 < turned < 3.2, (name, turned)


def hand(leader, arm, action, now):
    """Moves the leader's joints: the gripper between 10 and 90 %, the others between -60 and 60 deg."""
    errors = []
    for place, (key, value) in enumerate(action.items()):
        swing = math.sin((0.5 + 0.1 * place) * now)
        if key == "gripper.pos":
            joint = leader.calibration["gripper"]
            whole_rad = (joint.range_max - joint.range_min) / COUNTS_PER_RAD
            errors.append((50 + 40 * swing - value) / 100 * whole_rad)
        else:
            errors.append(math.radians(60 * swing - value))
    arm.push(errors)


def teleoperate(leader, follower, arm, seconds):
    """Copies the leader's joints; returns time, actions and positions of each cycle."""
    start, rows = time.monotonic(), []
    while (now := time.monotonic() - start) < seconds:
        action = leader.get_action()
        follower.send_action(action)
        rows.append((now, action, follower.get_observation()))
        hand(leader, arm, action, now)
        time.sleep(max(0.0, len(rows) / RATE_HZ - (time.monotonic() - start)))
    arm.push([0.0] * 6)
    return rows


def gripper(follower, what):
    """Prints current and temperature; a sync read, unlike a read, does not raise for the status."""
    names = ("Present_Current", "Present_Temperature", "Present_Position", "Status")
    current, temperature, position, status = (
        follower.bus.sync_read(name, ["gripper"], normalize=name == "Present_Position")["gripper"] for name in names)
    # LeRobot leaves the sign of the current in bit 15.
    ampere = (current & 0x7FFF) * AMPERE_PER_COUNT
    print(f"{what}: {ampere:.2f} A, {temperature} deg C, position {position:.0f}, status {status:#04x}")
    return ampere, temperature, position, status


def grip(follower, arm):
    """Closes the gripper on an object of half its width, for 20 s."""
    follower.send_action({"gripper.pos": 90.0})
    time.sleep(1.5)
    follower.send_action({"gripper.pos": 10.0})
    while follower.bus.read("Present_Position", "gripper") > 50:
        pass
    arm.fault("6 jam")
    for second in range(1, 21):
        time.sleep(1)
        ampere, temperature, _, status = gripper(follower, f"grip for {second} s")
    assert status & OVERLOAD and ampere < 1.0 and temperature < 70, (status, ampere, temperature)


def recover(follower, arm):
    """An overload is raised by LeRobot; the next goal ends it."""
    try:
        follower.bus.disable_torque("gripper")
        raise AssertionError("no overload")
    except RuntimeError as error:
        print("torque off in an overload raises:", error)
    arm.fault("6 free")
    follower.send_action({"gripper.pos": 90.0})
    time.sleep(1.5)
    _, _, position, status = gripper(follower, "after the next goal")
    assert status == 0 and abs(position - 90) < 3


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--plot", type=pathlib.Path)
    options = parser.parse_args()
    folder = pathlib.Path(tempfile.mkdtemp())
    arms = [Arm(options.program, folder, name) for name in ("follower", "leader")]
    follower = SO101Follower(SO101FollowerConfig(port=arms[0].path, id="f", calibration_dir=folder, cameras={}))
    leader = SO101Leader(SO101LeaderConfig(port=arms[1].path, id="l", calibration_dir=folder))
    try:
        for device, arm in zip((follower, leader), arms):
            set_up(device, arm)
            calibrate(device, arm)
        rows = teleoperate(leader, follower, arms[1], options.seconds)
        errors = [abs(present[key] - value) for _, action, present in rows[60:] for key, value in action.items()]
        print(f"{options.seconds:.0f} s of teleoperation at {len(rows) / options.seconds:.2f} Hz, "
              f"mean deviation {sum(errors) / len(errors):.1f}, greatest {max(errors):.1f}")
        if options.plot:
            plot(options.plot, rows)
        grip(follower, arms[0])
        recover(follower, arms[0])
        leader.disconnect()
        follower.disconnect()
    finally:
        for arm in arms:
            arm.process.kill()


if __name__ == "__main__":
    main()
