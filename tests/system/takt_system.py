"""For tests that run the real programs: starts takt, reads what it says, and looks in /proc at what it did.

A test derives from Case. Whatever it starts carries a mark of its own in the environment, which children inherit, so that
the processes of one run are found whoever their parent is by now, and never those of another run on the same machine.

TAKT_BIN is the folder of the programs; TAKT_COMPONENT_PATH is passed on to them. Each test program has a machine of its own
(machine.py), and each test a DDS domain that nobody on it uses, of those in TAKT_TEST_DOMAINS ("1-100" unless set); it uses the
loopback interface alone. TAKT_TEST_FULL=1: what has a short and a full form runs in full.
"""

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

import machine  # noqa: F401, moves this process to a machine of its own

BIN = os.environ.get("TAKT_BIN", "")
SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
STATES = ("IDLE", "INITIALIZE", "START", "EXECUTING", "RECOVER", "DESTRUCT")
# A whole life without an error.
LIFE = ["IDLE", "INITIALIZE", "START", "EXECUTING", "START", "DESTRUCT"]
# The life of a module whose device was refused after it had been started.
NEVER_RAN = ["IDLE", "INITIALIZE", "START", "DESTRUCT"]
MARK = "TAKT_TEST_RUN"
os.environ.setdefault("TAKT_INTERFACE", "127.0.0.1")
os.environ.pop("TAKT_DOMAIN", None)

FULL = os.environ.get("TAKT_TEST_FULL", "") == "1"


def how_much(variable, short, full):
    """How long or how often a test does something: what this environment variable says, else by the form in which tests run."""
    return type(full)(os.environ.get(variable) or (full if FULL else short))


def timing(why):
    """Marks a test that asserts on time, for the reason that it gives: of these, CTest runs one at a time. Virtual time cannot show the
    same."""
    assert why
    return lambda test: test


def alone(why):
    """Marks a test beside which CTest runs no other, for the reason that it gives. Executors are all placed on the last processor: one that
    keeps that busy starves those of tests beside it, and a test that counts missed rows counts theirs too."""
    assert why
    return lambda test: test


Line = namedtuple("Line", "at device module text")  # `at` as the node wrote it, in seconds of the day
Step = namedtuple("Step", "at source target text")

LINE = re.compile(r"^(\d\d):(\d\d):(\d\d\.\d{3}) ([\w-]+)(?:\.([\w-]+|\(host(?: [\w-]+)?\)))?: (.*)$")
STEP = re.compile(r"^(%s) -> (%s)(?: \((.*)\))?$" % ("|".join(STATES), "|".join(STATES)))


class Process(namedtuple("Process", "pid program arguments")):
    """One process, as /proc shows it. `program` is the file's name: takt, takt-node, takt-host, fine.exe."""

    @property
    def alive(self):
        return _read(self.pid, "cmdline") != b""  # a zombie has none

    def parent(self):
        """Its pid; 0 where it has ended."""
        stat = _read(self.pid, "stat")
        return int(stat.rsplit(b")", 1)[1].split()[1]) if stat else 0

    def threads(self):
        try:
            return len(os.listdir("/proc/%d/task" % self.pid))
        except OSError:
            return 0

    def memories(self):
        """The shared memories of Takt that it holds: pairs of name and inode."""
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


_claims = []  # on domains, of the test that runs


def claim_domain(domain):
    """Whether nobody is on it, nor any other test has it; then it is this one's until release_domains()."""
    claim = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            claim.bind("\0takt-test-domain-%d" % domain)  # a name without a file, gone with whoever has it
            probe.bind(("127.0.0.1", 7400 + 250 * domain + 10))
        except OSError:
            claim.close()
            return False
    _claims.append(claim)
    return True


def progress(text):
    """How far a test is that takes minutes, in one line; where somebody looks."""
    if sys.stderr.isatty():
        sys.stderr.write("\r\x1b[K%s" % text)
        sys.stderr.flush()


def free_domain():
    """A DDS domain that no process of this machine is on: the first port of one that is used is taken. No other test takes it
    before release_domains(): between two programs of this one nobody is on it."""
    first, last = (int(n) for n in os.environ.get("TAKT_TEST_DOMAINS", "1-100").split("-"))
    domains = list(range(first, last + 1))
    random.shuffle(domains)
    for domain in domains:
        if claim_domain(domain):
            return domain
    raise AssertionError("no DDS domain of %d to %d is free" % (first, last))


def release_domains():
    while _claims:
        _claims.pop().close()


def wait_until(condition, limit=10.0, what="the condition"):
    """What `condition` returns once that is true. Fails after `limit` seconds."""
    end = time.monotonic() + limit
    while True:
        late = time.monotonic() > end  # before it looks: it looks once more however long it was held up
        value = condition()
        if value:
            return value
        if late:
            raise AssertionError("%s did not come about within %g s" % (what, limit))
        time.sleep(0.01)


class Run:
    """One run of a program. Reads both outputs as they come."""

    def __init__(self, arguments, folder, environment=None, before=(), become=None, terminal=None,
                 error=subprocess.PIPE):
        self.mark = uuid.uuid4().hex
        self.began = time.monotonic()
        self._seen = set()  # memories
        everything = dict(os.environ, **(environment or {}))
        everything[MARK] = self.mark
        everything.setdefault("NO_COLOR", "1")
        self._process = subprocess.Popen(list(before) + list(arguments), cwd=folder, env=everything,
                                         stdin=subprocess.DEVNULL if terminal is None else terminal,
                                         stdout=subprocess.PIPE if terminal is None else terminal, stderr=error,
                                         start_new_session=True, preexec_fn=become)
        self.pid = self._process.pid
        self.raw = []  # lines of standard error
        self.out_lines = []  # of standard output, each with the time at which it was read
        self._readers = [threading.Thread(target=read, daemon=True) for read in (self._read_out, self._read_err)]
        for reader in self._readers:
            reader.start()

    def _read_out(self):
        if self._process.stdout is None:
            return  # it is on a terminal
        for line in self._process.stdout:
            self.out_lines.append((time.monotonic(), line.decode(errors="replace")))

    def _read_err(self):
        if self._process.stderr is None:
            return
        for line in self._process.stderr:
            self.raw.append(line.decode(errors="replace").rstrip("\n"))

    # While it runs

    def processes(self, program=None):
        """Of this run, whoever their parent is. Never a zombie, and never a copy of its parent: what is between fork and exec."""
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
        """The only process of this program. One that is just in exec has no name yet."""
        try:
            return wait_until(lambda: (lambda found: found[0] if len(found) == 1 else None)(self.processes(program)), 2)
        except AssertionError:
            raise AssertionError("there are %d processes %s" % (len(self.processes(program)), program)) from None

    def wait_for_line(self, pattern, limit=15.0, after=0):
        """The first line of standard error from index `after` on that `pattern` is found in."""
        expression = re.compile(pattern)

        def find():
            over = self._process.poll() is not None and not self._readers[1].is_alive()  # before the look, else it may miss the last
            for text in self.raw[after:]:
                if expression.search(text):
                    return text
            if over:
                raise AssertionError("it ended without a line %r; it said:\n%s" % (pattern, self.err))
            return None

        return wait_until(find, limit, "a line %r" % pattern)

    def wait_for_state(self, module, state, limit=15.0, device=r"[\w-]+"):
        return self.wait_for_line(r" %s\.%s: \w+ -> %s\b" % (device, re.escape(module), state), limit)

    def signal(self, number):
        """When it was sent, by time.monotonic()."""
        now = time.monotonic()
        os.kill(self.pid, number)
        return now

    def wait(self, limit=60.0):
        """Until it has ended and both outputs are closed, by its children too."""
        try:
            self._process.wait(limit)
        except subprocess.TimeoutExpired:
            said = self.err
            self.kill_all()
            raise AssertionError("it did not end within %g s; it said:\n%s" % (limit, said)) from None
        for reader in self._readers:
            reader.join(limit)  # counted from now: the last lines of one that ran for long are read, too
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
        self._process.wait(10)
        for reader, pipe in zip(self._readers, (self._process.stdout, self._process.stderr)):
            reader.join(1)
            if pipe is not None and not reader.is_alive():
                pipe.close()

    # What it said

    @property
    def status(self):
        """The exit status; minus the signal that ended it; none while it runs."""
        return self._process.poll()

    @property
    def out(self):
        return "".join(line for _, line in self.out_lines)

    def wait_for_out(self, pattern, limit=15.0, after=0):
        """When the first line of standard output from index `after` on was read that `pattern` is found in."""
        expression = re.compile(pattern)

        def find():
            return next((at for at, text in self.out_lines[after:] if expression.search(text)), None)

        return wait_until(find, limit, "%r on standard output" % pattern)

    @property
    def err(self):
        return "\n".join(self.raw)

    @property
    def report(self):
        """The object on standard output, which has nothing else on it."""
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
        """Of the nodes, one for each event."""
        found = []
        for text in list(self.raw):
            match = LINE.match(text)
            if match:
                at = int(match[1]) * 3600 + int(match[2]) * 60 + float(match[3])
                found.append(Line(at, match[4], match[5] or "", match[6]))
        return found

    @property
    def other_lines(self):
        """Of standard error, those that no node wrote: the reasons at the end."""
        return [text for text in list(self.raw) if not LINE.match(text)]

    def said(self, module, device=None):
        return [line for line in self.lines if line.module == module and device in (None, line.device)]

    def printed(self, module):
        """What the program of a process module printed, line by line."""
        return [line.text[2:] for line in self.said(module) if line.text.startswith("| ")]

    def steps(self, module, device=None):
        found = []
        for line in self.said(module, device):
            match = STEP.match(line.text)
            if match:
                found.append(Step(line.at, match[1], match[2], match[3] or ""))
        return found

    def states(self, module, device=None):
        """Every state that the module went through, in order. Fails when a step does not begin where the last one ended."""
        states = ["IDLE"]
        for step in self.steps(module, device):
            assert step.source == states[-1], "%s: a step from %s in state %s" % (module, step.source, states[-1])
            states.append(step.target)
        return states


class Watcher:
    """What `takt watch` says, line by line as it comes: the state of each device and module as it was last told."""
    DEVICE = re.compile(r"^\S+ ([\w-]+): (\w+)(?:, (\d+) of (\d+) modules EXECUTING)?")
    MODULE = re.compile(r"^\S+ ([\w-]+)\.([\w-]+): \w+ -> (\w+)")

    def __init__(self, run):
        self._run = run
        self._heard = 0
        self._modules = {}  # by device
        self._whole = {}  # of a device: its state, EXECUTING where all of its modules are

    def _hear(self):
        lines = self._run.out_lines[self._heard:]
        self._heard += len(lines)
        for _, line in lines:
            if match := self.MODULE.match(line):
                self._modules.setdefault(match[1], {})[match[2]] = match[3]
            elif match := self.DEVICE.match(line):
                self._whole[match[1]] = "EXECUTING" if match[3] and match[3] == match[4] else match[2]

    def holds(self, wanted):
        """As Case.wait_for_states(). Modules of an earlier deployment may deceive it."""
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
    """Each test works in a folder of its own, and leaves nothing behind."""

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
                if run.status is not None:  # else the test has failed, and its end is in no order
                    self.assert_nothing_left(run)
        finally:
            for run in self.runs:
                run.kill_all()
            shutil.rmtree(self.folder, ignore_errors=True)

    def beside(self, name):
        """A file of the test's own folder."""
        return os.path.join(os.path.dirname(os.path.abspath(sys.modules[type(self).__module__].__file__)), name)

    def start(self, *arguments, **options):
        """takt with these arguments; a descriptor is named as it lies beside the test. Does not wait."""
        arguments = [self.beside(a) if a.endswith(".xml") and not os.path.isabs(a) else a for a in arguments]
        return self.program("takt", *arguments, **options)

    def program(self, name, *arguments, **options):
        """One of Takt's programs, on the test's domain. Does not wait."""
        environment = {"TAKT_DOMAIN": str(self.domain), "TAKT_STATE_DIR": os.path.join(self.folder, "state")}
        environment.update(options.pop("environment", None) or {})
        run = Run([os.path.join(options.pop("programs", BIN), name)] + list(arguments), self.folder,
                  environment=environment, **options)
        self.runs.append(run)
        return run

    def takt(self, *arguments, limit=60.0, **options):
        return self.start(*arguments, **options).wait(limit)

    def at_once(self, *commands, limit=60.0):
        """Several commands side by side, each a line as one types it after `takt`. Most of what one of them takes is waiting."""
        runs = [self.start(*shlex.split(command)) for command in commands]
        return [run.wait(limit) for run in runs]

    def done(self, *commands):
        """What these print, done side by side; none may be refused."""
        runs = self.at_once(*commands)
        for command, run in zip(commands, runs):
            self.assertEqual(0, run.status, "takt %s: %s" % (command, run.err))
        return [run.out.rstrip("\n") for run in runs]

    def refused(self, commands):
        """Each of these ends with status 1, prints nothing, and says what its pattern finds."""
        for (command, pattern), run in zip(commands.items(), self.at_once(*commands)):
            self.assertEqual((1, ""), (run.status, run.out), "takt %s: %s" % (command, run.err))
            self.assertRegex(run.err, pattern, "takt %s" % command)

    def nodes(self, *devices, **options):
        """A node for each device, all waiting."""
        return {device: self.node(device, **options) for device in devices}

    def end(self, nodes):
        """SIGTERM ends each of them in order."""
        for node in nodes.values():
            node.signal(signal.SIGTERM)
        for node in nodes.values():
            self.assertEqual(0, node.wait(10).status, node.err)

    def deploy(self, descriptor, *options):
        """Deployed; runs from the instant on that all have agreed on."""
        return self.agreed(lambda: self.takt("deploy", descriptor, *options))

    def agreed(self, deploy):
        """The run of a command that deploys. The devices have 0.8 s to agree on the instant: where the machine stands still for longer
        nothing has run, and it is given again."""
        for _ in range(3):
            run = deploy()
            if "it gave no answer to run within" not in run.err:
                break
            print("it is deployed again: " + run.err)
        self.assertEqual(0, run.status, run.err)
        return run

    def wait_for_states(self, wanted, limit=15.0):
        """Until takt status says so: {"device": "EXECUTING"} or {"device": {"module": "START"}}. Returns it, by device. It is asked when
        takt watch has said so, and now and then in any case."""
        if self._watcher is None:
            self._watcher = Watcher(self.start("watch"))
        asked = 0.0

        def holds():
            nonlocal asked
            if not self._watcher.holds(wanted) and not self._watcher.ended and time.monotonic() < asked + 1:
                return None
            asked = time.monotonic()
            run = self.takt("status", "--json")
            if run.status != 0:  # nobody was found in time: the machine stands still
                return None
            status = {d["name"]: d for d in run.report["devices"]}
            for device, states in wanted.items():
                found = {m["name"]: m["state"] for m in status.get(device, {"modules": []})["modules"]}
                if found and not status[device]["alive"]:
                    return None  # these are the states that others heard last
                if isinstance(states, str):
                    if not found or set(found.values()) != {states}:
                        return None
                elif any(found.get(module) != state for module, state in states.items()):
                    return None
            return status
        return wait_until(holds, limit, "%s" % wanted)

    def node(self, device, *arguments, **options):
        """A takt-node that waits for a deployment."""
        run = self.program("takt-node", "--device", device, *arguments, **options)
        run.wait_for_line(r"^\S+ %s: waits for a deployment on domain %d" % (device, self.domain))
        return run

    def status_of(self, device=None, **options):
        """What takt status says of the domain, or of one device."""
        run = self.takt("status", "--json", **options)
        self.assertEqual(0, run.status, run.err)
        return run.report if device is None else run.device(device)

    def states_of(self, device):
        return {m["name"]: m["state"] for m in self.status_of(device)["modules"]}

    def read(self, name):
        """A file that a module wrote."""
        with open(os.path.join(self.folder, name)) as file:
            return file.read()

    def write(self, name, text):
        path = os.path.join(self.folder, name)
        with open(path, "w") as file:
            file.write(text)
        return path

    def assert_nothing_left(self, run, limit=3.0):
        """No process of the run, hence no thread; nobody at all who holds its memories; no name in /dev/shm."""
        def left():
            return [p for p in run.processes() if p.alive]
        try:
            wait_until(lambda: not left(), limit)
        except AssertionError:
            self.fail("left behind: %s" % left())
        if run._seen:
            # A process that is ending has no environment any more before it closes its files.
            def holders():
                return [p for p in _pids() if Process(p, "", []).memories() & run._seen]
            try:
                wait_until(lambda: not holders(), limit)
            except AssertionError:
                self.fail("processes that hold shared memory of a run that is over: %s" % holders())
        new = {name for name in os.listdir("/dev/shm") if "takt" in name} - self._shared_before
        self.assertEqual(set(), new, "left in /dev/shm")

    def assert_grid(self, run, module, every=1, executor="main", device=None, broken_rows=0):
        """A periodic module that was in the tables from the first row to the last: it was called, or found busy, in each row
        that is its, save those that the executor missed. `every`: its period in rows. `broken_rows`: in which the host ended,
        so that the executor did not count them."""
        rows = run.executor(executor, device)
        m = run.modules(device)[module]
        due = -(-(rows["cycles"] + rows["missed"]) // every)
        met = m["cycles"] + (m["overruns"] if m["type"] == "process" else 0)
        self.assertGreater(met, 0, module)
        self.assertLessEqual(met, min(due, rows["cycles"] + broken_rows), module)
        self.assertGreaterEqual(met, due - rows["missed"], module)

    def assert_refused(self, run, *patterns):
        """Status 1, nothing ran, and standard error has a line for each pattern."""
        self.assertEqual(1, run.status, run.err)
        self.assertNotIn("EXECUTING", run.err)
        for pattern in patterns:
            self.assertRegex(run.err, pattern)


def main():
    unittest.main(verbosity=2)
