import glob
import os
import signal
import subprocess
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import LIFE, wait_until


# Replaces fsync() in a node: the disk does not answer while the file HANGS exists.
HANGING_DISK = r"""
#include <cstdlib>
#include <sys/syscall.h>
#include <unistd.h>
extern "C" int fsync(int file) {
  while (access(getenv("HANGS"), F_OK) == 0) usleep(1000);
  return static_cast<int>(syscall(SYS_fsync, file));
}
"""

KEEPS = """<cell name="keeps">
  <device name="robot">
    <module>
      <name>keeps</name>
      <filename>keeps.so</filename> <moduletype>thread</moduletype> <operationtype>periodic</operationtype>
      <period>4000000</period> <priority>1</priority> <retain>true</retain>
      <property><value name="after">1000000000</value></property>
    </module>
  </device>
</cell>"""


class Resume(takt_system.Case):
    def executes(self, node):
        for module in ("grid", "program"):
            node.wait_for_line(r" robot\.%s: START -> EXECUTING" % module)

    def gone(self, node):
        wait_until(lambda: not [p for p in node.processes() if p.alive], "the host and the programs of the node to end")

    def kept(self):
        found = glob.glob(os.path.join(self.folder, "state", "robot.*.deployment"))
        self.assertLessEqual(len(found), 1)
        return found[0] if found else None

    def first_release(self):
        return int(self.read("grid").split()[0])

    def assert_waits(self, node):
        status = self.status_of()
        self.assertEqual(("-", [[]]), (status["cell"], [d["modules"] for d in status["devices"]]))
        self.assertEqual(["takt-node"], [p.program for p in node.processes()])

    def test_a_restarted_node_resumes_its_cell_on_the_same_grid(self):
        node = self.node("robot")
        self.deploy("cell.xml")
        self.executes(node)
        instants = []
        for number in (signal.SIGKILL, signal.SIGTERM, signal.SIGKILL):
            node.signal(number)
            self.assertEqual(-9 if number == signal.SIGKILL else 0, node.wait().status, node.err)
            self.gone(node)
            if number == signal.SIGTERM:
                self.assertEqual(LIFE, node.states("grid"))
                instants.append(self.first_release())
            node = self.node("robot", "--resume")
            self.executes(node)
            # The restarted node skips the rows that were due while it was dead.
            executor = self.status_of("robot")["executors"][0]
            print("%s: rows walked %d, missed %d" % (number.name, executor["cycles"], executor["missed"]))
            self.assertLess(executor["missed"], 3000)
            self.assertEqual("cell", self.status_of()["cell"])
        self.done("undeploy cell")
        instants.append(self.first_release())
        print("its grids differ by %d ns" % (instants[1] - instants[0]))
        self.assertLess(abs(instants[0] - instants[1]), 20000)
        self.assertIsNone(self.kept())
        node.signal(signal.SIGKILL)
        node.wait()
        node = self.node("robot", "--resume")
        self.assert_waits(node)
        self.end({"robot": node})

    def node_with_hanging_disk(self):
        """Starts a node whose disk does not answer while the file `hangs` exists. Returns the node and the path of this file."""
        library = os.path.join(self.folder, "hanging_disk.so")
        subprocess.run(["c++", "-shared", "-fPIC", "-o", library, self.write("hanging_disk.cpp", HANGING_DISK)], check=True)
        hangs = os.path.join(self.folder, "hangs")
        return self.node("robot", environment={"LD_PRELOAD": library, "HANGS": hangs}), hangs

    def answers(self):
        begun = time.monotonic()
        report = self.status_of("robot")
        print("takt status took %.2f s while the disk did not answer" % (time.monotonic() - begun))
        self.assertTrue(report["alive"])
        return report

    def test_a_reset_is_answered_when_no_retained_state_is_left_on_disk(self):
        cell = self.write("keeps.xml", KEEPS)
        node, hangs = self.node_with_hanging_disk()
        self.deploy(cell)
        saved = os.path.join(self.folder, "state", "keeps.robot.keeps.saved")
        wait_until(lambda: os.path.exists(saved), "the saved state on disk")
        self.done("destruct robot.keeps")
        self.write("hangs", "")
        reset = self.start("reset", "robot.keeps")
        node.wait_for_line(r" robot\.keeps: DESTRUCT -> IDLE")
        self.assertEqual({"keeps": "IDLE"}, {m["name"]: m["state"] for m in self.answers()["modules"]})
        self.assertIsNone(reset.status)
        os.remove(hangs)
        self.assertEqual(0, reset.wait().status, reset.err)
        node.signal(signal.SIGKILL)
        node.wait()
        self.gone(node)
        node = self.node("robot")
        self.deploy(cell)
        node.wait_for_line("version 1 began 0")
        self.done("undeploy keeps")
        self.end({"robot": node})

    def test_a_node_answers_while_its_disk_does_not_and_confirms_only_what_is_on_disk(self):
        node, hangs = self.node_with_hanging_disk()

        self.write("hangs", "")
        deploy = self.start("deploy", self.beside("cell.xml"))
        for module in ("grid", "program"):
            node.wait_for_line(r" robot\.%s: INITIALIZE -> START" % module)
        self.assertEqual(("ready", "prepared"), tuple(self.answers()[key] for key in ("state", "stage")))
        self.assertIsNone(deploy.status)
        os.remove(hangs)
        self.assertEqual(0, deploy.wait().status, deploy.err)
        self.executes(node)
        self.assertIsNotNone(self.kept())

        self.write("hangs", "")
        undeploy = self.start("undeploy", "cell")
        node.wait_for_line("cell cell is undeployed")
        self.assertEqual("waiting", self.answers()["state"])
        self.assertIsNone(undeploy.status)
        os.remove(hangs)
        self.assertEqual(0, undeploy.wait().status, undeploy.err)
        self.assertIsNone(self.kept())
        self.end({"robot": node})

    def test_a_node_restarted_without_the_option_resume_does_not_start_its_saved_cell(self):
        node = self.node("robot")
        self.deploy("cell.xml")
        self.executes(node)
        node.signal(signal.SIGKILL)
        node.wait()
        self.gone(node)
        node = self.node("robot")
        node.wait_for_line("cell cell was deployed here before and is not restored; .*--resume")
        self.assert_waits(node)
        # The node still accepts a new deployment.
        self.deploy("cell.xml")
        self.executes(node)
        self.done("undeploy cell")
        self.end({"robot": node})

    def test_a_node_does_not_resume_a_cell_from_a_damaged_file(self):
        node = self.node("robot")
        self.deploy("cell.xml")
        self.executes(node)
        node.signal(signal.SIGTERM)
        self.assertEqual(0, node.wait().status)
        path = self.kept()
        with open(path, "rb") as file:
            whole = file.read()
        half = len(whole) // 2
        for what, content in (("cut short", whole[:half]), ("empty", b""), ("text", b"This is no deployment.\n"),
                              ("bytes", bytes(range(256)) * 16), ("one bit", whole[:half] + bytes([whole[half] ^ 1]) + whole[half + 1:])):
            with self.subTest(what):
                with open(path, "wb") as file:
                    file.write(content)
                node = self.node("robot", "--resume")
                said = node.wait_for_line("nothing is restored")
                self.assertIn(path, said)
                self.assertRegex(said, "damaged: .*; deploy the cell again$")
                self.assertEqual(["takt-node"], [p.program for p in node.processes()])
                if what == "cut short":
                    self.assert_waits(node)
                if what != "one bit":
                    self.end({"robot": node})
        self.deploy("cell.xml")
        self.executes(node)
        node.signal(signal.SIGKILL)
        node.wait()
        self.gone(node)
        node = self.node("robot", "--resume")
        self.executes(node)
        self.done("undeploy cell")
        self.end({"robot": node})


if __name__ == "__main__":
    takt_system.main()
