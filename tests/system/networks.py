"""Machines of a cell on one machine: network namespaces joined by a bridge that lies in a namespace of its own, so that nothing
of it touches the network of whoever runs the test. Needs root and iproute2."""

import os
import shutil
import subprocess
import uuid


def available():
    """Why not, or an empty text."""
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
    """with Networks("robot", "line", "operator") as net: net.on("robot") goes before a command that is to run there."""

    def __init__(self, *machines):
        self.mark = "t" + uuid.uuid4().hex[:6]
        self.machines = machines
        self._bridge = self.mark + "-bridge"

    def __enter__(self):
        try:
            self._ip("netns", "add", self._bridge)
            self._in_bridge("link", "set", "lo", "up")
            self._in_bridge("link", "add", "br0", "type", "bridge", "mcast_snooping", "0")
            self._in_bridge("link", "set", "br0", "up")
            for number, machine in enumerate(self.machines, 1):
                space = self._space(machine)
                self._ip("netns", "add", space)
                self._ip("link", "add", self._cable(machine), "netns", self._bridge, "type", "veth",
                         "peer", "name", "eth0", "netns", space)
                self._in_bridge("link", "set", self._cable(machine), "master", "br0")
                self._in_bridge("link", "set", self._cable(machine), "up")
                self._ip("-n", space, "addr", "add", "%s/24" % self.address(machine), "dev", "eth0")
                self._ip("-n", space, "link", "set", "eth0", "up")
                self._ip("-n", space, "link", "set", "lo", "up")
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        for space in [self._space(m) for m in self.machines] + [self._bridge]:
            subprocess.run(["ip", "netns", "del", space], capture_output=True)

    def address(self, machine):
        return "10.77.0.%d" % (self.machines.index(machine) + 1)

    def on(self, machine):
        return ["ip", "netns", "exec", self._space(machine)]

    def cut(self, machine):
        """Pulls the machine's cable."""
        self._in_bridge("link", "set", self._cable(machine), "down")

    def join(self, machine):
        self._in_bridge("link", "set", self._cable(machine), "up")

    def no_multicast(self):
        """The bridge passes unicast only, as many a managed switch does."""
        for machine in self.machines:
            self._run(["ip", "netns", "exec", self._bridge, "bridge", "link", "set", "dev", self._cable(machine),
                       "mcast_flood", "off"])

    def _space(self, machine):
        return "%s-%s" % (self.mark, machine)

    def _cable(self, machine):
        return "ve%d" % (self.machines.index(machine) + 1)

    def _in_bridge(self, *arguments):
        self._ip("-n", self._bridge, *arguments)

    def _ip(self, *arguments):
        self._run(["ip", *arguments])

    @staticmethod
    def _run(command):
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            raise RuntimeError("%s: %s" % (" ".join(command), done.stderr.strip()))
