"""Tests a cell in network namespaces while an attacker sends hostile packets to every open port.

TAKT_STORM_SECONDS: duration of each storm and of the quiet phase before it, in seconds (default 5; 20 with TAKT_TEST_FULL=1).
TAKT_STORM_RATE: packets per second (default 5000). TAKT_STORM_SEED: seed of the packets (default random; the test prints it)."""
import json
import os
import random
import signal
import struct
import subprocess
import sys
import time

sys.path[:0] = [os.path.dirname(os.path.abspath(__file__)), os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")]
import attack
import impostor
import networks
import takt_system
import wear
from takt_system import wait_until

DEVICES = ("robot", "line")
SECONDS = takt_system.how_much("TAKT_STORM_SECONDS", 5.0, 20.0)
RATE = float(os.environ.get("TAKT_STORM_RATE", "5000"))
SEED = int(os.environ.get("TAKT_STORM_SEED", random.randrange(10 ** 6)))
BUILTIN = 0x58  # the parameter with the readers and writers that a participant has for discovery
TYPE_LOOKUP = 0xF << 12  # those of them that exchange descriptions of types
TYPE_DESCRIPTIONS = {0x69, 0x72, 0x75}
ATTACK = os.path.join(os.path.dirname(os.path.abspath(__file__)), "attack.py")
IMPOSTOR = os.path.join(os.path.dirname(ATTACK), "impostor.py")
DDS_PORTS = (7400, 7401, 7410, 7411)
TCP_PORT = 1502


class Storm(networks.NetworkCase):
    MACHINES = (*DEVICES, "stranger")
    secured = False

    def setUp(self):
        super().setUp()
        with open(self.beside("cell.xml")) as file:
            text = file.read().replace("PORT", str(TCP_PORT))
        self.cell = self.write("harbour.xml", text.replace("SECURITY", 'security="required"' if self.secured else ""))
        self.identity, options = {}, {device: [] for device in DEVICES}
        if self.secured:
            self.order("secure", "init", self.cell, "keys", "--operator", "anna")
            keys = os.path.join(self.folder, "keys")
            self.identity = {"TAKT_SECURITY": os.path.join(keys, "operators", "anna")}
            options = {device: ["--security", os.path.join(keys, "devices", device)] for device in DEVICES}
        self.machines = {device: self.node(device, *options[device]) for device in DEVICES}

    def order(self, *arguments):
        """Runs a command, which must succeed. Altered copies of authentication packets can make the authentication of a new participant
        fail. So in a secured cell, this function repeats a command that found no node. Such a command has changed nothing."""
        for _ in range(3 if self.secured else 1):
            run = self.operator(*arguments, environment=self.identity)
            if "not found" not in run.err:
                break
            print("takt %s found no node and is repeated" % " ".join(arguments))
        self.assertEqual(0, run.status, "takt %s: %s" % (" ".join(arguments), run.err))
        return run

    def status(self):
        return {d["name"]: d for d in self.order("status", "--json").report["devices"]}

    def attack(self, machine, *arguments, wait=True):
        process = subprocess.Popen([*self.net.on(machine), sys.executable, "-B", ATTACK, *arguments], stdout=subprocess.PIPE, text=True)
        self.addCleanup(lambda: (process.kill(), process.wait(), process.stdout.close()))
        if not wait:
            return process
        out, _ = process.communicate(timeout=takt_system.LONG)
        self.assertEqual(0, process.returncode)
        return json.loads(out)

    def targets(self):
        """Returns every open port on the machines of the cell, and the multicast port of discovery."""
        targets = {"udp": [["239.255.0.1", 7400]], "tcp": [], "from": self.net.address("stranger")}
        for device in DEVICES:
            ports = self.attack(device, "ports")
            self.assertGreater(len(ports["udp"]), 1, device)
            for kind in ("udp", "tcp"):
                targets[kind] += [[self.net.address(device), port] for port in ports[kind]]
        self.assertEqual([[self.net.address("line"), TCP_PORT]], targets["tcp"])
        return targets

    def deploy(self):
        self.agreed(lambda: self.operator("deploy", self.cell, environment=self.identity))
        self.wait_until_all_execute()
        self.orders = 0
        self.hosts = {device: self.machines[device].one("takt-host").pid for device in DEVICES}

    def undeploy(self):
        """Undeploys the cell. Repeats the command if a machine stalled for longer than a lease, because then the
        first command or the reply to it may be lost."""
        for _ in range(3):
            run = self.operator("undeploy", "harbour", environment=self.identity)
            if run.status == 0:
                return
            self.assertRegex(run.err, "was lost before it answered|is lost and did not receive the command")
            print("takt undeploy is repeated: " + run.err)
        self.fail("no node answered to undeploy")

    def wait_until_all_execute(self):
        def holds():
            status = self.status()
            return {m["state"] for d in status.values() for m in d["modules"]} == {"EXECUTING"} and status
        return wait_until(holds, "every module to execute")

    def stop_and_start(self):
        for verb, state in (("stop", "START"), ("start", "EXECUTING")):
            began = time.monotonic()
            self.order(verb, "robot.source")
            self.slowest = max(self.slowest, time.monotonic() - began)
            self.machines["robot"].wait_for_state("source", state)
        self.orders += 1

    def hold(self, seconds):
        """Stops and starts the module of the loop about once a second, for `seconds` seconds."""
        self.slowest = 0.0
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.stop_and_start()
            time.sleep(min(1.0, max(0.0, end - time.monotonic())))

    def read_back(self, what):
        """Prints the jitter and the rows of the 1 kHz loop, checks its state transitions, and undeploys the cell. Returns what the sink
        counted."""
        status = self.wait_until_all_execute()
        for device in DEVICES:
            self.assertIsNone(self.machines[device].status, "the node of %s ended: %s" % (device, self.machines[device].err))
            self.assertEqual(self.hosts[device], self.machines[device].one("takt-host").pid, "the host of %s" % device)
        executor = status["robot"]["executors"][0]
        module = next(m for m in status["robot"]["modules"] if m["name"] == "source")
        jitter = module["jitter_us"]
        print("%-22s jitter p50 %.1f us, p99 %.1f us, max %.0f us; rows %d, missed %d; %d stops and starts, the slowest command %.2f s" %
              (what + ":", jitter["p50"], jitter["p99"], jitter["max"], executor["cycles"], executor["missed"], 2 * self.orders, self.slowest))
        steps = len(self.machines["robot"].steps("source"))
        begun = len(self.machines["robot"].raw)
        self.undeploy()
        self.machines["robot"].wait_for_line(r"robot\.source: START -> DESTRUCT", after=begun)
        states = ["INITIALIZE", "START", "EXECUTING"] + ["START", "EXECUTING"] * self.orders
        said = self.machines["robot"].steps("source")
        self.assertEqual(states + ["START", "DESTRUCT"], [s.target for s in said[-len(states) - 2:]], "after %d earlier steps" % steps)
        return json.loads(self.read("sink"))

    def weather(self, kinds, quiet_seconds=SECONDS):
        print("seed %d, %g s, %g packets a second" % (SEED, SECONDS, RATE))
        captured = os.path.join(self.folder, "captured")
        listening = self.attack("robot", "capture", captured, str(quiet_seconds + 2), wait=False)
        self.assertEqual("ready\n", listening.stdout.readline())
        self.deploy()
        self.hold(quiet_seconds)
        quiet = self.read_back("quiet")
        self.assertEqual((0, True), (quiet["wrong"], quiet["read"] > 0))
        for run in self.machines.values():
            self.assertNotIn("RTPS message", run.err, "a node must never reject packets of members")
        listening.wait()

        self.deploy()
        targets = self.targets()
        storm = self.attack("stranger", "storm", str(SECONDS), str(RATE), str(SEED), ",".join(kinds), json.dumps(targets), captured, wait=False)
        self.hold(SECONDS)
        out, _ = storm.communicate(timeout=takt_system.LONG)
        thrown = json.loads(out)
        print("sent: %s to %d UDP and %d TCP ports" % (thrown, len(targets["udp"]), len(targets["tcp"])))
        self.assertEqual(0, storm.returncode)
        self.assertTrue(all(n > 0 for n in thrown["sent"].values()), thrown)
        self.stop_and_start()  # once more after the end of the storm
        sink = self.read_back("storm")
        for device, run in self.machines.items():
            self.assertIn("dropped a packet from %s: it is not a valid RTPS message" % self.net.address("stranger"), run.err)
        for run in self.machines.values():
            run.signal(signal.SIGTERM)
        for run in self.machines.values():
            self.assertEqual(0, run.wait().status, run.err)
        return sink


class InTheOpen(Storm):
    def test_a_cell_works_during_a_storm_of_malformed_packets(self):
        sink = self.weather(["random", "rtps", "tcp"])
        self.assertEqual(0, sink["wrong"])
        self.assertGreater(sink["read"], 0)

    def capture(self, machine):
        """Deploys the cell. Returns a file with the packets that this machine sends and receives meanwhile."""
        captured = os.path.join(self.folder, "captured")
        listening = self.attack(machine, "capture", captured, "3", wait=False)
        self.assertEqual("ready\n", listening.stdout.readline())
        self.deploy()
        listening.wait()
        return captured

    def test_announcements_describe_no_types_and_do_not_name_the_machine(self):
        announced = []
        for packet in attack.read_captured(self.capture("robot")):
            for kind, flags, body in impostor.submessages(packet):
                if kind == attack.DATA and flags & 6 == 4 and body[11] & 0xC0 == 0xC0:  # of a writer that Fast DDS has created for itself
                    announced.append((impostor.parameters(body[24:]), bytes(body)))
        participants = [found for found, _ in announced if BUILTIN in found]
        self.assertGreaterEqual(len(participants), len(DEVICES))
        self.assertGreater(len(announced), len(participants))
        for found, body in announced:
            self.assertFalse(TYPE_DESCRIPTIONS & set(found), found)
            self.assertNotIn(b"physical_data", body)  # the names of the machine, the user and the process
        for found in participants:
            self.assertEqual(0, struct.unpack("<I", found[BUILTIN])[0] & TYPE_LOOKUP, found[BUILTIN])

    def test_no_process_hangs_or_crashes_when_an_attacker_sends_packets_in_the_name_of_members(self):
        captured = self.capture("robot")
        sent = self.attack("stranger", "forge", captured, "5", json.dumps(self.targets()))
        self.assertGreaterEqual(sent["members"], len(DEVICES))
        self.slowest = 0.0
        self.stop_and_start()
        self.status()
        for device in DEVICES:
            self.assertIsNone(self.machines[device].status, "the node of %s ended: %s" % (device, self.machines[device].err))
            self.assertEqual(self.hosts[device], self.machines[device].one("takt-host").pid, "the host of %s" % device)
            self.assertLess(wear.taken_by(self.machines[device].one("takt-node").pid)["rss_kib"], 500_000)

    def impersonate(self, name, near, *ports):
        """Deploys the cell. Returns a function that sends the packets of a case of impostor.py to the device `near`, in the name of the node
        of device `name`."""
        captured = self.capture("operator")
        targets = {"udp": [[self.net.address(near), port] for port in ports], "from": self.net.address("stranger"),
                   "name": self.net.address(name), "near": self.net.on(near)[-1]}

        def send(case, amount):
            run = subprocess.run([*self.net.on("stranger"), sys.executable, "-B", IMPOSTOR, captured, case, str(amount), json.dumps(targets)],
                                 stdout=subprocess.PIPE, text=True, timeout=takt_system.LONG)
            self.assertEqual(0, run.returncode, case)
            return json.loads(run.stdout)
        return send

    def check_that_all_live(self, after):
        """Checks that no process has ended or uses much memory, and that commands work."""
        for device in DEVICES:
            run = self.machines[device]
            self.assertIsNone(run.status, "after %s, the node of %s ended: %s" % (after, device, run.err))
            self.assertEqual(self.hosts[device], run.one("takt-host").pid, "after %s, the host of %s" % (after, device))
            used = wear.taken_by(run.one("takt-node").pid)["rss_kib"]
            print("after %s: the node of %s uses %d KiB" % (after, device, used))
            self.assertLess(used, 150_000, "after %s, the node of %s" % (after, device))
        self.slowest = 0.0
        self.stop_and_start()
        self.assertEqual(set(DEVICES), set(self.status()), after)

    def survive(self, *cases, rounds):
        send = self.impersonate("robot", "line", *DDS_PORTS)
        for case in cases:
            sent = send(case, rounds)
            self.check_that_all_live(case)
            self.assertFalse(sent["silent"], case)

    def test_a_cell_survives_forged_fragments_of_a_sample_that_a_member_sends_next(self):
        self.survive("false_size", "one_of_two", "whole_but_invalid", "many_begun", "far_ahead", rounds=10)

    def test_a_cell_survives_forged_announcements_of_a_members_writer(self):
        self.survive("false_counts", "nested_filter", "false_types", "false_durations", "encrypted", rounds=2)

    def test_a_cell_survives_announcements_of_a_participant_without_a_guid(self):
        self.survive("of_nobody", rounds=2)

    def test_a_flood_of_forged_samples_costs_no_memory_and_no_commands(self):
        self.deploy()
        self.hold(SECONDS)
        self.read_back("quiet")
        send = self.impersonate("line", "robot", 7401, 7411)  # the ports for status and commands
        sent = send("flood", SECONDS)
        self.check_that_all_live("flood")
        events = [json.loads(line) for line in self.order("log", "robot", "--json").out.splitlines()]
        refused = [e for e in events if e["kind"] == "refused-packet"]
        print("sent: %s; rejected: %d" % (sent, sum(e["count"] for e in refused)))
        self.assertTrue(refused)
        self.read_back("flood")


class Secured(Storm):
    secured = True

    def test_a_secured_cell_works_during_a_storm_of_altered_copies_of_its_packets(self):
        sink = self.weather(["random", "rtps", "tcp", "mutated"], quiet_seconds=5)
        self.assertEqual(0, sink["wrong"])
        self.assertGreater(sink["read"], 0)

    def deceive(self, how, seconds):
        """Runs commands during and after the attack. Returns the attacker's report and what the sink counted."""
        captured = os.path.join(self.folder, "captured")
        listening = self.attack("robot", "capture", captured, "3", wait=False)
        self.assertEqual("ready\n", listening.stdout.readline())
        self.deploy()
        listening.wait()
        deceiver = self.attack("stranger", how, captured, str(seconds), json.dumps(self.targets()), wait=False)
        self.hold(seconds)
        out, _ = deceiver.communicate(timeout=takt_system.LONG)
        self.assertEqual(0, deceiver.returncode)
        self.stop_and_start()
        sink = self.read_back("%s: %s" % (how, out.strip()))
        self.assertEqual(0, sink["wrong"])
        return json.loads(out), sink

    def test_a_secured_cell_ignores_forged_heartbeats(self):
        sent, sink = self.deceive("forge", 5)
        self.assertGreaterEqual(sent["members"], len(DEVICES))
        self.assertGreater(sink["read"], 5000, "a reader that believes the heartbeat waits for number 2^40")
        for run in self.machines.values():
            self.assertIn("dropped a packet from %s: it is not encrypted" % self.net.address("stranger"), run.err)

    def test_commands_to_a_secured_cell_work_despite_a_thousand_fake_participants(self):
        sent, _ = self.deceive("crowd", 10)
        self.assertGreater(sent["participants"], 1000)
        for run in self.machines.values():
            self.assertIn("dropped a packet from %s: it announces" % self.net.address("stranger"), run.err)


if __name__ == "__main__":
    takt_system.main()
