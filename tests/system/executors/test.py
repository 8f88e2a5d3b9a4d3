import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system


class Executors(takt_system.Case):
    def cell(self, priority):
        cpu = max(os.sched_getaffinity(0))
        modules = ""
        for executor, component, period, ns in (("slow", "slow.so", 20, 9000000), ("fast", "grid.so", 1, 0)):
            properties = '<property><value name="ns">%d</value></property>' % ns if ns else ""
            modules += """<module><name>m_%s</name><filename>%s</filename><moduletype>thread</moduletype>
                <operationtype>periodic</operationtype><period>%d000000</period><priority>1</priority><executor>%s</executor>
                %s</module>\n""" % (executor, component, period, executor, properties)
        return self.write("cell.xml", """<cell name="c"><device name="d">
            <executor name="slow" cpu="%d" priority="%s"/><executor name="fast" cpu="%d" priority="%s"/>
            %s</device></cell>\n""" % (cpu, priority, cpu, priority, modules))

    def missed(self, priority):
        """Runs the cell and returns the fraction of the rows that the fast table missed."""
        run = self.takt("run", self.cell(priority), "--for", "1", "--json", "--quiet")
        self.assertEqual(0, run.status, run.err)
        rows = run.executor("fast", "d")
        return rows["missed"] / (rows["cycles"] + rows["missed"])

    @takt_system.alone("two executors share one CPU, and the test counts the missed rows of one of them")
    def test_automatic_priorities_keep_a_slow_executor_from_delaying_a_fast_one(self):
        # The slow module runs during 9 of 20 rows of the fast table. A stall of the machine makes the table miss rows too, so one run
        # without a stall is enough.
        together = [self.missed("80") for _ in range(2)]
        apart = [self.missed("auto")]
        while apart[-1] >= 0.1 and len(apart) < 6:
            apart.append(self.missed("auto"))
        print("rows missed: %s with equal priorities, %s with priority=\"auto\"" % (
            " ".join("%.1f %%" % (100 * m) for m in together), " ".join("%.1f %%" % (100 * m) for m in apart)))
        self.assertGreater(min(together), 0.3)
        self.assertLess(min(apart), 0.1)

    def test_executor_threads_run_with_the_priorities_that_takt_check_prints(self):
        cell = self.cell("auto")
        run = self.start("run", cell)
        run.wait_for_state("m_fast", "EXECUTING")
        host = run.one("takt-host").pid
        priorities = {}
        for thread in os.listdir("/proc/%d/task" % host):
            try:
                with open("/proc/%d/task/%s/comm" % (host, thread), encoding="ascii") as name:
                    priorities[name.read().strip()] = os.sched_getparam(int(thread)).sched_priority
            except OSError:
                pass  # this thread only called a hook and has already ended
        self.assertEqual((80, 70), (priorities["fast"], priorities["slow"]))
        checked = self.takt("check", cell)
        self.assertRegex(checked.out, r"executor fast: cpu \d+, priority 80 \(auto\)")
        self.assertRegex(checked.out, r"executor slow: cpu \d+, priority 70 \(auto\)")


if __name__ == "__main__":
    takt_system.main()
