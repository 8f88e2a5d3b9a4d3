"""A program that uses Cyclone DDS communicates with Takt. The IDL compiler of Cyclone generates its types from idl/.

TAKT_DDS_PEER is the path of the program in tests/conformance/dds. TAKT_CYCLONE_PEER is the path of the program in this folder."""
import json
import os
import subprocess
import sys
import tempfile
import threading
import time
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system

PEER = os.environ["TAKT_DDS_PEER"]
CYCLONE = os.environ["TAKT_CYCLONE_PEER"]
DOMAIN = os.environ.get("TAKT_TEST_DOMAIN") or str(takt_system.free_domain())
KEPT = 32  # The history depth on both sides. If one side stalls, samples beyond this number are lost.
# Makes Cyclone DDS use the loopback interface, so that no packet leaves the machine. Otherwise it uses the first multicast interface that
# is up.
LOOPBACK = """<CycloneDDS><Domain id="any"><General><Interfaces><NetworkInterface address="127.0.0.1" multicast="true"/></Interfaces>
<AllowMulticast>spdp</AllowMulticast></General></Domain></CycloneDDS>"""
REPORT, STOP = 0, 8  # values of takt::CommandKind

# The types of port.idl, as Python data.
SAMPLE = {"name": "test::Sample", "fields": [
    {"name": "number", "type": "unsigned long long"}, {"name": "value", "type": "long long"},
    {"name": "data", "type": "octet", "sequence": 65536}]}
PLACE = [{"name": "x", "type": "double"}, {"name": "angle", "type": "float"}]
MIXED = {"name": "test::Mixed", "fields": [
    {"name": "flag", "type": "boolean"}, {"name": "small", "type": "octet"}, {"name": "number", "type": "short"},
    {"name": "colour", "type": "enum", "of": "test::Colour", "enumerators": ["RED", "GREEN", "BLUE"]},
    {"name": "name", "type": "string", "bound": 15},
    {"name": "places", "type": "struct", "of": "test::Place", "array": [2], "fields": PLACE},
    {"name": "values", "type": "double", "sequence": 4},
    {"name": "way", "type": "struct", "of": "test::Place", "sequence": 3, "fields": PLACE},
    {"name": "last", "type": "long long"}]}


class Program:
    def __init__(self, *arguments, environment=None):
        self.process = subprocess.Popen(arguments, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                                        env={**os.environ, **(environment or {})})

    def lines(self):
        return iter(self.process.stdout.readline, "")

    def line(self):
        return self.process.stdout.readline().rstrip("\n")

    def write(self, text):
        self.process.stdin.write(text + "\n")
        self.process.stdin.flush()

    def end(self):
        self.process.kill()
        self.process.wait()
        self.process.stdin.close()
        self.process.stdout.close()


class Cyclone(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def takt(self, *arguments, first="ready"):
        program = Program(PEER, DOMAIN, *arguments)
        self.addCleanup(program.end)
        self.assertEqual(first, program.line())
        return program

    def cyclone(self, *arguments):
        program = Program(CYCLONE, DOMAIN, *arguments, environment={"CYCLONEDDS_URI": LOOPBACK})
        self.addCleanup(program.end)
        return program

    def type_file(self, shape):
        path = os.path.join(self.folder, shape["name"].replace("::", "_"))
        with open(path, "w") as file:
            json.dump(shape, file)
        return path

    def test_cyclone_dds_reads_the_status_topics_of_nodes(self):
        self.takt("state", "12", first="failures 0")
        device = self.takt("device", "robot")
        self.takt("statistics", "servo")
        watch = self.cyclone("watch", "60")
        modules, seen, killed, gone = {}, {}, False, False
        for text in watch.lines():
            said = json.loads(text)
            if said["topic"] == "lifecycle" and "path" in said:
                modules[said["path"]] = said
            elif "path" in said:
                seen.setdefault(said["topic"], []).append(said)
            if len(modules) == 12 and len(seen.get("device", [])) >= 5 and len(seen.get("statistics", [])) >= 3:
                device.process.kill()
                killed = True
            if said["topic"] == "device" and "not_alive" in said:
                gone = said["not_alive"] == 1  # this may arrive early if the machine stalled for longer than the lease
            if killed and gone:
                break
        self.assertTrue(killed and gone, "the reader must see the death of the node")
        self.assertEqual({"test/device/module%d" % n for n in range(12)}, set(modules))
        one = modules["test/device/module3"]
        self.assertEqual((2, 2, "module3", "test", "device"),
                         (one["sequence_number"], one["state"], one["name"], one["cell"], one["device"]))
        self.assertEqual({"robot"}, {s["device"] for s in seen["device"]})
        self.assertEqual({(5, 0, "here")}, {(s["state"], s["health"], s["host_name"]) for s in seen["device"]})
        self.assertGreater(seen["device"][-1]["sequence_number"], seen["device"][0]["sequence_number"])
        self.assertEqual({("servo", 7, -1.5, 12.25)},
                         {(s["name"], s["overruns"], s["jitter_mean_us"], s["run_p99_us"]) for s in seen["statistics"]})

    def test_a_cyclone_dds_reader_is_notified_when_the_states_of_modules_are_disposed(self):
        state = self.takt("state", "12", first="failures 0")
        watch = self.cyclone("watch", "30")
        alive, disposed, told = set(), set(), False
        for text in watch.lines():
            said = json.loads(text)
            if "path" in said:
                alive.add(said["path"])
            elif "disposed" in said:
                disposed.add(said["disposed"])
            if len(alive) == 12 and not told:
                state.write("dispose")
                told = True
            if len(disposed) == 12:
                break
        self.assertEqual({"test/device/module%d" % n for n in range(12)}, alive)
        self.assertEqual(alive, disposed)

    def test_a_cyclone_dds_program_can_send_a_command_and_receive_the_reply(self):
        server = self.takt("server", "robot", "5")
        run = self.cyclone("command", "robot", "servo", str(STOP))
        answer = json.loads(run.line())
        self.assertEqual(0, run.process.wait())
        handled = server.line()
        self.assertRegex(handled, r"^handled cyclone-\d+-\d+ 0$")
        self.assertEqual((0, 5, "robot", "node"), (answer["code"], answer["bytes"], answer["device"], answer["node"]))
        self.assertEqual("for " + handled.split()[1], answer["value"])

    def test_a_takt_port_reads_the_samples_of_a_cyclone_dds_writer(self):
        for reliability in ("reliable", "best-effort"):
            with self.subTest(reliability):
                topic = "to/" + reliability.replace("-", "_")  # Cyclone DDS allows no other special characters here
                tap = self.takt("tap", topic, reliability, str(KEPT))
                count = KEPT - 2
                write = self.cyclone("write", "Sample", topic, str(count), "5", reliability)
                for number in range(1, count + 1):
                    self.assertEqual("sample %d" % number, tap.line(), "samples must arrive complete and in order")
                self.assertEqual("written", write.line())
                tap.write("health")
                self.assertEqual("samples %d lost 0 refused 0" % count, " ".join(tap.line().split()[2:8]))

    def test_a_cyclone_dds_reader_reads_the_samples_of_a_takt_port(self):
        for reliability in ("reliable", "best-effort"):
            with self.subTest(reliability):
                topic = "from/" + reliability.replace("-", "_")
                feed = self.takt("feed", topic, reliability, str(KEPT))
                read = self.cyclone("read", "Sample", topic, "30", "30", reliability)
                samples = []
                reader = threading.Thread(target=lambda: samples.extend(json.loads(text) for text in read.lines()))
                reader.start()
                written = 0
                while reader.is_alive():  # a reader does not receive samples that were written before it matched
                    if not samples or written - samples[-1]["number"] < KEPT // 2:
                        feed.write("1 3000")
                        written = int(feed.line().split()[1])
                    time.sleep(0.01 if samples else 0.05)
                reader.join()
                numbers = [sample["number"] for sample in samples]
                for sample in samples:
                    self.assertTrue(sample["whole"])
                    self.assertEqual(sample["number"], sample["value"])
                self.assertEqual(list(range(numbers[0], numbers[0] + 30)), numbers)
                self.assertEqual(0, read.process.wait())

    def test_takt_and_cyclone_dds_can_exchange_structs_with_every_kind_of_member(self):
        mixed = self.type_file(MIXED)
        show = self.takt("show", "mixed/to", "reliable", "32", mixed)
        self.cyclone("write", "Mixed", "mixed/to", "12", "5", "reliable")
        for n in range(1, 13):
            self.assertEqual({"flag": n % 2 == 1, "small": n, "number": -n, "colour": ["RED", "GREEN", "BLUE"][n % 3],
                              "name": "abcdefghijklmno"[:n % 16], "places": [{"x": n, "angle": 0}, {"x": n + 1, "angle": 0.5}],
                              "values": [n * 10 + i for i in range(n % 5)],
                              "way": [{"x": i, "angle": 0.25} for i in range(n % 4)], "last": 1 << 40}, json.loads(show.line()))
        show.write("health")
        self.assertEqual("refused 0", show.line())

        give = self.takt("give", "mixed/from", "reliable", "32", mixed)
        read = self.cyclone("read", "Mixed", "mixed/from", "1", "30", "reliable")
        sample = {"flag": True, "small": 200, "number": -32768, "colour": "BLUE", "name": "fifteen letters",
                  "places": [{"x": 1.5, "angle": -2.5}, {"x": -0.25, "angle": 8}], "values": [0.5, 1e300, -1],
                  "way": [{"x": 9, "angle": 1}], "last": -5}
        while read.process.poll() is None:
            give.write(json.dumps(sample))
            self.assertEqual("written", give.line())
            time.sleep(0.05)
        got = json.loads(read.line())
        self.assertEqual({**sample, "colour": 2, "places": [[1.5, -2.5], [-0.25, 8]], "way": [[9, 1]]}, got)

    def test_a_takt_port_reads_cyclone_dds_samples_of_a_type_that_takt_provides(self):
        """The type line::Part is in the IDL files that come with Takt."""
        shape = {"name": "line::Part", "fields": [
            {"name": "number", "type": "unsigned long"}, {"name": "kind", "type": "string", "bound": 15},
            {"name": "x", "type": "double"}, {"name": "y", "type": "double"}, {"name": "angle", "type": "double"}]}
        show = self.takt("show", "part", "reliable", "32", self.type_file(shape))
        self.cyclone("write", "Part", "part", "3", "5", "reliable")
        for number in (1, 2, 3):
            self.assertEqual({"number": number, "kind": "box", "x": 0, "y": 0.01, "angle": 0}, json.loads(show.line()))


if __name__ == "__main__":
    takt_system.main()
