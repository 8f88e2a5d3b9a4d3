"""Counts the RTPS packets that are sent in the network of this process. This needs root."""
import socket
import struct
import threading
import time
from collections import Counter

SUBMESSAGES = {0x06: "ACKNACK", 0x07: "HEARTBEAT", 0x08: "GAP", 0x12: "NACK_FRAG", 0x13: "HEARTBEAT_FRAG", 0x15: "DATA", 0x16: "DATA_FRAG"}
INFO_DST = 0x0e
DISCOVERY = {0x000100c2: "the discovery of participants", 0x000003c2: "the discovery of writers", 0x000004c2: "the discovery of readers",
             0x000200c2: "the liveliness of participants"}
TOPIC_NAME, ENDPOINT_GUID, SENTINEL = 0x05, 0x5a, 0x01  # parameters in samples of discovery


def submessages(packet):
    """Returns (kind, GUID of the writer, body) for each submessage that concerns a writer in an RTPS packet."""
    sender, receiver, found, at = packet[8:20], b"", [], 20
    while at + 4 <= len(packet):
        kind, flags = packet[at], packet[at + 1]
        length = struct.unpack_from("<H" if flags & 1 else ">H", packet, at + 2)[0]
        body = packet[at + 4:at + 4 + length] if length else packet[at + 4:]
        if kind == INFO_DST:
            receiver = body[:12]
        elif kind in (0x06, 0x12):  # ACKNACK and NACK_FRAG, which a reader sends to a writer
            found.append((SUBMESSAGES[kind], receiver + body[4:8], body))
        elif kind in SUBMESSAGES:
            begin = 8 if kind in (0x15, 0x16) else 4
            found.append((SUBMESSAGES[kind], sender + body[begin:begin + 4], body))
        at += 4 + len(body)
    return found


def endpoint(body):
    """Returns the GUID and the topic of the writer or reader that a sample of discovery describes, or None."""
    at, guid, topic = 24, None, None
    while at + 4 <= len(body):
        parameter, length = struct.unpack_from("<HH", body, at)
        value = body[at + 4:at + 4 + length]
        if parameter == ENDPOINT_GUID:
            guid = value[:16]
        elif parameter == TOPIC_NAME:
            topic = value[4:].split(b"\0")[0].decode()
        elif parameter == SENTINEL:
            break
        at += 4 + length
    return (guid, topic) if guid and topic else None


class Traffic:
    """Counts all packets that are sent in this network, from __enter__ to __exit__."""

    def __enter__(self):
        self.topics = {}  # by the GUID of the writer or reader
        self.submessages = Counter()  # by kind and topic
        self.samples = {}  # by topic: how often each sample was sent
        self.packets = self.bytes = 0
        self._socket = socket.socket(socket.AF_PACKET, socket.SOCK_DGRAM, socket.htons(0x0003))  # ETH_P_ALL
        self._socket.setsockopt(socket.SOL_SOCKET, 33, 1 << 28)  # SO_RCVBUFFORCE
        self._socket.settimeout(0.2)
        self._ends = False
        self._lock = threading.Lock()
        self._thread = threading.Thread(target=self._listen)
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._ends = True
        self._thread.join()
        self._socket.close()

    def _listen(self):
        while not self._ends:
            try:
                packet, (_, _, direction, *_) = self._socket.recvfrom(65536)
            except TimeoutError:
                continue
            rtps = packet[4 * (packet[0] & 15) + 8:]
            if direction != socket.PACKET_OUTGOING or packet[9] != socket.IPPROTO_UDP or rtps[:4] != b"RTPS":
                continue
            with self._lock:
                self.packets += 1
                self.bytes += len(packet)
                for kind, writer, body in submessages(rtps):
                    discovery = DISCOVERY.get(int.from_bytes(writer[12:], "big"))
                    if discovery and kind == "DATA" and (found := endpoint(body)):
                        self.topics[found[0]] = found[1]
                    topic = discovery or self.topics.get(writer, "an unknown topic")
                    self.submessages[kind, topic] += 1
                    if kind == "DATA":
                        self.samples.setdefault(topic, Counter())[writer, body[12:20]] += 1

    def count(self, kind, topic):
        """Returns how many submessages of this kind the readers or writers of a topic have sent."""
        with self._lock:
            return self.submessages[kind, topic]

    def sent(self, topic):
        """Returns how often each sample of a topic was sent, by sample."""
        with self._lock:
            return Counter(self.samples.get(topic))

    def over(self, seconds):
        """Counts for this number of seconds. Returns the packets, the bytes, and the submessages by (kind, topic), all per second."""
        with self._lock:
            packets, octets, before, begun = self.packets, self.bytes, self.submessages.copy(), time.monotonic()
        time.sleep(seconds)
        with self._lock:
            took = time.monotonic() - begun
            return ((self.packets - packets) / took, (self.bytes - octets) / took,
                    {what: n / took for what, n in (self.submessages - before).items()})
