"""Two cells in different DDS domains exchange samples through a bridge.

The cell of far.xml connects its ports to topics of the other domain. The cell of near.xml sends replies on these topics. The node of
far.xml starts a bridge process for the other domain, and restarts it after a crash. If a QoS policy prevents a connection from matching,
takt status names this policy. """
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
        """Returns the bridge process that the node of this run has started for the other domain."""
        found = [p for p in run.processes("takt-node") if not p.arguments]
        return found[0] if found else None

    def test_samples_reach_another_dds_domain_even_after_the_bridge_is_killed(self):
        far = self.start("run", self.cell, "--json")
        far.wait_for_state("sink", "EXECUTING")
        self.assertEqual(0, self.port("source", "out")["matched"], "the other cell does not run yet")
        near = self.start("run", "near.xml", "--json", environment={"TAKT_DOMAIN": str(self.other)})
        near.wait_for_state("relay", "EXECUTING")
        port = wait_until(lambda: (lambda p: p if p["samples"] > 100 else None)(self.port("sink", "in")), "100 answers")
        self.assertEqual((1, 1, None), (port["connections"], port["matched"], port["incompatible"]))
        self.assertEqual(1, self.port("source", "out")["matched"])

        begun = len(far.raw)
        self.gateway(far).kill()
        far.wait_for_line("the bridge to domain %d was killed" % self.other, after=begun)
        before = self.port("sink", "in")["samples"]
        port = wait_until(lambda: (lambda p: p if p["samples"] > before + 100 else None)(self.port("sink", "in")), "more answers")
        self.assertEqual({"EXECUTING"}, set(self.states_of("far").values()))

        near.signal(signal.SIGINT)
        self.assertEqual(0, near.wait().status, near.err)
        wait_until(lambda: self.port("source", "out")["matched"] == 0, "the writer to notice the end of the other cell")
        far.signal(signal.SIGINT)
        self.assertEqual(0, far.wait().status, far.err)
        seen = json.loads(self.read("far"))
        self.assertEqual(0, seen["wrong"])
        self.assertGreater(seen["read"], 200)
        executor = far.executor()
        print("rows %d, missed %d, %d samples went there and back" % (executor["cycles"], executor["missed"], seen["read"]))

    def test_takt_status_names_the_qos_policy_that_prevents_a_match(self):
        far = self.start("run", self.cell, "--json")
        far.wait_for_state("sink", "EXECUTING")
        with open(self.beside("near.xml")) as file:
            text = file.read()
        cell = self.write("near.xml", text.replace('topic="answers" kind="queue" depth="256" reliability="reliable"', 'topic="answers"'))
        near = self.start("run", cell, "--json", environment={"TAKT_DOMAIN": str(self.other)})
        near.wait_for_state("relay", "EXECUTING")
        wait_until(lambda: self.port("source", "out")["matched"] == 1, "the connection to the other cell to match")
        port = wait_until(lambda: (lambda p: p if p["incompatible"] else None)(self.port("sink", "in")), "the mismatch to be named")
        self.assertEqual(("reliability", 1, 0, 0), (port["incompatible"], port["connections"], port["matched"], port["samples"]))
        for run in (near, far):
            run.signal(signal.SIGINT)
            self.assertEqual(0, run.wait().status, run.err)


if __name__ == "__main__":
    takt_system.main()
