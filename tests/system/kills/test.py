import collections
import json
import os
import pathlib
import random
import signal
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import networks
import takt_system
from takt_system import wait_until
from wear import Wear, taken_by

SECONDS = takt_system.how_much("TAKT_KILLS_SECONDS", 12.0, 600.0)
SEED = int(os.environ.get("TAKT_KILLS_SEED", "0")) or random.randrange(1, 1 << 30)
DEVICES = ("left", "right")
MODULES = ("left.source", "left.own", "left.program", "right.far", "right.answers", "right.program")
RESTARTS, WINDOW = 3, 60.0  # the recovery rule of a host: kHostRestarts and kRestartWindow in framework/supervision/src/limits.hpp
SAMPLED_EVERY = 5.0  # seconds
CHECKED_EVERY = 10  # kills


class Kills(networks.NetworkCase):
    MACHINES = DEVICES

    def setUp(self):
        super().setUp()
        self.random = random.Random(SEED)
        self.running = {}
        self.ended = []  # the runs of killed nodes
        self.host_ends = collections.defaultdict(list)  # for each host of the present nodes, when it was killed
        self.killed = collections.Counter()
        self.given_up = collections.Counter()
        self.samples = []
        self.asked = None  # the command of the operator that runs
        self.commands = 0

    def start_node(self, device):
        self.running[device] = self.node(device, "--resume")
        for host in [host for host in self.host_ends if host[0] == device]:
            del self.host_ends[host]

    def victim(self, device, *programs):
        """Returns a process of the device that executes one of these programs; none if all have been given up or restart just now."""
        found = [p for p in self.running[device].processes() if p.program in programs]
        return self.random.choice(found) if found else None

    # Each of these functions kills one process. The node and the operator then go on as usual.

    def node_killed(self):
        device = self.random.choice(DEVICES)
        run = self.running[device]
        run.one("takt-node").kill()
        run.wait()
        self.assert_nothing_left(run)
        self.runs.remove(run)
        self.start_node(device)

    def host_killed(self):
        device = self.random.choice(DEVICES)
        host = self.victim(device, "takt-host")
        if host is None:
            return
        shares = self.hosts_of(device)
        host.kill()
        wait_until(lambda: not host.alive, "the end of host %s" % (host,))
        # Only the device's own host has the executor `risky`; its threads have the name of the executor.
        self.host_ends[device, shares.get(host.pid, "shared")].append(time.monotonic())

    def hosts_of(self, device):
        """Returns for each host of the device, by its PID, whether it is the own host of an executor or the shared one."""
        found = {}
        for process in self.running[device].processes("takt-host"):
            try:
                names = [pathlib.Path(task, "comm").read_text() for task in pathlib.Path("/proc/%d/task" % process.pid).iterdir()]
            except OSError:
                continue
            found[process.pid] = "own" if any("risky" in name for name in names) else "shared"
        return found

    def program_killed(self):
        self.kill(self.victim(self.random.choice(DEVICES), "grid.exe"))

    def keeper_killed(self):
        self.kill(self.victim(self.random.choice(DEVICES), "takt-keeper"))

    @staticmethod
    def kill(process):
        if process is not None:
            try:
                process.kill()
            except ProcessLookupError:  # it has just ended with another one that was killed
                pass

    def command_killed(self):
        arguments = self.random.choice((["watch"], ["echo", "left.source.out"], ["deploy", self.descriptor(), "--update"], ["status"],
                                        ["restart", self.random.choice(MODULES)], ["log", "left"]))
        run = self.start(*arguments)
        time.sleep(self.random.uniform(0, 0.5))
        run.signal(signal.SIGKILL)
        run.wait()
        self.runs.remove(run)

    def descriptor(self):
        """Writes the cell with another value of a property, so that an update has something to change."""
        with open(self.beside("cell.xml")) as file:
            text = file.read()
        value = "<property><value name=\"burst\">%d</value></property>" % self.random.randrange(1, 5)
        return self.write("cell.xml", text.replace("<name>answers</name>", "<name>answers</name> " + value))

    def command(self):
        """Starts one command of the operator, unless the last one has not ended yet. It may fail, because a node or host may be dead just
        now."""
        if self.asked is not None:
            if self.asked.status is None:
                return
            self.end_command()
        module = self.random.choice(MODULES)
        self.asked = self.start(*self.random.choice((["status"], ["get", "right.answers", "burst"], ["set", "right.answers", "burst", "2"],
                                                     ["stop", module], ["start", module], ["log", module.split(".")[0]])))

    def end_command(self):
        if self.asked is not None:
            run = self.asked.wait()
            self.assertIn(run.status, (0, 1), run.err)
            self.runs.remove(run)
            self.commands += 1
            self.asked = None

    def rule_gives_up(self, device, host):
        """True if the host may have been given up: it was killed more than three times in a minute. A second of tolerance, because the node
        counts from the moment in which it notices an end."""
        ends = self.host_ends[device, host]
        return any(ends[i + RESTARTS] - ends[i] < WINDOW + 1 for i in range(len(ends) - RESTARTS))

    def restore(self):
        """Waits until all modules execute, and starts those that the operator has stopped. Only modules whose host was killed too often may
        have been given up; the operator then resets or deploys them again."""
        self.end_command()
        seen = {}

        def lost():
            nonlocal seen
            status = self.status()
            seen = {"%s.%s" % (d, m["name"]): m["state"] for d in DEVICES if status.get(d, {}).get("alive") for m in status[d]["modules"]}
            for module in [module for module, state in seen.items() if state == "START"]:
                self.operator("start", module)
            missing = [module for module in MODULES if seen.get(module) != "EXECUTING"]
            by_rule = all(self.rule_gives_up(m.split(".")[0], "own" if m == "left.own" else "shared") for m in missing)
            return missing if by_rule and "RECOVER" not in seen.values() else None

        try:
            found = []
            wait_until(lambda: found.append(lost()) or found[-1] is not None)
        except AssertionError:
            self.fail("after %s, hosts killed %s, seed %d: %s\n%s" % (dict(self.killed), dict(self.host_ends), SEED, seen, "\n".join(
                "%s: %s" % (device, run.err[-4000:]) for device, run in self.running.items())))
        missing = found[-1]
        if not missing:
            return
        self.given_up[" ".join(missing)] += 1
        if missing == ["left.own"]:
            for verb in ("reset", "initialize", "start"):
                self.assertEqual(0, self.operator(verb, "left.own").status, verb)
        else:
            self.operator("undeploy", "kills")
            self.deploy_cell()
        for device, host in list(self.host_ends):
            if any(m.startswith(device) for m in missing):
                del self.host_ends[device, host]
        self.restore()

    def deploy_cell(self):
        self.agreed(lambda: self.operator("deploy", self.descriptor()))

    def sample(self, watch):
        processes = [p for run in self.running.values() for p in run.processes()]
        total = collections.Counter()
        for process in processes:
            try:
                total.update(taken_by(process.pid))
            except (OSError, KeyError):
                continue
            total["processes"] += 1
        state = [os.path.join(at, name) for d in DEVICES for at, _, names in os.walk(os.path.join(self.folder, d)) for name in names]
        self.samples.append({"s": round(time.monotonic() - self.began, 1), **total, "shm": len(os.listdir("/dev/shm")),
                             "state_files": len(state),
                             "watch": taken_by(watch.pid), "bystander": taken_by(self.bystander.one("takt-node").pid)})

    def test_a_kill_a_second_of_any_process_of_a_cell_leaves_nothing_behind(self):
        for device in DEVICES:
            self.start_node(device)
        # These two programs live through the whole test, and see every other one come and go.
        self.bystander = self.node("bystander", on="operator")
        watch = self.start("watch")
        wears = {"watch": Wear("takt watch"), "bystander": Wear("the bystander")}
        for wear in wears.values():
            wear.begin()
        self.deploy_cell()
        kinds = (self.node_killed, self.host_killed, self.program_killed, self.keeper_killed, self.command_killed)
        self.began = time.monotonic()
        sampled = self.began - SAMPLED_EVERY
        kills = 0
        while time.monotonic() - self.began < SECONDS:
            at = time.monotonic()
            kind = self.random.choice(kinds)
            self.killed[kind.__name__] += 1
            kind()
            self.command()
            kills += 1
            takt_system.progress("%.0f of %.0f s, %s" % (at - self.began, SECONDS, dict(self.killed)))
            if time.monotonic() - sampled > SAMPLED_EVERY:
                sampled = time.monotonic()
                self.sample(watch)
                wears["watch"].look(watch.pid)
                wears["bystander"].look(self.bystander.one("takt-node").pid)
            if kills % CHECKED_EVERY == 0:
                self.restore()
            time.sleep(max(0.0, at + 1 - time.monotonic()))
        self.restore()
        self.assertEqual(0, self.operator("undeploy", "kills").status)
        for device in DEVICES:
            wait_until(lambda: [p.program for p in self.running[device].processes()] == ["takt-node"],
                       "the host and programs of %s to end" % device)
            left = [n for n in os.listdir(os.path.join(self.folder, device)) if n.endswith(".deployment")]
            self.assertEqual([], left, "the deployment is forgotten")
        self.sample(watch)
        figures = {"seed": SEED, "seconds": round(time.monotonic() - self.began), "killed": dict(self.killed), "commands": self.commands,
                   "given_up": dict(self.given_up), "first": self.samples[min(2, len(self.samples) - 1)], "last": self.samples[-2:],
                   "wear": {name: wear.ends for name, wear in wears.items()}}
        print("\n" + json.dumps(figures, indent=1))
        if os.environ.get("TAKT_KILLS_REPORT"):
            with open(os.environ["TAKT_KILLS_REPORT"], "w") as file:
                json.dump({**figures, "samples": self.samples}, file, indent=1)
        # A single sample may catch the cell while a part of it restarts, so only the highest ones are compared.
        most = [{what: max(sample.get(what, 0) for sample in half) for what in ("processes", "threads", "files", "state_files")}
                for half in (self.samples[:len(self.samples) // 2], self.samples[len(self.samples) // 2:])]
        if len(self.samples) > 20:
            for what, before in most[0].items():
                self.assertLessEqual(most[1][what], 1.25 * before, "%s: %s" % (what, self.samples))
        watch.signal(signal.SIGINT)
        watch.wait()
        self.end({**self.running, "bystander": self.bystander})
        self.assertEqual([], os.listdir("/dev/shm"))
        for wear in wears.values():
            wear.assert_none(self)


if __name__ == "__main__":
    takt_system.main()
