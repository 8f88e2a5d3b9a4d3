import os
import re
import signal
import sys
import time
from collections import namedtuple

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import networks
import takt_system
from takt_system import wait_until

Change = namedtuple("Change", "what at number")  # at: monotonic seconds
_CHANGE = re.compile(r"\b(thread|program|relayed|reader) (SAFE|LIVE|WRONG) (\d+) [a-z, ]+ (\d+)$")


def changes(node, who):
    found = []
    for line in list(node.raw):
        match = _CHANGE.search(line)
        if match and match[1] == who:
            found.append(Change(match[2], int(match[3]) / 1e9, int(match[4])))
    return found


class Readers:
    def wait_for(self, node, readers, what, since, after=None):
        """Waits until each reader has printed `what` later than `since`. If `after` is given, the line must be printed at least after[reader]
        seconds later than `since`. Returns, for each reader, the seconds from `since` until the line."""
        took = {}
        for who in readers:
            begin = since + (after[who] if after else 0.0)

            def found():
                return next((c for c in changes(node, who) if c.what == what and c.at > begin), None)
            took[who] = wait_until(found, "%s of %s" % (what, who)).at - since
        return took

    def tell(self, what, took):
        print("%s: %s" % (what, ", ".join("%s after %.1f ms" % (who, 1000 * s) for who, s in took.items())))

    def goes_safe(self, what, node, readers, act, *arguments, back=None):
        """Calls `act` and waits until the readers get the safe value. Then calls `back` and waits until they get samples again. With
        back="itself", the writer recovers without help, so this function only waits for the samples."""
        since = time.monotonic()
        act(*arguments)
        took = self.wait_for(node, readers, "SAFE", since)
        self.tell(what, took)
        if back is None:
            return
        if back == "itself":  # one reader may get samples again before the other reader has got the safe value
            self.tell("  and back", self.wait_for(node, readers, "LIVE", since, after=took))
            return
        since = time.monotonic()
        back()
        self.tell("  and back", self.wait_for(node, readers, "LIVE", since))

    def assert_never_wrong(self, node):
        for line in node.raw:
            self.assertNotIn(" WRONG ", line)


class OnOneDevice(Readers, takt_system.Case):
    def test_readers_on_the_same_device_get_the_safe_value_when_the_writer_stops_or_fails(self):
        node = self.node("d")
        self.deploy("local.xml")
        everybody = ("thread", "program", "relayed")
        direct = ("thread", "program")
        self.wait_for(node, everybody, "LIVE", 0)

        def order(*words):
            return lambda: self.done(*words)

        self.goes_safe("stopped", node, direct, order("stop d.source"), back=order("start d.source"))
        self.goes_safe("in RECOVER", node, direct, order("set d.source how 2"), back=order("set d.source how 0"))
        self.goes_safe("older than the deadline", node, direct, order("set d.source how 1"), back=order("set d.source how 0"))
        self.goes_safe("in DESTRUCT", node, direct, order("destruct d.source"), back=lambda: self.done("reset d.source") and
                       self.done("initialize d.source") and self.done("start d.source"))
        self.goes_safe("its program was killed", node, ("relayed",), lambda: node.one("port_relay.exe").kill(), back="itself")
        # The readers that this host releases read nothing until the host has restarted, so the test only checks that they get samples again.
        since = time.monotonic()
        node.one("takt-host").kill()
        self.tell("its host was killed; samples again", self.wait_for(node, ("thread",), "LIVE", since))
        self.wait_for_states({"d": "EXECUTING"})
        self.goes_safe("it crashed", node, ("program",), order("set d.source how 3"))
        self.assertEqual(0, self.takt("status", "--json").status)
        inputs = {m["name"]: m["ports"][0] for m in self.status_of("d")["modules"] if m["name"] in ("program", "relayed")}
        self.assertTrue(inputs["program"]["safe"])
        self.assertFalse(inputs["relayed"]["safe"], "the writer of this reader executes")
        self.assert_never_wrong(node)
        self.assertEqual(0, self.takt("undeploy", "local").status)
        self.end({"d": node})


class OnAnotherDevice(Readers, takt_system.Case):
    READERS = ("thread", "program")

    def test_readers_get_the_safe_value_when_a_remote_writer_is_stopped_or_killed(self):
        nodes = self.nodes("robot", "line")
        self.deploy("far.xml")
        self.wait_for(nodes["line"], self.READERS, "LIVE", 0)
        for who in self.READERS:
            self.assertEqual("SAFE", changes(nodes["line"], who)[0].what)
        self.goes_safe("stopped", nodes["line"], self.READERS, self.done, "stop robot.source", back=lambda: self.done("start robot.source"))
        self.goes_safe("its host was killed", nodes["line"], self.READERS, lambda: nodes["robot"].one("takt-host").kill(), back="itself")
        self.goes_safe("its node was killed", nodes["line"], self.READERS, lambda: nodes["robot"].kill_all())
        self.assert_never_wrong(nodes["line"])
        self.takt("undeploy", "far")
        self.end({"line": nodes["line"]})


class OverACable(Readers, networks.NetworkCase):
    def start_cell(self, cell, devices):
        self.lay(*devices)
        nodes = self.nodes(*devices)
        self.deploy(cell)
        return nodes

    def test_readers_get_the_safe_value_when_the_network_cable_of_the_writer_is_pulled(self):
        nodes = self.start_cell("far.xml", ("robot", "line"))
        readers = OnAnotherDevice.READERS
        self.wait_for(nodes["line"], readers, "LIVE", 0)
        for _ in range(2):
            self.goes_safe("its cable was pulled", nodes["line"], readers, self.net.cut, "robot", back=lambda: self.net.join("robot"))
        self.assert_never_wrong(nodes["line"])
        self.assertEqual(0, self.operator("undeploy", "far").status)
        self.end(nodes)

    def test_a_cell_stops_when_a_device_with_a_stop_cell_module_loses_its_network(self):
        nodes = self.start_cell("stop_cell.xml", ("a", "b", "c"))
        self.wait_for(nodes["b"], ("reader",), "LIVE", 0)
        cut = time.monotonic()
        self.net.cut("a")
        nodes["a"].wait_for_line(r"device a: error: has lost b, c, and one of its modules stops the cell when it fails; check its machine")
        for other in ("b", "c"):
            nodes[other].wait_for_line(r"device %s: error: (is lost|stops with its cell: device a: error: is lost)" %
                                       ("(a|%s)" % other))
        for name, module in (("a", "source"), ("b", "reader"), ("c", "reader")):
            nodes[name].wait_for_state(module, "DESTRUCT")
        print("a cell stopped %.0f ms after one device was isolated" % (1000 * (time.monotonic() - cut)))
        self.net.join("a")
        # If takt does not reach device a yet, devices b and c pass the command on to it.
        self.operator("undeploy", "stop_cell")
        wait_until(lambda: [d.get("state") for d in self.status().values()] == ["waiting"] * 3, "all devices to wait for a deployment")
        self.end(nodes)


class ACell(Readers, takt_system.Case):
    DEVICES = ("a", "b", "c")

    def begin(self):
        nodes = self.nodes(*self.DEVICES)
        self.deploy("stop_cell.xml")
        for device in ("b", "c"):
            self.wait_for(nodes[device], ("reader",), "LIVE", 0)
        return nodes

    def test_a_fault_of_a_stop_cell_module_stops_the_cell(self):
        nodes = self.begin()
        since = time.monotonic()
        self.done("set a.source how 2")
        for name, module in (("a", "source"), ("b", "reader"), ("c", "reader")):
            nodes[name].wait_for_state(module, "DESTRUCT")
        print("a cell stopped %.0f ms after one module was told to fail" % (1000 * (time.monotonic() - since)))
        nodes["a"].wait_for_line(r"module a\.source: error: it was given up: failure: it was told to")
        for other in ("b", "c"):
            nodes[other].wait_for_line(r"device %s: error: stops with its cell: .*module a\.source: error: it was given up" % other)
        self.assert_never_wrong(nodes["b"])
        undeployed = self.takt("undeploy", "stop_cell")
        self.assertRegex(undeployed.err, "module a.source: error: it was given up")
        self.end(nodes)

    def test_the_cell_stops_if_a_device_is_lost_whose_module_stops_the_cell_when_it_fails(self):
        nodes = self.begin()
        since = time.monotonic()
        nodes["a"].kill_all()
        for other in ("b", "c"):
            nodes[other].wait_for_state("reader", "DESTRUCT")
            nodes[other].wait_for_line(r"device (a: error: is lost, and one of its modules stops the cell when it fails|"
                                       r"%s: error: stops with its cell: device a: error: is lost)" % other)
        print("the other devices stopped %.0f ms after a node was killed" % (1000 * (time.monotonic() - since)))
        self.takt("undeploy", "stop_cell")
        self.end({d: nodes[d] for d in ("b", "c")})

    def test_the_loss_of_a_device_without_a_stop_cell_module_does_not_stop_the_cell(self):
        nodes = self.begin()
        nodes["b"].kill_all()
        time.sleep(2)
        self.wait_for_states({"a": "EXECUTING", "c": "EXECUTING"})
        self.takt("undeploy", "stop_cell")
        for device in ("a", "c"):
            self.assertNotIn("stops the cell", nodes[device].err)
            self.assertNotIn("stops with its cell", nodes[device].err)
        self.end({d: nodes[d] for d in ("a", "c")})


if __name__ == "__main__":
    takt_system.main()
