"""A cell whose samples go to, and come from, another DDS domain, where a cell of its own answers them."""
import json
import os
import signal
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import wait_until


class Domains(takt_system.Case):
    def setUp(self):
        super().setUp()
        self.other = takt_system.free_domain()
        with open(self.beside("far.xml")) as file:
            self.cell = self.write("far.xml", file.read().replace("OTHER", str(self.other)))

    def port(self, module, port):
        modules = {m["name"]: m for m in self.status_of("far")["modules"]}
        return next(p for p in modules[module]["ports"] if p["name"] == port)

    def gateway(self, run):
        """The program that the node of this run has for the other domain."""
        found = [p for p in run.processes("takt-node") if not p.arguments]
        return found[0] if found else None

    def test_samples_cross_both_ways_and_a_killed_gateway_comes_back(self):
        far = self.start("run", self.cell, "--json")
        far.wait_for_state("sink", "EXECUTING")
        self.assertEqual(0, self.port("source", "out")["matched"], "nobody is there yet")
        near = self.start("run", "near.xml", "--json", environment={"TAKT_DOMAIN": str(self.other)})
        near.wait_for_state("relay", "EXECUTING")
        port = wait_until(lambda: (lambda p: p if p["samples"] > 100 else None)(self.port("sink", "in")), 15, "100 answers")
        self.assertEqual((1, 1, None), (port["connections"], port["matched"], port["incompatible"]))
        self.assertEqual(1, self.port("source", "out")["matched"])

        begun = len(far.raw)
        self.gateway(far).kill()
        far.wait_for_line("the gateway to domain %d was killed" % self.other, after=begun)
        before = self.port("sink", "in")["samples"]
        port = wait_until(lambda: (lambda p: p if p["samples"] > before + 100 else None)(self.port("sink", "in")), 15, "answers again")
        self.assertEqual({"EXECUTING"}, set(self.states_of("far").values()))

        near.signal(signal.SIGINT)
        self.assertEqual(0, near.wait(10).status, near.err)
        wait_until(lambda: self.port("source", "out")["matched"] == 0, 10, "the loss of the other side")
        far.signal(signal.SIGINT)
        self.assertEqual(0, far.wait(10).status, far.err)
        seen = json.loads(self.read("far"))
        self.assertEqual(0, seen["wrong"])
        self.assertGreater(seen["read"], 200)
        executor = far.executor()
        print("rows %d, missed %d, %d samples went there and back" % (executor["cycles"], executor["missed"], seen["read"]))

    def test_a_quality_of_service_that_keeps_the_other_from_matching_is_named(self):
        far = self.start("run", self.cell, "--json")
        far.wait_for_state("sink", "EXECUTING")
        with open(self.beside("near.xml")) as file:
            text = file.read()
        cell = self.write("near.xml", text.replace('topic="answers" kind="queue" depth="256" reliability="reliable"', 'topic="answers"'))
        near = self.start("run", cell, "--json", environment={"TAKT_DOMAIN": str(self.other)})
        near.wait_for_state("relay", "EXECUTING")
        wait_until(lambda: self.port("source", "out")["matched"] == 1, 15, "the way there")
        port = wait_until(lambda: (lambda p: p if p["incompatible"] else None)(self.port("sink", "in")), 15, "what is incompatible")
        self.assertEqual(("reliability", 1, 0, 0), (port["incompatible"], port["connections"], port["matched"], port["samples"]))
        for run in (near, far):
            run.signal(signal.SIGINT)
            self.assertEqual(0, run.wait(10).status, run.err)


if __name__ == "__main__":
    takt_system.main()
