import collections
import glob
import json
import os
import signal
import subprocess
import sys
import time
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import wait_until

MODULE = """<module><name>%s</name><filename>%s</filename><moduletype>%s</moduletype>
  <operationtype>periodic</operationtype><period>%d</period><priority>%d</priority>
  %s</module>"""

SPIN = """
import os, sys, time
os.sched_setaffinity(0, {int(sys.argv[1])})
os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(99))
for _ in range(3):
    end = time.monotonic() + 0.03
    while time.monotonic() < end: pass
    time.sleep(0.3)
"""


def module(name, file, priority, kind="thread", **properties):
    values = "".join('<value name="%s">%s</value>' % each for each in properties.items())
    return MODULE % (name, file, kind, 5000000, priority, "<property>%s</property>" % values if values else "")


class Trace(takt_system.Case):
    def deployed(self, *modules, connections=""):
        path = self.write("cell.xml", '<cell name="cell"><device name="robot"><executor name="plc" cpu="0"/>%s</device>%s</cell>'
                          % ("".join(modules), connections))
        node = self.node("robot")
        self.deploy(path)
        return node

    def sound(self, trace):
        """Checks that Chrome can read the trace, and that its spans are consistent. Returns the spans by thread and category."""
        spans = collections.defaultdict(list)
        names = {}
        for event in trace["traceEvents"]:
            self.assertLessEqual({"ph", "pid", "tid", "name"}, set(event))
            if event["ph"] == "M":
                if event["name"] == "thread_name":
                    names[event["tid"]] = event["args"]["name"]
                continue
            self.assertIn(event["ph"], ("X", "i"))
            self.assertGreaterEqual(event["ts"], 0)
            if event["ph"] == "X":
                self.assertGreaterEqual(event["dur"], 0)
                spans[event["tid"], event["cat"]].append(event)
        for (thread, category), events in spans.items():
            self.assertIn(thread, names)
            for before, after in zip(events, events[1:]):
                self.assertGreaterEqual(after["ts"] + 0.002, before["ts"] + before["dur"], (thread, category))
            if category != "run" or (thread, "row") not in spans:
                continue
            rows = iter(spans[thread, "row"])
            row = next(rows)
            for run in events:
                while row["ts"] + row["dur"] + 0.002 < run["ts"] + run["dur"]:
                    row = next(rows)  # each run must lie within a row
                self.assertLessEqual(row["ts"], run["ts"] + 0.002)
        self.assertEqual("takt trace 1", trace["otherData"]["format"])
        return spans

    def trace(self, last=20):
        run = self.takt("trace", "robot", "--last", str(last), "-o", "trace.json", "--json")
        self.assertEqual(0, run.status, run.err)
        trace = json.loads(self.read("trace.json"))
        self.spans = self.sound(trace)
        print(run.out)
        again = self.takt("trace", "trace.json", "--json")
        self.assertEqual(run.out, again.out)
        text = self.takt("trace", "trace.json")
        self.assertEqual(0, text.status, text.err)
        for line in text.out.splitlines():
            self.assertLessEqual(len(line), 100, line)
        return run.report, trace

    def caused(self, report, trace, cause, culprit=None):
        """Checks that at least one delay has this cause, and names `culprit` as the module or program at fault. Returns all delays with
        this cause."""
        found = [e for e in trace["traceEvents"] if e.get("args", {}).get("cause") == cause]
        self.assertTrue(found, "no delay has the cause %s: %s" % (cause, report))
        if culprit is not None:
            self.assertIn(culprit, {e["args"].get("culprit") for e in found})
        return found

    @takt_system.alone("the program slow.exe keeps a CPU busy")
    def test_takt_trace_records_the_rows_and_runs_of_a_running_device(self):
        node = self.deployed(module("source", "port_source.so", 1), module("sink", "port_sink.so", 2),
                             module("slow", "slow.exe", 3, kind="process"),
                             connections='<connection from="robot.source.out" to="robot.sink.in"/>')
        self.wait_for_states({"robot": "EXECUTING"})
        time.sleep(1)
        report, trace = self.trace(last=60)
        executor = report["executors"][0]
        print("rows recorded: %d, entries lost: %d" % (executor["rows"], executor["lost"]))
        self.assertGreater(executor["rows"], 20)
        row = min(tid for tid, category in self.spans if category == "row")
        self.assertEqual({"source", "sink"}, {run["name"] for run in self.spans[row, "run"]})
        names = {event["name"] for event in trace["traceEvents"]}
        self.assertLessEqual({"write source.out", "release slow", "source: START -> EXECUTING"}, names)
        bodies = [events for (_, category), events in self.spans.items() if category == "body"]
        self.assertEqual(["slow"], sorted({body["name"] for events in bodies for body in events}))
        self.end({"robot": node})

    @takt_system.alone("other real-time threads would delay its executor as well")
    def test_takt_trace_names_the_module_whose_overrun_delayed_a_run(self):
        node = self.deployed(module("long", "slow.so", 1, ns=7000000, every=50), module("other", "fine.so", 2))
        self.wait_for_states({"robot": "EXECUTING"})
        time.sleep(1.5)
        report, trace = self.trace()
        self.caused(report, trace, "own overrun", "long")
        self.caused(report, trace, "predecessor", "long")
        self.end({"robot": node})

    @takt_system.alone("other real-time threads would delay its executor as well")
    def test_takt_trace_attributes_a_delay_to_page_faults(self):
        node = self.deployed(module("maps", "maps.so", 1, ns=2000000, every=50), module("other", "fine.so", 2))
        self.wait_for_states({"robot": "EXECUTING"})
        time.sleep(1.5)
        report, trace = self.trace()
        self.caused(report, trace, "page fault", "maps")
        self.end({"robot": node})

    @unittest.skipUnless(os.geteuid() == 0, "needs a priority")
    def test_takt_trace_attributes_a_delay_to_preemption(self):
        node = self.deployed(module("fine", "fine.so", 1))
        self.wait_for_states({"robot": "EXECUTING"})
        time.sleep(0.5)
        subprocess.run([sys.executable, "-c", SPIN, "0"], check=True)
        report, trace = self.trace()
        self.caused(report, trace, "preemption")
        self.end({"robot": node})

    def test_takt_trace_attributes_a_delay_to_a_stopped_host(self):
        node = self.deployed(module("fine", "fine.so", 1))
        self.wait_for_states({"robot": "EXECUTING"})
        time.sleep(0.5)
        host = node.one("takt-host").pid
        os.kill(host, signal.SIGSTOP)
        time.sleep(0.3)
        os.kill(host, signal.SIGCONT)
        time.sleep(0.3)
        report, trace = self.trace()
        # The machine may also have stalled, and then the delay is longer than the time for which the test stopped the host.
        stopped = [e for e in self.caused(report, trace, "preemption") if "a signal stopped its process" in e["args"]["why"]]
        self.assertTrue(stopped, report)
        late = max(stopped, key=lambda e: e["args"]["begins_late_us"])
        self.assertGreater(late["args"]["missed"], 20)
        self.end({"robot": node})

    @takt_system.timing("the rows before the crash must still be in the recorder")
    def test_a_node_writes_a_trace_of_the_last_rows_before_a_crash(self):
        node = self.deployed(module("segv", "segv.so", 1), module("fine", "fine.so", 2))

        def of_the_crash():
            """The name and the content of the trace. On a busy machine, there may also be a trace of missed rows."""
            for name in glob.glob(os.path.join(self.folder, "state", "traces", "robot.*.trace.json")):
                with open(name) as file:
                    trace = json.load(file)
                if "SIGSEGV" in trace["otherData"]["why"]:
                    return name, trace
            return None
        name, trace = wait_until(of_the_crash, "the trace of the crash")
        spans = self.sound(trace)
        print(trace["otherData"])
        died = [run for run in spans[10, "run"] if run.get("args", {}).get("ended") is False]
        self.assertEqual(["segv"], [run["name"] for run in died])
        row = [row for row in spans[10, "row"] if row["args"].get("ended") is False]
        self.assertEqual(1, len(row))
        before = [row for row in spans[10, "row"] if row["ts"] < died[0]["ts"]]
        self.assertGreater(len(before), 20)
        self.assertIn("segv: EXECUTING -> RECOVER", {event["name"] for event in trace["traceEvents"]})
        run = self.takt("trace", name)
        self.assertEqual(0, run.status, run.err)
        self.end({"robot": node})

    def test_takt_trace_reports_a_device_or_file_without_a_trace(self):
        node = self.node("robot")
        self.write("none.json", "{}")
        self.write("text.json", "no")
        self.refused({"trace robot": "device robot has no deployment to trace",
                      "trace none.json": r"none\.json: error: is not a Takt trace",
                      "trace text.json": r"text\.json: error: is not a Takt trace",
                      "trace nothing.json": "is neither an existing file nor a valid device name",
                      "trace robot.m": "give the name of a device, without a module, or of a file that takt trace wrote",
                      "trace robto": r"device robto: error: not found on domain \d+; devices found there: .*; did you mean robot\?",
                      "trace nobody": "device nobody: error: not found on domain"})
        self.assertEqual(2, self.takt("trace", "robot", "--last", "0").status)
        self.end({"robot": node})


if __name__ == "__main__":
    takt_system.main()
