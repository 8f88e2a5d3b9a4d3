import json
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
        self.assertEqual(1, sum(line.startswith("module %s.%s: error: it was given up: %s; " % (device, module, reason))
                                for line in run.other_lines), run.other_lines)

    def test_a_program_that_ends_after_every_restart_is_given_up(self):
        run = self.takt("run", "ends.xml", "--for", "4", "--json")
        self.assertEqual(1, run.status)
        modules = run.modules()
        self.assert_recovered_then_given_up(run, "exits", "crash: the process ended with status 3", 2)
        self.assert_recovered_then_given_up(run, "crashes", "crash: the process was killed by SIGSEGV (Segmentation fault)", 2)
        # A program that ends during its first release was EXECUTING before that, if only for a moment.
        self.assert_recovered_then_given_up(run, "first_row", "crash: the process ended with status 4", 3)
        for module, releases, lives in (("exits", 50, 3), ("crashes", 50, 3), ("first_row", 1, 4)):
            # Each process ends by itself after this many releases. While it ends, at most one more release may be counted.
            self.assertIn(modules[module]["cycles"] - releases * lives, range(lives + 1), module)
        self.assertEqual(3, len(run.other_lines), run.other_lines)
        self.assert_others_unaffected(run)

    def test_a_program_that_ends_with_status_0_counts_as_finished_and_is_not_restarted(self):
        run = self.takt("run", "finishes.xml", "--for", "2", "--json")
        self.assertEqual(0, run.status, run.err)
        for module in ("program", "thread"):
            self.assertEqual(LIFE, run.states(module))
            self.assertEqual("it has finished", run.steps(module)[-1].text)
            finished = run.modules()[module]
            self.assertEqual((0, "it has finished"), (finished["errors"], finished["text"]))
            self.assertIn(finished["cycles"], (50, 51))  # while the program ends, one more release may be counted
        self.assertEqual([], run.other_lines)
        self.assertEqual(LIFE, run.states("steady"))
        self.assert_grid(run, "steady")

    def test_a_program_gets_its_arguments_in_order_before_its_properties(self):
        run = self.takt("run", "arguments.xml", "--for", "0.3", "--json")
        self.assertEqual(0, run.status, run.err)
        given = ["--camera", "0", "--mode=fast", "a lens.yaml", "", "speed=2.5"]
        self.assertEqual(["argument %d: [%s]" % (i + 1, text) for i, text in enumerate(given)] + ["speed 2.5"], run.printed("arguments"))
        described = json.loads(self.takt("describe", "arguments.xml", "--json").out)
        self.assertEqual(given[:5], described["module"]["arguments"])

    def test_an_operator_can_set_the_properties_of_a_running_program(self):
        cell = self.write("live.xml", '<cell name="live"><device name="d">' + "".join(
            "<module><name>%s</name><filename>%s</filename><moduletype>process</moduletype>%s<priority>1</priority></module>" % module for module in (
                ("p", "program_properties.exe", "<operationtype>sporadic</operationtype><deadline>1s</deadline>"
                 '<recovery attempts="1" backoff="10ms"/><property><value name="label">mine</value></property>'),
                ("grid", "grid.exe", "<operationtype>periodic</operationtype><period>10ms</period>"))) + "</device></cell>")
        run = self.start("run", cell, "--json")
        run.wait_for_line(r"p: \| gain 1\.5, label mine")
        run.wait_for_state("p", "EXECUTING")
        self.assertEqual(["1.5", "mine"], self.done("get d.p gain", "get d.p label"))
        self.assertEqual(["2.5"], self.done("set d.p gain 2.5"))
        run.wait_for_line(r"p: \| gain 2\.5, label mine")
        run.wait_for_line(r"d\.p: gain = 2\.5")
        self.assertRegex(self.done("get d.p")[0], r"(?m)^gain +2\.5 +1/s +0 to 100 +double$")
        self.refused({
            "set d.p gain 100.5": r"^module d\.p: error: property 'gain' cannot be '100\.5'; it takes a number, 0 to 100, in 1/s$",
            "set d.p gain fast": r"^module d\.p: error: property 'gain' cannot be 'fast'; it takes a number, 0 to 100, in 1/s$",
            "set d.p gian 1": r"^module d\.p: error: this program has no property 'gian'; did you mean gain\?$",
            "get d.p gian": r"^module d\.p: error: this program has no property 'gian'; did you mean gain\?$",
            "set d.p label %s" % ("x" * 256): r"has 256 bytes; give a value of at most 255 bytes$",
            "set d.grid file x": r"^module d\.grid: error: its program declares no properties: it gets them, except log-level, as arguments when it starts; ",
        })
        self.assertEqual(["2.5"], self.done("get d.p gain"))

        killed = len(run.raw)
        run.one("program_properties.exe").kill()
        run.wait_for_line(r"p: \| gain 2\.5, label mine", after=killed)
        run.wait_for_line(r"d\.p: RECOVER -> EXECUTING", after=killed)
        self.assertEqual(["2.5"], self.done("get d.p gain"))

        self.done("stop d.p")  # in START the program has no releases, so the node does not kill it when it is stopped
        process = run.one("program_properties.exe")
        process.kill(signal.SIGSTOP)
        self.refused({"set d.p gain 3": r"^module d\.p: error: the program of module p has not answered within 2 s: it is stopped, or gets no CPU "
                                        r"time; the value takes effect if the program still answers$"})
        process.kill(signal.SIGCONT)
        run.wait_for_line(r"d\.p: gain = 3")
        self.assertEqual(["4"], self.done("set d.p gain 4"))
        self.done("start d.p")
        run.wait_for_line(r"p: \| gain 4, label mine")
        run.signal(signal.SIGINT)
        run.wait()
        self.assertEqual(0, run.status, run.err)

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
        # Each time the condition holds, the body takes too long. Other releases may be late too. The shutdown may interrupt the last body.
        self.assertGreaterEqual(run.modules()["late"]["overruns"], held - 1)
        self.assertEqual(LIFE, run.states("late"))

    def test_takt_check_rejects_a_program_that_cannot_be_released_as_the_descriptor_specifies(self):
        reasons = {
            "never_attaches": "the program never calls initPeriodExe(), because it is not linked with libtakt_process",
            "wrong_kind": "the program calls initSporadicExe(), so it is sporadic; use <operationtype>sporadic</operationtype>",
            "never_released": "module culprit has <dispatch>immediate</dispatch>, but no event port that could release it",
        }
        for name, reason in reasons.items():
            with self.subTest(descriptor=name):
                for arguments in (("check", name + ".xml"), ("run", name + ".xml", "--for", "5")):
                    run = self.takt(*arguments)
                    self.assertEqual((1, ""), (run.status, run.out))
                    self.assertRegex(run.err, r"^\S*%s\.xml:1[0-9]: error: (module culprit: )?%s" % (name, re.escape(reason)))

    def test_a_program_that_does_not_reach_its_wait_function_prevents_the_start_of_the_device(self):
        reasons = {
            "never_waits": "did not call waitPeriod() within 5 s",
            "exits_at_once": "it was given up: the process ended with status 7",
            "crashes_at_once": "it was given up: the process was killed by SIGSEGV (Segmentation fault)",
        }
        runs = {name: self.start("run", name + ".xml", "--for", "5", "--json") for name in reasons}  # in parallel, because no module runs
        for name, run in runs.items():
            with self.subTest(descriptor=name):
                run.wait()
                self.assert_refused(run)
                self.assertEqual(1, len(run.other_lines), run.other_lines)
                self.assertIn("module %s.culprit: error: %s" % (name, reasons[name]), run.other_lines[0])
                self.assertEqual({"DESTRUCT"}, {m["state"] for m in run.modules().values()})
                self.assertEqual(0, run.executor()["cycles"])

    def test_a_program_that_hangs_after_every_restart_is_given_up(self):
        run = self.start("run", "stuck.xml", "--for", "6", "--json")
        run.wait_for_state("stuck", "EXECUTING")  # until then, Takt runs the program only to get its description
        pids = set()
        wait_until(lambda: pids.update(p.pid for p in run.processes("stuck.exe")) or len(pids) == 2)
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
        run.wait()
        self.assertEqual("was killed by SIGTERM (Terminated)", run.steps("stuck")[-1].text)
        self.assertEqual("was killed by SIGKILL (Killed)", run.steps("deaf")[-1].text)
        for module in ("stuck", "deaf"):
            self.assertEqual(LIFE, run.states(module))
            self.assertIn("does not return to its wait function; sending SIGTERM", [line.text for line in run.said(module)])
            self.assertEqual(3, run.modules()[module]["cycles"])
        self.assertIn("does not end on SIGTERM; sending SIGKILL", [line.text for line in run.said("deaf")])
        self.assert_others_unaffected(run)

    def begins(self, module):
        """Returns, for each release of a begins.exe, the time at which its body began. Both times are in ns of the monotonic clock."""
        return dict(map(int, line.split()) for line in self.read(module).splitlines())

    def assert_order(self, descriptor, seconds):
        # A node with two CPUs gives one to the executor, and one to all programs.
        cpus = sorted(os.sched_getaffinity(0))[-2:]
        order = self.takt("check", descriptor, "--json").device()["executors"][0]["rows"][0]
        self.assertEqual(["first", "middle", "last"], order)
        seen = 0
        while seen <= seconds * 400:  # of 500 rows per second; a machine that misses more than 100 of them runs the programs again
            run = self.takt("run", descriptor, "--for", "%g" % seconds, "--json", limit=seconds + takt_system.LONG,
                            become=lambda: os.sched_setaffinity(0, cpus))
            self.assertEqual(0, run.status, run.err)
            begins = {module: self.begins(module) for module in order}
            for module in order:
                self.assert_grid(run, module)
                # The cell may end while a program waits for its turn.
                self.assertIn(run.modules()[module]["cycles"] - len(begins[module]), (0, 1), module)
            rows = set.intersection(*(set(begins[module]) for module in order))
            self.assertGreater(len(rows), 0)
            seen += len(rows)
            jitter = run.executor()["jitter_us"]
            print("%d common rows, which were late by p50 %.1f us, p99 %.1f us" % (len(rows), jitter["p50"], jitter["p99"]))
            for module in order:
                late = sorted(begins[module][row] - row for row in rows)
                print("%s: began after p50 %.1f us, p99 %.1f us, max %.1f us" % (
                    module, late[len(late) // 2] / 1e3, late[len(late) * 99 // 100] / 1e3, late[-1] / 1e3))
            self.assertEqual([], [{module: (begins[module][row] - row) / 1e3 for module in order} for row in rows
                                  if sorted(order, key=lambda module: begins[module][row]) != order],
                             "rows that began in another order, with the time from the release to the begin in us")

    @takt_system.timing("on virtual time, no program could begin in the wrong order because it wakes up too late")
    def test_programs_on_one_cpu_begin_in_the_order_that_takt_check_prints(self):
        self.assert_order("order.xml", takt_system.how_much("TAKT_ORDER_SECONDS", 3.0, 22.0))

    @takt_system.timing("on virtual time, no program could begin in the wrong order because it wakes up too late")
    def test_programs_with_the_same_kernel_priority_begin_in_the_order_that_takt_check_prints(self):
        with open(self.beside("order.xml")) as file:
            # With this priority of the executor, all programs have the SCHED_FIFO priority 1.
            one_level = file.read().replace("<root>", '<root><executor name="main" priority="2"/>')
        self.assert_order(self.write("order.xml", one_level), takt_system.how_much("TAKT_ORDER_SECONDS", 3.0, 22.0))


if __name__ == "__main__":
    takt_system.main()
