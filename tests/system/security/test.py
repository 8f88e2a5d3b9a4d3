"""Tests a cell with DDS Security in network namespaces, with strangers on the same network."""
import json
import mmap
import os
import re
import shutil
import signal
import struct
import subprocess
import sys
import time
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import networks
import takt_system
from shifted_clock import WallClock
from takt_system import BIN, Run, wait_until
from wear import taken_by

PEER = os.environ.get("TAKT_DDS_PEER", "")
CYCLONE = os.environ.get("TAKT_CYCLONE_PEER", "")
RACES = os.environ.get("TAKT_RACES_LIBRARY", "")
DEVICES = ("robot", "line")
# This program records all packets that pass the switch, and writes them to a file on SIGTERM.
SNIFF = r"""
import signal, socket, sys
ended = []
signal.signal(signal.SIGTERM, lambda *_: ended.append(1))
s = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.ntohs(3))
s.setsockopt(socket.SOL_SOCKET, 33, 1 << 26)  # SO_RCVBUFFORCE: no packet is lost while this process stalls
s.settimeout(0.1)
print("ready", flush=True)
seen = bytearray()
while not ended:
    try:
        seen += s.recv(65535)
    except socket.timeout:
        pass
open(sys.argv[1], "wb").write(seen)
"""


# Words of the descriptor and of states, which must not be readable (the names of topics may be).
WORDS = (b"quiet_sink", b"port_source.so", b"port_sink.so")
# The type samples::Count, as its component describes it.
SHAPE = {"name": "samples::Count", "fields": [{"name": "number", "type": "unsigned long long"}, {"name": "same", "type": "double", "unit": "mm",
                                               "array": [6]}, {"name": "few", "type": "unsigned long", "sequence": 4}]}

# Device robot reads a value of device line, and fails without it.
WATCHED = """<cell name="guarded" security="required">
  <device name="robot"><module><name>sink</name>
    <filename>port_sink.so</filename> <moduletype>thread</moduletype> <operationtype>periodic</operationtype>
    <period>10000000</period> <priority>1</priority> <recovery attempts="1000" backoff="100ms"/>
  </module></device>
  <device name="line"><module><name>source</name>
    <filename>port_source.so</filename> <moduletype>thread</moduletype> <operationtype>periodic</operationtype>
    <period>10000000</period> <priority>1</priority>
  </module></device>
  <connection from="line.source.out" to="robot.sink.in" deadline="1s" stale="error"/>
</cell>
"""


class Peer:
    """The program of the DDS tests, on one of the machines. The program ends when its standard input is closed."""

    def __init__(self, case, machine, *arguments, **environment):
        self._process = subprocess.Popen(
            case.net.on(machine) + [PEER, "0", *arguments], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
            stderr=subprocess.DEVNULL, env=dict(os.environ, PEER_INTERFACES="all", **environment))
        case.addCleanup(self.end)

    def line(self):
        """Returns the next line of the program. Skips its notices about participants that it rejected."""
        while True:
            line = self._process.stdout.readline()
            if not line.startswith("notice "):
                return line.rstrip("\n")

    def ask(self):
        """Lets the program send a command, and returns the answer."""
        self._process.stdin.write("send\n")
        self._process.stdin.flush()
        return self.line()

    def end(self):
        if self._process.poll() is None:
            self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            pipe.close()


class Security(takt_system.Case):
    def setUp(self):
        super().setUp()
        reason = networks.available()
        if reason:
            self.skipTest(reason)
        self.net = networks.Networks(*DEVICES, "operator", "stranger")
        self.net.__enter__()
        self.addCleanup(self.net.__exit__)
        # The programs use all interfaces, not only loopback, because the network belongs to this test.
        self.environment = {"TAKT_DOMAIN": "0", "TAKT_INTERFACE": ""}
        self.keys = os.path.join(self.folder, "keys")
        run = self.secure("init", self.beside("cell.xml"), "keys", "--operator", "anna", "--observer", "eve")
        self.assertIn("cell guarded, domain 0", run.out)

    def secure(self, *arguments):
        run = self.takt("secure", *arguments, environment=self.environment)
        self.assertEqual(0, run.status, run.err)
        return run

    def node(self, device, folder=None, machine=None, wait=True, options=()):
        folder = os.path.join(self.keys, "devices", device) if folder is None else folder
        security = ["--security", folder] if folder else []
        run = Run([os.path.join(BIN, "takt-node"), "--device", device, "--state-dir", os.path.join(self.folder, device),
                   *security, *options], self.folder, environment=self.environment, before=self.net.on(machine or device))
        self.runs.append(run)
        if wait:
            run.wait_for_line("waits for a deployment")
        return run

    def started(self, **options):
        return {device: self.node(device, **options) for device in DEVICES}

    def as_one(self, who, *arguments, machine="operator"):
        """Runs takt with the identity in this folder of the authority ("operators/anna"), in another folder, or without one ("")."""
        environment = dict(self.environment, TAKT_SECURITY=who and os.path.join(self.keys, who))
        return self.start(*arguments, environment=environment, before=self.net.on(machine)).wait()

    def deploy(self, cell="cell.xml"):
        self.agreed(lambda: self.as_one("operators/anna", "deploy", cell))

    def undeploy(self, who):
        """Undeploys the cell. Repeats the command if the machine stalled for longer than a lease: then the first command was carried out, but
        its reply was lost."""
        for _ in range(3):
            run = self.as_one(who, "undeploy", "guarded")
            if "was lost before it answered" not in run.err:
                break
        self.assertEqual(0, run.status, run.err)

    def end(self, nodes):
        for node in nodes.values():
            node.signal(signal.SIGTERM)
        for node in nodes.values():
            self.assertEqual(0, node.wait().status, node.err)

    def states(self, who="operators/anna"):
        run = self.as_one(who, "status", "--json")
        self.assertEqual(0, run.status, run.err)
        return {m["name"]: m["state"] for d in run.report["devices"] for m in d["modules"]}

    def sniff(self):
        path = os.path.join(self.folder, "seen")
        process = subprocess.Popen(["ip", "netns", "exec", self.net._bridge, sys.executable, "-c", SNIFF, path],
                                   stdout=subprocess.PIPE)
        self.addCleanup(process.kill)
        self.assertEqual(b"ready\n", process.stdout.readline())

        def seen():
            process.terminate()
            process.wait()
            process.stdout.close()
            with open(path, "rb") as file:
                return file.read()
        return seen

    def test_an_observer_cannot_force_an_input_and_the_node_names_the_operator_who_does(self):
        cell = self.write("watched.xml", WATCHED)
        self.secure("update", "keys", cell)
        nodes = self.started()
        self.deploy(cell)
        force = self.as_one("observers/eve", "force", "robot.sink.in", "number=1", "--for", "60")
        self.assertEqual(1, force.status, force.out)
        self.assertIn("observer eve at 10.77.0.3 may only observe, not force", force.err)
        force = self.start("force", "robot.sink.in", "number=1", "--for", "3600", before=self.net.on("operator"),
                           environment=dict(self.environment, TAKT_SECURITY=os.path.join(self.keys, "operators/anna")))
        wait_until(lambda: "is forced to" in force.out or force.status is not None, "the force")
        seen = self.as_one("observers/eve", "force")
        self.assertRegex(seen.out, r"robot\.sink\.in +operator anna at 10\.77\.0\.3", seen.err)
        end = self.as_one("observers/eve", "force", "--end", "robot.sink.in")
        self.assertEqual(1, end.status, end.out)
        self.assertIn("observer eve at 10.77.0.3 may only observe, not end the force", end.err)
        force.signal(signal.SIGINT)
        self.assertEqual(0, force.wait().status, force.err)
        log = self.as_one("observers/eve", "log", "--json", "--kind", "forced,force-ended")
        causes = [json.loads(line)["cause"] for line in log.out.splitlines()]
        self.assertEqual(2, len(causes), log.out + log.err)
        self.assertTrue(causes[0].endswith("for at most 3600 s, by operator anna at 10.77.0.3"), causes)
        self.assertTrue(causes[1].endswith(": operator anna at 10.77.0.3 ended it"), causes)
        self.undeploy("operators/anna")
        self.end(nodes)

    def test_the_network_traffic_of_a_secured_cell_is_unreadable(self):
        sniffed = self.sniff()
        nodes = self.started()
        self.assertIn("security is on: device robot of cell guarded", nodes["robot"].err)
        self.deploy()
        wait_until(lambda: self.states() == {"plainly_visible": "EXECUTING", "quiet_sink": "EXECUTING"}, "both modules")
        echo = self.as_one("operators/anna", "echo", "robot.plainly_visible.out", "--count", "3")
        self.assertEqual((0, 3), (echo.status, len(echo.out.splitlines())), echo.err)
        # An observer can read everything and change nothing.
        wait_until(lambda: self.states("observers/eve") == {"plainly_visible": "EXECUTING", "quiet_sink": "EXECUTING"}, "both modules")
        echo = self.as_one("observers/eve", "echo", "robot.plainly_visible.out", "--count", "3")
        self.assertEqual((0, 3), (echo.status, len(echo.out.splitlines())), echo.err)
        stop = self.as_one("observers/eve", "stop", "robot.plainly_visible")
        self.assertEqual(1, stop.status)
        self.assertIn("observer eve at 10.77.0.3 may only observe, not stop", stop.err)
        nodes["robot"].wait_for_line("rejected: observer eve at 10.77.0.3 asked to stop, which only an operator may do")
        update = self.as_one("observers/eve", "deploy", "--update", "cell.xml")
        self.assertEqual(1, update.status)
        self.assertEqual(len(DEVICES), update.err.count("observer eve at 10.77.0.3 may only observe, not"), update.err)
        call = self.as_one("observers/eve", "call", "robot.plainly_visible.none")
        self.assertEqual(1, call.status)
        self.assertRegex(call.err, "observers/eve: error: observer eve may only observe, not call; give the identity folder of an operator")
        undeploy = self.as_one("observers/eve", "undeploy", "guarded")
        self.assertEqual(1, undeploy.status, undeploy.err)
        wait_until(lambda: self.states() == {"plainly_visible": "EXECUTING", "quiet_sink": "EXECUTING"}, "both modules")

        stop = self.as_one("operators/anna", "stop", "robot.plainly_visible")
        self.assertEqual(0, stop.status, stop.err)
        self.undeploy("operators/anna")
        self.end(nodes)
        seen = json.loads(self.read("sink"))
        self.assertGreater(seen["read"], 10, "samples of robot must arrive")
        self.assertEqual(0, seen["wrong"])
        seen = sniffed()
        self.assertGreater(len(seen), 50000, "the traffic must have been recorded")
        # The names of topics are readable, because participants exchange their permissions in the clear when they meet.
        for secret in WORDS:
            self.assertEqual(0, seen.count(secret), secret)

    def test_the_network_traffic_of_a_cell_without_security_is_readable(self):
        """Shows that the test of a secured cell would find these words if they were readable."""
        with open(self.beside("cell.xml")) as file:
            text = file.read()
        plain = self.write("plain.xml", text.replace(' security="required"', ""))
        sniffed = self.sniff()
        nodes = self.started(folder="")
        for node in nodes.values():
            self.assertIn("security is off: anyone on its network can command this device and read its data", node.err)
        refused = self.as_one("", "deploy", "cell.xml")
        self.assertEqual(1, refused.status)
        self.assertIn("cell guarded requires security, but the node of device robot runs without it", refused.err)
        run = self.as_one("", "deploy", plain)
        self.assertEqual(0, run.status, run.err)
        self.undeploy("")
        self.end(nodes)
        seen = sniffed()
        for word in WORDS:
            self.assertGreater(seen.count(word), 0, word)

    def test_a_cell_rejects_participants_without_an_identity_of_the_cell(self):
        self.takt("secure", "init", self.beside("cell.xml"), "evil", "--operator", "anna", environment=self.environment)
        nodes = self.started()
        self.deploy()
        line = nodes["line"]

        # The participants without an identity are takt, a program of Fast DDS, and a program of Cyclone DDS.
        run = self.as_one("", "stop", "line.quiet_sink", machine="stranger")
        self.assertEqual(1, run.status)
        self.assertIn("not found: no answer", run.err)
        line.wait_for_line("rejected: participant 'takt' at 10.77.0.4 has no identity of this cell")
        plain = Peer(self, "stranger", "stop", "line")
        self.assertEqual("no answer", plain.line())
        line.wait_for_line("rejected: participant 'peer' at 10.77.0.4 has no identity of this cell")
        if CYCLONE:
            cyclone = subprocess.run(self.net.on("stranger") + [CYCLONE, "0", "command", "line", "quiet_sink", "8"],
                                     capture_output=True, timeout=takt_system.LONG,
                                     env=dict(os.environ, CYCLONEDDS_URI="<CycloneDDS><Domain id='any'><General>"
                                              "<AllowMulticast>true</AllowMulticast></General></Domain></CycloneDDS>"))
            self.assertNotEqual(0, cyclone.returncode, cyclone.stdout)

        # This identity has the name of the operator, but another authority issued it.
        run = self.as_one(os.path.join(self.folder, "evil", "operators", "anna"), "stop", "line.quiet_sink", machine="stranger")
        self.assertEqual(1, run.status)
        line.wait_for_line("rejected: operator anna at 10.77.0.4: its identity was issued by another authority")
        self.assertEqual({"plainly_visible": "EXECUTING", "quiet_sink": "EXECUTING"}, self.states())
        self.assertEqual(1, sum("'takt' at 10.77.0.4" in text for text in line.raw), "each participant must be reported once")
        self.end(nodes)

    def test_members_of_a_cell_cannot_exceed_their_permissions(self):
        nodes = self.started()
        self.deploy()
        robot, line = nodes["robot"], nodes["line"]
        identity = lambda path: os.path.join(self.keys, path)

        # A program with the identity of device line publishes the status of device robot, in a cell named "test".
        impostor = Peer(self, "stranger", "device", "robot", PEER_SECURITY=identity("devices/line"))
        self.assertEqual("ready", impostor.line())
        robot.wait_for_line("rejected: device line at 10.77.0.4 publishes on takt/device for test/robot, but may publish only for itself")
        impostor.end()

        # A program with the identity of device line tries to write a topic of device robot. Fast DDS in this program prevents this. If a
        # manipulated program writes nevertheless, the other participants ignore its samples.
        shape = self.write("type.json", json.dumps(SHAPE))
        topic = "takt/guarded/robot/plainly_visible/out"
        wanted = "rejected: device line at 10.77.0.4 writes %s without permission" % topic
        honest = Peer(self, "stranger", "give", topic, "reliable", "32", shape, PEER_SECURITY=identity("devices/line"))
        self.assertNotEqual("ready", honest.line())
        honest.end()
        self.assertNotIn(wanted, line.err)
        cheat = Peer(self, "stranger", "give", topic, "reliable", "32", shape, PEER_SECURITY=identity("devices/line"), PEER_CHEATS="1")
        self.assertEqual("ready", cheat.line())
        line.wait_for_line(wanted)

        # A manipulated program of an observer writes commands.
        forge = Peer(self, "stranger", "forge", "takt/command", "takt::Command", "plain", "1", "00" * 64,
                     PEER_SECURITY=identity("observers/eve"), PEER_CHEATS="1")
        robot.wait_for_line("rejected: observer eve at 10.77.0.4 writes takt/command without permission")
        forge.end()
        self.assertEqual({"plainly_visible": "EXECUTING", "quiet_sink": "EXECUTING"}, self.states())
        self.end(nodes)

    def test_repeated_commands_do_not_leak_memory_or_open_files_in_a_node(self):
        nodes = self.started()
        self.deploy()
        ask = lambda: self.assertEqual(0, self.as_one("operators/anna", "status").status)
        for _ in range(10):
            ask()
        line = nodes["line"].one("takt-node").pid
        before = taken_by(line)
        for _ in range(40):
            ask()
        after = taken_by(line)
        print("40 commands: from %s to %s" % (before, after))
        self.assertLess(after["rss_kib"] - before["rss_kib"], 2000, "Fast DDS by itself keeps 115 KiB for each command")
        self.assertEqual(before["files"], after["files"])
        self.end(nodes)

    def test_nodes_started_after_a_revocation_reject_the_revoked_identity(self):
        shutil.copytree(os.path.join(self.keys, "operators", "anna"), os.path.join(self.folder, "stolen"))
        self.secure("add", "keys", "operator", "bert")
        run = self.secure("revoke", "keys", "anna")
        self.assertRegex(run.out, r"operator +anna +revoked")
        own = self.as_one("operators/anna", "status")
        self.assertEqual(1, own.status)
        self.assertIn("it was revoked", own.err)
        nodes = self.started()
        run = self.as_one(os.path.join(self.folder, "stolen"), "status", machine="stranger")
        self.assertEqual(1, run.status)
        nodes["robot"].wait_for_line("rejected: operator anna at 10.77.0.4: its identity was revoked")
        self.assertEqual(0, self.as_one("operators/bert", "status").status)
        # Given the whole folder, takt uses the first valid identity.
        whole = self.as_one(".", "status")
        self.assertEqual(0, whole.status, whole.err)
        self.assertRegex(whole.err, r"anna/identity.cert.pem: it was revoked\nusing the identity of operator bert instead")
        self.end(nodes)

    def test_running_nodes_reject_an_identity_as_soon_as_it_is_revoked(self):
        self.secure("add", "keys", "operator", "bert")
        stolen = os.path.join(self.folder, "stolen")
        shutil.copytree(os.path.join(self.keys, "operators", "bert"), stolen)
        nodes = self.started()
        robot = nodes["robot"]
        self.deploy()
        bert = Peer(self, "stranger", "ask", "robot", PEER_SECURITY=stolen)
        self.assertEqual("ready", bert.line())
        self.assertIn("no module", bert.ask())
        self.secure("revoke", "keys", "bert")
        rejected = r"rejected: operator bert at 10\.77\.0\.4: its identity is no longer accepted: it was revoked; to accept it again, run takt secure"
        for node in nodes.values():
            node.wait_for_line(rejected)
        self.assertEqual("no answer", bert.ask())
        bert.end()
        # A new process with this identity authenticates, because Fast DDS knows only the earlier list. It is rejected nevertheless.
        seen = len(robot.raw)
        again = Peer(self, "stranger", "ask", "robot", PEER_SECURITY=stolen)
        self.assertEqual("ready", again.line())
        self.assertEqual("no answer", again.ask())
        robot.wait_for_line(rejected, after=seen)
        with open(os.path.join(self.keys, "devices", "robot", "crl.pem"), "w") as file:
            file.write("nothing")
        robot.wait_for_line(r"warning: .*crl\.pem: it is not a list that the authority of this identity has signed, so the earlier list applies")
        self.assertEqual({"plainly_visible": "EXECUTING", "quiet_sink": "EXECUTING"}, self.states())
        self.end(nodes)

    def test_takt_commands_reject_an_identity_of_the_wrong_kind(self):
        run = self.as_one("devices/line", "stop", "robot.plainly_visible")
        self.assertEqual(1, run.status)
        self.assertRegex(run.err, r"^\S+keys/devices/line: error: this is the identity of device line, not of an operator or observer; "
                                  r"give the identity folder of an operator or observer, such as DIR/operators/NAME$")
        self.refused({"secure add keys program mes": "cell guarded has no topics for programs outside Takt: each connection has two ends in the cell; remove",
                      "sign cell.xml --key keys/operators/anna": "keys/operators/anna: error: this is the identity of one participant, not an "
                      "authority; its authority is in .*keys$"})
        self.assertFalse(os.path.exists(os.path.join(self.keys, "programs")))

    def test_takt_secure_update_warns_about_a_device_removed_from_the_cell(self):
        with open(self.beside("cell.xml")) as file:
            text = file.read()
        self.assertNotIn("no longer in the cell", self.secure("update", "keys", self.beside("cell.xml")).err)
        less = self.write("less.xml", re.sub(r'(?s)<device name="line">.*</device>|<connection.*?/>', "", text))
        update = self.secure("update", "keys", less)
        self.assertIn("device line is no longer in the cell, but its identity is still valid; "
                      "use takt secure revoke keys line to revoke it", update.err)
        self.secure("revoke", "keys", "line")
        self.assertEqual("", self.secure("update", "keys", less).err)

    def test_a_node_does_not_start_with_missing_exposed_or_wrong_identity_files(self):
        folder = os.path.join(self.keys, "devices", "robot")

        def refused(pattern, **options):
            run = self.node("robot", wait=False, **options).wait()
            self.assertEqual(1, run.status, run.err)
            self.assertRegex(run.err, pattern)

        key = os.path.join(folder, "identity.key.pem")
        self.assertEqual(0o600, os.stat(key).st_mode & 0o777)
        self.assertEqual(0o700, os.stat(folder).st_mode & 0o777)
        os.chmod(key, 0o640)
        refused("other users may read or write this private key; run chmod 600 .*identity.key.pem")
        os.chmod(key, 0o600)
        os.rename(key, key + ".away")
        refused("identity.key.pem: error: there is no such file")
        os.rename(key + ".away", key)
        refused("this is the identity of device line, not of device robot", folder=os.path.join(self.keys, "devices", "line"))
        refused("not of device robot", folder=os.path.join(self.keys, "operators", "anna"))
        refused("this identity is for domain 0, not for domain 5", options=["--domain", "5"])
        refused("exclude each other", options=["--server", "127.0.0.1:11811"])
        refused("there is no such folder", folder=os.path.join(self.keys, "devices", "nobody"))

        again = self.takt("secure", "init", "cell.xml", "keys", environment=self.environment)
        self.assertEqual(1, again.status)
        self.assertIn("an authority already exists", again.err)

    def test_a_node_warns_about_an_identity_that_expires_soon(self):
        run = self.secure("renew", "keys", "robot", "--days", "10")
        self.assertRegex(run.out, r"device +robot .*it expires in (9|10) days")
        robot = self.node("robot")
        self.assertRegex(robot.err, r"warning: its identity must be renewed: it expires in (9|10) days; run takt secure renew")
        self.end({"robot": robot})
        doctor = self.takt("doctor", "--json", environment={"TAKT_SECURITY": os.path.join(self.keys, "devices", "robot")})
        finding = next(f for f in doctor.report["findings"] if f["check"] == "security")
        self.assertEqual("note", finding["severity"])
        self.assertRegex(finding["found"], r"is on: CN=robot,OU=device,O=guarded; it expires in (9|10) days")
        doctor = self.takt("doctor", "--json", environment={"TAKT_SECURITY": ""})
        finding = next(f for f in doctor.report["findings"] if f["check"] == "security")
        self.assertRegex(finding["found"], "is off")

    def device(self, name):
        """Returns what takt status shows about a device."""
        run = self.as_one("operators/anna", "status", "--json")
        self.assertEqual(0, run.status, run.err)
        return next(d for d in run.report["devices"] if d["name"] == name)

    def test_a_running_cell_rejects_an_identity_that_expires(self):
        cell = self.write("watched.xml", WATCHED)
        self.secure("update", "keys", cell)
        self.secure("add", "keys", "operator", "bert", "--days", "10")
        self.secure("renew", "keys", "line", "--days", "10")
        clock = WallClock(os.path.join(self.folder, "clock"))
        self.environment.update(clock.environment)
        nodes = self.started()
        robot, line = nodes["robot"], nodes["line"]
        self.deploy(cell)
        wait_until(lambda: self.states() == {"source": "EXECUTING", "sink": "EXECUTING"}, "both modules")
        # The clock of this operator is never set, as that of an attacker who has stolen the identity.
        bert = Peer(self, "stranger", "ask", "robot", PEER_SECURITY=os.path.join(self.keys, "operators", "bert"))
        self.assertEqual("ready", bert.line())
        self.assertIn("no module", bert.ask())
        clock.set_by(11 * 24 * 3600)

        when = r"it expired on \d{4}-\d\d-\d\d at \d\d:\d\d:\d\d UTC"
        why = r"its identity is no longer accepted: %s; run takt secure renew DIR %s, copy its folder again and restart it"
        robot.wait_for_line(r"rejected: device line at 10\.77\.0\.2: " + why % (when, "line"))
        robot.wait_for_line(r"rejected: operator bert at 10\.77\.0\.4: " + why % (when, "bert"))
        line.wait_for_line(r"warning: its identity must be renewed: %s; the other participants of the cell reject this node until it is "
                           r"started again with a new one; run takt secure renew DIR line, copy" % when)
        self.assertEqual("no answer", bert.ask())
        robot.wait_for_line("device line is lost: " + why % (when, "line"))
        robot.wait_for_line(r"sink: EXECUTING -> RECOVER")
        wait_until(lambda: not self.device("line")["alive"], "line to be shown as lost")
        self.assertRegex(self.device("line")["text"], why % (when, "line"))
        stop = self.as_one("operators/anna", "stop", "line.source")
        self.assertEqual(1, stop.status)
        self.assertRegex(stop.err, "device line: error: it is lost: " + why % (when, "line"))
        self.assertRegex(self.as_one("operators/anna", "log", "robot").out, "rejected: device line at 10.77.0.2: its identity is no longer")
        self.assertEqual(1, sum("rejected: device line" in text for text in robot.raw), "it must be reported once")

        doctor = self.takt("doctor", "--json", environment=dict(self.environment, TAKT_SECURITY=os.path.join(self.keys, "devices", "line")))
        finding = next(f for f in doctor.report["findings"] if f["check"] == "security")
        self.assertRegex(finding["found"], "the identity in TAKT_SECURITY is rejected: .*it has expired")
        self.secure("renew", "keys")
        line.signal(signal.SIGTERM)
        line.wait()
        nodes["line"] = self.node("line", options=["--resume"])
        robot.wait_for_line("device line is back")
        wait_until(lambda: self.states() == {"source": "EXECUTING", "sink": "EXECUTING"}, "both modules")
        self.end(nodes)

    def test_takt_run_can_secure_a_cell_with_the_keys_in_one_folder(self):
        run = self.start("run", "cell.xml", "--for", "2", "--security", "keys", environment=self.environment,
                         before=self.net.on("operator")).wait()
        self.assertEqual(0, run.status, run.err)
        self.assertIn("security is on: device line of cell guarded", run.err)


class Components(takt_system.Case):
    """A node loads components as code, so it checks who can change them."""

    def setUp(self):
        super().setUp()
        self.components = os.path.join(self.folder, "components")
        os.mkdir(self.components, 0o755)
        shutil.copy(self.built("fine.so"), os.path.join(self.components, "mine.so"))
        self.file = os.path.join(self.components, "mine.so")
        os.chmod(self.file, 0o755)
        self.cell = self.write("cell.xml", """<cell name="c"><device name="d"><module>
          <filename>mine.so</filename> <moduletype>thread</moduletype> <operationtype>periodic</operationtype>
          <period>10000000</period> <priority>1</priority></module></device></cell>""")
        self.environment = {"TAKT_COMPONENT_PATH": self.components}

    @staticmethod
    def built(name):
        return next(p for p in (os.path.join(f, name) for f in os.environ["TAKT_COMPONENT_PATH"].split(":")) if os.path.exists(p))

    def try_it(self, **more):
        runs = [self.start(*command, environment=dict(self.environment, **more))
                for command in (("check", self.cell), ("run", self.cell, "--for", "1"))]
        for run in runs:
            run.wait()
        self.assertEqual(1, len({run.status for run in runs}), [run.err for run in runs])
        return runs[0].status, runs[0].err + runs[1].err

    def test_takt_rejects_components_that_every_user_may_overwrite(self):
        self.assertEqual(0, self.try_it()[0])
        os.chmod(self.file, 0o757)
        status, said = self.try_it()
        self.assertEqual(1, status)
        self.assertIn("everybody may write to %s (owner root, mode 0757); run chmod o-w %s" % (self.file, self.file), said)
        os.chmod(self.file, 0o755)
        os.chmod(self.components, 0o777)
        self.assertIn("everybody may write to %s (owner root, mode 0777); run chmod o-w %s" % (self.components, self.components),
                      self.try_it()[1])

    @unittest.skipUnless(os.getuid() == 0, "only root can give files to other users")
    def test_takt_accepts_components_of_the_user_who_owns_the_folder_of_takt(self):
        os.chown(self.components, 12345, -1)
        self.assertIn("%s belongs to user 12345, who can replace it" % self.components, self.try_it()[1])
        copies = os.path.join(self.folder, "bin")
        os.mkdir(copies)
        for name in ("takt", "takt-host"):
            shutil.copy(os.path.join(takt_system.BIN, name), copies)
        os.chown(copies, 12345, -1)
        run = self.program("takt", "check", self.cell, programs=copies, environment=self.environment).wait()
        self.assertEqual(0, run.status, run.err)

    def test_takt_rejects_unsigned_components_if_signatures_are_required(self):
        self.assertEqual(0, self.takt("secure", "init", self.cell, "keys").status)
        signed = self.takt("sign", self.file, "--key", "keys")
        self.assertEqual(0, signed.status, signed.err)
        certificate = os.path.join(self.folder, "keys", "authority", "components.cert.pem")
        self.assertIn("1 signed", signed.out)
        self.assertEqual((0, ""), self.try_it(TAKT_SIGNED_BY=certificate)[:1] + ("",))
        # openssl can verify the signature without Takt.
        public = subprocess.run(["openssl", "x509", "-in", certificate, "-pubkey", "-noout"], capture_output=True, check=True).stdout
        self.write("public.pem", public.decode())
        subprocess.run(["openssl", "dgst", "-sha256", "-verify", os.path.join(self.folder, "public.pem"), "-signature",
                        self.file + ".sig", self.file], check=True, capture_output=True)

        with open(self.file, "ab") as file:
            file.write(b"x")
        status, said = self.try_it(TAKT_SIGNED_BY=certificate)
        self.assertEqual(1, status)
        self.assertIn("its signature does not match its contents", said)
        os.remove(self.file + ".sig")
        self.assertIn("it is not signed, and only signed components are accepted here", self.try_it(TAKT_SIGNED_BY=certificate)[1])
        self.assertEqual(0, self.try_it()[0], "no signature is required")
        # A certificate in the folder of the device makes its node require signatures.
        self.assertEqual(0, self.takt("sign", self.file, "--key", "keys").status)
        shutil.copy(certificate, os.path.join(self.folder, "keys", "devices", "d"))
        run = self.takt("run", self.cell, "--for", "1", "--security", "keys", environment=self.environment)
        self.assertEqual(0, run.status, run.err)
        os.remove(self.file + ".sig")
        run = self.takt("run", self.cell, "--for", "1", "--security", "keys", environment=self.environment)
        self.assertEqual(1, run.status)
        self.assertIn("it is not signed", run.err)

    def replace(self, name, by):
        """Replaces a component, as an attacker would: the signature stays."""
        path = os.path.join(self.components, name)
        shutil.copy(by, path + ".new")
        os.chmod(path + ".new", 0o755)
        os.replace(path + ".new", path)

    def running(self, modules):
        """Deploys the signed modules to device d, whose node requires signatures, and returns the node."""
        for name in modules:
            if not os.path.exists(os.path.join(self.components, name)):
                self.replace(name, self.built(name))
        cell = self.write("cell.xml", '<cell name="c"><device name="d">%s</device></cell>' % "".join(
            """<module><name>%s</name><filename>%s</filename><moduletype>%s</moduletype><operationtype>periodic</operationtype>
            <period>10000000</period><priority>1</priority></module>""" % (
                name.replace(".", "_"), name, "process" if name.endswith(".exe") else "thread") for name in modules))
        self.done("secure init %s keys" % cell)
        self.done("sign %s --key keys" % " ".join(os.path.join(self.components, name) for name in modules))
        self.environment["TAKT_SIGNED_BY"] = os.path.join(self.folder, "keys", "authority", "components.cert.pem")
        node = self.node("d", environment=self.environment)
        self.deploy(cell)
        return node

    UNSIGNED = r"%s: its signature does not match its contents, or was not made with the key of "

    def test_a_component_replaced_after_the_deployment_is_not_loaded_at_a_reset(self):
        node = self.running(["mine.so"])
        self.replace("mine.so", self.built("leaves.so"))
        self.done("destruct d.mine_so")
        self.refused({"reset d.mine_so": self.UNSIGNED % re.escape(self.file)})
        self.assertEqual({"mine_so": "DESTRUCT"}, self.states_of("d"))
        self.replace("mine.so", self.built("fine.so"))
        for verb in ("reset", "initialize", "start"):
            self.done(verb + " d.mine_so")
        self.wait_for_states({"d": "EXECUTING"})
        self.end({"d": node})

    def test_a_restarted_host_loads_the_signed_component_that_was_deployed_even_if_its_file_is_replaced(self):
        node = self.running(["mine.so", "grid.so"])
        self.wait_for_states({"d": "EXECUTING"})
        self.replace("mine.so", self.built("leaves.so"))
        os.kill(node.one("takt-host").pid, signal.SIGKILL)
        wait_until(lambda: [s.target for s in node.steps("mine_so")].count("EXECUTING") == 2, "the module to run in the new host")
        self.assertNotIn("its signature does not match", node.err)
        self.wait_for_states({"d": "EXECUTING"})
        self.end({"d": node})

    def test_a_program_replaced_after_the_deployment_is_not_started_at_a_recovery(self):
        node = self.running(["mine.so", "fine.exe"])
        self.wait_for_states({"d": "EXECUTING"})
        program = os.path.join(self.components, "fine.exe")
        self.replace("fine.exe", self.write("evil", "#!/bin/sh\ntouch %s\n" % os.path.join(self.folder, "executed")))
        os.kill(next(m["pid"] for m in self.status_of("d")["modules"] if m["name"] == "fine_exe"), signal.SIGKILL)
        self.wait_for_states({"d": {"mine_so": "EXECUTING", "fine_exe": "DESTRUCT"}})
        self.assertRegex(node.err, self.UNSIGNED % re.escape(program))
        self.assertFalse(os.path.exists(os.path.join(self.folder, "executed")))
        self.end({"d": node})

    def test_a_restarted_node_does_not_resume_a_cell_with_a_replaced_component(self):
        node = self.running(["mine.so"])
        self.replace("mine.so", self.built("leaves.so"))
        os.kill(node.pid, signal.SIGKILL)
        node.wait()
        again = self.node("d", "--resume", environment=self.environment)
        again.wait_for_line(self.UNSIGNED % re.escape(self.file))
        self.assertEqual({}, self.states_of("d"))
        self.end({"d": again})

    def race(self):
        """Lets an attacker win the races for the files of the components (races.c). Returns a function that sets how many more times Takt
        finds them before it finds the attacker's files, and returns how many times are left."""
        evil = os.path.join(self.folder, "evil")
        shutil.copytree(self.components, evil)
        shutil.copy(self.built("intruder.so"), os.path.join(evil, "mine.so"))
        mark = os.path.join(self.folder, "intruded")
        program = os.path.join(evil, "fine.exe")
        with open(program, "w") as file:
            file.write("#!/bin/sh\ntouch %s\n" % mark)
        os.chmod(program, 0o755)
        word = os.path.join(self.folder, "race")
        with open(word, "wb") as file:
            file.write(struct.pack("<q", 1 << 40))
        with open(word, "r+b") as file:
            memory = mmap.mmap(file.fileno(), 8)
        self.environment.update(LD_PRELOAD=RACES, TAKT_RACE=word, TAKT_RACE_FOLDER=self.components + "/", TAKT_RACE_OTHER=evil + "/",
                                TAKT_INTRUDER=mark)

        def times(number=None):
            before = struct.unpack("<q", memory[:8])[0]
            if number is not None:
                memory[:8] = struct.pack("<q", number)
            return before
        self.intruded = lambda: os.path.exists(mark)
        return times

    def lose_every_race(self, times, step, repair=lambda: None):
        """Carries out a step, in which the attacker replaces the components before the first use of their files, before the second use, and so
        on, until the step uses no file any more."""
        for number in range(30):
            times(number)
            step()
            left = times(1 << 40)
            self.assertFalse(self.intruded(), "the files were replaced after %d uses" % number)
            repair()
            if left > 0:
                return number
        self.fail("the step uses files again and again")

    def raced_node(self):
        """Starts a node with two signed components that an attacker replaces. Returns the node and the function of race()."""
        self.end({"d": self.running(["mine.so", "fine.exe"])})
        times = self.race()
        return self.node("d", environment=self.environment), times

    def lost(self, uses):
        print("uses of the files of two components: %s" % uses)
        for step, number in uses.items():
            self.assertGreater(number, 1, step + " does not use the files, so it is no test")

    def test_an_attacker_who_replaces_signed_components_during_a_check_or_deployment_cannot_run_code(self):
        node, times = self.raced_node()
        takt = lambda *words: lambda: self.takt(*words, environment=self.environment)
        self.lost({"check": self.lose_every_race(times, takt("check", self.cell)),
                   "describe .so": self.lose_every_race(times, takt("describe", self.file)),
                   "describe .exe": self.lose_every_race(times, takt("describe", os.path.join(self.components, "fine.exe"))),
                   "deploy": self.lose_every_race(times, lambda: self.takt("deploy", self.cell), lambda: self.takt("undeploy", "c"))})
        self.end({"d": node})

    def test_an_attacker_who_replaces_signed_components_during_a_restart_or_swap_cannot_run_code(self):
        node, times = self.raced_node()
        self.deploy(self.cell)
        self.wait_for_states({"d": "EXECUTING"})
        reset = lambda: self.takt("restart", "d.mine_so")
        uses = {"reset": self.lose_every_race(times, reset, reset),
                "swap": self.lose_every_race(times, lambda: self.takt("swap", "d.mine_so", "mine.so"))}

        def crash():
            starts = len(node.steps("fine_exe"))
            os.kill(next(m["pid"] for m in self.status_of("d")["modules"] if m["name"] == "fine_exe"), signal.SIGKILL)
            wait_until(lambda: {s.target for s in node.steps("fine_exe")[starts:]} & {"EXECUTING", "DESTRUCT"}, "the recovery of the program")

        def restart():
            self.done("restart d.fine_exe")
            self.wait_for_states({"d": "EXECUTING"})
        uses["recovery"] = self.lose_every_race(times, crash, restart)
        self.lost(uses)

        times(0)  # a new host loads the copy that was checked at the deployment
        steps = len(node.steps("mine_so"))
        os.kill(node.one("takt-host").pid, signal.SIGKILL)
        wait_until(lambda: "EXECUTING" in [s.target for s in node.steps("mine_so")[steps:]], "the module to run in the new host")
        self.assertFalse(self.intruded())
        times(1 << 40)
        self.end({"d": node})

    def test_an_attacker_who_replaces_signed_components_while_a_node_resumes_cannot_run_code(self):
        node, times = self.raced_node()
        nodes = [node]
        self.deploy(self.cell)

        def resume():
            nodes[0].signal(signal.SIGKILL)
            nodes[0].wait()
            nodes[0] = self.node("d", "--resume", environment=self.environment)
            nodes[0].wait_for_line("START -> EXECUTING|signature does not match")
        self.lost({"resume": self.lose_every_race(times, resume)})
        self.end({"d": nodes[0]})

    def test_the_attacker_of_the_races_runs_code_if_no_signature_is_required(self):
        """Shows that the test of signed components would notice the attacker."""
        self.replace("fine.exe", self.built("fine.exe"))
        times = self.race()
        times(0)
        self.takt("describe", self.file, environment=self.environment)
        self.assertTrue(self.intruded())
        os.remove(os.path.join(self.folder, "intruded"))
        self.takt("describe", os.path.join(self.components, "fine.exe"), environment=self.environment)
        self.assertTrue(self.intruded())

    def test_the_crash_of_a_signed_component_is_reported_with_its_source_line(self):
        node = self.running(["segv.so", "fine.exe"])
        node.wait_for_line(r"in run\(\), in \w.* at segv\.cpp:1\d in segv\.so")
        program = next(m for m in self.status_of("d")["modules"] if m["name"] == "fine_exe")
        with open("/proc/%d/cmdline" % program["pid"]) as file:
            self.assertEqual(os.path.join(self.components, "fine.exe"), file.read().split("\0")[0])
        self.end({"d": node})

    def test_takt_rejects_components_below_a_folder_that_every_user_may_write_to(self):
        inner = os.path.join(self.components, "inner")
        os.mkdir(inner)
        os.rename(self.file, os.path.join(inner, "mine.so"))
        self.environment["TAKT_COMPONENT_PATH"] = inner
        self.assertEqual(0, self.try_it()[0])
        os.chmod(self.components, 0o777)
        self.assertIn("everybody may write to %s (owner" % self.components, self.try_it()[1])
        link = os.path.join(self.folder, "link")
        os.symlink(inner, link)
        self.environment["TAKT_COMPONENT_PATH"] = link
        self.assertIn("run chmod o-w %s" % self.components, self.try_it()[1])
        os.chmod(self.components, 0o755)
        self.assertEqual(0, self.try_it()[0])

    def test_a_node_rejects_a_state_folder_that_every_user_may_write_to(self):
        state = os.path.join(self.folder, "state")
        os.mkdir(state)
        os.chmod(state, 0o777)
        node = self.program("takt-node", "--device", "d", "--resume").wait()
        self.assertEqual(1, node.status, node.err)
        self.assertIn("everybody may write to %s (owner root, mode 0777); run chmod o-w %s" % (state, state), node.err)
        os.chmod(state, 0o755)
        self.end({"d": self.node("d", "--resume")})

    def test_a_node_creates_its_state_folder_in_a_folder_where_others_may_create_files(self):
        shared = os.path.join(self.folder, "shared")
        os.mkdir(shared)
        os.chmod(shared, 0o1777)
        state = os.path.join(shared, "takt", "state")
        self.end({"d": self.node("d", "--resume", "--state-dir", state)})
        self.assertNotEqual([], os.listdir(state))

    def test_takt_reports_an_invalid_signing_certificate(self):
        other = self.write("other.pem", "nothing")
        for file, what in (("nosuch.pem", "there is no such file"), (other, "it is not a certificate")):
            self.assertIn("module mine: %s: %s; name the certificate that takt sign prints" % (file, what), self.try_it(TAKT_SIGNED_BY=file)[1])
            node = self.program("takt-node", "--device", "d", "--signed-by", file).wait()
            self.assertEqual(1, node.status, node.err)
            self.assertIn("%s: error: %s; name the certificate that takt sign prints" % (file, what), node.err)


if __name__ == "__main__":
    takt_system.main()
