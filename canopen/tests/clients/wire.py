"""CAN frames over slcan and an SDO client that transmits arbitrary requests. It is written from the standard alone and shares no
code with the server or with the masters that are tested against it.
"""
import collections
import re
import socket
import struct
import subprocess
import time
import unittest

Frame = collections.namedtuple("Frame", "identifier data extended remote")


class Aborted(Exception):
    def __init__(self, code):
        super().__init__(f"aborted with {code:08X}h")
        self.code = code


class NoResponse(Exception):
    """No frame was received in time."""


class Wire:
    """The CAN bus of an slcan server on loopback TCP."""

    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port))
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.rest, self.frames = b"", collections.deque()
        self.socket.sendall(b"C\rS8\rO\r")

    def close(self):
        self.socket.close()

    def send(self, identifier, data=b"", extended=False, remote=False, length=None):
        head = f"{identifier:08X}" if extended else f"{identifier:03X}"
        kind = ("R" if extended else "r") if remote else ("T" if extended else "t")
        body = "" if remote else bytes(data).hex().upper()
        self.socket.sendall(f"{kind}{head}{len(data) if length is None else length:X}{body}\r".encode())

    def _fill(self, until):
        left = until - time.monotonic()
        if left <= 0:
            return False
        self.socket.settimeout(left)
        try:
            self.rest += self.socket.recv(65536)
        except TimeoutError:
            return False
        *lines, self.rest = self.rest.replace(b"\a", b"\r").split(b"\r")
        for line in map(bytes.decode, lines):
            if line[:1] in "tTrR" and line:
                extended, remote = line[0] in "TR", line[0] in "rR"
                digits = 8 if extended else 3
                data = bytes() if remote else bytes.fromhex(line[digits + 2:digits + 2 + 2 * int(line[digits + 1])])
                self.frames.append(Frame(int(line[1:digits + 1], 16), data, extended, remote))
        return True

    def receive(self, matches, seconds):
        """The first matching frame; earlier frames are discarded."""
        until = time.monotonic() + seconds
        while True:
            while self.frames:
                frame = self.frames.popleft()
                if matches(frame):
                    return frame
            if not self._fill(until):
                raise NoResponse

    def receive_all(self, matches, seconds):
        """All matching frames since the last received one and during the next `seconds`."""
        until = time.monotonic() + seconds
        while self._fill(until):
            pass
        received = [frame for frame in self.frames if matches(frame)]
        self.frames.clear()
        return received

    def discard(self):
        """Discards all frames received so far."""
        while self._fill(time.monotonic() + 0.001):
            pass
        self.frames.clear()


class Sdo:
    """SDO client of one server."""

    def __init__(self, wire, node, timeout):
        self.wire, self.node, self.timeout = wire, node, timeout

    def send(self, data):
        self.wire.send(0x600 + self.node, bytes(data).ljust(8, b"\0"))

    def response(self, seconds=None):
        """The next response of the server; raises an abort."""
        frame = self.wire.receive(lambda frame: frame.identifier == 0x580 + self.node, seconds or self.timeout)
        assert len(frame.data) == 8 and not frame.extended, frame
        if frame.data[0] == 0x80:
            raise Aborted(struct.unpack_from("<I", frame.data, 4)[0])
        return frame.data

    def request(self, data):
        self.send(data)
        return self.response()

    def upload(self, index, sub):
        first = self.request(struct.pack("<BHB", 0x40, index, sub))
        assert first[1:4] == struct.pack("<HB", index, sub), first
        if first[0] & 2:
            return first[4:8 - (first[0] >> 2 & 3 if first[0] & 1 else 0)]
        assert first[0] == 0x41, first
        size, data, toggle = struct.unpack_from("<I", first, 4)[0], b"", 0
        while True:
            segment = self.request([0x60 | toggle])
            assert segment[0] & 0xF0 == toggle, segment
            data += segment[1:8 - (segment[0] >> 1 & 7)]
            toggle ^= 0x10
            if segment[0] & 1:
                assert len(data) == size, (len(data), size)
                return data

    def download(self, index, sub, data):
        if 1 <= len(data) <= 4:
            first = struct.pack("<BHB", 0x23 | (4 - len(data)) << 2, index, sub)
            assert self.request(first + data)[:4] == struct.pack("<BHB", 0x60, index, sub)
            return
        assert self.request(struct.pack("<BHBI", 0x21, index, sub, len(data)))[0] == 0x60
        toggle = 0
        for at in range(0, max(len(data), 1), 7):
            part, last = data[at:at + 7], at + 7 >= len(data)
            answer = self.request(bytes([toggle | (7 - len(part)) << 1 | last]) + part)
            assert answer[0] == 0x20 | toggle, answer
            toggle ^= 0x10


def boards(arguments):
    """Removes `--elf ACTUATOR_BOARD COMM_BOARD` from a command line; returns the server's arguments for it."""
    if "--elf" not in arguments:
        return []
    at = arguments.index("--elf")
    _, actuator, communication = arguments[at:at + 3]
    del arguments[at:at + 3]
    return ["--elf", actuator, "--comm-elf", communication]


class Bench(unittest.TestCase):
    """Node 1 of a server shared by all tests of the class: native, or both programs on emulated boards."""

    program = None
    elf = []
    node = 1

    @classmethod
    def setUpClass(cls):
        command = [cls.program, "serve", "--listen", "127.0.0.1:0", "--nodes", "1", *cls.elf]
        cls.server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        cls.addClassCleanup(cls.stop)
        cls.port = int(re.search(r"127\.0\.0\.1:(\d+)", cls.server.stdout.readline())[1])
        cls.wire = Wire(cls.port)
        cls.addClassCleanup(cls.wire.close)
        # A busy computer may emulate more slowly than real time.
        cls.sdo = Sdo(cls.wire, cls.node, timeout=8 if cls.elf else 2)
        # While the serial line is closed no node acknowledges the boot-up of a board, which records
        # this error.
        cls.sdo.download(0x1003, 0, b"\0")

    @classmethod
    def stop(cls):
        cls.server.kill()
        cls.server.wait()
        cls.server.stdout.close()

    def refusal(self, action, *arguments):
        """The abort code, or None."""
        try:
            action(*arguments)
        except Aborted as aborted:
            return aborted.code
        return None

    def expect_frame(self, identifier, data):
        """Waits for this frame."""
        self.wire.receive(lambda frame: (frame.identifier, frame.data) == (identifier, bytes(data)), self.sdo.timeout)
