import hashlib
import itertools
import json
import os
import re
import shutil
import signal
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import LIFE, wait_until

RUNS = LIFE[:4]
COMPONENTS = os.path.join(os.path.dirname(takt_system.BIN), "tests", "components")
STATION = """<device name="station">
    <module>
      <name>grid</name> <filename>grid.so</filename>
      <moduletype>thread</moduletype> <operationtype>periodic</operationtype>
      <period>5000000</period> <priority>1</priority>
      <property><value name="file">station</value></property>
    </module>
  </device>"""


class Update(takt_system.Case):
    def setUp(self):
        super().setUp()
        with open(self.beside("cell.xml")) as file:
            self.cell = file.read()

    def changed(self, *changes):
        """Writes the cell to a file, with these texts replaced."""
        text = self.cell
        for old, new in changes:
            self.assertEqual(1, text.count(old), old)
            text = text.replace(old, new)
        return self.write("cell.xml", text)

    def running(self, *devices, file=None):
        nodes = self.nodes(*(devices or ("robot", "line")))
        self.deploy(file or self.changed())
        self.wait_for_states({"robot": "EXECUTING", "line": "EXECUTING"})
        return nodes

    def update(self, *changes):
        return self.done("deploy %s --update" % self.changed(*changes))[0].split("\n")

    def update_fails(self, *changes):
        run = self.takt("deploy", self.changed(*changes), "--update")
        self.assertEqual(1, run.status, run.out + run.err)
        return run

    def hosts(self, nodes):
        return {device: node.one("takt-host").pid for device, node in nodes.items()}

    def versions(self, node):
        """Returns what each instance of module ticks printed in start(): its version, how it got its initial state, and its label."""
        found = [re.match(r"version (\d) (from|begins at) \d+, label (\w+)", line.text.lstrip("| ")) for line in list(node.lines)]
        return [m.groups() for m in found if m]

    def assert_versions(self, node, *expected):
        """Waits until the last instances of module ticks have these versions. Their output may arrive after the reply to the update."""
        wait_until(lambda: [version for version, *_ in self.versions(node)][-len(expected):] == list(expected),
                   "versions %s to be printed" % (expected,))

    def t0(self, name):
        """Returns the T0 of a module that has ended, in ns. Checks that all its releases were on the grid."""
        t0, runs, strayed = (int(n) for n in self.read(name).split())
        self.assertEqual((True, 0), (runs > 0, strayed))
        return t0

    def assert_same_grid(self, one, other):
        print("the grids differ by %d ns" % (other - one))
        self.assertLess(abs(other - one), 20000)

    def test_an_update_changes_components_and_properties_of_running_modules(self):
        nodes = self.running()
        hosts = self.hosts(nodes)
        self.done("set robot.live label mine")
        more = ("ticks.so", "ticks_more.so"), ('"step">1', '"step">7')
        self.assertEqual(["robot.ticks: file: ticks.so -> ticks_more.so", "robot.live: step: 1 -> 7", "cell cell is updated"],
                         self.update(*more))
        self.assertEqual(["7", "mine"], self.done("get robot.live step", "get robot.live label"))
        self.assertEqual(["nothing differs"], self.update(*more))
        # An update replaces a value that an operator has set only if the descriptor changes this value.
        self.assertEqual(["robot.live: label: a -> b (an operator has set it to mine)", "cell cell is updated"],
                         self.update(*more, ('"label">a', '"label">b')))
        self.assertEqual(["7", "b"], self.done("get robot.live step", "get robot.live label"))
        self.assertEqual(["robot.live: log-level: not set -> debug", "cell cell is updated"],
                         self.update(*more, ('"label">a', '"label">b</value><value name="log-level">debug')))
        self.assertEqual(["debug"], self.done("get robot.live log-level"))
        self.assertEqual(hosts, self.hosts(nodes))
        for node, module in (("robot", "ticks"), ("robot", "live"), ("line", "grid"), ("line", "reader")):
            self.assertEqual(RUNS, nodes[node].states(module))
        self.assert_versions(nodes["robot"], "1", "2")
        self.assertEqual([("1", "begins at", "given"), ("2", "from", "given")], self.versions(nodes["robot"]))
        log = self.done("log robot --kind command --json")[0]
        self.assertIn("was carried out: robot.ticks: file: ticks.so -> ticks_more.so: robot.live: step: 1 -> 7", log)

        nodes["robot"].signal(signal.SIGKILL)
        nodes["robot"].wait()
        nodes["robot"] = self.node("robot", "--resume")
        self.wait_for_states({"robot": "EXECUTING"})
        self.assertEqual(["7", "b", "debug"],
                         self.done("get robot.live step", "get robot.live label", "get robot.live log-level"))
        self.assert_versions(nodes["robot"], "2")
        self.done("undeploy cell")
        steps = json.loads(self.read("steps"))
        self.assertEqual(([7], 0), (steps["steps"], steps["changed"]))
        self.t0("line")
        seen = json.loads(self.read("seen"))
        self.assertGreater(seen["read"], 0)
        self.end(nodes)

    def test_an_update_swaps_in_a_component_that_was_rebuilt_under_the_same_name(self):
        own = os.path.join(self.folder, "own")
        os.mkdir(own)

        def build(source):
            shutil.copy(os.path.join(COMPONENTS, source), os.path.join(own, "new"))
            os.rename(os.path.join(own, "new"), os.path.join(own, "ticks.so"))
            with open(os.path.join(own, "ticks.so"), "rb") as file:
                return hashlib.sha256(file.read()).hexdigest()[:8]

        def shown():
            return next(m for m in self.status_of("robot")["modules"] if m["name"] == "ticks")["hash"]

        before = build("ticks.so")
        path = own + ":" + os.environ["TAKT_COMPONENT_PATH"]
        nodes = {"line": self.node("line"), "robot": self.node("robot", environment={"TAKT_COMPONENT_PATH": path})}
        self.deploy(self.changed())
        self.wait_for_states({"robot": "EXECUTING", "line": "EXECUTING"})
        hosts = self.hosts(nodes)
        self.assertEqual(before, shown())
        self.assertEqual(["nothing differs"], self.update())
        after = build("ticks_more.so")
        self.assertEqual(["robot.ticks: file ticks.so: %s -> %s" % (before, after), "cell cell is updated"], self.update())
        self.assertEqual(["nothing differs"], self.update())
        self.assertEqual((hosts, after), (self.hosts(nodes), shown()))
        self.assert_versions(nodes["robot"], "1", "2")
        self.assertRegex(self.done("status")[0], r"ticks +%s +- +%s/ticks\.so" % (after, re.escape(own)))
        self.assertIn("ticks.so %s, " % before, self.done("log robot --kind deployed --json")[0])
        self.done("undeploy cell")
        self.end(nodes)

    def test_an_update_of_a_period_restarts_only_the_device_of_that_module(self):
        nodes = self.running()
        robot = nodes["robot"].one("takt-host").pid
        self.done("set line.grid file operator", "set line.grid log-level warning")
        self.assertEqual(["line is restarted: module grid: period: 5 ms -> 2 ms", "cell cell is updated"],
                         self.update(("<period>5000000</period> <priority>1", "<period>2000000</period> <priority>1")))
        self.wait_for_states({"robot": "EXECUTING", "line": "EXECUTING"})
        before = self.t0("operator")
        self.assertEqual(robot, nodes["robot"].one("takt-host").pid)
        self.assertEqual([RUNS, RUNS], [nodes["robot"].states(module) for module in ("ticks", "live")])
        self.assertEqual(["operator", "warning"], self.done("get line.grid file", "get line.grid log-level"))
        # The restarted device must get samples from the other device again.
        reader = lambda: next(m for m in self.status_of("line")["modules"] if m["name"] == "reader")["ports"][0]
        wait_until(lambda: reader()["samples"] > 0, "samples from the other device")
        self.done("undeploy cell")
        self.assert_same_grid(before, self.t0("operator"))
        self.assertGreater(json.loads(self.read("seen"))["read"], 0)
        self.end(nodes)

    def test_an_invalid_update_changes_nothing_on_any_device(self):
        nodes = self.nodes("robot", "line")
        more = ("ticks.so", "ticks_more.so")
        run = self.update_fails(more)
        self.assertRegex(run.err, r"no device on domain \d+ runs cell cell; no cell runs on this domain; start the cell with takt deploy")
        self.deploy(self.changed())
        self.wait_for_states({"robot": "EXECUTING", "line": "EXECUTING"})
        hosts = self.hosts(nodes)
        for changes, pattern in (
                ((more, ("grid.so", "nothing.so")), r"cell\.xml:\d+: error: .*no file nothing\.so"),
                ((more, ("robot.ticks.out", "robot.ticks.output")), r"cell\.xml:\d+: error: .*no port 'output'"),
                ((more, ("<period>5000000</period> <priority>1", "<period>5m</period> <priority>1")), r"cell\.xml:\d+: error: "),
                ((more, ('<cell name="cell">', '<cell name="cell" domain="%d">' % self.domain)),
                 r"cell\.xml:1: error: a running cell cannot change its domain: none -> \d+; undeploy the cell and deploy it"),
                ((('"step">1', '"step">100000'),), r"cell\.xml:\d+: error: .*property 'step' cannot be '100000'"),
                ((more, ('</device>\n  <connection', '</device>\n  %s\n  <connection' % STATION)),
                 r"device station: error: not found: no answer")):
            run = self.update_fails(*changes)
            self.assertEqual("", run.out)
            self.assertRegex(run.err, pattern)
            self.assertEqual(1, len(re.findall(pattern, run.err)), run.err)
            if "5m<" not in repr(changes):
                self.assertIn("cell cell is not updated; nothing was changed", run.err)
        self.assertEqual(hosts, self.hosts(nodes))
        self.assertEqual(["nothing differs"], self.update())
        self.assertEqual([("1", "begins at", "given")], self.versions(nodes["robot"]))
        self.done("undeploy cell")
        self.end(nodes)

    def test_a_failed_update_is_undone_on_every_device(self):
        nodes = self.running()
        robot = nodes["robot"].one("takt-host").pid
        for _ in range(5):  # robot fails after three runs, and line may hear of that before it begins
            before = {name: len(node.err) for name, node in nodes.items()}
            run = self.update_fails((">given<", ">other<"), ("ticks.so", "ticks_fails.so"), ('"file">line', '"file">other'),
                                    ("<period>5000000</period> <priority>1", "<period>2000000</period> <priority>1"))
            self.assertIn("line is restarted: module grid: period: 5 ms -> 2 ms; module grid: file: line -> other\n", run.out)
            self.assertRegex(run.err, r"module robot\.ticks: error: file: ticks\.so -> ticks_fails\.so: the old instance was put back "
                                      r"at release \d+: failure: the third is not for me")
            self.assertIn("cell cell is not updated; all changes were undone", run.err)
            wait_until(lambda: all("is not updated: " in node.err[before[name]:] for name, node in nodes.items()), "both nodes to undo it")
            news = {name: node.err[before[name]:] for name, node in nodes.items()}
            if "is being updated: " in news["line"]:
                break
        # Each node reports the change when it begins, and reports the reason before it undoes the change.
        for node, change in (("robot", "robot.ticks: label: given -> other; file: "), ("line", "line is restarted: ")):
            said = news[node]
            told = [said.find(text) for text in ("is being updated: " + change, "undoing the update: ", "is not updated: ")]
            self.assertNotIn(-1, told, said)
            self.assertEqual(sorted(told), told, said)
            self.assertNotIn(": is updated", said)
        said = nodes["line"].err
        self.assertLess(said.index("undoing the update: "), said.rindex("-> DESTRUCT"))
        self.wait_for_states({"robot": "EXECUTING", "line": "EXECUTING"})
        self.assertEqual(robot, nodes["robot"].one("takt-host").pid)
        self.assertEqual(["given"], self.done("get robot.ticks label"), "the property was set before the swap and must be set back")
        first = self.t0("line")
        self.assertEqual(["nothing differs"], self.update())
        # In this update, a module of one device fails to start.
        run = self.update_fails(("ticks.so", "ticks_more.so"), ("grid.so", "bad_start.so"), ('<value name="file">line</value>', ""))
        self.assertRegex(run.err, r"grid.*start\(\)")
        self.assertIn("cell cell is not updated; all changes were undone", run.err)
        self.wait_for_states({"robot": "EXECUTING", "line": "EXECUTING"})
        self.assert_versions(nodes["robot"], "1", "2", "1")
        self.assertEqual(["nothing differs"], self.update())
        self.done("undeploy cell")
        self.assert_same_grid(first, self.t0("line"))
        self.end(nodes)

    def test_an_update_is_undone_if_its_value_crashes_a_module(self):
        nodes = self.running()
        hosts = self.hosts(nodes)
        given = '"label">given</value>'
        step = lambda value: (given, given + ' <value name="step">%d</value>' % value)
        run = self.update_fails(step(-1))
        self.assertRegex(run.err, r"module robot\.ticks: (error: )?step: not set -> -1: it went to (RECOVER|DESTRUCT): ")
        self.assertIn("cell cell is not updated; all changes were undone", run.err)
        self.wait_for_states({"robot": "EXECUTING", "line": "EXECUTING"})
        self.assertEqual(["1"], self.done("get robot.ticks step"))
        self.assertIn("cell.xml was undone: module robot.ticks: step: not set -> -1", self.done("log robot --kind failed-command --json")[0])
        self.assertEqual(hosts["line"], nodes["line"].one("takt-host").pid)
        # The running instance would crash with this value, but only the new one gets it.
        hosts = self.hosts(nodes)
        more = ("ticks.so", "ticks_more.so")
        self.assertEqual(["robot.ticks: step: not set -> -1; file: ticks.so -> ticks_more.so", "cell cell is updated"],
                         self.update(more, step(-1)))
        self.assertEqual((hosts, ["-1"]), (self.hosts(nodes), self.done("get robot.ticks step")))
        # An operator's value crashes the module for good. An update that changes the module starts the device again.
        self.done("set robot.ticks step -6")
        wait_until(lambda: self.states_of("robot")["ticks"] == "DESTRUCT", "module ticks to be given up")
        run = self.takt("deploy", self.changed(more, step(-1)), "--update")
        self.assertEqual((0, "nothing differs\n"), (run.status, run.out))
        self.assertRegex(run.err, r"device robot: warning: module ticks is in DESTRUCT: ")
        self.assertEqual(["robot is restarted: module ticks was given up; module ticks: step: -1 -> -2 (an operator has set it to -6)", "cell cell is updated"],
                         self.update(more, step(-2)))
        self.wait_for_states({"robot": "EXECUTING", "line": "EXECUTING"})
        self.assertEqual(["-2"], self.done("get robot.ticks step"))
        self.done("undeploy cell")
        self.end(nodes)

    def devices_agree(self):
        """Returns whether both devices run, and neither still takes part in an undecided update."""
        run = self.takt("status", "--json")
        if run.status != 0 or "differences" in run.report:
            return False
        devices = [d for d in run.report["devices"] if d["name"] in ("robot", "line")]
        return len(devices) == 2 and all(d["state"] == "running" and d["stage"] not in ("prepared", "armed", "running") for d in devices)

    def test_all_devices_agree_on_the_old_or_new_version_while_takt_deploy_is_halted_by_sigstop(self):
        nodes = self.running()
        present = ()
        periods = itertools.cycle(("2000000", "4000000"))
        for line_of_takt in ("comparing the running cell", "changing line"):
            for _ in range(20):  # takt deploy may end before the test halts it
                new = (("<period>5000000</period> <priority>1", "<period>%s</period> <priority>1" % next(periods)),)
                run = self.start("deploy", self.changed(*new), "--update")
                run.wait_for_line(line_of_takt)
                if run.halt():
                    break
                run.wait()
                present = new
            wait_until(self.devices_agree, "the devices to agree while takt deploy is stopped")
            run.signal(signal.SIGCONT)
            run.wait()
            print("stopped after '%s': exit status %d: %s" % (line_of_takt, run.status, run.err.splitlines()[-1]))
            # With another exit status, all devices can have the new version only if takt deploy says so.
            present = new if run.status == 0 or re.search("^cell cell is updated; ", run.err, re.MULTILINE) else present
            wait_until(self.devices_agree, "the devices to agree")
            changed = self.update(*present)
            if "the devices decide together" not in run.err:
                self.assertEqual(["nothing differs"], changed, "the exit status must be true")
        self.done("undeploy cell")
        self.end(nodes)

    def test_an_update_can_add_and_remove_devices(self):
        connection = re.search(r"  <connection.*\n", self.cell)[0]
        self.cell = self.cell.replace(connection, "")
        nodes = self.running("robot", "line", "station")
        robot = nodes["robot"].one("takt-host").pid
        line = self.cell[self.cell.index('<device name="line">'):self.cell.index("</cell>")]
        self.assertEqual(["line is stopped: it is no longer in the cell", "station is new", "cell cell is updated"],
                         self.update((line, STATION)))
        self.wait_for_states({"robot": "EXECUTING", "station": "EXECUTING"})
        self.assertEqual([], nodes["line"].processes("takt-host"))
        self.assertEqual(robot, nodes["robot"].one("takt-host").pid)
        self.assertEqual(["cell cell is undeployed from robot, station"], self.done("undeploy cell"))
        self.assert_same_grid(self.t0("line"), self.t0("station"))
        self.end(nodes)


if __name__ == "__main__":
    takt_system.main()
