import json
import os
import re
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system

EXAMPLE = os.path.join(takt_system.SOURCE, "deploy", "module.xml")
SCHEDULED = ["controller1", "control2", "control3", "control4", "emergency", "vision"]
TIMES = ["min_ns", "p50_ns", "p99_ns", "p999_ns", "max_ns"]


def line_of(module):
    """Returns the number of the line in deploy/module.xml at which the <module> element begins."""
    with open(EXAMPLE, encoding="utf-8") as file:
        lines = file.read().splitlines()
    found = next(i for i, line in enumerate(lines) if "<filename>" in line and module in line)
    return next(i for i in range(found, -1, -1) if "<module>" in lines[i]) + 1


class Profile(takt_system.Case):
    def profile(self, **longest):
        """Writes a profile in which every module takes 1 us, except for the given times."""
        modules = {}
        for name in SCHEDULED + ["monitoring"]:
            time = longest.get(name, 1000)
            modules["module." + name] = dict({key: time for key in TIMES}, runs=100)
        return self.write("made.json", json.dumps({"cell": "module", "machine": {}, "modules": modules}, indent=1))

    def check(self, file, *more):
        return self.takt("check", EXAMPLE, "--profile", file, "--cpus", "2", *more)

    def worst_cases(self, run):
        return {m["name"]: m for m in run.report["devices"][0]["worst_case"]["modules"]}

    def test_takt_check_reads_the_profile_that_takt_run_writes(self):
        file = os.path.join(self.folder, "profile.json")
        run = self.takt("run", EXAMPLE, "--for", "1", "--json", "--profile", file)
        self.assertEqual(0, run.status, run.err)
        with open(file, encoding="utf-8") as text:
            profile = json.load(text)
        self.assertEqual(["cell", "machine", "modules"], list(profile))
        self.assertEqual("module", profile["cell"])
        self.assertEqual(str(len(os.sched_getaffinity(0))), profile["machine"]["processors"])
        reported = run.modules()
        self.assertEqual({"module." + name for name in reported}, set(profile["modules"]))
        for name in SCHEDULED:
            times = profile["modules"]["module." + name]
            self.assertEqual(["runs"] + TIMES, list(times))
            self.assertGreater(times["runs"], 0)
            self.assertLessEqual(times["runs"], reported[name]["cycles"])
            self.assertAlmostEqual(reported[name]["run_us"]["max"] * 1000, times["max_ns"], delta=1)
            self.assertGreater(times["min_ns"], 0)
            self.assertEqual(sorted(times[key] for key in TIMES), [times[key] for key in TIMES])

        # On a machine that other programs use, the measured run times may exceed a period of 100 us.
        report = self.check(file, "--json")
        self.assertIn(report.status, (0, 1))
        worst = self.worst_cases(report)
        self.assertEqual(SCHEDULED, list(worst))
        for name, case in worst.items():
            self.assertEqual(profile["modules"]["module." + name]["max_ns"], case["run_ns"])
        refused = re.findall(r"^\S*module\.xml:(\d+): error: 'module\.(\w+)' cannot keep its (?:period|deadline)", report.err,
                             re.MULTILINE)
        self.assertEqual([(str(line_of(name)), name) for name in SCHEDULED if not worst[name]["kept"]], refused, report.err)
        self.assertEqual(1 if refused else 0, report.status)

    def test_takt_check_reports_the_response_time_and_slack_of_each_module(self):
        run = self.check(self.profile(), "--json")
        self.assertEqual((0, ""), (run.status, run.err))
        proof = run.report["devices"][0]["worst_case"]
        self.assertEqual((2, 1, "profile"), (proof["processors"], proof["factor"], proof["run_times"]))
        worst = self.worst_cases(run)
        # In row 0, control3, control2 and controller1 run in this order.
        self.assertEqual([1000, 2000, 3000], [worst[name]["response_ns"] for name in ("control3", "control2", "controller1")])
        self.assertEqual((600000, 597000, True, [1]), tuple(worst["controller1"][key] for key in
                                                             ("deadline_ns", "slack_ns", "kept", "cpus")))
        self.assertEqual([0], worst["vision"]["cpus"])
        self.assertNotIn("monitoring", worst)
        text = self.check(self.profile())
        self.assertEqual((0, ""), (text.status, text.err))
        self.assertIn("worst-case response times, computed from the profile, on 2 CPUs", text.out)
        self.assertRegex(text.out, r"controller1 +1 +1 us +3 us +600 us +597 us +kept")

    def test_takt_check_rejects_a_module_that_cannot_meet_its_deadline(self):
        run = self.check(self.profile(emergency=70000))
        self.assertEqual(1, run.status)
        self.assertRegex(run.err, r"^%s:%d: error: 'module\.emergency' cannot keep its deadline, 100 us: it may finish as late as .* "
                                  r"after its release, .* too late; shorten the runs, " % (re.escape(EXAMPLE), line_of("emergency")))
        self.assertEqual(1, len(run.err.splitlines()))
        self.assertRegex(run.out, r"(?m)^ +emergency .*NOT KEPT$")
        self.assertEqual(0, self.check(self.profile(emergency=20000)).status)
        self.assertEqual(1, self.check(self.profile(emergency=20000), "--factor", "10").status)
        overloaded = self.check(self.profile(control2=99500))
        self.assertIn(":%d: error: 'module.control2' cannot keep its period, 100 us: the work does not fit into the available time"
                      % line_of("control2"), overloaded.err)

    def test_takt_check_rejects_an_invalid_profile_or_one_from_another_cell(self):
        with open(self.profile(), encoding="utf-8") as file:
            good = json.load(file)
        other = dict(good, cell="other")
        less = dict(good, modules={k: v for k, v in good["modules"].items() if k != "module.control3"})
        negative = json.loads(json.dumps(good))
        negative["modules"]["module.control2"]["max_ns"] = -1
        cases = {
            "absent.json": (None, r"^\S*absent\.json: error: there is no such file; create a profile with takt run --profile FILE$"),
            "text.json": ("{\n no", r"^\S*text\.json:2: error: the file is not JSON; "),
            "list.json": ("[]", r"^\S*list\.json:1: error: the file is not a profile; "),
            "negative.json": (json.dumps(negative, indent=1), r"^\S*negative\.json:\d+: error: \"max_ns\" of 'module\.control2' is "
                                                              r"-1; write a whole number from 0 to 2\^63 - 1$"),
            "other.json": (json.dumps(other), r"^\S*module\.xml:\d+: error: the profile belongs to cell 'other', "
                                              r"but this cell is 'module'; "),
            "less.json": (json.dumps(less), r"^\S*module\.xml:%d: error: the run time of 'module\.control3' is not known; add a "
                                            r"<budget>, " % line_of("control3")),
        }
        for name, (content, message) in cases.items():
            with self.subTest(name=name):
                file = os.path.join(self.folder, name) if content is None else self.write(name, content)
                run = self.check(file)
                self.assertEqual((1, ""), (run.status, run.out))
                self.assertEqual(1, len(run.err.splitlines()), run.err)
                self.assertRegex(run.err, message)

    def test_takt_run_reports_a_profile_file_that_it_cannot_write(self):
        run = self.takt("run", EXAMPLE, "--for", "0.1", "--json", "--profile", os.path.join(self.folder, "nowhere", "p.json"))
        self.assertEqual(1, run.status)
        self.assertRegex(run.err, r"nowhere/p\.json: error: cannot be written: the folder \S+/nowhere does not exist; create it, or choose another file")
        self.assertEqual("module", run.report["cell"])

    def test_takt_check_exits_with_status_2_on_invalid_profile_options(self):
        for arguments in (["--factor", "0.5"], ["--factor", "nan"], ["--factor", "x"], ["--cpus", "0"], ["--profile"]):
            self.assertEqual(2, self.takt("check", EXAMPLE, *arguments).status, arguments)

    def test_takt_check_proves_all_deadlines_if_every_module_has_a_budget(self):
        def cell(run):
            module = """<module><name>%s</name><filename>none.so</filename><moduletype>thread</moduletype>
              <operationtype>periodic</operationtype><period>%d</period><priority>1</priority><executor>%s</executor>%s</module>"""
            fast = module % ("fast", 1000000, "e", "<budget>600000</budget>")
            slow = module % ("slow", 4000000, "f", run)
            return self.write("cell.xml", """<cell name="c"><device name="d"><executor name="e" cpu="1" priority="80"/>
              <executor name="f" cpu="1" priority="70"/>%s%s</device></cell>""" % (fast, slow))

        held = self.takt("check", cell("<budget>500000</budget>"), "--remote")
        self.assertEqual(0, held.status, held.err)
        self.assertIn("worst-case response times, computed from the budgets", held.out)
        late = self.takt("check", cell("<budget>1500000</budget>"), "--remote", "--cpus", "2")
        self.assertEqual(1, late.status)
        self.assertIn("'d.slow' cannot keep its period, 4 ms", late.err)
        self.assertNotIn("'d.fast' cannot", late.err)
        self.assertNotIn("worst case", self.takt("check", cell(""), "--remote").out)


if __name__ == "__main__":
    takt_system.main()
