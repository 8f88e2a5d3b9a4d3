import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system

# Periods in ms. Run times are at most 2 ms, which is shorter than a row.
PERIODS = {"m0": 20, "m1": 20, "m2": 40, "m3": 60}
CONNECTIONS = [("m0", "m1.a"), ("m1", "m2.a"), ("m2", "m0.a"), ("m0", "m3.a"), ("m3", "m1.b"), ("m2", "m3.b"), ("m1", "m0.b")]
RUNS_MS = 600


class LogicalTime(takt_system.Case):
    def cell(self, executors, timing):
        text = '<cell name="c"><device name="d">\n'
        text += "".join('<executor name="e%d" timing="%s"/>\n' % (e, timing) for e in range(executors))
        for i, (name, period) in enumerate(PERIODS.items()):
            text += """<module><name>%s</name><filename>mixer.so</filename><moduletype>thread</moduletype>
                <operationtype>periodic</operationtype><period>%d000000</period><priority>%d</priority><executor>e%d</executor>
                <property><value name="file">%s</value><value name="runs">%d</value><value name="most">1000000</value></property>
                </module>\n""" % (name, period, i, i % executors, name, RUNS_MS // period)
        text += "</device>\n"
        for number, (source, target) in enumerate(CONNECTIONS):
            kind = 'kind="queue" depth="16"' if number % 3 == 2 else ""
            text += '<connection from="d.%s.out" to="d.%s" %s/>\n' % (source, target, kind)
        return self.write("cell.xml", text + "</cell>\n")

    def computed(self, executors, timing):
        """Returns the results of all modules after a run without missed rows and overruns. Repeats the run if a stall of the machine
        disturbed it."""
        cell = self.cell(executors, timing)
        for _ in range(20):
            run = self.takt("run", cell, "--for", "1.1", "--json", "--quiet")
            self.assertEqual(0, run.status, run.err)
            modules = run.modules("d").values()
            rows = [run.executor("e%d" % e, "d")["missed"] for e in range(executors)]
            if any(rows) or any(m["overruns"] for m in modules):
                continue
            return [self.read(name) for name in PERIODS]
        self.fail("all 20 runs had missed rows or overruns")

    @takt_system.alone("the test compares runs row by row, and a missed row would change the results")
    def test_with_logical_execution_time_results_do_not_depend_on_run_times(self):
        one = self.computed(1, "let")
        for name, text in zip(PERIODS, one):
            self.assertEqual(RUNS_MS // PERIODS[name], int(text.split()[0]), name)
        self.assertEqual(one, self.computed(1, "let"))
        self.assertEqual(one, self.computed(2, "let"))
        self.assertEqual(one, self.computed(2, "let"))

    @takt_system.alone("the test compares two runs row by row, and a missed row would change the results")
    def test_without_logical_execution_time_results_depend_on_run_times(self):
        self.assertNotEqual(self.computed(2, "direct"), self.computed(2, "direct"))


if __name__ == "__main__":
    takt_system.main()
