import json
import os
import re
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system

DEMO = os.path.join(takt_system.SOURCE, "deploy", "palletizing.xml")
EXAMPLE = os.path.join(takt_system.SOURCE, "deploy", "module.xml")


class Simulate(takt_system.Case):
    def trace(self, *arguments, status=0):
        run = self.takt("simulate", *arguments, "--trace", "trace.txt")
        self.assertEqual(status, run.status, run.err)
        with open(os.path.join(self.folder, "trace.txt"), "rb") as file:
            return file.read()

    def test_two_simulations_with_the_same_seed_write_identical_traces(self):
        faults = ("--faults", "20", "--for", "0.5")
        # With the seeds of this test, each module that fails recovers, so the exit status must be 0.
        first = self.trace(DEMO, "--seed", "1", "--for", "1", "--script", self.beside("faults.txt"))
        self.assertGreater(len(first), 100000)
        self.assertEqual(first, self.trace(DEMO, "--seed", "1", "--for", "1", "--script", self.beside("faults.txt")))
        self.assertNotEqual(first, self.trace(DEMO, "--seed", "2", "--for", "1", "--script", self.beside("faults.txt")))
        random = self.takt("simulate", DEMO, *faults, "--seed", "5", "--trace", "-")
        again = self.takt("simulate", DEMO, *faults, "--seed", "5", "--trace", "-")
        self.assertGreater(len(random.out), 100000)
        self.assertEqual(random.out, again.out)

    def test_takt_simulate_and_takt_run_print_reports_in_the_same_format(self):
        run = self.takt("simulate", EXAMPLE, "--for", "2", "--json")
        self.assertEqual(0, run.status, run.err)
        self.assertEqual(["cell", "devices"], list(run.report))
        self.assertEqual(["name", "alive", "real_time", "executors", "modules"], list(run.report["devices"][0]))
        executor = run.executor()
        self.assertEqual(["name", "cycles", "missed", "margin_us", "jitter_us"], list(executor))
        self.assertEqual(20000, executor["cycles"] + executor["missed"])
        modules = run.modules()
        self.assertEqual(["controller1", "control2", "control3", "control4", "emergency", "vision", "monitoring"], list(modules))
        for name, m in modules.items():
            self.assertEqual(["name", "type", "operation", "state", "cycles", "overruns", "errors", "jitter_us", "run_us", "pid"],
                             list(m)[:10], name)
        self.assertEqual(executor["cycles"], modules["control2"]["cycles"])
        self.assertGreater(modules["emergency"]["cycles"], 0)
        text = self.takt("simulate", EXAMPLE, "--for", "0.1")
        self.assertIn("cell module", text.out)
        self.assertIn("takt status --help explains the columns", text.out)

    def test_takt_simulate_injects_each_fault_of_a_script_at_the_given_time(self):
        lines = self.trace(DEMO, "--for", "1.5", "--script", self.beside("faults.txt")).decode().splitlines()

        def has(pattern):
            self.assertTrue(any(re.search(pattern, line) for line in lines), pattern)

        has(r"^\+0\.20[4-9]\d+ robot executor motion ran row 20[4-5], .*, missed rows before it: [3-4]$")
        has(r"^\+0\.40\d+ robot\.servo EXECUTING -> RECOVER, step 4, failure")
        has(r"robot\.servo RECOVER -> EXECUTING, step 5$")
        has(r"^\+0\.6\d+ line\.counter EXECUTING -> RECOVER, step 4, crash")
        has(r"line\.counter RECOVER -> EXECUTING, step 5$")
        self.assertEqual(3, sum(1 for line in lines if line.endswith("is lost") and "station.panel.arm" in line))
        has(r"^\+0\.900000000 station fault \(at 900000 us station clock-step -2000 us\)$")
        has(r"^\+1\.00[3-4]\d+ robot executor motion woke 300\d+ ns after its release$")
        # Every line begins with its time, and the times never decrease.
        times = [float(line.split(" ")[0]) for line in lines]
        self.assertEqual(sorted(times), times)

    def test_the_script_of_takt_simulate_updates_and_undeploys_the_cell(self):
        with open(DEMO) as file:
            new = self.write("new.xml", file.read().replace("<period>1ms</period>", "<period>2ms</period>"))
        script = self.write("script.txt", "at 500 ms update\nat 2 s line down for 300 ms\nat 3 s undeploy\nat 4 s deploy\n")
        run = self.takt("simulate", DEMO, "--for", "6", "--script", script, "--update", new, "--trace", "trace.txt")
        self.assertEqual(0, run.status, run.err)
        reports = [line for line in run.err.splitlines() if line.startswith("takt: operator: ")]
        self.assertEqual(["takt: operator: %s: done" % action for action in ("update", "undeploy", "deploy")], reports)
        with open(os.path.join(self.folder, "trace.txt")) as file:
            begins = re.findall(r"^(\S+) (\w+) begins, with T0 at (\S+)$", file.read(), re.MULTILINE)
        # The update restarts devices on the same time grid. So does the node of the line after its loss of power.
        self.assertIn("robot", [device for at, device, t0 in begins if 0.5 < float(at) < 2 and float(t0) == 0])
        self.assertEqual(["line"], [device for at, device, t0 in begins if 2 < float(at) < 3 and float(t0) == 0])
        self.assertEqual(["line", "robot", "station"], sorted(device for at, device, t0 in begins if 4 < float(at) < float(t0)))

        wrong = self.takt("simulate", DEMO, "--script", script)
        self.assertEqual((1, ""), (wrong.status, wrong.out))
        self.assertIn("the script updates the cell, but no new descriptor is given; give it with --update FILE", wrong.err)
        other = self.takt("simulate", DEMO, "--script", script, "--update", EXAMPLE)
        self.assertEqual((1, ""), (other.status, other.out))
        self.assertIn("the update has other devices than the cell", other.err)
        lost = self.takt("simulate", DEMO, "--for", "2", "--update", new,
                         "--script", self.write("lost.txt", "at 500 ms robot down for 1 s\nat 1 s update\n"))
        self.assertEqual(1, lost.status)
        self.assertIn("takt: operator: update: failed; the devices run what they ran before: device robot: it is not found", lost.err)

    def test_takt_simulate_reports_the_line_of_each_error_in_a_fault_script(self):
        wrong = self.beside("wrong.txt")
        run = self.takt("simulate", DEMO, "--for", "1", "--script", wrong, "--trace", "trace.txt")
        self.assertEqual((1, ""), (run.status, run.out))
        self.assertEqual(["%s:%d: error: " % (wrong, line) for line in (1, 4, 5)],
                         [re.match(r".*?:\d+: error: ", text)[0] for text in run.err.splitlines()])
        self.assertIn("did you mean robot?", run.err)
        self.assertFalse(os.path.exists(os.path.join(self.folder, "trace.txt")))
        absent = self.takt("simulate", DEMO, "--script", "absent.txt")
        self.assertEqual((1, ""), (absent.status, absent.out))
        self.assertIn("absent.txt: error: ", absent.err)

    def test_takt_simulate_warns_about_lines_of_a_script_that_have_no_effect(self):
        script = self.write("late.txt", "at 2 s robot.servo crash\nat 0.5 s line.camera swap\nat 0.5 s robot.servo swap\n")
        run = self.takt("simulate", DEMO, "--for", "1", "--script", script)
        warnings = [line for line in run.err.splitlines() if "has no effect" in line]
        self.assertEqual(["takt: warning: 'at 2000000 us robot.servo crash' has no effect: the simulation ends before; use a longer --for",
                          "takt: warning: 'at 500000 us line.camera swap' has no effect: the module is a program, and only a thread module "
                          "can be swapped"], warnings)

    def test_takt_simulate_generates_the_same_random_cell_from_the_same_seed(self):
        traces = [self.takt("simulate", "--random-cell", str(n), "--trace", "-") for n in (3, 3, 4)]
        for run in traces:
            self.assertNotIn("violated an invariant", run.err)
        self.assertEqual(traces[0].out, traces[1].out)
        self.assertNotEqual(traces[0].out, traces[2].out)

    def test_takt_simulate_exits_with_status_2_on_invalid_arguments(self):
        for arguments in ([], [DEMO, "--for", "0"], [DEMO, "--for", "soon"], [DEMO, "--cpus", "0"], [DEMO, "--random-cell", "1"],
                          [DEMO, "--faults", "-1"], [DEMO, "--faults", "nan"], [DEMO, "--for", "nan"], [DEMO, "--seed", "x"],
                          [DEMO, "--seed", "-1"], [DEMO, "--seed", "99999999999999999999"], [DEMO, "--trace", "-", "--json"],
                          ["--random-cell", "-1"], ["--random-cell", "1", "--for", "1"], ["--random-cell", "1", "--seed", "2"]):
            with self.subTest(arguments=arguments):
                run = self.takt("simulate", *arguments)
                self.assertEqual((2, ""), (run.status, run.out), run.err)
        self.assertIn("robot.servo late 3 ms", self.takt("simulate", "--help").out)
        nowhere = self.takt("simulate", DEMO, "--trace", os.path.join(self.folder, "no", "trace.txt"))
        self.assertEqual((1, ""), (nowhere.status, nowhere.out))
        self.assertIn("cannot be written", nowhere.err)

    def test_takt_simulate_warns_about_modules_with_unknown_run_times(self):
        guessed = self.takt("simulate", DEMO, "--for", "0.1")
        self.assertRegex(guessed.err, r"warning: the run times of these modules are not known.*robot\.trajectory.*line\.conveyor")
        times = '{"runs": 9, "min_ns": 1000, "p50_ns": 2000, "p99_ns": 3000, "p999_ns": 4000, "max_ns": 5000}'
        cell = json.loads(self.takt("check", DEMO, "--json").out)
        names = [d["name"] + "." + m for d in cell["devices"] for e in d["executors"] for m in set(sum(e["rows"], [])) | set(e["sporadic"])]
        profile = '{"cell": "palletizing", "machine": {}, "modules": {%s}}' % ", ".join('"%s": %s' % (n, times) for n in names)
        known = self.takt("simulate", DEMO, "--for", "1", "--json", "--profile", self.write("times.json", profile))
        self.assertEqual(0, known.status, known.err)
        self.assertNotIn("are not known", known.err)
        for m in known.report["devices"][0]["modules"]:
            self.assertLessEqual(m["run_us"]["max"], 5.5, m["name"])
        for broken in (profile.replace("palletizing", "other"), profile.replace("line.conveyor", "line.ghost"), "{"):
            refused = self.takt("simulate", DEMO, "--for", "1", "--profile", self.write("broken.json", broken))
            self.assertEqual((1, ""), (refused.status, refused.out))
            self.assertIn("error: ", refused.err)

    def test_takt_simulate_prints_its_speed_relative_to_real_time(self):
        run = self.takt("simulate", DEMO, "--for", "100")
        self.assertEqual(0, run.status, run.err)
        print("\n" + run.err)
        self.assertRegex(run.err, r"simulated 100 s in [\d.]+ s, \d+ times real time; seed 1")
        self.assertIn("every module writes each of its outputs in every run, so a queue may drop samples", run.err)


if __name__ == "__main__":
    takt_system.main()
