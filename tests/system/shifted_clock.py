"""A wall clock that a test can set, for the programs that it starts."""
import mmap
import os
import struct

LIBRARY = os.environ.get("TAKT_SHIFTED_CLOCK_LIBRARY", "")


class WallClock:
    """The wall clock that the programs of one device see. Setting this clock does not change the clock of the machine."""

    def __init__(self, path):
        assert os.path.exists(LIBRARY), "set TAKT_SHIFTED_CLOCK_LIBRARY to shifted_clock.so"
        with open(path, "wb") as file:
            file.write(struct.pack("qq", 0, 0))
        with open(path, "r+b") as file:
            self._words = mmap.mmap(file.fileno(), 16)
        self.environment = {"LD_PRELOAD": LIBRARY, "TAKT_SHIFTED_CLOCK": path}

    def set_by(self, seconds):
        """Sets this clock to `seconds` ahead of the clock of the machine."""
        struct.pack_into("q", self._words, 0, int(seconds * 10**9))

    @property
    def waits(self):
        """Returns how often a program has waited until a certain time of this clock."""
        return struct.unpack_from("q", self._words, 8)[0]
