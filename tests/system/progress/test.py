import os
import re
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from terminal import Terminal

BAR = r"^\[[#.]{20}\] +\d+ %  "


class Progress(takt_system.Case):
    def in_terminal(self, *arguments):
        terminal = Terminal(50, 300)
        self.addCleanup(terminal.close)
        return terminal, self.start(*arguments, terminal=terminal.slave, become=terminal.become, error=terminal.slave,
                                    environment={"LC_ALL": "C"})

    def ends(self, terminal, run, last):
        """In order, and nothing but what stays is left of it."""
        self.assertEqual(0, run.wait(120).status)
        terminal.wait_for(last)
        self.assertNotRegex(terminal.text, "s simulated")
        self.assertEqual([], terminal.strange)

    def test_of_a_simulation(self):
        terminal, run = self.in_terminal("simulate", "cell.xml", "--for", "2000")
        terminal.wait_for(BAR + r"\d+\.\d of 2000 s simulated, \d+ times as fast$", 60)
        self.ends(terminal, run, "^takt: simulated 2000 s in ")

    def test_of_a_deployment(self):
        terminal, run = self.in_terminal("deploy", "cell.xml")
        terminal.wait_for("^waiting for line, robot ")
        nodes = self.nodes("robot", "line")
        self.ends(terminal, run, "^cell cell runs on robot, line$")
        self.assertIn("preparing 2 devices ...", terminal.lines)
        for line in (r"robot\.grid: (START|EXECUTING)", r"line\.other: (START|EXECUTING)", "robot: (ready|running)", "line: (ready|running)"):
            self.assertTrue(any(re.fullmatch(line, shown) for shown in terminal.lines), (line, terminal.lines))
        self.done("undeploy cell")
        self.end(nodes)

    def test_is_not_there_without_a_terminal(self):
        run = self.takt("simulate", "cell.xml", "--for", "2000", limit=120)
        self.assertEqual(0, run.status, run.err)
        self.assertNotRegex(run.out + run.err, "[\r\x1b]|times as fast$|%  ")
        nodes = self.nodes("robot", "line")
        run = self.deploy("cell.xml")
        self.assertNotRegex(run.out + run.err, "[\r\x1b]|%  |: START")
        self.done("undeploy cell")
        self.end(nodes)


if __name__ == "__main__":
    takt_system.main()
