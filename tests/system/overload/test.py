import os
import signal
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system

MODULE = """<module><name>%(name)s</name><filename>%(file)s</filename><moduletype>%(type)s</moduletype>
    <operationtype>periodic</operationtype><period>10000000</period><priority>%(priority)d</priority>
    <property>%(properties)s</property>%(more)s</module>\n"""


def module(name, component, priority, more="", **properties):
    values = "".join('<value name="%s">%s</value>' % pair for pair in properties.items())
    return MODULE % {"name": name, "file": component, "type": "process" if component.endswith(".exe") else "thread", "priority": priority,
                     "properties": values, "more": more}


# Every 20th run of this module takes three and a half periods, so that the modules after it in the row miss three releases.
HOG = module("hog", "slow.so", 9, ns=35000000, every=20)


class Overload(takt_system.Case):
    def run_cell(self, modules, executor="", seconds="1.5"):
        cell = self.write("cell.xml", '<cell name="c"><device name="d"><executor name="main" %s/>%s</device></cell>\n' % (executor, modules))
        return self.takt("run", cell, "--for", seconds, "--json")

    def test_the_overrun_policy_decides_whether_missed_releases_are_dropped_or_run_later(self):
        run = self.run_cell(HOG + module("skips", "grid.so", 1, file="skips") +
                            module("all", "grid.so", 2, "<overrun limit=\"1000\">catch-up</overrun>", file="all") +
                            module("one", "grid.so", 3, "<overrun>catch-up</overrun>", file="one"),
                            seconds="1.6")  # ends between two long runs, so nothing is left to catch up
        self.assertEqual(0, run.status, run.err)
        rows = run.executor("main", "d")
        modules = run.modules("d")
        self.assertGreaterEqual(rows["missed"], 6)
        self.assertEqual(rows["missed"], modules["skips"]["missed"])
        self.assertEqual(rows["cycles"], modules["skips"]["cycles"])
        self.assertEqual(0, modules["all"]["missed"])
        self.assertEqual(rows["cycles"] + rows["missed"], modules["all"]["cycles"])
        self.assertGreater(modules["one"]["missed"], 0)
        self.assertEqual(rows["cycles"] + rows["missed"], modules["one"]["cycles"] + modules["one"]["missed"])
        self.assertGreater(modules["one"]["cycles"], rows["cycles"])
        # Each release was on the grid, even if its run started later.
        for name in ("skips", "all", "one"):
            t0, runs, strayed = self.read(name).split()
            self.assertEqual((str(modules[name]["cycles"]), "0"), (runs, strayed), name)

    def test_with_overrun_policy_error_an_overrun_moves_the_module_to_recover(self):
        run = self.run_cell(HOG + module("strict", "fine.so", 1, '<overrun>error</overrun><recovery attempts="100" backoff="1000000"/>'))
        self.assertEqual(0, run.status, run.err)
        steps = [s.text for s in run.steps("strict") if s.target == "RECOVER"]
        self.assertGreaterEqual(len(steps), 2)
        self.assertRegex(steps[0], r"^overrun: \d+ releases? w(as|ere) missed, (from )?number \d+( on)?$")
        # The run may end before the last recovery.
        recovered = [s.target for s in run.steps("strict") if s.source == "RECOVER"]
        self.assertGreaterEqual(recovered.count("EXECUTING"), len(steps) - 1, run.states("strict"))

    def test_a_module_without_an_overrun_policy_uses_the_policy_of_its_executor(self):
        run = self.run_cell(HOG.replace("</property>", "</property><overrun>skip</overrun>") +
                            module("strict", "fine.so", 1, '<recovery attempts="100" backoff="1000000"/>') +
                            module("lax", "fine.so", 2, "<overrun>skip</overrun>"), executor='overrun="error"')
        self.assertEqual(0, run.status, run.err)
        self.assertIn("RECOVER", run.states("strict"))
        self.assertNotIn("RECOVER", run.states("lax"))
        self.assertNotIn("RECOVER", run.states("hog"))

    def test_with_overrun_policy_stop_device_an_overrun_ends_the_device(self):
        run = self.run_cell(HOG + module("vital", "fine.so", 1, "<overrun>stop-device</overrun>"), seconds="20")
        self.assertEqual(1, run.status, run.err)
        self.assertRegex(run.err, r"module d\.vital: error: overrun: \d+ release.*choose an <overrun> other than stop-device")
        self.assertEqual("DESTRUCT", run.states("hog")[-1])

    def test_with_overrun_policy_catch_up_a_program_runs_all_its_releases(self):
        hog = dict(ns=35000000, every=20)
        run = self.run_cell(module("skips", "slow.exe", 1, **hog) +
                            module("owed", "slow.exe", 2, '<overrun limit="1000">catch-up</overrun>', **hog))
        self.assertEqual(0, run.status, run.err)
        rows = run.executor("main", "d")
        modules = run.modules("d")
        for name in ("skips", "owed"):
            self.assertGreaterEqual(modules[name]["overruns"], 6, name)
        self.assertLess(modules["skips"]["cycles"], rows["cycles"])
        # The program with catch-up got one release for each row, even for rows that the executor missed.
        self.assertEqual(rows["cycles"] + rows["missed"], modules["owed"]["cycles"])

    @takt_system.alone("an endless loop at a real-time priority keeps a CPU busy")
    def test_the_node_kills_the_host_of_a_module_that_exceeds_its_hang_limit(self):
        # If `deaf` is true, the hanging thread blocks all signals, so the message cannot name the place at which the thread hangs.
        for budget, limit, deaf in (("", "1.1 s", "false"), ('<budget hang="200000000">300000</budget>', "200 ms", "true"),
                                    ("<budget>300000</budget>", "20 ms", "false")):
            with self.subTest(budget=budget, deaf=deaf):
                cell = self.write("cell.xml", '<cell name="c"><device name="d"><executor name="main"/>%s%s</device></cell>\n' % (
                    module("culprit", "endless.so", 1, budget, after=20, deaf=deaf), module("grid", "grid.so", 2, file="grid")))
                run = self.start("run", cell, "--json")
                # The node restarts the host for the other module.
                takt_system.wait_until(lambda: run.states("grid").count("EXECUTING") == 2, "module grid to execute again")
                run.signal(signal.SIGINT)
                self.assertEqual(1, run.wait().status)
                calls = "" if deaf == "true" else r"; run\(\) was in run at endless\.cpp:\d+ in endless\.so"
                self.assertEqual(1, len(run.other_lines), run.other_lines)
                self.assertRegex(run.other_lines[0], r"^module d\.culprit: error: run\(\) did not return within %s, so the node killed "
                                 r"the host%s$" % (limit, calls))
                self.assertEqual("DESTRUCT", run.states("culprit")[-1])
                self.assertEqual(["DESTRUCT", "IDLE", "INITIALIZE", "START", "EXECUTING"], run.states("grid")[4:9])
                print("hang limit %s: the executor missed %d rows of 10 ms" % (limit, run.executor("main", "d")["missed"]))

    def test_a_budget_tolerates_as_many_overruns_as_its_attributes_allow(self):
        long = dict(ns=2000000, every=7)
        run = self.run_cell(module("often", "slow.so", 1, '<budget in-a-row="2">1000000</budget>', **long) +
                            module("little", "slow.so", 2, '<budget times="1000">1000000</budget>', **long) +
                            module("strict", "slow.so", 3, '<budget>1000000</budget><recovery attempts="0"/>', **long))
        modules = run.modules("d")
        self.assertEqual(1, run.status, run.err)
        self.assertGreaterEqual(modules["often"]["over_budget"], 10)
        self.assertGreaterEqual(modules["little"]["over_budget"], 10)
        self.assertNotIn("RECOVER", run.states("little"))
        self.assertIn("RECOVER", run.states("strict"))


if __name__ == "__main__":
    takt_system.main()
