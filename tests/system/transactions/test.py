import os
import random
import re
import signal
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import networks
import takt_system
from takt_system import wait_until

ROUNDS = takt_system.how_much("TAKT_ROUNDS", 4, 300)
LONGEST = takt_system.how_much("TAKT_LONGEST_FAULT", 5.0, 30.0)
SEED = int(os.environ.get("TAKT_SEED") or random.randrange(1 << 31))
DEVICES = ("robot", "line")
# What takt says if it cannot know the outcome.
UNKNOWN = r"the devices decide together|did not confirm|not confirmed this|not reached"


class Transactions(networks.NetworkCase):
    MACHINES = DEVICES

    def file_of(self, version):
        with open(self.beside("cell.xml")) as file:
            return self.write(version + ".xml", file.read().replace("<name>old</name>", "<name>%s</name>" % version))

    def versions(self):
        """Returns what each device runs: a version, or "none"; or None if the devices have not decided yet or do not all answer."""
        run = self.operator("status", "--json")
        if run.status != 0 or "differences" in run.report:
            return None
        found = {}
        for device in run.report["devices"]:
            names = {m["name"] for m in device["modules"] if m["state"] != "DESTRUCT"}
            if not device["alive"] or device["stage"] in ("prepared", "armed", "running"):
                return None
            if device["state"] == "waiting" and not names:
                found[device["name"]] = "none"
            elif device["state"] == "running" and len(names) == 1 and {m["state"] for m in device["modules"]} == {"EXECUTING"}:
                found[device["name"]] = names.pop()
            else:
                return None
        return found if set(found) == set(DEVICES) else None

    def agreed_version(self):
        last = []

        def agree():
            found = self.versions()
            last[:] = [found]
            return found["robot"] if found and len(set(found.values())) == 1 else None

        try:
            return wait_until(agree, "the devices to agree")
        except AssertionError:
            raise AssertionError("the devices do not agree: %s\n%s" % (last, self.takt("status").out)) from None

    def inject(self, fault, run):
        """Injects the fault and returns the function that ends it."""
        kind, target = fault
        if kind == "cut":
            self.net.cut(target)
            return lambda: self.net.join(target)
        if kind == "halt":
            halted = run if target == "operator" else self.running[target]
            return (lambda: halted.signal(signal.SIGCONT)) if halted.halt() else (lambda: None)
        if kind == "kill" and target == "operator":
            if run.halt():
                run.signal(signal.SIGKILL)
        elif kind == "kill":
            self.running[target].signal(signal.SIGKILL)
            self.running[target].wait()
            return lambda: self.resume(target)
        return lambda: None

    def resume(self, device):
        self.running[device] = self.program("takt-node", "--device", device, "--resume", on=device,
                                            environment={"TAKT_STATE_DIR": os.path.join(self.folder, device)})

    def expected(self, action, before, after, run):
        """Returns the outcomes that the exit status and the messages of takt allow."""
        if run.status is None or run.status < 0 or re.search(UNKNOWN, run.err):
            return {before, after}
        if run.status == 0 or re.search(" is updated, because ", run.err):
            return {after}
        return {before} if action != "undeploy" else {before, after}

    def test_all_devices_have_the_same_deployment_after_random_faults_and_takt_tells_the_truth(self):
        print("seed %d" % SEED)
        chance = random.Random(SEED)
        self.running = self.nodes(*DEVICES)
        before = "none"
        counts = {}
        for number in range(ROUNDS):
            action = "deploy" if before == "none" else chance.choice(("update", "update", "undeploy"))
            after = {"deploy": "old", "undeploy": "none", "update": "new" if before == "old" else "old"}[action]
            kind = chance.choice(("cut", "halt", "kill", "nothing"))
            fault = (kind, chance.choice(("operator",) + DEVICES))
            delay, duration = chance.uniform(0, 1.2), chance.choice((chance.uniform(0.1, 2), chance.uniform(2, LONGEST)))
            said = "round %d: %s from %s, %s %s after %.2f s for %.1f s" % (number, action, before, *fault, delay, duration)
            command = ["undeploy", "cell"] if action == "undeploy" else ["deploy", self.file_of(after)] + ["--update"] * (action == "update")
            run = self.start(*command)
            time.sleep(delay)
            mend = self.inject(fault, run)
            time.sleep(duration if kind in ("cut", "halt") else 0)
            mend()
            run.wait(limit=3 * takt_system.LONG)
            self.runs.remove(run)
            found = self.agreed_version()
            print("%s: exit status %s, %s" % (said, run.status, found))
            self.assertIn(found, self.expected(action, before, after, run), "%s\n%s" % (said, run.err))
            counts[action, kind] = counts.get((action, kind), 0) + 1
            before = found
        print("rounds by action and fault: %s" % counts)
        if before != "none":
            self.done("undeploy cell")
        self.end(self.running)


if __name__ == "__main__":
    takt_system.main()
