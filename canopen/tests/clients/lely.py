#!/usr/bin/env python3
"""Lely's dcfgen generates from the EDS the configuration that a Lely master writes at boot-up. The actuator accepts all of it and
operates in the synchronous network that it describes.

    lely.py target/debug/actuator docs/smart-actuator.eds
"""
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

from wire import Bench, boards

PROGRAM, SHEET, ELF = sys.argv.pop(1), sys.argv.pop(1), boards(sys.argv)
DCFGEN = pathlib.Path(sys.executable).with_name("dcfgen")
NETWORK = pathlib.Path(__file__).with_name("network.yml")


def concise_dcf():
    """Index, sub-index and data of each write."""
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(SHEET, folder)
        shutil.copy(NETWORK, folder)
        subprocess.run([DCFGEN, "--remote-pdo", NETWORK.name], cwd=folder, check=True, timeout=30)
        data = pathlib.Path(folder, "actuator.bin").read_bytes()
    (count,), at = struct.unpack_from("<I", data), 4
    for _ in range(count):
        index, sub, size = struct.unpack_from("<HBI", data, at)
        at += 7 + size
        yield index, sub, data[at - size:at]


class Lely(Bench):
    program, elf = PROGRAM, ELF

    def test_lely_s_configuration_is_accepted_and_a_synchronous_network_works(self):
        writes = list(concise_dcf())
        self.assertGreater(len(writes), 15)
        for index, sub, data in writes:
            self.assertIsNone(self.refusal(self.sdo.download, index, sub, data), f"{index:04X}h:{sub:02X}h")
        self.wire.send(0, bytes([1, 1]))
        statusword, position, target = 0, 0, 0
        for cycle in range(300):
            # A master's cycle: heartbeat, command, SYNC, then reception of the telemetry.
            self.wire.send(0x77F, b"\x05")
            state = statusword & 0x6F
            word = {0x21: 7, 0x23: 15, 0x27: 15}.get(state, 6 if statusword & 0x4F == 0x40 else 0)
            target += 200 if state == 0x27 and target < 20_000 else 0
            self.wire.send(0x201, struct.pack("<Hi", word, target))
            self.wire.send(0x80)
            received = self.wire.receive(lambda frame: frame.identifier == 0x181, self.sdo.timeout)
            statusword, position = struct.unpack("<Hi", received.data)
            self.wire.receive_all(lambda frame: False, 0.01)
            if abs(position - 20_000) < 500:
                break
        self.assertAlmostEqual(position, 20_000, delta=500, msg=f"in {cycle} cycles")
        self.assertGreater(cycle, 100, "it follows and does not jump")
        self.assertEqual(statusword & 0x6F, 0x27)


if __name__ == "__main__":
    unittest.main()
