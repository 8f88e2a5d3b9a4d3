import os
import re
import signal
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import LIFE, wait_until

STARTED = LIFE[:4]
AGAIN = ["RECOVER", "EXECUTING"]
HUNG = "hang: the process did not return to waitPeriod() within 1.02 s and was killed"


class Processes(takt_system.Case):
    def assert_others_unaffected(self, run):
        for module, every in (("steady", 1), ("program", 2)):
            self.assertEqual(LIFE, run.states(module))
            self.assert_grid(run, module, every=every)

    def assert_recovered_then_given_up(self, run, module, reason, attempts):
        self.assertEqual(STARTED + AGAIN * attempts + ["RECOVER", "DESTRUCT"], run.states(module))
        reasons = {step.text for step in run.steps(module) if step.target == "RECOVER"}
        self.assertEqual({reason}, reasons)
        self.assertEqual(attempts + 1, run.modules()[module]["errors"])
        device = run.device()["name"]
        self.assertEqual(1, sum(line.startswith("module %s.%s: error: was given up: %s; " % (device, module, reason))
                                for line in run.other_lines), run.other_lines)

    def test_a_program_that_ends_after_every_restart_is_given_up(self):
        run = self.takt("run", "ends.xml", "--for", "4", "--json")
        self.assertEqual(1, run.status)
        modules = run.modules()
        self.assert_recovered_then_given_up(run, "exits", "crash: the process ended with status 3", 2)
        self.assert_recovered_then_given_up(run, "crashes", "crash: the process was killed by SIGSEGV (Segmentation fault)", 2)
        # For a program that gets releases, exit status 0 is an error too.
        self.assert_recovered_then_given_up(run, "leaves", "crash: the process ended with status 0", 0)
        # A program that ends during its first release was EXECUTING before that, if only for a moment.
        self.assert_recovered_then_given_up(run, "first_row", "crash: the process ended with status 0", 3)
        for module, releases, lives in (("exits", 50, 3), ("crashes", 50, 3), ("leaves", 50, 1), ("first_row", 1, 4)):
            # Each process ends by itself after this many releases. While it ends, at most one more release may be counted.
            self.assertIn(modules[module]["cycles"] - releases * lives, range(lives + 1), module)
        self.assertEqual(4, len(run.other_lines), run.other_lines)
        self.assert_others_unaffected(run)

    def test_a_program_keeps_running_after_an_overrun(self):
        run = self.takt("run", "late.xml", "--for", "1", "--json")
        self.assertEqual(0, run.status, run.err)
        self.assertEqual(LIFE, run.states("late"))
        late = run.modules()["late"]
        self.assertEqual(0, late["errors"])
        # Every tenth body takes one and a half periods, so the next row finds the program busy, unless the executor missed that row or it
        # was the last row.
        self.assertGreaterEqual(late["overruns"] + run.executor()["missed"], late["cycles"] // 10 - 1)
        self.assertGreater(late["overruns"], 0)
        self.assert_grid(run, "late", every=5)
        self.assertEqual(LIFE, run.states("steady"))
        self.assert_grid(run, "steady")

    def test_the_run_report_counts_each_missed_deadline_of_a_sporadic_program(self):
        run = self.takt("run", "deadline.xml", "--for", "1", "--json")
        self.assertEqual(0, run.status, run.err)
        held = int(re.search(r"condition held (\d+) times", " ".join(run.printed("late")))[1])
        self.assertGreater(held, 5)
        # Every body takes too long. More releases may be late, and the shutdown may interrupt the last body.
        self.assertGreaterEqual(run.modules()["late"]["overruns"], held - 1)
        self.assertEqual(LIFE, run.states("late"))

    def test_a_program_that_never_calls_the_takt_interface_prevents_the_start_of_the_device(self):
        reasons = {
            "never_attaches": "did not call initPeriodExe() within 5 s",
            "never_waits": "did not call waitPeriod() within 5 s",
            "exits_at_once": "was given up: the process ended with status 7",
            "crashes_at_once": "was given up: the process was killed by SIGSEGV (Segmentation fault)",
            "wrong_kind": "the process ended with status 1; its last line was: takt: initSporadicExe(): the descriptor "
                          "declares the module periodic; use initPeriodExe() and waitPeriod(); it had not called initPeriodExe()",
        }
        runs = {name: self.start("run", name + ".xml", "--for", "5", "--json") for name in reasons}  # in parallel, because no module runs
        for name, run in runs.items():
            with self.subTest(descriptor=name):
                run.wait(20)
                self.assert_refused(run)
                self.assertEqual(1, len(run.other_lines), run.other_lines)
                self.assertIn("module %s.culprit: error: %s" % (name, reasons[name]), run.other_lines[0])
                self.assertEqual({"DESTRUCT"}, {m["state"] for m in run.modules().values()})
                self.assertEqual(0, run.executor()["cycles"])

    def test_a_program_that_hangs_after_every_restart_is_given_up(self):
        run = self.start("run", "stuck.xml", "--for", "6", "--json")
        run.wait_for_state("stuck", "EXECUTING")  # before this, Takt started the program so that it describes itself
        pids = set()
        wait_until(lambda: pids.update(p.pid for p in run.processes("stuck.exe")) or len(pids) == 2, 10)
        run.wait()
        self.assertEqual(1, run.status)
        self.assert_recovered_then_given_up(run, "stuck", HUNG, 1)
        self.assert_recovered_then_given_up(run, "deaf", HUNG, 0)
        modules = run.modules()
        self.assertEqual((100, 50), (modules["stuck"]["cycles"], modules["deaf"]["cycles"]))
        self.assertGreater(modules["stuck"]["overruns"], 0)
        self.assertIn(modules["stuck"]["pid"], pids)
        self.assert_others_unaffected(run)

    def test_a_program_that_ignores_sigterm_during_the_shutdown_is_killed(self):
        run = self.start("run", "stuck_at_the_end.xml", "--json")
        for module in ("stuck", "deaf"):
            run.wait_for_state(module, "EXECUTING")
        time.sleep(1.9)  # after three releases, both programs stay in their bodies, but not long enough to be treated as hung
        run.signal(signal.SIGTERM)
        run.wait(10)
        self.assertEqual("was killed by SIGTERM (Terminated)", run.steps("stuck")[-1].text)
        self.assertEqual("was killed by SIGKILL (Killed)", run.steps("deaf")[-1].text)
        for module in ("stuck", "deaf"):
            self.assertEqual(LIFE, run.states(module))
            self.assertIn("does not return to its wait function; sending SIGTERM", [line.text for line in run.said(module)])
            self.assertEqual(3, run.modules()[module]["cycles"])
        self.assertIn("does not end on SIGTERM; sending SIGKILL", [line.text for line in run.said("deaf")])
        self.assert_others_unaffected(run)


if __name__ == "__main__":
    takt_system.main()
