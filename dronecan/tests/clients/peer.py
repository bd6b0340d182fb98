#!/usr/bin/env python3
"""pip `dronecan`, unmodified, with actuators of `actuator serve --protocol dronecan`: natively, by UDP
multicast, and on emulated boards."""
import math
import os
import subprocess
import sys
import tempfile
import time
import unittest

import dronecan
from dronecan import uavcan
from dronecan.app.dynamic_node_id import CentralizedServer
from dronecan.app.file_server import FileServer
from dronecan.app.node_monitor import NodeMonitor

PROGRAM, BOARDS = os.path.abspath(sys.argv.pop(1)), os.path.abspath(sys.argv.pop(1))
OWN_ID = 100
Command = uavcan.equipment.actuator.Command
ArrayCommand = uavcan.equipment.actuator.ArrayCommand
GetSet = uavcan.protocol.param.GetSet
Opcode = uavcan.protocol.param.ExecuteOpcode


class Bench(unittest.TestCase):
    """Actuators, and a node that allocates their node-IDs."""

    count = 1
    options = []

    def setUp(self):
        command = [PROGRAM, "serve", "--protocol", "dronecan", "--nodes", str(self.count), *self.options]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        self.addCleanup(self.process.stdout.close)
        self.addCleanup(self.process.wait)
        self.addCleanup(self.process.terminate)
        line = self.process.stdout.readline()
        self.assertIn("ready: slcan at", line)
        self.connect(self.channel(line.split(" at ")[1].split(",")[0]))

    def channel(self, address):
        return f"slcan:{address}"

    def connect(self, channel):
        self.node = dronecan.make_node(channel, node_id=OWN_ID, bitrate=1_000_000)
        self.addCleanup(self.node.close)
        self.node.mode = uavcan.protocol.NodeStatus().MODE_OPERATIONAL
        self.monitor = NodeMonitor(self.node)
        self.allocator = CentralizedServer(self.node, self.monitor)
        self.statuses, self.logs = {}, []
        self.circuits, self.temperatures = {}, {}
        self.node.add_handler(uavcan.equipment.actuator.Status, self.on_status)
        self.node.add_handler(uavcan.equipment.power.CircuitStatus, self.by_id(self.circuits, "circuit_id"))
        self.node.add_handler(uavcan.equipment.device.Temperature, self.by_id(self.temperatures, "device_id"))
        self.node.add_handler(uavcan.protocol.debug.LogMessage, lambda event: self.logs.append(str(event.message.text)))
        self.spin_until(lambda: len(self.statuses) == self.count, "node-IDs", 20)

    def by_id(self, store, field):
        return lambda event: store.__setitem__(getattr(event.message, field), event.message)

    def on_status(self, event):
        status = event.message
        self.statuses.setdefault(status.actuator_id, []).append((time.monotonic(), status))
        self.nodes = getattr(self, "nodes", {})
        self.nodes[status.actuator_id] = event.transfer.source_node_id

    def spin(self, seconds):
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            self.node.spin(min(left, 0.01))

    def spin_until(self, condition, message, seconds=5):
        end = time.monotonic() + seconds
        while not condition():
            self.assertLess(time.monotonic(), end, message)
            self.node.spin(0.005)

    def request(self, request, actuator=1, seconds=2):
        responses = []
        self.node.request(request, self.nodes[actuator], responses.append, timeout=seconds)
        self.spin_until(lambda: responses, f"a response to {request}", seconds + 1)
        self.assertIsNotNone(responses[0], f"no response to {request}")
        return responses[0].response

    def send(self, kind, value, actuator=1):
        command = Command(actuator_id=actuator, command_type=kind, command_value=value)
        self.node.broadcast(ArrayCommand(commands=[command]))

    def command(self, kind, value, seconds, rate_hz=50, actuator=1):
        """Commands a value, or a function of time, at a rate."""
        start = time.monotonic()
        for number in range(round(seconds * rate_hz)):
            self.spin(start + number / rate_hz - time.monotonic())
            at = number / rate_hz
            self.send(kind, value(at) if callable(value) else value, actuator)
        self.spin(0.05)

    def move(self, kind, value):
        """Commands an angle until the shaft rests, also where the time of the emulator is behind."""
        self.command(kind, value, 3)

    def last(self, actuator=1):
        return self.statuses[actuator][-1][1]

    def status(self, actuator=1):
        """The last node status. A node whose statuses are late is forgotten until the next one."""
        node = self.nodes[actuator]
        self.spin_until(lambda: self.monitor.exists(node), "a node status")
        return self.monitor.get(node).status

    def health(self, actuator=1):
        return self.status(actuator).health

    def parameter(self, name, value=None, kind="integer_value"):
        request = GetSet.Request(name=name)
        if value is not None:
            request.value = uavcan.protocol.param.Value(**{kind: value})
        response = self.request(request)
        field = dronecan.get_active_union_field(response.value)
        return getattr(response.value, field), response

    def restart(self):
        request = uavcan.protocol.RestartNode.Request(magic_number=uavcan.protocol.RestartNode.Request().MAGIC_NUMBER)
        requests = []

        def on_allocation(event):
            # Without a node-ID of its own a node is 0.
            if event.transfer.source_node_id == 0:
                requests.append(event)

        # The actuators have their node-IDs: only one that has restarted requests one. What it has sent before the
        # restart may follow the response.
        handle = self.node.add_handler(uavcan.protocol.dynamic_node_id.Allocation, on_allocation)
        self.assertTrue(self.request(request).ok)
        self.spin_until(lambda: requests, "a request for a node-ID after the restart", 15)
        handle.remove()
        self.statuses.clear()
        self.spin_until(lambda: self.statuses.get(1), "a status after the restart", 15)


class Contract:
    """What natively run actuators and boards do alike."""

    count = 3

    def status_rate(self):
        """Statuses of actuator 1 in a second of its own time: an emulated board may be slower than this
        machine's clock."""
        seconds = []

        def on_node_status(event):
            if event.transfer.source_node_id == self.nodes[1]:
                seconds.append((event.message.uptime_sec, len(self.statuses[1])))

        handle = self.node.add_handler(uavcan.protocol.NodeStatus, on_node_status)
        self.spin_until(lambda: len(seconds) == 4, "four seconds of the node", 20)
        handle.remove()
        (start, before), (end, after) = seconds[0], seconds[-1]
        return (after - before) / (end - start)

    def test_nodes_get_ids_of_their_own_and_say_what_they_are(self):
        self.assertEqual(sorted(self.nodes), [1, 2, 3])
        self.assertEqual(len(set(self.nodes.values())), 3)
        uids = set()
        for actuator in self.nodes:
            info = self.request(uavcan.protocol.GetNodeInfo.Request(), actuator)
            self.assertEqual(str(info.name), "org.smart-actuator")
            uids.add(bytes(info.hardware_version.unique_id))
        self.assertEqual(len(uids), 3)
        self.assertAlmostEqual(self.status_rate(), 50, delta=2)
        self.assertTrue(all(abs(self.circuits[n].voltage - 6) < 0.1 for n in self.nodes))
        self.assertTrue(all(280 < self.temperatures[n].temperature < 320 for n in self.nodes))

    def test_parameters_are_listed_and_checked(self):
        names = []
        while str(response := self.request(GetSet.Request(index=len(names)))) and len(response.name):
            names.append(str(response.name))
        self.assertEqual(len(names), len(set(names)))
        self.assertGreater(len(names), 100)
        value, described = self.parameter("stall_ms")
        self.assertEqual((value, described.default_value.integer_value), (500, 500))
        self.assertEqual((described.min_value.integer_value, described.max_value.integer_value), (20, 60000))
        self.assertEqual(self.parameter("stall_ms", 19)[0], 500)
        self.assertEqual(self.parameter("stall_ms", 600)[0], 600)
        gain, _ = self.parameter("position_gain", 9.5, "real_value")
        self.assertEqual(gain, 9.5)
        self.assertEqual(len(self.request(GetSet.Request(name="nonsense")).name), 0)
        self.assertTrue(self.request(Opcode.Request(opcode=Opcode.Request().OPCODE_SAVE)).ok)
        self.parameter("position_gain", 7.0, "real_value")
        self.restart()
        self.assertEqual([self.parameter(name)[0] for name in ("stall_ms", "position_gain")], [600, 9.5])
        self.assertTrue(self.request(Opcode.Request(opcode=Opcode.Request().OPCODE_ERASE)).ok)
        self.restart()
        self.assertEqual(self.parameter("stall_ms")[0], 500)

    def test_commands_of_each_kind_are_followed_and_released(self):
        kinds = Command()
        for kind, value, angle in [
            (kinds.COMMAND_TYPE_UNITLESS, 0.5, math.radians(30)),
            (kinds.COMMAND_TYPE_POSITION, -0.4, -0.4),
            (4, 1250, math.radians(-30)),
        ]:
            self.move(kind, value)
            self.assertAlmostEqual(self.last().position, angle, delta=0.01)
        self.command(kinds.COMMAND_TYPE_SPEED, 0.5, 1)
        self.assertAlmostEqual(self.last().speed, 0.5, delta=0.05)
        # Released: it stays where it is, whatever the value means as an angle.
        for kind, value in [(kinds.COMMAND_TYPE_UNITLESS, math.nan), (4, 0)]:
            self.move(kinds.COMMAND_TYPE_POSITION, 0.3)
            self.command(kind, value, 1)
            at = self.last().position
            self.command(kind, value, 0.5)
            self.assertAlmostEqual(at, 0.3, delta=0.02)
            self.assertAlmostEqual(self.last().position, at, delta=0.002)
        self.assertEqual(self.health(), 0)
        # Only the actuator that was commanded has moved.
        self.assertAlmostEqual(self.last(2).position, 0, delta=0.002)

    def test_commands_that_stay_away_are_a_fault_until_a_release(self):
        self.command(0, 0.2, 0.5)
        self.spin_until(lambda: self.health() == 2, "an error")
        self.assertTrue(any(text.startswith("fault ") for text in self.logs), self.logs)
        # Longer than the reaction to the fault, on a slow emulator too.
        self.command(0, math.nan, 2)
        self.spin_until(lambda: self.health() == 0, "health")
        self.move(0, 0.2)
        self.assertAlmostEqual(self.last().position, math.radians(12), delta=0.01)

    def test_a_restart_stops_first(self):
        self.command(Command().COMMAND_TYPE_SPEED, 2.0, 0.3)
        self.restart()
        self.spin(0.3)
        at = self.last().position
        self.spin(0.3)
        self.assertAlmostEqual(self.last().position, at, delta=0.002)


class Native(Contract, Bench):
    options = ["--pty"]

    def follow_a_sine(self, rate_hz):
        """Mean error, rad, rate of the statuses, Hz, and health with so many commands a second."""
        del self.statuses[1][:]
        start = time.monotonic()
        self.command(1, lambda at: 0.4 * math.sin(math.pi * at), 4, rate_hz)
        # The loop lags by 1/8 s, a command by its period.
        errors = [
            abs(status.position - 0.4 * math.sin(math.pi * (at - start - 1 / 8 - 0.03)))
            for at, status in self.statuses[1] if at - start > 1
        ]
        times = [at for at, _ in self.statuses[1]]
        statuses_hz = (len(times) - 1) / (times[-1] - times[0])
        return sum(errors) / len(errors), statuses_hz, self.health()

    def test_a_sine_is_followed_at_50_to_400_commands_a_second(self):
        for rate_hz in (50, 100, 200, 400):
            # On a busy computer commands come too late, which is a fault, or statuses do.
            for _ in range(3):
                error, statuses_hz, health = self.follow_a_sine(rate_hz)
                is_followed = error < 0.03 and abs(statuses_hz - 50) < 2 and health == 0
                if is_followed:
                    break
                self.command(0, math.nan, 2)
                self.spin_until(lambda: self.health() == 0, "health")
            self.assertTrue(is_followed, f"{rate_hz} Hz: {error} rad, {statuses_hz} Hz, {health}")

    def test_an_update_without_a_bootloader_is_refused(self):
        path = uavcan.protocol.file.Path(path="image")
        response = self.request(uavcan.protocol.file.BeginFirmwareUpdate.Request(image_file_remote_path=path))
        self.assertEqual((response.error, str(response.optional_error_message)), (1, "no bootloader, or busy"))


class Multicast(Bench):
    """As the simulator of ArduPilot has its buses."""

    options = ["--listen", "127.0.0.1:0", "--multicast", "7"]

    def channel(self, address):
        return "mcast:7"

    def test_a_node_is_found_and_commanded(self):
        self.command(0, 0.5, 1.5)
        self.assertAlmostEqual(self.last().position, math.radians(30), delta=0.01)


class Emulated(Contract, Bench):
    options = ["--pty", "--elf", f"{BOARDS}/actuator-board", "--comm-elf", f"{BOARDS}/comm-board"]


class Update(Bench):
    """A board with a bootloader."""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.options = [*Emulated.options, "--boot-elf", f"{BOARDS}/actuator-boot"]
        super().setUp()

    def test_an_image_is_read_from_this_node_and_runs(self):
        image = os.path.join(self.folder.name, "next.img")
        sign = [PROGRAM, "image", "sign", f"{BOARDS}/actuator-board", "--version", "9.8.7", "--out", image]
        subprocess.run(sign, check=True, stdout=subprocess.DEVNULL)
        FileServer(self.node, [self.folder.name])
        path = uavcan.protocol.file.Path(path="next.img")
        begin = uavcan.protocol.file.BeginFirmwareUpdate.Request(image_file_remote_path=path)
        self.assertEqual(self.request(begin).error, 0)
        self.assertEqual(self.request(begin).error, 2)
        updating = uavcan.protocol.NodeStatus().MODE_SOFTWARE_UPDATE
        self.spin_until(lambda: self.status().mode == updating, "the mode")
        self.spin_until(lambda: self.version() == (9, 8), "the version", 300)

    def version(self):
        self.spin(1)
        responses = []
        self.node.request(uavcan.protocol.GetNodeInfo.Request(), self.nodes[1], responses.append, timeout=1)
        self.spin_until(lambda: responses, "an end of the request")
        if responses[0] is None:
            return None
        software = responses[0].response.software_version
        return software.major, software.minor


if __name__ == "__main__":
    unittest.main(verbosity=2)
