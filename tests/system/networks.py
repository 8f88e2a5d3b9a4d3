"""Simulates several machines on one machine: each is a network namespace, and a bridge connects them. The bridge has its own namespace, so
that the tests do not touch the real network. This needs root and iproute2."""

import os
import shutil
import subprocess
import sys
import uuid

import takt_system


def available():
    """Returns an empty string if this process can create network namespaces, and otherwise the reason why it cannot."""
    if os.geteuid() != 0:
        return "network namespaces need root"
    if shutil.which("ip") is None:
        return "ip (iproute2) is not installed"
    probe = "takt-probe-%d" % os.getpid()
    made = subprocess.run(["ip", "netns", "add", probe], capture_output=True, text=True)
    if made.returncode != 0:
        return "no network namespace can be made here: " + made.stderr.strip()
    subprocess.run(["ip", "netns", "del", probe], check=True)
    return ""


class Networks:
    """A network of simulated machines: with Networks("robot", "line", "operator") as net. A command that begins with net.on("robot") runs
    on machine robot."""

    def __init__(self, *machines):
        self.mark = "t" + uuid.uuid4().hex[:6]
        self.machines = machines
        self._bridge = self.mark + "-bridge"
        self._switch = None
        self._links = {}

    def __enter__(self):
        try:
            self._ip("netns", "add", self._bridge)
            self._in_bridge("link", "set", "lo", "up")
            self._in_bridge("link", "add", "br0", "type", "bridge", "mcast_snooping", "0")
            self._in_bridge("link", "set", "br0", "up")
            for machine in self.machines:
                self._ip("netns", "add", self._space(machine))
                self._in(machine, "link", "set", "lo", "up")
                self.create(machine)
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        if self._switch is not None:
            self._switch.kill()
            self._switch.wait()
            self._switch.stdin.close()
        for machine in list(self._links):
            self._end_link(machine)
        for space in [self._space(m) for m in self.machines] + [self._bridge]:
            subprocess.run(["ip", "netns", "del", space], capture_output=True)
        for machine in self.machines:
            shutil.rmtree(self._files(machine), ignore_errors=True)

    def number(self, machine):
        """Returns the last number of the address that the machine has at first."""
        return self.machines.index(machine) + 1

    def address(self, machine):
        return "10.77.0.%d" % self.number(machine)

    def on(self, machine):
        return ["ip", "netns", "exec", self._space(machine)]

    def create(self, machine):
        """Creates the network interface of the machine."""
        self._ip("link", "add", self._cable(machine), "netns", self._bridge, "type", "veth",
                 "peer", "name", "eth0", "netns", self._space(machine))
        self._in_bridge("link", "set", self._cable(machine), "master", "br0")
        self._in_bridge("link", "set", self._cable(machine), "up")
        self._in(machine, "addr", "add", "%s/24" % self.address(machine), "dev", "eth0")
        self.turn(machine, "up")

    def remove(self, machine):
        self._in(machine, "link", "del", "eth0")

    def turn(self, machine, state):
        """Turns the network interface of the machine "up" or "down"."""
        self._in(machine, "link", "set", "eth0", state)

    def set_address(self, machine, number):
        """Gives the machine another address, with this last number, or none."""
        self._in(machine, "addr", "flush", "dev", "eth0")
        if number is not None:
            self._in(machine, "addr", "add", "10.77.0.%d/24" % number, "dev", "eth0")

    def set_host_names(self, **numbers):
        """Makes these names known on all machines, and no others: the machine robot=7 has the address 10.77.0.7. The first call must come
        before the programs that use names."""
        for machine in self.machines:
            os.makedirs(self._files(machine), exist_ok=True)
            # Running programs see changes of these files, but not new files in their place.
            with open(self._files(machine) + "/nsswitch.conf", "w") as file:
                file.write("hosts: files\n")
            with open(self._files(machine) + "/hosts", "w") as file:
                file.write("".join("10.77.0.%d %s\n" % (number, name) for name, number in numbers.items()))

    def lose_route(self, machine):
        self._in(machine, "route", "del", "10.77.0.0/24", "dev", "eth0")

    def add_route(self, machine):
        self._in(machine, "route", "add", "10.77.0.0/24", "dev", "eth0")

    def cut(self, machine):
        """Disconnects the network cable of the machine."""
        self._in_bridge("link", "set", self._cable(machine), "down")

    def join(self, machine):
        self._in_bridge("link", "set", self._cable(machine), "up")

    def drop(self, machine):
        """Makes the switch drop all packets from and to the machine, while all interfaces stay up. pass_on() undoes this at once."""
        self._port(machine, 0)

    def pass_on(self, machine):
        self._port(machine, 3)

    def _port(self, machine, state):
        if self._switch is None:  # one process makes all changes, because starting one per change takes too long
            self._switch = subprocess.Popen(["ip", "netns", "exec", self._bridge, "bridge", "-batch", "-"], stdin=subprocess.PIPE,
                                            text=True, bufsize=1)
        self._switch.stdin.write("link set dev %s state %d\n" % (self._cable(machine), state))

    def lose_packets(self, sender, receiver):
        """Loses all unicast packets from one machine to another, but not those in the opposite direction."""
        self._ip("-n", self._space(sender), "neigh", "replace", self.address(receiver), "lladdr", "02:00:00:00:00:01", "dev", "eth0",
                 "nud", "permanent")

    def impair(self, machine, loss=0.0, delay=0.0, rate=0, first=0):
        """From now on, the cable of the machine loses this fraction of all packets in each direction, delays them by so many seconds, and
        carries so many bits per second (0: no limit). It also loses the first copies of each message that announces a reader or writer."""
        link = "li%d" % (self.machines.index(machine) + 1)
        if machine in self._links:
            self._end_link(machine)
        else:
            self._in_bridge("link", "set", self._cable(machine), "nomaster")
            self._in_bridge("link", "add", link, "type", "veth", "peer", "name", link + "b")
            self._in_bridge("link", "set", link + "b", "master", "br0", "up")
            self._in_bridge("link", "set", link, "up")
        program = os.path.join(os.path.dirname(os.path.abspath(__file__)), "poor_link.py")
        run = subprocess.Popen(["ip", "netns", "exec", self._bridge, sys.executable, "-B", program, self._cable(machine), link, str(loss),
                                str(delay), str(rate), str(first)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1)
        self._links[machine] = run
        if run.stdout.readline() != "ready\n":
            raise RuntimeError("poor_link.py could not be started")

    def carried(self, machine):
        """Returns how many bytes the impaired cable has carried from the machine and to it, and how many packets were lost."""
        run = self._links[machine]
        run.stdin.write("\n")
        return tuple(int(each) for each in run.stdout.readline().split())

    def _end_link(self, machine):
        run = self._links.pop(machine)
        run.kill()
        run.wait()
        run.stdin.close()
        run.stdout.close()

    def limit(self, machine, mtu):
        """Loses all IP packets from and to the machine that are longer than this, without a notice to their sender, as many VPNs and
        firewalls do. The machine does not know of the limit: it splits a long message into fragments that are too long, too."""
        # A bridge port drops longer packets, but it allows 4 bytes more than its MTU, for a VLAN tag.
        self._in_bridge("link", "set", self._cable(machine), "mtu", str(mtu - 4))

    def lost(self, machine):
        """Returns how many packets of the machine were longer than limit() allows."""
        return self._count(self._bridge, self._cable(machine), "rx_dropped")

    @staticmethod
    def _count(space, interface, what):
        path = "/sys/class/net/%s/statistics/%s" % (interface, what)
        return int(subprocess.run(["ip", "netns", "exec", space, "cat", path], check=True, capture_output=True, text=True).stdout)

    def no_multicast(self):
        """Makes the bridge forward only unicast packets, as many managed switches do."""
        for machine in self.machines:
            self._run(["ip", "netns", "exec", self._bridge, "bridge", "link", "set", "dev", self._cable(machine),
                       "mcast_flood", "off"])

    def _space(self, machine):
        return "%s-%s" % (self.mark, machine)

    def _files(self, machine):
        """Returns the folder with the files that the programs on this machine see in /etc (ip-netns(8))."""
        return "/etc/netns/" + self._space(machine)

    def _cable(self, machine):
        return "ve%d" % (self.machines.index(machine) + 1)

    def _in(self, machine, *arguments):
        self._ip("-n", self._space(machine), *arguments)

    def _in_bridge(self, *arguments):
        self._ip("-n", self._bridge, *arguments)

    def _ip(self, *arguments):
        self._run(["ip", *arguments])

    @staticmethod
    def _run(command):
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            raise RuntimeError("%s: %s" % (" ".join(command), done.stderr.strip()))


class NetworkCase(takt_system.Case):
    """The base class of tests in which each node has its own machine. Commands run on an additional machine, "operator"."""
    MACHINES = ()  # all machines except "operator"; a test that leaves this empty calls lay() itself

    def setUp(self):
        super().setUp()
        self.domain = 0  # domain 0 is free, because no other test uses this network
        if self.MACHINES:
            self.lay(*self.MACHINES)

    def lay(self, *machines):
        reason = available()
        if reason:
            self.skipTest(reason)
        self.net = Networks(*machines, "operator")
        self.net.__enter__()
        self.addCleanup(self.net.__exit__)

    def program(self, name, *arguments, on="operator", environment=None, **options):
        # The program may use all network interfaces, not only loopback, because no other test uses this network.
        return super().program(name, *arguments, environment={"TAKT_INTERFACE": "", **(environment or {})},
                               before=self.net.on(on), **options)

    def node(self, device, *arguments, on=None, **options):
        """Starts a takt-node on the machine of the device, with a state folder of its own."""
        environment = {"TAKT_STATE_DIR": os.path.join(self.folder, device), **(options.pop("environment", None) or {})}
        return super().node(device, *arguments, on=on or device, environment=environment, **options)

    def operator(self, *arguments, **options):
        """Runs a command until it ends. Removes the run from self.runs, because a long test runs thousands of commands."""
        run = self.takt(*arguments, **options)
        self.runs.remove(run)
        return run

    def status(self):
        """Returns the status of each device, by name. The result is empty if no node answers."""
        run = self.operator("status", "--json")
        return {d["name"]: d for d in run.report["devices"]} if run.status == 0 else {}
