import json
import os
import re
import shutil
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import wait_until

SECONDS = takt_system.how_much("TAKT_RELEASES_SECONDS", 20.0, 900.0)
OTHER_RELEASE = os.environ["TAKT_OTHER_RELEASE"]  # debian12 or debian13
CELL = os.path.join(takt_system.SOURCE, "deploy", "palletizing.xml")
HERE, THERE = ("station",), ("robot", "line")  # the devices on this system and on the other one
BETWEEN = ("station.panel.belt", "station.panel.arm", "line.conveyor.command")  # receive samples from the other system all the time
# The programs that consist of the unit tests of a room, from the bottom up to the messages between nodes.
UNIT_TESTS = ("core", "os", "model", "channel", "schedule", "lifecycle", "transaction", "component", "descriptor", "security", "wire")


class Releases(takt_system.Case):
    """Station runs on the system of this machine; robot and line run on the other system, in a root folder of its own."""

    def use(self, other):
        """Sets the other system, for which there is a build: debian12, debian13 or debian13-arm64."""
        self.keys = ""
        self.other = other
        self.root = os.path.join(takt_system.SOURCE, "build", other)
        self.shared = os.path.join(self.root, "root", os.path.basename(self.folder))  # programs in the root folder see it as /root/...
        os.mkdir(self.shared)
        self.addCleanup(shutil.rmtree, self.shared)

    def there(self, script):
        """Starts a shell script on the other system."""
        settings = ["TAKT_DOMAIN=%d" % self.domain, "TAKT_INTERFACE=127.0.0.1", "PATH=/takt/build/release/bin:/usr/bin:/bin",
                    "HERE=/root/" + os.path.basename(self.shared)]
        run = takt_system.Run([os.path.join(takt_system.SOURCE, "tools", "on"), "--keep", self.root, self.other, "env", *settings, "sh", "-euc",
                               script], self.folder)
        self.runs.append(run)
        return run

    def takt_there(self, command):
        security = " --security $HERE/keys/operators/operator" if self.keys else ""
        run = self.there("takt " + command + security).wait()
        self.assertEqual(0, run.status, run.err)
        return run.out

    def takt_here(self, *arguments):
        security = ["--security", os.path.join(self.keys, "operators", "operator")] if self.keys else []
        run = self.takt(*arguments, *security)
        self.assertEqual(0, run.status, run.err)
        return run.out

    def security_of(self, device, keys):
        return ["--security", os.path.join(keys, "devices", device)] if self.keys else []

    def start_nodes(self):
        self.station = self.node(HERE[0], *self.security_of(HERE[0], self.keys))
        nodes = ["takt-node --device %s --state-dir $HERE/%s %s &" % (device, device, " ".join(self.security_of(device, "$HERE/keys")))
                 for device in THERE]
        self.others = self.there(" ".join(["trap 'kill $(jobs -p); wait' TERM;"] + nodes + ["wait"]))
        for device in THERE:
            self.others.wait_for_line(r"^\S+ %s: waits for a deployment" % device)

    def health(self):
        """Returns the health of each connection, by its receiver."""
        return {c["to"]: c["health"] for c in json.loads(self.takt_here("graph", CELL, "--live", "--json"))["connections"]}

    def wait_until_it_runs(self, seconds):
        """Waits until all connections are matched, and then for some seconds. Then samples must arrive, and none may have been lost."""
        wait_until(lambda: all(health["matched"] for health in self.health().values()), "all connections to be matched")
        time.sleep(seconds)
        wait_until(lambda: all(self.health()[to].get("age_ns", 1e9) < 1e9 for to in BETWEEN), "samples from the other system")
        for receiver, health in self.health().items():
            self.assertEqual((True, 0), (health["matched"], health["lost"]), receiver)

    def run_cell(self):
        self.start_nodes()
        self.takt_here("deploy", CELL)
        self.wait_until_it_runs(SECONDS / 2)
        with open(CELL, encoding="utf-8") as file:
            text = file.read()
        changed = text.replace('<value name="spacing">0.3</value>', '<value name="spacing">0.4</value>')
        self.assertNotEqual(text, changed)
        with open(os.path.join(self.shared, "palletizing.xml"), "w") as file:
            file.write(changed)
        self.takt_there("deploy --update $HERE/palletizing.xml")
        self.wait_until_it_runs(SECONDS / 2)
        self.assertEqual("0.4", self.takt_here("get", "line.conveyor", "spacing").strip())
        self.takt_there("undeploy palletizing")
        self.takt_there("deploy $HERE/palletizing.xml")
        self.wait_until_it_runs(1)
        self.takt_here("undeploy", "palletizing")
        self.end({HERE[0]: self.station})

    def secure(self):
        self.keys = os.path.join(self.folder, "keys")
        self.assertEqual(0, self.takt("secure", "init", CELL, self.keys, "--domain", str(self.domain)).status)
        shutil.copytree(self.keys, os.path.join(self.shared, "keys"))

    def test_a_cell_runs_on_two_debian_releases(self):
        self.use(OTHER_RELEASE)
        self.run_cell()

    def test_a_secured_cell_runs_on_two_debian_releases(self):
        self.use(OTHER_RELEASE)
        self.secure()
        self.run_cell()

    def test_a_secured_cell_runs_on_two_architectures(self):
        self.use("debian13-arm64")
        self.secure()
        self.run_cell()

    def test_unit_tests_pass_on_arm64(self):
        self.use("debian13-arm64")
        for room in UNIT_TESTS:
            # With several CPUs, QEMU lets a load with memory_order_seq_cst overtake an earlier store, which no ARM processor does.
            run = self.there("taskset -c 0 build/release/bin/%s_test" % room).wait(600)
            self.assertEqual(0, run.status, run.out)
            print("%s: %s" % (room, re.search(r"\d+ tests from \d+ test suites ran", run.out).group()))


if __name__ == "__main__":
    takt_system.main()
