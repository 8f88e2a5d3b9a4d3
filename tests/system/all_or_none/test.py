import os
import shutil
import signal
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import networks
import takt_system
from takt_system import LIFE, wait_until

MODULE = """
    <module>
      <name>%s</name>
      <filename>%s</filename> <moduletype>thread</moduletype> <operationtype>periodic</operationtype>
      <period>5000000</period> <priority>2</priority>%s
    </module>
  </device>
</cell>
"""
WHERE = '<property><value name="where">initialize</value></property>'


class AllOrNone(takt_system.Case):
    def cell(self, name, module=None, filename="", rest=""):
        """Writes the valid cell under another name, with an additional module on device line."""
        with open(self.beside("cell.xml")) as file:
            text = file.read().replace('name="cell"', 'name="%s"' % name)
        if module:
            text = text[:text.rindex("\n  </device>")] + MODULE % (module, filename, rest)
        return self.write(name + ".xml", text)

    def path_without(self, *names):
        """Returns an environment in which the component path contains no files with these names."""
        folder = os.path.join(self.folder, "components")
        os.mkdir(folder)
        for source in os.environ["TAKT_COMPONENT_PATH"].split(":"):
            for name in os.listdir(source):
                if name.endswith((".so", ".exe")) and name not in names:
                    os.symlink(os.path.join(source, name), os.path.join(folder, name))
        return {"TAKT_COMPONENT_PATH": folder}

    def begin(self):
        self.running = {"robot": self.node("robot"), "line": self.node("line", environment=self.path_without("fine.so"))}
        self.marks = {}
        self.mark()

    def mark(self):
        self.marks = {device: len(node.raw) for device, node in self.running.items()}

    def said_since(self, device):
        return "\n".join(self.running[device].raw[self.marks[device]:])

    def assert_nothing_runs(self):
        """Waits until all nodes wait for a deployment and have no child processes. They may not do so yet, because nodes reply shortly before
        they publish that they have no cell."""
        def free():
            status = self.status_of()
            return status["cell"] == "-" and {d["name"]: d["modules"] for d in status["devices"]} == {"robot": [], "line": []}
        wait_until(free, "all nodes to wait")
        self.assert_nothing_left_of_it()

    def assert_nothing_left_of_it(self):
        for device, node in self.running.items():
            wait_until(lambda: [process.program for process in node.processes()] == ["takt-node"], "the host and programs of node %s to end" % device)
            self.assertNotIn("EXECUTING", self.said_since(device))

    def assert_refused_everywhere(self, run, cell, *patterns, outcome="the devices are unchanged"):
        self.assertEqual((1, ""), (run.status, run.out), run.err)
        for pattern in patterns:
            self.assertRegex(run.err, pattern)
        self.assertRegex(run.err, "(?m)^cell %s was not deployed; %s$" % (cell, outcome))

    def assert_a_good_one_succeeds(self):
        self.deploy("cell.xml")
        for device, node in self.running.items():
            node.wait_for_line(r" %s\.grid: START -> EXECUTING" % device, after=self.marks[device])
        self.undeploy("cell")

    def undeploy(self, cell):
        """Undeploys the cell. Waits for the last lines of the nodes, so that they are not mistaken for lines about the next deployment."""
        self.done("undeploy " + cell)
        for device, node in self.running.items():
            node.wait_for_line(": cell %s is undeployed$" % cell, after=self.marks[device])
        self.mark()

    def refuse(self, cell, *patterns, then_a_good_one=True):
        with self.subTest(cell=os.path.basename(cell)):
            name = os.path.basename(cell)[:-4]
            begun = time.monotonic()
            run = self.takt("deploy", cell)
            print("%s was rejected after %.2f s" % (name, time.monotonic() - begun))
            self.assert_refused_everywhere(run, name, *patterns)
            if then_a_good_one:
                self.assert_nothing_left_of_it()
                self.assert_a_good_one_succeeds()
            else:
                self.assert_nothing_runs()

    def test_a_failure_on_one_device_cancels_the_deployment_on_all_devices(self):
        self.begin()
        self.refuse(self.cell("absent", "bad", "fine.so"),
                    r"(?m)absent\.xml:\d+: error: device line: module bad: there is no file fine\.so on this device's component path",
                    then_a_good_one=False)
        # A node loads only files on its component path.
        shutil.copy(os.path.join(self.folder, "components", "grid.so"), os.path.join(self.folder, "mine.so"))
        self.refuse(self.cell("path", "bad", os.path.join(self.folder, "mine.so")),
                    r"(?m)path\.xml:\d+: error: device line: module bad: there is no file .*/mine\.so on this device's component path "
                    r".*name it mine\.so, without a path",
                    then_a_good_one=False)
        self.refuse(self.cell("unknown", "bad", "grid.so", '<property><value name="fiel">x</value></property>'),
                    r"(?m)unknown\.xml:\d+: error: device line: .*bad.*'?fiel'?")
        self.refuse(self.cell("initialize", "bad", "bad_initialize.so"),
                    r"(?m)^module line\.bad: error: initialize\(\) failed: threw: initialize\(\) threw")
        self.refuse(self.cell("start", "bad", "bad_start.so", '<recovery attempts="0"/>'),
                    r"(?m)^module line\.bad: error: .*start\(\) failed: threw: start\(\) threw")
        self.refuse(self.cell("crash", "bad", "segv.so", WHERE),
                    r"(?m)^module line\.bad: error: the host was killed by SIGSEGV .* in initialize\(\)")
        self.refuse(self.with_a_third_device(),
                    r"(?m)^device third: error: not found on domain %d; start its node with takt-node --device third --domain %d; "
                    r"devices found there: (\w+, )*line" % (self.domain, self.domain))
        with open(self.beside("cell.xml")) as file:
            text = file.read().replace('"cell"', '"lime"').replace('"line"', '"lime"')
        self.refuse(self.write("lime.xml", text),
                    r"(?m)^device lime: error: not found on domain %d; did you mean line\? Otherwise start its node" % self.domain,
                    then_a_good_one=False)
        self.end(self.running)

    def with_a_third_device(self):
        with open(self.beside("cell.xml")) as file:
            text = file.read().replace('name="cell"', 'name="third"').replace(
                "</cell>", '<device name="third"><module><filename>grid.so</filename><moduletype>thread</moduletype>'
                "<operationtype>periodic</operationtype><period>1000000</period><priority>1</priority></module></device></cell>")
        return self.write("third.xml", text)

    def test_takt_deploy_does_not_send_an_invalid_descriptor_to_any_device(self):
        self.begin()
        before = {device: list(node.raw) for device, node in self.running.items()}
        cell = self.cell("mistake", "grid", "grid.so", "<perod>5</perod>")
        run = self.takt("deploy", cell)
        self.assertEqual((1, ""), (run.status, run.out))
        # takt must report all errors at once.
        self.assertRegex(run.err, r"(?m)^\S*mistake\.xml:\d+: error: .*perod")
        self.assertRegex(run.err, r"(?m)^\S*mistake\.xml:\d+: error: .*grid")
        self.assert_nothing_runs()
        self.assertEqual(before, {device: node.raw for device, node in self.running.items()})
        self.end(self.running)

    def test_ctrl_c_in_takt_deploy_undoes_an_unfinished_deployment(self):
        self.begin()
        run = self.start("deploy", self.cell("hang", "bad", "hang.so", WHERE))
        self.running["line"].wait_for_line("preparing cell hang")
        self.running["robot"].wait_for_line("program: INITIALIZE|program: IDLE -> INITIALIZE")
        run.signal(signal.SIGINT)
        begun = time.monotonic()
        run.wait()
        print("takt deploy ended %.2f s after Ctrl-C, while initialize() hung" % (time.monotonic() - begun))
        self.assert_refused_everywhere(run, "hang", "error: the deployment was cancelled before all devices were ready")
        self.assert_nothing_runs()
        self.assert_a_good_one_succeeds()
        self.end(self.running)

    def test_a_node_killed_during_preparation_cancels_the_deployment(self):
        self.begin()
        run = self.start("deploy", self.cell("hang", "bad", "hang.so", WHERE))
        self.running["line"].wait_for_line("preparing cell hang")
        self.running["robot"].wait_for_line("program: INITIALIZE -> START")
        self.running["line"].signal(signal.SIGKILL)
        begun = time.monotonic()
        run.wait()
        took = time.monotonic() - begun
        print("cancelled %.2f s after a node was killed" % took)
        self.assertLess(took, 4, "takt deploy must not wait for the hanging hook")
        self.assert_refused_everywhere(
            run, "hang", r"(?m)^device line: error: it was lost before it answered command change; the command was sent \d+ times?, and "
            r"the last status of the device arrived [\d.]+ m?s ago; the device may have carried it out: check with takt status before you "
            r"try again$", outcome="line has not confirmed this; takt status shows whether the cell runs there")
        self.running["line"].wait()
        self.running["line"] = self.node("line")
        self.marks["line"] = 0
        self.assert_nothing_runs()
        self.assert_a_good_one_succeeds()
        self.end(self.running)

    def test_at_most_one_of_two_simultaneous_deployments_succeeds(self):
        self.begin()
        files = {name: self.cell(name) for name in ("one", "two")}
        won = {}
        for _ in range(2):
            runs = {name: self.start("deploy", file) for name, file in files.items()}
            for run in runs.values():
                run.wait()
            winners = [name for name, run in runs.items() if run.status == 0]
            won[tuple(winners)] = won.get(tuple(winners), 0) + 1
            self.assertLessEqual(len(winners), 1, "a device runs only one cell")
            if not winners:
                self.assert_nothing_runs()
                continue
            status = self.wait_for_states({"robot": "EXECUTING", "line": "EXECUTING"})
            self.assertEqual(2, len(status))
            self.assertEqual(winners[0], self.status_of()["cell"])
            self.undeploy(winners[0])
        print("cells that ran, of two deployed at once: %s" % won)
        self.end(self.running)

    def test_takt_deploy_fails_while_two_nodes_have_the_same_name(self):
        self.begin()
        second = self.program("takt-node", "--device", "line", "--state-dir", os.path.join(self.folder, "second"))
        clash = r"another node named line is on domain %d: process %%d on \S+; end or rename one of them: while both run, they " \
                r"reject deployments and commands" % self.domain
        self.running["line"].wait_for_line(clash % second.pid)
        second.wait_for_line(clash % self.running["line"].pid)
        # takt either finds both nodes, or it finds one of them, which knows the other. The message is the same.
        pids = [self.running["line"].pid, second.pid]
        both = "|".join(r"process %d on \S+, process %d on \S+" % pair for pair in (tuple(pids), tuple(reversed(pids))))
        two = r"(?m)^device line: error: 2 nodes on domain %d have this name: (%s); end all but one of them" % (self.domain, both)
        self.assert_refused_everywhere(self.takt("deploy", "cell.xml"), "cell", two)
        self.refused({command: two for command in ("stop line", "get line.grid", "get line.grid x", "echo line.grid.x", "trace line")})
        status = self.takt("status", "--json")
        self.assertEqual(0, status.status, status.err)
        devices = status.report["devices"]
        self.assertEqual(sorted(list(self.running) + ["line"]), [d["name"] for d in devices], "both nodes named line are shown")
        self.assertEqual(2, sum("another node named line" in d.get("conflict", "") for d in devices))
        self.assertEqual(2, self.takt("status").out.count("NAME CONFLICT: another node named line"))
        second.signal(signal.SIGTERM)
        self.assertEqual(0, second.wait().status)
        self.running["line"].wait_for_line("the other node with this name is gone")
        self.assert_nothing_runs()
        self.assert_a_good_one_succeeds()
        self.end(self.running)

    def test_a_rejected_deployment_does_not_disturb_the_running_cell(self):
        self.begin()
        self.deploy("cell.xml")
        before = self.wait_for_states({"robot": "EXECUTING", "line": "EXECUTING"})
        hosts = {device: node.one("takt-host").pid for device, node in self.running.items()}
        other, again, undeploy = self.at_once("deploy " + self.cell("other"), "deploy cell.xml", "undeploy other")
        self.assert_refused_everywhere(again, "cell", "error: it already runs cell cell; run takt undeploy cell first; or run takt "
                                                      "deploy --update to change the cell while it runs")
        self.assertEqual(1, undeploy.status)
        self.assertIn("error: no device on domain %d runs cell other; cells on this domain: cell" % self.domain, undeploy.err)
        self.assert_refused_everywhere(other, "other", *[r"(?m)^device %s: error: it already runs cell cell; run takt "
                                                       r"undeploy cell first$" % device for device in self.running])
        after = self.wait_for_states({"robot": "EXECUTING", "line": "EXECUTING"})
        for device, node in self.running.items():
            self.assertEqual(hosts[device], node.one("takt-host").pid)
            self.assertEqual(LIFE[:4], node.states("grid"))
            rows = [status[device]["executors"][0] for status in (before, after)]
            self.assertGreater(rows[1]["cycles"], rows[0]["cycles"])
        self.done("undeploy cell")
        self.end(self.running)


class WithoutTheOperator(networks.NetworkCase):
    MACHINES = ("robot", "line", "observer")

    def begin(self):
        self.running = self.nodes("robot", "line")
        self.watch = self.start("watch", on="observer")
        self.watch.wait_for_out(r"robot: waiting")
        self.watch.wait_for_out(r"line: waiting")

    def start_deployment(self):
        """Deploys a cell in which device line is ready only after the test has called be_ready()."""
        self.fifo = os.path.join(self.folder, "fifo")
        os.mkfifo(self.fifo)  # the diary module waits in initialize() until the test reads its lines
        with open(self.beside("cell.xml")) as file:
            text = file.read()
        diary = MODULE % ("diary", "diary.so", '<property><value name="file">%s</value></property>' % self.fifo)
        self.run_of_deploy = self.start("deploy", self.write("cell.xml", text[:text.rindex("\n  </device>")] + diary))
        self.running["line"].wait_for_line("preparing cell cell")
        self.running["line"].wait_for_line("grid: IDLE -> INITIALIZE")

    def be_ready(self):
        reader = os.open(self.fifo, os.O_RDONLY | os.O_NONBLOCK)
        self.addCleanup(os.close, reader)

    def assert_waiting(self, *devices):
        def free():
            run = self.takt("status", "--json", on="observer")
            state = {d["name"]: (d.get("state"), d["modules"]) for d in run.report["devices"]} if run.status == 0 else {}
            return all(state.get(device) == ("waiting", []) for device in devices)
        wait_until(free, "devices %s to wait for a deployment" % ", ".join(devices))

    def test_all_devices_undo_a_deployment_if_the_operator_loses_its_network_before_it_sends_the_start_time(self):
        self.begin()
        self.start_deployment()
        self.net.lose_packets("operator", "line")  # so line does not receive the safe values
        self.be_ready()
        self.watch.wait_for_out(r"line: ready")
        self.net.cut("operator")
        self.assert_waiting("robot", "line")
        for device, node in self.running.items():
            self.assertNotIn("EXECUTING", "\n".join(node.raw), device)
        run = self.run_of_deploy.wait()
        self.assertEqual((1, ""), (run.status, run.out))
        self.assertIn("this machine has lost all devices of the cell at the same moment; check its own network", run.err)
        self.assertIn("cell cell was not deployed; robot, line have not confirmed this; takt status shows whether", run.err)
        self.end(self.running)

    def test_no_device_runs_if_a_node_is_killed_after_it_has_confirmed_the_start_time(self):
        self.begin()
        self.start_deployment()
        self.be_ready()
        self.watch.wait_for_out(r"line: (armed|running)")
        self.running["line"].signal(signal.SIGKILL)
        run = self.run_of_deploy.wait()
        self.assertEqual((1, ""), (run.status, run.out))
        self.assertRegex(run.err, "(?m)^device line: error: ")
        self.assert_waiting("robot")
        self.end({"robot": self.running["robot"]})


if __name__ == "__main__":
    takt_system.main()
