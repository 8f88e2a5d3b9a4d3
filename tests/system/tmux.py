"""Runs a program in tmux, reads the screen that tmux shows, and sends keys to the program. tmux is a real terminal multiplexer."""
import os
import re
import shlex
import signal
import subprocess

from takt_system import LONG, Process, wait_until


class Tmux:
    """A tmux server that has its socket in `folder`."""

    def __init__(self, folder, arguments, columns=80, rows=24, environment=None):
        self._socket = os.path.join(folder, "tmux")
        settings = os.path.join(folder, "tmux.conf")
        with open(settings, "w", encoding="utf-8") as file:
            file.write("set -g status off\nset -g default-shell /bin/sh\n")
        # The screen uses UTF-8, whatever the locale of the test is.
        self._environment = dict(os.environ, LC_ALL="C.UTF-8", **(environment or {}))
        self._do("-f", settings, "new-session", "-d", "-x", str(columns), "-y", str(rows), "-c", folder,
                 shlex.join(arguments))
        self._server = int(self.show("pid"))

    def _do(self, *arguments):
        return subprocess.run(["tmux", "-u", "-S", self._socket, *arguments], env=self._environment, check=True,
                              capture_output=True, text=True, timeout=LONG).stdout

    def close(self):
        """Kills the server by its process id, because the folder that contains its socket may no longer exist."""
        try:
            os.kill(self._server, signal.SIGTERM)
        except ProcessLookupError:
            return
        wait_until(lambda: not Process(self._server, "tmux", []).alive, "tmux to end")

    def press(self, *keys):
        """Presses keys by their tmux names: "Enter", "Escape", "Up", "PPage", "a"."""
        self._do("send-keys", *keys)

    def type(self, text):
        self._do("send-keys", "-l", text)

    def resize(self, columns, rows):
        self._do("resize-window", "-x", str(columns), "-y", str(rows))

    @property
    def lines(self):
        return self._do("capture-pane", "-p").split("\n")[:-1]

    @property
    def coloured(self):
        return self._do("capture-pane", "-p", "-e")

    def show(self, of):
        return self._do("display-message", "-p", "#{%s}" % of).strip()

    def wait_for(self, pattern):
        """Waits until a line of the screen matches `pattern`, and returns this line."""
        expression = re.compile(pattern)
        try:
            return wait_until(lambda: next((line for line in self.lines if expression.search(line)), None),
                              "%r on the screen" % pattern)
        except AssertionError as error:
            raise AssertionError("%s; the screen shows:\n%s" % (error, "\n".join(self.lines))) from None

    def gone(self, pattern):
        expression = re.compile(pattern)
        wait_until(lambda: not any(expression.search(line) for line in self.lines), "%r off the screen" % pattern)
