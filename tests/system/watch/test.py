import os
import re
import signal
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import wait_until
from terminal import DOWN, Terminal, UP


class Watch(takt_system.Case):
    def open(self, *arguments, rows=24, columns=100, **options):
        terminal = Terminal(rows, columns)
        self.addCleanup(terminal.close)
        run = self.start("watch", *arguments, terminal=terminal.slave, become=terminal.become, **options)
        return terminal, run

    def cell(self):
        self.running = self.nodes("robot", "line")
        self.deploy("cell.xml")

    def finish(self):
        self.done("undeploy cell")
        self.end(self.running)

    def choose(self, terminal, name):
        """Presses the arrows until the mark is on it."""
        def there():
            lines = terminal.lines
            marked = next((i for i, line in enumerate(lines) if line.startswith("> ")), None)
            wanted = next((i for i, line in enumerate(lines) if re.match(r"[> ] +%s\b" % name, line)), None)
            if marked is None or wanted is None:
                return False
            if marked == wanted:
                return True
            terminal.press((DOWN if wanted > marked else UP) * abs(wanted - marked))
            wait_until(lambda: re.match(r"> +%s\b" % name, terminal.lines[wanted]), 5, "the mark on %s" % name)
            return True
        wait_until(there, 15, "%s to be chosen" % name)

    def leave(self, terminal, run, how):
        how()
        self.assertEqual(0, run.wait(10).status, run.err)
        wait_until(terminal.restored, 5, "the terminal to be as it was")
        self.assertEqual([], terminal.strange)
        self.assertEqual("", run.err)

    def test_shows_what_is_there_and_follows_it(self):
        terminal, run = self.open()
        terminal.wait_for("no device is to be seen on this domain")
        self.assertTrue(terminal.alternate)
        self.assertFalse(terminal.cursor)
        self.running = self.nodes("robot", "line")
        for device in self.running:
            terminal.wait_for(r"^[> ] %s +waiting$" % device)
        self.deploy("cell.xml")
        for device in self.running:
            terminal.wait_for(r"^[> ] %s +running\b" % device)
        for module in ("grid", "program"):
            terminal.wait_for(r"^ +%s +EXECUTING +\d+ +\d+\.\d\d +\d+\.\d\d +\d+ +0$" % module)
        terminal.wait_for(r"^ +fails +RECOVER .*failure: run\(\)")
        # What happened last, and what the keys are.
        terminal.wait_for(r"^  \d\d:\d\d:\d\d\.\d{3} line\.fails: EXECUTING -> RECOVER")
        terminal.wait_for(r"^arrows choose .*q quit")
        self.running["robot"].signal(signal.SIGKILL)
        terminal.wait_for(r"^[> ] robot +LOST")
        terminal.wait_for(r"^ +grid +LOST")
        self.running["robot"].wait(10)
        self.running["robot"] = self.node("robot", "--resume")
        terminal.wait_for(r"^ +grid +EXECUTING")
        self.done("undeploy cell")
        for device in self.running:
            terminal.wait_for(r"^[> ] %s +waiting$" % device)
        self.end(self.running)
        terminal.wait_for("no device is to be seen on this domain")
        self.leave(terminal, run, lambda: terminal.press("q"))

    def test_keys_tell_the_module_that_is_chosen(self):
        self.cell()
        terminal, run = self.open()
        terminal.wait_for(r"^ +fails +RECOVER")
        terminal.wait_for(r"^ +grid +EXECUTING")
        for module in ("grid", "program"):
            self.choose(terminal, module)
            terminal.press("t")
            terminal.wait_for(r"^robot\.%s: START$" % module)
            terminal.wait_for(r"^> +%s +START\b" % module)
            terminal.press("t")
            terminal.wait_for(r"stop is refused in state START; it is allowed in EXECUTING")
            terminal.press("s")
            terminal.wait_for(r"^robot\.%s: EXECUTING$" % module)
            terminal.wait_for(r"^> +%s +EXECUTING\b" % module)
        begun = len(self.running["line"].raw)
        self.choose(terminal, "fails")
        terminal.press("r")
        terminal.wait_for(r"^line\.fails: EXECUTING$")
        self.running["line"].wait_for_line("fails: RECOVER -> EXECUTING", after=begun)
        # A device is all of its modules.
        self.choose(terminal, "robot")
        terminal.press("t")
        for module in ("grid", "program"):
            terminal.wait_for(r"^ +%s +START\b" % module)
        terminal.press("s")
        for module in ("grid", "program"):
            terminal.wait_for(r"^ +%s +EXECUTING\b" % module)
        # At the ends the mark stays, and a key that means nothing does nothing.
        terminal.press(UP * 20 + "zZ7\t\r")
        terminal.wait_for(r"^> line\b")
        terminal.press(DOWN * 20)
        terminal.wait_for(r"^> +program\b")
        self.assertIsNone(run.status)
        self.leave(terminal, run, lambda: terminal.press("q"))
        self.finish()

    def test_a_terminal_of_any_size(self):
        self.cell()
        for rows, columns in ((1, 1), (2, 3), (3, 200), (5, 10), (60, 20)):
            with self.subTest(rows=rows, columns=columns):
                terminal, run = self.open(rows=rows, columns=columns)
                wait_until(lambda: terminal.alternate and terminal.seen > 10 + rows, 15, "something on the screen")
                terminal.press(DOWN * 3 + UP)
                self.leave(terminal, run, lambda: terminal.press("q"))
        terminal, run = self.open(rows=24, columns=100)
        line = terminal.wait_for(r"^  \d\d:\d\d:\d\d\.\d{3} line\.fails: \S+ -> RECOVER")
        terminal.resize(24, len(line) - 5)
        terminal.wait_for("^%s$" % re.escape(line[:-5].rstrip()))
        for rows, columns in ((1, 1), (5, 40), (2, 500), (24, 100)):
            seen = terminal.seen
            terminal.resize(rows, columns)
            wait_until(lambda: terminal.seen > seen, 5, "a screen of the new size")
            if rows >= 5:
                terminal.wait_for("^> line")
        terminal.wait_for(r"^arrows choose .*q quit")
        del terminal.strange[:]  # what was drawn for a larger one just before
        self.leave(terminal, run, lambda: terminal.press("q"))
        self.finish()

    def test_however_it_ends_the_terminal_is_restored(self):
        terminals = [self.open(*arguments) for arguments in ((), (), (), ("--for", "3"))]
        for terminal, _ in terminals:
            terminal.wait_for("no device")
        ways = (lambda: terminals[0][0].press("\x03"), lambda: terminals[1][1].signal(signal.SIGTERM),
                lambda: terminals[2][1].signal(signal.SIGHUP), lambda: None)
        for (terminal, run), way in zip(terminals, ways):
            self.leave(terminal, run, way)
        # There may be nobody left to restore it for.
        terminal, run = self.open()
        terminal.wait_for("no device")
        terminal.close()
        self.assertIn(run.wait(10).status, (0, 1))

    def test_without_a_terminal_a_line_is_printed_for_each_transition(self):
        run = self.start("watch")
        self.running = self.nodes("robot", "line")
        for device in self.running:  # who comes later is told the last transition alone
            run.wait_for_out(r"^\S+ %s: waiting" % device)
        self.deploy("cell.xml")
        for module in ("robot.grid", "robot.program", "line.fails"):
            for step in ("IDLE -> INITIALIZE", "INITIALIZE -> START", "START -> EXECUTING"):
                run.wait_for_out(r"^\d\d:\d\d:\d\d\.\d{3} %s: %s$" % (re.escape(module), step))
        for state in ("waiting", "preparing", "ready", "running"):
            run.wait_for_out(r"^\S+ robot: %s" % state)
        run.wait_for_out(r"^\S+ line\.fails: EXECUTING -> RECOVER \(failure: run\(\) threw as it was asked to\)$")
        self.finish()
        run.signal(signal.SIGINT)
        self.assertEqual(0, run.wait(10).status)


if __name__ == "__main__":
    takt_system.main()
