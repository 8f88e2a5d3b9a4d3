import os
import re
import shutil
import signal
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import LIFE, wait_until

STARTED = LIFE[:4]
PLACE = r"(, in .+ in \w+\.so)?"  # the place is unknown after a stack overflow or a call of exit()
SEGV = r"the host was killed by SIGSEGV \(Segmentation fault\) in %s\(\)"

HEAD = """<cell name="cell"><device name="d">
  <module> <name>grid</name> <filename>grid.so</filename>
    <moduletype>thread</moduletype> <operationtype>periodic</operationtype> <period>2000000</period> <priority>1</priority> </module>"""
MODULE = """
  <module> <name>%s</name> <filename>trespasses.so</filename>
    <moduletype>thread</moduletype> <operationtype>periodic</operationtype> <period>2000000</period> <priority>2</priority>
    <recovery attempts="1" backoff="10000000"/>
    <property> <value name="deed">%s</value> <value name="hook">%s</value> <value name="after">%d</value> </property> </module>"""


class Trespasses(takt_system.Case):
    """A module does something that ends its host or endangers other modules, but is no crash of its own code."""

    def cell(self, *modules):
        return self.write("cell.xml", HEAD + "".join(MODULE % module for module in modules) + "</device></cell>")

    def run_with(self, *modules):
        run = self.start("run", self.cell(*modules), "--json")
        run.wait_for_state("grid", "EXECUTING")
        return run

    def end(self, run, status):
        run.signal(signal.SIGINT)
        run.wait()
        self.assertEqual(status, run.status, run.err)

    def swap(self):
        """Replaces the component of the module by a copy of itself."""
        file = os.path.join(self.folder, "another.so")
        shutil.copy(os.path.join(os.environ["TAKT_COMPONENT_PATH"].split(":")[0], "trespasses.so"), file)
        self.done("swap d.culprit " + file)

    def module(self):
        return next(m for m in self.status_of("d")["modules"] if m["name"] == "culprit")

    def assert_swap_keeps_the_host(self, others={}):
        """Swaps the module while it runs, and waits for 100 more cycles of the module in the same host. `others` are the states of modules
        other than the usual two."""
        wait_until(lambda: self.module()["cycles"] > 10, "the old instance to run")
        before = self.module()
        self.swap()
        wait_until(lambda: self.module()["cycles"] > before["cycles"] + 100, "the new instance to run")
        self.assertEqual(before["pid"], self.module()["pid"])
        self.assertEqual({"grid": "EXECUTING", "culprit": "EXECUTING", **others}, self.states_of("d"))

    def test_a_call_that_ends_the_host_is_attributed_to_its_module_and_hook(self):
        for deed, hook in (("_exit", "run"), ("_Exit", "error"), ("quick_exit", "recover")):
            with self.subTest(deed=deed, hook=hook):
                run = self.run_with(("culprit", deed, hook, 10))
                run.wait_for_line("the host is started again")
                wait_until(lambda: [s.target for s in run.steps("grid")].count("EXECUTING") == 2, "grid to run in the new host")
                self.end(run, 1)
                self.assertEqual(["module d.culprit: error: the host ended with status 3 in %s()" % hook], run.other_lines)
                self.assertEqual("DESTRUCT", run.steps("culprit")[-1].target)

    def test_a_call_that_ends_the_host_in_initialize_prevents_the_start_of_the_device(self):
        run = self.takt("run", self.cell(("culprit", "_exit", "initialize", 0)), "--for", "5", "--json")
        self.assert_refused(run, r"(?m)^module d\.culprit: error: the host ended with status 3 in initialize\(\)$")

    def test_the_end_of_the_host_by_a_thread_of_a_module_is_attributed_to_the_module(self):
        for deed, hook, reason in (("crashing thread", "run", r"was killed by SIGSEGV \(Segmentation fault\)"),
                                   ("exiting thread", "error", "ended with status 3"),
                                   ("thread of a thread", "run", r"was killed by SIGABRT \(Aborted\)"),
                                   ("crashing timer", "run", r"was killed by SIGSEGV \(Segmentation fault\)")):
            with self.subTest(deed=deed):
                run = self.run_with(("culprit", deed, hook, 10))
                run.wait_for_line("the host is started again")
                wait_until(lambda: [s.target for s in run.steps("grid")].count("EXECUTING") == 2, "grid to run in the new host")
                self.end(run, 1)
                self.assertEqual(1, len(run.other_lines), run.other_lines)
                self.assertRegex(run.other_lines[0], r"^module d\.culprit: error: the host %s in a thread of the module" % reason)
                self.assertEqual("DESTRUCT", run.steps("culprit")[-1].target)

    def test_the_code_of_a_swapped_module_stays_in_memory_while_a_thread_of_the_module_runs(self):
        run = self.run_with(("culprit", "endless thread", "start", 0))
        self.assert_swap_keeps_the_host()
        run.wait_for_line("module culprit: a thread that it started still runs, so its code stays in memory")
        self.end(run, 0)

    def test_timers_and_signal_handlers_of_a_module_do_not_end_the_host(self):
        for deed in ("timers", "handled timers"):
            with self.subTest(deed=deed):
                run = self.run_with(("culprit", deed, "start", 0))
                self.done("set d.culprit deed none")  # the new instance starts no timers and sets no handlers
                self.assert_swap_keeps_the_host()
                self.end(run, 0)

    def test_a_timer_that_a_swapped_module_leaves_running_is_deleted_and_reported(self):
        run = self.run_with(("culprit", "thread timer", "start", 0))
        self.done("set d.culprit deed none")  # the new instance starts no timer
        self.assert_swap_keeps_the_host()
        run.wait_for_line(r"module culprit: the host has deleted a timer that the module left running \(timer_create\(\) with SIGEV_THREAD\)")
        self.end(run, 0)
        self.assertEqual(LIFE, run.states("grid"))

    def test_a_module_cannot_close_file_descriptors_of_the_host(self):
        reason = "it tried to close file descriptors of the host, which stay open; close only those that the module has opened"
        for deed in ("close", "close_range", "closefrom"):
            with self.subTest(deed=deed):
                run = self.takt("run", self.cell(("culprit", deed, "initialize", 0)), "--for", "5", "--json")
                self.assert_refused(run, r"(?m)^module d\.culprit: error: initialize\(\) failed: %s$" % reason)
        run = self.run_with(("culprit", "close", "run", 10), ("other", "close own", "run", 10))
        run.wait_for_line(r"d\.culprit: EXECUTING -> RECOVER \(failure: %s\)" % reason)
        self.done("set d.culprit deed none")  # the new instance closes nothing
        self.assert_swap_keeps_the_host(others={"other": "EXECUTING"})
        self.end(run, 0)
        self.assertEqual(LIFE, run.states("grid"))
        self.assertEqual(LIFE, run.states("other"))

    def test_a_module_may_close_the_file_descriptors_that_it_has_opened(self):
        # The host has closed the descriptor of the only component before, so the module gets the same number.
        run = self.start("run", self.write("cell.xml", '<cell name="cell"><device name="d">%s</device></cell>' %
                                           MODULE % ("culprit", "close own", "run", 10)), "--json")
        run.wait_for_state("culprit", "EXECUTING")
        wait_until(lambda: self.module()["cycles"] > 20, "the module to close its descriptor")
        self.end(run, 0)
        self.assertEqual(LIFE, run.states("culprit"))

    def test_a_hook_that_calls_pthread_exit_fails(self):
        reason = r"it called pthread_exit\(\) in a thread of the host; return from the hook instead"
        run = self.takt("run", self.cell(("culprit", "pthread_exit", "initialize", 0)), "--for", "5", "--json")
        self.assert_refused(run, r"(?m)^module d\.culprit: error: initialize\(\) failed: %s$" % reason)
        run = self.run_with(("culprit", "pthread_exit", "run", 10))
        run.wait_for_line(r"d\.culprit: EXECUTING -> RECOVER \(failure: %s\)" % reason)
        run.wait_for_state("culprit", "EXECUTING")
        self.end(run, 0)
        self.assertEqual(LIFE, run.states("grid"))

    def test_an_exception_that_is_not_a_std_exception_is_reported(self):
        run = self.takt("run", self.cell(("culprit", "throw", "initialize", 0)), "--for", "5", "--json")
        self.assert_refused(run, r"(?m)^module d\.culprit: error: initialize\(\) failed: threw something that is not a std::exception$")
        run = self.takt("run", self.cell(("culprit", "throw in noexcept", "start", 0)), "--for", "5", "--json")
        self.assert_refused(run, r"(?m)^module d\.culprit: error: the host was killed by SIGABRT \(Aborted\) in start\(\), because nothing "
                                 r"caught the exception 'int \(not a std::exception\)' \(none can leave a noexcept function\)" + PLACE)

    def test_a_module_that_ends_the_host_by_a_system_call_is_given_up(self):
        run = self.run_with(("forks", "fork_exit", "run", 10), ("culprit", "exit_group", "run", 100))
        run.wait_for_line("the host is started again")
        wait_until(lambda: [s.target for s in run.steps("grid")].count("EXECUTING") == 2, "grid to run in the new host")
        self.end(run, 1)
        self.assertEqual(["module d.culprit: error: the host ended with status 3 in run(), which made the system call exit_group() itself"],
                         run.other_lines)
        self.assertEqual("DESTRUCT", run.steps("culprit")[-1].target)

    def test_a_hook_that_replaces_the_handler_of_crashes_fails(self):
        run = self.takt("run", self.cell(("culprit", "handler of SIGSEGV", "initialize", 0)), "--for", "5", "--json")
        self.assert_refused(run, r"(?m)^module d\.culprit: error: initialize\(\) failed: it replaced the signal handler of SIGSEGV, "
                            "with which the host reports crashes; remove the call of ")


class Crashes(takt_system.Case):
    def crash(self, descriptor, reason, culprits=("culprit",)):
        """Runs the cell until all culprits have crashed, and a while longer. Checks what must be true after every kind of crash."""
        run = self.start("run", descriptor + ".xml", "--json")
        run.wait_for_state("program", "EXECUTING")
        node, program = run.one("takt-node").pid, run.one("grid.exe").pid
        run.wait_for_line("the host is started again")
        self.assertEqual(node, run.one("takt-node").pid)
        self.assertEqual(program, run.one("grid.exe").pid)
        for module in ("grid", "slower", "sporadic"):
            wait_until(lambda: [s.target for s in run.steps(module)].count("EXECUTING") == 1 + len(culprits),
                       "%s to run in the last host" % module)
        time.sleep(0.8)
        run.signal(signal.SIGINT)
        run.wait()

        self.assertEqual(1, run.status, run.err)
        self.assertRegex(run.other_lines[0], r"^module %s\.%s: error: %s%s$" % (descriptor, culprits[0], reason, PLACE))
        self.assertEqual(len(culprits), len(run.other_lines), run.other_lines)
        modules = run.modules()
        self.assertEqual({"grid", "slower", "program", "sporadic"} | set(culprits), set(modules))
        for name, module in modules.items():
            self.assertEqual("DESTRUCT", module["state"], name)
        for culprit in culprits:
            self.assertGreaterEqual(modules[culprit]["errors"], 1)
            self.assertEqual("DESTRUCT", run.states(culprit)[-1])
        self.assertRegex(run.steps(culprits[0])[-2].text + run.steps(culprits[0])[-1].text, reason)
        for module in ("grid", "slower", "sporadic"):
            self.assertEqual(STARTED + (["DESTRUCT"] + STARTED) * len(culprits) + LIFE[4:], run.states(module))
            self.assertEqual(0, modules[module]["errors"])
        self.assertEqual(LIFE, run.states("program"))

        # The program was in the table all the time. The other modules missed the rows while they were loaded again.
        restarts = len(culprits)
        self.assert_grid(run, "program", every=2, broken_rows=restarts)
        rows = run.executor()
        self.assertGreater(rows["missed"], 0)
        for module, every in (("grid", 1), ("slower", 5)):
            cycles = modules[module]["cycles"]
            self.assertLessEqual(cycles, min(-(-(rows["cycles"] + rows["missed"]) // every), rows["cycles"] + restarts))
            self.assertGreater(cycles, 100 // every)

        # The grid must be the same before and after the restart.
        t0, runs, strayed = map(int, self.read("grid").split())
        self.assertGreater(runs, 0, "it must have run in the last host")
        said = re.search(r"grid (\d+) (\d+) (\d+)", " ".join(run.printed("program")))
        self.assertEqual((0, 0), (strayed, int(said[3])))
        self.assertEqual(t0, int(said[1]))
        self.assertIn(modules["program"]["cycles"] - int(said[2]), (0, 1))
        return run

    def test_a_segmentation_fault_in_a_module_restarts_the_host_without_this_module(self):
        run = self.crash("segv", SEGV % "run" + r", in \w.* at segv\.cpp:1\d in segv\.so")
        self.assertEqual(99, run.modules()["culprit"]["cycles"])
        self.assertEqual(STARTED + ["RECOVER", "DESTRUCT"], run.states("culprit"))

    def test_a_call_of_exit_in_a_module_restarts_the_host_without_this_module(self):
        self.crash("leaves", r"the host ended with status 3 in run\(\)")

    def test_a_host_process_that_a_module_forks_executes_no_modules(self):
        run = self.takt("run", "forks.xml", "--for", "1", "--json")
        self.assertEqual(0, run.status, run.err)
        pids = self.read("pids").split()
        self.assertGreater(len(pids), 10)
        self.assertEqual(1, len(set(pids)), "the copy executed a row")

    def test_a_call_of_abort_in_a_module_restarts_the_host_without_this_module(self):
        run = self.crash("abort", r"the host was killed by SIGABRT \(Aborted\) in run\(\)")
        self.assertEqual(99, run.modules()["culprit"]["cycles"])

    def test_the_text_of_an_exception_that_ends_the_host_is_reported(self):
        run = self.crash("uncaught", r"the host was killed by SIGABRT \(Aborted\) in run\(\), because nothing caught the exception "
                         r"'no part in\\nthe gripper' \(none can leave a noexcept function\), in \w.* at abort\.cpp:1\d in abort\.so")
        self.assertEqual(99, run.modules()["culprit"]["cycles"])

    def test_a_stack_overflow_in_a_module_restarts_the_host_without_this_module(self):
        self.crash("overflow", SEGV % "run")

    @takt_system.alone("an endless loop at a real-time priority keeps a CPU busy")
    def test_an_endless_loop_in_a_module_restarts_the_host_without_this_module(self):
        run = self.crash("endless", r"run\(\) did not return within 1\.01 s, so the node killed the host; "
                         r"run\(\) was in run at endless\.cpp:\d+ in endless\.so")
        self.assertGreaterEqual(run.executor()["missed"], 1000, "no row was walked during the endless loop")

    def test_a_crash_in_the_error_or_recover_hook_restarts_the_host_without_this_module(self):
        for hook in ("error", "recover"):
            with self.subTest(hook=hook):
                run = self.crash("segv_in_" + hook, SEGV % hook)
                self.assertEqual(STARTED + ["RECOVER", "DESTRUCT"], run.states("culprit"))
                self.assertEqual((100, 2), (run.modules()["culprit"]["cycles"], run.modules()["culprit"]["errors"]))

    def test_a_crash_of_a_non_real_time_module_restarts_the_host_without_this_module(self):
        self.crash("background", SEGV % "run")

    def test_each_of_two_crashing_modules_is_removed_from_the_restarted_host(self):
        self.crash("two", SEGV % "run", culprits=("first", "second"))

    def test_a_crash_in_the_initialize_or_start_hook_prevents_the_start_of_the_device(self):
        for hook in ("initialize", "start"):
            with self.subTest(hook=hook):
                run = self.takt("run", "segv_in_%s.xml" % hook, "--for", "5", "--json")
                self.assert_refused(run, "(?m)^module segv_in_%s.culprit: error: %s%s$" % (hook, SEGV % hook, PLACE))
                self.assertEqual(0, run.executor()["cycles"])
                self.assertNotIn("started again", run.err)
                self.assertEqual({"DESTRUCT"}, {m["state"] for m in run.modules().values()})

    def test_takt_run_reports_a_crash_in_the_destruct_hook(self):
        run = self.takt("run", "segv_in_destruct.xml", "--for", "1", "--json")
        self.assertEqual(1, run.status)
        self.assertRegex(run.err, "(?m)^module segv_in_destruct.culprit: error: %s%s$" % (SEGV % "destruct", PLACE))
        self.assertEqual({"DESTRUCT"}, {m["state"] for m in run.modules().values()})
        self.assertEqual(LIFE, run.states("program"))
        self.assertEqual(LIFE, run.states("grid"))

    def test_a_crash_of_a_stop_device_module_ends_the_device(self):
        run = self.takt("run", "stop_device.xml", "--for", "30", "--json")
        self.assertEqual(1, run.status)
        self.assertEqual(1, len(run.other_lines), run.other_lines)
        self.assertRegex(run.err, "(?m)^module stop_device.culprit: error: %s%s$" % (SEGV % "run", PLACE))
        self.assertEqual(LIFE, run.states("program"))
        self.assertEqual(LIFE, run.states("grid"))
        self.assertEqual({"DESTRUCT"}, {m["state"] for m in run.modules().values()})


if __name__ == "__main__":
    takt_system.main()
