#!/usr/bin/env python3
"""Tests with unmodified python-canopen and python-can's slcan driver against one node.

    python_canopen.py target/debug/examples/loopback
"""
import logging
import struct
import sys
import time
import unittest

import canopen
from canopen import objectdictionary as od
from canopen.lss import LssError
from canopen.profiles.p402 import BaseNode402

from served import Bench, DriveTests

PROGRAM = sys.argv.pop(1)
DATA = bytes((at * 7 + at // 256) & 255 for at in range(1 << 16))


def dictionary():
    """The objects used by name; python-canopen reads the others by index."""
    objects = od.ObjectDictionary()

    def variable(index, name, data_type, sub=None):
        var = od.ODVariable(name, index, sub or 0)
        var.data_type = data_type
        var.pdo_mappable = True
        if sub is None:
            objects.add_object(var)
        return var

    def record(index, name, members):
        group = od.ODRecord(name, index)
        for sub, (member, data_type) in members.items():
            group.add_member(variable(index, member, data_type, sub))
        objects.add_object(group)

    u8, u16, u32 = od.UNSIGNED8, od.UNSIGNED16, od.UNSIGNED32
    for index, name, data_type in (
        (0x1001, "Error register", u8), (0x1005, "COB-ID SYNC", u32), (0x1017, "Heartbeat", u16),
        (0x2000, "Choice", u8), (0x2001, "Level", od.INTEGER16), (0x2005, "Name", od.VISIBLE_STRING),
        (0x2007, "Error", u16), (0x2010, "Data", od.DOMAIN), (0x6040, "Controlword", u16),
        (0x6041, "Statusword", u16), (0x6064, "Position", od.INTEGER32), (0x607A, "Target", od.INTEGER32),
        (0x1008, "Device name", od.VISIBLE_STRING), (0x6060, "Mode", od.INTEGER8),
        (0x6061, "Mode display", od.INTEGER8), (0x60FF, "Velocity", od.INTEGER32), (0x6502, "Modes", u32),
    ):
        variable(index, name, data_type)
    record(0x1003, "History", {sub: (f"Error {sub}", u32 if sub else u8) for sub in range(9)})
    record(0x1010, "Store", {0: ("Count", u8), 1: ("All", u32)})
    record(0x1011, "Restore", {0: ("Count", u8), 1: ("All", u32)})
    for base in (0x1400, 0x1800):
        for index in (base, base + 1):
            record(index, f"PDO {index:X}", {
                0: ("Highest", u8), 1: ("COB-ID", u32), 2: ("Type", u8), 3: ("Inhibit", u16),
                5: ("Event timer", u16), 6: ("SYNC start", u8)})
            record(index + 0x200, f"Map {index:X}",
                   {sub: (f"Object {sub}", u32 if sub else u8) for sub in range(9)})
    return objects


class Served(Bench):
    """A separate node for each test."""

    def command(self):
        return [PROGRAM, "0", str(self.node_id)]

    @staticmethod
    def master():
        return canopen.RemoteNode(5, dictionary())


class Management(Served):
    def test_the_scanner_finds_the_node(self):
        self.network.scanner.search()
        self.wait_for(lambda: self.network.scanner.nodes == [5], "node 5 is not found")

    def test_nmt_states_are_reached_and_reported_by_heartbeat(self):
        self.node.sdo[0x1017].raw = 20
        for state in ("OPERATIONAL", "STOPPED", "PRE-OPERATIONAL"):
            self.node.nmt.state = state
            self.wait_for(lambda: self.node.nmt.state == state, state)
            self.assertEqual(self.node.nmt.wait_for_heartbeat(1), state)
        self.reset()
        self.assertEqual(self.node.sdo[0x1017].raw, 0)

    def test_heartbeats_keep_their_period(self):
        self.node.sdo[0x1017].raw = 50
        time.sleep(1.0)
        stamps = [stamp for _, data, stamp in self.frames if data == b"\x7f"]
        self.assertTrue(17 <= len(stamps) <= 22, len(stamps))

    def test_lost_heartbeat_of_the_client_is_an_emergency(self):
        self.node.sdo.download(0x1016, 1, struct.pack("<I", 100 << 16 | 60))
        self.network.send_message(0x700 + 100, b"\x05")
        self.wait_for(lambda: self.node.emcy.active, "emergency")
        [error] = self.node.emcy.active
        self.assertEqual((error.code, error.register, error.data), (0x8130, 0x11, bytes([100, 0, 0, 0, 0])))


class Transfers(Served):
    def test_numbers_and_strings(self):
        self.node.sdo[0x2001].raw = -321
        self.assertEqual(self.node.sdo[0x2001].raw, -321)
        self.assertEqual(self.node.sdo[0x1008].raw, "CANOPEN-EXAMPLE")
        self.node.sdo[0x2005].raw = "thirty-two bytes are not too long"[:32]
        self.assertEqual(self.node.sdo[0x2005].raw, "thirty-two bytes are not too lon")

    def test_segmented_transfer_in_both_directions(self):
        for size in (1, 4, 5, 7, 8, 1000):
            self.node.sdo.download(0x2010, 0, DATA[:size], force_segment=True)
            self.assertEqual(self.node.sdo.upload(0x2010, 0), DATA[:size])

    def block(self, size):
        with self.node.sdo[0x2010].open("wb", size=size, block_transfer=True) as out:
            out.write(DATA[:size])
        with self.node.sdo[0x2010].open("rb", block_transfer=True, request_crc_support=True) as back:
            self.assertEqual(back.read(), DATA[:size])

    def test_block_transfer_in_both_directions_with_crc(self):
        for size in (5, 7, 8, 888, 889, 890, 5000):
            self.block(size)

    def test_64_kib_in_blocks(self):
        self.block(1 << 16)

    def test_abort_codes(self):
        sdo = self.node.sdo
        self.aborts(0x0602_0000, sdo.upload, 0x2FFF, 0)
        self.aborts(0x0609_0011, sdo.upload, 0x1018, 9)
        self.aborts(0x0601_0001, sdo.upload, 0x2002, 0)
        self.aborts(0x0601_0002, sdo.download, 0x1000, 0, bytes(4))
        self.aborts(0x0607_0012, sdo.download, 0x6040, 0, bytes(4))
        self.aborts(0x0607_0013, sdo.download, 0x6040, 0, bytes(1))
        self.aborts(0x0609_0031, sdo.download, 0x2000, 0, b"\x03")
        self.aborts(0x0609_0036, sdo.download, 0x607D, 1, struct.pack("<i", 70_000))
        self.aborts(0x0800_0020, sdo.download, 0x1010, 1, b"evas")

    def test_parameters_are_stored_across_a_reset(self):
        self.node.sdo[0x1017].raw = 500
        self.node.sdo[0x2000].raw = 2
        self.node.store()
        self.node.sdo[0x2000].raw = 1
        self.reset()
        self.assertEqual((self.node.sdo[0x1017].raw, self.node.sdo[0x2000].raw), (500, 2))
        self.node.restore()
        self.reset()
        self.assertEqual((self.node.sdo[0x1017].raw, self.node.sdo[0x2000].raw), (0, 0))


class ProcessData(Served):
    def setUp(self):
        super().setUp()
        self.node.tpdo.read()
        self.node.rpdo.read()

    def test_the_default_mapping_is_read(self):
        self.assertEqual([var.index for var in self.node.tpdo[1]], [0x6041, 0x6064])
        self.assertEqual(self.node.rpdo[1].cob_id, 0x205)

    def test_pdos_are_remapped_and_transmitted(self):
        pdo = self.node.tpdo[2]
        pdo.clear()
        pdo.add_variable(0x2001)
        pdo.add_variable(0x6064)
        pdo.trans_type, pdo.event_timer, pdo.enabled = 254, 50, True
        pdo.save()
        self.node.nmt.state = "OPERATIONAL"
        self.node.sdo[0x2001].raw = -7
        self.node.sdo[0x6060].raw = 8
        command = self.node.rpdo[1]
        command[0x607A].raw = 12_345
        for word in (0x06, 0x07, 0x0F):
            command[0x6040].raw = word
            command.transmit()
            time.sleep(0.02)
        # A cyclic target acts once it arrives after enabling.
        command.transmit()
        self.wait_for(lambda: pdo[0x6064].raw == 12_345 and pdo[0x2001].raw == -7, "values")
        seen = []
        pdo.add_callback(seen.append)
        time.sleep(1.0)
        self.assertTrue(17 <= len(seen) <= 22, len(seen))

    def test_sync_triggers(self):
        self.triggers_at_every_other_sync(self.node.tpdo[1])

    def test_invalid_mappings_are_refused(self):
        self.node.sdo.download(0x1A01, 0, b"\x00")
        self.aborts(0x0604_0041, self.node.sdo.download, 0x1A01, 1, struct.pack("<I", 0x2000_0008))
        self.aborts(0x0602_0000, self.node.sdo.download, 0x1A01, 1, struct.pack("<I", 0x2FFF_0008))
        self.aborts(0x0601_0000, self.node.sdo.download, 0x1A00, 0, b"\x00")


class Drive(DriveTests, Served):
    """BaseNode402, which performs the state transitions itself and receives the state by TPDO."""

    @staticmethod
    def master():
        return BaseNode402(5, dictionary())

    def setUp(self):
        super().setUp()
        # BaseNode402 treats a PDO received twice as periodic and waits for the next.
        self.node.sdo[0x1800][5].raw = 20
        self.node.nmt.state = "OPERATIONAL"
        self.node.setup_402_state_machine()

    def set_target(self, mdeg):
        # Its RPDO 1 contains the controlword and the target.
        self.node.rpdo[1][0x607A].raw = mdeg

    def test_cyclic_positions_are_followed(self):
        self.enable("CYCLIC SYNCHRONOUS POSITION")
        for target in range(0, 20_001, 1_000):
            self.node.sdo[0x607A].raw = target
            time.sleep(0.02)
        self.wait_for(lambda: self.node.sdo[0x6064].raw == 20_000, "the last target")

    def test_a_fault_is_reported_and_reset(self):
        self.enable("PROFILED VELOCITY")
        self.node.sdo[0x2007].raw = 0x2310
        self.wait_for(lambda: self.node.state == "FAULT", "fault")
        self.node.sdo[0x2007].raw = 0
        self.node.reset_from_fault()
        self.assertEqual(self.node.state, "OPERATION ENABLED", "reset_from_fault re-enables the drive")

    def test_limits_are_write_protected_while_enabled(self):
        self.enable("PROFILED POSITION")
        limit = struct.pack("<i", 70_000)
        self.aborts(0x0800_0022, self.node.sdo.download, 0x607D, 2, limit)
        self.node.state = "SWITCH ON DISABLED"
        self.node.sdo.download(0x607D, 2, limit)


class Emergencies(Served):
    def test_errors_are_reported_recorded_and_reset(self):
        self.node.sdo[0x2007].raw = 0x8611
        self.wait_for(lambda: self.node.emcy.active, "emergency")
        [error] = self.node.emcy.active
        self.assertEqual((error.code, error.register), (0x8611, 0x21))
        self.assertEqual(self.node.sdo[0x1001].raw, 0x21)
        self.assertEqual(self.node.sdo[0x1003][1].raw, 0x8611)
        self.node.sdo[0x2007].raw = 0
        self.wait_for(lambda: not self.node.emcy.active, "error reset")
        self.assertEqual(self.node.sdo[0x1001].raw, 0)


class LayerSettings(Served):
    node_id = 255

    def test_fast_scan_finds_the_node_and_assigns_a_node_id(self):
        found, identity = self.network.lss.fast_scan()
        self.assertTrue(found)
        self.assertEqual(identity, [0x1234, 0x5341, 0x0001_0000, 0xCAFE_F00D])
        self.assertEqual(self.network.lss.inquire_node_id(), 255)
        self.network.lss.configure_node_id(5)
        self.network.lss.store_configuration()
        waiting = self.network.lss.WAITING_STATE
        self.reset(lambda: self.network.lss.send_switch_state_global(waiting))
        self.assertEqual(self.node.sdo[0x1008].raw, "CANOPEN-EXAMPLE")

    def test_selection_by_identity(self):
        lss = self.network.lss
        self.assertTrue(lss.send_switch_state_selective(0x1234, 0x5341, 0x0001_0000, 0xCAFE_F00D))
        self.assertEqual(lss.inquire_lss_address(0x5D), 0xCAFE_F00D)
        with self.assertRaises(LssError):
            lss.configure_bit_timing(9)
        lss.configure_bit_timing(2)


if __name__ == "__main__":
    logging.getLogger("canopen").setLevel(logging.CRITICAL)
    unittest.main()
