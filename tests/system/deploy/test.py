import json
import os
import re
import subprocess
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import LIFE, wait_until

DEVICES = {"robot": ["grid", "program", "plain"], "line": ["grid", "properties", "source"], "station": ["grid", "sink", "program"]}
KINDS = ("grid", "program", "plain")  # the modules of robot: a thread module, a periodic program and a non-real-time module
DISTRIBUTION = {"mean", "variance", "min", "p50", "p99", "p999", "max"}


class Deploy(takt_system.Case):
    def test_all_devices_of_a_deployed_cell_start_at_the_same_instant(self):
        nodes = self.nodes(*DEVICES)
        pids = {device: node.pid for device, node in nodes.items()}
        for again in range(2):
            begun = {device: len(node.lines) for device, node in nodes.items()}
            run = self.deploy("cell.xml")
            self.assertEqual("cell cell runs on robot, line, station\n", run.out)
            self.assert_contract(self.wait_for_states({device: "EXECUTING" for device in DEVICES}))
            # All modules must be ready before the first module runs.
            def said(step):
                return [line.at for device, node in nodes.items() for line in node.lines[begun[device]:] if line.text == step]
            wait_until(lambda: len(said("START -> EXECUTING")) >= 9, "all modules to report EXECUTING")
            ready, first = said("INITIALIZE -> START"), said("START -> EXECUTING")
            self.assertEqual((9, 9), (len(ready), len(first)))
            self.assertLessEqual(max(ready), min(first))
            self.assertEqual(["cell cell is undeployed from line, robot, station"], self.done("undeploy cell"))
            # All devices use the same clocks here, but each node reads the two clocks itself to convert the instant of the start from one to
            # the other. So the results may differ slightly.
            instants = [int(self.read(device).split()[0]) for device in DEVICES]
            self.assertLess(max(instants) - min(instants), 20000, instants)
            print("the devices' instants differ by %d ns" % (max(instants) - min(instants)))
            self.assertGreaterEqual(run.out_lines[0][0] * 1e9, min(instants), "takt deploy must not report the start before it happened")
            for device, node in nodes.items():
                self.assertEqual("0", self.read(device).split()[2], "releases off the grid")
                self.assertEqual([], node.processes("takt-host"))
                self.assertEqual(pids[device], node.one("takt-node").pid)
        seen = json.loads(self.read("sink"))
        print("the sink saw %s" % seen)
        self.assertGreater(seen["read"], 0)
        self.assertEqual((0, 0), (seen["gaps"], seen["wrong"]))
        status = self.status_of()
        self.assertEqual(("-", [[], [], []]), (status["cell"], [d["modules"] for d in status["devices"]]))
        self.refused({"stop robot.grid": "^device robot: error: device robot has no deployment; deploy a cell to it first: takt deploy CELL$"})
        self.end(nodes)
        for device, node in nodes.items():
            for module in DEVICES[device]:
                states = [step.target for step in node.steps(module)]
                self.assertEqual(2 * LIFE[1:], states, module)

    def assert_contract(self, status):
        self.assertEqual(set(DEVICES), set(status))
        for name, device in status.items():
            self.assertLessEqual({"name", "alive", "real_time", "executors", "modules"}, set(device))
            self.assertIs(True, device["alive"])
            for executor in device["executors"]:
                self.assertLessEqual({"name", "cycles", "missed", "jitter_us"}, set(executor))
                self.assertEqual(DISTRIBUTION, set(executor["jitter_us"]))
                self.assertGreater(executor["cycles"], 0)
            self.assertEqual(DEVICES[name], [m["name"] for m in device["modules"]])
            for module in device["modules"]:
                self.assertLessEqual({"name", "type", "operation", "state", "cycles", "overruns", "errors", "jitter_us", "run_us",
                                      "pid"}, set(module))
                self.assertEqual(DISTRIBUTION, set(module["jitter_us"]))
                self.assertEqual(DISTRIBUTION, set(module["run_us"]))
                self.assertTrue(os.path.exists("/proc/%d" % module["pid"]), module)

    def running(self):
        """Deploys the cell and waits until all modules are EXECUTING. Returns the nodes by name."""
        nodes = self.nodes(*DEVICES)
        self.deploy("cell.xml")
        for device, modules in DEVICES.items():
            for module in modules:
                nodes[device].wait_for_state(module, "EXECUTING")
        return nodes

    def each(self, verb):
        """Gives the command to one module of each kind at the same time. Returns the output of each command."""
        return self.done(*("%s robot.%s" % (verb, module) for module in KINDS))

    def assert_each(self, verb, state):
        self.assertEqual(["robot.%s: %s" % (module, state) for module in KINDS], self.each(verb))

    def assert_each_refused(self, verb, state, allowed):
        self.refused({"%s robot.%s" % (verb, module): r"^module robot\.%s: error: %s is not allowed in state %s; it is allowed in %s$" %
                      (module, verb, state, allowed) for module in KINDS})

    def robot(self):
        return {m["name"]: m for m in self.status_of("robot")["modules"]}

    def test_each_lifecycle_command_works_on_each_kind_of_module(self):
        nodes = self.running()
        self.assert_each("stop", "START (stopped)")
        stopped = self.robot()
        self.assert_each_refused("stop", "START", "EXECUTING")
        still = self.robot()
        for module in KINDS:
            self.assertEqual((stopped[module]["cycles"], "START"), (still[module]["cycles"], still[module]["state"]), module)
        self.assertEqual([], nodes["robot"].processes("monitoring.exe"))
        self.assert_each("start", "EXECUTING")
        for module in ("grid", "program"):
            wait_until(lambda: self.robot()[module]["cycles"] > still[module]["cycles"], "%s to run again" % module)
        nodes["robot"].one("monitoring.exe")
        for verb, allowed in (("start", "INITIALIZE or START"), ("recover", "RECOVER"), ("reset", "DESTRUCT"), ("initialize", "IDLE")):
            self.assert_each_refused(verb, "EXECUTING", allowed)
        self.assert_each("destruct", "DESTRUCT")
        self.assertEqual([], nodes["robot"].processes("monitoring.exe") + nodes["robot"].processes("grid.exe"))
        for verb, allowed in (("start", "INITIALIZE or START"), ("recover", "RECOVER")):
            self.assert_each_refused(verb, "DESTRUCT", allowed + r"; run takt reset robot\.\w+ first, or takt restart robot\.\w+")
        self.assert_each_refused("destruct", "DESTRUCT", "IDLE or INITIALIZE or START or EXECUTING or RECOVER")
        self.assert_each("reset", "IDLE")
        self.assert_each("initialize", "INITIALIZE")
        self.assert_each("start", "EXECUTING")
        # A command to one module must not affect the others.
        for device in ("line", "station"):
            for module in DEVICES[device]:
                self.assertEqual(LIFE[:4], nodes[device].states(module))
        self.done("undeploy cell")
        self.end(nodes)
        for module in KINDS:
            self.assertEqual(LIFE[:4] + ["START", "EXECUTING", "START", "DESTRUCT"] + LIFE, nodes["robot"].states(module))

    def test_a_command_to_a_device_applies_to_all_its_modules(self):
        nodes = self.running()
        said = lambda state: "\n".join(["line.%s: %s" % (module, state) for module in DEVICES["line"]])
        for verb, state in (("stop", "START (stopped)"), ("start", "EXECUTING"), ("destruct", "DESTRUCT"), ("reset", "IDLE"),
                            ("initialize", "INITIALIZE"), ("start", "EXECUTING")):
            self.assertEqual([said(state)], self.done("%s line" % verb))
        self.done("stop line.grid")
        run = self.takt("stop", "line")
        self.assertEqual(1, run.status)
        self.assertEqual(["line.grid: START (stop is not allowed in state START; it is allowed in EXECUTING)", "line.properties: START (stopped)",
                          "line.source: START (stopped)"], sorted(run.out.splitlines()))
        self.assertRegex(run.err, "^device line: error: 1 of 3 modules failed: grid: stop is not allowed in state START")
        self.done("undeploy cell")
        self.end(nodes)

    def completed(self, line):
        """Returns the words that bash offers as completions at the end of this line, and the seconds that this took."""
        script = os.path.join(takt_system.BIN, "..", "tools", "pages", "completions", "takt")
        begun = time.monotonic()
        run = subprocess.run(["bash", "-c", 'source "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _takt; '
                              'printf "%s\\n" "${COMPREPLY[@]}"', "bash", script] + line.split(" "),
                             capture_output=True, text=True, cwd=self.folder, timeout=takt_system.LONG,
                             env=dict(os.environ, TAKT_DOMAIN=str(self.domain), PATH=takt_system.BIN + ":" + os.environ["PATH"]))
        self.assertEqual((0, ""), (run.returncode, run.stderr), line)
        return set(run.stdout.split()), time.monotonic() - begun

    def test_takt_get_without_a_name_lists_all_properties(self):
        nodes = self.running()
        self.done("set line.properties count 7")
        listed, = self.done("get line.properties")
        self.assertRegex(listed, r"(?m)^count +7 +parts +1 to 10 +\S+$")
        self.assertRegex(listed, r"(?m)^label +none +string$")
        report = json.loads(self.done("get line.properties --json")[0])
        self.assertEqual("line.properties", report["module"])
        properties = {one["name"]: one for one in report["properties"]}
        self.assertEqual(("7", "parts", 1, 10), tuple(properties["count"][m] for m in ("value", "unit", "min", "max")))
        self.assertEqual({"enabled", "count", "offset", "gain", "ratio", "label", "log-level"}, set(properties))
        self.refused({"get line.proprties": r"^error: device line has no module 'proprties'; .*properties"})
        self.end(nodes)

    def wait_for_completion(self, line, words):
        """Repeats the completion until bash offers exactly these words. On a busy machine, a completion may find a device too late, or
        a device may not have described its components yet."""
        wait_until(lambda: words == self.completed(line)[0], "completion of %r" % line)

    def test_bash_completes_the_names_of_the_running_cell(self):
        self.assertEqual(set(), self.completed("takt stop ")[0])
        nodes = self.running()
        self.wait_for_completion("takt stop line", {"line", "line.grid", "line.properties", "line.source"})
        self.wait_for_completion("takt get --domain %d robot.p" % self.domain, {"robot.program", "robot.plain"})
        self.wait_for_completion("takt echo line.", {"line.source.out"})
        self.wait_for_completion("takt get line.properties g", {"gain"})
        self.wait_for_completion("takt log s", {"station", "station.grid", "station.program", "station.sink"})
        print("completion took %.2f s" % self.completed("takt stop ")[1])
        self.end(nodes)

    def test_operators_can_address_properties_and_ports_by_name(self):
        nodes = self.running()
        self.assertEqual(["3", "none", "1.5"], self.done("get line.properties count", "get line.properties label",
                                                         "get line.properties gain"))
        self.assertEqual(["7", "a b"], self.done("set line.properties count 7", "set line.properties label 'a b'"))
        self.refused({
            "set line.properties count 70": r"^module line\.properties: error: property 'count' cannot be '70'; .*1 to 10",
            "set line.properties count seven": r"^module line\.properties: error: property 'count' cannot be 'seven'; .*whole number",
            "set line.properties cuont 7": r"^module line\.properties: error: component CppProperties has no property 'cuont'; .*count",
            "get line.proprties count": r"^device line: error: device line has no module 'proprties'; .*properties",
            "get line.properties a\x01": r"^error: 'a\\x01' is not a valid name; a name has at most 63 bytes, and no control characters$",
            "get line.properties %s" % ("x" * 64): r"^error: 'x+' is not a valid name",
            "set line.properties label %s" % ("x" * 256): r"^error: the value 'x.*x' has 256 bytes; give a value of at most 255 bytes$",
            "set station.program x 1": r"^module station\.program: error: its program declares no properties: it gets them, except log-level, as "
                                  r"arguments when it starts; ",
            "echo line.source.nothing": r"^device line: error: module line\.source has no port 'nothing'; .*out",
            "echo line.source": r"^error: line\.source is a module, not a port; its outputs are line\.source\.out",
            "call line.source.out": r"^error: line\.source\.out is an output port, not a service; show its samples with takt echo "
                                    r"line\.source\.out; module line\.source has no services; no module of device line has one$",
            "call station.sink.in": r"^error: station\.sink\.in is an input port, not a service; module station\.sink has no services; ",
            "echo station.sink.in": r"^device station: error: port station\.sink\.in is an input; .*line\.source\.out",
        })
        self.assertEqual(["7", "a b"], self.done("get line.properties count", "get line.properties label"))
        nodes["line"].wait_for_line(r"line\.properties: count = 7")
        # Every command to a missing device must fail within a few seconds.
        asked = ("get nobody.grid x", "set nobody.grid x 1", "stop nobody.grid", "start nobody", "echo nobody.grid.out")
        begun = time.monotonic()
        self.refused({command: r"^device nobody: error: not found on domain %d; check that takt-node --device nobody --domain %d is running; "
                               r"devices found there: line, robot, station$" % (self.domain, self.domain) for command in asked})
        # If the name of a device is misspelled or missing, the message must suggest the correct name.
        self.refused({"stop lien.source": r"^device lien: error: not found on domain %d; devices found there: line, robot, station; did you mean "
                                           r"line\.source\?$" % self.domain,
                      "stop lien": r"; did you mean line\?$",
                      "get lien.properties count": r"; did you mean line\.properties\?$",
                      "swap lien.source port_source.so": r"; did you mean line\.source\?$",
                      "echo lien.source.out": r"; did you mean line\.source\.out\?$",
                      "stop source": r"; for a module, write DEVICE\.MODULE; did you mean line\.source\?$",
                      "get source step": r"; for a module, write DEVICE\.MODULE; did you mean line\.source\?$",
                      "stop sorce": r"; for a module, write DEVICE\.MODULE; did you mean line\.source\?$"})
        took = time.monotonic() - begun
        print("all commands to a missing device failed within %.2f s" % took)
        self.assertLess(took, 10)
        # takt echo must print the samples of a port in order.
        run = self.takt("echo", "line.source.out", "-n", "5")
        self.assertEqual(0, run.status, run.err)
        numbers = [json.loads(line)["number"] for line in run.out.splitlines()]
        self.assertEqual(list(range(numbers[0], numbers[0] + 5)), numbers)
        # takt echo must explain why there are no samples, and continue when there are samples again.
        self.done("stop line.source")
        echo = self.start("echo", "line.source.out", "--count", "1")
        wait_until(lambda: "no samples from line.source.out: line.source is stopped, in START; takt start line.source starts it" in echo.err, "takt echo to explain the silence")
        self.done("start line.source")
        self.assertEqual(0, echo.wait().status, echo.err)
        described = self.done("describe cpp_properties.so")[0]
        for name in ("enabled", "count", "offset", "gain", "ratio", "label"):
            self.assertRegex(described, r"(?m)^ +%s\b" % name)
        self.done("undeploy cell")
        self.end(nodes)

    def test_takt_recover_works_on_each_kind_of_module(self):
        node = self.node("robot")
        self.deploy("recover.xml")
        modules = ("thread", "program", "plain", "never")
        in_recover = {module: "RECOVER" for module in modules}
        self.wait_for_states({"robot": in_recover})
        self.refused({"%s robot.%s" % (verb, module): r"^module robot\.%s: error: %s is not allowed in state RECOVER; it is allowed in %s$" %
                      (module, verb, allowed)
                      for verb, allowed in (("start", "INITIALIZE or START"), ("stop", "EXECUTING")) for module in modules})
        recovered = modules[:3]
        self.assertEqual(["robot.%s: EXECUTING" % module for module in recovered],
                         self.done(*("recover robot.%s" % module for module in recovered)))
        self.refused({"recover robot.never": r"^module robot\.never: error: it could not recover: recover\(\) failed: threw: recover\(\) threw"})
        # These modules fail again after each recovery.
        for module in recovered:
            wait_until(lambda: len(node.steps(module)) == 6, "%s to fail again" % module)
            self.assertEqual(LIFE[:4] + ["RECOVER", "EXECUTING", "RECOVER"], node.states(module))
        self.wait_for_states({"robot": in_recover})
        self.assertEqual(["robot.%s: DESTRUCT" % module for module in modules],
                         self.done(*("destruct robot.%s" % module for module in modules)))
        self.done("undeploy recover")
        self.end({"robot": node})


if __name__ == "__main__":
    takt_system.main()
