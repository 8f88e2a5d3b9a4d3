import os
import random
import signal
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import networks
import takt_system
from takt_system import wait_until

EVENTS = int(takt_system.how_much("TAKT_INTERFACE_EVENTS", 0, 200))
SEED = int(os.environ.get("TAKT_INTERFACE_SEED", "0")) or random.randrange(1, 1 << 30)

DEVICE = """
  <device name="%s">
    <module>
      <name>out</name>
      <filename>port_source.so</filename> <moduletype>thread</moduletype> <operationtype>periodic</operationtype>
      <period>20ms</period> <priority>1</priority>
    </module>
    <module>
      <name>in</name>
      <filename>port_sink.so</filename> <moduletype>thread</moduletype> <operationtype>periodic</operationtype>
      <period>20ms</period> <priority>2</priority>
    </module>
  </device>"""
CONNECTION = """
  <connection from="%s.out.out" to="%s.in.in" kind="queue" depth="64"/>"""


def cell(devices, attributes=""):
    ring = zip(devices, devices[1:] + devices[:1])
    return '<cell name="ring"%s>%s%s\n</cell>\n' % (attributes, "".join(DEVICE % d for d in devices), "".join(CONNECTION % c for c in ring))


class Ring(networks.NetworkCase):
    def setUp(self):
        super().setUp()
        self.random = random.Random(SEED)
        self.hosts = {}
        self.free = list(range(100, 200))  # the last numbers of addresses that no machine has had yet

    def begin(self, *devices, attributes=""):
        self.lay(*devices)
        self.devices = devices
        path = self.write("ring.xml", cell(devices, attributes))
        self.prepare(path)
        self.running = {device: self.node(device, **self.options(device)) for device in devices}
        self.started()
        self.agreed(lambda: self.operator("deploy", path))
        self.wait_until_samples_arrive("the deployment")
        self.processes = {device: self.pids(device) for device in devices}

    def prepare(self, path):
        """Prepares the nodes and the operator."""

    def options(self, device):
        return {}

    def started(self):
        """Is called when all nodes have been started, before the deployment."""

    def pids(self, device):
        return sorted(process.pid for process in self.running[device].processes())

    def received(self):
        """Returns how many samples each device has received; nothing if one does not answer."""
        status = self.status()
        if set(status) != set(self.devices) or not all(status[device]["alive"] for device in self.devices):
            return None
        return [port["samples"] for device in self.devices for m in status[device]["modules"] if m["name"] == "in" for port in m["ports"]]

    def wait_until_samples_arrive(self, event):
        begin = time.monotonic()
        before = wait_until(self.received, "all devices after " + event)
        wait_until(lambda: (now := self.received()) and all(b < n for b, n in zip(before, now)), "samples on each connection after " + event)
        takt_system.progress("%s: samples arrive everywhere after %.1f s" % (event, time.monotonic() - begin))

    def command_here(self, machine):
        """Stops and starts a module by commands on the machine of its device."""
        for command in ("stop", "start"):
            run = self.operator(command, machine + ".in", on=machine)
            self.assertEqual(0, run.status, (machine, command, run.err))

    # Each of these functions causes one event. After the event, the machine has an address and a way to the others.

    def change_address(self, machine):
        self.net.set_address(machine, self.free.pop(0))

    def create_again(self, machine):
        self.net.remove(machine)
        self.command_here(machine)
        self.net.create(machine)

    def lose_address(self, machine):
        self.net.set_address(machine, None)
        self.command_here(machine)
        self.net.set_address(machine, self.free.pop(0) if self.random.random() < 0.5 else self.net.number(machine))

    def turn_off(self, machine):
        self.net.turn(machine, "down")
        self.command_here(machine)
        self.net.turn(machine, "up")

    def pull_cable(self, machine):
        self.net.cut(machine)
        self.command_here(machine)
        self.net.join(machine)

    def lose_route(self, machine):
        self.net.lose_route(machine)
        self.command_here(machine)
        self.net.add_route(machine)

    def pause(self, machine):
        node = self.running[machine].one("takt-node").pid
        os.kill(node, signal.SIGSTOP)
        time.sleep(self.random.uniform(0.5, 6))
        os.kill(node, signal.SIGCONT)

    def happen(self, event, machine):
        event(machine)
        self.wait_until_samples_arrive("%s of %s" % (event.__name__, machine))
        self.command_here(machine)
        for device in self.devices:
            self.assertEqual(self.processes[device], self.pids(device), "%s must not be restarted" % device)


class Open(Ring):
    def test_a_cell_goes_on_after_its_network_interfaces_have_changed(self):
        self.begin("north", "east", *(("south", "west") if EVENTS else ()))
        print("seed %d" % SEED)
        events = [self.change_address, self.create_again, self.lose_address, self.turn_off, self.pull_cable, self.lose_route, self.pause]
        for number, event in enumerate(self.random.choices(events, k=EVENTS) if EVENTS else events):
            takt_system.progress("event %d: %s" % (number, event.__name__))
            self.happen(event, self.random.choice(self.devices))


class Secured(Ring):
    """The same in a cell with DDS Security, where the participants must authenticate each other again."""

    def prepare(self, path):
        run = self.takt("secure", "init", path, "keys", "--operator", "anna", on="operator")
        self.assertEqual(0, run.status, run.err)

    def options(self, device):
        return {"environment": {"TAKT_SECURITY": os.path.join(self.folder, "keys", "devices", device)}}

    def program(self, name, *arguments, environment=None, **options):
        identity = os.path.join(self.folder, "keys", "operators", "anna")
        return super().program(name, *arguments, environment={"TAKT_SECURITY": identity, **(environment or {})}, **options)

    def test_a_secured_cell_goes_on_after_its_network_interfaces_have_changed(self):
        self.begin("north", "east", attributes=' security="required"')
        for event in (self.change_address, self.create_again, self.lose_address):
            self.happen(event, "east")


class Named(Ring):
    """The devices find each other by their host names, without multicast."""
    PEERS = ("--peers", "north,east")

    def node(self, device, *arguments, **options):
        return super().node(device, *self.PEERS, *arguments, **options)

    def operator(self, *arguments, **options):
        return super().operator(*arguments, *self.PEERS, **options)

    def prepare(self, path):
        self.net.set_host_names()

    def started(self):
        for node in self.running.values():
            for peer in self.devices:
                node.wait_for_line("warning: peer '%s' cannot be resolved yet: .*; trying again" % peer)
        self.net.set_host_names(north=1, east=2)

    def test_devices_find_each_other_when_their_host_names_are_known_and_when_their_addresses_have_changed(self):
        self.begin("north", "east")
        # Each device only knows the old address of the other.
        self.net.set_address("north", 101)
        self.net.set_address("east", 102)
        self.net.set_host_names(north=101, east=102)
        self.wait_until_samples_arrive("the change of both addresses")
        for node in self.running.values():
            self.assertEqual(2, node.err.count("cannot be resolved"), "one warning for each name")


if __name__ == "__main__":
    takt_system.main()
