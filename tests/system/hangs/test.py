import os
import signal
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import LIFE, NEVER_RAN, wait_until


def reason(hook):
    return "%s() did not return within 5 s" % hook


NO_ROW = "executor main ran no row for 1.01 s, so the node killed the host"


class Hangs(takt_system.Case):
    def test_a_hang_in_the_initialize_or_start_hook_prevents_the_start_of_the_device(self):
        for hook, last in (("initialize", ["IDLE", "DESTRUCT"]), ("start", ["IDLE", "INITIALIZE", "RECOVER", "DESTRUCT"])):
            with self.subTest(hook=hook):
                run = self.takt("run", hook + ".xml", "--for", "5", "--json")
                self.assert_refused(run)
                self.assertEqual(["module %s.culprit: error: %s" % (hook, reason(hook))], run.other_lines)
                self.assertEqual(last, run.states("culprit"))
                self.assertEqual(0, run.executor()["cycles"])
                self.assertEqual({"DESTRUCT"}, {m["state"] for m in run.modules().values()})
                # Takt must still call the hooks of the next module in the descriptor.
                self.assertEqual("destruct", self.read("after").splitlines()[-1])
                os.remove(os.path.join(self.folder, "after"))

    def test_a_host_that_sends_unreadable_answers_is_killed_and_takt_run_fails(self):
        cell = self.write("unreadable.xml", """<cell name="unreadable"><device name="line"><module><filename>garbage.so</filename>
            <moduletype>thread</moduletype><operationtype>periodic</operationtype><period>1000000</period><priority>1</priority></module>
            </device></cell>""")
        run = self.takt("run", cell)
        self.assertEqual(1, run.status, run.err)
        failure = "device line: error: the host did not answer within 10 s, so the node killed the host; read its output above"
        self.assertEqual(1, run.err.splitlines().count(failure), run.err[-2000:])

    def test_ctrl_c_ends_takt_run_as_soon_as_the_hanging_hook_times_out(self):
        run = self.start("run", "initialize.xml", "--json")
        run.wait_for_state("program", "INITIALIZE")
        run.signal(signal.SIGINT)
        run.wait()
        self.assertIn("module initialize.culprit: error: %s" % reason("initialize"), run.other_lines)
        self.assertEqual({"DESTRUCT"}, {m["state"] for m in run.modules().values()})

    @staticmethod
    def is_pending(pid, number):
        """Returns whether a signal to the process is still pending."""
        with open("/proc/%d/status" % pid) as file:
            status = dict(line.split(":", 1) for line in file if ":" in line)
        return int(status["ShdPnd"], 16) >> (number - 1) & 1

    def test_a_second_ctrl_c_ends_takt_run_without_waiting_for_a_hanging_hook(self):
        run = self.start("run", "initialize.xml", "--json")
        run.wait_for_state("program", "INITIALIZE")
        run.signal(signal.SIGINT)
        # If the first signal were still pending, the kernel would merge both signals into one.
        wait_until(lambda: not self.is_pending(run.pid, signal.SIGINT), "the first signal to be delivered")
        run.signal(signal.SIGINT)
        run.wait()
        self.assertEqual(1, run.status)
        self.assertIn("device initialize: error: its node was killed by SIGKILL (Killed)", run.other_lines)

    def test_a_hang_in_the_error_recover_or_destruct_hook_does_not_delay_other_modules(self):
        run = self.start("run", "running.xml", "--json")
        run.wait_for_line("after: recovery, attempt 1")
        host = run.one("takt-host")
        run.wait_for_line(r"in_recover: RECOVER -> DESTRUCT")
        self.assertEqual(host.pid, run.one("takt-host").pid)
        run.wait_for_state("after", "DESTRUCT")
        run.signal(signal.SIGINT)
        run.wait()
        self.assertEqual(1, run.status)
        for module, hook in (("in_error", "error"), ("in_recover", "recover"), ("in_destruct", "destruct")):
            self.assertIn("module running.%s: error: %s" % (module, reason(hook)), run.other_lines)
            self.assertTrue(run.steps(module)[-1].text.startswith(reason(hook)), run.steps(module)[-1].text)
            self.assertEqual("DESTRUCT", run.states(module)[-1])
        for module in ("in_error", "in_recover"):
            self.assertTrue(run.steps(module)[-1].text.endswith("; to start it again, run takt restart running." + module))
            self.assertEqual(LIFE[:4] + ["RECOVER", "DESTRUCT"], run.states(module))
            self.assertEqual(50, run.modules()[module]["cycles"])
        # The hooks of module `after` had to wait for the hooks of the other modules. Nevertheless, all hooks of `after` were called: error()
        # and recover() for each attempt, and destruct().
        diary = self.read("after").splitlines()
        self.assertEqual(["initialize", "start"] + ["error 1", "recover"] * 3 + ["error 1", "destruct"], diary)
        # The hanging hooks must not affect the modules in the tables.
        for module, every in (("steady", 1), ("program", 2)):
            self.assertEqual(LIFE, run.states(module))
            self.assert_grid(run, module, every=every)
        self.assertEqual(run.executor()["cycles"], run.modules()["steady"]["cycles"])
        self.assertEqual(run.executor()["cycles"], run.modules()["in_destruct"]["cycles"])

    def test_no_module_counts_as_hanging_because_all_processes_stood_still(self):
        run = self.start("run", "paused.xml", "--json")
        for module in ("steady", "busy"):
            run.wait_for_state(module, "EXECUTING")
        for _ in range(3):
            pids = [p.pid for p in run.processes()]
            for number in (signal.SIGSTOP, signal.SIGCONT):
                for pid in pids:  # takt and takt-node continue first, and find all other processes stopped
                    os.kill(pid, number)
                time.sleep(5 if number == signal.SIGSTOP else 1)  # longer than the hang limit of `busy`, which is 1.05 s
        run.signal(signal.SIGINT)
        self.assertEqual(0, run.wait().status, run.err)
        self.assertEqual(LIFE, run.states("steady"))
        self.assertEqual(LIFE, run.states("busy"))

    def test_a_host_stopped_by_sigstop_is_killed_and_restarted(self):
        run = self.start("run", "stopped.xml", "--json")
        for module in ("steady", "program", "apart"):
            run.wait_for_state(module, "EXECUTING")
        self.done("stop stopped.steady")
        host = next(m["pid"] for m in self.status_of("stopped")["modules"] if m["name"] == "steady")
        os.kill(host, signal.SIGSTOP)
        stopped = time.monotonic()
        start = self.takt("start", "stopped.steady")
        print("takt start failed %.2f s after the host was stopped" % (time.monotonic() - stopped))
        self.assertEqual(1, start.status, start.out)
        self.assertIn(NO_ROW, start.err)
        self.wait_for_states({"stopped": {"steady": "EXECUTING", "program": "EXECUTING", "apart": "EXECUTING"}})
        run.signal(signal.SIGINT)
        run.wait()
        self.assertEqual(0, run.status, run.err)
        self.assertIn("main ran no row", run.err)
        self.assertEqual(1, run.err.count("the host is started again"))
        self.assertEqual(LIFE + LIFE, run.states("steady"))
        self.assertEqual(LIFE, run.states("apart"), "an executor with its own host must not be affected")
        self.assertEqual(LIFE, run.states("program"))


if __name__ == "__main__":
    takt_system.main()
