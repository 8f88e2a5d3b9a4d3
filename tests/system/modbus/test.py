import json
import os
import signal
import struct
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import modbus
import takt_system
from takt_system import wait_until

# The master must have fewer overruns than this. Some are tolerated because the machine may stall. A body that waited for one missing answer
# (0.7 s) would be busy at 70 releases and have more overruns, because its period is 10 ms.
FEW = 50


class Modbus(takt_system.Case):
    def descriptor(self, name, port, **changes):
        with open(self.beside(name)) as file:
            text = file.read().replace("PORT", str(port))
        for old, new in changes.get("replace", ()):
            self.assertIn(old, text)
            text = text.replace(old, new)
        return self.write(name, text)

    def device(self):
        device = modbus.Device()
        self.addCleanup(device.close)
        return device

    def master(self, port):
        def attempt():
            try:
                return modbus.Master(port)
            except OSError:
                return None
        master = wait_until(attempt, "a connection")
        self.addCleanup(master.close)
        return master

    def run_cell(self, device, **options):
        run = self.start("run", self.descriptor("cell.xml", device.port, **options), "--json")
        run.wait_for_state("master", "EXECUTING")
        return run

    def end(self, run):
        run.signal(signal.SIGINT)
        run.wait()
        self.assertEqual(0, run.status, run.err)
        return run

    def assert_on_time(self, run):
        """Checks that the body of the master always returned to waitPeriod() before its next release, whatever the device did."""
        master = run.modules("plc")["master"]
        self.assertEqual(0, master["errors"])
        self.assertLess(master["overruns"], FEW)
        self.assertGreater(master["cycles"], 5)

    # The tests below run Takt's master with the device of modbus.py.

    def test_the_master_accesses_neighbouring_addresses_in_one_request(self):
        device = self.device()
        device.discrete[3] = 1
        device.inputs[4] = -205 & 0xFFFF
        low, high = struct.unpack(">HH", struct.pack("<f", -2.0)[1::-1] + struct.pack("<f", -2.0)[3:1:-1])
        device.registers[20], device.registers[21] = low, high
        run = self.run_cell(device)
        # -20.5 is below the range of register 10, so the master writes 0. -2.0 fits into registers 30 and 31.
        wait_until(lambda: (device.coils[0], device.registers[10], device.registers[30], device.registers[31]) ==
                   (1, 0, 0xFFFF, 0xFFFE), what="the values that were read to be written")
        device.inputs[4] = 25
        wait_until(lambda: device.registers[10] == 2500, what="2.5 with a scale of 0.001")
        device.discrete[3] = 0
        wait_until(lambda: device.coils[0] == 0)
        self.assert_on_time(self.end(run))
        # Coil 1 has no value, so the master wrote only coil 0. At the end it wrote the safe values of both coils in one request. It also
        # accessed other neighbouring addresses in one request.
        self.assertEqual({(2, 3, 1), (4, 4, 1), (3, 20, 2), (15, 0, 1), (16, 10, 1), (16, 30, 2), (15, 0, 2)},
                         set(device.requests))
        self.assertEqual((15, 0, 2), next(r for r in reversed(device.requests) if r[0] == 15))

    def test_the_master_writes_safe_values_when_the_cell_ends(self):
        device = self.device()
        device.discrete[3] = 1
        device.inputs[4] = 25
        run = self.run_cell(device)
        wait_until(lambda: device.coils[0] == 1 and device.registers[10] == 2500)
        self.end(run)
        self.assertEqual((0, 1, 0), (device.coils[0], device.coils[1], device.registers[10]))

    def test_the_outputs_have_safe_values_while_the_master_is_stopped(self):
        device = self.device()
        device.discrete[3] = 1
        run = self.run_cell(device, replace=[('<value name="backoff">', '<value name="watchdog">0.3</value><value name="backoff">')])
        wait_until(lambda: device.coils[0] == 1)
        self.done("stop plc.master")
        wait_until(lambda: (device.coils[0], device.coils[1]) == (0, 1), what="the safe values")
        run.wait_for_line(r"plc.master: \| .*does not run; its outputs now have their safe values")
        self.done("start plc.master")
        wait_until(lambda: device.coils[0] == 1, what="the master to write values again")
        self.end(run)

    def test_a_misbehaving_modbus_device_does_not_delay_a_cycle_of_the_master(self):
        device = self.device()
        device.discrete[3] = 1
        device.inputs[4] = 25
        run = self.run_cell(device)
        wait_until(lambda: device.coils[0] == 1)
        # The failed request may be any of those that the master sends.
        request = r"(reading|writing) [a-z ]+ \d+ to \d+ \(\w+\): "
        refuses = ("refuses", "the device rejected " + request + "Illegal data address; correct the map")
        for mood, words in (refuses,
                            ("garbage", "no valid answer when " + request + "Invalid data"),
                            ("other", "no valid answer when " + request + "Invalid data"),
                            ("silent", "no valid answer when " + request + "Connection timed out"),
                            ("drip", "no valid answer when " + request + "Connection timed out"),
                            refuses):
            begun = len(run.raw)
            device.mood = mood
            run.wait_for_line(words, after=begun)
            time.sleep(2)  # if the message were repeated, it would appear in this time
            device.mood = "well"
            run.wait_for_line(r"plc.master: \| 127.0.0.1:\d+: the exchange works again after \d", after=begun)
            # The master reports a rejection of each of its six requests, but only one message about a lost connection.
            lines = [line.split(" plc.master: | ")[1] for line in run.raw[begun:] if " plc.master: | " in line]
            self.assertEqual(7 if mood == "refuses" else 2, len(set(lines)), run.err)
            self.assertEqual(len(set(lines)), len(lines), run.err)
            device.coils[0] = 0
            wait_until(lambda: device.coils[0] == 1, what="the lamp after " + mood)
        self.assert_on_time(self.end(run))

    def test_values_from_a_modbus_device_are_stale_while_it_is_off(self):
        device = self.device()
        run = self.run_cell(device, replace=[('deadline="300000000"', 'deadline="2000000000"')])  # longer than a stall of the machine
        wait_until(lambda: len(device.requests) > 50)

        def late():
            port = next(p for p in run.modules("plc")["master"]["ports"] if p["name"] == "target")
            return port["late"]
        device.close()
        run.wait_for_line(r"plc.master: \| 127.0.0.1:%d: (no valid answer|no connection)" % device.port)
        time.sleep(3)
        again = modbus.Device(device.port)
        self.addCleanup(again.close)
        again.discrete[3] = 1
        run.wait_for_line(r"the exchange works again")
        wait_until(lambda: again.coils[0] == 1)
        self.assert_on_time(self.end(run))
        self.assertEqual(1, late())

    # The tests below run Takt's device component with Takt's master, and with a master of modbus.py.

    def test_the_master_and_the_device_component_exchange_values(self):
        port = modbus.free_port()
        run = self.start("run", self.descriptor("pair.xml", port), "--json")
        run.wait_for_state("device", "EXECUTING")
        stranger = self.master(port)
        stranger.write_bit(100, 1)
        stranger.write_word(100, -125)
        wait_until(lambda: stranger.read_bits(2, 3) == [1], what="the button")
        wait_until(lambda: stranger.read_bits(1, 0) == [1], what="the lamp")
        wait_until(lambda: stranger.read_words(3, 10, 2) == [0xFFFF, -1250 & 0xFFFF], what="the speed")
        self.assertEqual([-125 & 0xFFFF], stranger.read_words(4, 4))
        for pdu, code in ((struct.pack(">BHH", 1, 5000, 1), 2), (struct.pack(">BHH", 3, 10, 200), 3), (b"\x63\0\0\0\0", 1)):
            with self.assertRaises(modbus.Refused) as refused:
                stranger.ask(pdu)
            self.assertEqual(code, refused.exception.args[0])
        self.assertEqual([1], stranger.read_bits(1, 0))
        self.end(run)

    def test_invalid_data_from_one_modbus_master_does_not_disturb_other_masters(self):
        port = modbus.free_port()
        run = self.start("run", self.descriptor("pair.xml", port), "--json")
        run.wait_for_state("device", "EXECUTING")
        good = self.master(port)
        good.write_bit(100, 1)
        for data in (b"GET / HTTP/1.1\r\nHost: x\r\n\r\n", b"\0\1\0\0\0\6\xff\1", bytes(range(256)) * 8, b"\0" * 7,
                     b"\0\1\0\0\xff\xff\xff\x0f" + b"\xff" * 300, b"\0\1\0\0\0\x09\xff\x10\0\x0a\0\x02\xff\0\1"):
            other = modbus.Master(port)
            other.connection.sendall(data)
            begun = time.monotonic()
            self.assertEqual([1], good.read_bits(1, 100))
            self.assertLess(time.monotonic() - begun, 1.5)
            other.close()
        many = [self.master(port) for _ in range(8)]
        for one in many:
            self.assertEqual([1], one.read_bits(1, 100))
        self.end(run)

    def test_the_master_reconnects_to_a_restarted_device(self):
        port = modbus.free_port()
        run = self.start("run", self.descriptor("pair.xml", port), "--json")
        run.wait_for_state("device", "EXECUTING")
        stranger = self.master(port)
        stranger.write_bit(100, 1)
        wait_until(lambda: stranger.read_bits(1, 0) == [1])
        os.kill(run.one("modbus_device.exe").pid, signal.SIGKILL)
        run.wait_for_line(r"post.device: RECOVER -> EXECUTING")
        run.wait_for_line(r"plc.master: \| .*the exchange works again")
        again = self.master(port)
        again.write_bit(100, 1)
        wait_until(lambda: again.read_bits(1, 0) == [1], what="the lamp of the new device")
        self.end(run)
        self.assertRegex(run.printed("master")[0], r"no valid answer|no connection")
        self.assertRegex(run.printed("master")[1], r"works again")
        self.assert_on_time(run)

    def test_the_device_component_reports_a_tcp_port_that_is_in_use(self):
        device = self.device()
        run = self.takt("run", self.descriptor("pair.xml", device.port), "--for", "1")
        self.assertEqual(1, run.status)
        self.assertRegex(run.err, r"cannot listen on 127.0.0.1:%d: Address already in use; choose a free port" % device.port)

    # The tests below run no cell.

    def test_takt_check_reports_the_line_of_each_error_in_a_modbus_map(self):
        wrong = self.descriptor("cell.xml", 1502, replace=[("discrete 3", "discret 3"), ("int16 scale 0.1", "int16 scale x"),
                                                           ("register 30 int32", "input-register 30 int32")])
        run = self.takt("check", wrong)
        self.assertEqual(1, run.status)
        at = r"cell.xml:12: error: module master: property 'map', line "
        self.assertRegex(run.err, at + r"\d+: unknown table 'discret'; write coil, discrete, register or input-register\n")
        self.assertRegex(run.err, at + r"\d+: the scale cannot be 'x'; write a number that is not 0\n")
        self.assertRegex(run.err, at + r"\d+: an input register cannot be written; write 'in', or 'out register'")
        self.assert_refused(self.takt("run", wrong, "--for", "1"), at)

    def test_takt_describe_lists_a_port_for_each_point_of_the_modbus_map(self):
        out, = self.done("describe --json modbus_device.exe 'map=lamp out coil 0; speed in register 4 unit m/s'")
        ports = {p["name"]: (p["direction"], p["type"]["name"] if isinstance(p["type"], dict) else p["type"], p["text"])
                 for p in json.loads(out)["ports"]}
        self.assertEqual(("out", "basic::Flag", "coil 0"), ports["lamp"])
        self.assertEqual(("in", "basic::Number", "register 4, in m/s"), ports["speed"])
        self.refused({"describe modbus_master.exe": r"property 'map' is missing; write one point per line",
                      "describe modbus_master.exe port=1.5 'map=a in coil 1'": r"property 'port' cannot be '1.5'; it takes a whole"})


if __name__ == "__main__":
    takt_system.main()
