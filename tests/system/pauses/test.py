import os
import random
import re
import signal
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import networks
import takt_system
from takt_system import wait_until

PAUSES = takt_system.how_much("TAKT_PAUSES", 2, 100)
LONGEST = takt_system.how_much("TAKT_LONGEST_PAUSE", 5.0, 20.0)
VICTIMS = (["robot"], ["line"], ["robot", "line"], ["watch"])


class Pauses(networks.NetworkCase):
    MACHINES = ("robot", "line")

    def begin(self, cell):
        self.running = self.nodes("robot", "line")
        self.agreed(lambda: self.takt("deploy", cell))
        self.watch = self.start("watch")

    def samples(self):
        """Returns the number of samples at each port. Returns None unless both devices run, each module is in EXECUTING, and each port is
        connected."""
        devices = self.status()
        if set(devices) != {"robot", "line"} or not all(device["alive"] for device in devices.values()):
            return None
        modules = [(name, module) for name, device in devices.items() for module in device["modules"]]
        ports = [(name, module["name"], port) for name, module in modules for port in module["ports"]]
        if any(module["state"] != "EXECUTING" for _, module in modules) or any(port["matched"] != 1 for _, _, port in ports):
            return None
        return {(name, module, port["name"]): port["samples"] for name, module, port in ports}

    def is_whole(self):
        before = self.samples()
        after = before and self.samples()
        return after and all(after[port] > count for port, count in before.items())

    def is_shown(self):
        states = {}
        for _, line in list(self.watch.out_lines):
            if match := re.match(r"\S+ (robot|line): (\w+)", line):
                states[match[1]] = match[2]
        return states == {"robot": "running", "line": "running"}

    def pause(self, chance):
        victims = chance.choice(VICTIMS)
        pids = [self.watch.pid if victim == "watch" else self.running[victim].one("takt-node").pid for victim in victims]
        for pid in pids:
            os.kill(pid, signal.SIGSTOP)
        time.sleep(chance.uniform(2.0, LONGEST))
        for pid in pids:
            os.kill(pid, signal.SIGCONT)
        begin = time.monotonic()
        wait_until(self.is_whole, "both devices to exchange samples after a pause of %s" % " and ".join(victims))
        wait_until(self.is_shown, "takt watch to show both devices after a pause of %s" % " and ".join(victims))
        return time.monotonic() - begin

    def check(self, cell):
        self.begin(cell)
        wait_until(lambda: self.is_whole() and self.is_shown(), "the cell to run")
        seed = random.randrange(1000)
        print("seed %d" % seed)
        chance = random.Random(seed)
        print("%d pauses; whole again after at most %.1f s" % (PAUSES, max(self.pause(chance) for _ in range(PAUSES))))
        self.end(self.running)
        self.watch.signal(signal.SIGINT)
        self.assertEqual(0, self.watch.wait().status, self.watch.err)

    def test_a_cell_is_whole_again_after_its_nodes_were_paused(self):
        self.check("cell.xml")

    def test_a_secured_cell_is_whole_again_after_its_nodes_were_paused(self):
        with open(self.beside("cell.xml")) as cell:
            secured = self.write("secured.xml", cell.read().replace(' domain="0"', ' domain="0" security="required"'))
        keys = os.path.join(self.folder, "keys")
        run = self.takt("secure", "init", secured, keys, "--operator", "anna")
        self.assertEqual(0, run.status, run.err)
        os.environ["TAKT_SECURITY"] = keys
        self.addCleanup(os.environ.pop, "TAKT_SECURITY")
        self.check(secured)


if __name__ == "__main__":
    takt_system.main()
