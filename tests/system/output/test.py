import fcntl
import json
import os
import pty
import select
import signal
import sys
import termios

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import wait_until

CHATTY = """<cell name="chatty"><device name="bench">
  <module>
    <name>prints</name> <filename>prints.exe</filename> <moduletype>process</moduletype> <operationtype>periodic</operationtype>
    <period>2ms</period> <priority>1</priority> <property><value name="lines">1000000</value></property>
  </module>
</device></cell>
"""


class Output(takt_system.Case):
    def test_takt_run_prefixes_each_line_that_a_program_prints_with_the_module_name(self):
        run = self.takt("run", "cell.xml", "--for", "2", "--json")
        self.assertEqual(0, run.status, run.err)
        self.assertEqual("cell", run.report["cell"])
        self.assertEqual(1, len(run.out.splitlines()))
        self.assertEqual([], run.other_lines)
        for module, lines, letters in (("prints", 50, 5000), ("other", 3, 2000)):
            printed = run.printed(module)
            self.assertTrue(all(len(line) <= 2004 for line in printed))
            for side in ("out", "err"):
                own = [line for line in printed if line.startswith(side)]
                self.assertEqual([side + ": before it attaches"] + ["%s: line %d" % (side, i + 1) for i in range(lines)] +
                                 [side + ": a partial last line"], own)
            cut = [line for line in printed if line.startswith("x")]
            self.assertEqual(2 * letters, sum(line.count("x") for line in cut))
            pieces = ["x" * 2000 + " ..."] * ((letters - 1) // 2000) + ["x" * ((letters - 1) % 2000 + 1)]
            self.assertEqual(sorted(pieces * 2), sorted(cut))
        self.assertEqual(1, len(run.printed("brief")))
        self.assertRegex(run.printed("brief")[0], r"^released \d+ times$")

    def test_takt_run_quiet_prints_only_the_report(self):
        run = self.takt("run", "cell.xml", "--for", "0.2", "--quiet")
        self.assertEqual((0, ""), (run.status, run.err))
        self.assertIn("cell cell", run.out)
        for module in ("prints", "brief", "other"):
            self.assertRegex(run.out, r"(?m)^ +%s +DESTRUCT +\d+" % module)

    def test_takt_run_fails_if_it_cannot_write_the_report(self):
        run = self.takt("run", "cell.xml", "--for", "0.3", "--json", before=["/bin/sh", "-c", 'exec "$0" "$@" >/dev/full'])
        self.assertEqual(1, run.status)
        self.assertIn("brief: START -> DESTRUCT", run.err)
        self.assertEqual(["error: cannot write the report to standard output"], run.other_lines)
        run = self.takt("check", "cell.xml", before=["/bin/sh", "-c", 'exec "$0" "$@" >/dev/full'])
        self.assertEqual((1, "error: cannot write the report to standard output"), (run.status, run.err))

    def test_a_device_keeps_running_after_the_reader_of_its_log_has_exited(self):
        run = self.takt("run", "cell.xml", "--for", "0.5", "--json",
                        before=["/bin/sh", "-c", '"$0" "$@" 2>&1 >report | head -1'])
        self.assertEqual(1, len(run.out.splitlines()))
        device = json.loads(self.read("report"))["devices"][0]
        self.assertTrue(device["alive"])
        self.assertGreater(device["executors"][0]["cycles"] + device["executors"][0]["missed"], 200)
        self.assertEqual({"DESTRUCT"}, {m["state"] for m in device["modules"]})

    def assert_commands_work(self, error, block):
        """Runs a chatty program on a node with this standard error, which nothing reads after block()."""
        node = self.program("takt-node", "--device", "bench", error=error)
        self.assertEqual(0, self.takt("deploy", self.write("chatty.xml", CHATTY)).status)
        block()
        writable = select.poll()
        writable.register(error, select.POLLOUT)
        wait_until(lambda: not writable.poll(0), "standard error takes nothing")
        self.done("stop bench.prints")
        self.assertEqual({"prints": "START"}, self.states_of("bench"))
        self.done("undeploy chatty")
        node.signal(signal.SIGTERM)
        self.assertEqual(0, node.wait().status)

    def test_a_node_carries_out_commands_while_nothing_reads_its_output(self):
        reader, writer = os.pipe()
        self.addCleanup(os.close, reader)
        self.addCleanup(os.close, writer)
        fcntl.fcntl(writer, fcntl.F_SETPIPE_SZ, 4096)
        self.assert_commands_work(writer, lambda: None)

    def test_a_node_carries_out_commands_while_ctrl_s_stops_its_terminal(self):
        master, slave = pty.openpty()
        self.addCleanup(os.close, master)
        self.addCleanup(os.close, slave)
        self.assert_commands_work(slave, lambda: termios.tcflow(slave, termios.TCOOFF))


if __name__ == "__main__":
    takt_system.main()
