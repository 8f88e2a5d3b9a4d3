import ctypes
import os
import re
import resource
import subprocess
import sys
import time
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system

NOBODY = 65534


def become_nobody():
    resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))
    resource.setrlimit(resource.RLIMIT_MEMLOCK, (65536, 65536))
    if os.getuid() == 0:
        os.setgroups([])
        os.setgid(NOBODY)
        os.setuid(NOBODY)


def kept_by_the_kernel():
    """Returns whether the kernel has its default settings. With these settings, if a real-time thread never
    sleeps, the kernel interrupts it for 50 ms in each second."""
    release = tuple(int(n) for n in re.match(r"(\d+)\.(\d+)", os.uname().release).groups())
    if release >= (6, 12):
        return not os.path.isdir("/sys/kernel/debug/sched/fair_server")  # if this folder exists, the default may have been changed
    with open("/proc/sys/kernel/sched_rt_runtime_us") as runtime:
        return int(runtime.read()) == 950000


def error_of_the_wall_clock():
    """Returns the largest error of the wall clock in us, as the kernel estimates it. 16,000,000: nothing synchronises the clock."""
    timex = (ctypes.c_long * 32)()  # its fourth member is maxerror
    if ctypes.CDLL(None, use_errno=True).adjtimex(timex) < 0:
        raise OSError(ctypes.get_errno(), "adjtimex")
    return timex[3]


class Doctor(takt_system.Case):
    def test_the_json_report_of_takt_doctor_agrees_with_its_exit_status(self):
        run = self.takt("doctor", "--json")
        report = run.report
        self.assertEqual("", run.err)
        self.assertEqual(os.uname().release, report["kernel"])
        by_severity = [[f for f in report["findings"] if f["severity"] == s] for s in ("spoils", "note", "good")]
        self.assertEqual([report["spoils"], report["notes"]], [len(found) for found in by_severity[:2]])
        self.assertEqual(len(report["findings"]), sum(len(found) for found in by_severity))
        self.assertEqual(1 if report["spoils"] else 0, run.status)
        for finding in report["findings"]:
            self.assertTrue(finding["found"] and finding["why"], finding)
            self.assertEqual(finding["severity"] == "good", finding["cure"] == "", finding)
        wake_up = report["wake_up_us"]
        self.assertEqual(500, wake_up["count"])
        self.assertTrue(0 <= wake_up["p50"] <= wake_up["p99"] <= wake_up["max"], wake_up)

    def test_takt_doctor_says_whether_the_wall_clock_is_synchronised(self):
        synchronised = error_of_the_wall_clock() < 16e6
        found = [f for f in self.takt("doctor", "--json").report["findings"] if f["check"] == "wall clock"]
        self.assertEqual(["good" if synchronised else "note"], [f["severity"] for f in found])
        self.assertRegex(found[0]["found"], r"^the wall clock is synchronised, .* at most \d" if synchronised else "^nothing synchronises")

    def test_takt_doctor_writes_no_escape_sequences_to_a_pipe(self):
        run = self.takt("doctor")
        self.assertIn(run.status, (0, 1))
        self.assertNotIn("\x1b", run.out)
        for check in ("preemption", "throttling", "interrupts", "stolen time", "wake-up"):
            self.assertIn(check, run.out)

    def test_takt_doctor_reports_the_rights_that_its_user_lacks(self):
        os.chmod(self.folder, 0o755)
        programs = os.path.join(self.folder, "bin")
        os.mkdir(programs)
        # Every user may read these copies of the programs.
        subprocess.run(["cp"] + [os.path.join(takt_system.BIN, name) for name in ("takt", "takt-node")] + [programs], check=True)
        libraries = os.path.join(self.folder, "lib")
        subprocess.run(["cp", "-r", os.path.join(os.path.dirname(takt_system.BIN), "lib"), libraries], check=True)
        run = self.takt("doctor", "--json", programs=programs, become=become_nobody,
                        environment={"LD_LIBRARY_PATH": libraries})
        self.assertEqual(1, run.status, run.err)
        findings = {f["check"]: f for f in run.report["findings"]}
        self.assertFalse(run.report["root"])
        self.assertEqual("spoils", findings["priority"]["severity"])
        self.assertIn("is denied", findings["priority"]["found"])
        self.assertEqual("spoils", findings["memory"]["severity"])
        self.assertIn("limits.conf", findings["memory"]["cure"])

    def test_the_help_of_takt_doctor_explains_the_exit_status(self):
        run = self.takt("doctor", "--help")
        self.assertEqual(0, run.status)
        self.assertIn("Exit status: 0 nothing spoils", run.out)
        self.assertEqual(2, self.takt("doctor", "--nonsense").status)

    @unittest.skipUnless(os.getuid() == 0 and kept_by_the_kernel() and len(os.sched_getaffinity(0)) > 1,
                         "needs root, two CPUs, and a kernel that throttles real-time threads")
    @takt_system.alone("the throttled executor keeps a CPU busy")
    def test_takt_run_warns_when_the_kernel_throttles_an_executor(self):
        cpu = max(os.sched_getaffinity(0))  # the node places the executor on the highest CPU
        run = self.start("run", "spin.xml", "--json")
        run.wait_for_state("fine", "EXECUTING")
        self.assertRegex(run.err, r"robot: warning: executor busy never sleeps, .*; use wakeup=\"hybrid\", or run ")
        other = subprocess.Popen([sys.executable, "-c", "while True: pass"],
                                 preexec_fn=lambda: os.sched_setaffinity(0, {cpu}))
        try:
            run.wait_for_line(r"robot: warning: executor busy lost its CPU for \d+(\.\d+)? ms: the kernel reserves 50 ms of "
                              r"each second .*; use wakeup=\"hybrid\", or run ")
        finally:
            other.kill()
            other.wait()
        time.sleep(0.1)
        run.signal(2)
        run.wait()
        self.assertEqual(0, run.status, run.err)
        said = [line for line in run.lines if "lost its CPU" in line.text]
        self.assertEqual(1, len(said), "the warning must be printed once")
        self.assertGreater(run.executor("busy")["missed"], 20)


if __name__ == "__main__":
    takt_system.main()
