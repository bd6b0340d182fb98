#!/usr/bin/env python3
"""Searches for motion that was not commanded: enables the drive in every mode from random angles with old targets, switches modes
in motion, commands beyond the limits, floods the bus, and writes targets to a drive that is not enabled. The frames are written
from the standards; the angle is read as object 6064h.

    commanded_motion.py target/debug/actuator
    commanded_motion.py target/debug/actuator --elf ACTUATOR_BOARD COMM_BOARD
"""
import random
import struct
import sys
import threading
import time
import unittest

from wire import Bench, Wire, boards

PROGRAM, ELF = sys.argv.pop(1), boards(sys.argv)

MODES = {
    "profile position": 1,
    "profile velocity": 3,
    "profile torque": 4,
    "interpolated position": 7,
    "cyclic position": 8,
    "cyclic velocity": 9,
    "cyclic torque": 10,
}
SHUTDOWN, SWITCH_ON, ENABLE, NEW_SETPOINT, FAULT_RESET = 0x06, 0x07, 0x0F, 0x10, 0x80
# 6071h, 0.1 %: more than friction holds.
TORQUE = 200

# A shaft at rest hunts within a count of the encoder, 0.088 deg, on either side of an angle.
REST_MDEG = 3 * 88
# Default of 607Dh.
LIMIT_MDEG = 60_000
# Beyond a limit: 1 deg is the overshoot of a step of the position loop (report, step responses).
OVERSHOOT_MDEG = 1_000
# How long a shaft that shall not move is observed, s.
OBSERVED_S = 0.3


def is_of_node(identifier):
    """Whether node 1 sends frames with this identifier, or is commanded by them: NMT, SYNC, TIME, its EMCY, PDOs, SDO and
    heartbeat, LSS."""
    return identifier in (0x000, 0x080, 0x100, 0x7E4, 0x7E5) or identifier & 0x7F == 1


def position(word, target):
    """RPDO 3 by default: controlword and target position, mdeg."""
    return 0x401, struct.pack("<Hi", word, target)


def mode_of_operation(word, mode):
    """RPDO 2 by default: controlword and mode of operation."""
    return 0x301, struct.pack("<Hb", word, mode)


def velocity(word, target):
    """RPDO 4 by default: controlword and target velocity, mdeg/s."""
    return 0x501, struct.pack("<Hi", word, target)


class Motion(Bench):
    program, elf = PROGRAM, ELF

    def setUp(self):
        self.random = random.Random(self.id())
        self.wire.send(0, [1, self.node])

    def tearDown(self):
        # Each queued change of the controlword acts in a control period of its own.
        time.sleep(0.05)
        self.write(0x6040, 0, "<H", SHUTDOWN)

    def write(self, index, sub, layout, value):
        self.sdo.download(index, sub, struct.pack(layout, value))

    def angle(self):
        return struct.unpack("<i", self.sdo.upload(0x6064, 0))[0]

    def status(self):
        return struct.unpack("<H", self.sdo.upload(0x6041, 0))[0]

    def is_enabled(self):
        return self.status() & 0x6F == 0x27

    def wait(self, condition, message, seconds=10):
        end = time.monotonic() + seconds
        while not condition():
            self.assertLess(time.monotonic(), end, message)

    def reset_fault(self):
        if self.status() & 0x08:
            self.write(0x6040, 0, "<H", 0)
            self.write(0x6040, 0, "<H", FAULT_RESET)
            self.wait(lambda: not self.status() & 0x08, "fault reset")

    def enable(self, mode):
        self.reset_fault()

        def is_selected():
            # Again, if a PDO with a mode was still under way.
            self.write(0x6060, 0, "<b", mode)
            return self.sdo.upload(0x6061, 0)[0] == mode

        self.wait(is_selected, f"mode {mode}")
        for word, state in ((SHUTDOWN, 0x21), (SWITCH_ON, 0x23), (ENABLE, 0x27)):
            self.write(0x6040, 0, "<H", word)
            self.wait(lambda: self.status() & 0x6F == state, f"state {state:02X}h")

    def disable(self):
        self.write(0x6040, 0, "<H", SHUTDOWN)
        self.wait(lambda: not self.is_enabled(), "the drive is disabled")

    def sample_time(self):
        """Time of the board's last sample, us; an emulated board lags on a loaded machine."""
        return struct.unpack("<I", self.sdo.upload(0x2007, 2))[0]

    def is_at_rest(self):
        """Whether every angle within 0.2 s is within a count.

        Two angles are equal on either side of an overshoot too.
        """
        before, begun = self.angle(), self.sample_time()
        while (self.sample_time() - begun) % 2**32 < 200_000:
            if abs(self.angle() - before) > 88:
                return False
        return True

    def move(self, target):
        """To this angle by a profile; the drive remains enabled."""
        self.enable(MODES["profile position"])
        self.write(0x607A, 0, "<i", target)
        self.write(0x6040, 0, "<H", ENABLE | NEW_SETPOINT)
        self.wait(lambda: self.status() & 0x1000, "acknowledge")
        self.write(0x6040, 0, "<H", ENABLE)
        self.wait(lambda: self.status() & 0x0400, "target reached")
        self.wait(self.is_at_rest, "rest")

    def place(self, target):
        """To this angle, then disabled and at rest."""
        self.move(target)
        self.disable()
        self.wait(self.is_at_rest, "rest")

    def stays(self, seconds=OBSERVED_S):
        """The greatest distance from the present angle within this time."""
        start, greatest, end = self.angle(), 0, time.monotonic() + seconds
        while time.monotonic() < end:
            greatest = max(greatest, abs(self.angle() - start))
        return greatest

    def command(self, mode, sign):
        """The first target of a mode in this direction: the last admissible position, or a velocity or torque that passes it."""
        if mode in (4, 10):
            self.write(0x6071, 0, "<h", sign * TORQUE)
        elif mode in (3, 9):
            self.write(0x60FF, 0, "<i", sign * 200_000)
        else:
            # The entries have the range of 607Dh: the last admissible target.
            index, sub = (0x60C1, 1) if mode == 7 else (0x607A, 0)
            self.write(index, sub, "<i", sign * LIMIT_MDEG)
            # Bit 4 begins the interpolation too, and has no meaning in the cyclic mode.
            self.write(0x6040, 0, "<H", ENABLE | NEW_SETPOINT)

    def repeat(self, mode, sign):
        """The next target of a mode that needs one in each cycle."""
        if mode == 7:
            self.write(0x60C1, 1, "<i", sign * LIMIT_MDEG)
        elif mode == 8:
            self.wire.send(*position(ENABLE, sign * 90_000))
        elif mode == 9:
            self.wire.send(*velocity(ENABLE, sign * 200_000))
        elif mode == 10:
            self.write(0x6071, 0, "<h", sign * TORQUE)

    def test_enabling_in_every_mode_from_any_angle_with_old_targets_moves_nothing(self):
        for name, mode in MODES.items():
            for _ in range(2):
                self.place(self.random.randint(-55_000, 55_000))
                self.write(0x607A, 0, "<i", self.random.randint(-55_000, 55_000))
                self.write(0x60FF, 0, "<i", self.random.choice((-1, 1)) * self.random.randint(20_000, 100_000))
                self.write(0x6071, 0, "<h", self.random.choice((-1, 1)) * TORQUE)
                self.write(0x60C1, 1, "<i", self.random.randint(-55_000, 55_000))
                before = self.angle()
                with self.subTest(name, angle_mdeg=before):
                    self.enable(mode)
                    self.assertLessEqual(self.stays(), REST_MDEG)
                    self.assertLessEqual(abs(self.angle() - before), REST_MDEG)

    def test_a_change_of_mode_in_motion_brings_the_shaft_to_rest_where_it_is(self):
        for name in (name for name in MODES if name != "profile velocity"):
            for rate in (-40_000, 40_000):
                self.place(0)
                self.enable(MODES["profile velocity"])
                self.write(0x6071, 0, "<h", TORQUE if rate > 0 else -TORQUE)
                self.write(0x60FF, 0, "<i", rate)
                self.wait(lambda: abs(self.angle()) > 5_000, "motion")
                with self.subTest(name, rate=rate):
                    start = self.angle()
                    self.write(0x6060, 0, "<b", MODES[name])
                    self.wait(self.is_at_rest, "rest")
                    travel = (self.angle() - start) * (1 if rate > 0 else -1)
                    # 40 deg/s for the 100 ms of the command timeout, and the same again for the
                    # time of the transfer and of the deceleration.
                    self.assertGreater(travel, -REST_MDEG)
                    self.assertLess(travel, 8_000)
                    self.assertLessEqual(self.stays(), REST_MDEG)

    def test_no_command_moves_the_shaft_beyond_its_limits(self):
        for name, mode in MODES.items():
            for sign in (-1, 1):
                self.place(sign * 40_000)
                self.enable(mode)
                with self.subTest(name, sign=sign):
                    greatest, end = 0, time.monotonic() + 0.8
                    self.command(mode, sign)
                    while time.monotonic() < end:
                        self.repeat(mode, sign)
                        greatest = max(greatest, sign * self.angle())
                    self.assertGreater(greatest, 45_000, "it moves")
                    self.assertLess(greatest, LIMIT_MDEG + OVERSHOOT_MDEG)

    def test_a_flooded_bus_moves_nothing(self):
        self.move(self.random.randint(-50_000, 50_000))
        flooding = Wire(self.port) if not ELF else self.wire
        running = threading.Event()
        running.set()
        source = random.Random("flood")

        def frame():
            identifier, data = source.randrange(0x800), source.randbytes(source.randrange(9))
            if identifier in (0x201, 0x301, 0x401, 0x501):
                # Shorter than its mapping: an error, and no command.
                flooding.send(identifier, data[:1])
            elif not is_of_node(identifier):
                flooding.send(identifier, data)

        def flood():
            while running.is_set():
                frame()

        thread = threading.Thread(target=flood, daemon=True)
        if not ELF:
            thread.start()
        try:
            start, greatest, end = self.angle(), 0, time.monotonic() + 2
            while time.monotonic() < end:
                if ELF:
                    # The serial line has one client.
                    for _ in range(20):
                        frame()
                greatest = max(greatest, abs(self.angle() - start))
        finally:
            running.clear()
            if not ELF:
                thread.join()
                flooding.close()
        self.assertLessEqual(greatest, REST_MDEG)
        self.assertTrue(self.is_enabled())

    def test_commands_to_a_drive_that_is_not_enabled_move_nothing(self):
        self.place(self.random.randint(-50_000, 50_000))
        start = self.angle()
        for _ in range(200):
            word = self.random.choice((0, SHUTDOWN, SWITCH_ON, NEW_SETPOINT, NEW_SETPOINT | SWITCH_ON))
            self.write(0x6071, 0, "<h", self.random.randint(-TORQUE, TORQUE))
            self.write(0x6060, 0, "<b", self.random.choice(list(MODES.values())))
            target, mode = self.random.randint(-60_000, 60_000), self.random.choice(list(MODES.values()))
            self.wire.send(*self.random.choice((position(word, target), mode_of_operation(word, mode), velocity(word, target))))
            self.assertLessEqual(abs(self.angle() - start), REST_MDEG)


if __name__ == "__main__":
    unittest.main()
