#!/usr/bin/env python3
"""LeRobot's SO-101 leader and follower on simulated servos: `lerobot_arms.py target/release/actuator`.

Needs LeRobot, which is too large for CI: `pip install 'lerobot[feetech]==0.4.4'`. Loads on the shafts
stand for the hands that move an arm.
"""
import builtins
import math
import pathlib
import subprocess
import sys
import tempfile
import threading
import time

import lerobot.motors.motors_bus as motors_bus
from lerobot.robots.so_follower import SO101Follower, SO101FollowerConfig
from lerobot.teleoperators.so_leader import SO101Leader, SO101LeaderConfig

PROGRAM, SECONDS = sys.argv[1], float(sys.argv[2]) if len(sys.argv) > 2 else 60.0
FOLDER = pathlib.Path(tempfile.mkdtemp())


class Arm:
    """Six servos on a terminal, and what happens to them."""

    def __init__(self, name):
        self.path = str(FOLDER / name)
        command = [PROGRAM, "serve", "--protocol", "sts3215", "--nodes", "6", "--pty", "--link", self.path]
        self.process = subprocess.Popen(
            command + ["--servo-faults", "-"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        print(self.process.stdout.readline().strip())

    def fault(self, *lines):
        self.process.stdin.write("".join(line + "\n" for line in lines))
        self.process.stdin.flush()

    def push(self, torque_nm, seconds=0.0):
        self.fault(*(f"{servo} load {torque_nm(servo):.3f}" for servo in range(1, 7)))
        time.sleep(seconds)


def calibrate(device, arm):
    """Connects, and moves all joints by hand while LeRobot records their ranges."""
    is_done, hands = threading.Event(), []

    def move():
        for torque in 0.3, -0.3, -0.3, 0.3, 0.0:
            arm.push(lambda _: torque, 0.3)
        is_done.set()

    def entered():
        if not hands:
            hands.append(threading.Thread(target=move))
            hands[0].start()
        return is_done.is_set()

    motors_bus.enter_pressed, builtins.input = entered, lambda *_: ""
    device.connect(calibrate=True)
    assert device.is_calibrated


def teleoperate(leader, follower, arm):
    """Copies the leader's joints at 60 Hz; returns the rate, and the deviation within the range."""
    start, cycles, deviations = time.monotonic(), 0, []
    while (now := time.monotonic() - start) < SECONDS:
        arm.push(lambda servo: 0.14 * math.sin(1.5 * now + servo))
        action = leader.get_action()
        follower.send_action(action)
        present = follower.get_observation()
        inside = [abs(present[key] - value) for key, value in action.items() if abs(value) < 80]
        deviations += inside if cycles > 120 else []
        cycles += 1
        time.sleep(max(0.0, cycles / 60 - (time.monotonic() - start)))
    return cycles / SECONDS, sum(deviations) / max(1, len(deviations))


def overload(follower, arm):
    """A gripper that is jammed: what LeRobot says, and whether it is usable afterwards."""
    arm.fault("6 jam")
    follower.bus.write("Goal_Position", "gripper", 100.0)
    time.sleep(4)
    try:
        follower.bus.disable_torque("gripper")
    except RuntimeError as error:
        print("torque off during an overload raises:", error)
    arm.fault("6 free")
    time.sleep(0.1)
    print("status afterwards:", follower.bus.read("Status", "gripper"))


def main():
    arms = Arm("follower"), Arm("leader")
    follower = SO101Follower(SO101FollowerConfig(port=arms[0].path, id="f", calibration_dir=FOLDER, cameras={}))
    leader = SO101Leader(SO101LeaderConfig(port=arms[1].path, id="l", calibration_dir=FOLDER))
    try:
        calibrate(follower, arms[0])
        calibrate(leader, arms[1])
        rate, deviation = teleoperate(leader, follower, arms[1])
        print(f"{SECONDS:.0f} s of teleoperation at {rate:.2f} Hz, mean deviation {deviation:.1f} of 200")
        overload(follower, arms[0])
        leader.disconnect()
        follower.disconnect()
    finally:
        for arm in arms:
            arm.process.kill()


if __name__ == "__main__":
    main()
