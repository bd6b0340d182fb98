"""A separate server for each test, and a python-canopen master over python-can's slcan driver."""
import re
import subprocess
import time
import unittest

import canopen
from canopen.sdo import SdoAbortedError


class Bench(unittest.TestCase):
    node_id = 5
    bitrate = 500_000
    # Response time-out, s.
    timeout = 2

    def command(self):
        """Command line of the server; its first output line contains the port on 127.0.0.1."""
        raise NotImplementedError

    @staticmethod
    def master():
        """The master's view of the node."""
        raise NotImplementedError

    def setUp(self):
        self.process = subprocess.Popen(self.command(), stdout=subprocess.PIPE, text=True)
        # Also runs if the rest of this method fails.
        self.addCleanup(self.stop)
        self.port = re.search(r"127\.0\.0\.1:(\d+)", self.process.stdout.readline())[1]
        self.frames = []
        self.network = self.connect()
        self.addCleanup(self.network.disconnect)
        self.node = self.network.add_node(self.master())
        self.network.subscribe(0x700 + self.node.id, lambda *frame: self.frames.append(frame))
        self.node.sdo.RESPONSE_TIMEOUT = self.timeout

    def connect(self):
        network = canopen.Network()
        network.NOTIFIER_CYCLE = 0.02
        network.connect(
            interface="slcan", channel=f"socket://127.0.0.1:{self.port}", bitrate=self.bitrate, sleep_after_open=0)
        return network

    def stop(self):
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()

    def reset(self, act=None):
        """Resets the node. The client's wait_for_bootup misses a boot-up received before its call."""
        boots = lambda: sum(data == b"\0" for _, data, _ in self.frames)
        before = boots()
        (act or (lambda: setattr(self.node.nmt, "state", "RESET")))()
        self.wait_for(lambda: boots() > before, "boot-up")

    def wait_for(self, condition, message):
        end = time.monotonic() + 2.5 * self.timeout
        while not condition():
            self.assertLess(time.monotonic(), end, message)
            time.sleep(0.002)

    def aborts(self, code, action, *arguments):
        with self.assertRaises(SdoAbortedError) as caught:
            action(*arguments)
        self.assertEqual(caught.exception.code, code)

    def triggers_at_every_other_sync(self, pdo):
        pdo.trans_type, pdo.event_timer, pdo.enabled = 2, 0, True
        pdo.save()
        self.node.nmt.state = "OPERATIONAL"
        seen = []
        pdo.add_callback(seen.append)
        for _ in range(6):
            self.network.sync.transmit()
            time.sleep(0.02)
        self.wait_for(lambda: len(seen) >= 3, "a frame at every other SYNC")
        time.sleep(0.02)
        self.assertEqual(len(seen), 3)


class DriveTests:
    """Tests of a drive with BaseNode402 as master; a mix-in for Bench."""

    # Tolerance of the position when the target is reached, mdeg.
    tolerance = 0

    def enable(self, mode):
        self.node.op_mode = mode
        # The client confirms the mode within 0.2 s, which a busy computer can exceed.
        self.wait_for(lambda: self.node.op_mode == mode, f"the mode {mode}")
        self.node.state = "OPERATION ENABLED"
        self.assertEqual(self.node.state, "OPERATION ENABLED")

    def set_target(self, mdeg):
        self.node.sdo[0x607A].raw = mdeg

    def angle_mdeg(self):
        return self.node.sdo[0x6064].raw

    def test_the_drive_reaches_operation_enabled_and_a_position(self):
        self.enable("PROFILED POSITION")
        self.set_target(30_000)
        self.node.controlword = 0x1F
        self.wait_for(lambda: self.node.statusword & 0x1000, "acknowledge")
        self.node.controlword = 0x0F
        self.wait_for(lambda: self.node.statusword & 0x0400, "target reached")
        self.assertAlmostEqual(self.angle_mdeg(), 30_000, delta=self.tolerance)
        self.node.state = "SWITCHED ON"
        self.assertEqual(self.node.state, "SWITCHED ON")
