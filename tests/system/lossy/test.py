"""Commands from a machine whose network cable loses packets. tests/system/poor_link.py simulates the cable."""
import os
import signal
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import networks
import takt_system
from takt_system import how_much, wait_until

CELL = """<cell name="lossy">
  <device name="robot">
    <module><name>latch</name><filename>latch.so</filename><moduletype>thread</moduletype><operationtype>periodic</operationtype>
      <period>20000000</period><priority>1</priority></module>
  </device>
</cell>
"""

QUEUE = """<cell name="queue">
  <device name="robot">
    <module><name>source</name><filename>port_source.so</filename><moduletype>thread</moduletype><operationtype>periodic</operationtype>
      <period>100000000</period><priority>1</priority></module>
  </device>
  <device name="line">
    <module><name>sink</name><filename>port_sink.so</filename><moduletype>thread</moduletype><operationtype>periodic</operationtype>
      <period>100000000</period><priority>1</priority></module>
  </device>
  <connection from="robot.source.out" to="line.sink.in" kind="queue" depth="64"/>
</cell>
"""


class Lossy(networks.NetworkCase):
    MACHINES = ("robot", "line")

    def test_commands_are_answered_in_time_although_every_third_packet_is_lost(self):
        # Fewer than half of the commands may fail. With a chance of 2 % each, fewer than one run in a million exceeds this.
        nodes = self.nodes("robot")
        self.deploy(self.write("cell.xml", CELL))
        self.net.impair("operator", loss=0.3)
        commands = how_much("TAKT_TEST_LOSSY_COMMANDS", 10, 100)
        failed = []
        for i in range(commands):
            run = self.operator(("status", "log")[i % 2])
            if run.status != 0:
                failed.append(run.err)
        print("%d of %d commands failed%s" % (len(failed), commands, "".join("\n" + text for text in failed)))
        self.assertLess(len(failed), commands / 2)
        self.net.impair("operator")
        wait_until(lambda: self.status().get("robot", {}).get("alive"), "the device to be found without loss")
        self.done("undeploy lossy")
        self.end(nodes)

    def test_a_command_finds_its_device_although_discovery_messages_are_lost_four_times(self):
        # Fast DDS repeats a lost message after 1.1 s, and a command searches for 3 s.
        self.nodes("robot")
        wait_until(lambda: "robot" in self.status(), "the device to be found")
        self.net.impair("operator", first=4)
        self.assertIn("robot", self.status())

    def test_a_link_with_a_long_delay_carries_few_heartbeats(self):
        # Ten samples a second need about 15 kB/s. Heartbeats in a fixed period of 5 ms would need as much again, because an answer takes
        # 200 ms. A slow machine only sends less.
        nodes = self.nodes(*self.MACHINES)
        self.deploy(self.write("queue.xml", QUEUE))
        self.net.impair("line", delay=0.1)
        before, begin = self.net.carried("line"), time.monotonic()
        time.sleep(4)
        after, elapsed = self.net.carried("line"), time.monotonic() - begin
        self.end(nodes)
        rates = [(after[way] - before[way]) / elapsed for way in (0, 1)]
        print("%.0f B/s from the device, %.0f B/s to it" % tuple(rates))
        self.assertGreater(min(rates), 500)
        self.assertLess(max(rates), 22000)

    def test_the_message_names_the_device_that_only_announced_itself(self):
        # The node sends its status to the multicast group, because another machine receives it. So it also arrives at the operator.
        self.nodes("robot")
        self.start("watch", on="line").wait_for_out(r"\brobot: waiting\b")
        wait_until(lambda: "robot" in self.status(), "the device to be found")
        self.net.lose_packets("robot", "operator")
        for command in ("status", "stop robot.latch", "deploy " + self.write("cell.xml", CELL)):
            run = self.operator(*command.split())
            self.assertEqual(1, run.status)
            self.assertIn("only announcements arrived from robot: check whether the network loses or delays packets", run.err)

    def test_the_search_goes_on_while_discovery_messages_arrive(self):
        # Discovery needs at least two messages there and back, 4 s, and a search without any message ends after 3 s.
        self.nodes("robot")
        wait_until(lambda: "robot" in self.status(), "the device to be found")
        self.net.impair("operator", delay=1.0)
        for command in ("status", "stop robot.nothing"):
            run = self.operator(*command.split())
            self.assertIn("waiting for the status of robot, whose packets arrive slowly ...", run.err)
            self.assertEqual(0 if command == "status" else 1, run.status, run.err)
            self.assertNotIn("not found", run.err)

    def test_a_cell_can_be_used_over_a_link_of_128_kbit_per_second(self):
        nodes = self.nodes("robot")
        wait_until(lambda: "robot" in self.status(), "the device to be found")
        self.net.impair("operator", delay=0.2, rate=128000)
        self.deploy(self.write("cell.xml", CELL))
        watch = self.start("watch")
        watch.wait_for_out(r"\brobot: running\b")
        watch.signal(signal.SIGINT)
        watch.wait()
        self.done("stop robot.latch")
        self.assertEqual("START", self.status()["robot"]["modules"][0]["state"])
        self.done("undeploy lossy")
        self.end(nodes)


class Secured(networks.NetworkCase):
    MACHINES = ("robot",)

    def test_secured_commands_are_answered_although_every_third_packet_is_lost(self):
        cell = self.write("cell.xml", CELL)
        self.assertEqual(0, self.takt("secure", "init", cell, "keys", "--operator", "anna").status)
        keys = os.path.join(self.folder, "keys")
        nodes = {"robot": self.node("robot", "--security", os.path.join(keys, "devices", "robot"))}
        identity = ("--security", os.path.join(keys, "operators", "anna"))
        self.assertEqual(0, self.operator("deploy", cell, *identity).status)
        self.net.impair("operator", loss=0.3)
        commands = how_much("TAKT_TEST_LOSSY_COMMANDS", 10, 100)
        failed = []
        for i in range(commands):
            run = self.operator(("status", "log")[i % 2], *identity)
            if run.status != 0:
                failed.append(run.err)
        print("%d of %d secured commands failed%s" % (len(failed), commands, "".join("\n" + text for text in failed)))
        self.assertLess(len(failed), commands / 2)
        self.net.impair("operator")
        self.end(nodes)


if __name__ == "__main__":
    takt_system.main()
