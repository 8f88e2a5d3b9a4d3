import json
import os
import re
import shutil
import signal
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import LIFE, wait_until

STARTED = LIFE[:4]
HOST = r"the host of executor risky"


class Containment(takt_system.Case):
    def setUp(self):
        super().setUp()
        with open(self.beside("cell.xml")) as file:
            self.cell = file.read()

    def run_with(self, *changes):
        text = self.cell
        for old, new in changes:
            self.assertEqual(1, text.count(old), old)
            text = text.replace(old, new)
        run = self.start("run", self.write("cell.xml", text), "--json")
        for module in ("grid", "far", "program"):
            run.wait_for_state(module, "EXECUTING")
        return run

    def finish(self, run):
        run.signal(signal.SIGINT)
        run.wait()
        return run.modules()

    def assert_untouched(self, run, hosts=0):
        """Checks that the other executor ran every row, and that its modules went only through the normal states."""
        for module in ("grid", "source", "near"):
            self.assertEqual(LIFE, run.states(module))
        t0, runs, strayed = map(int, self.read("grid").split())
        self.assertEqual(0, strayed)
        self.assertEqual(run.modules()["grid"]["cycles"], runs, "there must be one instance from the first release to the last")
        near = json.loads(self.read("near"))
        self.assertEqual((1, 0, 0), (near["first"], near["gaps"], near["wrong"]))
        self.assertEqual(hosts, run.err.count("is started again"))

    def test_samples_pass_between_two_host_processes(self):
        run = self.run_with()
        modules = {}

        def some_went():
            modules.update({m["name"]: m for m in self.status_of("d")["modules"]})
            return modules["source"]["cycles"] > 200 and modules["far"]["cycles"] > 10
        wait_until(some_went, "some samples")
        motion, risky = modules["grid"]["pid"], modules["far"]["pid"]
        self.assertNotEqual(motion, risky)
        self.assertEqual({motion, risky}, {p.pid for p in run.processes() if p.program == "takt-host"})
        self.finish(run)
        self.assertEqual(0, run.status, run.err)
        self.assert_untouched(run)
        far = json.loads(self.read("far"))
        self.assertGreater(far["read"], 100)
        self.assertEqual((1, 0, 0), (far["first"], far["gaps"], far["wrong"]))

    def test_a_crashing_module_is_given_up_without_disturbing_other_hosts(self):
        run = self.run_with(('<value name="after">1000000', '<value name="after">25'))
        run.wait_for_state("culprit", "DESTRUCT")
        wait_until(lambda: [step.target for step in run.steps("far")].count("EXECUTING") == 4, "its host's other module to run")
        modules = self.finish(run)
        self.assertEqual(1, run.status, run.err)
        self.assertEqual(STARTED + ["RECOVER", "EXECUTING"] * 2 + ["RECOVER", "DESTRUCT"], run.states("culprit"))
        for step in run.steps("culprit"):
            if step.target == "RECOVER":
                self.assertRegex(step.text, r"^crash: %s was killed by SIGSEGV .* in run\(\), in .* in segv\.so$" % HOST)
        self.assertEqual(3, modules["culprit"]["errors"])
        self.assertIn(modules["culprit"]["cycles"], range(72, 76), "25 runs of each of 3 instances, whose last run crashed")
        self.assertRegex(run.err, r"module d\.culprit: error: it was given up: .*SIGSEGV")
        # The other module of the host was loaded three more times, and continued to read where it had stopped in the queue.
        self.assertEqual(STARTED + (["DESTRUCT"] + STARTED) * 3 + LIFE[4:], run.states("far"))
        self.assertEqual(LIFE, run.states("program"))
        self.assertEqual(0, json.loads(self.read("far"))["wrong"])
        self.assert_untouched(run, hosts=3)

    @takt_system.alone("an endless loop at a real-time priority keeps a CPU busy")
    def test_an_endless_loop_in_a_module_ends_only_its_own_host(self):
        # The next instance reaches its endless loop after a second. The test ends the run before that.
        run = self.run_with(("segv.so", "endless.so"), ('<value name="after">1000000', '<value name="after">250'))
        run.wait_for_state("culprit", "RECOVER")
        run.wait_for_line(r"\.culprit: RECOVER -> EXECUTING")
        self.finish(run)
        self.assertRegex(run.steps("culprit")[3].text, r"hang: run\(\) did not return within .*so the node killed %s" % HOST)
        self.assert_untouched(run, hosts=1)

    def test_a_host_that_ends_after_every_restart_does_not_disturb_other_hosts(self):
        run = self.run_with()

        def host_of(module):
            return next(m for m in self.status_of("d")["modules"] if m["name"] == module)["pid"]

        for time_round in range(4):
            begun = len(run.raw)
            os.kill(host_of("far"), signal.SIGKILL)
            if time_round < 3:
                run.wait_for_line(r"\.far: START -> EXECUTING", after=begun)
        run.wait_for_line(HOST + r" is given up; the other hosts continue", after=begun)
        self.wait_for_states({"d": {"grid": "EXECUTING", "far": "DESTRUCT", "culprit": "DESTRUCT", "program": "DESTRUCT"}})
        wait_until(lambda: not run.processes("grid.exe"), "its program to end")

        # The host stays given up until an operator resets one of its modules.
        begun = len(run.raw)
        self.done("restart d.far")
        run.wait_for_line(r"\.far: START -> EXECUTING", after=begun)
        self.wait_for_states({"d": {"far": "EXECUTING"}})
        self.finish(run)
        self.assertEqual(1, run.status)
        self.assertRegex(run.err, r"module d\.far: error: %s was killed by SIGKILL .*; it has been restarted 3 times" % HOST)
        self.assert_untouched(run, hosts=4)

    def test_properties_and_commands_reach_the_host_of_their_module(self):
        run = self.run_with()
        self.done("set d.far most 5", "set d.near most 7")
        self.assertEqual(["5", "7"], self.done("get d.far most", "get d.near most"))
        self.done("stop d.far", "stop d.near")
        states = self.states_of("d")
        self.assertEqual(("START", "START", "EXECUTING"), (states["far"], states["near"], states["culprit"]))
        self.done("start d.far", "start d.near")
        self.finish(run)
        self.assertEqual(0, run.status, run.err)


KEEPS = """<root>
  <executor name="risky" host="own"/>
  <module>
    <name>keeps</name> <filename>%(file)s</filename>
    <moduletype>thread</moduletype> <operationtype>periodic</operationtype>
    <period>4000000</period> <priority>1</priority>
    <recovery attempts="2" backoff="300000000"/> <retain>%(retain)s</retain>
    <property><value name="after">%(after)d</value></property>
  </module>
  <module>
    <name>neighbour</name> <filename>keeps_c.so</filename>
    <moduletype>thread</moduletype> <operationtype>periodic</operationtype>
    <period>4000000</period> <priority>2</priority>
  </module>
</root>"""

PROGRAMS = """<root>
  <module>
    <name>keeps</name> <filename>%(file)s</filename>
    <moduletype>process</moduletype> <operationtype>periodic</operationtype>
    <period>4000000</period> <priority>1</priority>
    <recovery attempts="2" backoff="300000000"/> <retain>%(retain)s</retain>
    <property><value name="after">%(after)d</value></property>
  </module>
  <module>
    <name>in_c</name> <filename>keeps_program_c.exe</filename>
    <moduletype>process</moduletype> <operationtype>periodic</operationtype>
    <period>4000000</period> <priority>2</priority>
    <recovery attempts="2" backoff="300000000"/>
  </module>
</root>"""

RECALLS = """<cell name="recalls">
  <device name="d">
    <executor name="risky" host="own"/>
    <module>
      <name>writer</name> <filename>recalls.so</filename>
      <moduletype>thread</moduletype> <operationtype>periodic</operationtype>
      <period>4000000</period> <priority>1</priority> <executor>risky</executor>
      <property><value name="number">7</value></property>
    </module>
    <module>
      <name>reader</name> <filename>recalls.so</filename>
      <moduletype>thread</moduletype> <operationtype>periodic</operationtype>
      <period>4000000</period> <priority>2</priority> <executor>risky</executor>
    </module>
  </device>
  <connection from="d.writer.out" to="d.reader.in"/>
</cell>"""


class Saved(takt_system.Case):
    """The next instance of a module restores the state that the module saved."""

    def run_keeping(self, file="keeps.so", after=1000000000, retain="false"):
        run = self.start("run", self.write("cell.xml", KEEPS % {"file": file, "after": after, "retain": retain}), "--json")
        run.wait_for_state("neighbour", "EXECUTING")
        return run

    def wait_for_runs(self, more=50):
        """Waits until the first module has run this many more times."""
        def runs():
            return self.status_of()["devices"][0]["modules"][0]["cycles"]
        before = runs()
        wait_until(lambda: runs() > before + more, "some runs")

    def said_of(self, run, what):
        """Returns what the instances printed about their state in start()."""
        return [line.text for line in run.lines if line.module == "(host risky)" and line.text.startswith(what)]

    def finish(self, run):
        run.signal(signal.SIGINT)
        run.wait()

    def test_a_module_restores_its_saved_state_after_one_crash_but_not_after_a_second(self):
        run = self.run_keeping(after=50)
        run.wait_for_state("keeps", "DESTRUCT")
        wait_until(lambda: len(self.said_of(run, "c has")) == 4, "the other module to start again")
        self.finish(run)
        # The run that crashed was not saved. The second instance crashed in its own 50th run.
        self.assertEqual(["version 1 began 0", "version 1 restored 49", "version 1 began 0"], self.said_of(run, "version"))
        self.assertEqual(1, run.err.count("keeps: its saved state was restored"))
        runs = [int(text.split()[-1]) for text in self.said_of(run, "c has")]
        self.assertEqual(4, len(runs), runs)
        self.assertEqual([0] + sorted(runs[1:]), runs)
        self.assertGreaterEqual(runs[1], 48)
        self.assertLessEqual(runs[3], run.modules()["neighbour"]["cycles"])

    def test_a_module_restores_the_state_of_another_version_only_if_it_supports_that_version(self):
        folder = os.environ["TAKT_COMPONENT_PATH"].split(":")[0]
        mine = os.path.join(self.folder, "mine.so")
        shutil.copy(os.path.join(folder, "keeps.so"), mine)
        run = self.run_keeping(file=mine, retain="true")
        self.wait_for_runs()
        self.finish(run)
        shutil.copy(os.path.join(folder, "keeps_more.so"), mine)
        run = self.run_keeping(file=mine, retain="true")
        run.wait_for_line(r"keeps: restore\(\) converted the state that version 1 saved")
        run.wait_for_line(r"version 2 restored \d{2,}")
        # Version 2 has saved its state, and then version 1 is loaded again. Version 1 cannot restore this state, says so, and starts at 0.
        self.wait_for_runs()
        self.finish(run)
        shutil.copy(os.path.join(folder, "keeps.so"), mine)
        run = self.run_keeping(file=mine, retain="true")
        run.wait_for_line(r"keeps: its saved state was not restored: the saved value has version 2, but .*override restore\(\)")
        self.finish(run)
        self.assertEqual("version 1 began 0", self.said_of(run, "version")[-1])

    def test_retained_state_of_a_module_survives_a_restart_of_the_cell(self):
        first = self.run_keeping(retain="true")
        self.wait_for_runs()
        self.finish(first)
        self.assertEqual(0, first.status, first.err)
        second = self.run_keeping(retain="true")
        second.wait_for_line(r"keeps: its saved state was restored")
        wait_until(lambda: self.said_of(second, "version") and self.said_of(second, "c has"), "both modules to print their state")
        self.assertEqual(["version 1 restored %d" % first.modules()["keeps"]["cycles"]], self.said_of(second, "version"))
        self.assertEqual(["c has 0"], self.said_of(second, "c has"), "the other module does not retain its state")
        # An operator can make the module start from the beginning.
        device = self.status_of()["devices"][0]["name"]
        self.done("restart %s.keeps" % device)
        wait_until(lambda: len(self.said_of(second, "version")) == 2, "the module to print its state")
        self.assertEqual("version 1 began 0", self.said_of(second, "version")[-1])
        self.finish(second)

    def test_the_latest_values_of_ports_survive_a_crash_of_the_host(self):
        run = self.start("run", self.write("cell.xml", RECALLS), "--json")
        run.wait_for_state("reader", "EXECUTING")
        self.wait_for_runs()
        for _ in range(2):
            said = len(self.said_of(run, "holds"))
            os.kill(run.one("takt-host").pid, signal.SIGKILL)
            wait_until(lambda: len(self.said_of(run, "holds")) > said, "the reader to start again")
            self.wait_for_runs()
        self.finish(run)
        self.assertEqual(["holds 0", "holds 7", "holds 7"], self.said_of(run, "holds"))


class SavedByPrograms(takt_system.Case):
    def run_keeping(self, file="keeps_program.exe", after=1000000000, retain="false"):
        run = self.start("run", self.write("cell.xml", PROGRAMS % {"file": file, "after": after, "retain": retain}), "--json")
        run.wait_for_state("in_c", "EXECUTING")
        return run

    def cycles(self):
        return {m["name"]: m["cycles"] for m in self.status_of()["devices"][0]["modules"]}

    def told(self, run, module, what):
        return [line for line in run.printed(module) if line.startswith(what)]

    def finish(self, run):
        run.signal(signal.SIGINT)
        run.wait()

    def test_a_program_restores_its_saved_state_after_one_crash_but_not_after_a_second(self):
        run = self.run_keeping(after=50)
        run.wait_for_state("keeps", "DESTRUCT")
        self.finish(run)
        # The second instance restored the state and crashed too, so the third instance starts without this state.
        self.assertEqual(["version 1 began 0", "version 1 restored 49", "version 1 began 0"],
                         self.told(run, "keeps", "version"))
        self.assertEqual(["takt: the program's saved state was restored"], self.told(run, "keeps", "takt:"))
        self.assertEqual(["c has 0"], run.printed("in_c"), "the crash of another program must not affect this program")

    def test_killed_programs_in_cpp_and_c_restore_their_saved_state(self):
        run = self.run_keeping()
        wait_until(lambda: min(self.cycles().values()) > 50, "some bodies")
        for module, file in (("keeps", "keeps_program.exe"), ("in_c", "keeps_program_c.exe")):
            begun = len(run.raw)
            os.kill(run.one(file).pid, signal.SIGKILL)
            run.wait_for_line(r"\.%s: RECOVER -> EXECUTING" % module, after=begun)
        self.finish(run)
        modules = run.modules()
        for module, before in (("keeps", r"version 1 restored (\d+)"), ("in_c", r"c has (\d+)")):
            found = int(re.fullmatch(before, run.printed(module)[-1])[1])
            self.assertGreater(found, 48)
            self.assertLessEqual(found, modules[module]["cycles"])

    def test_a_program_does_not_restore_state_that_another_version_saved(self):
        folder = os.environ["TAKT_COMPONENT_PATH"].split(":")[0]
        mine = os.path.join(self.folder, "mine.exe")
        shutil.copy(os.path.join(folder, "keeps_program.exe"), mine)
        run = self.run_keeping(file=mine)
        wait_until(lambda: min(self.cycles().values()) > 50, "some bodies")
        shutil.copy(os.path.join(folder, "keeps_program_more.exe"), mine + ".new")
        os.replace(mine + ".new", mine)
        os.kill(run.one("mine.exe").pid, signal.SIGKILL)
        run.wait_for_line(r"saved state was not restored: it has version 1 \(8 bytes\), but this program saves version 2 \(16 bytes\)")
        run.wait_for_line(r"version 2 began 0")
        self.finish(run)

    def test_retained_state_of_a_program_survives_a_restart_of_the_cell(self):
        first = self.run_keeping(retain="true")
        wait_until(lambda: min(self.cycles().values()) > 50, "some bodies")
        self.finish(first)
        self.assertEqual(0, first.status, first.err)
        second = self.run_keeping(retain="true")
        self.finish(second)
        found = int(self.told(second, "keeps", "version 1 restored")[0].split()[-1])
        # The end of the run may have interrupted the last body of the program.
        self.assertIn(first.modules()["keeps"]["cycles"] - found, (0, 1))
        self.assertEqual(["c has 0"], second.printed("in_c"), "this program does not retain its state")

    def test_takt_describe_shows_the_version_and_size_of_the_saved_state_of_a_program(self):
        told = json.loads(self.done("describe keeps_program_more.exe --json")[0])
        self.assertEqual({"version": 2, "bytes": 16}, told["saved"])


if __name__ == "__main__":
    takt_system.main()
