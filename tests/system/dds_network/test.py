"""Tests how DDS uses the network interfaces of a machine, and how it follows addresses. Network namespaces simulate the machines.

TAKT_DDS_PEER is the path of a program from tests/conformance/dds. These tests need root and iproute2."""
import os
import queue
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import uuid

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import networks
import takt_system

PEER = os.environ["TAKT_DDS_PEER"]
MODULE = """<module>
  <name>%s</name> <filename>%s.so</filename> <moduletype>thread</moduletype> <operationtype>periodic</operationtype>
  <period>20ms</period> <priority>1</priority>
</module>"""
# The device robot may write the topic t, and the others may read it.
CELL = """<cell name="cell" security="required">
  <device name="robot">%s</device> <device name="twin">%s</device> <device name="line">%s</device>
  <connection from="robot.out.out" to="twin.in.in" topic="t"/> <connection from="robot.out.out" to="line.in.in" topic="t"/>
</cell>""" % (MODULE % ("out", "port_source"), MODULE % ("in", "port_sink"), MODULE % ("in", "port_sink"))


def ip(*arguments):
    subprocess.run(["ip", *arguments], check=True, capture_output=True)


class TwoMachines:
    """The simulated machines robot and line, connected by the cables net0 (10.80.0.x) and net1 (10.80.1.x). At first, both cables are
    disconnected."""

    def __init__(self):
        mark = "t" + uuid.uuid4().hex[:6]
        self.spaces = {name: mark + "-" + name for name in ("robot", "line")}
        for space in self.spaces.values():
            ip("netns", "add", space)
            ip("-n", space, "link", "set", "lo", "up")
        for cable in (0, 1):
            self.create(cable)

    def on(self, machine):
        return ["ip", "netns", "exec", self.spaces[machine]]

    def create(self, cable):
        ip("link", "add", "net%d" % cable, "netns", self.spaces["robot"], "type", "veth", "peer", "name", "net%d" % cable,
           "netns", self.spaces["line"])

    def remove(self, cable):
        ip("-n", self.spaces["robot"], "link", "del", "net%d" % cable)

    def change_address(self, machine, cable, host):
        ip("-n", self.spaces[machine], "addr", "flush", "dev", "net%d" % cable, "scope", "global")
        ip("-n", self.spaces[machine], "addr", "add", "10.80.%d.%d/24" % (cable, host), "dev", "net%d" % cable)

    def connect(self, cable):
        for number, space in enumerate(self.spaces.values(), 1):
            ip("-n", space, "addr", "add", "10.80.%d.%d/24" % (cable, number), "dev", "net%d" % cable)
            ip("-n", space, "link", "set", "net%d" % cable, "up")
        for space in self.spaces.values():
            while b"LOWER_UP" not in subprocess.run(["ip", "-n", space, "link", "show", "net%d" % cable], capture_output=True).stdout:
                time.sleep(0.01)

    def set(self, machine, cable, state):
        ip("-n", self.spaces[machine], "link", "set", "net%d" % cable, state)

    def bytes(self, machine, cable):
        return self._count(machine, cable, "tx_bytes")

    def packets(self, machine, cable):
        """Returns how many packets the machine has sent, with those that the cable has lost."""
        return self._count(machine, cable, "tx_packets") + self._count(machine, cable, "tx_dropped")

    def _count(self, machine, cable, what):
        path = "/sys/class/net/net%d/statistics/%s" % (cable, what)
        return int(subprocess.run(["ip", "netns", "exec", self.spaces[machine], "cat", path], check=True, capture_output=True, text=True).stdout)

    def mute(self, machine, mute=True):
        """The machine receives packets through cable 0, but what it sends is lost."""
        subprocess.run(["tc", "-n", self.spaces[machine], "qdisc", "add" if mute else "del", "dev", "net0", "root", "blackhole"], check=True)

    def limit(self, mtu):
        """Cable 0 loses IP packets to machine line that are longer than this."""
        ip("-n", self.spaces["line"], "link", "set", "net0", "mtu", str(mtu - 4))  # the interface takes 4 bytes more

    def end(self):
        for space in self.spaces.values():
            subprocess.run(["ip", "netns", "del", space], capture_output=True)


class Peer:
    def __init__(self, network, machine, *arguments, **environment):
        self.process = subprocess.Popen([*network.on(machine), PEER, "0", *arguments],
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                                        env={**os.environ, "PEER_INTERFACES": "all", **environment})
        self.lines = queue.Queue()
        self.reader = threading.Thread(target=self._read)
        self.reader.start()

    def write(self, text):
        self.process.stdin.write(text + "\n")
        self.process.stdin.flush()

    def _read(self):
        for line in self.process.stdout:
            self.lines.put(line.rstrip("\n"))

    def line(self, limit=takt_system.LONG):
        """Returns the next line, or an empty string if the program prints no line within the limit."""
        try:
            return self.lines.get(timeout=limit)
        except queue.Empty:
            return ""

    def end(self):
        self.process.kill()
        self.process.wait()
        self.reader.join()
        self.process.stdin.close()
        self.process.stdout.close()


class Matching(unittest.TestCase):
    """Lets writers and readers on simulated machines find each other. self.net is the network."""

    def peer(self, machine, *arguments, **environment):
        peer = Peer(self.net, machine, *arguments, **environment)
        self.addCleanup(peer.end)
        self.assertEqual("ready", peer.line())
        return peer

    def match(self, feed, tap, limit=takt_system.LONG):
        """Writes samples until one arrives while no other sample is in transit. Returns the number of the last sample."""
        end = time.monotonic() + limit
        while time.monotonic() < end:
            feed.write("1")
            written = int(feed.line().split()[1])
            heard = tap.line(0.1)
            if heard:
                while heard and heard != "sample %d" % written:
                    heard = tap.line()
                return written
        self.fail("writer and reader did not find each other")

    def assert_arrive(self, feed, tap, first, count):
        feed.write(str(count))
        for number in range(first, first + count):
            self.assertEqual("sample %d" % number, tap.line())
        self.assertTrue(feed.line().startswith("written %d failures 0" % (first + count - 1)))

    def found_again(self, feed, tap, what):
        """Waits until ten samples arrive one after the other."""
        begin = time.monotonic()
        while time.monotonic() < begin + takt_system.LONG:
            last = self.match(feed, tap)
            feed.write("10")
            if [tap.line(1.0) for _ in range(10)] == ["sample %d" % (last + 1 + number) for number in range(10)]:
                feed.line()
                print("%s: found again after %.1f s" % (what, time.monotonic() - begin))
                return
            feed.line()
        self.fail("%s: the samples do not arrive" % what)


class Interfaces(Matching):
    def setUp(self):
        reason = networks.available()
        if reason:
            self.skipTest(reason)
        self.net = TwoMachines()
        self.addCleanup(self.net.end)

    def test_dds_uses_only_the_configured_network_interface(self):
        for cable in (0, 1):
            self.net.connect(cable)
        tap = self.peer("line", "tap", "t", "reliable", "64", PEER_INTERFACES="10.80.1.2")
        feed = self.peer("robot", "feed", "t", "reliable", "64", PEER_INTERFACES="10.80.1.1")
        last = self.match(feed, tap)
        before = [self.net.bytes("robot", cable) for cable in (0, 1)]
        feed.write("100 5000")
        for number in range(last + 1, last + 101):
            self.assertEqual("sample %d" % number, tap.line())
        after = [self.net.bytes("robot", cable) for cable in (0, 1)]
        self.assertGreater(after[1] - before[1], 500000)
        self.assertLess(after[0] - before[0], 2000, "only the kernel itself may send on the other cable")

    def test_large_samples_arrive_over_a_network_that_loses_ip_packets_above_1280_bytes(self):
        self.net.connect(0)
        self.net.limit(1280)
        tap = self.peer("line", "tap", "t", "reliable", "64")
        feed = self.peer("robot", "feed", "t", "reliable", "64")
        last = self.match(feed, tap)
        feed.write("20 60000")
        for number in range(last + 1, last + 21):
            self.assertEqual("sample %d" % number, tap.line())

    def test_a_writer_repeats_samples_seldom_if_they_never_arrive(self):
        self.net.connect(0)
        tap = self.peer("line", "tap", "t", "reliable", "64")
        feed = self.peer("robot", "feed", "t", "reliable", "64")
        self.match(feed, tap)
        self.net.limit(600)
        feed.write("4 20000")
        self.assertIn("failures 0", feed.line())
        before = self.net.packets("robot", 0)
        time.sleep(3)
        sent = self.net.packets("robot", 0) - before
        print("%d packets in 3 s" % sent)
        self.assertLess(sent, 5000, "packets in 3 s, for 80 kB")

    def test_dds_uses_a_network_interface_that_comes_up_after_the_start(self):
        tap = self.peer("line", "tap", "t", "reliable", "64")
        feed = self.peer("robot", "feed", "t", "reliable", "64")
        time.sleep(1)
        feed.write("0")
        self.assertIn("matched 0", feed.line())
        self.net.connect(0)
        begin = time.monotonic()
        last = self.match(feed, tap)
        print("matched %.1f s after the interface came up" % (time.monotonic() - begin))
        self.assert_arrive(feed, tap, last + 1, 20)

    def test_reliable_samples_sent_while_a_cable_is_unplugged_arrive_when_it_is_plugged_in(self):
        self.net.connect(0)
        tap = self.peer("line", "tap", "t", "reliable", "64")
        feed = self.peer("robot", "feed", "t", "reliable", "64")
        last = self.match(feed, tap)
        self.assert_arrive(feed, tap, last + 1, 10)
        self.net.set("line", 0, "down")
        feed.write("40")
        time.sleep(0.5)
        self.net.set("line", 0, "up")
        for number in range(last + 11, last + 51):
            self.assertEqual("sample %d" % number, tap.line())
        self.assertTrue(feed.line().startswith("written %d failures 0" % (last + 50)))
        self.assert_arrive(feed, tap, last + 51, 10)

    def test_a_participant_uses_an_interface_again_that_was_removed_and_created_again(self):
        self.net.connect(0)
        tap = self.peer("line", "tap", "t", "reliable", "64")
        feed = self.peer("robot", "feed", "t", "reliable", "64")
        self.match(feed, tap)
        for _ in range(3):
            self.net.remove(0)
            self.net.create(0)
            self.net.connect(0)
            self.found_again(feed, tap, "interface created again")

    def test_a_participant_is_found_at_its_new_address(self):
        self.net.connect(0)
        tap = self.peer("line", "tap", "t", "reliable", "64")
        feed = self.peer("robot", "feed", "t", "reliable", "64")
        self.match(feed, tap)
        for machine in ("robot", "line"):
            for host in (11, 12):
                self.net.change_address(machine, 0, host + 10 * (machine == "line"))
                self.found_again(feed, tap, "new address of " + machine)
                self.found_again(feed, self.peer("line", "tap", "t", "reliable", "64"), "process started afterwards")

    def test_a_participant_is_found_at_its_new_address_if_its_peers_do_not_use_multicast(self):
        self.net.connect(0)
        tap = self.peer("line", "tap", "t", "reliable", "64", PEER_DISCOVERY="peers=10.80.0.1")
        feed = self.peer("robot", "feed", "t", "reliable", "64", PEER_DISCOVERY="peers=10.80.0.2")
        self.match(feed, tap)
        self.net.change_address("line", 0, 22)
        self.found_again(feed, tap, "new address of line")

    def test_processes_of_one_machine_communicate_without_any_address(self):
        self.net.connect(0)
        tap = self.peer("robot", "tap", "t", "reliable", "64")
        feed = self.peer("robot", "feed", "t", "reliable", "64")
        last = self.match(feed, tap)
        self.net.remove(0)
        self.assert_arrive(feed, tap, last + 1, 10)
        new = self.peer("robot", "tap", "t", "reliable", "64")
        self.found_again(feed, new, "process started without a network")
        new_feed = self.peer("robot", "feed", "u", "reliable", "64")
        self.net.create(0)
        self.net.connect(0)
        remote = self.peer("line", "tap", "u", "reliable", "64")
        self.found_again(new_feed, remote, "process started without a network, from another machine")

    def test_connections_go_on_while_an_interface_that_they_do_not_use_appears_and_disappears(self):
        self.net.connect(0)
        tap = self.peer("line", "tap", "t", "reliable", "64")
        feed = self.peer("robot", "feed", "t", "reliable", "64")
        last = self.match(feed, tap)
        self.net.set("robot", 1, "up")
        self.net.set("line", 1, "up")
        for _ in range(5):
            for change in ("add", "del"):
                ip("-n", self.net.spaces["robot"], "addr", change, "10.90.0.1/24", "dev", "net1")
                for _ in range(5):  # the participants follow the change within this time
                    self.assert_arrive(feed, tap, last + 1, 10)
                    last += 10
                    time.sleep(0.1)

    def secured(self, machine, device, *arguments):
        """Starts a member of a secured cell."""
        if not hasattr(self, "keys"):
            folder = tempfile.TemporaryDirectory()
            self.addCleanup(folder.cleanup)
            cell = os.path.join(folder.name, "cell.xml")
            with open(cell, "w") as file:
                file.write(CELL)
            self.keys = os.path.join(folder.name, "keys")
            subprocess.run([os.path.join(takt_system.BIN, "takt"), "secure", "init", cell, self.keys, "--operator", "anna"],
                           check=True, capture_output=True)
        return self.peer(machine, *arguments, "t", "reliable", "64", PEER_SECURITY=os.path.join(self.keys, "devices", device))

    def test_secured_processes_of_one_machine_stay_connected_when_it_gets_another_address(self):
        self.net.connect(0)
        tap = self.secured("robot", "twin", "tap")
        remote = self.secured("line", "line", "tap")
        feed = self.secured("robot", "robot", "feed")
        self.match(feed, remote)
        last = self.match(feed, tap)
        for host in (11, 12, 13):
            self.net.change_address("robot", 0, host)
            for _ in range(30):  # the participants follow the change within this time
                self.assert_arrive(feed, tap, last + 1, 10)
                last += 10
                time.sleep(0.05)
            self.match(feed, remote)
            last = self.match(feed, tap)

    def test_secured_participants_find_each_other_again_after_only_one_has_lost_the_other(self):
        self.net.connect(0)
        tap = self.secured("line", "line", "tap")
        feed = self.secured("robot", "robot", "feed")
        self.match(feed, tap)
        for mute in ("robot", "line"):
            self.net.mute(mute)
            time.sleep(4)  # the lease is 3 s
            self.net.mute(mute, False)
            self.found_again(feed, tap, mute + " was mute")

    def test_secured_participants_authenticate_also_if_one_is_mute_for_the_first_17_s(self):
        self.net.connect(0)
        self.net.mute("robot")
        tap = self.secured("line", "line", "tap")
        feed = self.secured("robot", "robot", "feed")
        time.sleep(17)
        self.net.mute("robot", False)
        self.found_again(feed, tap, "robot was mute")

    def test_a_secured_participant_is_found_after_one_with_the_same_port_has_crashed_during_its_authentication(self):
        self.net.connect(0)
        feed = self.secured("robot", "robot", "feed")
        self.net.mute("robot")
        crashed = self.secured("line", "line", "tap")
        time.sleep(2)  # robot begins to authenticate it, and goes on after its crash
        crashed.process.kill()
        self.net.mute("robot", False)
        tap = self.secured("line", "line", "tap")
        self.found_again(feed, tap, "crash")

    def test_a_secured_participant_forgets_one_that_has_crashed_during_its_authentication(self):
        self.net.connect(0)
        self.secured("robot", "robot", "feed")
        self.net.mute("robot")
        crashed = self.secured("line", "line", "tap")
        time.sleep(2)  # robot begins to authenticate it
        crashed.process.kill()
        self.net.mute("robot", False)

        def is_quiet():
            before = self.net.packets("robot", 0)
            time.sleep(2)
            return self.net.packets("robot", 0) - before < 10  # it still announces itself every second
        takt_system.wait_until(is_quiet, "the end of the authentication")

    def test_a_secured_participant_is_found_again_after_a_forged_message_that_it_leaves(self):
        self.net.connect(0)
        tap = self.secured("line", "line", "tap")
        feed = self.secured("robot", "robot", "feed")
        self.match(feed, tap)
        time.sleep(5)  # LossReports::kNew
        forge = os.path.join(os.path.dirname(os.path.abspath(__file__)), "forged_leave.py")
        subprocess.run([*self.net.on("robot"), sys.executable, forge, "10.80.0.1", "10.80.0.2"], check=True, timeout=takt_system.LONG)
        self.found_again(feed, tap, "forged leave")


class Served(Matching):
    """The machine station runs the discovery server. The other machines only know its name."""
    MACHINES = ("station", "spare", "line", "robot")
    SERVER = {"PEER_DISCOVERY": "server=station:11811"}

    def setUp(self):
        reason = networks.available()
        if reason:
            self.skipTest(reason)
        self.net = networks.Networks(*self.MACHINES)
        self.net.__enter__()
        self.addCleanup(self.net.__exit__)
        self.net.no_multicast()
        self.net.set_host_names(station=1)

    def serve(self, machine):
        return self.peer(machine, "device", "server", PEER_DISCOVERY="serve=0.0.0.0:11811")

    def begin(self, machine, **environment):
        """Starts the discovery server, and two clients that find each other."""
        self.server = self.serve("station")
        self.tap = self.peer(machine, "tap", "t", "reliable", "64", **{**self.SERVER, **environment})
        self.feed = self.peer("robot", "feed", "t", "reliable", "64", **{**self.SERVER, **environment})
        return self.match(self.feed, self.tap)

    def assert_new_ones_are_found(self, what, **environment):
        """Starts two more clients, and waits until the first ones find them."""
        new = {**self.SERVER, **environment}
        self.found_again(self.feed, self.peer("robot", "tap", "t", "reliable", "64", **new), "new reader after " + what)
        while self.tap.line(0.2):  # what the first writer has written
            pass
        self.found_again(self.peer("spare", "feed", "t", "reliable", "64", **new), self.tap, "new writer after " + what)

    def follow_addresses(self, machine):
        last = self.begin(machine)
        for number in (101, 102, 103):
            self.net.set_address("station", number)
            self.net.set_host_names(station=number)
            if machine != "station":
                self.assert_arrive(self.feed, self.tap, last + 1, 10)
            self.assert_new_ones_are_found("a new address")
            last = self.match(self.feed, self.tap)

    def test_clients_follow_their_discovery_server_to_a_new_address(self):
        self.follow_addresses("line")

    def test_a_client_on_the_machine_of_the_discovery_server_follows_it_to_a_new_address(self):
        self.follow_addresses("station")

    def test_clients_follow_their_discovery_server_to_a_new_address_that_its_name_does_not_have(self):
        self.begin("line")
        self.net.set_address("station", 101)
        self.assert_new_ones_are_found("a new address", PEER_DISCOVERY="server=10.77.0.101:11811")

    def test_clients_that_were_given_the_address_of_their_discovery_server_follow_it_to_a_new_one(self):
        self.begin("line", PEER_DISCOVERY="server=10.77.0.1:11811")
        self.net.set_address("station", 101)
        self.assert_new_ones_are_found("a new address", PEER_DISCOVERY="server=10.77.0.101:11811")

    def test_a_discovery_server_follows_a_client_to_a_new_address(self):
        self.begin("line")
        for number in (101, 102):
            self.net.set_address("line", number)
            self.assert_new_ones_are_found("a new address of a client")

    def test_clients_follow_their_discovery_server_to_another_machine(self):
        self.begin("line")
        for machine in ("spare", "station"):
            self.server.end()
            self.net.set_host_names(station=self.net.number(machine))
            self.server = self.serve(machine)
            self.assert_new_ones_are_found("a restart on machine " + machine)


if __name__ == "__main__":
    takt_system.main()
