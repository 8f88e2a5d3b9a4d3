import fcntl
import json
import os
import pty
import select
import signal
import stat
import subprocess
import sys
import termios
import unittest

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
SOURCE = """<cell name="sampled"><device name="bench">
  <module>
    <name>source</name> <filename>port_source.so</filename> <moduletype>thread</moduletype> <operationtype>periodic</operationtype>
    <period>2ms</period> <priority>1</priority>
  </module>
</device></cell>
"""
# All commands that write a file which the user names, but takt bench, which measures first.
WRITERS = ("check cell.xml --svg FILE", "graph cell.xml --svg FILE", "simulate cell.xml --for 0.1 --trace FILE",
           "run cell.xml --for 0.1 --quiet --profile FILE", "plot samples.takt bench.source.out.number --csv FILE",
           "plot samples.takt bench.source.out.number --svg FILE", "trace short.json -o FILE", "trace short.json --svg FILE")


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
        self.assertEqual(["error: cannot write the output: No space left on device"], run.other_lines)

    def test_a_command_fails_if_it_cannot_write_its_output(self):
        without_reader = ("import os, signal, sys; signal.signal(signal.SIGPIPE, signal.%s); r, w = os.pipe(); os.close(r); os.dup2(w, 1); "
                          "os.execv(sys.argv[1], sys.argv[1:])")
        for number, command in enumerate(("takt --help", "takt --version", "takt help check", "takt check --help", "takt secure --help",
                                          "takt-node --help", "takt-node --version", "takt check cell.xml", "takt check cell.xml --json",
                                          "takt graph cell.xml", "takt describe prints.exe", "takt new fresh FOLDER", "takt doctor",
                                          "takt secure init cell.xml FOLDER")):
            for way, before, status, said in (
                    ("full", ["/bin/sh", "-c", 'exec "$0" "$@" >/dev/full'], 1, "error: cannot write the output: No space left on device"),
                    ("closed", [sys.executable, "-c", without_reader % "SIG_IGN"], 141, ""),
                    ("killed", [sys.executable, "-c", without_reader % "SIG_DFL"], -signal.SIGPIPE, "")):
                with self.subTest(command=command, way=way):
                    program, *arguments = command.replace("FOLDER", "%s%d" % (way, number)).split()
                    arguments = [self.beside(a) if a.endswith(".xml") else a for a in arguments]
                    run = self.program(program, *arguments, before=before).wait()
                    self.assertEqual((status, said), (run.status, run.err))

    def test_a_device_keeps_running_after_the_reader_of_its_log_has_exited(self):
        run = self.takt("run", "cell.xml", "--for", "0.5", "--json",
                        before=["/bin/sh", "-c", '"$0" "$@" 2>&1 >report | head -1'])
        self.assertEqual(1, len(run.out.splitlines()))
        device = json.loads(self.read("report"))["devices"][0]
        self.assertTrue(device["alive"])
        self.assertGreater(device["executors"][0]["cycles"] + device["executors"][0]["missed"], 200)
        self.assertEqual({"DESTRUCT"}, {m["state"] for m in device["modules"]})

    def sampled(self):
        """Writes the recording samples.takt and the trace short.json of a running cell."""
        node = self.node("bench")
        self.deploy(self.write("source.xml", SOURCE))
        self.done("record --out samples.takt bench.source.out --for 0.5", "trace bench -o short.json")
        self.done("undeploy sampled")
        self.end({"bench": node})

    def write_file(self, command, path):
        """Runs a command of WRITERS with this path as FILE. Returns its exit status and its last error line."""
        run = self.takt(*command.replace("FILE", path).split())
        return run.status, run.err.rstrip("\n").split("\n")[-1]

    def test_commands_write_into_the_device_pipe_or_link_target_that_the_user_names(self):
        self.sampled()
        path = lambda name: os.path.join(self.folder, name)
        for command in WRITERS:
            with self.subTest(command=command):
                os.mkfifo(path("pipe"))
                with open(path("got"), "wb") as got:
                    reader = subprocess.Popen(["cat", path("pipe")], stdout=got)
                self.addCleanup(reader.kill)
                self.assertEqual(0, self.write_file(command, "pipe")[0])
                self.assertTrue(stat.S_ISFIFO(os.lstat(path("pipe")).st_mode))
                self.assertEqual(0, reader.wait(takt_system.LONG))
                self.assertGreater(os.path.getsize(path("got")), 100)
                for target in ("old", "new"):
                    if target == "old":
                        self.write("old", "before")
                    os.symlink(target, path("link"))
                    self.assertEqual(0, self.write_file(command, "link")[0])
                    self.assertEqual(target, os.readlink(path("link")))
                    self.assertGreater(os.path.getsize(path(target)), 100)
                    os.remove(path("link"))
                    os.remove(path(target))
                os.remove(path("pipe"))

    @unittest.skipUnless(os.getuid() == 0, "only root can make devices")
    def test_commands_write_into_a_device_and_report_that_it_is_full(self):
        self.sampled()
        path = lambda name: os.path.join(self.folder, name)
        # Not those of /dev, so that the test cannot harm the machine.
        for name, number in (("null", 3), ("full", 7)):
            os.mknod(path(name), 0o666 | stat.S_IFCHR, os.makedev(1, number))
        before = sorted(os.listdir(self.folder))
        for command in WRITERS:
            with self.subTest(command=command):
                self.assertEqual(0, self.write_file(command, "null")[0])
                self.assertEqual((1, "full: error: was not written completely; check whether the disk is full"),
                                 self.write_file(command, "full"))
        for options in ((), ("--append",)):
            run = self.takt("record", "--out", "null", "bench.source.out", "--for", "1", *options)
            self.assertEqual((1, "null: error: is not a regular file; record into another file"), (run.status, run.err.rstrip()))
        for name in ("null", "full"):
            self.assertTrue(stat.S_ISCHR(os.lstat(path(name)).st_mode))
        self.assertEqual(before, sorted(os.listdir(self.folder)))

    def test_an_output_file_named_dev_stdout_continues_standard_output(self):
        # With a /dev of its own, so that the test cannot harm the machine.
        own = ("unshare", "-m", "sh", "-c", "mount -t tmpfs tmpfs /dev && mknod -m 666 /dev/null c 1 3 && ln -s /proc/self/fd /dev/fd && "
               'ln -s /proc/self/fd/1 /dev/stdout && %s')
        for command in ("check cell.xml --svg FILE", "graph cell.xml --svg FILE", "simulate cell.xml --for 0.1 --trace FILE"):
            for name in ("/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"):
                with self.subTest(command=command, name=name):
                    words = command.replace("FILE", name).split()
                    piped = self.takt(*words, before=[*own[:-1], own[-1] % 'exec "$0" "$@"'])
                    self.assertEqual(0, piped.status, piped.err)
                    to_file = self.takt(*words, before=[*own[:-1], own[-1] % 'exec "$0" "$@" >out'])
                    self.assertEqual(0, to_file.status, to_file.err)
                    self.assertEqual(piped.out.rstrip("\n"), self.read("out").rstrip("\n"))

    def test_takt_record_leaves_a_link_to_a_recording_without_samples(self):
        os.symlink("target.takt", os.path.join(self.folder, "link.takt"))
        run = self.takt("record", "--out", "link.takt", "bench.source.out", "--for", "0.5")
        self.assertEqual(1, run.status, run.err)
        self.assertEqual("target.takt", os.readlink(os.path.join(self.folder, "link.takt")))
        self.assertFalse(os.path.exists(os.path.join(self.folder, "target.takt")))

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
