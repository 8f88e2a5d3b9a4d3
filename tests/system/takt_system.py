"""Helpers for tests that run the real programs: they start takt, read its output, and inspect its processes in /proc.

A test derives from Case. Each program that it starts has a unique mark in its environment, which child processes inherit. By this mark
a test finds all processes of one run, whatever their parent is now, and never those of another run on the same machine.

TAKT_BIN is the folder of the programs; TAKT_COMPONENT_PATH is passed on to them. Each test program runs in its own namespaces
(machine.py). Each test uses a free DDS domain out of TAKT_TEST_DOMAINS ("1-76" unless set), and only the loopback interface.
TAKT_TEST_FULL=1 runs the full form of the tests that have a short form.
"""

import glob
import json
import os
import random
import re
import shlex
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import uuid
from collections import namedtuple

import machine  # noqa: F401, the import moves this process into its own namespaces

BIN = os.environ.get("TAKT_BIN", "")
SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
STATES = ("IDLE", "INITIALIZE", "START", "EXECUTING", "RECOVER", "DESTRUCT")
# The states that a module passes through if it runs and ends without an error.
LIFE = ["IDLE", "INITIALIZE", "START", "EXECUTING", "START", "DESTRUCT"]
# The states that a module passes through if it reaches START, but its device never runs.
NEVER_RAN = ["IDLE", "INITIALIZE", "START", "DESTRUCT"]
MARK = "TAKT_TEST_RUN"
os.environ.setdefault("TAKT_INTERFACE", "127.0.0.1")
os.environ.pop("TAKT_DOMAIN", None)

FULL = os.environ.get("TAKT_TEST_FULL", "") == "1"
# Limits in seconds. LONG is long enough for every event that a test waits for, and SOON for the end of a killed process. On a slow machine,
# ../run.py makes them longer. Only a test that asserts a duration has other limits.
LONG = 60.0 * float(os.environ.get("TAKT_TEST_SLOWNESS", "1"))
SOON = LONG / 20


def how_much(variable, short, full):
    """Returns the duration or the number of repetitions of a test: the value of the environment variable `variable` if it is set, otherwise
    `full` or `short`."""
    return type(full)(os.environ.get(variable) or (full if FULL else short))


def timing(why):
    """Marks a test that asserts durations in real time. `why` says why a test on virtual time could not check the same thing. CTest runs
    only one such test at a time."""
    assert why
    return lambda test: test


def alone(why):
    """Marks a test during which CTest runs no other test with executors; `why` says why. All tests place their executors on the last CPU. An
    executor that keeps this CPU busy would starve the executors of other tests. A test that counts missed rows would count rows that other
    tests made it miss."""
    assert why
    return lambda test: test


def quiet(why):
    """Marks a test during which CTest runs no other test; `why` says why. Such a test asserts how soon threads without a real-time priority
    act, and other tests would take CPU time from these threads."""
    assert why
    return lambda test: test


Line = namedtuple("Line", "at device module text")  # `at`: the time that the node printed, in seconds of the day
Step = namedtuple("Step", "at source target text")

LINE = re.compile(r"^(\d\d):(\d\d):(\d\d\.\d{3}) ([\w-]+)(?:\.([\w-]+|\(host(?: [\w-]+)?\)))?: (.*)$")
STEP = re.compile(r"^(%s) -> (%s)(?: \((.*)\))?$" % ("|".join(STATES), "|".join(STATES)))


class Process(namedtuple("Process", "pid program arguments")):
    """One process, as /proc shows it. `program` is the file name of its executable: takt, takt-node, takt-host, fine.exe."""

    @property
    def alive(self):
        return _read(self.pid, "cmdline") != b""  # a zombie has no command line

    def parent(self):
        """The pid of the parent process, or 0 if this process has ended."""
        stat = _read(self.pid, "stat")
        return int(stat.rsplit(b")", 1)[1].split()[1]) if stat else 0

    def threads(self):
        try:
            return len(os.listdir("/proc/%d/task" % self.pid))
        except OSError:
            return 0

    def memories(self):
        """Returns the shared memories of Takt that this process has open, as pairs of name and inode number."""
        found = set()
        try:
            for fd in os.listdir("/proc/%d/fd" % self.pid):
                path = "/proc/%d/fd/%s" % (self.pid, fd)
                try:
                    name = os.readlink(path)
                    if name.startswith("/memfd:takt-"):
                        found.add((name.split()[0][7:], os.stat(path).st_ino))
                except OSError:
                    pass
        except OSError:
            pass
        return found

    def kill(self, number=signal.SIGKILL):
        os.kill(self.pid, number)


def _read(pid, what):
    try:
        with open("/proc/%d/%s" % (pid, what), "rb") as file:
            return file.read()
    except OSError:
        return b""


def _pids():
    return [int(entry) for entry in os.listdir("/proc") if entry.isdigit()]


_claims = []  # one socket for each domain that the current test has claimed


def claim_domain(domain):
    """Claims the domain until release_domains() is called. Returns False if another process uses the domain, or if another test has
    claimed it."""
    claim = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            claim.bind("\0takt-test-domain-%d" % domain)  # the kernel releases an abstract socket name when the process ends
            probe.bind(("127.0.0.1", 7400 + 250 * domain + 10))
        except OSError:
            claim.close()
            return False
    _claims.append(claim)
    return True


def progress(text):
    """Shows the progress of a long test on one line, if standard error is a terminal."""
    if sys.stderr.isatty():
        sys.stderr.write("\r\x1b[K%s" % text)
        sys.stderr.flush()


def free_domain():
    """Claims a DDS domain whose first port is free, so that no process on this machine uses the domain. The claim lasts until
    release_domains() is called, even while no program of this test runs. Pages of the documentation name domain 77, so only the tests of
    these pages use it."""
    first, last = (int(n) for n in os.environ.get("TAKT_TEST_DOMAINS", "1-76").split("-"))
    domains = list(range(first, last + 1))
    random.shuffle(domains)
    for domain in domains:
        if claim_domain(domain):
            return domain
    raise AssertionError("no DDS domain of %d to %d is free" % (first, last))


def release_domains():
    while _claims:
        _claims.pop().close()


def wait_until(condition, what="the condition", limit=LONG):
    """Returns the value of `condition` as soon as it is true. Fails if it is still false after `limit` seconds."""
    end = time.monotonic() + limit
    while True:
        late = time.monotonic() > end  # read the clock before the check: if the machine stalls in between, the loop checks once more
        value = condition()
        if value:
            return value
        if late:
            raise AssertionError("waited %g s in vain for %s" % (limit, what))
        time.sleep(0.01)


class Run:
    """One run of a program. Reads its standard output and standard error while it runs."""

    def __init__(self, arguments, folder, environment=None, before=(), become=None, terminal=None,
                 error=subprocess.PIPE):
        self.mark = uuid.uuid4().hex
        self.began = time.monotonic()
        self._seen = set()  # the shared memories that processes of this run have had open
        everything = dict(os.environ, **(environment or {}))
        everything[MARK] = self.mark
        everything.setdefault("NO_COLOR", "1")
        self._process = subprocess.Popen(list(before) + list(arguments), cwd=folder, env=everything,
                                         stdin=subprocess.DEVNULL if terminal is None else terminal,
                                         stdout=subprocess.PIPE if terminal is None else terminal, stderr=error,
                                         start_new_session=True, preexec_fn=become)
        self.pid = self._process.pid
        self.raw = []  # all lines of standard error
        self.out_lines = []  # all lines of standard output, each with the time at which this process read it
        self._readers = [threading.Thread(target=read, daemon=True) for read in (self._read_out, self._read_err)]
        for reader in self._readers:
            reader.start()

    def _read_out(self):
        if self._process.stdout is None:
            return  # standard output is connected to a terminal
        for line in self._process.stdout:
            self.out_lines.append((time.monotonic(), line.decode(errors="replace")))

    def _read_err(self):
        if self._process.stderr is None:
            return
        for line in self._process.stderr:
            self.raw.append(line.decode(errors="replace").rstrip("\n"))

    # Functions to use while the program runs.

    def processes(self, program=None):
        """Returns all processes of this run. Leaves out zombies, and children between fork() and exec(), which are still copies of their
        parent."""
        wanted = ("%s=%s" % (MARK, self.mark)).encode()
        all_of_it = {}
        for pid in _pids():
            if wanted not in _read(pid, "environ").split(b"\0"):
                continue
            arguments = [a.decode(errors="replace") for a in _read(pid, "cmdline").split(b"\0")[:-1]]
            if not arguments:
                continue
            all_of_it[pid] = Process(pid, os.path.basename(arguments[0]), arguments[1:])
        found = []
        for process in all_of_it.values():
            parent = all_of_it.get(process.parent())
            if parent is not None and process[1:] == parent[1:]:
                continue
            if program is None or process.program == program:
                found.append(process)
                self._seen |= process.memories()
        return sorted(found)

    def one(self, program):
        """Returns the process of this run that executes `program`, which must be the only one. Waits briefly, because a process has no name
        during exec."""
        try:
            return wait_until(lambda: (lambda found: found[0] if len(found) == 1 else None)(self.processes(program)))
        except AssertionError:
            raise AssertionError("expected one process %s, found %d" % (program, len(self.processes(program)))) from None

    def wait_for_line(self, pattern, after=0):
        """Waits for a line of standard error that matches `pattern`, beginning at line index `after`. Returns the line."""
        expression = re.compile(pattern)

        def find():
            # Check this before the search; otherwise the search could miss the last lines.
            over = self._process.poll() is not None and not self._readers[1].is_alive()
            for text in self.raw[after:]:
                if expression.search(text):
                    return text
            if over:
                raise AssertionError("the program ended without a line %r; standard error:\n%s" % (pattern, self.err))
            return None

        return wait_until(find, "a line %r" % pattern)

    def wait_for_state(self, module, state, device=r"[\w-]+"):
        return self.wait_for_line(r" %s\.%s: \w+ -> %s\b" % (device, re.escape(module), state))

    def signal(self, number):
        """Sends a signal to the program and returns the value of time.monotonic() at that moment."""
        now = time.monotonic()
        os.kill(self.pid, number)
        if number == signal.SIGSTOP:
            wait_until(self._is_stopped, "every thread to stop")
        return now

    def halt(self):
        """Stops the program with SIGSTOP. Returns false if the program has ended before."""
        if self._process.poll() is None:
            os.kill(self.pid, signal.SIGSTOP)
            wait_until(lambda: self._process.poll() is not None or self._is_stopped(), "every thread to stop")
        return self._process.poll() is None

    def _is_stopped(self):
        """Returns whether every thread is stopped. A busy machine stops the threads some milliseconds after the signal."""
        for stat in glob.glob("/proc/%d/task/*/stat" % self.pid):
            with open(stat) as file:
                if file.read().rpartition(")")[2].split()[0] != "T":
                    return False
        return True

    def wait(self, limit=LONG):
        """Waits until the program has ended and all its child processes have closed standard output and standard error."""
        try:
            self._process.wait(limit)
        except subprocess.TimeoutExpired:
            said = self.err
            self.kill_all()
            raise AssertionError("the program did not end within %g s; standard error:\n%s" % (limit, said)) from None
        for reader in self._readers:
            reader.join(limit)  # each output gets the full limit, so that the last lines of a long run are read too
        if self._process.stdout is not None:
            self._process.stdout.close()
        if self._process.stderr is not None:
            self._process.stderr.close()
        return self

    def kill_all(self):
        for process in self.processes():
            try:
                process.kill()
            except OSError:
                pass
        self._process.wait()
        for reader, pipe in zip(self._readers, (self._process.stdout, self._process.stderr)):
            reader.join(1)
            if pipe is not None and not reader.is_alive():
                pipe.close()

    # Functions that read the output of the program.

    @property
    def status(self):
        """The exit status of the program, or the negative number of the signal that ended it, or None while it runs."""
        return self._process.poll()

    @property
    def out(self):
        return "".join(line for _, line in self.out_lines)

    def wait_for_out(self, pattern, after=0):
        """Waits for a line of standard output that matches `pattern`, beginning at line index `after`. Returns the time at which it was
        read."""
        expression = re.compile(pattern)

        def find():
            return next((at for at, text in self.out_lines[after:] if expression.search(text)), None)

        return wait_until(find, "%r on standard output" % pattern)

    @property
    def err(self):
        return "\n".join(self.raw)

    @property
    def report(self):
        """The JSON object on standard output. Standard output must contain nothing else."""
        return json.loads(self.out)

    def device(self, name=None):
        devices = self.report["devices"]
        return devices[0] if name is None else next(d for d in devices if d["name"] == name)

    def modules(self, device=None):
        return {m["name"]: m for m in self.device(device)["modules"]}

    def executor(self, name="main", device=None):
        return next(e for e in self.device(device)["executors"] if e["name"] == name)

    @property
    def lines(self):
        """The lines that nodes wrote to standard error, one for each event."""
        found = []
        for text in list(self.raw):
            match = LINE.match(text)
            if match:
                at = int(match[1]) * 3600 + int(match[2]) * 60 + float(match[3])
                found.append(Line(at, match[4], match[5] or "", match[6]))
        return found

    @property
    def other_lines(self):
        """The lines of standard error that no node wrote, such as the errors that takt prints before it exits."""
        return [text for text in list(self.raw) if not LINE.match(text)]

    def said(self, module, device=None):
        return [line for line in self.lines if line.module == module and device in (None, line.device)]

    def printed(self, module):
        """The lines that the program of this process module printed."""
        return [line.text[2:] for line in self.said(module) if line.text.startswith("| ")]

    def steps(self, module, device=None):
        found = []
        for line in self.said(module, device):
            match = STEP.match(line.text)
            if match:
                found.append(Step(line.at, match[1], match[2], match[3] or ""))
        return found

    def states(self, module, device=None):
        """Returns all states of the module, in order. Fails if a transition does not begin in the state in which the previous transition
        ended."""
        states = ["IDLE"]
        for step in self.steps(module, device):
            assert step.source == states[-1], "%s: a step from %s while in state %s" % (module, step.source, states[-1])
            states.append(step.target)
        return states


class Watcher:
    """Reads the output of a running `takt watch` and remembers the last state of each device and module."""
    DEVICE = re.compile(r"^\S+ ([\w-]+): (\w+)(?:, (\d+) of (\d+) modules EXECUTING)?")
    MODULE = re.compile(r"^\S+ ([\w-]+)\.([\w-]+): \w+ -> (\w+)")

    def __init__(self, run):
        self._run = run
        self._heard = 0
        self._modules = {}  # for each device, the state of each of its modules
        self._whole = {}  # for each device, its state, which is EXECUTING if all its modules are EXECUTING

    def _hear(self):
        lines = self._run.out_lines[self._heard:]
        self._heard += len(lines)
        for _, line in lines:
            if match := self.MODULE.match(line):
                self._modules.setdefault(match[1], {})[match[2]] = match[3]
            elif match := self.DEVICE.match(line):
                self._whole[match[1]] = "EXECUTING" if match[3] and match[3] == match[4] else match[2]

    def holds(self, wanted):
        """Returns whether takt watch has shown these states (see Case.wait_for_states()). The answer may be wrong while takt watch still
        shows modules of an earlier deployment."""
        self._hear()
        for device, states in wanted.items():
            found = self._modules.get(device, {})
            if isinstance(states, str):
                if self._whole.get(device) != states and (not found or set(found.values()) != {states}):
                    return False
            elif any(found.get(module) != state for module, state in states.items()):
                return False
        return True

    @property
    def ended(self):
        return self._run.status is not None


class Case(unittest.TestCase):
    """The base class of all system tests. Case gives each test its own folder, and checks that the test leaves nothing behind."""

    def setUp(self):
        self.assertTrue(os.path.exists(os.path.join(BIN, "takt")), "set TAKT_BIN to the folder of the programs")
        self.folder = tempfile.mkdtemp(prefix="takt-system-")
        self.runs = []
        self._watcher = None
        self.addCleanup(release_domains)
        self.domain = free_domain()
        self._shared_before = set(os.listdir("/dev/shm"))

    def tearDown(self):
        try:
            for run in self.runs:
                if run.status is not None:  # if the program is still running, the test has already failed
                    self.assert_nothing_left(run)
        finally:
            for run in self.runs:
                run.kill_all()
            shutil.rmtree(self.folder, ignore_errors=True)

    def beside(self, name):
        """Returns the path of a file in the folder that contains test.py."""
        return os.path.join(os.path.dirname(os.path.abspath(sys.modules[type(self).__module__].__file__)), name)

    def start(self, *arguments, **options):
        """Starts takt and returns without waiting for its end. A descriptor name without a path refers to the folder that contains
        test.py."""
        arguments = [self.beside(a) if a.endswith(".xml") and not os.path.isabs(a) else a for a in arguments]
        return self.program("takt", *arguments, **options)

    def program(self, name, *arguments, **options):
        """Starts one of Takt's programs on the DDS domain of this test, and returns without waiting for its end."""
        environment = {"TAKT_DOMAIN": str(self.domain), "TAKT_STATE_DIR": os.path.join(self.folder, "state")}
        environment.update(options.pop("environment", None) or {})
        run = Run([os.path.join(options.pop("programs", BIN), name)] + list(arguments), self.folder,
                  environment=environment, **options)
        self.runs.append(run)
        return run

    def takt(self, *arguments, limit=LONG, **options):
        return self.start(*arguments, **options).wait(limit)

    def at_once(self, *commands):
        """Runs several takt commands at the same time, because each of them mostly waits. Each command is a string without the leading word
        `takt`."""
        runs = [self.start(*shlex.split(command)) for command in commands]
        return [run.wait() for run in runs]

    def done(self, *commands):
        """Runs these commands at the same time and returns the standard output of each. Fails if any command fails."""
        runs = self.at_once(*commands)
        for command, run in zip(commands, runs):
            self.assertEqual(0, run.status, "takt %s: %s" % (command, run.err))
        return [run.out.rstrip("\n") for run in runs]

    def refused(self, commands):
        """Runs commands that must fail: each must exit with status 1, write nothing to standard output, and write a match for its pattern
        to standard error."""
        for (command, pattern), run in zip(commands.items(), self.at_once(*commands)):
            self.assertEqual((1, ""), (run.status, run.out), "takt %s: %s" % (command, run.err))
            self.assertRegex(run.err, pattern, "takt %s" % command)

    def nodes(self, *devices, **options):
        """Starts a node for each device, and returns when all nodes are ready for a deployment."""
        return {device: self.node(device, **options) for device in devices}

    def end(self, nodes):
        """Ends each node with SIGTERM and expects exit status 0."""
        for node in nodes.values():
            node.signal(signal.SIGTERM)
        for node in nodes.values():
            self.assertEqual(0, node.wait().status, node.err)

    def deploy(self, descriptor, *options):
        """Deploys a cell, and repeats the deployment if the machine stalled (see agreed())."""
        return self.agreed(lambda: self.takt("deploy", descriptor, *options))

    def agreed(self, deploy):
        """Runs a command that deploys a cell, and returns its run. If the machine stalls, takt and the devices may miss one of these limits:
        3 s to find the devices, 0.3 s to confirm T0, 0.4 s until every device knows that all others have T0, and 3 s from T0 until every
        device knows that all others have begun. Then the devices undo the deployment, and this function repeats the command."""
        for _ in range(3):
            run = deploy()
            if not re.search("no answer to command run within|not found on domain|not heard to (be ready before T0|run within)", run.err):
                break
            print("takt deploy is repeated: " + run.err)
        self.assertEqual(0, run.status, run.err)
        return run

    def wait_for_states(self, wanted):
        """Waits until takt status shows these states: {"device": "EXECUTING"} or {"device": {"module": "START"}}. Returns the status by
        device. Runs takt status once takt watch has shown the states, and every second."""
        if self._watcher is None:
            self._watcher = Watcher(self.start("watch"))
        asked = 0.0

        def holds():
            nonlocal asked
            if not self._watcher.holds(wanted) and not self._watcher.ended and time.monotonic() < asked + 1:
                return None
            asked = time.monotonic()
            run = self.takt("status", "--json")
            if run.status != 0:  # takt status found no node in time, because the machine stalled
                return None
            status = {d["name"]: d for d in run.report["devices"]}
            for device, states in wanted.items():
                found = {m["name"]: m["state"] for m in status.get(device, {"modules": []})["modules"]}
                if found and not status[device]["alive"]:
                    return None  # these are only the last states that other nodes know of this device
                if isinstance(states, str):
                    if not found or set(found.values()) != {states}:
                        return None
                elif any(found.get(module) != state for module, state in states.items()):
                    return None
            return status
        return wait_until(holds, "%s" % wanted)

    def node(self, device, *arguments, **options):
        """Starts a takt-node and waits until it is ready for a deployment."""
        run = self.program("takt-node", "--device", device, *arguments, **options)
        run.wait_for_line(r"^\S+ %s: waits for a deployment on domain %d" % (device, self.domain))
        return run

    def status_of(self, device=None, **options):
        """Returns the JSON output of takt status, or only the part about one device."""
        run = self.takt("status", "--json", **options)
        self.assertEqual(0, run.status, run.err)
        return run.report if device is None else run.device(device)

    def states_of(self, device):
        return {m["name"]: m["state"] for m in self.status_of(device)["modules"]}

    def read(self, name):
        """Returns the content of a file that a module wrote."""
        with open(os.path.join(self.folder, name)) as file:
            return file.read()

    def write(self, name, text):
        path = os.path.join(self.folder, name)
        with open(path, "w") as file:
            file.write(text)
        return path

    def assert_nothing_left(self, run):
        """Checks that no process of the run remains, that no other process has opened its shared memories, and that /dev/shm has no new
        file."""
        def left():
            return [p for p in run.processes() if p.alive]
        try:
            wait_until(lambda: not left(), limit=SOON)
        except AssertionError:
            self.fail("left behind: %s" % left())
        if run._seen:
            # In /proc, an ending process loses its environment before it closes its files.
            def holders():
                return [p for p in _pids() if Process(p, "", []).memories() & run._seen]
            try:
                wait_until(lambda: not holders(), limit=SOON)
            except AssertionError:
                self.fail("processes that still hold shared memory of the ended run: %s" % holders())
        new = {name for name in os.listdir("/dev/shm") if "takt" in name} - self._shared_before
        self.assertEqual(set(), new, "left in /dev/shm")

    def assert_grid(self, run, module, every=1, executor="main", device=None, broken_rows=0):
        """Checks the counts of a periodic module that was in the tables from the first row to the last: the executor called it, or found it
        busy, in each of its rows that the executor did not miss. `every` is its period in rows. `broken_rows` is the number of rows in
        which the host ended, so that the executor did not count them."""
        rows = run.executor(executor, device)
        m = run.modules(device)[module]
        due = -(-(rows["cycles"] + rows["missed"]) // every)
        met = m["cycles"] + (m["overruns"] if m["type"] == "process" else 0)
        self.assertGreater(met, 0, module)
        self.assertLessEqual(met, min(due, rows["cycles"] + broken_rows), module)
        self.assertGreaterEqual(met, due - rows["missed"], module)

    def assert_refused(self, run, *patterns):
        """Checks that the run exited with status 1, that no module ran, and that standard error matches each of the patterns."""
        self.assertEqual(1, run.status, run.err)
        self.assertNotIn("EXECUTING", run.err)
        for pattern in patterns:
            self.assertRegex(run.err, pattern)


def main():
    unittest.main(verbosity=2)
