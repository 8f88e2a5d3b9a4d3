import os
import re
import signal
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import LIFE, wait_until

SEEDS = [int(seed) for seed in os.environ.get("TAKT_SCRIBBLES", "1 2 3 4").split()]


PROGRAMS = """<cell name="zeroed">
  <device name="d">
    <module>
      <name>zeroes</name> <filename>zeroes.exe</filename>
      <moduletype>process</moduletype> <operationtype>periodic</operationtype>
      <period>%(period)d</period> <priority>1</priority>
      <recovery attempts="1" backoff="10000000"/>
      <property><value name="after">%(after)d</value></property>
    </module>
    <module>
      <name>neighbour</name> <filename>grid.exe</filename>
      <moduletype>process</moduletype> <operationtype>periodic</operationtype>
      <period>4000000</period> <priority>2</priority>
    </module>
    <module>
      <name>grid</name> <filename>grid.so</filename>
      <moduletype>thread</moduletype> <operationtype>periodic</operationtype>
      <period>4000000</period> <priority>3</priority>
    </module>
  </device>
</cell>"""


class Zeroes(takt_system.Case):
    """A program fills all shared memory that it can write to with zeros."""

    def run_with(self, **values):
        run = self.start("run", self.write("cell.xml", PROGRAMS % values), "--json")
        run.wait_for_line(r"zeroes: \| filled with zeros")
        return run

    def cycles_of(self, module):
        return next(m["cycles"] for m in self.status_of("d")["modules"] if m["name"] == module)

    def test_a_program_that_fills_its_shared_memory_with_zeros_goes_to_recover_and_other_modules_continue(self):
        run = self.run_with(period=4000000, after=100)
        filled = time.monotonic()
        before = self.cycles_of("neighbour")
        wait_until(lambda: self.cycles_of("neighbour") > before + 50, "the neighbour to run while the other program stands still")
        run.wait_for_state("zeroes", "RECOVER")
        print("the program was an error %.2f s after it had filled its memory" % (time.monotonic() - filled))
        self.assertRegex(run.steps("zeroes")[3].text, r"^hang: the process took no release for 1\.04 s and was killed")
        run.wait_for_line(r"\.zeroes: RECOVER -> EXECUTING")
        for order in ("stop", "start"):
            self.done("%s d.neighbour" % order)
        run.wait_for_state("zeroes", "DESTRUCT")
        run.signal(signal.SIGINT)
        run.wait()
        self.assertEqual(1, run.status, run.err)
        self.assertEqual(LIFE, run.states("grid"))
        neighbour, rows = run.modules("d")["neighbour"], run.executor("main", "d")["cycles"]
        self.assertGreater(neighbour["cycles"], rows / 2)
        said = next(line for line in run.printed("neighbour") if line.startswith("grid "))
        self.assertEqual("0", said.split()[3], "its releases must stay on the grid")

    def test_takt_stop_works_after_a_program_has_filled_its_shared_memory_with_zeros(self):
        # With this period, Takt notices only after 11 s that the program takes no releases.
        run = self.run_with(period=1000000000, after=2)
        self.done("stop d.zeroes", "stop d.neighbour")
        self.assertEqual({"zeroes": "START", "neighbour": "START", "grid": "EXECUTING"}, self.states_of("d"))
        run.signal(signal.SIGINT)
        run.wait()
        self.assertEqual(0, run.status, run.err)


class Scribbles(takt_system.Case):
    def test_a_node_survives_a_module_that_writes_random_words_to_shared_memory(self):
        with open(self.beside("cell.xml")) as file:
            cell = file.read()
        nodes = self.nodes("hurt", "whole")
        for seed in SEEDS:
            text = cell.replace('"seed">1<', '"seed">%d<' % seed)
            before = len(nodes["whole"].lines)
            self.deploy(self.write("cell.xml", text))
            # The module begins to write random words after 0.2 s. Meanwhile, the test uses the node as operators and observers do.
            for _ in range(4):
                time.sleep(0.4)
                status = self.status_of()
                self.assertEqual({"hurt", "whole"}, {d["name"] for d in status["devices"]})
                self.takt("log", "hurt", "--json")
                self.takt("trace", "hurt", "--last", "1", "-o", "hurt.json")
            for device, node in nodes.items():
                self.assertIsNone(node.status, "seed %d: the node of %s has ended:\n%s" % (seed, device, node.err))
            self.assertEqual({"EXECUTING"}, set(self.states_of("whole").values()), "seed %d" % seed)
            self.takt("undeploy", "scribbled")
            wait_until(lambda: not any(d["modules"] for d in self.status_of()["devices"]),
                       "both nodes to be free again after seed %d" % seed)
            new = nodes["whole"].lines[before:]
            self.assertEqual([], [line.text for line in new if re.match(r"\w+ -> RECOVER", line.text)], "seed %d" % seed)
        self.end(nodes)


if __name__ == "__main__":
    takt_system.main()
