"""The network loses IP packets above a length, and with them the fragments of longer packets, as many VPNs do. The senders are not told."""
import os
import re
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import networks
import takt_system
from takt_system import wait_until

DEVICES = ("robot", "line")
MACHINES = (*DEVICES, "operator")
MODULES = 40
MODULE = """<module>
  <name>%s_%d</name> <filename>fine.so</filename> <moduletype>thread</moduletype> <operationtype>periodic</operationtype>
  <period>100ms</period> <priority>1</priority>
</module>"""


class Mtu(networks.NetworkCase):
    MACHINES = DEVICES

    def limit(self, mtu):
        for machine in MACHINES:
            self.net.limit(machine, mtu)

    def cell(self, security):
        """Writes a descriptor of 15 kB. A device reports more than that about its modules."""
        devices = "".join("<device name='%s'>%s</device>" % (device, "".join(MODULE % (device, i) for i in range(MODULES))) for device in DEVICES)
        return self.write("cell.xml", "<cell name='cell' security='%s'>%s</cell>" % (security, devices))

    def assert_a_cell_runs(self, cell, environment):
        self.agreed(lambda: self.takt("deploy", cell, environment=environment))

        def status():
            run = self.takt("status", "--json", environment=environment)
            return {d["name"]: {m["state"] for m in d["modules"]} for d in run.report["devices"]} if run.status == 0 else {}
        wait_until(lambda: status() == {device: {"EXECUTING"} for device in DEVICES}, "all modules to execute")
        log = self.takt("log", "robot", environment=environment)
        self.assertEqual(0, log.status, log.err)
        undeploy = self.takt("undeploy", "cell", environment=environment)
        self.assertEqual(0, undeploy.status, undeploy.err)
        self.assertEqual({machine: 0 for machine in MACHINES}, {machine: self.net.lost(machine) for machine in MACHINES},
                         "number of packets that were too long")

    def test_a_cell_runs_although_the_network_loses_ip_packets_above_1280_bytes(self):
        self.limit(1280)
        nodes = self.nodes(*DEVICES)
        self.assert_a_cell_runs(self.cell("optional"), {})
        self.end(nodes)

    def test_a_secured_cell_runs_although_the_network_loses_ip_packets_above_1280_bytes(self):
        self.limit(1280)
        cell = self.cell("required")
        run = self.takt("secure", "init", cell, "keys", "--operator", "anna")
        self.assertEqual(0, run.status, run.err)
        keys = os.path.join(self.folder, "keys")
        nodes = {device: self.node(device, "--security", os.path.join(keys, "devices", device)) for device in DEVICES}
        self.assert_a_cell_runs(cell, {"TAKT_SECURITY": os.path.join(keys, "operators", "anna")})
        self.end(nodes)

    def test_devices_are_found_and_name_the_cause_if_only_ip_packets_up_to_600_bytes_arrive(self):
        self.limit(600)
        nodes = self.nodes(*DEVICES)
        for _ in range(5):
            self.assertEqual(set(DEVICES), set(self.status()))
        self.assertEqual({machine: 0 for machine in MACHINES}, {machine: self.net.lost(machine) for machine in MACHINES},
                         "number of packets that were too long")

        for name in ("one", "two", "three", "four"):  # the fault record contains each rejected command
            self.assertEqual(1, self.operator("stop", "robot." + name).status)

        def names_the_cause():
            self.assertNotEqual(0, self.operator("log", "robot").status, "the answer is too long")
            return re.search(r"IP packets of up to 1280 bytes do not reach 10\.77\.0\.3, but shorter ones do", nodes["robot"].err)
        wait_until(names_the_cause, "the node to name the cause")
        self.end(nodes)


if __name__ == "__main__":
    takt_system.main()
