"""Frames of CAN over slcan, and an SDO client that says exactly what it is told to say: written from the standard alone, so
that it shares no view of CANopen with the server nor with the masters that run against it.
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


class Silent(Exception):
    """Nothing came in time."""


class Wire:
    """The bus behind an slcan server on loopback TCP."""

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

    def hear(self, wanted, seconds):
        """The first frame that is wanted; what came before it is forgotten."""
        until = time.monotonic() + seconds
        while True:
            while self.frames:
                frame = self.frames.popleft()
                if wanted(frame):
                    return frame
            if not self._fill(until):
                raise Silent

    def hear_all(self, wanted, seconds):
        """Every wanted frame since the last that was heard, and of the time to come."""
        until = time.monotonic() + seconds
        while self._fill(until):
            pass
        heard = [frame for frame in self.frames if wanted(frame)]
        self.frames.clear()
        return heard

    def forget(self):
        """Nothing that came before counts."""
        while self._fill(time.monotonic() + 0.001):
            pass
        self.frames.clear()


class Sdo:
    """The client of one server."""

    def __init__(self, wire, node, patience):
        self.wire, self.node, self.patience = wire, node, patience

    def say(self, data):
        self.wire.send(0x600 + self.node, bytes(data).ljust(8, b"\0"))

    def answer(self, seconds=None):
        """The next frame of the server; an abort is raised."""
        frame = self.wire.hear(lambda frame: frame.identifier == 0x580 + self.node, seconds or self.patience)
        assert len(frame.data) == 8 and not frame.extended, frame
        if frame.data[0] == 0x80:
            raise Aborted(struct.unpack_from("<I", frame.data, 4)[0])
        return frame.data

    def ask(self, data):
        self.say(data)
        return self.answer()

    def upload(self, index, sub):
        first = self.ask(struct.pack("<BHB", 0x40, index, sub))
        assert first[1:4] == struct.pack("<HB", index, sub), first
        if first[0] & 2:
            return first[4:8 - (first[0] >> 2 & 3 if first[0] & 1 else 0)]
        assert first[0] == 0x41, first
        size, data, toggle = struct.unpack_from("<I", first, 4)[0], b"", 0
        while True:
            segment = self.ask([0x60 | toggle])
            assert segment[0] & 0xF0 == toggle, segment
            data += segment[1:8 - (segment[0] >> 1 & 7)]
            toggle ^= 0x10
            if segment[0] & 1:
                assert len(data) == size, (len(data), size)
                return data

    def download(self, index, sub, data):
        if 1 <= len(data) <= 4:
            first = struct.pack("<BHB", 0x23 | (4 - len(data)) << 2, index, sub)
            assert self.ask(first + data)[:4] == struct.pack("<BHB", 0x60, index, sub)
            return
        assert self.ask(struct.pack("<BHBI", 0x21, index, sub, len(data)))[0] == 0x60
        toggle = 0
        for at in range(0, max(len(data), 1), 7):
            part, last = data[at:at + 7], at + 7 >= len(data)
            answer = self.ask(bytes([toggle | (7 - len(part)) << 1 | last]) + part)
            assert answer[0] == 0x20 | toggle, answer
            toggle ^= 0x10


def boards(arguments):
    """Takes `--elf ACTUATOR_BOARD COMM_BOARD` out of a command line: what the server is to be told of it."""
    if "--elf" not in arguments:
        return []
    at = arguments.index("--elf")
    _, actuator, communication = arguments[at:at + 3]
    del arguments[at:at + 3]
    return ["--elf", actuator, "--comm-elf", communication]


class Bench(unittest.TestCase):
    """Node 1 of a server that all tests of the class share: natively, or both programs on emulated boards."""

    program = None
    elf = []
    node = 1

    @classmethod
    def setUpClass(cls):
        command = [cls.program, "serve", "--listen", "127.0.0.1:0", "--nodes", "1", *cls.elf]
        cls.server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        cls.addClassCleanup(cls.stop)
        cls.wire = Wire(int(re.search(r"127\.0\.0\.1:(\d+)", cls.server.stdout.readline())[1]))
        cls.addClassCleanup(cls.wire.close)
        # A busy computer emulates slower than real time.
        cls.sdo = Sdo(cls.wire, cls.node, patience=8 if cls.elf else 2)
        # A board has nobody who acknowledges its boot-up as long as the serial line is closed, and keeps that error.
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

    def hear(self, identifier, data):
        """Waits for this frame."""
        self.wire.hear(lambda frame: (frame.identifier, frame.data) == (identifier, bytes(data)), self.sdo.patience)
