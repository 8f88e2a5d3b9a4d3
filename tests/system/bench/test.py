import os
import signal
import subprocess
import sys
import tempfile
import time
from html.parser import HTMLParser

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import wait_until

TIMES = ["p50_us", "p90_us", "p99_us", "p99.9_us", "max_us"]
JITTER = ["count", "mean", "variance", "min", "p50", "p90", "p99", "p999", "max"]


def thread_names(pid):
    names = set()
    for thread in os.listdir("/proc/%d/task" % pid):
        try:
            with open("/proc/%d/task/%s/comm" % (pid, thread)) as name:
                names.add(name.read().strip())
        except OSError:
            pass  # the thread has ended
    return names


class Page(HTMLParser):
    """Counts the elements of a page and collects their links."""

    def __init__(self, text):
        super().__init__()
        self.elements = {}
        self.references = []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.elements[tag] = self.elements.get(tag, 0) + 1
        self.references += [value for name, value in attributes if name in ("href", "src", "xlink:href", "action", "data")]


class Bench(takt_system.Case):
    def measured(self, *arguments, limit=3 * takt_system.LONG):
        run = self.takt("bench", *arguments, "--json", limit=limit)
        self.assertEqual((0, ""), (run.status, run.err))
        for key in ("name", "processors", "kernel", "governor", "isolated", "load"):
            self.assertIn(key, run.report["machine"])
        return run.report

    def rows(self, report, section):
        return {row["name"]: row for row in report["sections"][section]["rows"]}

    @takt_system.alone("each run lasts 0.2 s, and the test counts every row of it")
    def test_takt_bench_table1_measures_ten_cases_and_reports_them_in_html(self):
        page = os.path.join(self.folder, "table1.html")
        report = self.measured("table1", "--for", "0.2", "--html", page)
        self.assertEqual(("table1", 100), (report["benchmark"], report["period_us"]))
        self.assertEqual(list(range(1, 11)), [case["case"] for case in report["cases"]])
        self.assertEqual(["thread"] * 3 + ["process"] + ["thread", "process"] * 3, [case["measured"] for case in report["cases"]])
        for case in report["cases"]:
            with self.subTest(case=case["case"]):
                self.assertEqual(JITTER, list(case["jitter_us"]))
                self.assertEqual(JITTER, list(case["bare_us"]))
                self.assertGreater(case["jitter_us"]["count"], 0)
                self.assertGreater(case["bare_us"]["count"], 0)
                # In 0.2 s there are 2000 periods of 100 us. Each of them counts as served or as missed.
                self.assertGreaterEqual(case["bare_us"]["count"] + case["bare_missed"], 2000)
                self.assertGreaterEqual(case["cycles"] + case["missed"], 2000)
                self.assertLessEqual(case["jitter_us"]["count"], case["cycles"])
                self.assertIn(case["verdict"], ("held", "more modules than cores", "not held"))
                self.assertEqual(case["verdict"] == "held", case["why"] == "")
        with open(page, encoding="utf-8") as file:
            text = file.read()
        self.assertNotIn("http", text)
        subprocess.run(["xmllint", "--noout", page], check=True)
        seen = Page(text)
        self.assertEqual(20, seen.elements["svg"])
        self.assertNotIn("script", seen.elements)
        self.assertTrue(all(reference.startswith("#case") for reference in seen.references), seen.references)

    def test_takt_bench_table1_measures_with_the_period_given_as_an_option(self):
        run = self.takt("bench", "table1", "--for", "0.05", "--period", "1000", limit=3 * takt_system.LONG)
        self.assertEqual((0, ""), (run.status, run.err))
        self.assertIn("at a basic period of 1 ms", run.out)
        self.assertEqual(10, len([line for line in run.out.splitlines() if " paper " in line]))

    @takt_system.alone("the benchmark keeps a CPU busy")
    def test_takt_bench_dispatch_measures_tables_of_up_to_a_thousand_modules(self):
        report = self.measured("dispatch", "--for", "0.1")
        self.assertEqual(["10 modules", "100 modules", "1000 modules"], list(self.rows(report, 0)))
        recorded = self.rows(report, 1)
        self.assertEqual(["10 modules", "100 modules", "1000 modules"], list(recorded))
        for row in recorded.values():
            self.assertGreater(row["a_bare_entry"], 0)
        thousand = self.rows(report, 2)
        self.assertEqual(["one table", "bare calls", "one thread per module"], list(thousand))
        self.assertGreater(thousand["one table"]["processor"], 0)
        self.assertTrue(any("Besides the modules' own work" in note for note in report["sections"][2]["notes"]))

    @takt_system.alone("the benchmark keeps a CPU busy")
    def test_takt_bench_wake_compares_all_wake_up_strategies(self):
        report = self.measured("wake", "--for", "0.1")
        for section in (0, 1):
            rows = self.rows(report, section)
            self.assertEqual(["bare loop", "sleep", "hybrid", "spin"], list(rows))
            for row in rows.values():
                self.assertEqual(["name"] + TIMES + ["cycles", "missed", "processor_%"], list(row))

    def test_takt_bench_process_compares_three_ways_to_wake_a_process(self):
        rows = self.rows(self.measured("process", "--for", "0.2"), 0)
        self.assertEqual(["process module", "futex", "signal"], list(rows))
        for row in rows.values():
            self.assertGreater(row["cycles"], 0)

    def test_takt_bench_ports_compares_the_speed_of_ports_and_memcpy(self):
        rows = self.rows(self.measured("ports", "--for", "0.1"), 0)
        self.assertEqual(1, rows["memcpy to a buffer and back"]["of_memcpy"])
        self.assertEqual(11, len(rows))
        self.assertEqual(3, len([name for name in rows if "with a safe value" in name]))

    def test_takt_bench_cell_deploys_a_cell_and_receives_its_samples(self):
        report = self.measured("cell", "--for", "1", "--devices", "2")
        self.assertEqual(["start of all nodes, until discovered", "takt deploy", "takt status", "takt undeploy"], list(self.rows(report, 0)))
        for row in self.rows(report, 1).values():
            self.assertGreater(row["samples"], 0)

    def test_an_interrupted_benchmark_leaves_no_processes_and_files_behind(self):
        for command, program in (("table1", "takt-host"), ("cell", "takt-host"), ("process", "bench_periodic_process.exe")):
            with self.subTest(command=command):
                before = set(os.listdir(tempfile.gettempdir()))
                run = self.start("bench", command, "--for", "2")
                wait_until(lambda: run.processes(program))
                run.signal(signal.SIGINT)
                run.wait()
                self.assertEqual(1, run.status)
                self.assertIn("ended by a signal before everything was measured", run.err)
                left = {name for name in set(os.listdir(tempfile.gettempdir())) - before if name.startswith("takt-bench-%d-" % run.pid)}
                self.assertEqual(set(), left)

    def test_takt_bench_exits_with_status_2_on_invalid_arguments(self):
        for arguments in ([], ["nonsense"], ["table1", "more"], ["table1", "--for", "0"], ["table1", "--for", "soon"], ["table1", "--period", "1"],
                          ["table1", "--cpu", "-1"], ["wake", "--html", "x"], ["ports", "--period", "100"], ["cell", "--devices", "1"]):
            with self.subTest(arguments=arguments):
                run = self.takt("bench", *arguments)
                self.assertEqual((2, ""), (run.status, run.out), run.err)
                self.assertIn("Usage: takt", run.err)

    def test_with_the_option_load_takt_bench_runs_a_background_load(self):
        with open(os.path.join(self.folder, "stress-ng"), "w") as file:
            file.write('#!/bin/sh\necho "$$ $*" > %s/load\nexec sleep 1000\n' % self.folder)
        os.chmod(file.name, 0o755)
        run = self.takt("bench", "wake", "--for", "0.2", "--load", "--json",
                        environment={"PATH": "%s:%s" % (self.folder, os.environ["PATH"])})
        self.assertEqual((0, ""), (run.status, run.err))
        pid, arguments = self.read("load").split(" ", 1)
        self.assertEqual("stress-ng " + arguments.strip(), run.report["load"])
        self.assertFalse(os.path.exists("/proc/" + pid))

    def test_takt_bench_wake_shows_a_delay_that_is_longer_than_the_period(self):
        run = self.start("bench", "wake", "--period", "1000", "--for", "1", "--json")
        for _ in range(3):
            wait_until(lambda: "bench" in thread_names(run.pid), "a thread that measures")
            run.halt()
            time.sleep(0.1)
            run.signal(signal.SIGCONT)
        run.wait()
        self.assertEqual(0, run.status, run.err)
        self.assertGreater(max(way["max_us"] for way in run.report["sections"][0]["rows"]), 50_000)

    def test_takt_bench_reports_that_it_measured_without_real_time_rights(self):
        if os.geteuid() != 0:
            self.skipTest("needs root, to give it up")
        run = self.takt("bench", "wake", "--for", "0.1", "--json", before=["setpriv", "--inh-caps=-all", "--bounding-set=-all"])
        self.assertEqual(0, run.status, run.err)
        self.assertIn("SCHED_FIFO 80 is denied", " ".join(run.report["refused"]))

    def test_takt_bench_checks_its_requirements_before_it_measures(self):
        run = self.takt("bench", "table1", "--html", os.path.join(self.folder, "nowhere", "x.html"))
        self.assertEqual((1, ""), (run.status, run.out))
        self.assertIn("cannot be written", run.err)
        alone = self.takt("bench", "wake", "--load", "--for", "0.05", environment={"PATH": self.folder})
        self.assertEqual((1, ""), (alone.status, alone.out))
        self.assertIn("stress-ng, which --load runs, is not installed", alone.err)
        self.assertIn("apt-get install stress-ng", alone.err)


if __name__ == "__main__":
    takt_system.main()
