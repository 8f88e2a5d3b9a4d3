import os
import re
import signal
import statistics
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import LIFE, wait_until

LEASE_MS = 300
# Takt promises 50 ms for a killed host or program, and the lease plus 100 ms for a killed node. The limits here are longer, because a
# machine that other programs use can stall.
LEAVES_MS = 500
LOST_MS = 2000


class Lost(takt_system.Case):
    def begin(self):
        self.looks = []
        self.robot, self.line = self.node("robot"), self.node("line")
        self.watch = self.start("watch")
        self.deploy("cell.xml")
        self.begun = self.wait_for_states({"robot": "EXECUTING", "line": "EXECUTING"})
        for module in ("robot.grid", "robot.sporadic", "robot.program", "line.grid", "line.program"):
            self.watch.wait_for_out(r"^\d\d:\d\d:\d\d\.\d{3} %s: START -> EXECUTING$" % re.escape(module))

    def kill(self, process, seen, back):
        """Kills the process. Returns the time in ms until takt watch had printed all lines `seen`, and the time in ms until it had printed
        all lines `back`."""
        after = len(self.watch.out_lines)
        killed = time.monotonic()
        process.kill()
        took = [1000 * (self.watch.wait_for_out(pattern, after=after) - killed) for pattern in seen]
        again = [1000 * (self.watch.wait_for_out(pattern, after=after) - killed) for pattern in back]
        return max(took), max(again)

    def assert_soon(self, what, trials, limit):
        gone, back = zip(*trials)
        print("%s: seen after %s ms (median %.0f), back after %s ms" % (
            what, ", ".join("%.0f" % ms for ms in gone), statistics.median(gone), ", ".join("%.0f" % ms for ms in back)))
        self.assertLess(statistics.median(gone), limit)

    def assert_line_goes_on(self):
        """Checks that the modules of device line never left EXECUTING and still have the same processes. Returns the status of all
        devices."""
        before = time.monotonic_ns()
        now = self.wait_for_states({"robot": "EXECUTING", "line": "EXECUTING"})
        row = now["line"]["executors"][0]
        self.looks.append((before, row["cycles"] + row["missed"], time.monotonic_ns()))
        for module in ("grid", "program"):
            self.assertEqual(LIFE[:4], self.line.states(module))
        self.assertEqual([m["pid"] for m in self.begun["line"]["modules"]], [m["pid"] for m in now["line"]["modules"]])
        return now

    def told_by_the_line(self):
        """Waits until the node of device line has also lost robot. Returns the status of all devices. In this status, the data about robot
        come only from the node of line."""
        def holds():
            status = {d["name"]: d for d in self.status_of()["devices"]}
            alive = {name: device["alive"] for name, device in status.items()}
            return status if alive == {"robot": False, "line": True} else None
        return wait_until(holds, "line to lose robot")

    def finish(self, failure="^$"):
        run = self.takt("undeploy", "cell")
        self.assertEqual(0, run.status, run.err)
        self.assertRegex(run.err, failure)
        t0, _, strayed = map(int, self.read("line").split())
        self.assertEqual(0, strayed)
        # Each row of line since T0 must have run or count as missed. Half a second is tolerated for an executor that stalled.
        for before, rows, after in self.looks:
            self.assertGreater(rows, (before - t0) / 5e6 - 100)
            self.assertLess(rows, (after - t0) / 5e6 + 2)
        self.end({"robot": self.robot, "line": self.line})
        self.watch.signal(signal.SIGINT)
        self.assertEqual(0, self.watch.wait().status, self.watch.err)

    def test_takt_watch_shows_the_end_and_the_restart_of_a_killed_host_or_program(self):
        self.begin()
        trials = []
        for _ in range(3):  # a host is restarted at most 3 times a minute
            trials.append(self.kill(self.robot.one("takt-host"),
                                    [r" robot\.%s: (START|EXECUTING) -> DESTRUCT \(its host ended\)" % m for m in ("grid", "sporadic")],
                                    [r" robot\.%s: START -> EXECUTING$" % m for m in ("grid", "sporadic")]))
        self.assert_soon("a host", trials, LEAVES_MS)
        trials = []
        for _ in range(7):
            trials.append(self.kill(self.robot.one("grid.exe"),
                                    [r" robot\.program: EXECUTING -> RECOVER \(crash: .*SIGKILL"],
                                    [r" robot\.program: RECOVER -> EXECUTING"]))
        self.assert_soon("a program", trials, LEAVES_MS)
        now = self.assert_line_goes_on()
        robot = {m["name"]: m for m in now["robot"]["modules"]}
        self.assertEqual(7, robot["program"]["errors"])
        self.assertEqual(0, robot["grid"]["errors"], "the module itself had no error")
        # When the host ends for the fourth time, this device ends, but not the other device.
        self.robot.one("takt-host").kill()
        reason = r"device robot: error: the host was killed by SIGKILL \(Killed\); it has been restarted 3 times"
        self.watch.wait_for_out(r"^\S+ robot: ended \(%s" % reason)
        self.wait_for_states({"robot": "DESTRUCT", "line": "EXECUTING"})
        self.assertEqual(["takt-node"], [process.program for process in self.robot.processes()])
        self.finish("failed earlier: " + reason)

    def test_takt_watch_and_takt_status_show_the_loss_and_return_of_a_node(self):
        self.begin()
        # Takt treats a node that is stopped with SIGSTOP as lost. Its host and programs keep running. After SIGCONT, the device is back.
        node = self.robot.one("takt-node")
        after = len(self.watch.out_lines)
        node.kill(signal.SIGSTOP)
        self.watch.wait_for_out(r"^\S+ robot: LOST", after=after)
        self.assertEqual(["EXECUTING"], list({m["state"] for m in self.status_of("line")["modules"]}))
        node.kill(signal.SIGCONT)
        self.watch.wait_for_out(r"^\S+ robot: running", after=after)
        self.assert_line_goes_on()
        self.assertEqual(LIFE[:4], self.robot.states("grid"))

        host = self.robot.one("takt-host")
        after = len(self.watch.out_lines)
        killed = time.monotonic()
        self.robot.one("takt-node").kill()
        gone = 1000 * (self.watch.wait_for_out(r"^\S+ robot: LOST", after=after) - killed)
        status = self.told_by_the_line()
        self.assertEqual(["grid", "sporadic", "program"], [m["name"] for m in status["robot"]["modules"]])
        self.refused({"stop robot": "^device robot: error: it is lost: its node no longer answers; .*takt log --kind device-lost"})
        self.assertRegex(self.done("status")[0], r"(?m)^device robot  LOST$")
        wait_until(lambda: not [p for p in self.robot.processes() if p.alive], "the host and the program of robot to end")
        self.assertFalse(host.alive)
        self.assertEqual({"EXECUTING"}, {m["state"] for m in status["line"]["modules"]})

        after = len(self.watch.out_lines)
        started = time.monotonic()
        self.robot = self.node("robot", "--resume")
        back = max(self.watch.wait_for_out(r" robot\.%s: START -> EXECUTING$" % m, after=after)
                   for m in ("grid", "sporadic", "program"))
        print("a node: lost after %.0f ms (its lease is %d ms), its modules ran again %.0f ms after it was started again" %
              (gone, LEASE_MS, 1000 * (back - started)))
        self.assertLess(gone, LOST_MS)
        self.assert_line_goes_on()
        self.finish()

    def test_takt_undeploy_reports_a_lost_device(self):
        self.begin()
        self.robot.one("takt-node").kill()
        self.watch.wait_for_out(r"^\S+ robot: LOST")
        self.told_by_the_line()
        run = self.takt("undeploy", "cell")
        self.assertEqual((1, "cell cell is undeployed from line\n"), (run.status, run.out))
        self.assertEqual("device robot: error: it is lost and did not receive the command; the other devices pass it on when the device "
                         "is back, unless their nodes are restarted before", run.err.rstrip())
        self.assertEqual("-", self.status_of()["cell"])
        self.assertIn("device robot  LOST  it may still run cell cell, which is undeployed on the other devices; they tell it when it is back",
                      self.takt("status").out)
        self.robot = self.node("robot", "--resume")
        self.robot.wait_for_line("cell cell ends: it was undeployed on device line")
        wait_until(lambda: self.status_of("robot")["state"] == "waiting", "robot to wait for a deployment")
        self.end({"robot": self.robot, "line": self.line})


if __name__ == "__main__":
    takt_system.main()
