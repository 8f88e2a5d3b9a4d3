import json
import os
import re
import signal
import sys
import time
import urllib.request

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import networks
import takt_system
from shifted_clock import WallClock
from takt_system import wait_until

HOUR = 3600
DAY = 24 * HOUR
FAR = """<cell name="far">
  <device name="robot"><module><name>source</name>
    <filename>port_source.so</filename> <moduletype>thread</moduletype> <operationtype>periodic</operationtype>
    <period>20ms</period> <priority>1</priority>
  </module></device>
  <device name="line"><module><name>sink</name>
    <filename>port_sink.so</filename> <moduletype>thread</moduletype> <operationtype>periodic</operationtype>
    <period>5ms</period> <priority>1</priority>
  </module></device>
  <connection from="robot.source.out" to="line.sink.in" deadline="100ms"/>
</cell>
"""


class ClockSteps(takt_system.Case):
    def setUp(self):
        super().setUp()
        self.robot = WallClock(os.path.join(self.folder, "clock.robot"))
        self.line = WallClock(os.path.join(self.folder, "clock.line"))

    def program(self, name, *arguments, **options):
        """Starts a program with the clock of device robot, unless `environment` names another clock."""
        options["environment"] = {**self.robot.environment, **(options.get("environment") or {})}
        return super().program(name, *arguments, **options)

    def start_nodes(self):
        self.nodes_of_cell = {"robot": self.node("robot"), "line": self.node("line", environment=self.line.environment)}

    def start_cell(self):
        self.start_nodes()
        self.deploy("cell.xml")
        self.wait_for_states({"robot": "EXECUTING", "line": "EXECUTING"})

    def end_cell(self):
        self.done("undeploy cell")
        self.end(self.nodes_of_cell)
        for node in self.nodes_of_cell.values():
            self.assertNotRegex(node.err, "RECOVER|stale")

    def walk_on(self, rows=1500):
        """Waits until both devices have run `rows` more rows, and checks that no module failed. Returns the status of the devices."""
        before = {d["name"]: d for d in self.status_of()["devices"]}

        def walked():
            now = {d["name"]: d for d in self.status_of()["devices"]}
            return now if set(now) == set(before) and all(
                now[name]["executors"][0]["cycles"] >= before[name]["executors"][0]["cycles"] + rows for name in before) else None
        after = wait_until(walked, "%d more rows" % rows)
        for name in before:
            self.assertTrue(after[name]["alive"], name)
            missed = [each[name]["executors"][0]["missed"] for each in (before, after)]
            self.assertLess(missed[1] - missed[0], 60 * 1000, "%s: it must not miss the rows of the clock step (3,600,000)" % name)
            for module in after[name]["modules"]:
                self.assertEqual(("EXECUTING", 0), (module["state"], module["errors"]), (name, module["name"]))
        return after

    def walked(self, device):
        """Returns the T0 that the module on the device measured. Checks that all its releases were on one grid."""
        t0, runs, strayed = (int(word) for word in self.read(device).split())
        self.assertGreater(runs, 0)
        self.assertEqual(0, strayed, "%s: releases off the grid" % device)
        return t0

    def assert_one_grid(self, restarts=0):
        """Checks that both devices had the same grid. `restarts` is how often the source was restarted, because its numbers then begin with
        1 again."""
        t0 = {device: self.walked(device) for device in ("robot", "line")}
        print("T0 of the devices differs by %d ns" % (t0["robot"] - t0["line"]))
        self.assertLess(abs(t0["robot"] - t0["line"]), 500 * 1000)
        seen = json.loads(self.read("seen"))
        self.assertGreater(seen["read"], 100)
        self.assertLessEqual(seen["wrong"], restarts)
        self.assertLess(seen["oldest_ns"], 30 * 10**9, "a sample must not look as old as the clock step")

    def robots_times(self):
        """Returns the times of day, in seconds, at which the node of robot reported that the source is EXECUTING."""
        return [step.at for step in self.nodes_of_cell["robot"].steps("source") if step.target == "EXECUTING"]

    def test_setting_the_clocks_of_all_devices_does_not_move_the_grid(self):
        self.start_cell()
        began = wait_until(self.robots_times, "the source to execute")[0]
        for seconds in (HOUR, -HOUR, 0):
            with self.subTest(seconds):
                for clock in (self.robot, self.line):
                    clock.set_by(seconds)
                self.walk_on()
                before = len(self.robots_times())
                self.done("stop robot.source", "get line.sink most")
                self.done("start robot.source")
                # New lines must show the new time, which proves that the clock was set.
                said = wait_until(lambda: self.robots_times()[before:], "the source to execute again")[0]
                ahead = (said - began + DAY // 2) % DAY - DAY // 2
                self.assertAlmostEqual(seconds, ahead, delta=600)
                log, trace = self.done("log robot --json", "trace robot --json")
                told = [json.loads(line) for line in log.splitlines()]
                self.assertEqual(len(told), len({event["sequence"] for event in told}))
                for earlier, later in zip(told, told[1:]):  # a node may record an event up to a second after its time
                    if earlier["sequence"] > later["sequence"]:
                        self.assertLess(later["time_ns"] - earlier["time_ns"], 2 * 10**9, (earlier, later))
                commands = [event for event in told if event["kind"] == "command"]
                self.assertIn("start was carried out", commands[-1]["cause"])
                self.assertAlmostEqual(seconds, commands[-1]["time_ns"] / 1e9 - time.time(), delta=600)
                self.assertIn("executors", json.loads(trace))
        self.done("swap robot.source port_source.so")
        self.walk_on(500)
        self.end_cell()
        self.assert_one_grid(restarts=1)
        for clock in (self.robot, self.line):
            self.assertEqual(0, clock.waits, "a program waits until an instant of the wall clock")

    def test_setting_the_clock_of_one_device_does_not_move_the_grid(self):
        self.start_cell()
        for seconds in (HOUR, -HOUR):
            with self.subTest(seconds):
                self.line.set_by(seconds)
                self.walk_on(3000)  # this takes longer than every lease, and longer than the deadline of every value
                self.done("get line.sink most", "log", "trace line")
                order = self.takt("stop", "line.grid")
                if seconds > 0:  # by the clock of the device, the deadline of the command has already passed
                    self.assertEqual(1, order.status)
                    self.assertRegex(order.err, "after its deadline; synchronise the clocks of the devices")
                else:
                    self.assertEqual(0, order.status, order.err)
                    self.done("start line.grid")
        self.line.set_by(0)
        self.walk_on()
        self.end_cell()
        self.assert_one_grid()

    def test_a_cell_resumed_after_a_clock_step_keeps_its_grid(self):
        self.start_cell()
        for seconds in (HOUR, -HOUR):
            with self.subTest(seconds):
                for clock in (self.robot, self.line):
                    clock.set_by(seconds)
                node = self.nodes_of_cell["robot"]
                node.signal(signal.SIGKILL)
                node.wait()
                wait_until(lambda: not [p for p in node.processes() if p.alive], "its host and programs to end")
                self.nodes_of_cell["robot"] = self.node("robot", "--resume")
                self.wait_for_states({"robot": "EXECUTING", "line": "EXECUTING"})
        self.done("undeploy cell")
        self.end(self.nodes_of_cell)
        self.assert_one_grid(restarts=2)

    def test_takt_record_keeps_recording_when_the_clocks_of_the_devices_are_set(self):
        self.start_cell()
        recording = self.start("record", "robot.source.out", "--for", "4", "--out", "steps.takt")
        wait_until(lambda: os.path.exists(os.path.join(self.folder, "steps.takt")), "a recording")
        for seconds in (HOUR, -HOUR, 0):
            for clock in (self.robot, self.line):
                clock.set_by(seconds)
            self.walk_on(300)
        self.assertEqual(0, recording.wait().status, recording.err)
        self.assertGreater(int(re.search(r"(\d+) samples", recording.out + recording.err)[1]), 100)
        self.end_cell()
        self.assert_one_grid()

    def test_takt_deploy_rejects_a_cell_whose_clocks_differ_by_30_s(self):
        self.start_nodes()
        for seconds in (30, -30):
            with self.subTest(seconds):
                self.line.set_by(seconds)
                # The operator has the clock that is ahead. Otherwise one device would reject its command as late.
                operator = self.line if seconds > 0 else self.robot
                deploy = self.takt("deploy", "cell.xml", environment=operator.environment)
                self.assertEqual(1, deploy.status)
                self.assertRegex(deploy.err, r"(?m)^error: the clock of device (robot|line) is (29\.\d+|30(\.\d+)?) s (behind|ahead of) the clock "
                                             r"of device (robot|line) \(±.*\), more than the allowed 100 ms; .*chrony or ptp4l$")
                self.assertNotIn("EXECUTING", "".join(node.err for node in self.nodes_of_cell.values()))
        self.line.set_by(0)
        self.deploy("cell.xml")
        self.wait_for_states({"robot": "EXECUTING", "line": "EXECUTING"})
        self.end_cell()

    def test_a_value_becomes_stale_although_the_clock_of_its_writer_is_ahead(self):
        self.start_nodes()
        self.deploy("delayed.xml")
        self.wait_for_states({"robot": "EXECUTING", "line": "EXECUTING"})

        def late():
            sink = [m for m in self.status_of("line")["modules"] if m["name"] == "sink"][0]
            return sink["ports"][0]["late"]

        def become_late():
            before = late()
            wait_until(lambda: late() >= before + 3, "three more late values")
        become_late()
        self.assertLess(abs(self.status_of("line")["clock"]["offset_us"]), 100e3)
        self.robot.set_by(0.5)  # the values now seem to come from the future
        clock = wait_until(lambda: [c for c in [self.status_of("line")["clock"]] if c and c["offset_us"] < -400e3], "the step to be seen")[0]
        self.assertEqual("robot", clock["reference"])
        self.assertAlmostEqual(-500e3, clock["offset_us"], delta=clock["bound_us"] + 1)
        self.assertRegex(self.done("status")[0], r"device line .*clock -[45]\d\d\.\d ms ±\d+\.\d ms")
        become_late()
        wait_until(lambda: "clocks-differ" in self.done("log --kind clocks-differ")[0], "the event")
        self.robot.set_by(0)
        wait_until(lambda: "clocks-agree" in self.done("log --kind clocks-agree")[0], "the event")
        self.done("undeploy delayed")
        self.end(self.nodes_of_cell)

    def test_the_metrics_show_how_far_the_clock_of_a_device_differs(self):
        self.start_cell()
        web = self.start("web", "--port", "0")
        web.wait_for_out(r"http://")
        address = re.search(r"http://\S+/", web.out)[0]

        def measured(seconds):
            with urllib.request.urlopen(address + "metrics", timeout=takt_system.LONG) as answer:
                told = re.findall(r'^takt_device_clock_offset(_error)?_seconds{cell="cell",device="(\w+)"} (\S+)$', answer.read().decode(), re.M)
            found = {what: float(value) for what, device, value in told if device == "line"}
            self.assertEqual(len(found), len(told), "the clock of the first device differs from no other: %s" % told)
            return found and found["_error"] < 0.1 and abs(found[""] - seconds) <= found["_error"] + 1e-3
        for seconds in (0, 0.5, -HOUR, 0):
            with self.subTest(seconds):
                self.line.set_by(seconds)
                wait_until(lambda: measured(seconds), "the metrics to contain the offset")
        web.signal(signal.SIGTERM)
        self.assertEqual(0, web.wait().status, web.err)
        self.end_cell()


class FarDevices(networks.NetworkCase):
    """Packets between the devices take 300 ms in each direction, longer than the deadline of their connection."""
    MACHINES = ("robot", "line")

    def test_a_late_value_stays_late_if_the_clock_of_its_writer_is_set_by_less_than_the_round_trip(self):
        robot = WallClock(os.path.join(self.folder, "clock.robot"))
        self.net.impair("robot", delay=0.3)
        nodes = {"robot": self.node("robot", environment=robot.environment), "line": self.node("line")}
        self.deploy(self.write("far.xml", FAR))
        self.wait_for_states({"robot": "EXECUTING", "line": "EXECUTING"})

        def line_knows(seconds):
            """Returns the status of line if it contains the true difference of the clocks, and values have arrived since."""
            line = self.status().get("line")
            if line is None or line["clock"] is None or line["modules"][0]["ports"][0]["age_us"] is None:
                return None
            self.assertEqual("robot", line["clock"]["reference"])
            return line if abs(line["clock"]["offset_us"] + seconds * 1e6) <= line["clock"]["bound_us"] + 5e3 else None

        for seconds in (0, 0.55, 0):
            with self.subTest(seconds):
                robot.set_by(seconds)
                wait_until(lambda: line_knows(seconds), "line to measure the clock of robot")
                for _ in range(3):
                    port = wait_until(lambda: line_knows(seconds), "the status of line")["modules"][0]["ports"][0]
                    self.assertGreater(port["age_us"], 300e3, "each value needs 300 ms, and the deadline is 100 ms")
        self.done("undeploy far")
        self.end(nodes)


if __name__ == "__main__":
    takt_system.main()
