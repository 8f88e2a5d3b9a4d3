import json
import os
import re
import signal
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import LIFE, wait_until

RUNS = LIFE[:4]
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
        """The cell with parts in place of others, as a file."""
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
        """What each instance of ticks said in start(): its version, how it began, its label."""
        found = [re.match(r"version (\d) (from|begins at) \d+, label (\w+)", line.text.lstrip("| ")) for line in list(node.lines)]
        return [m.groups() for m in found if m]

    def assert_versions(self, node, *expected):
        """Of the last instances of ticks. What one prints may come after the answer that it is there."""
        wait_until(lambda: [version for version, *_ in self.versions(node)][-len(expected):] == list(expected), 10,
                   "versions %s to be told" % (expected,))

    def t0(self, name):
        """When the grid of a module that has ended began, in ns; it has strayed from it never."""
        t0, runs, strayed = (int(n) for n in self.read(name).split())
        self.assertEqual((True, 0), (runs > 0, strayed))
        return t0

    def assert_same_grid(self, one, other):
        print("the grids differ by %d ns" % (other - one))
        self.assertLess(abs(other - one), 20000)

    def test_a_file_and_a_property_are_changed_while_it_runs_and_resumed(self):
        nodes = self.running()
        hosts = self.hosts(nodes)
        self.done("set robot.live label mine")
        more = ("ticks.so", "ticks_more.so"), ('"step">1', '"step">7')
        self.assertEqual(["robot.ticks: file: ticks.so -> ticks_more.so", "robot.live: step: 1 -> 7", "cell cell is updated"],
                         self.update(*more))
        self.assertEqual(["7", "mine"], self.done("get robot.live step", "get robot.live label"))
        self.assertEqual(["nothing differs"], self.update(*more))
        # What an operator has set gives way only to a new word of the descriptor.
        self.assertEqual(["robot.live: label: a -> b", "cell cell is updated"], self.update(*more, ('"label">a', '"label">b')))
        self.assertEqual(["7", "b"], self.done("get robot.live step", "get robot.live label"))
        self.assertEqual(hosts, self.hosts(nodes))
        for node, module in (("robot", "ticks"), ("robot", "live"), ("line", "grid"), ("line", "reader")):
            self.assertEqual(RUNS, nodes[node].states(module))
        self.assert_versions(nodes["robot"], "1", "2")
        self.assertEqual([("1", "begins at", "given"), ("2", "from", "given")], self.versions(nodes["robot"]))
        log = self.done("log --device robot --kind command --json")[0]
        self.assertIn("was carried out: robot.ticks: file: ticks.so -> ticks_more.so: robot.live: step: 1 -> 7", log)

        nodes["robot"].signal(signal.SIGKILL)
        nodes["robot"].wait(10)
        nodes["robot"] = self.node("robot", "--resume")
        self.wait_for_states({"robot": "EXECUTING"})
        self.assertEqual(["7", "b"], self.done("get robot.live step", "get robot.live label"))
        self.assert_versions(nodes["robot"], "2")
        self.done("undeploy cell")
        steps = json.loads(self.read("steps"))
        self.assertEqual(([7], 0), (steps["steps"], steps["changed"]))
        self.t0("line")
        seen = json.loads(self.read("seen"))
        self.assertGreater(seen["read"], 0)
        self.end(nodes)

    def test_one_device_is_brought_up_anew_on_its_grid_and_the_other_runs_on(self):
        nodes = self.running()
        robot = nodes["robot"].one("takt-host").pid
        self.done("set line.grid file operator")
        self.assertEqual(["line is brought up anew: module grid: period: 5 ms -> 2 ms", "cell cell is updated"],
                         self.update(("<period>5000000</period> <priority>1", "<period>2000000</period> <priority>1")))
        self.wait_for_states({"robot": "EXECUTING", "line": "EXECUTING"})
        before = self.t0("operator")
        self.assertEqual(robot, nodes["robot"].one("takt-host").pid)
        self.assertEqual([RUNS, RUNS], [nodes["robot"].states(module) for module in ("ticks", "live")])
        self.assertEqual(["operator"], self.done("get line.grid file"))
        # Samples of the device that ran on arrive again.
        reader = lambda: next(m for m in self.status_of("line")["modules"] if m["name"] == "reader")["ports"][0]
        wait_until(lambda: reader()["samples"] > 0, 15, "samples of the other device")
        self.done("undeploy cell")
        self.assert_same_grid(before, self.t0("operator"))
        self.assertGreater(json.loads(self.read("seen"))["read"], 0)
        self.end(nodes)

    def test_a_mistake_on_one_device_changes_nothing_anywhere(self):
        nodes = self.nodes("robot", "line")
        more = ("ticks.so", "ticks_more.so")
        run = self.update_fails(more)
        self.assertRegex(run.err, r"no device on domain \d+ runs a cell cell; none runs any cell; takt deploy starts it")
        self.deploy(self.changed())
        self.wait_for_states({"robot": "EXECUTING", "line": "EXECUTING"})
        hosts = self.hosts(nodes)
        for changes, pattern in (
                ((more, ("grid.so", "nothing.so")), r"cell\.xml:\d+: error: .*no file nothing\.so"),
                ((more, ("robot.ticks.out", "robot.ticks.output")), r"cell\.xml:\d+: error: .*no port 'output'"),
                ((more, ("<period>5000000</period> <priority>1", "<period>5ms</period> <priority>1")), r"cell\.xml:\d+: error: "),
                ((more, ('<cell name="cell">', '<cell name="cell" domain="%d">' % self.domain)),
                 r"cell\.xml:1: error: a cell that runs cannot be given another domain: none -> \d+; undeploy the cell and deploy it"),
                ((('"step">1', '"step">100000'),), r"cell\.xml:\d+: error: .*property 'step' cannot be '100000'"),
                ((more, ('</device>\n  <connection', '</device>\n  %s\n  <connection' % STATION)),
                 r"device station: error: it is not there")):
            run = self.update_fails(*changes)
            self.assertEqual("", run.out)
            self.assertRegex(run.err, pattern)
            self.assertEqual(1, len(re.findall(pattern, run.err)), run.err)
            if "5ms" not in repr(changes):
                self.assertIn("cell cell is not updated; nothing was changed", run.err)
        self.assertEqual(hosts, self.hosts(nodes))
        self.assertEqual(["nothing differs"], self.update())
        self.assertEqual([("1", "begins at", "given")], self.versions(nodes["robot"]))
        self.done("undeploy cell")
        self.end(nodes)

    def test_what_fails_on_its_way_is_put_back_on_every_device(self):
        nodes = self.running()
        robot = nodes["robot"].one("takt-host").pid
        run = self.update_fails((">given<", ">other<"), ("ticks.so", "ticks_fails.so"), ('"file">line', '"file">other'),
                                ("<period>5000000</period> <priority>1", "<period>2000000</period> <priority>1"))
        self.assertIn("line is brought up anew: module grid: period: 5 ms -> 2 ms; module grid: file: line -> other\n", run.out)
        self.assertRegex(run.err, r"module robot\.ticks: error: file: ticks\.so -> ticks_fails\.so: the one before it was put back "
                                  r"in cycle \d+: failure: the third is not for me")
        self.assertIn("cell cell is not updated; what had been changed was put back", run.err)
        # Each says what it does as it does it, and why it goes back before it does.
        for node, change in (("robot", "robot.ticks: label: given -> other; file: "), ("line", "line is brought up anew: ")):
            nodes[node].wait_for_line("is not updated: ")
            said = nodes[node].err
            told = [said.find(text) for text in ("is being updated: " + change, "is put back to what it was: ", "is not updated: ")]
            self.assertNotIn(-1, told, said)
            self.assertEqual(sorted(told), told, said)
            self.assertNotIn(": is updated", said)
        said = nodes["line"].err
        self.assertLess(said.index("is put back to what it was: "), said.rindex("-> DESTRUCT"))
        self.wait_for_states({"robot": "EXECUTING", "line": "EXECUTING"})
        self.assertEqual(robot, nodes["robot"].one("takt-host").pid)
        self.assertEqual(["given"], self.done("get robot.ticks label"), "it was set before the file was to be swapped")
        first = self.t0("line")
        self.assertEqual(["nothing differs"], self.update())
        # A device that cannot be brought up.
        run = self.update_fails(("ticks.so", "ticks_more.so"), ("grid.so", "bad_start.so"), ('<value name="file">line</value>', ""))
        self.assertRegex(run.err, r"grid.*start\(\)")
        self.assertIn("cell cell is not updated; what had been changed was put back", run.err)
        self.wait_for_states({"robot": "EXECUTING", "line": "EXECUTING"})
        self.assert_versions(nodes["robot"], "1", "2", "1")
        self.assertEqual(["nothing differs"], self.update())
        self.done("undeploy cell")
        self.assert_same_grid(first, self.t0("line"))
        self.end(nodes)

    def test_devices_come_and_go(self):
        connection = re.search(r"  <connection.*\n", self.cell)[0]
        self.cell = self.cell.replace(connection, "")
        nodes = self.running("robot", "line", "station")
        robot = nodes["robot"].one("takt-host").pid
        line = self.cell[self.cell.index('<device name="line">'):self.cell.index("</cell>")]
        self.assertEqual(["line is taken down: the cell does not have it any more", "station is new", "cell cell is updated"],
                         self.update((line, STATION)))
        self.wait_for_states({"robot": "EXECUTING", "station": "EXECUTING"})
        self.assertEqual([], nodes["line"].processes("takt-host"))
        self.assertEqual(robot, nodes["robot"].one("takt-host").pid)
        self.assertEqual(["cell cell is undeployed from robot, station"], self.done("undeploy cell"))
        self.assert_same_grid(self.t0("line"), self.t0("station"))
        self.end(nodes)


if __name__ == "__main__":
    takt_system.main()
