import os
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system

CPUS = sorted(os.sched_getaffinity(0))


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

    # Tests of the CPUs that executors request.

    def cell_on(self, cpu):
        return self.write("cpu.xml", """<cell name="c"><device name="d"><executor name="main" cpu="%d"/>
            <module><name>m</name><filename>grid.so</filename><moduletype>thread</moduletype><operationtype>periodic</operationtype>
            <period>1ms</period><priority>1</priority></module></device></cell>\n""" % cpu)

    def cpus_of(self, run, thread):
        """Returns the CPUs on which this thread of the host may run."""
        host = run.one("takt-host").pid
        for task in os.listdir("/proc/%d/task" % host):
            with open("/proc/%d/task/%s/comm" % (host, task), encoding="ascii") as name:
                if name.read().strip() == thread:
                    return os.sched_getaffinity(int(task))
        self.fail("the host has no thread " + thread)

    @unittest.skipUnless(len(CPUS) > 1 and shutil.which("taskset"), "needs two CPUs and taskset")
    def test_an_executor_gets_the_isolated_cpu_that_it_requests(self):
        """As with the kernel's option isolcpus=, the processes may use the last CPU, but get it only on request."""
        isolated = dict(before=["taskset", "-c", ",".join(map(str, CPUS[:-1]))])
        cell = self.cell_on(CPUS[-1])
        checked = self.takt("check", cell, **isolated)
        self.assertEqual((0, ""), (checked.status, checked.err))
        run = self.start("run", cell, **isolated)
        run.wait_for_state("m", "EXECUTING")
        self.assertEqual({CPUS[-1]}, self.cpus_of(run, "main"))
        self.assertLessEqual(self.cpus_of(run, "takt-hooks"), set(CPUS[:-1]), "no other thread uses the isolated CPU")
        self.assertNotIn("requests CPU", run.err)

    def cpuset(self, cpus):
        """Makes a cgroup that is limited to these CPUs. Returns a function that moves the calling process into it."""
        top = tempfile.mkdtemp(prefix="takt-cpuset-")  # not in the folder of the test, all of which is removed
        self.addCleanup(os.rmdir, top)
        if subprocess.run(["mount", "-t", "cgroup", "-o", "cpuset", "cpuset", top], capture_output=True).returncode != 0:
            self.skipTest("needs root, and the controller cpuset of cgroups of version 1")
        self.addCleanup(subprocess.run, ["umount", top], check=True)
        folder = os.path.join(top, "takt-test-%d" % os.getpid())
        os.mkdir(folder)
        self.addCleanup(os.rmdir, folder)
        with open(os.path.join(top, "cpuset.mems")) as mems:
            limits = {"cpuset.mems": mems.read(), "cpuset.cpus": ",".join(map(str, cpus))}
        for name, value in limits.items():
            with open(os.path.join(folder, name), "w") as file:
                file.write(value)

        def enter():
            with open(os.path.join(folder, "cgroup.procs"), "w") as file:
                file.write(str(os.getpid()))
        return enter

    @unittest.skipUnless(len(CPUS) > 1, "needs two CPUs")
    def test_takt_names_the_cpuset_limit_that_excludes_the_cpu_of_an_executor(self):
        limited = dict(become=self.cpuset(CPUS[:-1]))
        cell = self.cell_on(CPUS[-1])
        warning = r"executor main \(line 1\) requests CPU %d, which a cpuset limit \(.*\) excludes; Takt may use CPUs? [\d,-]+, " % CPUS[-1]
        self.assertRegex(self.takt("check", cell, **limited).err, warning)
        doctor = {finding["check"]: finding for finding in self.takt("doctor", "--json", **limited).report["findings"]}
        self.assertRegex(doctor["CPU limit"]["found"], "a cpuset limit .* excludes CPU %d$" % CPUS[-1])
        run = self.takt("run", cell, "--for", "0.2", **limited)
        self.assertEqual(0, run.status, run.err)
        self.assertRegex(run.err, "warning: " + warning)


if __name__ == "__main__":
    takt_system.main()
