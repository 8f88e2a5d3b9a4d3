import os
import resource
import shutil
import sys
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import BIN, LIFE

NOBODY = 65534
MODULES = ["steady", "program", "sporadic", "background"]


def become_unprivileged(locked_bytes=0):
    """The child process calls this to become a user without rights, with resource limits that grant no rights either."""
    resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))
    resource.setrlimit(resource.RLIMIT_MEMLOCK, (locked_bytes, locked_bytes))
    if os.getuid() == 0:
        os.setgroups([])
        os.setgid(NOBODY)
        os.setuid(NOBODY)


class NoRealTime(takt_system.Case):
    def setUp(self):
        super().setUp()
        os.chmod(self.folder, 0o755)
        # Every user may read these copies of the programs and components.
        self.bin = os.path.join(self.folder, "bin")
        components = os.path.join(self.folder, "components")
        shutil.copytree(BIN, self.bin, ignore=lambda folder, names: [n for n in names if not n.startswith("takt")])
        os.mkdir(components)
        for name in ("fine.so", "fine.exe", "fine_sporadic.so"):
            for folder in os.environ["TAKT_COMPONENT_PATH"].split(":"):
                if os.path.exists(os.path.join(folder, name)):
                    shutil.copy(os.path.join(folder, name), components)
        libraries = os.path.join(self.folder, "lib")
        shutil.copytree(os.path.join(os.path.dirname(BIN), "lib"), libraries)
        self.descriptor = shutil.copy(self.beside("cell.xml"), self.folder)
        self.options = dict(programs=self.bin, become=become_unprivileged,
                            environment={"TAKT_COMPONENT_PATH": components, "LD_LIBRARY_PATH": libraries})

    def assert_ran(self, run):
        self.assertEqual(0, run.status, run.err)
        for module in MODULES:
            self.assertEqual(LIFE, run.states(module))
        self.assert_grid(run, "steady")
        self.assert_grid(run, "program", every=2)
        self.assertEqual(run.executor()["cycles"], run.modules()["steady"]["cycles"])
        self.assertGreater(run.modules()["background"]["cycles"], 0)

    def test_takt_run_reports_a_limit_on_locked_memory(self):
        # Many systems limit locked memory to 8 MiB: enough for the start of a program, but less than the program needs later.
        options = dict(self.options, become=lambda: become_unprivileged(8 * 1024 * 1024))
        run = self.takt("run", self.descriptor, "--for", "1.5", "--json", **options)
        self.assert_ran(run)
        self.assertIs(False, run.device()["real_time"])
        self.assertIn("mlockall is denied beyond 8192 KiB", run.err)

    def test_a_cell_without_real_time_rights_runs_with_warnings(self):
        run = self.takt("run", self.descriptor, "--for", "1", "--json", **self.options)
        self.assert_ran(run)
        self.assertIs(False, run.device()["real_time"])
        warnings = [line.text for line in run.lines if line.text.startswith("WARNING: not real-time: ")]
        self.assertTrue([w for w in warnings if "SCHED_FIFO" in w and "is denied" in w and "CAP_SYS_NICE" in w], run.err)
        self.assertTrue([w for w in warnings if "mlockall is denied" in w and "memlock" in w], run.err)

    def test_the_report_marks_a_run_without_real_time_rights_as_not_real_time(self):
        run = self.takt("run", self.descriptor, "--for", "0.2", **self.options)
        self.assertEqual(0, run.status, run.err)
        self.assertRegex(run.out, r"(?m)^device cell +NOT REAL-TIME$")

    def test_the_option_require_realtime_prevents_a_start_without_real_time_rights(self):
        run = self.takt("run", self.descriptor, "--for", "5", "--json", "--require-realtime", **self.options)
        self.assert_refused(run, r"(?m)^device cell: error: SCHED_FIFO .* is denied: .*; run as root, or give ",
                            r"(?m)^device cell: error: mlockall is denied beyond 0 KiB")
        self.assertNotIn("INITIALIZE", run.err)
        self.assertNotIn("WARNING", run.err)

    @unittest.skipUnless(os.getuid() == 0 and shutil.which("setpriv"), "needs root and setpriv")
    def test_takt_tells_root_which_capabilities_it_lacks(self):
        """In a container, root has only some of the capabilities."""
        def limit():
            resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))
            resource.setrlimit(resource.RLIMIT_MEMLOCK, (65536, 65536))

        as_root = dict(become=limit, before=["setpriv", "--bounding-set=-sys_nice,-ipc_lock", "--inh-caps=-sys_nice,-ipc_lock"])
        run = self.takt("run", "cell.xml", "--for", "0.2", "--json", **as_root)
        self.assertEqual(0, run.status, run.err)
        self.assertRegex(run.err, r"SCHED_FIFO 1 is denied: .*; root lacks CAP_SYS_NICE here: add it to the container")
        self.assertRegex(run.err, r"mlockall is denied beyond 64 KiB; root lacks CAP_IPC_LOCK here: add it to the container")
        cures = {finding["check"]: finding["cure"] for finding in self.takt("doctor", "--json", **as_root).report["findings"]}
        self.assertRegex(cures["priority"], "^root lacks CAP_SYS_NICE here: ")
        self.assertRegex(cures["memory"], "^root lacks CAP_IPC_LOCK here: ")

    @unittest.skipUnless(shutil.which("taskset"), "no taskset")
    def test_a_cell_without_real_time_rights_can_run_on_a_single_cpu(self):
        run = self.takt("run", self.descriptor, "--for", "1", "--json", before=["taskset", "-c", self.a_processor()], **self.options)
        self.assert_ran(run)
        self.assertRegex(run.err, "no CPU is left for process modules")

    @unittest.skipUnless(shutil.which("taskset"), "no taskset")
    def test_a_cell_with_real_time_rights_can_run_on_a_single_cpu(self):
        run = self.takt("run", "cell.xml", "--for", "1", "--json", before=["taskset", "-c", self.a_processor()])
        self.assert_ran(run)
        self.assertRegex(run.err, "no CPU is left for process modules")

    @staticmethod
    def a_processor():
        return str(min(os.sched_getaffinity(0)))


if __name__ == "__main__":
    takt_system.main()
