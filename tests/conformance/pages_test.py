#!/usr/bin/env python3
"""Follows a page as a reader would, in an empty folder: writes every file and runs every command of the page, in the order of the page.

Usage: pages_test.py PREFIX SOURCE BUILD PAGE.md ...      PREFIX: where Takt is installed; it replaces /opt/takt in the pages

The commands see only the installed Takt: with root rights, the folders of SOURCE and BUILD are hidden from them. The README is read in the
source tree, so its commands also see a copy of deploy/.

Marks in a page:

  <!-- file: NAME -->        before a fenced block: the content of this file
  <!-- edit: NAME -->        before a diff: this file has the lines with "-" and " "; they become the lines with "+" and " "
  ```console                 "$ " begins a command, "> " continues it. The lines below it must be printed in this order, but lines of
                             different modules may come in any order, and further lines may come between them. A number, a time or a
                             hash matches any other, but one that changes from line to line must change in the output too. "..."
                             matches anything. The first line must be real. A command that only shows something is repeated for up to
                             30 s until it prints these lines
  <!-- status: N -->         before a console block: its last command exits with this status. All other commands exit with status 0
  <!-- runs on -->           before a console block: its last command is still running when it has printed the lines below it
  <!-- Ctrl-C -->            interrupts all commands that still run; they end with status 0. A block after it shows what they then print
  <!-- not compared: why --> before a console block: its last command may print anything, and exit with status 0 or 1
  <!-- not run: why -->      before a block that cannot be run here
  <!-- shown: why -->        before a block that is neither a file nor a command; every other fenced block needs one of these comments
"""
import collections
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

sys.dont_write_bytecode = True  # leave no bytecode of takt_system in the source tree
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "system"))
import takt_system

BLOCK = re.compile(r"^(?:<!-- (?P<mark>[\w -]+?)(?:: (?P<value>.*?))? -->\n)?```(?P<kind>\S*)\n(?P<text>.*?)^```$"
                   r"|^<!-- Ctrl-C -->$", re.M | re.S)
ONLY_SHOWS = re.compile(r"takt (status|log|get|echo|graph)\b")
NUMBER = r"\b[0-9a-f]{8}\b|[-+]?\d+(?:[.,]\d+)*(?:e[-+]?\d+)?(?: [nmu]?s\b)?"
STAMPED = re.compile(r"\d\d:\d\d:\d\d\.\d{3}\W+([\w-]+(?:\.[\w-]+)?)")


class Wrong(Exception):
    pass


def pattern_of(line):
    """Returns a regular expression that matches the printed lines for which this line of the page stands."""
    parts = []
    for piece in re.split(rf"(\.\.\.|{NUMBER}|\s+)", line.strip()):
        if piece == "...":
            parts.append(".*")
        elif re.fullmatch(NUMBER, piece):
            parts.append(f"(?:{NUMBER})")
        elif piece.isspace():
            parts.append(r"\s+")
        else:
            parts.append(re.escape(piece))
    return re.compile("".join(parts))


def source_of(line):
    """Returns the module or device that printed this line with a time; None for every other line."""
    stamped = STAMPED.match(line)
    return stamped and stamped[1]


def check_output(expected, printed):
    lines = collections.defaultdict(list)
    for line in printed.splitlines():
        lines[source_of(line)].append(line)
    rest = {source: iter(lines[source]) for source in lines}
    last = (None, None, None)  # the last line: its pattern, the line on the page, the printed line
    for line in expected:
        if line.strip() in ("", "..."):
            continue
        pattern = pattern_of(line)
        stuck = last[2] if pattern == last[0] and line != last[1] else None
        found = next((each for each in rest.get(source_of(line), ()) if pattern.search(each) and each != stuck), None)
        if found is None:
            raise Wrong(f"this line was not printed, or not in this order: {line}\nthe output was:\n{printed}")
        last = (pattern, line, found)


def edited(content, diff, name):
    """Returns the content with the change that the diff describes."""
    before, after = ("".join(line[1:] for line in diff.splitlines(True) if line[0] in kinds) for kinds in ("- ", "+ "))
    if content.count(before) != 1:
        raise Wrong(f"{name} has these lines {content.count(before)} times, not once:\n{before}")
    return content.replace(before, after)


class Shell:
    """The bash in which the commands of a page run one after the other."""

    def __init__(self, folder, environment):
        self.folder = folder
        self.marks = os.path.join(folder, ".page")
        os.mkdir(self.marks)
        self.work = os.path.join(folder, "work")
        os.mkdir(self.work)
        self.bash = subprocess.Popen(["bash", "--norc"], stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                     cwd=self.work, env=environment, text=True, start_new_session=True)
        self.bash.stdin.write("set -m\n")  # a command that runs on reacts to SIGINT, as in a terminal
        self.number = 0
        self.running = []  # the process and the output of each command that runs on

    def run(self, command, limit=300):
        self.number += 1
        out = os.path.join(self.marks, f"out{self.number}")
        done = os.path.join(self.marks, f"done{self.number}")
        os.mkfifo(done)
        self.bash.stdin.write(f"{{ {command}\n}} >{out} 2>&1 </dev/null; echo $? >{done}\n")
        self.bash.stdin.flush()
        reader = subprocess.run(["timeout", str(limit), "cat", done], capture_output=True, text=True)
        with open(out, encoding="utf-8", errors="replace") as stream:
            printed = stream.read()
        if not reader.stdout.strip():
            raise Wrong(f"the command did not end within {limit} s; the output was:\n{printed}")
        return int(reader.stdout), printed

    def start(self, command):
        """Starts a command that runs on."""
        out = os.path.join(self.marks, f"running{self.number}")
        open(out, "w").close()
        self.running.append((int(self.run(f"{command} >{out} 2>&1 </dev/null & echo $!")[1]), out))

    def so_far(self):
        """Returns what the commands that run on have printed."""
        printed = ""
        for _, out in self.running:
            with open(out, encoding="utf-8", errors="replace") as stream:
                printed += stream.read()
        return printed

    def interrupt(self):
        """Interrupts the commands that run on. Returns all that they printed."""
        for pid, _ in self.running:
            try:
                os.killpg(pid, signal.SIGINT)
            except ProcessLookupError:
                raise Wrong(f"a command has ended by itself; the output was:\n{self.so_far()}") from None
        for pid, out in self.running:
            status, _ = self.run(f"wait {pid}")
            if status != 0:
                raise Wrong(f"an interrupted command ended with status {status}; the output was:\n{self.so_far()}")
        printed = self.so_far()
        self.running = []
        return printed

    def end(self):
        """Ends the bash and all processes of its session."""
        self.bash.stdin.close()
        try:
            self.bash.wait(10)
        except subprocess.TimeoutExpired:
            pass
        for sign in (signal.SIGTERM, signal.SIGKILL):
            pids = [pid for pid in os.listdir("/proc") if pid.isdigit() and session_of(pid) == self.bash.pid]
            for pid in pids:
                try:
                    os.kill(int(pid), sign)
                except ProcessLookupError:
                    pass
            if pids and sign == signal.SIGTERM:
                subprocess.run(["sleep", "3"])


def session_of(pid):
    try:
        with open(f"/proc/{pid}/stat", encoding="utf-8", errors="replace") as stream:
            return int(stream.read().rsplit(")", 1)[1].split()[3])
    except (OSError, IndexError, ValueError):
        return None


def commands_of(text):
    """Returns (command, expected lines) for each command of a console block."""
    found = []
    for line in text.splitlines():
        if line.startswith("$ "):
            found.append([line[2:], []])
        elif found and line.startswith("> "):  # this line continues the command
            found[-1][0] += "\n" + line[2:]
        elif found:
            found[-1][1].append(line)
        else:
            raise Wrong(f"a console block does not begin with a command: {line}")
    for command, expected in found:
        if expected and expected[0].startswith("..."):
            raise Wrong(f"show the first lines that this command prints: {command}")
        if re.search(r"\|\| true|\b(sed|sleep)\b", command):
            raise Wrong(f"no reader would enter this: {command}")
    return found


def run_page(path, prefix, page, environment):
    for domain in sorted(set(re.findall(r"--domain (\d+)", page))):
        takt_system.wait_until(lambda: takt_system.claim_domain(int(domain)), f"domain {domain}, which the page names, to be free",
                               2 * takt_system.LONG)
    ran = 0
    with tempfile.TemporaryDirectory(prefix="takt-page-") as folder:
        shell = Shell(folder, environment)
        if os.path.basename(path) == "README.md":
            shutil.copytree(os.path.join(prefix, "share", "takt", "deploy"), os.path.join(shell.work, "deploy"))
        try:
            for block in BLOCK.finditer(page):
                line = page.count("\n", 0, block.start()) + 1
                try:
                    ran += run_block(block, shell)
                except Wrong as wrong:
                    raise Wrong(f"{path}:{line}: {wrong}") from None
            if shell.running:
                raise Wrong(f"{path}: a command still runs at the end of the page:\n{shell.so_far()}")
        finally:
            shell.end()
            takt_system.release_domains()
    return ran


def until_right(check, limit):
    """Repeats the check for up to `limit` seconds, until it raises nothing."""
    end = time.monotonic() + limit
    while True:
        try:
            return check()
        except Wrong:
            if time.monotonic() > end:
                raise
            time.sleep(1)


def check_command(shell, command, statuses, expected):
    ended, printed = shell.run(command)
    if ended not in statuses:
        raise Wrong(f"the command ended with status {ended}, not {' or '.join(map(str, statuses))}; the output was:\n{printed}")
    check_output(expected, printed)


def run_block(block, shell):
    mark, value, kind, text = block["mark"], block["value"], block["kind"], block["text"]
    if mark in ("not run", "shown"):
        return 0
    if mark == "Ctrl-C" or kind is None:
        check_output((text or "").splitlines(), shell.interrupt())
        return 0
    if mark in ("file", "edit"):
        name = os.path.join(shell.work, value)
        os.makedirs(os.path.dirname(name), exist_ok=True)
        if mark == "edit":
            with open(name, encoding="utf-8") as stream:
                text = edited(stream.read(), text, value)
        with open(name, "w", encoding="utf-8") as stream:
            stream.write(text)
        return 0
    if kind != "console" or mark not in (None, "status", "runs on", "not compared"):
        raise Wrong(f"this block of kind '{kind}' is neither a file nor a command; say what it is in a comment before it")
    commands = commands_of(text)
    for command, expected in commands:
        last = command is commands[-1][0]
        try:
            if mark == "runs on" and last:
                shell.start(command)
                until_right(lambda: check_output(expected, shell.so_far()), takt_system.LONG)
            elif mark == "not compared" and last:
                check_command(shell, command, (0, 1), [])
            else:
                statuses = (int(value),) if mark == "status" and last else (0,)
                until_right(lambda: check_command(shell, command, statuses, expected), 30 if ONLY_SHOWS.match(command) else 0)
        except Wrong as wrong:
            raise Wrong(f"$ {command}\n{wrong}") from None
    return len(commands)


def hide(folder, but):
    """Hides all folders in this folder, except `but`, from this process and its children."""
    for path in (entry.path for entry in os.scandir(folder) if entry.is_dir(follow_symlinks=False)):
        if but.startswith(path + "/"):
            hide(path, but)
        elif path != but:
            subprocess.run(["mount", "-t", "tmpfs", "-o", "ro", "hidden", path], check=True)


def main():
    prefix, source, build, *paths = sys.argv[1:]
    environment = {name: value for name, value in os.environ.items() if not name.startswith("TAKT_")}
    environment.update({"PATH": os.path.join(prefix, "bin") + ":" + environment["PATH"], "TAKT_INTERFACE": "127.0.0.1"})
    pages = {}
    for path in paths:
        with open(path, encoding="utf-8") as stream:
            pages[path] = stream.read().replace("/opt/takt", prefix)
    if not takt_system.machine.MISSING:
        for folder in (build, source):
            hide(folder, prefix)
    failed = 0
    for path, page in pages.items():
        environment.pop("TAKT_DOMAIN", None)
        if 'domain="' not in page:
            environment["TAKT_DOMAIN"] = os.environ.get("TAKT_TEST_DOMAIN") or str(takt_system.free_domain())
        try:
            print(f"{path}: {run_page(path, prefix, page, environment)} commands")
        except Wrong as wrong:
            failed += 1
            print(wrong, file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
