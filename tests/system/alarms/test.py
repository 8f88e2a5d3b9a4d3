"""Tests the alarms of real nodes: faults that somebody must acknowledge."""
import getpass
import os
import signal
import socket
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import wait_until


class Alarms(takt_system.Case):
    def alarms(self, **options):
        run = self.takt("alarms", "--json", **options)
        self.assertEqual(0, run.status, run.err)
        return run.report["alarms"]

    def wait_for_alarms(self, *wanted, **options):
        """Waits for these alarms, each as "DEVICE.MODULE KIND: STATE", in any order. Returns them."""
        def found():
            alarms = self.alarms(**options)
            there = ["%s%s %s: %s" % (a["device"], "." + a["module"] if a["module"] else "", a["kind"], a["state"]) for a in alarms]
            return alarms if sorted(there) == sorted(wanted) else None
        return wait_until(found, "the alarms %s" % (wanted,)) if wanted else self.assertEqual([], self.alarms(**options))

    def acknowledged(self, **options):
        run = self.takt("log", "--json", "--kind", "acknowledged", **options)
        self.assertEqual(0, run.status, run.err)
        return run.out.splitlines()

    def test_an_alarm_outlives_its_cause_and_its_node_until_it_is_acknowledged(self):
        node = self.node("line")
        self.assertEqual("no alarms\n", self.takt("alarms").out)
        self.deploy("cell.xml")
        alarm, = self.wait_for_alarms("line.fails error: unacknowledged")
        self.assertEqual(("failure", "error", 1, True), (alarm["error"], alarm["severity"], alarm["count"], alarm["active"]))
        self.assertRegex(self.takt("alarms").out, r"^X line\.fails +error +unacknowledged, since \d{4}-.*\n +failure: ")
        self.assertIn("\n  1 unacknowledged alarm; takt alarms lists them\n", self.takt("status").out)
        self.refused({"acknowledge line.source": "module line.source has no unacknowledged alarm",
                      "acknowledge line.fials": "device line has no module 'fials'; did you mean fails",
                      "acknowledge nobody": "device nobody",
                      "acknowledge line.fails --note " + "x" * 256: "the note has 256 bytes, but may have at most 255"})

        # An operator ends the module, so the cause has gone. Then the node crashes.
        self.done("destruct line.fails")
        self.wait_for_alarms("line.fails error: unacknowledged, returned to normal")
        node.signal(signal.SIGKILL)
        node.wait()
        node = self.node("line")
        self.wait_for_alarms("line.fails error: unacknowledged, returned to normal",
                             "line node-restart: unacknowledged, returned to normal")

        run = self.takt("acknowledge", "line.fails", "--note", "the cable: \x1b[2Jworn\n\u202eout")
        self.assertEqual((0, "line.fails: error is acknowledged\n"), (run.status, run.out), run.err)
        self.wait_for_alarms("line node-restart: unacknowledged, returned to normal")
        self.done("acknowledge line")
        self.wait_for_alarms()
        self.refused({"acknowledge line": "device line and its modules have no unacknowledged alarm"})
        who = "acknowledged by %s@%s" % (getpass.getuser(), socket.gethostname())
        first, second = self.acknowledged()
        self.assertIn(r"(error) %s: the cable: \\x1b[2Jworn\\n\\xe2\\x80\\xaeout" % who, first)
        self.assertIn('(node-restart) %s"' % who, second)
        # The acknowledgement outlives the node, too.
        node.signal(signal.SIGTERM)
        self.assertEqual(0, node.wait().status, node.err)
        node = self.node("line")
        self.wait_for_alarms()
        self.end({"line": node})

    def test_an_acknowledged_alarm_is_listed_while_its_cause_exists(self):
        node = self.node("line")
        self.deploy("cell.xml")
        self.wait_for_alarms("line.fails error: unacknowledged")
        self.done("acknowledge line.fails --note 'waits for a spare part'")
        alarm, = self.wait_for_alarms("line.fails error: acknowledged")
        self.assertEqual("waits for a spare part", alarm["acknowledged"]["note"])
        self.assertNotIn("unacknowledged", self.takt("status").out)
        self.assertRegex(self.takt("alarms").out, r"\n +acknowledged by \S+ at .*: waits for a spare part\n$")
        self.done("restart line.fails")  # it fails again
        self.wait_for_alarms("line.fails error: unacknowledged")
        self.done("acknowledge line", "undeploy alarmed")
        self.wait_for_alarms()
        self.end({"line": node})

    def test_an_operator_of_a_secured_cell_may_acknowledge_but_an_observer_may_not(self):
        with open(self.beside("cell.xml")) as file:
            text = file.read()
        cell = self.write("cell.xml", text.replace("<cell ", '<cell domain="%d" security="required" ' % self.domain))
        self.assertEqual(0, self.takt("secure", "init", cell, "keys", "--operator", "anna", "--observer", "eve").status)
        keys = os.path.join(self.folder, "keys")

        def who(identity):
            return {"environment": {"TAKT_SECURITY": os.path.join(keys, identity)}}
        node = self.node("line", "--security", keys)
        self.agreed(lambda: self.takt("deploy", cell, **who("operators/anna")))
        self.wait_for_alarms("line.fails error: unacknowledged", **who("observers/eve"))
        run = self.takt("acknowledge", "line.fails", **who("observers/eve"))
        self.assertEqual(1, run.status)
        self.assertRegex(run.err, "observer eve at .* may only observe, not acknowledge")
        self.wait_for_alarms("line.fails error: unacknowledged", **who("observers/eve"))
        run = self.takt("acknowledge", "line.fails", "--note", "seen", **who("operators/anna"))
        self.assertEqual(0, run.status, run.err)
        alarm, = self.wait_for_alarms("line.fails error: acknowledged", **who("observers/eve"))
        self.assertEqual(("operator anna at 127.0.0.1", "seen"), (alarm["acknowledged"]["by"], alarm["acknowledged"]["note"]))
        self.assertIn("acknowledged by operator anna at 127.0.0.1: seen", self.acknowledged(**who("observers/eve"))[0])
        self.end({"line": node})


if __name__ == "__main__":
    takt_system.main()
