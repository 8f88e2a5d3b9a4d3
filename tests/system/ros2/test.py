"""A program that looks like a ROS 2 node on the network exchanges messages with the ports of a cell. TAKT_ROS2_PEER is the program of this folder."""
import json
import os
import signal
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import Run, wait_until

PEER = os.environ["TAKT_ROS2_PEER"]
LOOPBACK = """<CycloneDDS><Domain id="any"><General><Interfaces><NetworkInterface address="127.0.0.1" multicast="true"/></Interfaces>
<AllowMulticast>spdp</AllowMulticast></General></Domain></CycloneDDS>"""


class Ros2(takt_system.Case):
    def peer(self, *arguments):
        run = Run([PEER, str(self.domain)] + [str(a) for a in arguments], self.folder, environment={"CYCLONEDDS_URI": LOOPBACK})
        self.runs.append(run)
        return run

    def messages(self, run):
        return [json.loads(line) for _, line in list(run.out_lines)]

    def matched(self, port):
        return any(line.split()[0].endswith(port) and "1/1" in line for line in self.takt("status").out.splitlines() if line.strip())

    def test_a_ros2_node_exchanges_messages_with_a_cell(self):
        cell = self.start("run", "cell.xml", "--json")
        cell.wait_for_state("echo", "EXECUTING")

        names = self.peer("list", 60)
        expected = {"pub rt/joint_states sensor_msgs::msg::dds_::JointState_ reliable",
                    "pub rt/cell/capitals std_msgs::msg::dds_::String_ reliable",
                    "pub rt/cell/x std_msgs::msg::dds_::Float64_ reliable",
                    "sub rt/cell/text std_msgs::msg::dds_::String_ reliable",
                    "sub rt/cmd_vel geometry_msgs::msg::dds_::Twist_ best-effort"}
        wait_until(lambda: expected <= {line.strip() for _, line in list(names.out_lines)}, "the topics under their ROS 2 names")

        before = time.time()
        states = self.peer("sub", "JointState", "/joint_states", 20, 20).wait()
        self.assertEqual(0, states.status, states.err)
        seen = self.messages(states)
        for state in seen:
            self.assertEqual(("base_link", ["a1", "a2", "a3", "a4", "a5", "a6"], 6, 6, []),
                             (state["frame_id"], state["name"], len(state["position"]), len(state["velocity"]), state["effort"]))
        times = [s["sec"] + s["nanosec"] * 1e-9 for s in seen]
        self.assertEqual(sorted(set(times)), times)
        self.assertGreater(times[-1], before)
        self.assertLess(times[-1], time.time() + 1)

        # Texts are sent to the cell and back. The third text is longer than the 255 characters that the port allows, so it is dropped.
        capitals = self.peer("sub", "String", "/cell/capitals", 5, 40)
        wait_until(lambda: self.matched("echo.capitals"), "the reader to match")
        self.assertEqual(0, self.peer("pub", "String", "/cell/text", 6, 20).wait().status)
        self.assertEqual(0, capitals.wait().status, capitals.err)
        self.assertEqual(["HELLO %d" % n for n in (1, 2, 4, 5, 6)], [m["data"] for m in self.messages(capitals)])

        # The cell must receive velocities from a reliable and from a best-effort writer.
        for reliability in ("reliable", "best-effort"):
            wait_until(lambda: not self.matched("echo.x"), "the previous reader to disappear")
            x = self.peer("sub", "Float64", "/cell/x", 5, 40)
            wait_until(lambda: self.matched("echo.x"), "the reader to match")
            self.assertEqual(0, self.peer("pub", "Twist", "/cmd_vel", 40, 20, reliability).wait().status)
            self.assertEqual(0, x.wait().status, x.err)
            values = [m["data"] for m in self.messages(x)]
            self.assertEqual(values, sorted(values))
            self.assertTrue(set(values) <= {0.25 * n for n in range(1, 41)}, values)

        cell.signal(signal.SIGINT)
        self.assertEqual(0, cell.wait().status, cell.err)
        names.signal(signal.SIGKILL)
        names.wait()

    def test_takt_check_rejects_a_port_type_that_ros2_does_not_support(self):
        with open(self.beside("cell.xml"), encoding="utf-8") as file:
            text = file.read()
        path = self.write("wrong.xml", text.replace('from="robot.joint_states.joint_states" topic', 'from="robot.arm.measured" topic'))
        run = self.takt("check", path)
        self.assertEqual(1, run.status)
        line = 1 + text[:text.index('topic="/joint_states"')].count("\n")
        self.assertIn(f"wrong.xml:{line}: error: port robot.arm.measured has type motion::JointState, which is not a ROS 2 message",
                      run.err)


if __name__ == "__main__":
    takt_system.main()
