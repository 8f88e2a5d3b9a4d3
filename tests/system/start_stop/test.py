import os
import signal
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import LIFE, wait_until

MODULES = ["fine", "program", "sporadic", "sporadic_program", "diary", "monitoring"]
PROGRAMS = ["fine.exe", "fine_sporadic.exe", "monitoring.exe"]


class StartStop(takt_system.Case):
    def running(self, *options):
        """Starts a run and waits until every module is EXECUTING."""
        run = self.start("run", "cell.xml", "--json", *options)
        for module in MODULES:
            run.wait_for_state(module, "EXECUTING")
        return run

    def assert_ended_well(self, run):
        self.assertEqual(0, run.status, run.err)
        self.assertEqual([], run.other_lines)
        for module in MODULES:
            self.assertEqual(LIFE, run.states(module))

    def test_repeated_runs_leave_no_process_and_no_shared_memory_behind(self):
        for _ in range(takt_system.how_much("TAKT_STARTS", 5, 50)):
            run = self.running()
            wait_until(lambda: all(m["cycles"] for m in self.status_of()["devices"][0]["modules"] if m["name"] in ("fine", "program")))
            run.signal(signal.SIGINT)
            self.assert_ended_well(run.wait())
            self.assert_nothing_left(run)
            self.assert_grid(run, "fine")
            self.assert_grid(run, "program", every=2)
            self.runs.remove(run)

    def test_a_termination_signal_to_takt_run_shuts_the_cell_down_cleanly(self):
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            with self.subTest(signal=number):
                run = self.running()
                run.signal(number)
                self.assert_ended_well(run.wait())

    def test_ctrl_c_to_the_whole_process_group_shuts_the_cell_down_cleanly(self):
        run = self.running()
        os.killpg(run.pid, signal.SIGINT)
        self.assert_ended_well(run.wait())

    def test_sigterm_to_a_node_shuts_its_device_down_cleanly(self):
        run = self.running()
        run.one("takt-node").kill(signal.SIGTERM)
        self.assert_ended_well(run.wait())

    def test_a_termination_signal_during_the_start_leaves_no_process_behind(self):
        for step in range(16):
            run = self.start("run", "cell.xml")
            time.sleep(0.01 * step)
            number = signal.SIGTERM if step % 2 else signal.SIGINT
            run.signal(number)
            run.wait()
            # Shortly after its start, takt does not handle signals yet, so that the signal kills it. takt has not started any other process
            # by then.
            self.assertIn(run.status, (0, -number), run.err)
            self.assert_nothing_left(run)

    def test_sigkill_during_the_start_leaves_no_process_behind(self):
        for step in range(10):
            run = self.start("run", "cell.xml")
            time.sleep(0.015 * step)
            run.signal(signal.SIGKILL)
            run.wait()
            self.assert_nothing_left(run)

    def test_killing_takt_run_leaves_no_process_behind(self):
        run = self.running()
        run.signal(signal.SIGKILL)
        run.wait()
        for module in MODULES:
            self.assertEqual(LIFE, run.states(module), "the node must end in order")
        self.assert_nothing_left(run)

    def test_a_killed_node_leaves_no_process_behind(self):
        run = self.running()
        run.one("takt-node").kill()
        run.wait()
        self.assertEqual(1, run.status)
        self.assertRegex(run.err, r"device cell: error: its node was killed by SIGKILL")
        device = run.device()
        self.assertEqual(("cell", False, [], []), (device["name"], device["alive"], device["executors"], device["modules"]))
        self.assert_nothing_left(run)
        # The host must still call destruct() of its modules, although no process reads its output any more.
        self.assertEqual(["initialize", "start", "destruct"], self.read("diary").splitlines())

    def test_the_restart_of_a_killed_host_does_not_disturb_other_processes(self):
        run = self.running()
        node = run.one("takt-node").pid
        programs = [run.one(program).pid for program in PROGRAMS]
        host = run.one("takt-host")
        held = len(run.one("takt-node").memories())
        begun = len(run.raw)
        host.kill()
        run.wait_for_line("the host is started again")
        for module in ("fine", "sporadic", "diary"):
            run.wait_for_line(r"\.%s: START -> EXECUTING" % module, after=begun)
        self.assertNotEqual(host.pid, run.one("takt-host").pid)
        self.assertEqual(node, run.one("takt-node").pid)
        self.assertEqual(programs, [run.one(program).pid for program in PROGRAMS])
        self.assertEqual(held, len(run.one("takt-node").memories()), "the node must keep the same shared memories")
        run.signal(signal.SIGINT)
        run.wait()
        self.assertEqual(0, run.status, run.err)
        self.assertRegex(run.err, "the host was killed by SIGKILL")
        for module in ("program", "sporadic_program", "monitoring"):
            self.assertEqual(LIFE, run.states(module))
        for module in ("fine", "sporadic", "diary"):
            self.assertEqual(LIFE[:4] + ["DESTRUCT"] + LIFE, run.states(module))
        # The grid must stay the same. The rows during the restart count as missed, also for the program.
        self.assertGreater(run.executor()["missed"], 0)
        self.assert_grid(run, "program", every=2)

    def test_a_device_ends_when_its_host_is_killed_for_the_fourth_time_in_a_minute(self):
        run = self.running()
        for _ in range(4):
            host = run.one("takt-host")
            host.kill()
            wait_until(lambda: run.status is not None or [p for p in run.processes("takt-host") if p.pid != host.pid])
        run.wait()
        self.assertEqual(1, run.status, run.err)
        self.assertRegex(run.err, "it has been restarted 3 times")
        self.assertEqual({"DESTRUCT"}, {m["state"] for m in run.modules().values()})

    def test_killed_process_modules_are_restarted(self):
        run = self.running()
        before = {program: run.one(program).pid for program in PROGRAMS}
        host = run.one("takt-host").pid
        for program in PROGRAMS:
            os.kill(before[program], signal.SIGKILL)
        for module in ("program", "sporadic_program", "monitoring"):
            run.wait_for_line(r"\.%s: RECOVER -> EXECUTING" % module)
        after = {program: run.one(program).pid for program in PROGRAMS}
        self.assertFalse(set(before.values()) & set(after.values()))
        self.assertEqual(host, run.one("takt-host").pid)
        run.signal(signal.SIGINT)
        run.wait()
        self.assertEqual(0, run.status, run.err)
        self.assert_grid(run, "fine")
        modules = run.modules()
        for module, program in zip(("program", "sporadic_program", "monitoring"), PROGRAMS):
            self.assertEqual(LIFE[:4] + ["RECOVER", "EXECUTING"] + LIFE[4:], run.states(module))
            self.assertEqual(1, modules[module]["errors"])
            self.assertEqual(after[program], modules[module]["pid"])


if __name__ == "__main__":
    takt_system.main()
