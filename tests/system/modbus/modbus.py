"""A device and a master for Modbus TCP, written according to the specification (Application Protocol V1.1b3, Messaging on TCP/IP V1.0b),
without the library that Takt uses. The device can misbehave."""

import random
import socket
import struct
import threading
import time

ILLEGAL_ADDRESS = 2


def free_port():
    """Returns a free TCP port below the range that the kernel uses for outgoing connections, so that the port stays free until the test
    uses it."""
    ports = list(range(12000, 30000))
    random.shuffle(ports)
    for port in ports:
        with socket.socket() as probe:
            try:
                probe.bind(("127.0.0.1", port))
                return port
            except OSError:
                pass
    raise AssertionError("no port is free")


def _bits(values):
    packed = bytearray((len(values) + 7) // 8)
    for i, value in enumerate(values):
        packed[i // 8] |= bool(value) << i % 8
    return bytes(packed)


def _unpacked(data, count):
    return [data[i // 8] >> i % 8 & 1 for i in range(count)]


def _exactly(connection, count):
    data = b""
    while len(data) < count:
        more = connection.recv(count - len(data))
        if not more:
            raise ConnectionError("closed")
        data += more
    return data


class Device:
    """A Modbus device with one address map. `mood` selects how it answers requests: "well", "refuses", "garbage", "silent", "drip" (byte by
    byte) or "other" (answers a different request)."""

    def __init__(self, port=None):
        self.coils = dict.fromkeys(range(64), 0)
        self.discrete = dict.fromkeys(range(64), 0)
        self.registers = dict.fromkeys(range(64), 0)
        self.inputs = dict.fromkeys(range(64), 0)
        self.mood = "well"
        self.requests = []  # (function, address, count)
        self._listener = socket.create_server(("127.0.0.1", port or free_port()))
        self.port = self._listener.getsockname()[1]
        self._connections = []
        threading.Thread(target=self._accept, daemon=True).start()

    def close(self):
        try:
            self._listener.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        self._listener.close()
        for connection in self._connections:
            try:
                connection.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass
            connection.close()

    def _accept(self):
        while True:
            try:
                connection, _ = self._listener.accept()
            except OSError:
                return
            self._connections.append(connection)
            threading.Thread(target=self._serve, args=(connection,), daemon=True).start()

    def _serve(self, connection):
        try:
            while True:
                transaction, protocol, length, unit = struct.unpack(">HHHB", _exactly(connection, 7))
                request = _exactly(connection, length - 1)
                mood = self.mood
                if mood == "silent":
                    continue
                if mood == "garbage":
                    connection.sendall(b"\xde\xad\xbe\xef" * 20)
                    continue
                if mood == "refuses":
                    answer = struct.pack(">BB", request[0] | 0x80, ILLEGAL_ADDRESS)
                else:
                    answer = self._answer(request)
                if mood == "other":
                    transaction ^= 0x5555
                frame = struct.pack(">HHHB", transaction, protocol, len(answer) + 1, unit) + answer
                if mood == "drip":
                    for i in range(len(frame)):
                        connection.sendall(frame[i:i + 1])
                        time.sleep(0.1)
                else:
                    connection.sendall(frame)
        except (OSError, ConnectionError):
            pass

    def _answer(self, request):
        function, address, count = struct.unpack(">BHH", request[:5])
        self.requests.append((function, address, count))
        try:
            if function in (1, 2):
                table = self.coils if function == 1 else self.discrete
                data = _bits([table[address + i] for i in range(count)])
                return struct.pack(">BB", function, len(data)) + data
            if function in (3, 4):
                table = self.registers if function == 3 else self.inputs
                data = struct.pack(">%dH" % count, *[table[address + i] for i in range(count)])
                return struct.pack(">BB", function, len(data)) + data
            if function == 15:
                for i, bit in enumerate(_unpacked(request[6:], count)):
                    self.coils[address + i] = bit
                return request[:5]
            if function == 16:
                for i, word in enumerate(struct.unpack(">%dH" % count, request[6:6 + 2 * count])):
                    self.registers[address + i] = word
                return request[:5]
        except KeyError:
            return struct.pack(">BB", function | 0x80, ILLEGAL_ADDRESS)
        return struct.pack(">BB", function | 0x80, 1)


class Refused(Exception):
    """The device answered with a Modbus exception. The argument is the exception code."""


class Master:
    def __init__(self, port, timeout=10.0):
        self.connection = socket.create_connection(("127.0.0.1", port), timeout)
        self._transaction = 0

    def close(self):
        self.connection.close()

    def ask(self, pdu):
        self._transaction += 1
        self.connection.sendall(struct.pack(">HHHB", self._transaction, 0, len(pdu) + 1, 255) + pdu)
        transaction, protocol, length, _ = struct.unpack(">HHHB", _exactly(self.connection, 7))
        answer = _exactly(self.connection, length - 1)
        assert (transaction, protocol) == (self._transaction, 0)
        if answer[0] & 0x80:
            raise Refused(answer[1])
        assert answer[0] == pdu[0]
        return answer

    def read_bits(self, function, address, count=1):
        return _unpacked(self.ask(struct.pack(">BHH", function, address, count))[2:], count)

    def read_words(self, function, address, count=1):
        return list(struct.unpack(">%dH" % count, self.ask(struct.pack(">BHH", function, address, count))[2:]))

    def write_bit(self, address, value):
        self.ask(struct.pack(">BHH", 5, address, 0xFF00 if value else 0))

    def write_word(self, address, value):
        self.ask(struct.pack(">BHH", 6, address, value & 0xFFFF))
