#!/usr/bin/env python3
"""Compares the server with its EDS: reads, writes, maps and restores every entry, and writes its limits and values beyond them.

    walk.py target/debug/actuator docs/smart-actuator.eds
"""
import collections
import struct
import sys
import unittest

import sheet
from wire import Bench, boards

PROGRAM, SHEET, ELF = sys.argv.pop(1), sys.argv.pop(1), boards(sys.argv)
NODE = 1
ENTRIES = sheet.read(SHEET)

WRITE_ONLY = 0x0601_0001
READ_ONLY, NO_OBJECT, NO_SUB, NOT_MAPPABLE = 0x0601_0002, 0x0602_0000, 0x0609_0011, 0x0604_0041
TOO_LONG, TOO_SHORT, TOO_HIGH, TOO_LOW = 0x0607_0012, 0x0607_0013, 0x0609_0031, 0x0609_0032
MINIMUM_ABOVE_MAXIMUM, NOT_STORED, LOCAL, STATE, NO_DATA = 0x0609_0036, 0x0800_0020, 0x0601_0000, 0x0800_0022, 0x0800_0024

# Entries without data until an event has occurred.
EMPTY = {(0x1003, sub) for sub in range(1, 9)} | {(0x2032, 0)}
# Its only value restarts the board, if an image is staged.
PROGRAM_CONTROL = 0x1F51


class Walk(Bench):
    program, elf = PROGRAM, ELF
    node = NODE

    def write(self, entry, data):
        return self.refusal(self.sdo.download, entry.index, entry.sub, data)

    def read(self, entry):
        return self.sdo.upload(entry.index, entry.sub)

    def test_every_entry_is_read_with_the_length_of_its_type(self):
        for entry in ENTRIES:
            with self.subTest(str(entry)):
                if (entry.index, entry.sub) in EMPTY:
                    self.assertEqual(self.refusal(self.read, entry), NO_DATA)
                elif entry.access == "wo":
                    self.assertEqual(self.refusal(self.read, entry), WRITE_ONLY)
                elif entry.format:
                    self.assertEqual(len(self.read(entry)), entry.size)
                else:
                    self.assertTrue(self.read(entry).isascii())

    def test_read_only_entries_refuse_data_of_any_length(self):
        for entry in filter(lambda entry: not entry.writable, ENTRIES):
            with self.subTest(str(entry)):
                for length in {entry.size or 4, 1, 4, 20}:
                    self.assertEqual(self.write(entry, bytes(length)), READ_ONLY)

    def test_writable_entries_accept_their_own_value_and_no_other_length(self):
        for entry in filter(lambda entry: entry.writable and entry.access != "wo", ENTRIES):
            with self.subTest(str(entry)):
                value = self.read(entry)
                self.assertIn(self.write(entry, value), self.refusals_of_its_own_value(entry))
                self.assertEqual(self.read(entry), value)
                for length in {1, 2, 3, 4, 5, 8, 20} - {entry.size}:
                    self.assertEqual(self.write(entry, bytes(length)), TOO_LONG if length > entry.size else TOO_SHORT)

    @staticmethod
    def refusals_of_its_own_value(entry):
        """Parameters that require a signature; and mapping, inhibit time and SYNC start value of a valid PDO."""
        if entry.index in (0x1010, 0x1011):
            return [NOT_STORED]
        if (entry.index, entry.sub) == (PROGRAM_CONTROL, 1):
            return [STATE]
        if entry.index & 0xFE00 == 0x1600 or entry.index & 0xFE00 == 0x1A00:
            return [None, LOCAL]
        if entry.index & 0xFE00 == 0x1800 and entry.sub in (3, 6):
            return [None, STATE]
        return [None]

    def test_limits_are_accepted_and_values_beyond_them_are_refused(self):
        for entry in filter(lambda entry: entry.writable and entry.access != "wo" and entry.low is not None and entry.format != "<f", ENTRIES):
            if entry.index == PROGRAM_CONTROL:
                continue
            with self.subTest(str(entry)):
                value = self.read(entry)
                for limit, beyond, code in ((entry.low, entry.low - 1, TOO_LOW), (entry.high, entry.high + 1, TOO_HIGH)):
                    # A limit may violate a relation to another parameter; and an excitation cannot
                    # start while the drive is disabled.
                    expected = [None, STATE] if entry.index == 0x2020 else [None, MINIMUM_ABOVE_MAXIMUM]
                    self.assertIn(self.write(entry, entry.pack(limit)), expected, limit)
                    self.assertIsNone(self.write(entry, value))
                    try:
                        data = entry.pack(beyond)
                    except struct.error:
                        continue
                    self.assertEqual(self.write(entry, data), code, beyond)
                self.assertEqual(self.read(entry), value)

    def test_no_entries_exist_beyond_the_eds(self):
        subs = collections.defaultdict(set)
        for entry in ENTRIES:
            subs[entry.index].add(entry.sub)
        for index, known in subs.items():
            with self.subTest(f"{index:04X}h"):
                for sub in {*range(12), max(known) + 1, 0xFE, 0xFF} - known:
                    self.assertEqual(self.refusal(self.sdo.upload, index, sub), NO_SUB, sub)
                    self.assertEqual(self.refusal(self.sdo.download, index, sub, b"\0"), NO_SUB, sub)
                for neighbour in {index - 1, index + 1} - subs.keys():
                    self.assertEqual(self.refusal(self.sdo.upload, neighbour, 0), NO_OBJECT)

    def test_sub_index_0_is_the_number_of_entries(self):
        for entry in filter(lambda entry: entry.member and entry.sub == 0, ENTRIES):
            with self.subTest(str(entry)):
                highest = max(other.sub for other in ENTRIES if other.index == entry.index)
                # Sub-index 0 of history and mappings is the number of used entries.
                counts = entry.index == 0x1003 or 0x1600 <= entry.index < 0x1800 or 0x1A00 <= entry.index < 0x1C00
                (count,) = self.read(entry)
                self.assertTrue(count <= highest if counts else count == highest, count)

    def test_mappable_entries_match_the_eds(self):
        for parameters, mapping, accesses in ((0x1803, 0x1A03, ("ro", "rw", "rwr", "const")), (0x1403, 0x1603, ("rw", "rww", "wo"))):
            cob_id = struct.unpack("<I", self.sdo.upload(parameters, 1))[0]
            self.sdo.download(parameters, 1, struct.pack("<I", cob_id | 1 << 31))
            for entry in ENTRIES:
                with self.subTest(str(entry)):
                    self.sdo.download(mapping, 0, b"\0")
                    expected = None if entry.mappable and entry.access in accesses else NOT_MAPPABLE
                    self.assertEqual(self.map(mapping, entry, 8 * (entry.size or 1)), expected)
                    for bits in (0, 1, 4 * (entry.size or 1), 16 * (entry.size or 1)):
                        self.assertEqual(self.map(mapping, entry, bits), NOT_MAPPABLE, bits)

    def map(self, mapping, entry, bits):
        word = struct.pack("<I", entry.index << 16 | entry.sub << 8 | bits)
        refused = self.refusal(self.sdo.download, mapping, 1, word)
        return refused or self.refusal(self.sdo.download, mapping, 0, b"\1") or self.refusal(self.sdo.download, mapping, 0, b"\0")

    def test_defaults_of_the_eds_apply_after_a_restore(self):
        changed = 0
        for entry in ENTRIES:
            if entry.writable and entry.low is not None and entry.format != "<f" and 0x2000 <= entry.index:
                changed += self.write(entry, entry.pack(entry.low)) is None
        self.assertGreater(changed, 50)
        self.sdo.download(0x1011, 1, b"load")
        self.wire.send(0, bytes([0x81, NODE]))
        self.expect_frame(0x700 + NODE, [0])
        for entry in filter(lambda entry: entry.default is not None and (entry.index, entry.sub) not in EMPTY, ENTRIES):
            if entry.access == "wo":
                continue
            with self.subTest(str(entry)):
                self.assertEqual(self.read(entry), entry.packed_default(NODE))


if __name__ == "__main__":
    unittest.main()
