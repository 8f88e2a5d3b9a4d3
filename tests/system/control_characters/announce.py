"""Announces a participant with any name to the participants of one DDS domain on this machine, and pretends that it sends more than
announcements. Usage: announce.py DOMAIN NAME_IN_HEX; runs until it is killed."""
import socket
import struct
import sys
import time

MULTICAST = "239.255.0.1"
PREFIX = b"\x01\x0f" + b"\x77" * 10
SPDP_WRITER, SPDP_READER = bytes.fromhex("000100c2"), bytes.fromhex("000100c7")
SEDP_WRITER, SEDP_READER = bytes.fromhex("000003c2"), bytes.fromhex("000003c7")
SILENT_PORT = 45678  # nothing listens there


def parameter(number, value):
    value += bytes(-len(value) % 4)
    return struct.pack("<HH", number, len(value)) + value


def announcement(name):
    locator = struct.pack("<iI", 1, SILENT_PORT) + bytes(12) + socket.inet_aton("127.0.0.1")
    text = name + b"\0"
    parameters = (
        parameter(0x15, b"\x02\x03")  # version of RTPS
        + parameter(0x16, b"\x01\x0f")  # vendor
        + parameter(0x50, PREFIX + bytes.fromhex("000001c1"))  # GUID
        + parameter(0x58, struct.pack("<I", 0xC3F))  # built-in endpoints
        + parameter(0x02, struct.pack("<iI", 20, 0))  # lease
        + parameter(0x31, locator) + parameter(0x32, locator)
        + parameter(0x62, struct.pack("<I", len(text)) + text)  # name
        + struct.pack("<HH", 1, 0))
    body = struct.pack("<HH", 0, 16) + SPDP_READER + SPDP_WRITER + struct.pack("<iI", 0, 1) + bytes((0, 3, 0, 0)) + parameters
    return b"RTPS\x02\x03\x01\x0f" + PREFIX + struct.pack("<BBH", 0x15, 5, len(body)) + body


def heartbeat():
    body = SEDP_READER + SEDP_WRITER + struct.pack("<iIiII", 0, 1, 0, 0, 1)
    return b"RTPS\x02\x03\x01\x0f" + PREFIX + struct.pack("<BBH", 0x07, 1, len(body)) + body


def main():
    base = 7400 + 250 * int(sys.argv[1])
    packets = announcement(bytes.fromhex(sys.argv[2])), heartbeat()
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    sender.bind(("127.0.0.1", 0))
    sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton("127.0.0.1"))
    while True:
        for packet in packets:
            for address in [(MULTICAST, base)] + [("127.0.0.1", base + 10 + 2 * i) for i in range(12)]:
                try:
                    sender.sendto(packet, address)
                except OSError:  # nothing listens there
                    pass
        time.sleep(0.1)


main()
