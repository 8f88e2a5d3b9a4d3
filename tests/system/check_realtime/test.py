import os
import re
import signal
import sys
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system

# The violations that each function in components/sins.h must cause.
SINS = {
    "allocate": {("allocation", "malloc"), ("allocation", "free")},
    "lock": {("lock", "pthread_mutex_lock")},
    "sleep": {("system call", "clock_nanosleep")},
    "print": {("system call", "write")},
    "fault": {("page fault", "")},
    "call": {("system call", "getppid")},
}
# Further violations that may occur: when a program prints for the first time, the C library allocates a buffer.
BESIDE = {"print": {("allocation", "malloc"), ("system call", "newfstatat"), ("system call", "fstat")}}


def module(name, filename, operation="periodic", **properties):
    values = "".join('<value name="%s">%s</value>' % pair for pair in properties.items())
    time = "<period>2000000</period>" if operation == "periodic" else "<deadline>4000000</deadline>"
    return """<module><name>%s</name><filename>%s</filename><moduletype>%s</moduletype><operationtype>%s</operationtype>
%s<priority>1</priority><property>%s</property></module>""" % (
        name, filename, "process" if filename.endswith(".exe") else "thread", operation, time, values)


class CheckRealtime(takt_system.Case):
    def run_these(self, *modules, options=("--check-realtime",)):
        """Runs these modules until all of them are EXECUTING."""
        cell = self.write("cell.xml", '<cell name="sins"><device name="d">%s</device></cell>' % "".join(modules))
        run = self.start("run", cell, "--json", *options)
        for name in re.findall("<name>(.*?)</name>", "".join(modules)):
            run.wait_for_state(name, "EXECUTING")
        run.signal(signal.SIGINT)
        return run.wait()

    def found(self, run, name):
        return [v for v in run.device()["realtime_violations"] if v["module"] == name]

    def assert_named(self, run, name, hook, sin):
        """Checks that all violations of `sin` were found in the hook `hook` of the module, and that their backtraces name the function.
        Returns these violations."""
        here = [v for v in self.found(run, name) if any(re.match(r"sin_%s(\(\))? at sins\.h:" % sin, call) for call in v["backtrace"])]
        kinds = {(v["kind"], v["what"]) for v in here}
        self.assertLessEqual(SINS[sin], kinds, run.err)
        self.assertLessEqual(kinds, SINS[sin] | BESIDE.get(sin, set()))
        for violation in here:
            self.assertEqual(hook, violation["hook"])
            self.assertGreaterEqual(violation["count"], 1)
            self.assertNotIn("takt-host", "".join(violation["backtrace"]))
        return here

    def test_the_realtime_check_reports_each_kind_of_violation_in_a_cpp_component(self):
        run = self.run_these(*[module("m_" + sin, "sins.so", sin=sin) for sin in SINS], module("clean", "sins.so"),
                             *[module("m_" + sin, "sins.so", sin=sin) for sin in ("new", "text")])
        self.assertEqual(1, run.status, run.err)
        for sin in SINS:
            name = "m_" + sin
            here = self.assert_named(run, name, "run()", sin)
            self.assertEqual(len(here), len(self.found(run, name)), "other violations: %s" % self.found(run, name))
            # A violation occurs in each cycle, or in only one cycle if only the first call of a function causes it.
            cycles = run.modules()[name]["cycles"]
            for kind, what in SINS[sin]:
                counts = [v["count"] for v in here if (v["kind"], v["what"]) == (kind, what)]
                self.assertTrue(any(count in (cycles, 64) for count in counts) or kind == "page fault", (sin, counts, cycles))
            self.assertTrue([line for line in run.said(name) if line.text.startswith("WARNING: run() is not real-time: ")], name)
            self.assertRegex("\n".join(run.other_lines), r"(?m)^module d\.%s: error: is not real-time: \d+ violations" % name)
        self.assertEqual([], self.found(run, "clean"))
        # The compiler inlines these functions from headers of the C++ library, and free() is the last call of run(). The backtraces must
        # nevertheless name the line in run().
        for name in ("m_new", "m_text"):
            self.assertEqual({"malloc", "free"}, {v["what"] for v in self.found(run, name)})
            for violation in self.found(run, name):
                self.assertRegex("\n".join(violation["backtrace"]), r"(?m)^Sins::run\(.*\) at sins\.cpp:\d+ in sins\.so$")
        self.assertEqual([], self.found(run, ""), "violations of the executor itself")

    def test_the_realtime_check_reports_violations_in_c_modules_and_programs(self):
        run = self.run_these(module("library", "sins_c.so"), module("copy", "sins_c.so"), module("program", "sins_c.exe"))
        self.assertEqual(1, run.status, run.err)
        for name in ("library", "copy", "program"):
            for sin in SINS:
                self.assert_named(run, name, "run()", sin)
        self.assertEqual({m["state"] for m in run.modules().values()}, {"DESTRUCT"})
        self.assertIn("something", run.printed("program"), "the checked call must still be made")

    def test_the_realtime_check_covers_the_condition_hook_of_a_sporadic_module(self):
        run = self.run_these(module("s", "sins.so", "sporadic", sin="allocate", in_condition="true"))
        self.assertEqual(1, run.status, run.err)
        self.assert_named(run, "s", "condition()", "allocate")
        self.assertEqual({"condition()"}, {v["hook"] for v in self.found(run, "s")})

    def test_the_text_report_shows_the_backtrace_of_a_violation(self):
        cell = self.write("cell.xml", '<cell name="sins"><device name="d">%s</device></cell>' % module("m", "sins.so", sin="sleep"))
        run = self.takt("run", cell, "--check-realtime", "--for", "1")
        self.assertEqual(1, run.status, run.err)
        self.assertRegex(run.out, r"real-time violations:\n  d\.m run\(\): system call clock_nanosleep, \d+ times\n(      .*\n)*"
                                  r"      sin_sleep\(\) at sins\.h:\d+ in sins\.so\n")

    @takt_system.timing("each module has to run within the two seconds of the run")
    def test_the_realtime_check_finds_no_violations_in_ready_made_components(self):
        for descriptor in ("module.xml", "palletizing.xml"):
            run = self.takt("run", os.path.join(takt_system.SOURCE, "deploy", descriptor), "--for", "2", "--json", "--check-realtime")
            for device in run.report["devices"]:
                self.assertEqual([], device["realtime_violations"], descriptor)
            self.assertEqual(0, run.status, run.err)

    def test_the_realtime_check_finds_no_violations_in_log_calls(self):
        run = self.run_these(module("cpp", "logs.so", every=1), module("c", "logs_c.so"), module("program", "logs_c.exe"))
        self.assertEqual(0, run.status, run.err)
        self.assertEqual([], run.device()["realtime_violations"])

    def test_the_realtime_check_does_not_blame_a_module_for_the_system_calls_of_the_crash_handler(self):
        cell = self.write("cell.xml", '<cell name="sins"><device name="d">%s</device></cell>' %
                          (module("m", "segv.so", after=1).replace("<property>", '<recovery attempts="1" backoff="0"/><property>') +
                           module("allocates", "sins.so", sin="allocate")))
        run = self.start("run", cell, "--json", "--check-realtime")
        run.wait_for_state("m", "DESTRUCT")
        run.wait_for_line(r"\.allocates: WARNING: run\(\) is not real-time: ")
        run.signal(signal.SIGINT)
        run.wait()
        self.assertRegex(run.err, r"m: .*SIGSEGV")
        self.assertEqual([], [v for v in self.found(run, "m") if v["kind"] == "system call"])
        self.assertTrue(self.found(run, "allocates"), "other violations are still reported")

    def test_a_run_without_the_realtime_check_reports_no_violations(self):
        run = self.run_these(module("m", "sins.so", sin="allocate"), options=())
        self.assertEqual(0, run.status, run.err)
        self.assertNotIn("realtime_violations", run.device())
        self.assertNotIn("not real-time: ", run.err.replace("WARNING: not real-time: ", ""))

    @unittest.skipUnless(os.path.isdir("/proc/self/fd"), "no /proc")
    def test_a_host_without_the_realtime_check_does_not_load_the_library_of_the_check(self):
        for options, loaded in (((), False), (("--check-realtime",), True)):
            cell = self.write("cell.xml", '<cell name="sins"><device name="d">%s</device></cell>' % module("m", "sins.so"))
            run = self.start("run", cell, *options)
            run.wait_for_state("m", "EXECUTING")
            with open("/proc/%d/maps" % run.one("takt-host").pid) as maps:
                self.assertEqual(loaded, "libtakt_check.so" in maps.read())
            run.signal(signal.SIGINT)
            self.assertEqual(0, run.wait().status, run.err)


if __name__ == "__main__":
    takt_system.main()
