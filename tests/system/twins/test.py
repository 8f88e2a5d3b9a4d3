import os
import shutil
import signal
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import networks
import takt_system
from takt_system import wait_until


class Twins(networks.NetworkCase):
    MACHINES = ("robot", "line", "spare")

    def begin(self):
        """Runs the cell on nodes robot and line. Copies the state folder of line to machine spare, as a cloned disk does."""
        self.running = self.nodes("robot", "line")
        self.first = self.running["line"]
        self.deploy("cell.xml")
        self.wait_for_states({"robot": "EXECUTING", "line": "EXECUTING"})
        shutil.copytree(os.path.join(self.folder, "line"), os.path.join(self.folder, "spare"))

    def start_second(self):
        self.second = self.node("line", "--resume", on="spare", environment={"TAKT_STATE_DIR": os.path.join(self.folder, "spare")})

    def lines(self):
        """Returns the part of takt status about each node named line."""
        return [d for d in self.status_of()["devices"] if d["name"] == "line"]

    def assert_second_is_the_line(self):
        self.second.wait_for_line(r"line\.grid: START -> EXECUTING")
        wait_until(lambda: ["EXECUTING"] == [m["state"] for d in self.lines() if "conflict" not in d for m in d["modules"]] or None,
                   "the second node to be the only node named line")
        self.done("stop line.grid")
        self.end({"robot": self.running["robot"], "line": self.second})

    def test_a_second_node_with_the_same_name_executes_nothing_and_commands_to_the_name_are_rejected(self):
        self.begin()
        self.start_second()
        self.second.wait_for_line(r"another node named line is on domain 0: process %d on \S+, which (executes|has executed) cell cell" % self.first.pid)
        self.second.wait_for_line("this node waits and does not restore its deployment")
        self.first.wait_for_line(r"another node named line is on domain 0: process %d on " % self.second.pid)
        rejected = r"(?m)^device line: error: 2 nodes on domain 0 have this name: "
        for command in ("stop line.grid", "set line.grid file other"):
            for _ in range(6):
                for run in self.at_once(*[command] * 5):
                    self.assertEqual((1, ""), (run.status, run.out), run.err)
                    self.assertRegex(run.err, rejected)
        lines = self.lines()
        self.assertEqual(2, sum("another node named line" in d.get("conflict", "") for d in lines))
        self.assertEqual([0, 1], sorted(len(d["modules"]) for d in lines), "only one node has modules")
        self.assertEqual(["EXECUTING"], [m["state"] for d in lines for m in d["modules"]])
        self.assertNotIn("preparing", self.second.err)
        self.first.signal(signal.SIGTERM)
        self.assertEqual(0, self.first.wait().status)
        self.assert_second_is_the_line()

    def test_a_node_that_was_cut_off_ends_if_another_node_has_taken_its_place(self):
        self.begin()
        self.net.cut("line")
        self.start_second()
        # The second node must have executed for longer than the 2 s in which the nodes count as equally old.
        wait_until(lambda: [d for d in self.lines() if d["alive"] and d["executors"] and d["executors"][0]["cycles"] > 1000] or None,
                   "the second node to execute for 5 s")
        self.net.join("line")
        self.first.wait_for_line(r"another node named line is on domain 0: process %d on .* this node stops and ends" % self.second.pid)
        self.assertEqual(1, self.first.wait().status)
        self.assertIn("EXECUTING -> START", self.first.err)
        self.assert_second_is_the_line()


if __name__ == "__main__":
    takt_system.main()
