import glob
import json
import os
import resource
import shutil
import subprocess
import sys
import time
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import machine
import takt_system
from takt_system import LIFE, wait_until

MODULES = ("grid", "source", "keeps", "program")


def fill(folder):
    """Fills the disk with one file and returns the path of this file."""
    path = os.path.join(folder, "filler")
    with open(path, "ab", buffering=0) as file:
        try:
            while True:
                file.write(bytes(4096))
        except OSError:
            return path


class Exhaustion(takt_system.Case):
    """Helpers for tests in which the machine of a running cell runs out of a resource."""

    def begin(self, **options):
        node = self.node("robot", **options)
        self.deploy("cell.xml")
        self.wait_for_states({"robot": "EXECUTING"})
        return node

    def walk_on(self, rows):
        """Waits until `rows` more rows have run. Checks that every thread module is EXECUTING and had no error."""
        def cycles():
            return self.status_of("robot")["executors"][0]["cycles"]
        until = cycles() + rows
        wait_until(lambda: cycles() >= until, "%d more rows" % rows)
        for module in self.status_of("robot")["modules"]:
            if module["type"] == "thread":
                self.assertEqual(("EXECUTING", 0), (module["state"], module["errors"]), module["name"])

    def finish(self, node):
        self.done("undeploy cell")
        self.end({"robot": node})
        self.assertEqual(LIFE, node.states("grid"))
        t0, runs, strayed = (int(word) for word in self.read("grid").split())
        self.assertGreater(runs, 0)
        self.assertEqual(0, strayed, "releases off the grid")


@unittest.skipIf(machine.MISSING, machine.MISSING)
class FullDisk(Exhaustion):
    def setUp(self):
        super().setUp()
        self.state = os.path.join(self.folder, "state")
        os.mkdir(self.state)

    def tearDown(self):
        super().tearDown()
        subprocess.run(["umount", "-l", self.state], capture_output=True, check=False)
        shutil.rmtree(self.folder, ignore_errors=True)  # super().tearDown() could not remove the folder while it contained a mount point

    def mount(self, size, how=""):
        subprocess.run(["mount", "-t", "tmpfs", "-o", how + "size=" + size, "tmpfs", self.state], check=True)

    def kept(self):
        return glob.glob(os.path.join(self.state, "robot.*.deployment"))

    def recorded(self):
        """Reads the events directly from the file of the fault record, not through the node."""
        found = glob.glob(os.path.join(self.state, "robot.*.faults"))
        self.assertEqual(1, len(found))
        return [json.loads(line) for line in self.done("log --file %s --json" % found[0])[0].splitlines()]

    def a_fault(self, node):
        """Causes a fault: kills a program, and waits until its module is EXECUTING again."""
        before = len(node.steps("program"))
        node.one("grid.exe").kill()
        wait_until(lambda: [s.target for s in node.steps("program")[before:]][-1:] == ["EXECUTING"], "the program to execute again")

    def test_a_node_writes_its_missing_files_when_a_full_disk_has_space_again(self):
        self.mount("64k")
        filler = fill(self.state)
        full = r"warning: .*%s/.*No space left on device; free space on its disk, or name a folder on another disk"
        node = self.node("robot")
        node.wait_for_line(r"the fault record: .*robot\.\d+\.faults: No space left on device")
        self.deploy("cell.xml")
        self.wait_for_states({"robot": "EXECUTING"})
        node.wait_for_line(r"cell cell could not be saved for --resume: .*No space left on device")
        node.wait_for_line(r"cannot write the state that modules retain to disk: .*No space left on device")
        self.a_fault(node)
        node.wait_for_line(r"no trace was written: .*No space left on device")
        self.walk_on(3000)
        self.assertEqual(4, sum("No space left" in line for line in node.raw), "each of the four must be reported once")
        for line in node.raw:
            if "No space left" in line:
                self.assertRegex(line, full % self.state)
        self.assertEqual([], self.kept())
        in_memory = [json.loads(line) for line in self.done("log --json")[0].splitlines()]
        self.assertIn("program", [event["module"] for event in in_memory])

        os.remove(filler)
        self.mount("64m", "remount,")
        for what in ("the fault record is written to its file again: ", "cell cell is saved for --resume again",
                     "the state that modules retain is on disk again: "):
            node.wait_for_line(what + ".*")
        self.assertEqual(1, len(self.kept()))
        self.assertEqual(in_memory, self.recorded()[:len(in_memory)])
        self.a_fault(node)
        trace = node.wait_for_line("a trace of the last few seconds was written; show it with takt trace ").split()[-1]
        self.assertTrue(os.path.exists(trace), trace)

        # Fill the disk again. The file of the fault record already has its full size, so no event is lost.
        after = len(node.raw)
        fill(self.state)
        node.wait_for_line(r"cannot write the state that modules retain to disk: .*No space left on device", after=after)
        self.a_fault(node)
        self.done("set robot.source burst 2")
        self.assertIn("set burst = 2 was carried out", [event["cause"] for event in self.recorded()])
        os.remove(filler)
        node.wait_for_line("the state that modules retain is on disk again: ", after=after)
        self.walk_on(500)
        self.finish(node)

    def test_takt_record_reports_a_full_disk(self):
        self.mount("256k")
        node = self.begin()
        fill(self.state)
        recording = self.takt("record", "robot.source.out", "--for", "3", "--out", os.path.join(self.state, "a.takt"))
        self.assertEqual(1, recording.status, recording.err)
        self.assertRegex(recording.err, "a.takt.*(full|No space left)")
        self.walk_on(500)
        self.finish(node)

    def test_a_swap_succeeds_in_a_running_cell_while_dev_shm_is_full(self):
        subprocess.run(["mount", "-t", "tmpfs", "-o", "size=4k", "tmpfs", "/dev/shm"], check=True)
        self.addCleanup(subprocess.run, ["umount", "-l", "/dev/shm"], check=True)
        fill("/dev/shm")
        node = self.begin()
        self.walk_on(500)
        self.done("swap robot.source port_source.so", "echo robot.source.out --count 3")
        self.walk_on(500)
        self.finish(node)
        os.remove("/dev/shm/filler")
        self.assertEqual([], os.listdir("/dev/shm"))


def without_descriptors(process):
    """Lowers the limit of the process so that it cannot open any more files. Returns its old limit."""
    def look():
        return {int(name) for name in os.listdir("/proc/%d/fd" % process.pid)}
    opened = look()
    for _ in range(50):  # skip descriptors that are open only for a moment
        time.sleep(0.005)
        opened &= look()
    first_free = next(number for number in range(len(opened) + 1) if number not in opened)
    before = resource.prlimit(process.pid, resource.RLIMIT_NOFILE)
    resource.prlimit(process.pid, resource.RLIMIT_NOFILE, (first_free, before[1]))
    return before


def processor_time(process):
    """Returns the CPU time of each thread, in seconds."""
    ticks = os.sysconf("SC_CLK_TCK")
    used = {}
    for task in os.listdir("/proc/%d/task" % process.pid):
        with open("/proc/%d/task/%s/stat" % (process.pid, task)) as file:
            fields = file.read().rsplit(")", 1)[1].split()
        used[task] = (int(fields[11]) + int(fields[12])) / ticks
    return used


class NoDescriptors(Exhaustion):
    NONE_LEFT = r"Too many open files; raise the limit on open files of this process: ulimit -n, prlimit --nofile or, for a service, LimitNOFILE="

    def test_a_swap_that_fails_because_the_node_has_no_free_file_descriptors_does_not_disturb_the_cell(self):
        node = self.begin()
        process = node.one("takt-node")
        threads = process.threads()
        limit = without_descriptors(process)
        before, began = processor_time(process), time.monotonic()
        self.done("get robot.source burst", "stop robot.source", "log --last 1")
        self.done("set robot.source burst 2", "start robot.source", "trace robot")
        swap = self.takt("swap", "robot.source", "port_source.so")
        self.assertEqual(1, swap.status)
        self.assertRegex(swap.err, self.NONE_LEFT)
        # While these rows run, the node does all its periodic work at least once.
        self.walk_on(6000)
        spent = time.monotonic() - began
        for task, used in processor_time(process).items():
            self.assertLess(used - before.get(task, 0.0), 0.6 * spent, "a thread must not spin")
        self.assertGreaterEqual(process.threads(), threads, "a thread has ended")
        self.assertNotIn("getifaddrs", node.err, "the error must not be repeated")
        self.done("echo robot.source.out --count 3")
        resource.prlimit(process.pid, resource.RLIMIT_NOFILE, limit)
        self.done("swap robot.source port_source.so", "echo robot.source.out --count 3")
        self.finish(node)

    def test_a_swap_that_fails_because_the_host_has_no_free_file_descriptors_does_not_disturb_the_cell(self):
        node = self.begin()
        host = node.one("takt-host")
        limit = without_descriptors(host)
        self.done("get robot.source burst", "set robot.source burst 2", "stop robot.source")
        self.done("start robot.source", "echo robot.source.out --count 3")
        swap = self.takt("swap", "robot.source", "port_source.so")
        self.assertEqual(1, swap.status)
        self.assertRegex(swap.err, "port_source.so: .*Too many open files")
        self.walk_on(2000)
        resource.prlimit(host.pid, resource.RLIMIT_NOFILE, limit)
        self.done("swap robot.source port_source.so")
        self.walk_on(500)
        self.finish(node)

    def test_a_node_with_too_few_file_descriptors_reports_why_it_cannot_start(self):
        for most in (4, 6, 8, 12, 24, 40):
            with self.subTest(most):
                def become(most=most):
                    resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
                run = self.program("takt-node", "--device", "robot", become=become).wait()
                self.assertEqual(1, run.status, run.err)
                self.assertRegex(run.err, "Too many open files|cannot open shared object file")

    def test_a_node_with_too_little_memory_reports_why_it_cannot_start(self):
        for megabytes in (40, 64):
            with self.subTest(megabytes):
                def become(most=megabytes << 20):
                    resource.setrlimit(resource.RLIMIT_AS, (most, most))
                run = self.program("takt-node", "--device", "robot", become=become).wait()
                if run.status == 127:  # the dynamic loader could not start the program
                    self.assertRegex(run.err, "error while loading shared libraries")
                else:
                    self.assertEqual(1, run.status, run.err)
                    self.assertRegex(run.err, "the system denied takt-node memory or a new thread: .*; free memory, or raise the limits")

    def test_a_node_without_free_file_descriptors_rejects_a_deployment(self):
        node = self.node("robot")
        process = node.one("takt-node")
        limit = without_descriptors(process)
        refused = self.takt("deploy", "cell.xml")
        self.assert_refused(refused, self.NONE_LEFT)
        resource.prlimit(process.pid, resource.RLIMIT_NOFILE, limit)
        self.deploy("cell.xml")
        self.wait_for_states({"robot": "EXECUTING"})
        self.walk_on(500)
        self.finish(node)


if __name__ == "__main__":
    takt_system.main()
