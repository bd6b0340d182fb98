#!/usr/bin/env python3
"""Tests with unmodified python-canopen and the EDS against the actuators of `actuator serve`: native, or both programs on emulated
boards through the serial line of the communication board.

    actuator.py target/debug/actuator docs/smart-actuator.eds
    actuator.py target/debug/actuator docs/smart-actuator.eds --elf ACTUATOR_BOARD COMM_BOARD
"""
import csv
import json
import logging
import signal
import struct
import subprocess
import sys
import time
import unittest
import zlib

import canopen
from canopen.profiles.p402 import BaseNode402

from served import Bench, DriveTests
from wire import boards

PROGRAM, SHEET, ELF = sys.argv.pop(1), sys.argv.pop(1), boards(sys.argv)

# Serial number: 1 for the first native actuator; a board hashes the unique ID of its chip, which is
# 1 on the first emulated board.
SERIAL_NUMBER = zlib.crc32(struct.pack("<III", 1, 0, 0)) if ELF else 1

# A serial line has one client, and a board stores its node-ID.
natively = unittest.skipIf(ELF, "for several clients, or for actuators without node-ID")


class Served(Bench):
    """Two actuators; the node under test is the first."""

    node_id = 1
    options = ()
    # Bit rate of new boards; the native bus has none.
    bitrate = 1_000_000
    # A busy computer may emulate more slowly than real time.
    timeout = 8 if ELF else 2

    def command(self):
        return [PROGRAM, "serve", "--listen", "127.0.0.1:0", "--nodes", "2", *ELF, *self.options]

    @staticmethod
    def master():
        return canopen.RemoteNode(1, SHEET)

    def actuator(self, *arguments):
        """The program `actuator` as a second client."""
        bus = ["--bus", f"127.0.0.1:{self.port}"]
        return subprocess.run([PROGRAM, *arguments, *bus], capture_output=True, text=True, timeout=20)


class Management(Served):
    def test_the_scanner_finds_both(self):
        self.network.scanner.search()
        self.wait_for(lambda: sorted(self.network.scanner.nodes) == [1, 2], "both nodes")

    def test_states_and_heartbeats(self):
        self.node.sdo[0x1017].raw = 20
        for state in ("OPERATIONAL", "STOPPED", "PRE-OPERATIONAL"):
            self.node.nmt.state = state
            # A heartbeat of before may still be on its way.
            self.wait_for(lambda: self.node.nmt.wait_for_heartbeat(1) == state, state)

    @natively
    def test_a_second_client_receives_and_commands(self):
        other = self.connect()
        try:
            node = other.add_node(canopen.RemoteNode(2, SHEET))
            node.sdo["Target position"].raw = 777
            self.assertEqual(node.sdo["Target position"].raw, 777)
            seen = []
            other.subscribe(0x123, lambda *frame: seen.append(frame[1]))
            self.network.send_message(0x123, b"hello")
            self.wait_for(lambda: [bytes(data) for data in seen] == [b"hello"], "the other client's frame")
        finally:
            other.disconnect()

    def test_an_interrupt_ends_the_server_cleanly(self):
        server = subprocess.Popen(self.command(), stdout=subprocess.PIPE, text=True)
        server.stdout.readline()
        server.send_signal(signal.SIGINT)
        rest, _ = server.communicate(timeout=5)
        self.assertEqual((server.returncode, rest), (0, ""))


class Transfers(Served):
    def test_values_by_name(self):
        sdo = self.node.sdo
        self.assertEqual(sdo["Manufacturer device name"].raw, "SMART-ACTUATOR")
        self.assertEqual(sdo["Identity object"]["Serial number"].raw, SERIAL_NUMBER)
        gain = sdo["Position control parameter set"]["Proportional gain"]
        gain.raw = 9.25
        self.assertEqual(gain.raw, 9.25)

    def test_three_transfer_types_in_both_directions(self):
        sdo = self.node.sdo
        value = struct.pack("<i", -123_456)
        sdo.download(0x607A, 0, value, force_segment=True)
        self.assertEqual(sdo.upload(0x607A, 0), value)
        with sdo["Target position"].open("wb", size=4, block_transfer=True) as out:
            out.write(value[::-1])
        with sdo["Target position"].open("rb", block_transfer=True, request_crc_support=True) as back:
            self.assertEqual(back.read(), value[::-1])

    def test_a_capture_is_uploaded_in_segments_and_in_blocks(self):
        sdo = self.node.sdo
        sdo["Capture"]["Control"].raw = 1
        self.wait_for(lambda: sdo["Capture"]["Records captured"].raw > 600, "2.4 s of capture")
        sdo["Capture"]["Control"].raw = 0
        records, size = sdo["Capture"]["Records captured"].raw, sdo["Capture"]["Record size"].raw
        # Seven signals.
        self.assertEqual(size, 28)
        with sdo["Capture data"].open("rb", block_transfer=True, request_crc_support=True) as blocks:
            data = blocks.read()
        self.assertEqual(len(data), records * size)
        self.assertEqual(sdo.upload(0x2032, 0), data)

    def test_abort_codes(self):
        sdo = self.node.sdo
        self.aborts(0x0602_0000, sdo.upload, 0x5000, 0)
        self.aborts(0x0609_0011, sdo.upload, 0x1018, 9)
        self.aborts(0x0601_0002, sdo.download, 0x6041, 0, bytes(2))
        self.aborts(0x0607_0012, sdo.download, 0x6040, 0, bytes(4))
        self.aborts(0x0607_0013, sdo.download, 0x6040, 0, bytes(1))
        self.aborts(0x0609_0030, sdo.download, 0x6060, 0, b"\x05")
        self.aborts(0x0609_0031, sdo.download, 0x2100, 8, struct.pack("<i", 2_801))
        self.aborts(0x0609_0032, sdo.download, 0x2100, 8, struct.pack("<i", 99))
        self.aborts(0x0609_0036, sdo.download, 0x607D, 1, struct.pack("<i", 60_001))
        self.aborts(0x0604_0043, sdo.download, 0x2102, 2, struct.pack("<i", 750))
        self.aborts(0x0800_0022, sdo.download, 0x2020, 1, b"\x01")
        self.aborts(0x0800_0024, sdo.upload, 0x2032, 0)
        self.aborts(0x0800_0020, sdo.download, 0x1010, 1, b"evas")

    def test_parameters_are_stored_across_a_reset(self):
        sdo = self.node.sdo
        sdo["Profile velocity"].raw, sdo[0x1017].raw = 123_000, 500
        self.node.store()
        sdo["Profile velocity"].raw = 5
        self.reset()
        self.assertEqual((sdo["Profile velocity"].raw, sdo[0x1017].raw), (123_000, 500))
        self.node.restore()
        self.reset()
        self.assertEqual((sdo["Profile velocity"].raw, sdo[0x1017].raw), (300_000, 0))


class ProcessData(Served):
    def setUp(self):
        super().setUp()
        self.node.tpdo.read()
        self.node.rpdo.read()

    def test_telemetry_has_250_hz_and_the_status_50_hz(self):
        seen = {1: [], 2: [], 3: []}
        for number, frames in seen.items():
            self.node.tpdo[number].add_callback(lambda pdo, frames=frames: frames.append(pdo.timestamp))
        self.node.nmt.state = "OPERATIONAL"
        counter = self.node.tpdo[2]["Sample stamp.Sample counter"]
        self.wait_for(lambda: seen[2], "telemetry")
        before, begun = counter.raw, len(seen[2])
        time.sleep(1)
        samples, frames = counter.raw - before & 0xFFFF, len(seen[2]) - begun
        # By the actuator's count no sample is lost; the tolerance is for the clock of a busy
        # computer.
        self.assertAlmostEqual(samples, frames, delta=2)
        if not ELF:
            self.assertTrue(230 <= samples <= 270, samples)
        self.assertAlmostEqual(len(seen[2]) / len(seen[3]), 5, delta=0.5)

    def test_a_pdo_is_remapped(self):
        pdo = self.node.tpdo[4]
        pdo.clear()
        pdo.add_variable("DC link circuit voltage")
        pdo.add_variable("Board temperature")
        pdo.trans_type, pdo.event_timer, pdo.enabled = 254, 20, True
        pdo.save()
        self.node.nmt.state = "OPERATIONAL"
        self.wait_for(lambda: abs(pdo["DC link circuit voltage"].raw - 6_000) < 50, "6 V")
        self.assertAlmostEqual(pdo["Board temperature"].raw, 250, delta=5)

    def test_sync_triggers(self):
        self.triggers_at_every_other_sync(self.node.tpdo[4])

    def test_lost_heartbeat_of_the_client_is_an_emergency(self):
        self.node.sdo.download(0x1016, 1, struct.pack("<I", 100 << 16 | 60))
        self.network.send_message(0x700 + 100, b"\x05")
        self.wait_for(lambda: self.node.emcy.active, "emergency")
        self.assertEqual(self.node.emcy.active[0].code, 0x8130)


class Drive(DriveTests, Served):
    # The position window.
    tolerance = 500

    @staticmethod
    def master():
        return BaseNode402(1, SHEET)

    def setUp(self):
        super().setUp()
        self.node.TIMEOUT_CHECK_TPDO = self.timeout
        self.node.nmt.state = "OPERATIONAL"
        self.node.setup_402_state_machine()

    def test_commands_at_50_hz_are_followed_and_their_loss_is_a_fault(self):
        self.enable("CYCLIC SYNCHRONOUS POSITION")
        command = self.node.rpdo[3]
        command["Controlword"].raw = 0x0F
        for step in range(100):
            command["Target position"].raw = 200 * step
            command.transmit()
            time.sleep(0.02)
        # The lag is the rate, 10 deg/s, divided by the gain, 8/s, plus the delay of a busy
        # computer.
        self.assertGreater(self.angle_mdeg(), 12_000)

        def settled():
            command.transmit()
            return abs(self.angle_mdeg() - 19_800) < 300

        self.wait_for(settled, "the last target")
        self.wait_for(lambda: self.node.state == "FAULT", "the fault of the missing commands")
        self.wait_for(lambda: self.node.emcy.active, "emergency")
        error = self.node.emcy.active[0]
        self.assertEqual((error.code, error.data[0]), (0x8130, 0x80 | 15))
        self.assertEqual(self.node.sdo["Error code"].raw, 0x8130)
        self.node.reset_from_fault()
        self.wait_for(lambda: not self.node.emcy.active, "error reset")

    def test_a_mode_is_changed_while_enabled_by_sdo_or_with_the_controlword_of_rpdo_2(self):
        def change(mode):
            self.node.op_mode = mode
            self.wait_for(lambda: self.node.op_mode == mode, f"the mode {mode}")
            # Longer than the stop that a controlword of 0 would start, and the period of TPDO 3.
            time.sleep(0.2)
            return self.node.state

        # The client sends controlwords by RPDO 1, and modes by RPDO 2 with a controlword of its
        # own, at first 0.
        self.enable("PROFILED POSITION")
        self.assertEqual(change("PROFILED VELOCITY"), "SWITCH ON DISABLED")
        self.enable("PROFILED VELOCITY")
        self.node.rpdo[2]["Controlword"].raw = 0x0F
        self.assertEqual(change("CYCLIC SYNCHRONOUS POSITION"), "OPERATION ENABLED")
        del self.node.rpdo_pointers[0x6060]
        self.assertEqual(change("PROFILED POSITION"), "OPERATION ENABLED")

    def test_homing_by_the_client(self):
        for offset in (12_000, -3_000):
            self.node.sdo["Homing method"].raw = 37
            self.node.sdo["Home offset"].raw = offset
            self.assertTrue(self.node.homing(timeout=self.timeout))
            self.assertLess(abs(self.node.sdo["Position actual value"].raw - offset), 200)
            self.assertTrue(self.node.is_homed())
            self.node.state = "SWITCH ON DISABLED"

    def test_velocities_are_reached(self):
        self.node.sdo["Software position limit"]["Max position limit"].raw = 150_000
        self.enable("PROFILED VELOCITY")
        self.node.sdo["Target velocity"].raw = 60_000
        self.wait_for(lambda: abs(self.node.sdo["Velocity actual value"].raw - 60_000) < 25_000, "60 deg/s")
        self.node.sdo["Target velocity"].raw = 0
        self.wait_for(lambda: abs(self.node.sdo["Velocity actual value"].raw) < 1_000, "standstill")

    def test_limits_are_write_protected_while_enabled(self):
        self.enable("PROFILED POSITION")
        limit = struct.pack("<i", 70_000)
        for index, sub in ((0x607D, 2), (0x2100, 8), (0x2102, 1), (0x6065, 0)):
            self.aborts(0x0800_0022, self.node.sdo.download, index, sub, limit[:4] if sub != 1 else struct.pack("<i", 5))
        self.node.state = "SWITCH ON DISABLED"
        self.node.sdo.download(0x607D, 2, limit)


class ServiceAccess(Served):
    """The service password, object 2103h. The drive is not enabled."""

    password = 0x1EAF_5EED
    limit = struct.pack("<i", 70_000)

    def setUp(self):
        super().setUp()
        self.access = self.node.sdo["Service access"]

    def give(self, password):
        self.node.sdo.download(0x2103, 1, struct.pack("<I", password))

    def lock(self):
        self.assertEqual(self.access["State"].raw, 0)
        self.node.sdo.download(0x2103, 4, struct.pack("<I", self.password))
        self.assertEqual(self.access["State"].raw, 2)
        self.node.store()
        self.reset()
        self.assertEqual(self.access["State"].raw, 1)

    def test_a_stored_password_locks_after_a_reset_until_it_is_given(self):
        self.lock()
        locked = [(0x607D, 2, self.limit), (0x2100, 8, struct.pack("<i", 1_500)), (0x2102, 1, struct.pack("<i", 5)),
                  (0x2103, 4, bytes(4)), (0x1F51, 1, b"\1"), (0x1011, 1, b"load"), (0x1011, 3, b"load")]
        for index, sub, data in locked:
            with self.subTest(f"{index:04X}h:{sub}"):
                self.aborts(0x0800_0022, self.node.sdo.download, index, sub, data)
        self.aborts(0x0800_0022, self.node.sdo.download, 0x1F50, 1, bytes(600))
        # What moves the drive is not locked.
        self.node.sdo["Profile velocity"].raw = 100_000
        self.give(self.password)
        self.assertEqual(self.access["State"].raw, 2)
        self.node.sdo.download(0x607D, 2, self.limit)
        self.give(0)
        self.assertEqual(self.access["State"].raw, 1)
        self.aborts(0x0800_0022, self.node.sdo.download, 0x607D, 2, self.limit)

    def test_a_wrong_password_starts_a_back_off_that_doubles_and_survives_a_reset(self):
        self.lock()
        self.aborts(0x0609_0030, self.give, 1)
        self.assertTrue(0 < self.access["Remaining back-off"].raw <= 1_000)
        self.reset()
        self.aborts(0x0800_0022, self.give, self.password)
        self.wait_for(lambda: self.access["Remaining back-off"].raw == 0, "the end of the back-off")
        self.aborts(0x0609_0030, self.give, 1)
        self.assertTrue(1_000 < self.access["Remaining back-off"].raw <= 2_000)
        self.wait_for(lambda: self.access["Remaining back-off"].raw == 0, "the end of the back-off")
        self.give(self.password)
        self.assertEqual(self.access["State"].raw, 2)

    def test_the_password_is_not_readable(self):
        self.lock()
        self.give(self.password)
        for sub in (1, 4):
            self.aborts(0x0601_0001, self.node.sdo.upload, 0x2103, sub)

    @natively
    def test_the_program_actuator_opens_for_a_command_and_locks_again(self):
        self.assertEqual(self.actuator("set", "new-password=77").returncode, 0)
        self.assertEqual(self.actuator("save").returncode, 0)
        self.reset()
        refused = self.actuator("set", "607D:2=70000")
        self.assertEqual((refused.returncode, "--password" in refused.stderr), (3, True), refused.stderr)
        done = self.actuator("set", "607D:2=70000", "--password", "0x4D")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        # By the same client: this one would take late responses to the other for its own.
        self.assertEqual(self.actuator("get", "2103:2").stdout.strip(), "1")
        wrong = self.actuator("restore", "--password", "78")
        self.assertEqual((wrong.returncode, "password is wrong" in wrong.stderr), (3, True), wrong.stderr)
        early = self.actuator("restore", "--password", "77")
        self.assertEqual((early.returncode, "remaining-back-off" in early.stderr), (3, True), early.stderr)
        self.assertEqual(self.actuator("set", "607D:2=1", "--password", "0").returncode, 2)


@natively
class Program(Served):
    """The client of the program `actuator`."""

    def test_move_excite_and_record(self):
        done = self.actuator("move", "20", "--json")
        self.assertAlmostEqual(json.loads(done.stdout)["angle_deg"], 20, delta=0.5)
        done = self.actuator("excite", "doublet", "--amplitude", "5", "--unit", "0.1", "--capture")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.actuator("set", "2030:1=0")
        rows = list(csv.DictReader(self.actuator("record", "--capture").stdout.splitlines()))
        # The commands of the board are exact in mdeg: 5 deg up, 5 deg down, 25 control periods
        # each.
        commands = [float(row["command_mdeg"]) - float(rows[-1]["command_mdeg"]) for row in rows]
        self.assertEqual([round(value) for value in commands[:51]], [5_000] * 25 + [-5_000] * 25 + [0])
        rows = list(csv.DictReader(self.actuator("record", "--for", "0.5").stdout.splitlines()))
        self.assertGreater(len(rows), 80)
        self.assertAlmostEqual(float(rows[-1]["angle_deg"]), 20, delta=0.5)
        times = [float(row["time_s"]) for row in rows]
        self.assertTrue(all(0.003 < b - a < 0.1 for a, b in zip(times, times[1:])))

    def test_names_json_and_exit_codes(self):
        devices = json.loads(self.actuator("scan", "--json").stdout)
        self.assertEqual([device["node"] for device in devices], [1, 2])
        self.assertEqual(self.actuator("set", "profile-velocity=5000", "607D:2=70000").returncode, 0)
        values = json.loads(self.actuator("get", "6081", "max-position-limit", "--json").stdout)
        self.assertEqual(list(values.values()), [5_000, 70_000])
        refused = self.actuator("set", "607D:1=70001")
        self.assertEqual((refused.returncode, "below the minimum" in refused.stderr), (3, True))
        unknown = self.actuator("get", "statuswort")
        self.assertEqual((unknown.returncode, "did you mean `statusword`" in unknown.stderr), (2, True))
        silent = self.actuator("get", "6041", "--node", "9")
        self.assertEqual((silent.returncode, "node 9 does not answer" in silent.stderr), (1, True))

    def test_faults_are_listed_and_reset(self):
        self.node.nmt.state = "OPERATIONAL"
        # A cyclic master that stops commanding.
        for word in (6, 7, 15, 15):
            self.network.send_message(0x401, struct.pack("<Hi", word, 0))
            time.sleep(0.03)
        faults = lambda *more: json.loads(self.actuator("faults", "--json", *more).stdout)
        self.wait_for(lambda: faults()["state"] == "fault", "the timeout of the commands")
        self.assertEqual(faults()["latched"], ["command timeout"])
        after = faults("--reset")
        self.assertEqual((after["latched"], after["state"]), ([], "switch on disabled"))
        self.assertEqual(after["history"][0]["code"], "8130h")

    def test_monitor_shows_lines(self):
        done = self.actuator("monitor", "--for", "0.5")
        self.assertIn("angle", done.stdout)
        self.assertIn("switch on disabled", done.stdout)


@natively
class LayerSettings(Served):
    options = ("--unconfigured",)

    def test_fast_scan_distinguishes_two_actuators_and_stores_their_node_ids(self):
        lss = self.network.lss
        for node_id in (2, 1):
            found, identity = lss.fast_scan()
            self.assertTrue(found)
            self.assertEqual(identity[:2], [0, 0x5341])
            lss.configure_node_id(node_id)
            lss.store_configuration()
            lss.send_switch_state_global(lss.WAITING_STATE)
        self.wait_for(lambda: any(data == b"\0" for _, data, _ in self.frames), "boot-up")
        self.assertEqual(self.node.sdo["Bus"]["Node-ID"].raw, 1)


if __name__ == "__main__":
    logging.getLogger("canopen").setLevel(logging.CRITICAL)
    unittest.main()
