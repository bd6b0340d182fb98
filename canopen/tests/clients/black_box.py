#!/usr/bin/env python3
"""Responses to invalid requests as specified by CiA 301 and CiA 402, and every command in every state of the drive. The frames are
written from the standards; the server is tested through its responses only.

    black_box.py target/debug/actuator
"""
import struct
import sys
import time
import unittest

from wire import Bench, boards

PROGRAM, ELF = sys.argv.pop(1), boards(sys.argv)

TOGGLE, TIMED_OUT, UNKNOWN = "00 00 03 05", "00 00 04 05", "01 00 04 05"
BLOCK_SIZE, SEQUENCE, CHECKSUM = "02 00 04 05", "03 00 04 05", "04 00 04 05"
LONG, SHORT = "12 00 07 06", "13 00 07 06"
NAME, TARGET = "08 10 00", "7A 60 00"
# The name is SMART-ACTUATOR, the target position has 4 bytes.
SEGMENTED, BLOCKS = f"41 {NAME} 0E 00 00 00", f"C6 {NAME} 0E 00 00 00"
FIRST, LAST = "01 53 4D 41 52 54 2D 41", "82 43 54 55 41 54 4F 52"

# Request of the client and expected response; None for no response, several frames in one list.
CONVERSATIONS = {
    "a toggle bit that does not alternate": [
        (f"40 {NAME}", SEGMENTED), ("70", f"80 {NAME} {TOGGLE}"), ("60", f"80 00 00 00 {UNKNOWN}")],
    "a segment without a transfer": [("00 01", f"80 00 00 00 {UNKNOWN}")],
    "a server's command": [("E0", f"80 00 00 00 {UNKNOWN}")],
    "a new upload within another": [(f"40 {NAME}", SEGMENTED), (f"40 {NAME}", SEGMENTED), ("80", None)],
    "a download's segment in an upload": [(f"40 {NAME}", SEGMENTED), ("00", f"80 {NAME} {UNKNOWN}")],
    "an upload's segment in a download": [(f"21 {TARGET} 04", f"60 {TARGET}"), ("60", f"80 {TARGET} {UNKNOWN}")],
    "fewer bytes than indicated": [(f"21 {TARGET} 04", f"60 {TARGET}"), ("09 01", f"80 {TARGET} {SHORT}")],
    "more bytes than the object has": [(f"20 {TARGET}", f"60 {TARGET}"), ("00", "20"), ("1D", f"80 {TARGET} {LONG}")],
    "a size that is not the object's": [(f"21 {TARGET} 03", f"80 {TARGET} {SHORT}"), (f"21 {TARGET} 05", f"80 {TARGET} {LONG}")],
    "an abort of an upload": [(f"40 {NAME}", SEGMENTED), ("80", None), ("60", f"80 00 00 00 {UNKNOWN}")],
    "an abort between blocks": [
        (f"A4 {NAME} 7F", BLOCKS), ("A3", [FIRST, LAST]), ("80", None), ("A2 02 7F", f"80 00 00 00 {UNKNOWN}")],
    "block size 0": [(f"A4 {NAME} 00", f"80 {NAME} {BLOCK_SIZE}")],
    "block size 128": [(f"A4 {NAME} 80", f"80 {NAME} {BLOCK_SIZE}")],
    "128 segments in the next block": [(f"A4 {NAME} 01", BLOCKS), ("A3", FIRST), ("A2 01 80", f"80 {NAME} {BLOCK_SIZE}")],
    "more confirmed than was sent": [(f"A4 {NAME} 01", BLOCKS), ("A3", FIRST), ("A2 02 01", f"80 {NAME} {SEQUENCE}")],
    "one confirmed of two": [
        (f"A0 {NAME} 7F", BLOCKS), ("A3", [FIRST, LAST]), ("A2 01 7F", "81" + LAST[2:]),
        ("A2 01 7F", "C1"), ("A1", None)],
    "a threshold above the size": [(f"A4 {NAME} 7F 0E", SEGMENTED), ("80", None)],
    "a threshold below the size": [(f"A4 {NAME} 7F 0D", BLOCKS), ("80", None)],
    "a wrong checksum": [(f"C6 {TARGET} 04", f"A4 {TARGET} 7F"), ("81 01", "A2 01 7F"), ("CD", f"80 {TARGET} {CHECKSUM}")],
    "segment 0": [(f"C2 {TARGET} 04", f"A4 {TARGET} 7F"), ("00", f"80 {TARGET} {SEQUENCE}")],
    "a gap": [(f"C2 {TARGET} 04", f"A4 {TARGET} 7F"), ("82", "A2 00 7F"), ("81", "A2 01 7F"), ("CD", "A1")],
    "a time-out": [(f"21 {TARGET} 04", [f"60 {TARGET}", f"80 {TARGET} {TIMED_OUT}"]), ("00", f"80 00 00 00 {UNKNOWN}")],
}


class Network(Bench):
    program, elf = PROGRAM, ELF

    def test_invalid_sdo_requests_are_answered_as_the_standard_specifies(self):
        for title, exchanges in CONVERSATIONS.items():
            with self.subTest(title):
                for sent, received in exchanges:
                    self.sdo.send(bytes.fromhex(sent))
                    for expected in [received] if isinstance(received, str) else received or []:
                        frame = self.wire.receive(lambda frame: frame.identifier == 0x581, self.sdo.timeout)
                        self.assertEqual(frame.data, bytes.fromhex(expected).ljust(8, b"\0"), sent)
                # No response is pending: the next response belongs to the next request.
                self.assertEqual(self.sdo.upload(0x1000, 0), bytes.fromhex("92 01 02 00"))

    def test_frames_that_are_not_sdo_requests_are_not_answered(self):
        request = bytes.fromhex("40 00 10 00 00 00 00 00")
        for length in range(8):
            self.wire.send(0x601, request[:length])
        self.wire.send(0x601, request, extended=True)
        self.wire.send(0x601, remote=True, length=8)
        self.wire.send(0x602, request)
        # The first response is that of the next request, which names another object.
        self.assertEqual(self.sdo.upload(0x1017, 0), bytes(2))
        self.assertEqual(self.wire.receive_all(lambda frame: frame.identifier == 0x581, 0.05), [])

    def state_after_all_frames(self):
        """NMT state from the first heartbeat after everything sent so far was processed: an SDO response follows it. While stopped
        a node answers no SDO request."""
        self.sdo.upload(0x1000, 0)
        return self.wire.receive(lambda frame: frame.identifier == 0x701, self.sdo.timeout).data[0]

    def test_only_valid_nmt_commands_are_executed(self):
        self.sdo.download(0x1017, 0, struct.pack("<H", 10))
        for command in ([1, 2], [1], [1, 2, 1], [0, 1], [5, 1], [127, 1], [1, 128], [1, 129], [129, 2]):
            self.wire.send(0, bytes(command))
            self.assertEqual(self.state_after_all_frames(), 127, command)
        self.wire.send(0, remote=True, length=2)
        self.wire.send(0, bytes([1, 1]), extended=True)
        self.assertEqual(self.state_after_all_frames(), 127)
        # Each command changes the state.
        for command, state in ([1, 1], 5), ([128, 0, 0, 0, 0, 0, 0, 0], 127), ([1, 0], 5), ([2, 1], 4), ([1, 1], 5), ([128, 1], 127), ([2, 0], 4):
            with self.subTest(command):
                self.wire.send(0, bytes(command))
                self.expect_frame(0x701, [state])
        self.sdo.send(bytes.fromhex("40 00 10 00"))
        self.wire.send(0x701, remote=True, length=1)
        # In the following 100 ms of the node.
        received = [self.wire.receive(lambda frame: True, self.sdo.timeout) for _ in range(10)]
        self.assertEqual({(frame.identifier, frame.data) for frame in received}, {(0x701, bytes([4]))}, "no SDO, no guarding")
        for command in (130, 129):
            self.wire.send(0, bytes([command, 0]))
            self.expect_frame(0x701, [0])
            self.assertEqual(self.sdo.upload(0x1017, 0), bytes(2))

    def test_every_sync_is_answered_while_emergencies_are_sent(self):
        """A SYNC right behind each reply, so that many an EMCY and a reply are due in the same communication cycle."""
        defaults = [(0x1029, 1, self.sdo.upload(0x1029, 1)), (0x1800, 5, self.sdo.upload(0x1800, 5)), (0x1800, 2, self.sdo.upload(0x1800, 2))]
        # The state is kept without a heartbeat; TPDO 1 is sent with each SYNC.
        for (index, sub, old), value in zip(defaults, (1, 0, 1)):
            self.sdo.download(index, sub, value.to_bytes(len(old), "little"))
        self.wire.send(0, [1, self.node])
        for _ in range(20):
            self.sdo.download(0x1016, 1, bytes(4))
            self.sdo.download(0x1016, 1, struct.pack("<I", 100 << 16 | 20))
            self.wire.send(0x700 + 100, b"\x05")
            emergencies = []
            while not emergencies:
                self.wire.send(0x80)
                self.wire.receive(lambda frame: frame.identifier == 0x81 and emergencies.append(frame) or frame.identifier == 0x181,
                                  self.sdo.timeout)
        self.wire.send(0, [128, self.node])
        for index, sub, value in [(0x1016, 1, bytes(4)), *defaults]:
            self.sdo.download(index, sub, value)

    def test_restricted_identifiers_and_reserved_types_are_refused(self):
        word = lambda value: struct.pack("<I", value)
        restricted = [
            range(0, 0x80), range(0x101, 0x181), range(0x581, 0x600), range(0x601, 0x680), range(0x6E0, 0x700),
            range(0x701, 0x780), range(0x780, 0x800)]
        for parameters, reserved in ((0x1803, range(241, 252)), (0x1403, range(241, 254))):
            default = struct.unpack("<I", self.sdo.upload(parameters, 1))[0] | 1 << 31
            self.sdo.download(parameters, 1, word(default))
            for among in restricted:
                for identifier in (among.start, among.stop - 1):
                    refused = self.refusal(self.sdo.download, parameters, 1, word(identifier))
                    self.assertEqual(refused, 0x0609_0030, f"{identifier:03X}h")
                for identifier in {among.start - 1, among.stop} & {0x80, 0x100, 0x181, 0x580, 0x600, 0x680, 0x6DF, 0x700}:
                    self.assertIsNone(self.refusal(self.sdo.download, parameters, 1, word(identifier)), f"{identifier:03X}h")
                    self.sdo.download(parameters, 1, word(default))
            for transmission in range(256):
                refused = self.refusal(self.sdo.download, parameters, 2, bytes([transmission]))
                self.assertEqual(refused, 0x0609_0030 if transmission in reserved else None, transmission)


NOT_ENABLED, READY, SWITCHED_ON, ENABLED, QUICK_STOP = 0x40, 0x21, 0x23, 0x27, 0x07
WAYS = {NOT_ENABLED: [], READY: [6], SWITCHED_ON: [6, 7], ENABLED: [6, 7, 15], QUICK_STOP: [6, 7, 15, 2]}
COMMANDS = {"shutdown": 0x06, "switch on": 0x07, "enable operation": 0x0F, "disable voltage": 0x00, "quick stop": 0x02, "fault reset": 0x80}
# Next state of each command; a command that is not listed has no effect. A fault reset has bit 1
# clear, which disables voltage.
LEADS = {
    (NOT_ENABLED, "shutdown"): READY,
    (READY, "switch on"): SWITCHED_ON, (READY, "enable operation"): ENABLED, (READY, "disable voltage"): NOT_ENABLED,
    (READY, "quick stop"): NOT_ENABLED, (READY, "fault reset"): NOT_ENABLED,
    (SWITCHED_ON, "shutdown"): READY, (SWITCHED_ON, "enable operation"): ENABLED, (SWITCHED_ON, "disable voltage"): NOT_ENABLED,
    (SWITCHED_ON, "quick stop"): NOT_ENABLED, (SWITCHED_ON, "fault reset"): NOT_ENABLED,
    (ENABLED, "shutdown"): READY, (ENABLED, "switch on"): SWITCHED_ON, (ENABLED, "disable voltage"): NOT_ENABLED,
    (ENABLED, "quick stop"): QUICK_STOP, (ENABLED, "fault reset"): NOT_ENABLED,
    (QUICK_STOP, "enable operation"): ENABLED, (QUICK_STOP, "disable voltage"): NOT_ENABLED, (QUICK_STOP, "fault reset"): NOT_ENABLED,
}


class Drive(Bench):
    program, elf = PROGRAM, ELF

    def setUp(self):
        # Profile position; the drive remains in "quick stop active" (605Ah is 6).
        self.command(0)
        self.sdo.download(0x6060, 0, b"\x01")
        self.sdo.download(0x605A, 0, struct.pack("<h", 6))

    def command(self, word):
        self.sdo.download(0x6040, 0, struct.pack("<H", word))

    def statusword(self):
        return struct.unpack("<H", self.sdo.upload(0x6041, 0))[0]

    def state(self):
        word = self.statusword()
        return word & 0x6F if word & 0x6F in (READY, SWITCHED_ON, ENABLED, QUICK_STOP) else word & 0x4F

    def reaches(self, state, message=None):
        end = time.monotonic() + self.sdo.timeout
        while self.state() != state and time.monotonic() < end:
            pass
        self.assertEqual(self.state(), state, message)

    def go(self, state):
        for word in [0, *WAYS[state]]:
            self.command(word)
            self.reaches(NOT_ENABLED if word == 0 else next(s for s, way in WAYS.items() if way and way[-1] == word))

    def test_every_command_in_every_state_matches_the_profile(self):
        for state in WAYS:
            for name, word in COMMANDS.items():
                with self.subTest(f"{name} in {state:02X}h"):
                    self.go(state)
                    self.command(word)
                    expected = LEADS.get((state, name), state)
                    self.reaches(expected)
                    # The state is unchanged two control periods later.
                    time.sleep(0.012)
                    self.assertEqual(self.state(), expected)
        self.command(0)

    def test_an_event_driven_pdo_reports_each_state_change_immediately(self):
        for pdo in range(0x1800, 0x1804):
            identifier = struct.unpack("<I", self.sdo.upload(pdo, 1))[0]
            self.sdo.download(pdo, 1, struct.pack("<I", identifier | 1 << 31))
        self.sdo.download(0x1A03, 0, b"\0")
        self.sdo.download(0x1A03, 1, struct.pack("<I", 0x6041_0010))
        self.sdo.download(0x1A03, 0, b"\1")
        self.sdo.download(0x1803, 2, b"\xFF")
        self.sdo.download(0x1803, 1, struct.pack("<I", 0x4000_0481))
        self.wire.send(0, bytes([1, 1]))
        self.addCleanup(self.wire.send, 0, bytes([130, 1]))
        for word, state in ((0, NOT_ENABLED), (6, READY), (7, SWITCHED_ON), (15, ENABLED), (0, NOT_ENABLED)):
            self.wire.send(0x201, struct.pack("<H", word))
            self.wire.receive(lambda frame: frame.identifier == 0x481 and frame.data[0] & 0x6F & (0x4F | state) == state, self.sdo.timeout)

    def test_unsupported_modes_are_refused_and_the_display_is_unchanged(self):
        supported = struct.unpack("<I", self.sdo.upload(0x6502, 0))[0]
        for mode in range(1, 11):
            refused = self.refusal(self.sdo.download, 0x6060, 0, bytes([mode]))
            self.assertEqual(refused is None, bool(supported >> (mode - 1) & 1), mode)
        self.sdo.download(0x6060, 0, b"\x01")
        self.assertIsNotNone(self.refusal(self.sdo.download, 0x6060, 0, b"\x05"))
        self.assertEqual(self.sdo.upload(0x6060, 0), b"\x01")
        # Each change acts in a control period of its own; twice their time, as the computer may be busy.
        changes = bin(supported).count("1") + 1
        time.sleep(2 * 0.004 * changes)
        self.assertEqual(self.sdo.upload(0x6061, 0), b"\x01")

    def test_set_points_are_acknowledged_buffered_and_changed_immediately(self):
        target = lambda mdeg: self.sdo.download(0x607A, 0, struct.pack("<i", mdeg))
        self.go(ENABLED)
        self.sdo.download(0x6081, 0, struct.pack("<I", 60_000))
        target(20_000)
        self.set_point(0x1F)
        self.reaches_bit(0x1000, False)
        target(0)
        self.set_point(0x1F)
        # The second is buffered; a third would not be accepted.
        time.sleep(0.012)
        self.assertTrue(self.statusword() & 0x1000)
        self.reaches_bit(0x1000, False)
        # Change set immediately replaces the active set-point.
        target(30_000)
        self.set_point(0x3F)
        self.reaches_bit(0x1000, False)
        target(-5_000)
        self.set_point(0x7F)
        self.reaches_bit(0x0400, True)
        (demanded,) = struct.unpack("<i", self.sdo.upload(0x6062, 0))
        self.assertEqual(demanded, 25_000, "relative to the set-point before")
        self.command(0)

    def set_point(self, word):
        self.command(word)
        self.reaches_bit(0x1000, True)
        self.command(0x0F)

    def reaches_bit(self, mask, value):
        end = time.monotonic() + self.sdo.timeout
        while bool(self.statusword() & mask) != value and time.monotonic() < end:
            pass
        self.assertEqual(bool(self.statusword() & mask), value, f"{mask:04X}h")


if __name__ == "__main__":
    unittest.main()
