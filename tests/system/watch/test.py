import os
import re
import signal
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import wait_until
from terminal import DOWN, ENTER, ESCAPE, Terminal, UP
from tmux import Tmux


class Watch(takt_system.Case):
    def open(self, *arguments, rows=24, columns=100, **options):
        terminal = Terminal(rows, columns)
        self.addCleanup(terminal.close)
        run = self.start("watch", *arguments, terminal=terminal.slave, become=terminal.become,
                         environment={"LC_ALL": "C", "NO_COLOR": ""}, **options)
        return terminal, run

    def cell(self):
        self.running = self.nodes("robot", "line")
        self.deploy("cell.xml")

    def finish(self):
        self.done("undeploy cell")
        self.end(self.running)

    def choose(self, terminal, name):
        """Presses the arrow keys until the row is selected."""
        def chosen():
            return next((line.split()[1] for line in terminal.lines if line.startswith("> ")), None)

        def there():
            lines = terminal.lines
            marked = next((i for i, line in enumerate(lines) if line.startswith("> ")), None)
            wanted = next((i for i, line in enumerate(lines) if re.match(r"[> ] +%s\b" % name, line)), None)
            if marked is None or wanted is None:
                return False
            if marked == wanted:
                return True
            terminal.press((DOWN if wanted > marked else UP) * abs(wanted - marked))
            # A row that appears or disappears at this moment moves the mark to another row, so the keys may be pressed again.
            end = time.monotonic() + takt_system.SOON
            while chosen() != name and time.monotonic() < end:
                time.sleep(0.02)
            return chosen() == name
        wait_until(there, "%s to be chosen" % name)

    def leave(self, terminal, run, how):
        how()
        self.assertEqual(0, run.wait().status, run.err)
        wait_until(terminal.restored, "the terminal to be restored")
        self.assertEqual([], terminal.strange)
        self.assertEqual("", run.err)

    def test_takt_watch_shows_the_current_state_of_each_device_and_module(self):
        terminal, run = self.open()
        terminal.wait_for("no devices found on this domain")
        self.assertTrue(terminal.alternate)
        self.assertFalse(terminal.cursor)
        self.running = self.nodes("robot", "line")
        for device in self.running:
            terminal.wait_for(r"^[> ] %s +o waiting$" % device)
        self.deploy("cell.xml")
        terminal.wait_for(r"^[> ] robot +\* running$")
        terminal.wait_for(r"^[> ] line +! running +module fails is in RECOVER")
        number = r"\d+(\.\d+)?"
        # The columns are p50, p99, run time in the last minute, budget, overruns, errors and cycles.
        terminal.wait_for(r"^ +grid +\* EXECUTING +%s +%s +[_.,\-=+*# ]*[_.,\-=+*#] +\d+ %% +\d+ +0 +\d+$" % (number, number))
        terminal.wait_for(r"^ +program +\* EXECUTING +%s +%s +[_.,\-=+*# ]+ - +\d+ +0 +\d+$" % (number, number))
        terminal.wait_for(r"^ +fails +! RECOVER .*failure: run\(\)")
        terminal.wait_for(r"^takt watch  cell  domain %d  2 devices  [1-9]\d* unacknowledged alarms?  4 modules  1 RECOVER +\d\d:\d\d:\d\d$" % self.domain)
        # The lines at the bottom show the last event, the last faults, also those from before a takt watch began, and the keys.
        terminal.wait_for(r"^  \d\d:\d\d:\d\d\.\d{3} line\.fails: error: failure ")
        terminal.wait_for(r"^  \d\d:\d\d:\d\d\.\d{3} line\.fails: EXECUTING -> RECOVER")
        terminal.wait_for(r"^Enter details .*q quit")
        self.running["robot"].signal(signal.SIGKILL)
        terminal.wait_for(r"^[> ] robot +X LOST")
        terminal.wait_for(r"^ +grid +X LOST")
        terminal.wait_for(r"  2 devices, 1 LOST  [1-9]\d* unacknowledged alarms?  4 modules  2 LOST")
        self.running["robot"].wait()
        # A takt watch that starts now also shows the loss.
        late, second = self.open()
        late.wait_for(r"^[> ] robot +X LOST")
        late.wait_for(r"^  \d\d:\d\d:\d\d\.\d{3} line: device-lost ")
        late.wait_for(r"  2 devices, 1 LOST  [1-9]\d* unacknowledged alarms?  4 modules  2 LOST")
        self.assertNotIn("all EXECUTING", late.text)
        self.leave(late, second, lambda: late.press("q"))
        self.running["robot"] = self.node("robot", "--resume")
        terminal.wait_for(r"^ +grid +\* EXECUTING")
        self.done("undeploy cell")
        for device in self.running:
            terminal.wait_for(r"^[> ] %s +o waiting$" % device)
        self.end(self.running)
        terminal.wait_for("no devices found on this domain")
        self.leave(terminal, run, lambda: terminal.press("q"))

    def test_a_key_in_takt_watch_sends_a_command_to_the_selected_module(self):
        self.cell()
        terminal, run = self.open()
        terminal.wait_for(r"^ +fails +! RECOVER")
        terminal.wait_for(r"^ +grid +\* EXECUTING")
        for module in ("grid", "program"):
            self.choose(terminal, module)
            terminal.press("ty")
            terminal.wait_for(r"^robot\.%s: START \(stopped\)$" % module)
            terminal.wait_for(r"^> +%s +o START\b" % module)
            terminal.press("ty")
            terminal.wait_for(r"robot\.%s: stop is not allowed in state START; it is allowed in EXECUTING" % module)
            terminal.press("sy")
            terminal.wait_for(r"^robot\.%s: EXECUTING$" % module)
            terminal.wait_for(r"^> +%s +\* EXECUTING\b" % module)
        begun = len(self.running["line"].raw)
        self.choose(terminal, "fails")
        terminal.press("r")
        terminal.wait_for(r"^line\.fails: EXECUTING$")
        self.running["line"].wait_for_line("fails: RECOVER -> EXECUTING", after=begun)
        # A command to a device applies to all its modules.
        self.choose(terminal, "robot")
        terminal.press("ty")
        for module in ("grid", "program"):
            terminal.wait_for(r"^ +%s +o START\b" % module)
        terminal.press("sy")
        for module in ("grid", "program"):
            terminal.wait_for(r"^ +%s +\* EXECUTING\b" % module)
        # The selection does not move beyond the first and last row. Keys without a meaning have no effect.
        terminal.press(UP * 20 + "zZ7\t\x1b[15~")
        terminal.wait_for(r"^> line\b")
        terminal.press(DOWN * 20)
        terminal.wait_for(r"^> +program\b")
        self.assertIsNone(run.status)
        self.leave(terminal, run, lambda: terminal.press("q"))
        self.finish()

    def test_takt_watch_fits_its_screen_to_a_terminal_of_any_size(self):
        self.cell()
        for rows, columns in ((1, 1), (2, 3), (3, 200), (5, 10), (60, 20)):
            with self.subTest(rows=rows, columns=columns):
                terminal, run = self.open(rows=rows, columns=columns)
                wait_until(lambda: terminal.alternate and terminal.seen > 10 + rows, "something on the screen")
                terminal.press(DOWN * 3 + UP)
                self.leave(terminal, run, lambda: terminal.press("q"))
        terminal, run = self.open(rows=24, columns=100)
        terminal.wait_for(r"^ +grid +\* EXECUTING")
        self.done("stop robot.grid")
        line = terminal.wait_for(r"^  \d\d:\d\d:\d\d\.\d{3} robot\.grid: EXECUTING -> START")
        terminal.resize(24, len(line) - 5)
        terminal.wait_for("^%s~$" % re.escape(line[:-6].rstrip()))
        for rows, columns in ((1, 1), (6, 40), (2, 500), (24, 100)):
            seen = terminal.seen
            terminal.resize(rows, columns)
            wait_until(lambda: terminal.seen > seen, "a screen of the new size")
            if rows >= 6:
                terminal.wait_for("^> line")
        terminal.wait_for(r"^Enter details .*q quit")
        del terminal.strange[:]  # takt watch drew these characters for the larger size
        self.leave(terminal, run, lambda: terminal.press("q"))
        self.finish()

    def test_takt_watch_shows_the_details_of_one_module_or_device(self):
        self.cell()
        terminal, run = self.open(rows=40)
        terminal.wait_for(r"^ +grid +\* EXECUTING")
        self.choose(terminal, "grid")
        terminal.press(ENTER)
        terminal.wait_for(r"^robot\.grid$")
        # takt watch reads these lines from the descriptor of the running cell.
        terminal.wait_for(r"^  runs +thread, periodic, every 1 ms$")
        terminal.wait_for(r"^  executor +main, priority 1$")
        terminal.wait_for(r"^  budget +500 us$")
        terminal.wait_for(r"^  cycles +\d{2,} +missed \d+ +overruns \d+ +over budget \d+$")
        terminal.wait_for(r"^  errors +0 +recoveries 0$")
        terminal.wait_for(r"^  jitter +p50 \S+ +p99 \S+ +p99.9 \S+ +max \S+ us$")
        terminal.wait_for(r"^  last minute .* \S+ us$")
        terminal.wait_for(r"^  run time +p50 +\S+ us [#.]+ +\d+ %")
        terminal.wait_for(r"^  transitions +\d\d:\d\d:\d\d\.\d{3} START -> EXECUTING +run$")
        self.done("stop robot.grid")
        terminal.wait_for(r"^  state +o START \(stopped\)$")
        terminal.wait_for(r"^  transitions +\d\d:\d\d:\d\d\.\d{3} EXECUTING -> START +stop$")
        terminal.press("sy")
        terminal.wait_for(r"^  state +\* EXECUTING$")
        terminal.press("n")
        terminal.wait_for(r"^robot\.program$")
        terminal.wait_for(r"the descriptor gives no budget")
        terminal.press(ESCAPE)
        terminal.wait_for(r"^> +program")
        self.choose(terminal, "robot")
        terminal.press(ENTER)
        terminal.wait_for(r"^  health +ok$")
        terminal.wait_for(r"^  node +process %d$" % self.running["robot"].pid)
        terminal.wait_for(r"^  main +\d+ +\d+ +\d+ +\S+ +\S+ +\S+ +\S+$")
        terminal.press(ESCAPE + "c")
        terminal.wait_for("the cell has no connections")
        terminal.press(ESCAPE + "?")
        terminal.wait_for("reset, restart, destruct; confirm with y")
        self.leave(terminal, run, lambda: terminal.press("q"))
        self.finish()

    def test_takt_watch_shows_the_newest_values_of_the_ports_of_a_module(self):
        self.running = self.nodes("robot", "line")
        self.deploy(os.path.join("..", "web", "cell.xml"))
        terminal, run = self.open(rows=40)
        terminal.wait_for(r"^ +sink +\* EXECUTING")
        self.choose(terminal, "sink")
        terminal.press(ENTER)
        terminal.wait_for(r"^  in +in +\S+ +\d+ \* ok")
        value = r"^      number: (\d+)"
        def number():
            return int(next((re.match(value, line)[1] for line in terminal.lines if re.match(value, line)), 0))
        before = wait_until(number, "a value of the port")
        wait_until(lambda: number() > before, "a newer value of the port")
        self.done("stop robot.source")
        terminal.wait_for(value + r".* \(\d+ s ago\)$")
        self.done("start robot.source")
        terminal.press("p")
        terminal.wait_for(r"^line\.fails$")
        self.leave(terminal, run, lambda: terminal.press("q"))
        self.finish()

    def test_takt_watch_reacts_to_keys_while_a_command_is_unanswered(self):
        self.cell()
        terminal, run = self.open()
        terminal.wait_for(r"^ +stubborn +\* EXECUTING")
        self.choose(terminal, "stubborn")
        terminal.press("D")
        terminal.wait_for(r"^destruct line\.stubborn\? y: yes")
        terminal.press("n")
        terminal.wait_for(r"^destruct of line\.stubborn cancelled")
        terminal.press("Dy")
        terminal.wait_for(r"destruct of line\.stubborn, [1-9] s \.\.\.$")
        # The command has no reply yet, but keys still work.
        for _ in range(3):
            terminal.press(UP)
            terminal.wait_for(r"^> +fails")
            terminal.press(DOWN)
            terminal.wait_for(r"^> +stubborn")
        terminal.wait_for(r"destruct of line\.stubborn, \d+ s \.\.\.$")
        terminal.press(ENTER)
        terminal.wait_for(r"^line\.stubborn$")
        # The key q also works.
        self.leave(terminal, run, lambda: terminal.press("q"))
        self.finish()

    def test_takt_watch_restores_the_terminal_however_it_ends(self):
        terminals = [self.open(*arguments) for arguments in ((), (), (), ("--for", "3"))]
        for terminal, _ in terminals:
            terminal.wait_for("devices.* on this domain")
        ways = (lambda: terminals[0][0].press("\x03"), lambda: terminals[1][1].signal(signal.SIGTERM),
                lambda: terminals[2][1].signal(signal.SIGHUP), lambda: None)
        for (terminal, run), way in zip(terminals, ways):
            self.leave(terminal, run, way)
        # takt watch also ends if its terminal is closed.
        terminal, run = self.open()
        terminal.wait_for("devices.* on this domain")
        terminal.close()
        self.assertIn(run.wait().status, (0, 1))

    def test_takt_watch_without_a_terminal_prints_a_line_for_each_transition(self):
        run = self.start("watch")
        self.running = self.nodes("robot", "line")
        for device in self.running:  # a takt watch that starts later prints only the last transition
            run.wait_for_out(r"^\S+ %s: waiting" % device)
        self.deploy("cell.xml")
        for module in ("robot.grid", "robot.program", "line.fails"):
            for step in ("IDLE -> INITIALIZE", "INITIALIZE -> START", "START -> EXECUTING"):
                run.wait_for_out(r"^\d\d:\d\d:\d\d\.\d{3} %s: %s$" % (re.escape(module), step))
        for state in ("waiting", "preparing", "running"):  # the state "ready" can be too short for an observer to see
            run.wait_for_out(r"^\S+ robot: %s" % state)
        run.wait_for_out(r"^\S+ line\.fails: EXECUTING -> RECOVER \(failure: run\(\) threw as it was asked to\)$")
        self.finish()
        run.signal(signal.SIGINT)
        self.assertEqual(0, run.wait().status)


class InTmux(takt_system.Case):
    def open(self, columns=80, rows=24):
        program = os.path.join(takt_system.BIN, "takt")
        tmux = Tmux(self.folder, ["sh", "-c", "%s watch; echo left with $?; sleep 1000" % program], columns, rows,
                    {"TAKT_DOMAIN": str(self.domain)})
        self.addCleanup(tmux.close)
        return tmux

    def test_takt_watch_works_in_tmux_at_80_by_24_characters(self):
        running = self.nodes("robot", "line")
        self.deploy("cell.xml")
        tmux = self.open()
        tmux.wait_for("^  ▲device, module +state +p50 us +p99 us +last minute +budget +over +err$")
        tmux.wait_for("^    grid +● EXECUTING .* [▁▂▃▄▅▆▇█]+ ")
        tmux.wait_for("^    fails +▲ RECOVER +failure: run")
        self.assertEqual(24, len(tmux.lines))
        self.assertLessEqual(max(len(line) for line in tmux.lines), 80)
        self.assertIn("1", tmux.show("alternate_on"))
        coloured = tmux.coloured
        self.assertRegex(coloured, "\x1b\\[32m● EXECUTING")
        self.assertRegex(coloured, "\x1b\\[31m▲ RECOVER")
        # Sort by state, first with the worst state at the top, then in reverse order.
        tmux.press(">")
        tmux.wait_for("module +▲state")
        self.assertRegex(tmux.lines[2], r"line\.fails +▲ RECOVER")
        tmux.press("v")
        tmux.wait_for("module +▼state")
        self.assertRegex(tmux.lines[5], r"line\.fails +▲ RECOVER")
        # Typing text filters the rows.
        tmux.press("<", "/")
        tmux.type("grix")
        tmux.wait_for("^/grix_$")
        tmux.wait_for("no rows match the filter")
        tmux.press("BSpace")
        tmux.type("d")
        tmux.wait_for("^. +grid +● EXECUTING")
        tmux.gone("^[> ] +(program|fails) ")
        tmux.press("Enter", "Down")
        tmux.wait_for("^>   grid")
        tmux.press("Enter")
        tmux.wait_for(r"^  run time +p50 +\S+ us [█▏▎▍▌▋▊▉·]+ +\d+ %")
        tmux.press("t", "y")
        tmux.wait_for(r"^  state +○ START \(stopped\)$")
        tmux.press("s", "y")
        tmux.wait_for("^  state +● EXECUTING$")
        tmux.press("Escape")
        tmux.wait_for("^>   grid")
        tmux.press("Escape")
        tmux.wait_for("^    program")
        # The terminal is resized while takt watch runs.
        for columns, rows in ((40, 10), (200, 60), (20, 5), (80, 24)):
            tmux.resize(columns, rows)
            wait_until(lambda: len(tmux.lines) == rows and tmux.lines[-1].startswith("Enter details"[:columns - 1]),
                       "the keys at the bottom of %d by %d" % (columns, rows))
            self.assertLessEqual(max(len(line) for line in tmux.lines), columns)
        tmux.press("q")
        tmux.wait_for("^left with 0$")
        self.assertEqual("0", tmux.show("alternate_on"))
        self.assertEqual("1", tmux.show("cursor_flag"))
        self.assertEqual("1", tmux.show("wrap_flag"))
        self.done("undeploy cell")
        self.end(running)

    def test_takt_watch_shows_a_hundred_modules_in_tmux(self):
        descriptor = self.write("many.xml", "<cell name='many'><device name='robot'>%s</device></cell>" % "".join(
            "<module><name>m%03d</name><filename>fine.so</filename><moduletype>thread</moduletype>"
            "<operationtype>periodic</operationtype><period>10000000</period><priority>1</priority></module>" % i
            for i in range(100)))
        running = self.nodes("robot")
        self.deploy(descriptor)
        tmux = self.open()
        tmux.wait_for("100 modules  all EXECUTING")
        tmux.wait_for("^    m000 +● EXECUTING +[0-9]")
        tmux.press("End")
        tmux.wait_for("^>   m099 +● EXECUTING")
        tmux.press("Home", *["Down"] * 50)
        tmux.wait_for("^>   m049 +● EXECUTING")
        tmux.press("t", "y")
        tmux.wait_for("^>   m049 +○ START")
        tmux.wait_for("100 modules  1 START")
        tmux.press("/")
        tmux.type("robot.m02")
        tmux.wait_for("^ +m020")
        self.assertEqual(10, sum("EXECUTING" in line and "->" not in line and "modules" not in line for line in tmux.lines))
        tmux.press("Escape", "q")
        tmux.wait_for("^left with 0$")
        self.done("undeploy many")
        self.end(running)


if __name__ == "__main__":
    takt_system.main()
