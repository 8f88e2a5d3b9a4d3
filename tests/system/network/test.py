"""The demo cell runs on three simulated machines (network namespaces), and a fourth machine deploys and observes it.

When a cable is pulled, the isolated device stops its belt by itself, and the other devices keep running. When the cable is back, the cell
places parts again. Two tests check that without multicast, the nodes find each other through a list of peers or through a discovery server.
"""
import json
import os
import re
import signal
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import networks
import takt_system
from takt_system import SOURCE, wait_until

DEVICES = ("robot", "line", "station")
CELL = os.path.join(SOURCE, "deploy", "palletizing.xml")
LEASE = 0.3


class Network(networks.NetworkCase):
    MACHINES = DEVICES

    def status(self):
        return {d["name"]: d for d in self.status_of()["devices"]}

    def wait_for_status(self, condition, what):
        def holds():
            status = self.status()
            return status if condition(status) else None
        return wait_until(holds, what)

    @staticmethod
    def all_execute(status):
        return all(device in status and status[device]["alive"] and {m["state"] for m in status[device]["modules"]} == {"EXECUTING"}
                   for device in DEVICES)

    def end(self, nodes):
        self.done("undeploy palletizing")
        super().end(nodes)

    def test_the_demo_cell_resumes_its_work_after_a_pulled_cable_is_reconnected(self):
        nodes = self.nodes(*DEVICES)
        with open(CELL) as file:
            text = file.read()
        # With its original deadline, the demo cell would correctly stop when the machine stalls, and wait for a manual reset.
        text = text.replace('deadline="500ms" stale="error"', 'deadline="2s" stale="error"')
        self.assertEqual(1, text.count('deadline="2s"'))
        self.deploy(self.write("patient.xml", text))
        self.wait_for_status(self.all_execute, "all devices to execute")
        time.sleep(5)  # wait until some parts are placed
        before = self.wait_for_status(self.all_execute, "all devices to execute")
        self.assertEqual([], [line.text for line in nodes["line"].said("conveyor") if "RECOVER" in line.text])

        self.net.cut("line")
        cut = time.monotonic()
        self.wait_for_status(lambda s: {name: d["alive"] for name, d in s.items()} == {"robot": True, "line": False, "station": True},
                             "the loss of line to be seen")
        print("takt status showed the loss of line %.2f s after the cut" % (time.monotonic() - cut))
        # The isolated device must stop its belt by itself, because it no longer receives commands for the speed of the belt.
        nodes["line"].wait_for_line(r"line\.conveyor: EXECUTING -> RECOVER .*(stale|older)")
        time.sleep(max(0.0, 5 - (time.monotonic() - cut)))
        during = self.status()
        for device, period in (("robot", 0.001), ("station", None)):
            self.assertEqual({"EXECUTING"}, {m["state"] for m in during[device]["modules"]}, device)
        self.net.join("line")
        joined = time.monotonic()
        after = self.wait_for_status(self.all_execute, "line to come back")
        print("the line was back %.2f s after the cable" % (time.monotonic() - joined))
        # Each row of robot during the disconnection must have run or count as missed.
        walked = {}
        for name, status in (("before", before), ("after", after)):
            executor = status["robot"]["executors"][0]
            walked[name] = executor["cycles"] + executor["missed"]
        print("robot: %d rows, %d of them missed" % (walked["after"] - walked["before"],
              after["robot"]["executors"][0]["missed"] - before["robot"]["executors"][0]["missed"]))
        placed = lambda: int(re.search(r"(\d+) placed;", nodes["station"].printed("panel")[-1])[1])
        before = placed()
        wait_until(lambda: placed() > before + 1, "parts to be placed again")
        self.end(nodes)

    def test_nodes_find_each_other_through_a_list_of_peers_without_multicast(self):
        self.net.no_multicast()
        peers = " ".join(self.net.address(device) for device in DEVICES)
        cell = self.cell_with('discovery="peers" peers="%s"' % peers)
        for device in DEVICES:
            self.node(device, "--peers", peers.replace(" ", ","))
        self.deploy(cell)
        self.assert_all_execute_by(("--peers", peers.replace(" ", ",")))
        self.assertEqual(0, self.operator("undeploy", "palletizing", "--peers", peers.replace(" ", ",")).status)

    def test_a_command_with_peers_finds_the_device_of_its_own_machine_without_a_network(self):
        self.net.remove("line")
        peers = ("--peers", self.net.address("robot"))
        self.node("line", *peers)
        run = self.operator("status", "--json", *peers, on="line")
        self.assertEqual(0, run.status, run.err)
        self.assertEqual(["line"], [d["name"] for d in run.report["devices"]])

    def test_a_node_is_the_discovery_server_of_its_own_machine_without_a_network(self):
        self.net.remove("line")
        self.node("line", "--serve-discovery", "11811")
        run = self.operator("status", "--json", "--server", "127.0.0.1:11811", on="line")
        self.assertEqual(0, run.status, run.err)
        self.assertEqual(["line"], [d["name"] for d in run.report["devices"]])

    def test_a_node_starts_before_the_name_of_its_discovery_server_is_known(self):
        self.net.no_multicast()
        self.net.set_host_names()
        server = ("--server", "station:11811")

        def both():
            run = self.operator("status", "--json", *server)
            return run.status == 0 and {d["name"] for d in run.report["devices"] if d["alive"]} == {"line", "station"}
        self.node("station", "--serve-discovery", "11811")
        line = self.node("line", *server)
        line.wait_for_line("warning: discovery server 'station' cannot be resolved yet: .*; trying again")
        self.net.set_host_names(station=self.net.number("station"))
        wait_until(both, "both nodes")

    def test_nodes_find_each_other_through_a_discovery_server_without_multicast(self):
        self.net.no_multicast()
        server = self.net.address("station") + ":11811"
        cell = self.cell_with('discovery="server" server="%s" server-device="station"' % server)
        for device in DEVICES:
            self.node(device, *(["--serve-discovery", "11811"] if device == "station" else ["--server", server]))
        self.deploy(cell)
        self.assert_all_execute_by(("--server", server))
        self.assertEqual(0, self.operator("undeploy", "palletizing", "--server", server).status)

    def test_a_node_may_use_a_discovery_server_on_its_own_machine(self):
        for interface in ("", self.net.address("station")):
            with self.subTest(interface=interface):
                server = self.net.address("station") + ":11811"
                environment = {"TAKT_INTERFACE": interface} if interface else {}
                nodes = {"station": self.node("station", "--serve-discovery", "11811", environment=environment),
                         "second": self.node("second", "--server", server, on="station", environment=environment)}

                def both():
                    run = self.operator("status", "--json", "--server", server)
                    return run.status == 0 and {d["name"] for d in run.report["devices"]} == set(nodes)
                wait_until(both, "both nodes")
                for node in nodes.values():
                    node.signal(signal.SIGTERM)
                    self.assertEqual(0, node.wait().status, node.err)

    def test_programs_on_the_machine_of_the_discovery_server_keep_running(self):
        # Fast DDS ended such programs with an assertion, about two seconds after they had found the server.
        self.net.no_multicast()
        server = self.net.address("station") + ":11811"
        nodes = {"station": self.node("station", "--serve-discovery", "11811"), "line": self.node("line", "--server", server, on="station")}
        for node in nodes.values():
            node.wait_for_line("waits for a deployment")
        watch = self.program("takt", "watch", "--for", "6", "--server", server, on="station").wait()
        self.assertEqual(0, watch.status, watch.err)
        status = self.takt("status", "--json", "--server", server, on="station")
        self.assertEqual(["line", "station"], sorted(d["name"] for d in status.report["devices"] if d["alive"]))
        takt_system.Case.end(self, nodes)

    def cell_with(self, attributes):
        with open(CELL) as file:
            return self.write("palletizing.xml", file.read().replace('<cell name="palletizing">', '<cell name="palletizing" %s>' % attributes))

    def assert_all_execute_by(self, options):
        def holds():
            run = self.operator("status", "--json", *options)
            return run.status == 0 and self.all_execute({d["name"]: d for d in run.report["devices"]})
        wait_until(holds, "every module to execute")


if __name__ == "__main__":
    takt_system.main()
