#!/usr/bin/env python3
"""The makers' libraries and rustypot, unmodified, as clients of `actuator serve --protocol --pty`.

    clients.py target/debug/actuator
    clients.py target/debug/actuator --elf ACTUATOR_BOARD

With the ELF of the actuator board the servos are two emulated boards.
"""
import math
import os
import statistics
import subprocess
import sys
import tempfile
import time
import unittest

import dynamixel_sdk as dxl
import rustypot
import scservo_sdk as scs

PROGRAM = os.path.abspath(sys.argv.pop(1))
ELF = sys.argv[2] if sys.argv[1:2] == ["--elf"] else None
del sys.argv[1 : 3 if ELF else 1]
IDS = [1, 2] if ELF else [1, 2, 3, 4, 5, 6]
LAST = IDS[-1]
# Within the position limits 607Dh of the board, 60 deg on either side.
LOW, HIGH = 1500, 2600
# 0.1 V.
SUPPLY = 60 if ELF else 74
if ELF:
    # ms of an adapter: an emulator pauses where it translates a part of the program first.
    scs.port_handler.LATENCY_TIMER = dxl.port_handler.LATENCY_TIMER = 500
# s; the pause lets an answer pass that a library does not read.
TIMEOUT, PAUSE = (1.0, 0.5) if ELF else (0.2, 0.02)


class Bench(unittest.TestCase):
    """A server for each test, and the path of its terminal."""

    model = None

    def setUp(self):
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        self.path = os.path.join(directory.name, "servos")
        command = [PROGRAM, "serve", "--protocol", self.model, "--nodes", str(LAST), "--pty"]
        command += ["--link", self.path, "--servo-faults", "-", *(["--elf", ELF] if ELF else [])]
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.process, self.faults = process, process.stdin
        self.addCleanup(process.stdin.close)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        line = process.stdout.readline()
        self.assertIn(f"{LAST} servos with IDs 1 to {LAST} of the model {self.model}", line)
        self.assertIn(os.readlink(self.path), line)

    def wait_for(self, condition, message, seconds=5):
        # The time of an emulator may be behind.
        end = time.monotonic() + seconds * (4 if ELF else 1)
        while not condition():
            self.assertLess(time.monotonic(), end, message)
            time.sleep(0.005)

    def fault(self, line):
        self.faults.write(line + "\n")
        self.faults.flush()
        time.sleep(0.1)

    def is_done(self, outcome):
        """The values of an outcome that ends with result and error, both 0."""
        *values, result, error = outcome
        self.assertEqual((result, error), (0, 0))
        return values[0] if len(values) == 1 else values


class Feetech(Bench):
    """feetech-servo-sdk."""

    model = "sts3215"

    def setUp(self):
        super().setUp()
        self.port, self.bus = scs.PortHandler(self.path), scs.PacketHandler(0)
        self.assertTrue(self.port.openPort() and self.port.setBaudRate(1_000_000))
        self.addCleanup(self.port.closePort)

    def read(self, servo, address, size):
        return self.is_done(getattr(self.bus, f"read{size}ByteTxRx")(self.port, servo, address))

    def write(self, servo, address, size, value):
        self.is_done(getattr(self.bus, f"write{size}ByteTxRx")(self.port, servo, address, value))

    def test_ping_returns_the_model_and_an_absent_servo_does_not_answer(self):
        for servo in IDS:
            self.assertEqual(self.is_done(self.bus.ping(self.port, servo)), 777)
        self.assertEqual(self.bus.ping(self.port, 7)[1], scs.COMM_RX_TIMEOUT)

    def test_values_of_one_two_and_four_bytes_are_read_and_written(self):
        self.assertEqual([self.read(1, 21, 1), self.read(1, 11, 2), self.read(1, 9, 4)], [32, 4095, 4095 << 16])
        self.write(1, 21, 1, 16)
        self.write(1, 9, 4, 3000 << 16 | 1000)
        self.assertEqual([self.read(1, 21, 1), self.read(1, 9, 2), self.read(1, 11, 2)], [16, 1000, 3000])
        # Without answers to writes, which this function would leave unread.
        self.write(2, 8, 1, 0)
        self.assertEqual(self.bus.write1ByteTxOnly(self.port, 2, 21, 20), scs.COMM_SUCCESS)
        time.sleep(PAUSE)
        self.assertEqual(self.read(2, 21, 1), 20)
        self.assertEqual(self.is_done(self.bus.readTxRx(self.port, 1, 0, 5)), [3, 10, 0, 9, 3])

    def test_a_registered_write_waits_for_the_action(self):
        for servo in IDS:
            self.is_done(self.bus.regWriteTxRx(self.port, servo, 42, 2, list(LOW.to_bytes(2, "little"))))
        time.sleep(PAUSE)
        self.assertEqual([self.read(1, 64, 1), self.read(1, 40, 1)], [1, 0])
        self.bus.action(self.port, scs.BROADCAST_ID)
        for servo in IDS:
            self.wait_for(lambda: abs(self.read(servo, 56, 2) - LOW) < 40, f"servo {servo}")

    def test_all_servos_follow_synchronous_writes_with_the_dynamics_of_a_motor(self):
        reader = scs.GroupSyncRead(self.port, self.bus, 56, 8)
        writer = scs.GroupSyncWrite(self.port, self.bus, 42, 2)
        for servo in IDS:
            self.assertTrue(reader.addParam(servo) and writer.addParam(servo, [HIGH & 0xFF, HIGH >> 8]))
        self.assertEqual(writer.txPacket(), scs.COMM_SUCCESS)
        track = []

        def are_at_rest():
            self.assertEqual(reader.txRxPacket(), scs.COMM_SUCCESS)
            track.append([reader.getData(servo, 56, 2) for servo in IDS])
            self.assertTrue(all(reader.isAvailable(servo, 62, 1) for servo in IDS))
            return len(track) > 20 and all(abs(a - HIGH) < 40 for row in track[-20:] for a in row)

        self.wait_for(are_at_rest, "all servos at their goals", 10)
        for positions in zip(*track):
            self.assertLess(abs(positions[-1] - HIGH), 40)
            # 3400 steps/s at most: not a jump.
            between = [position for position in positions if 2100 < position < HIGH - 50]
            self.assertGreater(len(between), 5)
            # Nor is it one where an emulator makes up for a pause.
            self.assertLess(max(b - a for a, b in zip(positions, positions[1:])), 500 if ELF else 400)
        self.assertAlmostEqual(reader.getData(1, 62, 1), SUPPLY, delta=1)

    def test_an_id_that_is_stored_answers_and_the_old_one_does_not(self):
        self.write(LAST, 55, 1, 0)
        self.bus.write1ByteTxOnly(self.port, LAST, 5, 17)
        time.sleep(PAUSE)
        self.assertEqual(self.is_done(self.bus.ping(self.port, 17)), 777)
        self.assertEqual(self.bus.ping(self.port, LAST)[1], scs.COMM_RX_TIMEOUT)

    def test_an_overload_is_read_cleared_and_recovered(self):
        self.write(1, 34, 2, 20 | 20 << 8)
        self.fault("1 jam")
        self.write(1, 42, 2, HIGH if ELF else 4000)
        self.wait_for(lambda: self.bus.ping(self.port, 1)[2] == 32, "an overload")
        # The answer to the write still has the status; the torque is off all the same.
        self.assertEqual(self.bus.write1ByteTxRx(self.port, 1, 40, 0), (scs.COMM_SUCCESS, 32))
        self.fault("1 free")
        self.wait_for(lambda: self.bus.ping(self.port, 1)[2] == 0, "an acknowledgement")
        self.assertEqual([self.read(1, 40, 1), self.read(1, 65, 1)], [0, 0])
        self.write(1, 42, 2, 2048)
        self.wait_for(lambda: abs(self.read(1, 56, 2) - 2048) < 40, "the goal")

    def test_the_link_ends_with_the_server(self):
        self.process.terminate()
        self.process.wait(5)
        self.assertFalse(os.path.lexists(self.path))

    @unittest.skipIf(ELF, "faults of the simulated servos")
    def test_servos_vanish_and_answers_are_damaged(self):
        self.fault("3 vanish")
        self.assertEqual(self.bus.ping(self.port, 3)[1], scs.COMM_RX_TIMEOUT)
        self.fault("3 return")
        self.fault("3 corrupt 1")
        self.assertEqual(self.bus.ping(self.port, 3)[1], scs.COMM_RX_CORRUPT)
        self.assertEqual(self.is_done(self.bus.ping(self.port, 3)), 777)


class Dynamixel(Bench):
    """dynamixel-sdk."""

    model = "xl330-m288" if ELF else "xm430-w350"
    # Model number, firmware, gain of the position.
    number, firmware, gain = (1200, 46, 400) if ELF else (1020, 45, 800)

    def setUp(self):
        super().setUp()
        self.port, self.bus = dxl.PortHandler(self.path), dxl.PacketHandler(2.0)
        self.assertTrue(self.port.openPort() and self.port.setBaudRate(1_000_000))
        self.addCleanup(self.port.closePort)

    def read(self, servo, address, size):
        return self.is_done(getattr(self.bus, f"read{size}ByteTxRx")(self.port, servo, address))

    def write(self, servo, address, size, value):
        return getattr(self.bus, f"write{size}ByteTxRx")(self.port, servo, address, value)

    def test_ping_and_broadcast_ping_find_all(self):
        self.assertEqual(self.is_done(self.bus.ping(self.port, LAST)), self.number)
        found, result = self.bus.broadcastPing(self.port)
        self.assertEqual((found, result), ({servo: [self.number, self.firmware] for servo in IDS}, dxl.COMM_SUCCESS))
        self.assertEqual(self.bus.ping(self.port, 9)[1], dxl.COMM_RX_TIMEOUT)

    def test_values_are_read_and_written_and_refusals_have_their_errors(self):
        self.assertEqual([self.read(1, 84, 2), self.read(1, 48, 4), self.read(1, 11, 1)], [self.gain, 4095, 3])
        self.assertEqual(self.write(1, 84, 2, 640), (0, 0))
        self.assertEqual(self.read(1, 84, 2), 640)
        self.assertEqual(self.write(1, 132, 4, 0), (0, dxl.ERRNUM_ACCESS))
        self.assertEqual(self.write(1, 116, 4, 4096), (0, dxl.ERRNUM_DATA_LIMIT))
        self.assertEqual(self.write(1, 116, 2, 1), (0, dxl.ERRNUM_DATA_LENGTH))
        self.assertEqual(self.write(1, 64, 1, 1), (0, 0))
        self.assertEqual(self.write(1, 11, 1, 1), (0, dxl.ERRNUM_ACCESS))

    def test_a_registered_write_waits_for_the_action(self):
        self.assertEqual(self.bus.regWriteTxRx(self.port, 1, 65, 1, [1]), (0, 0))
        self.assertEqual([self.read(1, 65, 1), self.read(1, 69, 1)], [0, 1])
        self.bus.action(self.port, 1)
        time.sleep(PAUSE)
        self.assertEqual([self.read(1, 65, 1), self.read(1, 69, 1)], [1, 0])

    def enable(self):
        for servo in IDS:
            self.assertEqual(self.write(servo, 64, 1, 1), (0, 0))

    def test_synchronous_writes_move_all_and_fast_reads_agree_with_others(self):
        self.enable()
        writer = dxl.GroupSyncWrite(self.port, self.bus, 116, 4)
        reader = dxl.GroupSyncRead(self.port, self.bus, 132, 4)
        for servo in IDS:
            goal = 2048 + 100 * servo
            self.assertTrue(writer.addParam(servo, list(goal.to_bytes(4, "little"))))
            self.assertTrue(reader.addParam(servo))
        self.assertEqual(writer.txPacket(), dxl.COMM_SUCCESS)

        def positions(read):
            self.assertEqual(read(), dxl.COMM_SUCCESS)
            return [reader.getData(servo, 132, 4) for servo in IDS]

        def are_there():
            return all(abs(p - 2048 - 100 * s) < 20 for s, p in zip(IDS, positions(reader.txRxPacket)))

        self.wait_for(are_there, "all servos at their goals")
        time.sleep(2 if ELF else 0.5)
        # The encoder of a board has noise of a count.
        for slow, fast in zip(positions(reader.txRxPacket), positions(reader.fastSyncRead)):
            self.assertAlmostEqual(slow, fast, delta=2 if ELF else 0)

    def test_bulk_writes_and_reads_take_other_registers_of_each(self):
        writer, reader = dxl.GroupBulkWrite(self.port, self.bus), dxl.GroupBulkRead(self.port, self.bus)
        self.assertTrue(writer.addParam(1, 84, 2, [100, 0]) and writer.addParam(2, 65, 1, [1]))
        self.assertEqual(writer.txPacket(), dxl.COMM_SUCCESS)
        self.assertTrue(reader.addParam(1, 84, 2) and reader.addParam(2, 65, 1))
        for read in reader.txRxPacket, reader.fastBulkRead:
            self.assertEqual(read(), dxl.COMM_SUCCESS)
            self.assertEqual([reader.getData(1, 84, 2), reader.getData(2, 65, 1)], [100, 1])

    def test_reboot_clear_and_factory_reset(self):
        self.assertEqual(self.write(1, 84, 2, 640), (0, 0))
        self.assertEqual(self.bus.reboot(self.port, 1), (0, 0))
        self.assertEqual(self.read(1, 84, 2), self.gain)
        self.assertEqual(self.bus.clearMultiTurn(self.port, 1), (0, 0))
        self.assertEqual(self.write(LAST, 20, 4, 77), (0, 0))
        self.assertEqual(self.bus.factoryReset(self.port, LAST, 0x02), (0, 0))
        self.assertEqual([self.read(LAST, 20, 4), self.read(LAST, 7, 1)], [0, LAST])


class Rustypot(Bench):
    """rustypot's controller of the STS3215."""

    model = "sts3215"

    def setUp(self):
        super().setUp()
        self.servos = rustypot.Sts3215PyController(self.path, 1_000_000, TIMEOUT)
        self.addCleanup(self.servos.close)

    def test_all_servos_are_found(self):
        self.assertTrue(self.servos.ping(1))
        if not ELF:
            # It waits for 10 ms, for which an emulator may pause.
            self.assertEqual(self.servos.scan(IDS + [9]), {servo: 777 for servo in IDS})
        self.assertEqual(self.servos.broadcast_scan(), {servo: 777 for servo in IDS})

    def test_positions_in_radians_are_reached_alone_and_together(self):
        self.servos.write_goal_position(1, 0.5)
        self.servos.sync_write_goal_position(IDS[1:], [-0.3] * len(IDS[1:]))
        goals = [0.5] + [-0.3] * len(IDS[1:])

        def are_there():
            positions = self.servos.sync_read_present_position(IDS)
            return all(math.isclose(p, goal, abs_tol=0.05) for p, goal in zip(positions, goals))

        self.wait_for(are_there, "all servos at their goals")
        self.assertAlmostEqual(self.servos.read_present_position(1)[0], 0.5, delta=0.05)

    def test_every_register_is_read(self):
        for register in self.servos.registers():
            self.servos.read_register(1, register.name)
            self.assertEqual(len(self.servos.sync_read_register(IDS, register.name)), LAST)

    def test_restart_and_recovery(self):
        self.servos.write_register(2, "p_coefficient", 50)
        self.servos.reboot(2)
        self.assertEqual(self.servos.read_register(2, "p_coefficient"), 32)
        self.assertTrue(self.servos.ping(2))


class RustypotX(Bench):
    """rustypot's controller of the XL330, and its bus."""

    model = "xl330-m288"

    def setUp(self):
        super().setUp()
        self.servos = rustypot.Xl330PyController(self.path, 1_000_000, TIMEOUT)
        self.addCleanup(self.servos.close)

    def test_all_servos_are_found_and_every_register_is_read(self):
        self.assertEqual(self.servos.broadcast_scan(), {servo: 1200 for servo in IDS})
        for fast in False, True:
            self.servos.set_fast_sync_read(fast)
            for register in self.servos.registers():
                self.assertEqual(len(self.servos.sync_read_register(IDS, register.name)), LAST, register.name)

    def test_the_current_of_a_grip_is_limited(self):
        self.servos.write_operating_mode(1, 5)
        self.servos.write_torque_enable(1, True)
        self.servos.write_goal_current(1, 60)
        self.servos.write_goal_position(1, 1.0)
        accelerating = []

        def is_half_way():
            accelerating.append(abs(self.servos.read_register(1, "present_current")))
            return self.servos.read_present_position(1)[0] > 0.5

        self.wait_for(is_half_way, "half of the way")
        if ELF:
            # A board limits the mean, which is 390 without the limit: a sample has noise, and the
            # flanks of its gears meet.
            accelerating = [statistics.fmean(accelerating)]
        self.assertLessEqual(max(accelerating), 66 if ELF else 61)
        self.wait_for(lambda: abs(self.servos.read_present_position(1)[0] - 1.0) < 0.1, "the goal")


if __name__ == "__main__":
    unittest.main()
