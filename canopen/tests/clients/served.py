"""A server of its own for each test, and a master that python-canopen makes of python-can's slcan driver."""
import re
import subprocess
import time
import unittest

import canopen
from canopen.sdo import SdoAbortedError


class Bench(unittest.TestCase):
    node_id = 5

    def command(self):
        """What starts the server; its first line tells the port behind 127.0.0.1."""
        raise NotImplementedError

    @staticmethod
    def master():
        """The node as the master has it."""
        raise NotImplementedError

    def setUp(self):
        self.process = subprocess.Popen(self.command(), stdout=subprocess.PIPE, text=True)
        self.port = re.search(r"127\.0\.0\.1:(\d+)", self.process.stdout.readline())[1]
        self.frames = []
        self.network = self.connect()
        self.node = self.network.add_node(self.master())
        self.network.subscribe(0x700 + self.node.id, lambda *frame: self.frames.append(frame))
        self.node.sdo.RESPONSE_TIMEOUT = 2

    def connect(self):
        network = canopen.Network()
        network.NOTIFIER_CYCLE = 0.02
        network.connect(
            interface="slcan", channel=f"socket://127.0.0.1:{self.port}", bitrate=500_000, sleep_after_open=0)
        return network

    def tearDown(self):
        self.network.disconnect()
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()

    def reset(self, act=None):
        """Resets the node. The client's wait_for_bootup misses what came before it was called."""
        boots = lambda: sum(data == b"\0" for _, data, _ in self.frames)
        before = boots()
        (act or (lambda: setattr(self.node.nmt, "state", "RESET")))()
        self.wait_for(lambda: boots() > before, "boot-up")

    def wait_for(self, condition, message):
        end = time.monotonic() + 5
        while not condition():
            self.assertLess(time.monotonic(), end, message)
            time.sleep(0.002)

    def aborts(self, code, action, *arguments):
        with self.assertRaises(SdoAbortedError) as caught:
            action(*arguments)
        self.assertEqual(caught.exception.code, code)
