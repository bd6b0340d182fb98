#!/usr/bin/env python3
"""A drive as the Cia402 driver of ros2_canopen operates it, by python-canopen: cycles of 60 ms with a SYNC every 10 ms; init with
a fault reset from 0, changes of mode with HALT set, recover, halt, shutdown.

    ros2.py target/debug/actuator docs/smart-actuator.eds
    ros2.py target/debug/actuator docs/smart-actuator.eds --elf ACTUATOR_BOARD COMM_BOARD
"""
import sys
import time
import unittest

import canopen

from served import Bench
from wire import boards

PROGRAM, SHEET, ELF = sys.argv.pop(1), sys.argv.pop(1), boards(sys.argv)

SYNC_S, SYNCS_OF_A_CYCLE = 0.01, 6
HALT, FAULT_RESET, START_HOMING = 1 << 8, 1 << 7, 1 << 4
NO_MODE, HOMING, CYCLIC_POSITION = 0, 6, 8
# State: mask and value of the statusword, and the command that leads to "operation enabled".
STATES = {
    "fault": (0x4F, 0x08, FAULT_RESET), "switch on disabled": (0x4F, 0x40, 0x06), "ready to switch on": (0x6F, 0x21, 0x07),
    "switched on": (0x6F, 0x23, 0x0F), "operation enabled": (0x6F, 0x27, 0x0F), "fault reaction active": (0x4F, 0x0F, 0x00),
    "quick stop active": (0x6F, 0x07, 0x00)}


class Driver(Bench):
    node_id = 1
    bitrate = 1_000_000
    timeout = 8 if ELF else 2

    def command(self):
        return [PROGRAM, "serve", "--listen", "127.0.0.1:0", *ELF]

    @staticmethod
    def master():
        return canopen.RemoteNode(1, SHEET)

    def setUp(self):
        super().setUp()
        node = self.node
        node.tpdo.read()
        node.rpdo.read()
        mappings = (node.tpdo[1], ("Statusword", "Modes of operation display")), (node.tpdo[2], ("Position actual value",)), \
            (node.rpdo[1], ("Controlword",)), (node.rpdo[2], ("Target position",))
        for pdo, names in mappings:
            pdo.clear()
            for name in names:
                pdo.add_variable(name)
            pdo.trans_type, pdo.event_timer, pdo.enabled = 1, 0, True
            pdo.save()
        # Of its defaults only those that are mapped above.
        node.tpdo[3].enabled = False
        node.tpdo[3].save()
        self.word, self.target, self.replies = 0, None, 0
        node.tpdo[2].add_callback(self.count)
        node.nmt.state = "OPERATIONAL"
        # While the serial line is closed no node acknowledges the boot-up of a board, which reports
        # this.
        self.wait_for(lambda: self.state_after_sync() and not node.emcy.active, "no bus error")
        node.emcy.reset()

    def count(self, _):
        self.replies += 1

    def sync(self):
        """A SYNC every 10 ms; less often if the emulation is slower than real time."""
        end, before = time.monotonic() + SYNC_S, self.replies
        self.network.sync.transmit()
        while self.replies == before and time.monotonic() < end + 1:
            time.sleep(0.001)
        time.sleep(max(0, end - time.monotonic()))

    def state_after_sync(self):
        self.sync()
        return self.state()

    def cycle(self):
        """The driver's cycle: HALT is set unless the mode has a target, or homing is started."""
        acts = self.target is not None or self.word & START_HOMING
        runs = self.state() == "operation enabled" and acts
        if runs and self.target is not None:
            self.node.rpdo[2]["Target position"].raw = self.target
            self.node.rpdo[2].transmit()
        self.node.rpdo[1]["Controlword"].raw = self.word if runs else self.word | HALT
        self.node.rpdo[1].transmit()
        for _ in range(SYNCS_OF_A_CYCLE):
            self.sync()

    def state(self):
        word = self.node.tpdo[1]["Statusword"].raw
        return next((name for name, (mask, value, _) in STATES.items() if word & mask == value), None)

    def enable(self):
        """init and recover: a fault is reset by an edge from 0."""
        self.word = 0
        self.cycle()
        end = time.monotonic() + self.timeout
        while self.state() != "operation enabled":
            self.assertLess(time.monotonic(), end, self.state())
            self.word = STATES[self.state()][2] if self.state() else 0
            self.cycle()

    def switch_mode(self, mode):
        self.target = None
        self.cycle()
        self.node.sdo["Modes of operation"].raw = mode
        end = time.monotonic() + self.timeout
        while self.node.tpdo[1]["Modes of operation display"].raw != mode:
            self.assertLess(time.monotonic(), end)
            self.sync()

    def follow(self, target_mdeg):
        """Targets at 20 deg/s until the shaft is there."""
        start = at = self.angle()
        cycles = 0
        while abs(self.angle() - target_mdeg) > 300:
            self.target = at = at + max(-1200, min(1200, target_mdeg - at))
            self.cycle()
            low, high = sorted((start, target_mdeg))
            self.assertTrue(low - 1_000 < self.angle() < high + 1_000, self.angle())
            cycles += 1
            self.assertLess(cycles, 100)

    def angle(self):
        return self.node.tpdo[2]["Position actual value"].raw

    def test_the_cia402_driver_of_ros2_canopen_inits_moves_recovers_halts_and_shuts_down(self):
        self.enable()
        if self.node.sdo["Supported drive modes"].raw >> (HOMING - 1) & 1:
            self.switch_mode(HOMING)
            self.word |= START_HOMING
            end = time.monotonic() + self.timeout
            while self.node.tpdo[1]["Statusword"].raw & 0x3400 != 0x1400:
                self.assertLess(time.monotonic(), end, "homing attained")
                self.cycle()
            self.word &= ~START_HOMING
        self.switch_mode(CYCLIC_POSITION)
        # Long without a target: no fault of missing commands.
        for _ in range(5):
            self.cycle()
        self.assertEqual(self.state(), "operation enabled")
        self.follow(20_000)
        # A pause of the controller.
        self.wait_for(lambda: self.state_after_sync() == "fault", "missing commands")
        self.target = None
        self.enable()
        self.assertLess(abs(self.angle() - 20_000), 500, "it stays")
        self.follow(-10_000)
        self.target = None
        for _ in range(5):
            self.cycle()
        self.assertEqual(self.state(), "operation enabled", "halted")
        self.switch_mode(NO_MODE)
        self.word = 0
        self.cycle()
        self.wait_for(lambda: self.state_after_sync() == "switch on disabled", "shutdown")
        self.assertEqual([error.code for error in self.node.emcy.log], [0x8130, 0])


if __name__ == "__main__":
    unittest.main()
