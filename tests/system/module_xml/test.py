import json
import os
import re
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system

EXAMPLE = os.path.join(takt_system.SOURCE, "deploy", "module.xml")
MODULES = ["controller1", "control2", "control3", "control4", "emergency", "vision", "monitoring"]
BOTH = ["control3", "control2"]
FIGURES_3_AND_4 = {
    "cell": "module",
    "devices": [{
        "name": "module",
        "executors": [{
            "name": "main",
            "basic_period_ns": 100000,
            "macro_period_ns": 600000,
            "rows": [BOTH + ["controller1", "control4"], BOTH, BOTH, BOTH + ["control4"], BOTH, BOTH],
            "sporadic": ["emergency", "vision"],
        }],
        "non_realtime": ["monitoring"],
    }],
}
STATISTICS = ["mean", "variance", "min", "p50", "p99", "p999", "max"]


class ModuleXml(takt_system.Case):
    def test_takt_check_prints_json_in_the_documented_format(self):
        run = self.takt("check", EXAMPLE, "--json")
        self.assertEqual(0, run.status, run.err)
        self.assertEqual("", run.err)
        self.assertEqual(FIGURES_3_AND_4, run.report)
        self.assertEqual(list(FIGURES_3_AND_4), list(run.report), "the keys must have the documented order")

    def test_takt_check_prints_the_tables_of_the_paper(self):
        run = self.takt("check", EXAMPLE)
        self.assertEqual(0, run.status, run.err)
        self.assertIn("basic period 100 us, macro period 600 us, 6 rows", run.out)
        rows = re.findall(r"^ +(\d+(?:-\d+)?) +[\d.]+ \w+ +(\w.*)$|^ +(\d+) +0 \w+ +(\w.*)$", run.out, re.MULTILINE)
        found = {a or c: [name.split(" ")[0] for name in (b or d).split(", ")] for a, b, c, d in rows}
        expected = {}
        table = FIGURES_3_AND_4["devices"][0]["executors"][0]["rows"]
        for name in found:
            first = int(name.split("-")[0])
            expected[name] = table[first]
        self.assertEqual(["0", "1-2", "3", "4-5"], list(found), run.out)
        self.assertEqual(expected, found)
        sporadic = re.findall(r"^ +(emergency|vision) +(thread|process) +(\d+ \w+) +(\d)", run.out, re.MULTILINE)
        self.assertEqual([("emergency", "thread", "100 us", "1"), ("vision", "process", "10 ms", "2")], sporadic)
        self.assertRegex(run.out, r"not real-time: +monitoring")

    def test_in_the_report_of_the_papers_example_executed_and_missed_rows_add_up(self):
        run = self.start("run", EXAMPLE, "--for", "10", "--json")
        run.wait_for_state("monitoring", "EXECUTING")
        programs = sorted(p.program for p in run.processes())
        pids = {p.program: p.pid for p in run.processes()}
        self.assertEqual(sorted(["takt", "takt-node", "takt-host", "control4.exe", "vision.exe", "monitoring.exe"] + 3 * ["takt-keeper"]), programs)
        run.wait()
        self.assertEqual(0, run.status, run.err)
        self.assertEqual([], run.other_lines)

        report = run.report
        self.assertEqual(["cell", "devices"], list(report))
        self.assertEqual("module", report["cell"])
        self.assertEqual(["name", "alive", "real_time", "executors", "modules"], list(report["devices"][0]))
        executor = run.executor()
        self.assertEqual(["name", "cycles", "missed", "jitter_us"], list(executor))
        self.assertEqual(STATISTICS, list(executor["jitter_us"]))
        modules = run.modules()
        self.assertEqual(MODULES, list(modules))
        for name, m in modules.items():
            self.assertEqual(["name", "type", "operation", "state", "cycles", "overruns", "errors", "jitter_us", "run_us", "pid"],
                             list(m))
            for statistics in (m["jitter_us"], m["run_us"]):
                self.assertEqual(STATISTICS, list(statistics))
                self.assertTrue(all(isinstance(x, float) for x in statistics.values()), statistics)
            self.assertEqual(takt_system.LIFE, run.states(name))
            self.assertEqual("DESTRUCT", m["state"])
            self.assertEqual(0, m["errors"])
            program = name + ".exe" if m["type"] == "process" else "takt-host"
            self.assertEqual(pids[program], m["pid"], name)

        # The grid has a row every 100 us, from T0 until takt run begins to end the cell.
        rows = executor["cycles"] + executor["missed"]
        self.assertLess(abs(rows - 100000), 20000)
        self.assertEqual(executor["cycles"], modules["control2"]["cycles"])
        self.assertEqual(executor["cycles"], modules["control3"]["cycles"])
        self.assert_grid(run, "controller1", every=6)
        self.assert_grid(run, "control4", every=3)
        # Each row releases a sporadic program, unless its body is still running.
        self.assertGreater(modules["vision"]["cycles"], 0)
        self.assertLessEqual(modules["vision"]["cycles"], executor["cycles"])
        self.assertGreater(modules["emergency"]["cycles"], 0)
        self.assertEqual(0, modules["monitoring"]["cycles"])

        # The modules must count the same number of releases as the scheduler. Only the last release of a program may be missing, because
        # the shutdown can interrupt it.
        for name in ("control4", "vision"):
            counted = int(re.search(r"(\d+) releases", " ".join(run.printed(name)))[1])
            self.assertIn(modules[name]["cycles"] - counted, (0, 1), name)
        self.assertIn("of %d periods" % modules["control2"]["cycles"], " ".join(line.text for line in run.said("(host)")))
        self.assertRegex(" ".join(run.printed("monitoring")), r"load .* monitoring: ended after \d+ lines")

    def test_every_module_completes_a_start_up_step_before_any_module_takes_the_next(self):
        run = self.takt("run", EXAMPLE, "--for", "1")
        self.assertEqual(0, run.status, run.err)
        order = [run.lines.index(line) for state in ("INITIALIZE", "START", "EXECUTING")
                 for line in run.lines if re.match(r"\w+ -> %s" % state, line.text) and "EXECUTING -> START" not in line.text]
        self.assertEqual(21, len(order))
        self.assertEqual(sorted(order), order)


if __name__ == "__main__":
    takt_system.main()
