import json
import os
import re
import shutil
import signal
import subprocess
import sys
import unittest
import urllib.request

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import wait_until

# Like controls.h of the components, but with a byte that is not UTF-8.
TEXT = b"<\x1b]0;title\x07\xc2\x9b31m\xc2\x90q\xe2\x80\xae>\r\nFORGED \t\xff."
# The control characters of takt::is_control_character() other than tabs and line feeds.
CONTROL = "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]"
# A line that one of the texts has begun; in XML, it is data.
FORGED = "\t|^FORGED"
ANNOUNCE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "announce.py")
SET_HOST_NAME = "import ctypes, os, sys; t = bytes.fromhex(sys.argv[1]); ctypes.CDLL(None).sethostname(t, len(t)); os.execvp(sys.argv[2], sys.argv[2:])"


def texts_in(value):
    """Returns all texts in a JSON value."""
    if isinstance(value, dict):
        return [text for pair in value.items() for part in pair for text in texts_in(part)]
    if isinstance(value, list):
        return [text for part in value for text in texts_in(part)]
    return [value] if isinstance(value, str) else []


class ControlCharacters(takt_system.Case):
    def assert_harmless(self, what, output, xml=False):
        try:
            text = output.decode()
        except UnicodeDecodeError as error:
            self.fail("%s: %s: %r" % (what, error, output))
        self.assertIsNone(re.search(CONTROL if xml else CONTROL + "|" + FORGED, text, re.M), "%s: %r" % (what, text))

    def both(self, *words, before=(), status=None):
        """Runs takt with these words, which may be bytes. Checks what it prints, and returns it."""
        words = [word if isinstance(word, bytes) else word.encode() for word in words]
        environment = dict(os.environ, TAKT_DOMAIN=str(self.domain), TAKT_STATE_DIR=os.path.join(self.folder, "state"))
        run = subprocess.run([*before, os.path.join(takt_system.BIN, "takt"), *words], capture_output=True, cwd=self.folder, env=environment,
                             timeout=takt_system.LONG)
        self.assert_harmless(words, run.stdout, xml=b"--xml" in words or b"--iso22166" in words)
        self.assert_harmless(words, run.stderr)
        if status is not None:
            self.assertEqual(status, run.returncode, run.stderr)
        return (run.stdout + run.stderr).decode()

    def component(self, name):
        return next(p for p in (os.path.join(f, name) for f in os.environ["TAKT_COMPONENT_PATH"].split(":")) if os.path.exists(p))

    def test_takt_describe_escapes_the_control_characters_of_a_component(self):
        for name in ("controls.so", "controls_c.so", "controls_c.exe"):
            for option in ("", "--json", "--xml", "--iso22166"):
                with self.subTest(component=name, option=option):
                    text = self.both("describe", self.component(name), *option.split(), status=0)
                    self.assertRegex(text, "title" if option != "--json" else r"\\u009b")
        # A descriptor has references for the characters that XML allows.
        described = self.both("describe", self.component("controls.so"), "--xml", status=0)
        self.assertIn('<value name="direction">a&#x202e;b&#x9b;c</value>', described)
        self.assertNotIn('name="label"', described, "XML cannot express its default value")

    def test_no_command_passes_on_the_control_characters_of_a_running_component(self):
        node = self.node("bench")
        self.deploy("cell.xml")
        cell = self.beside("cell.xml")
        for command in ("status", "status --json", "get bench.cpp", "get bench.cpp --json", "get bench.c", "get bench.c label", "get bench.program",
                        "call bench.cpp", "graph " + cell, "graph --live " + cell, "check " + cell, "log", "log --json", "trace bench",
                        "trace bench --json", "echo bench.cpp.out --count 1", "call bench.cpp.rejects number=1",
                        "call bench.cpp.rejects number=2"):
            self.both(*command.split())
        self.both("set", "bench.cpp", "fails", "true")
        wait_until(lambda: self.states_of("bench")["cpp"] == "DESTRUCT", "the module to be given up")
        for command in ("status", "status --json", "log", "log --json", "start bench.cpp", "reset bench.cpp", "restart bench.cpp"):
            self.both(*command.split())
        self.done("undeploy controlled")
        self.end({"bench": node})
        for line in node.raw:
            self.assert_harmless("the log of the node", line.encode())
        self.assertIn("title", node.err)

    def test_takt_status_does_not_print_the_control_characters_of_a_participant_name(self):
        for name in (b"takt-node " + TEXT, b"takt-node bench" + TEXT, TEXT):
            announcer = subprocess.Popen([sys.executable, ANNOUNCE, str(self.domain), name.hex()])
            try:
                for command in (("status",), ("stop", "bench"), ("watch", "--for", "0.5")):
                    self.both(*command)
            finally:
                announcer.kill()
                announcer.wait()

    @unittest.skipUnless(os.getuid() == 0, "only root can change the name of a machine")
    def test_the_name_of_a_machine_cannot_control_a_terminal(self):
        before = ["unshare", "-u", sys.executable, "-c", SET_HOST_NAME, TEXT.hex()]
        self.assertIn("title", self.both("doctor", before=before))
        # A node on such a machine runs as others do.
        node = self.node("bench", before=before)
        self.deploy("cell.xml")
        self.both("status", status=0)
        self.done("undeploy controlled")
        self.end({"bench": node})

    def test_the_page_and_the_metrics_contain_no_control_characters_of_components(self):
        node = self.node("bench")
        self.deploy("cell.xml")
        web = self.start("web", "--port", "0")
        web.wait_for_out(r"^domain \d+ is shown at http://\S+/$")
        address = re.search(r"http://\S+/", web.out).group()
        answered = {}
        for what in ("metrics", "api/ports?device=bench", *("api/properties?module=bench." + m for m in ("cpp", "c", "program"))):
            with urllib.request.urlopen(address + what, timeout=takt_system.LONG) as response:
                answered[what] = response.read().decode()
        with urllib.request.urlopen(address + "api/events", timeout=takt_system.LONG) as response:
            seen = set()
            while not {"state", "cell", "faults", "measures"} <= seen:
                line = response.readline().decode()
                if line.startswith("event: "):
                    seen.add(line[7:].strip())
                if line.startswith("data: "):
                    answered["event %d" % len(answered)] = line[6:]
        for what, text in answered.items():
            self.assert_harmless(what, text.encode())
            if what != "metrics":
                for part in texts_in(json.loads(text)):
                    self.assert_harmless(what, part.encode(), xml=True)
        self.assertIn("title", answered["api/properties?module=bench.cpp"])
        web.signal(signal.SIGINT)
        self.assertEqual(0, web.wait().status)
        self.done("undeploy controlled")
        self.end({"bench": node})

    def test_names_of_files_cannot_control_a_terminal(self):
        odd = os.path.join(self.folder.encode(), TEXT.replace(b"/", b""))
        os.mkdir(odd)
        for name in ("controls.so", "controls_c.exe"):
            shutil.copy(self.component(name), os.path.join(odd, name.encode()))
        cell = os.path.join(odd, b"cell.xml")
        shutil.copy(self.beside("cell.xml"), cell)
        inside = lambda name: os.path.join(odd, name)
        for words in (("describe", odd), ("describe", inside(b"controls.so")), ("describe", inside(b"none.so")), ("check", cell),
                      ("check", inside(b"none.xml")), ("check", "cell.xml", "--svg", inside(b"none/x.svg")), ("graph", cell),
                      ("run", cell, "--for", "0.1"), ("simulate", cell, "--for", "0.1", "--script", inside(b"none")),
                      ("new", "fresh", inside(b"fresh")), ("new", "fresh", inside(b"fresh")), ("new", "cell", inside(b"cell")),
                      ("secure", "init", cell, inside(b"keys")), ("secure", "show", inside(b"keys")),
                      ("sign", inside(b"controls.so"), "--key", inside(b"keys")), ("sign", inside(b"none"), "--key", inside(b"keys")),
                      ("play", inside(b"none")), ("plot", inside(b"none"), "a"), ("trace", inside(b"none")), ("log", "--file", cell),
                      ("record", "a.b.c", "--out", cell), ("record", "a.b.c", "--out", inside(b"none/x")),
                      ("status", "--security", inside(b"none"))):
            self.both(*words)

    def test_wrong_usage_is_reported_on_one_line(self):
        for words in ((TEXT,), ("status", TEXT), ("status", b"--" + TEXT), ("status", "--domain", TEXT), ("stop", TEXT), ("echo", TEXT),
                      ("get", "a.b", TEXT), ("call", TEXT), ("secure", TEXT), ("new", TEXT), ("web", "--port", TEXT), ("status", b"--domian" + TEXT)):
            self.both(*words)


if __name__ == "__main__":
    takt_system.main()
