"""Writes the seeds of the fuzzers: messages and files like those of real nodes, modules and Modbus masters.

seeds.py FOLDER writes the folders command_seeds, kept_seeds, modbus_seeds, rtps_seeds and sample_seeds into FOLDER."""

import json
import os
import struct
import sys

# ---- Seeds of command_fuzz. Time and names are the same as in tests/unit/agent/fake_device.hpp.

NOW = 1_700_000_005_000_000_000
(REPORT, DESCRIPTOR, DESCRIBE, PREPARE, RUN, UNDEPLOY, INITIALIZE, START, STOP, RECOVER, RESET, DESTRUCT, GET, SET, TAP,
 LOG, TRACE, SWAP, CHANGE, PUT_BACK) = range(20)
CELL = """<cell name="cell"><device name="robot">
<module><name>servo</name><filename>servo.so</filename><moduletype>thread</moduletype><operationtype>periodic</operationtype>
<period>1000000</period><priority>1</priority><property><value name="gain">1</value></property></module></device></cell>"""


class Cdr:
    """Encodes values as XCDR1, in little-endian or big-endian byte order, with the encapsulation."""

    def __init__(self, order="<"):
        self.order = order
        self.body = b""

    def number(self, code, value):
        size = struct.calcsize(code)
        self.body += b"\0" * (-len(self.body) % size) + struct.pack(self.order + code, value)
        return self

    def text(self, text):
        self.number("I", len(text) + 1)
        self.body += text.encode() + b"\0"
        return self

    def octets(self, data):
        self.number("I", len(data))
        self.body += data
        return self

    def bytes(self):
        return bytes([0, self.order == "<", 0, 0]) + self.body


def command(kind, order="<", part=0, parts=1, data=b"", module="", deployment="d1", name="", value="", time=0, deadline=NOW + 10**9,
            node=""):
    cdr = Cdr(order)
    for text in ("asker-%d" % kind, "robot", node, module):
        cdr.text(text)
    cdr.number("I", kind)
    for text in (deployment, name, value):
        cdr.text(text)
    cdr.number("q", time).number("q", deadline).number("I", part).number("I", parts).octets(data)
    return b"c" + counted(cdr.bytes())


def counted(data):
    return struct.pack("<H", len(data)) + data


WAITING, RUNNING_STATE, ENDED = 0, 5, 7  # values of DeviceState


def device(state, name="line", health=0, stops=False, deployment="d1", undeployed="", transaction="d1",
           stage=4):
    cdr = Cdr()
    for text in ("cell/" + name, "cell", name, "there", "elsewhere"):
        cdr.text(text)
    cdr.number("I", state).number("I", health).text("why").number("B", stops).text(deployment).number("q", NOW).text(undeployed).number("B", 1)
    cdr.number("i", 42).number("i", 43).number("I", 0).number("I", 1).number("I", 1).number("Q", 5).number("q", NOW)
    cdr.number("q", 7 * 10**9).number("I", 1).text("here").number("q", 5 * 10**9 - 10**6).number("q", 10**5)  # an answer
    cdr.text(transaction).number("I", stage)
    return b"d" + counted(cdr.bytes())


def module(state):
    cdr = Cdr()
    for text in ("cell/line/belt", "cell", "line", "belt"):
        cdr.text(text)
    cdr.number("I", state).number("I", 2).number("I", 3).number("I", 0).text("").number("Q", 4).number("q", NOW)
    return b"m" + counted(cdr.bytes())


SAFE = [{"device": "robot", "module": "servo", "port": "out", "safe": "{}"}]


def prepare(name, text=CELL):
    return command(PREPARE, data=text.encode(), name=name, value="cell.xml")


def change(*devices, name="u", time=NOW):
    return command(CHANGE, name=name, time=time, data=json.dumps({"devices": devices or ("robot",), "safe": SAFE}).encode())


def update(gain):
    return prepare("u", CELL.replace('"gain">1', gain))


PREPARED = prepare("d1")
STARTING = PREPARED + b"i" + change(name="d1", time=0)
RUNNING = STARTING + b"r" + command(RUN, name="d1", time=NOW + 5 * 10**8) + b"t\x09s\3"


KEPT = command(RUN, name="u", time=NOW + 10**9) + b"t\x0a"


COMMANDS = {
    "report": command(REPORT) + command(REPORT, order=">"),
    "run": RUNNING + b"t\x0a" + command(UNDEPLOY) + b"e",
    "modules": RUNNING + command(STOP, module="servo") + command(START) + command(GET, module="servo", name="gain") +
    command(SET, module="servo", name="gain", value="2.5") + b"o\0" + command(TAP, module="servo", name="out", time=NOW + 10**10),
    "errors": RUNNING + command(RECOVER, module="servo") + command(RESET, module="servo") + command(DESTRUCT) +
    command(INITIALIZE) + b"o\1" + b"e" + command(REPORT) + command(UNDEPLOY),
    "describe": STARTING + command(DESCRIBE) + b"i" + command(DESCRIBE) + command(UNDEPLOY),
    "descriptor": command(DESCRIPTOR) + RUNNING + command(DESCRIPTOR),
    "describing": RUNNING + command(DESCRIBE) + command(UNDEPLOY),
    "refused": PREPARED + b"f" + prepare("d2", "<cell>") + command(RUN) + command(START, deadline=1),
    "log": command(LOG, data=json.dumps({"module": "servo", "kinds": ["error", "overrun"], "after": 1, "since_ns": 5,
                                         "last": 10}).encode()) + command(TRACE, value="1000000"),
    "trace": RUNNING + command(TRACE, value="1000000"),
    "others": RUNNING + device(RUNNING_STATE) + module(3) + b"t\x0a" + command(REPORT) + b"l" + device(ENDED, health=2, stops=True) + b"g",
    "undeployed": RUNNING + command(UNDEPLOY) + b"e" + device(RUNNING_STATE) + device(WAITING, deployment="", undeployed="d1"),
    "namesake": device(WAITING, name="robot", deployment="") + PREPARED,
    "never": STARTING + b"r" + b"t\x0f" + b"t\x0f" + b"e",
    "swap": RUNNING + command(SWAP, module="servo", value="servo2.so") + b"i" + b"o\0",
    "in_place": RUNNING + update('"gain">2').replace(b"servo.so", b"serv2.so") + b"i" + change() + b"o\0" * 3 + KEPT + command(REPORT),
    "put_back": RUNNING + update('"gain">2') + b"i" + change() + b"o\0" * 2 + command(PUT_BACK, name="u") + b"o\0",
    "failing": RUNNING + update('"gain">2') + b"i" + change() + b"o\1",
    "anew": RUNNING + update('"other">1') + b"i" + change() + b"er" + KEPT + b"e",
    "anew_fails": RUNNING + update('"other">1') + b"i" + change() + b"eer" + command(PUT_BACK, name="u"),
    "added": update('"gain">1') + b"i" + change("robot", "line") + b"r" + device(WAITING, transaction="u", stage=0) + command(PUT_BACK, name="u") + b"e",
    "forward": RUNNING + update('"other">1') + b"i" + change("robot", "line") + b"er" + command(PUT_BACK, name="u") + b"er" +
    device(RUNNING_STATE, transaction="u", stage=4) + b"eir" + command(REPORT),
    "forgotten": RUNNING + update('"gain">2') + b"i" + b"t\x0f" + change(),
}

# ---- Seeds of kept_fuzz

KEPT_DEPLOYMENT = {"id": "d1", "transaction": "u1", "file": "cell.xml", "text": CELL, "require_real_time": False, "t0_ns": NOW, "boot": "3f1c",
                   "t0_monotonic_ns": 1, "safe": "[]", "devices": ["robot", "line"]}
DEPLOYMENT = json.dumps({"current": KEPT_DEPLOYMENT, "pending": None}, separators=(",", ":")).encode()


def slot(sequence, kind=0, text=b"took too long"):
    texts = [(b"budget", 16), (b"cell", 64), (b"robot", 64), (b"servo", 64), (text, 512)]
    fields = struct.pack("<QqQQII", sequence, NOW, 10, 1, kind, 0)
    return fields + b"".join(text.ljust(room, b"\0") for text, room in texts)


def slots(number, *placed):
    return b"f" + bytes([number]) + b"".join(bytes([at]) + counted(body) for at, body in placed)


KEPT = {
    "deployment": b"d" + DEPLOYMENT,
    "damaged": b"Dtakt deployment 3 0123456789abcdef\n" + DEPLOYMENT,
    "saved": b"s" + json.dumps({"version": 2, "bytes": "00ff10"}).encode(),
    "other": b"Stakt saved 2 0123456789abcdef\n{}",
    "faults": slots(8, (0, slot(1, 14)), (1, slot(2)), (2, slot(3, 20))),
    "overwritten": slots(4, (3, slot(8)), (0, slot(9)), (1, slot(6)), (2, slot(7))),
    "record": b"F" + struct.pack("<QQQ", 0x74616B74666C0001, 4, 0),
}

# ---- Seeds of modbus_fuzz

MAP = b"""lamp        out coil 0 safe 0
button      in  discrete 3
speed       out register 10 scale 0.001 unit m/s safe 0
level       out register 11 uint32 order low-first offset -5
temperature in  input-register 4 int16 scale 0.1 unit degC
position    in  register 20 float32 order low-first      # two registers
target      out register 30 float32
"""


def frame(function, *words, tail=b""):
    body = struct.pack(">BB%dH" % len(words), 1, function, *words) + tail
    return struct.pack(">HHH", 7, 0, len(body)) + body


MODBUS = {
    "map": MAP,
    "one": b"a out coil 65535; b in input-register 65534 float32 # both at the end",
    "mistakes": b"lamp out discrete 0\nlamp in coil 70000 scale 2\nx up spool -1 order last safe nan",
    "reads": MAP + b"\0" + frame(1, 0, 1) + frame(2, 3, 1) + frame(3, 10, 3) + frame(4, 4, 1) + frame(3, 20, 2),
    "writes": MAP + b"\0" + frame(5, 0, 0xFF00) + frame(6, 10, 1250) + frame(15, 0, 1, tail=b"\1\1") +
    frame(16, 10, 3, tail=b"\6\0\1\0\2\0\3") + frame(22, 10, 0xFF, 0x55) + frame(16, 30, 2, tail=b"\4\x7f\x7f\xff\xff") + frame(23, 20, 1, 11, 2, tail=b"\4\0\1\0\2"),
    "refused": MAP + b"\0" + frame(3, 100, 1) + frame(16, 10, 200, tail=b"\xff") + frame(99, 0, 0) + frame(17),
}

# ---- Seeds of rtps_fuzz


def submessage(kind, flags, body):
    return struct.pack("<BBH", kind, flags | 1, len(body)) + body


def parameter(which, body):
    return struct.pack("<HH", which, len(body)) + body


def text(characters):
    data = characters.encode() + b"\0"
    return struct.pack("<I", len(data)) + data + b"\0" * (-len(data) % 4)


HEADER = b"RTPS\2\3\1\x0f" + bytes(range(12))
INFO = submessage(0x0E, 0, bytes(12)) + submessage(0x09, 0, bytes(8))
SPDP, PUBLICATIONS, PROOFS = b"\0\1\0\xc2", b"\0\0\3\xc2", b"\0\2\1\xc3"


def data(writer, flags, content, number=1):
    return submessage(0x15, flags, struct.pack("<HH", 0, 16) + bytes(4) + writer + struct.pack("<iI", 0, number) + content)


PARAMETERS = (parameter(0x15, b"\2\3\0\0") + parameter(0x50, bytes(16)) + parameter(0x31, bytes(24)) + parameter(0x58, b"\x3f\x0c\0\0") +
              parameter(0x59, struct.pack("<I", 1) + text("name") + text("value")) + parameter(0x2C, struct.pack("<I", 3) + bytes(4)) +
              parameter(1, b""))
TOPIC = parameter(5, text("takt/device")) + parameter(7, text("takt::DeviceStatus")) + parameter(0x29, struct.pack("<I", 1) + text("a")) + parameter(1, b"")
TOKEN = text("DDS:Auth:PKI-DH:1.0+Req") + struct.pack("<I", 1) + text("name") + text("value") + struct.pack("<I", 1) + text("c.id") + struct.pack("<I", 4) + b"cert"
STATE = bytes(8) + struct.pack("<iI", 0, 1)
RTPS = {
    "participant": HEADER + INFO + data(SPDP, 4, b"\0\3\0\0" + PARAMETERS),
    "writer": HEADER + INFO + data(PUBLICATIONS, 6, parameter(0x70, bytes(16)) + parameter(1, b"") + b"\0\3\0\0" + TOPIC),
    "sample": HEADER + INFO + data(b"\0\0\1\3", 4, b"\0\1\0\0" + bytes(20)) +
    submessage(0x07, 0, STATE + struct.pack("<iII", 0, 9, 1)),
    "answers": HEADER + submessage(0x06, 0, STATE + struct.pack("<III", 33, 0, 0) + bytes(4)) +
    submessage(0x08, 0, STATE + struct.pack("<iII", 0, 2, 0)) + submessage(0x12, 0, STATE + struct.pack("<IIII", 1, 1, 0, 1)) +
    submessage(0x13, 0, STATE + struct.pack("<II", 1, 1)),
    "fragment": HEADER + submessage(0x16, 0, struct.pack("<HH", 0, 28) + STATE + struct.pack("<IHHI", 1, 1, 100, 150) + bytes(100)),
    "secured": HEADER + submessage(0x33, 0, bytes(20)) + submessage(0x30, 0, struct.pack(">I", 8) + bytes(8)) +
    submessage(0x34, 0, bytes(16) + struct.pack(">I", 1) + bytes(20)),
    "secured_parts": HEADER + INFO + (submessage(0x31, 0, bytes(20)) + submessage(0x30, 0, struct.pack(">I", 8) + bytes(8)) +
                                      submessage(0x32, 0, bytes(20))) * 2,
    "tokens": HEADER + data(SPDP, 4, b"\0\3\0\0" + parameter(0x1001, TOKEN) + parameter(0x1002, TOKEN) + parameter(1, b"")),
    "proof": HEADER + INFO + data(PROOFS, 4, b"\0\1\0\0" + bytes(96) + text("dds.sec.auth") + struct.pack("<I", 1) + TOKEN),
    "others": HEADER + submessage(0x0C, 0, bytes(20)) + submessage(0x0F, 2, struct.pack("<I", 1) + bytes(24) + struct.pack("<I", 0)) +
    submessage(0x01, 0, b"") + submessage(0x80, 0, bytes(5)),
}

# ---- Seeds of sample_fuzz


def scalars(order):
    cdr = Cdr(order).number("B", 1).number("B", 2).number("B", 65).number("h", -3).number("H", 4).number("i", -5).number("I", 6)
    cdr.number("q", -7).number("Q", 8).number("f", 0.5).number("d", 0.25).number("b", -9).number("B", 10).number("h", -11)
    cdr.number("H", 12).number("i", -13).number("I", 14).number("q", -15).number("Q", 16).text("name").number("I", 2)
    return cdr


def part(order, cdr=None):
    return (cdr or Cdr(order)).number("B", 3).number("Q", 4).text("label")


def whole(order, n):
    """Encodes an everything::Whole with n elements in each sequence, or as many as the bound of the sequence allows."""
    cdr = scalars(order)
    cdr.text("label")
    part(order, cdr)
    cdr.number("B", 66).number("d", 1.5)

    def each(count, make):
        for _ in range(count):
            make()

    def number(code, value=1):
        return lambda: cdr.number(code, value)

    def listed(bound, make):
        cdr.number("I", min(n, bound))
        each(min(n, bound), make)

    each(3, number("B"))
    each(5, number("B", 67))
    each(6, number("d"))
    each(4, lambda: cdr.text("abc"))
    each(3, number("I"))
    each(4, lambda: part(order, cdr))
    each(6, number("i"))
    each(12, number("i"))
    listed(5, number("B"))
    listed(7, number("B"))
    listed(3, number("B", 68))
    listed(3, number("h"))
    listed(4, number("d"))
    listed(3, lambda: cdr.text("sixsix"))
    listed(3, number("I"))
    listed(3, lambda: part(order, cdr))
    listed(2, lambda: each(6, number("i")))
    listed(6, lambda: cdr.text("seven77"))
    listed(4, number("d"))
    each(2, lambda: listed(4, number("d")))
    each(2, lambda: listed(2, number("q")))
    each(3, number("B"))
    return cdr


SAMPLES = {}
for mark, order in (("little", "<"), ("big", ">")):
    SAMPLES["scalars_" + mark] = b"s" + scalars(order).bytes()
    SAMPLES["part_" + mark] = b"p" + part(order).bytes()
    for n in (0, 1, 9):
        SAMPLES["whole_%d_%s" % (n, mark)] = b"w" + whole(order, n).bytes()


def main():
    for what, inputs in (("command", COMMANDS), ("kept", KEPT), ("modbus", MODBUS), ("rtps", RTPS), ("sample", SAMPLES)):
        folder = os.path.join(sys.argv[1], what + "_seeds")
        os.makedirs(folder, exist_ok=True)
        for name, data in inputs.items():
            with open(os.path.join(folder, name), "wb") as file:
                file.write(data)


main()
