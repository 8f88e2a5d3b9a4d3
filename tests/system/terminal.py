"""A small terminal emulator. A test uses it to read the screen that a program draws, and to press keys."""
import fcntl
import os
import pty
import re
import select
import struct
import termios
import threading

from takt_system import wait_until

UP, DOWN = "\x1b[A", "\x1b[B"
ENTER, ESCAPE = "\r", "\x1b"
_MODES = {"?25": "cursor", "?1049": "alternate", "?7": "wrap"}
_CONTROL = re.compile(r"\x1b\[([?\d;]*)([A-Za-z])")


class Terminal:
    """A screen of `rows` by `columns`. As in xterm, the cursor stays on the last column after a character is drawn there."""

    def __init__(self, rows=24, columns=100):
        self._master, self.slave = pty.openpty()
        self.settings = termios.tcgetattr(self.slave)
        self.alternate = False  # True if the alternate screen is active
        self.cursor = True
        self.wrap = True  # True if text beyond the last column continues on the next line
        self.strange = []  # unknown control sequences, and text outside the screen
        self.seen = 0  # the number of characters that the program has drawn
        self._lock = threading.Lock()
        self._over = threading.Event()
        self.resize(rows, columns)
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def resize(self, rows, columns):
        with self._lock:
            self.rows, self.columns = rows, columns
            self._cells = [[" "] * columns for _ in range(rows)]
            self._row = self._column = 0
            fcntl.ioctl(self.slave, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))

    def become(self):
        """The child process calls this to make this terminal its controlling terminal."""
        fcntl.ioctl(self.slave, termios.TIOCSCTTY, 0)

    def press(self, keys):
        os.write(self._master, keys.encode())

    def restored(self):
        """Returns whether the program has restored all settings of the terminal."""
        return not self.alternate and self.cursor and self.wrap and termios.tcgetattr(self.slave) == self.settings

    def close(self):
        """Closes the terminal. Programs that are still running in it get SIGHUP."""
        if self._over.is_set():
            return
        self._over.set()
        self._reader.join()
        os.close(self.slave)
        os.close(self._master)

    @property
    def lines(self):
        with self._lock:
            return ["".join(row).rstrip() for row in self._cells]

    @property
    def text(self):
        return "\n".join(self.lines)

    def wait_for(self, pattern):
        """Waits until a line of the screen matches `pattern`, and returns this line."""
        expression = re.compile(pattern)

        def find():
            return next((line for line in self.lines if expression.search(line)), None)

        try:
            return wait_until(find, "%r on the screen" % pattern)
        except AssertionError as error:
            raise AssertionError("%s; the screen shows:\n%s" % (error, self.text)) from None

    def _read(self):
        rest = ""
        while not self._over.is_set():
            if not select.select([self._master], [], [], 0.05)[0]:
                continue
            try:
                data = os.read(self._master, 65536)
            except OSError:
                return
            if not data:
                return
            with self._lock:
                text = data.decode(errors="replace")
                self.seen += len(text)
                rest = self._draw(rest + text)

    def _draw(self, text):
        """Draws the text, and returns the rest of it if it ends with an incomplete control sequence."""
        at = 0
        while at < len(text):
            if text[at] == "\x1b":
                match = _CONTROL.match(text, at)
                if match is None:
                    if len(text) - at < 16:
                        return text[at:]
                    self.strange.append(text[at:at + 16])
                    at += 1
                    continue
                self._control(match[1], match[2])
                at = match.end()
                continue
            self._put(text[at])
            at += 1
        return ""

    def _control(self, numbers, name):
        if name == "H":
            row, column = (int(n) - 1 for n in (numbers or "1;1").split(";"))
            self._row, self._column = row, column
            if row >= self.rows or column >= self.columns:
                self.strange.append("row %d, column %d of %d by %d" % (row, column, self.rows, self.columns))
                self._row = self.rows - 1
        elif name == "J" and numbers == "":
            if (self._row, self._column) != (0, 0):
                self.strange.append("a part of the screen cleared")
            self._cells = [[" "] * self.columns for _ in range(self.rows)]
        elif name == "K" and numbers in ("", "0", "2"):
            if self._row < self.rows:
                begin = 0 if numbers == "2" else min(self._column, self.columns - 1)
                self._cells[self._row][begin:] = [" "] * (self.columns - begin)
        elif name in "hl" and numbers in _MODES:
            setattr(self, _MODES[numbers], name == "h")
        elif name != "m":
            self.strange.append("CSI %s %s" % (numbers, name))

    def _put(self, character):
        if character == "\r":
            self._column = 0
        elif character == "\n":
            self._row += 1
            if self._row >= self.rows:
                self.strange.append("a line below the last")
                self._row = self.rows - 1
        elif self._column >= self.columns:
            self.strange.append("%r right of the last column" % character)
        else:
            self._cells[self._row][self._column] = character
            self._column += 1
