"""A network cable that loses, delays and limits packets: the program `poor_link.py A B LOSS DELAY RATE FIRST` passes all frames between the
network interfaces A and B. LOSS is the fraction of frames that it drops, DELAY is in seconds, and RATE in bits per second (0: no limit). If
more than a second of frames waits, it drops further ones, as a modem does. It also drops the first FIRST copies of each discovery message
that announces a reader or writer. For each line on its standard input, it prints how many bytes it
has passed from A to B and from B to A, and how many frames it has dropped.

The kernel has network emulation (sch_netem) for this, but not every kernel is built with it."""

import collections
import random
import select
import socket
import sys
import time

SOL_PACKET, PACKET_VNET_HDR, PACKET_IGNORE_OUTGOING = 263, 15, 23
HEADER = 10  # PACKET_VNET_HDR puts this many bytes before each frame, for checksums that are still to be computed
LONGEST_QUEUE = 1.0


def discovery_messages(frame):
    """Yields the sender, writer and number of each DATA of RTPS in the frame that announces a reader or writer (RTPS 2.5, 9.4 and 9.6)."""
    begin = frame.find(b"RTPS")
    at = begin + 20
    while begin >= 0 and at + 4 <= len(frame):
        kind, length = frame[at], int.from_bytes(frame[at + 2:at + 4], "little")
        if kind == 0x15 and frame[at + 12:at + 16] in (b"\0\0\x03\xc2", b"\0\0\x04\xc2"):
            yield frame[begin + 8:begin + 20] + frame[at + 12:at + 24]
        if length == 0:
            return
        at += 4 + length


class Way:
    """One direction of the cable."""

    def __init__(self, source, destination):
        self.source, self.destination = source, destination
        self.waiting = collections.deque()  # (time to send, frame)
        self.free = 0.0  # the time at which the last waiting frame has left the sender
        self.bytes = self.dropped = 0
        self.copies = collections.Counter()  # of each discovery message

    def take(self, now, loss, delay, rate, first):
        frame = self.source.recv(70000)
        begin = max(now, self.free)
        messages = list(discovery_messages(frame)) if first else []
        self.copies.update(messages)
        too_early = any(self.copies[each] <= first for each in messages)
        if too_early or random.random() < loss or begin - now > LONGEST_QUEUE:
            self.dropped += 1
            return
        self.bytes += len(frame) - HEADER
        self.free = begin + (8 * (len(frame) - HEADER) / rate if rate else 0)
        self.waiting.append((self.free + delay, frame))

    def give(self, now):
        while self.waiting and self.waiting[0][0] <= now:
            try:
                self.destination.send(self.waiting.popleft()[1])
            except OSError:  # the interface is down
                self.dropped += 1


def end(interface):
    one = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(3))
    one.setsockopt(SOL_PACKET, PACKET_VNET_HDR, 1)
    one.setsockopt(SOL_PACKET, PACKET_IGNORE_OUTGOING, 1)
    one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4 << 20)
    one.bind((interface, 0))
    return one


def main():
    a, b = end(sys.argv[1]), end(sys.argv[2])
    loss, delay, rate, first = (float(text) for text in sys.argv[3:7])
    ways = [Way(a, b), Way(b, a)]
    print("ready", flush=True)
    while True:
        due = [way.waiting[0][0] for way in ways if way.waiting]
        ready = select.select([a, b, sys.stdin], [], [], max(0.0, min(due) - time.monotonic()) if due else None)[0]
        now = time.monotonic()
        for way in ways:
            if way.source in ready:
                way.take(now, loss, delay, rate, first)
            way.give(now)
        if sys.stdin in ready:
            if not sys.stdin.readline():
                return
            print(ways[0].bytes, ways[1].bytes, ways[0].dropped + ways[1].dropped, flush=True)


if __name__ == "__main__":
    main()
