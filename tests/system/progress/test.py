import os
import re
import signal
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from terminal import Terminal

FILLED = r"^\[[#.]{20}\] +"
BAR = FILLED + r"\d+ %  "


class Progress(takt_system.Case):
    def in_terminal(self, *arguments):
        terminal = Terminal(100, 300)
        self.addCleanup(terminal.close)
        return terminal, self.start(*arguments, terminal=terminal.slave, become=terminal.become, error=terminal.slave,
                                    environment={"LC_ALL": "C"})

    def ends(self, terminal, run, last):
        """Waits for the end of the run. After that, the terminal must not show a progress line."""
        self.assertEqual(0, run.wait().status)
        terminal.wait_for(last)
        self.assertNotRegex(terminal.text, BAR[1:])
        self.assertEqual([], terminal.strange)

    def test_takt_simulate_shows_its_progress(self):
        terminal, run = self.in_terminal("simulate", "cell.xml", "--for", "4000")
        terminal.wait_for(BAR + r"\d+\.\d of 4000 s simulated, \d+ times real time$")
        self.ends(terminal, run, "^takt: simulated 4000 s in ")

    def test_takt_deploy_shows_its_progress(self):
        terminal, run = self.in_terminal("deploy", "cell.xml")
        terminal.wait_for("^waiting for devices line, robot ")
        nodes = self.nodes("robot", "line")
        self.ends(terminal, run, "^cell cell runs on robot, line$")
        self.assertIn("preparing 2 devices ...", terminal.lines)
        for line in (r"robot\.grid: (START|EXECUTING)", r"line\.other: (START|EXECUTING)", "robot: (ready|running)", "line: (ready|running)"):
            self.assertTrue(any(re.fullmatch(line, shown) for shown in terminal.lines), (line, terminal.lines))
        self.done("undeploy cell")
        self.end(nodes)

    def test_takt_run_shows_its_progress_with_the_option_quiet(self):
        terminal, run = self.in_terminal("run", "cell.xml", "--quiet", "--for", "3")
        terminal.wait_for(BAR + "[123] of 3 s$")
        self.ends(terminal, run, "^  other +DESTRUCT ")
        for line in (r"robot\.grid: (START|EXECUTING)", r"line\.other: (START|EXECUTING)"):
            self.assertTrue(any(re.fullmatch(line, shown) for shown in terminal.lines), (line, terminal.lines))

    def test_takt_run_shows_no_progress_line_without_the_option_quiet(self):
        terminal, run = self.in_terminal("run", "cell.xml", "--for", "2")
        terminal.wait_for("grid: START -> EXECUTING")
        self.ends(terminal, run, "^  other +DESTRUCT ")
        self.assertNotRegex(terminal.text, r"robot\.grid: (START|EXECUTING)$")

    @takt_system.alone("the benchmark keeps a CPU busy")
    def test_takt_bench_shows_its_progress(self):
        terminal, run = self.in_terminal("bench", "wake", "--period", "1000", "--for", "2.5")
        for share in (r"\d{1,2}", r"[5-9]\d"):
            terminal.wait_for(FILLED + share + r" %  wake-up by [a-z ]+ at 1 ms$")
        self.ends(terminal, run, "^  spin ")

    @takt_system.alone("the benchmark keeps a CPU busy")
    def test_takt_bench_table1_shows_which_case_it_measures(self):
        terminal, run = self.in_terminal("bench", "table1", "--for", "0.2")
        terminal.wait_for(BAR + "case [2-5] of 10: (Takt|the bare loop)")
        terminal.wait_for("^ 1 .*")  # the results so far must be above the progress line
        terminal.wait_for(BAR + "case [6-9] of 10: (Takt|the bare loop)")
        self.ends(terminal, run, "^ *10 ")

    def test_takt_record_and_takt_play_show_their_progress(self):
        source = self.start("run", "source.xml")
        source.wait_for_state("source", "EXECUTING")
        terminal, run = self.in_terminal("record", "d.source.*", "--out", "a.takt", "--for", "4")
        terminal.wait_for(r"^[23] s, 1 ports, \d+ samples, \d+/s, \S+ \S+, 0 lost$")
        self.ends(terminal, run, r"^takt record: \d+ samples of ")
        self.assertNotRegex(terminal.text, r"\d s, \d ports")
        source.signal(signal.SIGINT)
        source.wait()
        terminal, run = self.in_terminal("play", "a.takt")
        terminal.wait_for(BAR + r"[12]\.\d of [34]\.\d s, \d+ samples$")
        self.ends(terminal, run, r"^takt play: \d+ samples of ")

    def test_takt_prints_no_progress_if_standard_error_is_not_a_terminal(self):
        run = self.takt("simulate", "cell.xml", "--for", "4000")
        self.assertEqual(0, run.status, run.err)
        self.assertNotRegex(run.out + run.err, "[\r\x1b]|times real time$|%  ")
        nodes = self.nodes("robot", "line")
        run = self.deploy("cell.xml")
        self.assertNotRegex(run.out + run.err, "[\r\x1b]|%  |: START")
        self.done("undeploy cell")
        self.end(nodes)


if __name__ == "__main__":
    takt_system.main()
