import json
import os
import shutil
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import wait_until

SECONDS = takt_system.how_much("TAKT_RELEASES_SECONDS", 20.0, 900.0)
OTHER = os.environ["TAKT_OTHER_RELEASE"]  # debian12 or debian13
ROOT = os.environ["TAKT_OTHER_ROOT"]  # a folder that tools/on --keep has made, with a release build
CELL = os.path.join(takt_system.SOURCE, "deploy", "palletizing.xml")
HERE, THERE = ("station",), ("robot", "line")  # the devices on this release and on the other one


class Releases(takt_system.Case):
    """Station runs on the Debian release of this machine; robot and line run on the other release, in a root folder of its own."""

    def setUp(self):
        super().setUp()
        self.keys = ""
        self.shared = os.path.join(ROOT, "root", os.path.basename(self.folder))  # programs in ROOT see it as /root/...
        os.mkdir(self.shared)
        self.addCleanup(shutil.rmtree, self.shared)

    def there(self, script):
        """Starts a shell script on the other release."""
        settings = ["TAKT_DOMAIN=%d" % self.domain, "TAKT_INTERFACE=127.0.0.1", "PATH=/takt/build/release/bin:/usr/bin:/bin",
                    "HERE=/root/" + os.path.basename(self.shared)]
        run = takt_system.Run([os.path.join(takt_system.SOURCE, "tools", "on"), "--keep", ROOT, OTHER, "env", *settings, "sh", "-euc", script],
                              self.folder)
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

    def connections(self):
        return [c["health"] for c in json.loads(self.takt_here("graph", CELL, "--live", "--json"))["connections"]]

    def wait_until_it_runs(self, seconds):
        """Waits until all connections are matched, and then for some seconds, in which no sample may be lost."""
        wait_until(lambda: all(c["matched"] for c in self.connections()), "all connections to be matched")
        time.sleep(seconds)
        for connection in self.connections():
            self.assertTrue(connection["matched"], connection)
            self.assertEqual(0, connection["lost"], connection)

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

    def test_a_cell_runs_on_two_debian_releases(self):
        self.run_cell()

    def test_a_secured_cell_runs_on_two_debian_releases(self):
        self.keys = os.path.join(self.folder, "keys")
        self.assertEqual(0, self.takt("secure", "init", CELL, self.keys, "--domain", str(self.domain)).status)
        shutil.copytree(self.keys, os.path.join(self.shared, "keys"))
        self.run_cell()


if __name__ == "__main__":
    takt_system.main()
