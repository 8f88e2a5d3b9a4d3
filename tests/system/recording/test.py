import csv
import json
import os
import random
import re
import signal
import sqlite3
import sys
import time
import xml.etree.ElementTree

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import wait_until


class Recording(takt_system.Case):
    def path(self, name):
        return os.path.join(self.folder, name)

    def rows(self, sql, file="a.takt"):
        database = sqlite3.connect("file:%s?mode=ro" % self.path(file), uri=True)
        try:
            return database.execute(sql).fetchall()
        finally:
            database.close()

    def count(self, file="a.takt"):
        """Returns the number of samples in the file, or 0 if the file has no table yet."""
        try:
            return self.rows("select count(*) from sample", file)[0][0]
        except sqlite3.OperationalError:
            return 0

    def numbers(self, file="a.takt"):
        """Returns the numbers that the source wrote, in the order in which they are in the file. In each sample, the number comes after the
        CDR header."""
        return [int.from_bytes(data[4:12], "little") for (data,) in self.rows("select bytes from sample order by id", file)]

    def not_in_file(self):
        """Returns how many of the numbers that the source wrote between the first and the last sample of the file are not in it."""
        numbers = self.numbers()
        return numbers[-1] - numbers[0] + 1 - len(numbers)

    def assert_each_gap_is_counted(self):
        """Checks that the file counts each missing sample at the sample that follows it."""
        numbers = self.numbers()
        missing = [missing for (missing,) in self.rows("select missing from sample order by id")]
        wrong = [(before, number, counted) for before, number, counted in zip(numbers, numbers[1:], missing[1:])
                 if number - before - 1 != counted]
        self.assertEqual([], wrong[:10], "each entry: the numbers of two samples in a row, and how many samples the file says are missing")

    def arrived(self):
        """Returns how many samples have arrived at the port in the cell of sink.xml."""
        return next(p["samples"] for m in self.status_of("s")["modules"] for p in m["ports"] if p["name"] == "in")

    def record(self, seconds, cell, *options, file="a.takt"):
        """Starts the recorder, then the cell, and waits for the end of the recording."""
        recorder = self.start("record", "d.source.out", "--out", file, "--for", str(seconds), *options)
        recorder.wait_for_line("waits for d.source.out: device d not found")
        run = self.start("run", cell, "--json")
        recorder.wait(limit=2 * takt_system.LONG)
        run.signal(signal.SIGINT)
        self.assertEqual(0, run.wait().status, run.err)
        self.missed = run.executor("main", "d")["missed"]
        return recorder

    def test_recorded_samples_are_unchanged_when_they_are_played_back(self):
        recorder = self.record(6, "source.xml")
        self.assertEqual(0, recorder.status, recorder.err)
        self.assertRegex(recorder.err, r"records d\.source\.out \(samples::Count\)")
        self.assertGreaterEqual(float(re.search(r"takt record: \d+ samples of 1 port in (\d+\.\d) s", recorder.err)[1]), 6)

        # Check the content of the file.
        self.assertEqual(["a.takt"], [f for f in os.listdir(self.folder) if f.startswith("a.takt")])
        self.assertEqual([("source",)], self.rows("select value from meta where name = 'cell'"))
        self.assertEqual([("d.source.out", "takt/source/d/source/out", "samples::Count")],
                         self.rows("select path, topic, type_name from port"))
        numbers = self.numbers()
        self.assertGreater(len(numbers), 50)
        self.assertEqual(sorted(set(numbers)), numbers, "samples must be in order, and none twice")
        self.assert_each_gap_is_counted()
        times = [t for (t,) in self.rows("select time_ns from sample order by id")]
        self.assertLess(abs(times[-1] / 1e9 - time.time()), 60)
        # The recording must have the time stamps of the module. The module sends one sample per period, except in periods that the executor
        # missed.
        for (a, at), (b, bt) in zip(list(zip(numbers, times)), list(zip(numbers, times))[1:]):
            self.assertAlmostEqual((b - a) * 0.01, (bt - at) / 1e9, delta=0.5 + self.missed * 0.01)

        # Check that takt plot writes the same samples into a CSV table.
        run = self.takt("plot", "a.takt", "d.source.out", "--csv", "a.csv", "--svg", "a.svg")
        self.assertEqual(0, run.status, run.err)
        with open(self.path("a.csv"), newline="") as file:
            table = list(csv.DictReader(file))
        self.assertEqual(numbers, [int(row["d.source.out.number"]) for row in table])
        self.assertEqual(times, [int(row["time_ns"]) for row in table])
        for row in table:
            self.assertEqual(float(row["d.source.out.number"]), float(row["d.source.out.same[5]"]))
            few = [row["d.source.out.few[%d]" % i] for i in range(4)]
            self.assertEqual(int(row["d.source.out.number"]) % 5, sum(text != "" for text in few))
        self.assertIn("svg", xml.etree.ElementTree.parse(self.path("a.svg")).getroot().tag)
        with open(self.path("a.svg")) as file:
            self.assertIn(">same (mm)<", file.read())
        run = self.takt("plot", "a.takt", "d.source.out.same[5]", "d.source.out.number")
        self.assertRegex(run.out, r"d\.source\.out\.same\[5\] .* mm +\d+\n")
        self.assertRegex(run.out, r"d\.source\.out\.number +%d +%d +%d +\S+ +%d " % (len(numbers), self.not_in_file(), numbers[0], numbers[-1]))
        listed = self.takt("play", "a.takt", "--list")
        self.assertRegex(listed.out, r"d\.source\.out +samples::Count +%d +%d +0\.000" % (len(numbers), self.not_in_file()))

        # Play the whole recording into another cell, then play a part of it.
        for options, expected in ([], numbers), (["--from", "0.5", "--to", "1.5", "--speed", "2"],
                                                [n for n, t in zip(numbers, times) if 5e8 <= t - times[0] <= 15e8]):
            sink = self.start("run", "sink.xml")
            sink.wait_for_state("sink", "EXECUTING")
            began = time.monotonic()
            play = self.takt("play", "a.takt", "--port", "d.source.out=replay/out", *options)
            took = time.monotonic() - began
            self.assertEqual(0, play.status, play.err)
            self.assertNotIn("has no reader", play.err)
            self.assertRegex(play.err, r"takt play: %d samples of 1 port" % len(expected))
            if not options:
                self.assertGreater(took, (times[-1] - times[0]) / 1e9)
            wait_until(lambda: self.arrived() >= len(expected), "%d samples at the sink" % len(expected))
            time.sleep(0.5)  # in this time, the sink would read duplicates if there were any
            sink.signal(signal.SIGINT)
            sink.wait()
            seen = json.loads(self.read("seen"))
            self.assertEqual((len(expected), expected[0], expected[-1], 0),
                             (seen["read"], seen["first"], seen["last"], seen["wrong"]))

        # takt play must not write to the topic of a running module.
        run = self.start("run", "source.xml")
        run.wait_for_state("source", "EXECUTING")
        self.refused({"play a.takt": r"port d\.source\.out: error: is written by d\.source, which is running; .*--port d\.source\.out=TOPIC"})
        run.signal(signal.SIGINT)
        run.wait()

    def test_samples_that_a_paused_recorder_loses_are_counted_and_drawn_as_a_gap(self):
        run = self.start("run", "fast.xml")
        run.wait_for_state("source", "EXECUTING")
        recorder = self.start("record", "d.source.out", "--out", "a.takt", "--flush", "0.05")
        wait_until(lambda: self.count() > 100, "samples in the file")

        def written():
            return next(p["samples"] for m in self.status_of("d")["modules"] for p in m["ports"] if p["name"] == "out")

        recorder.signal(signal.SIGSTOP)
        # The device drops a silent recorder after 3 s. It publishes the port for 30 s after the recorder's last request.
        enough = written() + 10000
        wait_until(lambda: written() > enough, "samples while the recorder is paused")
        recorder.signal(signal.SIGCONT)
        wait_until(lambda: self.numbers()[-1] > enough, "a sample from after the pause in the file")
        recorder.signal(signal.SIGINT)
        self.assertEqual(0, recorder.wait().status, recorder.err)
        self.assert_each_gap_is_counted()
        numbers, missing = self.numbers(), self.not_in_file()
        self.assertGreater(max(after - before for before, after in zip(numbers, numbers[1:])), 1000, "the pause must be one long gap")
        self.assertGreaterEqual(int(re.search(r"in a\.takt; (\d+) lost", recorder.err)[1]), missing)
        self.assertRegex(self.takt("play", "a.takt", "--list").out, r"d\.source\.out +samples::Count +%d +%d " % (len(numbers), missing))
        self.assertRegex(self.takt("plot", "a.takt", "d.source.out.number").out, r"number +%d +%d +.* [1-9]\d*\n" % (len(numbers), missing))

    def test_samples_that_a_device_could_not_send_are_counted_as_missing(self):
        run = self.start("run", "two.xml")
        run.wait_for_state("sink", "EXECUTING")
        recorder = self.start("record", "d.source.out", "--out", "a.takt", "--flush", "0.05")
        wait_until(lambda: self.count() > 100, "samples in the file")
        node = next(process for process in run.processes("takt-node") if "d" in process.arguments)

        def is_missing():
            node.kill(signal.SIGSTOP)
            time.sleep(0.05)
            node.kill(signal.SIGCONT)
            return self.not_in_file() > 0
        wait_until(is_missing, "a sample that the paused node overwrites")
        recorder.signal(signal.SIGINT)
        self.assertEqual(0, recorder.wait().status, recorder.err)
        self.assert_each_gap_is_counted()

    def test_a_recorder_restarted_after_a_kill_appends_to_its_file(self):
        run = self.start("run", "component.xml")
        run.wait_for_state("source", "EXECUTING")
        wait_until(lambda: self.count() > 50, "samples in the file")
        begun = len(run.raw)
        os.kill(run.one("recorder.exe").pid, signal.SIGKILL)
        run.wait_for_line(r"\.recorder: \w+ -> RECOVER", after=begun)
        before = self.count()
        listed = self.takt("play", "a.takt", "--list")
        self.assertEqual(0, listed.status, listed.err)
        self.assertIn("d.source.out", listed.out)
        run.wait_for_line(r"recorder: records d\.source\.out", after=begun)
        wait_until(lambda: self.count() > before + 50, "more samples in the file")
        run.signal(signal.SIGINT)
        run.wait()
        self.assertRegex("\n".join(run.printed("recorder")), r"recorder: \d+ samples of 1 port .* in a\.takt; \d+ lost")
        numbers = self.numbers()
        self.assertEqual(sorted(set(numbers)), numbers)
        self.assertEqual(1, len(self.rows("select * from port")))

    def test_a_recording_never_exceeds_its_maximum_size(self):
        stopped = self.record(60, "fast.xml", "--max-size", "1")
        self.assertEqual(0, stopped.status, stopped.err)
        self.assertRegex(stopped.err, r"a\.takt has reached its limit of 1\.0 MB; the recording has ended")
        self.assertLessEqual(os.path.getsize(self.path("a.takt")), 1000000)
        self.assertGreater(os.path.getsize(self.path("a.takt")), 500000)

        dropped = self.record(15, "fast.xml", "--max-size", "1", "--full", "oldest", file="b.takt")
        self.assertEqual(0, dropped.status, dropped.err)
        self.assertRegex(dropped.err, r"lost, \d+ oldest samples dropped")
        self.assertLessEqual(os.path.getsize(self.path("b.takt")), 1000000)
        self.assertGreater(self.numbers("b.takt")[0], 1000)

    def test_takt_record_play_and_plot_reject_invalid_arguments_and_files(self):
        self.write("text.takt", "This is a text of more than a few words, and no recording whatever it is called.\n" * 50)
        self.refused({
            "record d --out x.takt": r"'d' is not a port name; write DEVICE\.MODULE\.PORT",
            "record d.m.p --out no/x.takt": r"no/x\.takt: error: cannot be written: the folder no does not exist; create it",
            "record d.m.p --out text.takt": r"text\.takt: error: exists already",
            "record d.m.p --out text.takt --append": r"text\.takt: error: is not a recording",
            "record d.m.p --out y.takt --max-size 0.5": r"use at least 1 MB",
            "play none.takt": r"none\.takt: error: does not exist",
            "play text.takt": r"text\.takt: error: is not a recording",
            "plot text.takt d.m.p.x": r"text\.takt: error: is not a recording",
        })
        usage = self.at_once("record --out x.takt", "record d.m.p", "play a --speed 0", "plot a", "record d.m.p --out x --full no")
        self.assertEqual([2] * len(usage), [run.status for run in usage])
        nobody = self.takt("record", "d.m.p", "--out", "z.takt", "--for", "1")
        self.assertEqual(1, nobody.status)
        self.assertRegex(nobody.err, r"waits for d\.m\.p: device d not found\n.*0 samples of 0 ports")
        nobody = self.takt("record", "d.*", "--out", "z.takt", "--for", "1.5")
        self.assertRegex(nobody.err, r"waits for an output port that matches 'd\.\*'; no device was found\n.*0 samples of 0 ports")
        self.assertFalse(os.path.exists(self.path("z.takt")), "no file may be left, which would block the next attempt")

        run = self.takt("run", "wrong.xml", "--for", "2")
        self.assertRegex(run.err, r"\| property max_size: error: cannot be 'much'; write a number from 0 to")
        self.assertRegex(run.err, r"\| error: unknown property 'fiel'; did you mean file\?")
        self.assertRegex(run.err, r"\| property file: error: is missing")

    def test_takt_play_and_plot_reject_unknown_ports_and_damaged_files(self):
        self.assertEqual(0, self.record(8, "source.xml").status)
        self.refused({
            "plot a.takt d.source.uot.number": r"has no port 'd\.source\.uot'; did you mean d\.source\.out\?",
            "plot a.takt d.source.out.numbr": r"port d\.source\.out has no field 'numbr'; did you mean number\?",
            "plot a.takt d.source.out --from 1000": r"has no samples between --from and --to",
            "play a.takt --from 1000": r"has no samples between --from and --to",
            "plot a.takt d.source.out --svg no/a.svg": r"no/a\.svg: error: cannot be written",
            "play a.takt --port d.source.uot": r"has no port 'd\.source\.uot'",
            "play a.takt --port d.source.out=": r"has no topic after '='",
            "play a.takt --from 2 --to 1": r"--from is after --to",
        })
        size = os.path.getsize(self.path("a.takt"))
        with open(self.path("a.takt"), "r+b") as file:
            file.seek(size // 2)
            file.write(random.Random(1).randbytes(size // 2))
        self.refused({"plot a.takt d.source.out.number": r"a\.takt: error: is damaged"})


if __name__ == "__main__":
    takt_system.main()
