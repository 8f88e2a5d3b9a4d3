"""Tests takt force with real nodes: modules read the forced value, and each way to end a force ends it."""
import json
import os
import signal
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import wait_until

INPUTS = ("near.thread.in", "near.program.in", "far.thread.in", "far.program.in")
FORCED = 5_000_000_000  # the source does not get there


class Force(takt_system.Case):
    def setUp(self):
        super().setUp()
        self.nodes_of_cell = self.nodes("near", "far")
        self.deploy("cell.xml")
        self.wait_for_states({"near": "EXECUTING", "far": "EXECUTING"})

    def number_at(self, module):
        """Returns the number in the next sample of the module's output, which is the number that the module reads."""
        out = self.takt("echo", module + ".out", "--count", "1")
        return json.loads(out.out)["number"] if out.status == 0 else None

    def force(self, port, number=FORCED, seconds="3600"):
        run = self.start("force", port, "number=%d" % number, "--for", seconds)
        wait_until(lambda: run.out or run.status is not None, "takt force %s" % port)
        self.assertIn("%s is forced to {\"number\": %d, " % (port, number), run.out, run.err)
        return run

    def forced_inputs(self):
        forced = {}
        for device in self.status_of()["devices"]:
            for module in device["modules"]:
                for port in module.get("ports", []):
                    if "forced" in port:
                        forced["%s.%s.%s" % (device["name"], module["name"], port["name"])] = port
        return forced

    def assert_forced(self, port):
        module = port.rsplit(".", 1)[0]
        wait_until(lambda: self.number_at(module) == FORCED, "%s to read the forced value" % module)

    def assert_not_forced(self, port):
        module = port.rsplit(".", 1)[0]
        wait_until(lambda: 0 < (self.number_at(module) or 0) < FORCED, "%s to read samples" % module)

    def events(self, device, kind):
        log = self.takt("log", device, "--json", "--kind", kind)
        self.assertEqual(0, log.status, log.err)
        return [json.loads(line) for line in log.out.splitlines()]

    def wait_for_end(self, port, why):
        """Waits until the fault record says that the force of the input has ended for this reason."""
        device, module, name = port.split(".")
        wait_until(lambda: [e for e in self.events(device, "force-ended") if e["module"] == module and e["cause"].endswith(": " + why)],
                   "the end of the force of " + port)
        begin = [e for e in self.events(device, "forced") if e["module"] == module]
        self.assertTrue(begin and begin[-1]["cause"].startswith("input '%s' is forced to {\"number\": %d, " % (name, FORCED)), begin)

    def test_modules_read_the_forced_value_until_each_force_ends_in_its_own_way(self):
        runs = {port: self.force(port) for port in INPUTS}
        for port in INPUTS:
            self.assert_forced(port)
        status = self.forced_inputs()
        self.assertEqual(set(INPUTS), set(status))
        for port in INPUTS:
            self.assertEqual(("poor", FORCED), (status[port]["rating"], status[port]["forced"]["value"]["number"]))
            self.assertRegex(status[port]["reason"], r"^forced: by .*@")
        shown = self.done("status", "force", "graph %s --live" % self.beside("cell.xml"))
        self.assertRegex(shown[0], r"thread\.in +in .*! forced: by ")
        for port in INPUTS:
            self.assertIn(port, shown[1])
        self.assertEqual(len(INPUTS), shown[2].count("! forced: by "), shown[2])
        self.refused({"echo near.thread.in": r"port near\.thread\.in is an input, which is forced by .*near\.source\.out"})

        runs["near.thread.in"].signal(signal.SIGINT)
        self.assertEqual(0, runs["near.thread.in"].wait().status)
        self.assert_not_forced("near.thread.in")

        runs["near.program.in"].signal(signal.SIGKILL)
        self.wait_for_end("near.program.in", "its client has not renewed it for 2 s")
        self.assert_not_forced("near.program.in")
        runs["near.program.in"].wait()

        self.assertEqual(["far.thread.in is no longer forced"], self.done("force --end far.thread.in"))
        ended = runs["far.thread.in"].wait()
        self.assertEqual(1, ended.status)
        self.assertRegex(ended.err, r"input far\.thread\.in is no longer forced: .* ended it")
        self.assert_not_forced("far.thread.in")

        self.done("stop far.program", "status")
        ended = runs["far.program.in"].wait()
        self.assertEqual(1, ended.status)
        self.assertIn("is no longer forced: the module left its table", ended.err)
        self.done("start far.program")
        self.assert_not_forced("far.program.in")
        self.assertEqual({}, self.forced_inputs())
        self.assertEqual(["no input is forced"], self.done("force"))

        swapped = self.force("near.thread.in")
        stopped = self.force("far.thread.in")
        self.done("swap near.thread port_latest.so")
        ended = swapped.wait()
        self.assertEqual(1, ended.status)
        self.assertIn("is no longer forced: the module is swapped", ended.err)
        self.assert_not_forced("near.thread.in")
        self.done("undeploy forced")
        self.assertEqual(1, stopped.wait().status)
        self.wait_for_end("far.thread.in", "the device stops")
        self.end(self.nodes_of_cell)

    def test_a_force_ends_when_its_time_is_over(self):
        run = self.force("near.program.in", seconds="1")
        self.assertEqual(0, run.wait().status, run.err)
        self.assertIn("near.program.in is no longer forced: its time is over", run.out)
        self.wait_for_end("near.program.in", "its time is over")
        self.assert_not_forced("near.program.in")
        self.finish()

    def test_a_forced_input_keeps_its_deadline_while_the_output_is_silent(self):
        ports = ("near.thread.in", "far.program.in")
        runs = [self.force(port) for port in ports]
        self.done("stop near.source")

        def silent():
            forced = self.forced_inputs()
            return all(port in forced and forced[port]["age_us"] > 2e6 for port in ports)
        wait_until(silent, "values twice as old as their deadline")
        states = dict(self.states_of("near"), program=self.states_of("far")["program"])
        self.assertEqual(("EXECUTING", "EXECUTING"), (states["thread"], states["program"]))
        for port in ports:
            self.assert_forced(port)
        for run in runs:
            run.signal(signal.SIGINT)
            self.assertEqual(0, run.wait().status, run.err)
        self.wait_for_states({"near": {"thread": "RECOVER"}, "far": {"program": "RECOVER"}})
        self.finish()

    def test_takt_force_rejects_what_cannot_be_forced_and_says_what_to_do(self):
        run = self.force("near.thread.in")
        self.refused({
            "force near.thread.in number=1 --for 5": r"input near\.thread\.in is forced already, by .*takt force --end near\.thread\.in",
            "force near.program.in numbr=1 --for 5": r"numbr.*number",
            "force near.program.in number=-1 --for 5": r"number",
            "force near.program.in number=hello --for 5": r"number",
            "force near.program.inn number=1 --for 5": r"module near\.program has no port 'inn'.*'?in'?",
            "force near.program.out number=1 --for 5": r"near\.program\.out is an output; only inputs can be forced",
            "force near.sink.in number=1 --for 5": r"input near\.sink\.in is a queue and cannot be forced",
            "force near.none.in number=1 --for 5": r"no module 'none'",
            "force near.program number=1 --for 5": r"write DEVICE\.MODULE\.PORT",
            "force --end near.program.in": r"input near\.program\.in is not forced",
        })
        for arguments in (["force", "near.program.in", "number=1"], ["force", "near.program.in", "number=1", "--for", "3601"],
                          ["force", "near.program.in"], ["force", "--end"]):
            self.assertEqual(2, self.takt(*arguments).status, arguments)
        self.assert_forced("near.thread.in")
        self.done("stop near.program")
        self.refused({"force near.program.in number=1 --for 5": r"module near\.program is in START; .*takt start near\.program"})
        run.signal(signal.SIGTERM)
        self.assertEqual(0, run.wait().status)
        self.finish()

    def finish(self):
        self.done("undeploy forced")
        self.end(self.nodes_of_cell)


if __name__ == "__main__":
    takt_system.main()
