import json
import os
import random
import signal
import sys
import time
from collections import Counter

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import networks
import takt_system
from takt_system import wait_until
from wear import Wear

SECONDS = takt_system.how_much("TAKT_SOAK_SECONDS", 25.0, 1800.0)
SEED = int(os.environ.get("TAKT_SOAK_SEED", "0")) or random.randrange(1, 1 << 30)
DEVICES = ("left", "right")


class Soak(networks.NetworkCase):
    MACHINES = DEVICES

    def setUp(self):
        super().setUp()
        self.running = {}
        self.wear = {device: Wear(device) for device in DEVICES}
        self.done_so_far = Counter()

    def start_node(self, device):
        self.running[device] = self.node(device, "--resume")
        self.wear[device].begin()

    def node_pid(self, device):
        return self.running[device].one("takt-node").pid

    def wait_until_all_execute(self):
        def holds():
            status = self.status()
            states = {m["state"] for d in DEVICES for m in status.get(d, {}).get("modules", [])}
            return states == {"EXECUTING"} and all(status[d]["alive"] for d in DEVICES)
        wait_until(holds, "every module to execute after %s (seed %d)" % (dict(self.done_so_far), SEED))

    # Each of these functions causes one event. After the event, the cell returns to its normal state.

    def order(self):
        module = self.random.choice(("left.source", "left.near", "left.program", "right.far", "right.answers"))
        run = self.operator("stop", module)
        self.assertEqual(0, run.status, run.err)
        self.assertEqual(0, self.operator("start", module).status, module)

    def property(self):
        value = str(self.random.randrange(1, 5))
        self.assertEqual(0, self.operator("set", "right.answers", "burst", value).status)
        self.assertEqual(value, self.operator("get", "right.answers", "burst").out.strip())

    def kill_host(self):
        time.sleep(max(0.0, self.hosts_killed_at + 25 - time.monotonic()))  # if a host ended more often, Takt would give it up
        self.hosts_killed_at = time.monotonic()
        hosts = [p for p in self.running["left"].processes() if p.program == "takt-host"]
        os.kill(self.random.choice(hosts).pid, signal.SIGKILL)

    def kill_program(self):
        os.kill(self.running["left"].one("grid.exe").pid, signal.SIGKILL)

    def pull_cable(self):
        device = self.random.choice(DEVICES)
        self.net.cut(device)
        time.sleep(self.random.uniform(0.1, 2))
        self.net.join(device)

    def kill_node(self):
        device = self.random.choice(DEVICES)
        self.running[device].one("takt-node").kill()
        self.running[device].wait()
        self.start_node(device)

    def redeploy(self):
        self.take_down()
        self.measure()
        self.deploy()

    def deploy(self):
        self.agreed(lambda: self.operator("deploy", self.beside("cell.xml")))

    def take_down(self):
        left = wait_until(lambda: self.status().get("left"), "the status of left")
        self.crashes += sum(m["errors"] for m in left["modules"] if m["name"] == "crashes")
        run = self.operator("undeploy", "soak")
        self.assertEqual(0, run.status, run.err)

    def measure(self):
        """Measures the resources of each node while it waits for a deployment."""
        for device in DEVICES:
            wait_until(lambda d=device: not [p for p in self.running[d].processes() if p.program != "takt-node"],
                       "the host and programs of %s to end" % device)
            self.wear[device].look(self.node_pid(device), at_s=round(time.monotonic() - self.began, 1))

    def test_a_node_uses_no_more_resources_after_a_long_run_than_after_its_warm_up(self):
        self.random = random.Random(SEED)
        self.hosts_killed_at = 0.0
        self.crashes = 0
        before = set(os.listdir("/dev/shm"))
        for device in DEVICES:
            self.start_node(device)
        self.began = time.monotonic()
        self.deploy()
        # A new process starts a new series of measurements, so the test kills a node only rarely.
        events = [self.order] * 6 + [self.property] * 6 + [self.kill_host] * 1 + [self.kill_program] * 4 + \
            [self.pull_cable] * 3 + [self.redeploy] * 6
        # The first event of a kind takes memory that the next one uses again: the first fault trace 4 MB, for example. So each happens once
        # before the first measurement that counts.
        for event in (self.kill_host, self.kill_program, self.pull_cable, self.order, self.property, self.redeploy):
            self.wait_until_all_execute()
            self.done_so_far[event.__name__] += 1
            event()
        self.began = time.monotonic()
        while time.monotonic() - self.began < SECONDS:
            self.wait_until_all_execute()
            passed = time.monotonic() - self.began
            takt_system.progress("%.0f of %.0f s, %d events" % (passed, SECONDS, sum(self.done_so_far.values())))
            event = self.kill_node if self.random.random() < 0.01 else self.random.choice(events)
            self.done_so_far[event.__name__] += 1
            event()
        self.wait_until_all_execute()
        self.redeploy()
        self.take_down()
        self.measure()
        self.assertGreater(self.crashes, 0)
        # Files that existed before the test belong to other programs.
        new = {name for name in os.listdir("/dev/shm") if "takt" in name or "fast" in name} - before
        self.assertEqual(set(), new, "left in /dev/shm")

        figures = {"seed": SEED, "seconds": round(time.monotonic() - self.began), "events": dict(self.done_so_far),
                   "nodes": {device: wear.ends for device, wear in self.wear.items()}}
        print("\n" + json.dumps(figures, indent=1))
        if os.environ.get("TAKT_SOAK_REPORT"):
            with open(os.environ["TAKT_SOAK_REPORT"], "w") as file:
                json.dump({**figures, "seen": {device: wear.lives for device, wear in self.wear.items()}}, file, indent=1)
        for wear in self.wear.values():
            wear.assert_none(self)


if __name__ == "__main__":
    takt_system.main()
