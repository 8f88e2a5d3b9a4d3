#!/usr/bin/env python3
"""Follows a page as a reader would, in an empty folder: writes every file and runs every command of the page, in the order of the page.

Usage: pages_test.py PREFIX SOURCE PAGE.md ...      PREFIX: where Takt is installed; the folder has a link to SOURCE/deploy

Marks in a page:

  <!-- file: NAME -->        before a fenced block: the content of this file
  ```console                 "$ " begins a command, "> " continues it. The lines below it must be printed in this order; other lines
                             may come between them. A number matches any number, "..." matches anything. A command must exit with
                             status 0, or with the status in "$ command  # exit status 1". A command that only shows something is
                             repeated for up to 30 s until it prints these lines
  <!-- not run: why -->      before a block that cannot be run here
  <!-- shown: why -->        before a block that is neither a file nor a command; every other fenced block needs one of these comments
"""
import os
import re
import signal
import subprocess
import sys
import tempfile
import time

sys.dont_write_bytecode = True  # leave no bytecode of takt_system in the source tree
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "system"))
import takt_system

FENCE = re.compile(r"^(?:<!-- (?P<mark>file|not run|shown): (?P<value>.*?) -->\n)?```(?P<kind>\S*)\n(?P<text>.*?)^```$", re.M | re.S)
ONLY_SHOWS = re.compile(r"(grep|takt (status|log|get|echo)) ")
NUMBER = r"[-+]?\d+(?:[.,]\d+)*(?:e[-+]?\d+)?"


class Wrong(Exception):
    pass


def pattern_of(line):
    """Returns a regular expression that matches the printed lines for which this line of the page stands."""
    parts = []
    for piece in re.split(rf"(\.\.\.|{NUMBER}|\s+)", line.strip()):
        if piece == "...":
            parts.append(".*")
        elif re.fullmatch(NUMBER, piece):
            parts.append(NUMBER)
        elif piece.isspace():
            parts.append(r"\s+")
        else:
            parts.append(re.escape(piece))
    return re.compile("".join(parts))


def check_output(expected, printed):
    lines = iter(printed.splitlines())
    for line in expected:
        if line.strip() in ("", "..."):
            continue
        pattern = pattern_of(line)
        if not any(pattern.search(each) for each in lines):
            raise Wrong(f"this line was not printed, or not in this order: {line}\nthe output was:\n{printed}")


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
        # The machine may stall, so sleep waits twice as long as the page says.
        self.bash.stdin.write('sleep() { command sleep "$@" "$@"; }\n')
        self.number = 0

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
    """Returns (command, expected status, expected lines) for each command of a console block."""
    found = []
    for line in text.splitlines():
        if line.startswith("$ "):
            status = re.search(r"\s+# exit status (\d+)$", line)
            command = line[2:status.start()] if status else line[2:]
            found.append([command, int(status.group(1)) if status else 0, []])
        elif found and line.startswith("> "):  # this line continues the command
            found[-1][0] += "\n" + line[2:]
        elif found:
            found[-1][2].append(line)
        else:
            raise Wrong(f"a console block does not begin with a command: {line}")
    return found


def run_page(path, source, environment):
    with open(path, encoding="utf-8") as stream:
        page = stream.read()
    for domain in sorted(set(re.findall(r"--domain (\d+)", page))):
        takt_system.wait_until(lambda: takt_system.claim_domain(int(domain)), f"domain {domain}, which the page names, to be free", 2 * takt_system.LONG)
    ran = 0
    with tempfile.TemporaryDirectory(prefix="takt-page-") as folder:
        shell = Shell(folder, environment)
        os.symlink(os.path.join(source, "deploy"), os.path.join(shell.work, "deploy"))
        try:
            for block in FENCE.finditer(page):
                line = page.count("\n", 0, block.start("kind")) + 1
                try:
                    ran += run_block(block, shell)
                except Wrong as wrong:
                    raise Wrong(f"{path}:{line}: {wrong}") from None
        finally:
            shell.end()
            takt_system.release_domains()
    return ran


def check_command(shell, command, status, expected):
    ended, printed = shell.run(command)
    if ended != status:
        raise Wrong(f"the command ended with status {ended}, not {status}; the output was:\n{printed}")
    check_output(expected, printed)


def run_block(block, shell):
    mark, value, kind, text = block["mark"], block["value"], block["kind"], block["text"]
    if mark in ("not run", "shown"):
        return 0
    if mark == "file":
        name = os.path.join(shell.work, value)
        os.makedirs(os.path.dirname(name), exist_ok=True)
        with open(name, "w", encoding="utf-8") as stream:
            stream.write(text)
        return 0
    if kind != "console":
        raise Wrong(f"this block of kind '{kind}' is neither a file nor a command; say what it is in a comment before it")
    commands = commands_of(text)
    for command, status, expected in commands:
        end = time.monotonic() + (30 if ONLY_SHOWS.match(command) else 0)
        while True:
            try:
                check_command(shell, command, status, expected)
                break
            except Wrong as wrong:
                if time.monotonic() > end:
                    raise Wrong(f"$ {command}\n{wrong}") from None
                time.sleep(1)
    return len(commands)


def main():
    prefix, source, *pages = sys.argv[1:]
    environment = {name: value for name, value in os.environ.items() if not name.startswith("TAKT_")}
    environment.update({"PATH": os.path.join(prefix, "bin") + ":" + environment["PATH"], "CMAKE_PREFIX_PATH": prefix,
                        "TAKT_INTERFACE": "127.0.0.1"})
    failed = 0
    for page in pages:
        environment["TAKT_DOMAIN"] = os.environ.get("TAKT_TEST_DOMAIN") or str(takt_system.free_domain())
        try:
            print(f"{page}: {run_page(page, source, environment)} commands")
        except Wrong as wrong:
            failed += 1
            print(wrong, file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
