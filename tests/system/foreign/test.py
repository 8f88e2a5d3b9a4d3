"""A program that uses Cyclone DDS observes a running cell, sends commands to it, and exchanges samples with its ports. Its message types
are those in idl/.

TAKT_CYCLONE_PEER is the path of the program in tests/system/cyclone."""
import json
import os
import signal
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import Run, wait_until

CYCLONE = os.environ["TAKT_CYCLONE_PEER"]
LOOPBACK = """<CycloneDDS><Domain id="any"><General><Interfaces><NetworkInterface address="127.0.0.1" multicast="true"/></Interfaces>
<AllowMulticast>spdp</AllowMulticast></General></Domain></CycloneDDS>"""
STOP, START = 8, 7  # values of takt::CommandKind
STARTED, EXECUTING = 2, 3  # values of takt::LifecycleState


class Foreign(takt_system.Case):
    def cyclone(self, *arguments):
        run = Run([CYCLONE, str(self.domain)] + [str(a) for a in arguments], self.folder, environment={"CYCLONEDDS_URI": LOOPBACK})
        self.runs.append(run)
        return run

    def said(self, run, topic):
        return [s for s in (json.loads(line) for _, line in list(run.out_lines)) if s["topic"] == topic and "path" in s]

    def command(self, kind):
        run = self.cyclone("command", "line", "conveyor", kind).wait()
        self.assertEqual(0, run.status, run.err)
        return json.loads(run.out)

    def test_a_program_with_cyclone_dds_can_observe_and_command_a_cell(self):
        cell = self.start("run", "cell.xml", "--json")
        cell.wait_for_state("counter", "EXECUTING")
        watch = self.cyclone("watch", 60)
        state = lambda module: [s["state"] for s in self.said(watch, "lifecycle") if s["path"] == "foreign/line/" + module]
        for module in ("conveyor", "counter"):
            wait_until(lambda: state(module), "the state of " + module)
            self.assertEqual(EXECUTING, state(module)[-1], "a late reader must get the present state")
        wait_until(lambda: len(self.said(watch, "statistics")) > 3 and self.said(watch, "device"), "statistics and the device")
        self.assertEqual({"line"}, {s["device"] for s in self.said(watch, "device")})

        # Samples are sent in both directions: the Cyclone program writes commands for the belt and reads the state of the belt.
        write = self.cyclone("write", "BeltCommand", "belt_command", 40, 20, "best-effort")
        parts = self.cyclone("read", "Part", "parts", 1, 30, "reliable")
        self.assertEqual(0, write.wait().status, write.err)
        seen = self.cyclone("read", "BeltState", "belt_state", 300, 20, "best-effort").wait()
        self.assertEqual(0, seen.status, seen.err)
        states = [json.loads(line) for _, line in seen.out_lines]
        self.assertEqual(sorted(s["position"] for s in states), [s["position"] for s in states], "samples must be in order")
        self.assertEqual(1, json.loads(parts.wait().out)["number"])
        self.assertGreater(states[-1]["parts"], 0)

        for kind, expected in ((STOP, STARTED), (START, EXECUTING)):
            before = len(state("conveyor"))
            answer = self.command(kind)
            self.assertEqual((0, "line"), (answer["code"], answer["device"]))
            wait_until(lambda: len(state("conveyor")) > before, "the transition of conveyor")
            self.assertEqual(expected, state("conveyor")[-1])
        numbers = [s["sequence_number"] for s in self.said(watch, "lifecycle") if s["path"] == "foreign/line/conveyor"]
        self.assertEqual(list(range(numbers[0], numbers[0] + len(numbers))), numbers, "no transition may be lost or doubled")

        cell.signal(signal.SIGINT)
        self.assertEqual(0, cell.wait().status, cell.err)
        watch.signal(signal.SIGKILL)
        watch.wait()

    def test_a_program_with_cyclone_dds_is_notified_when_a_deployment_or_undeployment_disposes_states(self):
        nodes = self.nodes("line")
        watch = self.cyclone("watch", 90)
        disposed = lambda: [json.loads(line).get("disposed") for _, line in list(watch.out_lines)]
        wait_until(lambda: "-/line" in [s["path"] for s in self.said(watch, "device")], "the waiting device")
        self.deploy("cell.xml")
        wait_until(lambda: "-/line" in disposed(), "the end of the waiting device")
        wait_until(lambda: len(self.said(watch, "lifecycle")) > 3, "the modules")
        self.done("undeploy foreign")
        for path in ("foreign/line", "foreign/line/conveyor", "foreign/line/counter"):
            wait_until(lambda: path in disposed(), "the end of " + path)
        watch.signal(signal.SIGKILL)
        watch.wait()
        self.end(nodes)


if __name__ == "__main__":
    takt_system.main()
