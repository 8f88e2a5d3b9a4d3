import os
import re
import signal
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import LIFE, wait_until

DEVICES = {"robot": ["grid", "program"], "line": ["grid", "sporadic"], "station": ["grid", "slow", "monitoring"]}


class ThreeDevices(takt_system.Case):
    def test_takt_run_starts_all_devices_of_a_cell_at_the_same_instant(self):
        run = self.start("run", "cell.xml", "--for", "3", "--json")
        run.wait_for_state("monitoring", "EXECUTING")
        nodes = run.processes("takt-node")
        self.assertEqual(sorted(DEVICES), sorted(node.arguments[node.arguments.index("--device") + 1] for node in nodes))
        self.assertEqual(3, len(run.processes("takt-host")))
        run.wait()
        self.assertEqual(0, run.status, run.err)
        self.assertEqual(list(DEVICES), [d["name"] for d in run.report["devices"]])
        self.assertEqual("cell", run.report["cell"])
        for device, modules in DEVICES.items():
            self.assertEqual(modules, list(run.modules(device)))
            for module in modules:
                self.assertEqual(LIFE, run.states(module, device))
        # All modules must be ready before the first module runs.
        texts = [(line.device, line.text) for line in run.lines]
        first_run = min(i for i, (_, text) in enumerate(texts) if text == "START -> EXECUTING")
        last_start = max(i for i, (_, text) in enumerate(texts) if text == "INITIALIZE -> START")
        self.assertLess(last_start, first_run)

        grids = [self.read(name).split() for name in ("robot", "line", "fast", "slow")]
        grids.append(re.search(r"grid (\d+) (\d+) (\d+)", " ".join(run.printed("program"))).groups())
        # All grids must begin at the same instant of the wall clock. Each node reads the two clocks itself to convert this instant, so the
        # results may differ slightly.
        instants = [int(t0) for t0, _, _ in grids]
        self.assertLess(max(instants) - min(instants), 20000, grids)
        self.assertEqual({"0"}, {strayed for _, _, strayed in grids})
        for module, device, every, executor in (("grid", "robot", 1, "main"), ("program", "robot", 2, "main"),
                                                ("grid", "line", 1, "main"), ("grid", "station", 1, "fast"),
                                                ("slow", "station", 1, "slow")):
            self.assert_grid(run, module, every=every, executor=executor, device=device)

    def test_no_device_runs_if_a_module_of_one_device_fails_to_initialise(self):
        run = self.takt("run", "one_refuses.xml", "--for", "5", "--json")
        self.assert_refused(run)
        self.assertEqual(["module line.bad: error: initialize() failed: threw: initialize() threw as it was asked to"], run.other_lines)
        for device in run.report["devices"]:
            self.assertTrue(device["alive"])
            for executor in device["executors"]:
                self.assertEqual(0, executor["cycles"])
            self.assertEqual({"DESTRUCT"}, {m["state"] for m in device["modules"]})

    def test_a_killed_node_leaves_the_other_devices_running(self):
        run = self.start("run", "cell.xml", "--json")
        run.wait_for_state("monitoring", "EXECUTING")
        line = next(node for node in run.processes("takt-node") if "line" in node.arguments)
        line.kill()
        wait_until(lambda: len(run.processes("takt-host")) == 2, "the host of line to end")
        self.assertEqual(2, len(run.processes("takt-node")))
        self.assertIsNone(run.status)
        run.signal(signal.SIGINT)
        run.wait()
        self.assertEqual(1, run.status)
        self.assertEqual(["device line: error: its node was killed by SIGKILL (Killed)"], run.other_lines)
        self.assertEqual([True, False, True], [d["alive"] for d in run.report["devices"]])
        for device in ("robot", "station"):
            for module in DEVICES[device]:
                self.assertEqual(LIFE, run.states(module, device))


if __name__ == "__main__":
    takt_system.main()
