"""Collects the state transitions, safe values and wrong samples that nodes and readers print while they run. All times are in seconds since
1970."""

import json
import re
import threading
import time
from collections import namedtuple

from takt_system import LINE, STATES, STEP

Step = namedtuple("Step", "at module source target text")
Reading = namedtuple("Reading", "at who what number")  # `what` is SAFE, LIVE or WRONG

_READING = re.compile(r"\b(near|far|relayed) (SAFE|LIVE|WRONG) (\d+) [a-z, ]+ (\d+)$")
_CARRIED_OUT = re.compile(r"carries out (\d+) at (\d+)$")

# The state transitions that the lifecycle allows (framework/lifecycle).
ALLOWED = {("IDLE", "INITIALIZE"), ("INITIALIZE", "START"), ("START", "EXECUTING"), ("EXECUTING", "START"),
           ("INITIALIZE", "RECOVER"), ("START", "RECOVER"), ("EXECUTING", "RECOVER"), ("RECOVER", "EXECUTING"),
           ("RECOVER", "START"), ("DESTRUCT", "IDLE")} | {(state, "DESTRUCT") for state in STATES if state != "DESTRUCT"}


def since_1970(hours, minutes, seconds):
    """Returns the time nearest to now at which the local clock shows these hours, minutes and seconds."""
    now = time.time()
    today = time.localtime(now)
    midnight = time.mktime((today.tm_year, today.tm_mon, today.tm_mday, 0, 0, 0, 0, 0, -1))
    at = midnight + 3600 * int(hours) + 60 * int(minutes) + float(seconds)
    return min((at - 86400, at, at + 86400), key=lambda t: abs(t - now))


def step_of(text):
    match = STEP.match(text)
    return match and (match[1], match[2], match[3] or "")


def line_of(text):
    """Returns the time, device, module and text of a line that a node printed, or None for any other line."""
    match = LINE.match(text)
    return match and (since_1970(*match.groups()[:3]), match[4], match[5] or "", match[6])


def breaks(module, steps):
    """Returns an error text for each transition of the module that breaks the rules of the lifecycle. The first transition must begin in
    IDLE."""
    found = []
    state = "IDLE"
    met = None  # the state in which the module had its last error
    for step in steps:
        if step.source != state:
            found.append("%s: a step from %s while in %s: %s" % (module, step.source, state, step))
        if (step.source, step.target) not in ALLOWED:
            found.append("%s: the lifecycle has no such step: %s" % (module, step))
        if step.target == "RECOVER":
            met = step.source
        if step.source == "RECOVER" and step.target in ("START", "EXECUTING") and \
                step.target != ("EXECUTING" if met == "EXECUTING" else "START"):
            found.append("%s: after an error in %s, this step is wrong: %s" % (module, met, step))
        state = step.target
    return found


class Ear:
    """Reads the output of one node from its start to its end."""

    def __init__(self, run):
        self.run = run
        self.steps = []
        self.readings = []
        self.carried_out = {}  # for each command number, the time at which the module carried out the command
        self.said = []  # all lines of the node: (at, module, text)
        self.states = {}
        self.live = {}  # for each reader, True while it reads samples
        self._heard = 0
        self._monotonic = time.time() - time.monotonic()
        self._lock = threading.Lock()

    def hear(self):
        with self._lock:
            raw = self.run.raw
            while self._heard < len(raw):
                self._take(raw[self._heard])
                self._heard += 1

    def _take(self, text):
        line = line_of(text)
        if line is None:
            return
        at, _, module, what = line
        self.said.append((at, module, what))
        step = step_of(what)
        if step:
            self.steps.append(Step(at, module, *step))
            self.states[module] = step[1]
            return
        reading = _READING.search(what)
        if reading:
            found = Reading(int(reading[3]) / 1e9 + self._monotonic, reading[1], reading[2], int(reading[4]))
            self.readings.append(found)
            if found.what != "WRONG":
                self.live[found.who] = found.what == "LIVE"
            return
        told = _CARRIED_OUT.search(what)
        if told:
            self.carried_out[int(told[1])] = int(told[2]) / 1e9

    def mark(self):
        """Returns a mark that separates the lines so far from later lines. Nodes print times in ms, so the first later line may show a time
        just before the mark."""
        self.hear()
        return len(self.said), len(self.steps), len(self.readings)

    def first(self, pattern, mark, module=None):
        """Returns the time of the first line after the mark that matches `pattern`."""
        return next((at for at, of, text in self.said[mark[0]:] if module in (None, of) and re.search(pattern, text)), None)

    def first_step(self, module, target, mark, pattern=""):
        """Returns the time of the first transition of the module to state `target` after the mark, if its text matches `pattern`."""
        return next((step.at for step in self.steps[mark[1]:] if step.module == module and step.target == target and
                     re.search(pattern, step.text)), None)

    def first_reading(self, who, what, mark, since):
        """Returns the time at which the reader `who` first reported `what`, after the mark and not before `since`."""
        return next((r.at for r in self.readings[mark[2]:] if r.who == who and r.what == what and r.at > since - 1e-3), None)

    def last_news(self, mark):
        """Returns the time of the last transition after the mark, or of the last reader that began to read samples again, whichever is
        later."""
        return max([step.at for step in self.steps[mark[1]:]] + [r.at for r in self.readings[mark[2]:] if r.what == "LIVE"],
                   default=None)

    def breaks(self):
        by_module = {}
        for step in self.steps:
            by_module.setdefault(step.module, []).append(step)
        return [found for module, steps in by_module.items() for found in breaks(module, steps)]

    def wrong(self):
        return [reading for reading in self.readings if reading.what == "WRONG"]


class Monitor:
    """Reads the output of takt watch on another machine, and notes when each transition arrived there."""
    Seen = namedtuple("Seen", "came device step")  # `step` is None if the device is LOST

    def __init__(self, run):
        self.run = run
        self.seen = []
        self._heard = 0
        self._monotonic = time.time() - time.monotonic()

    def hear(self):
        lines = self.run.out_lines
        while self._heard < len(lines):
            came, text = lines[self._heard]
            self._heard += 1
            line = line_of(text.rstrip("\n"))
            if line is None:
                continue
            at, device, module, what = line
            step = step_of(what)
            if step and step[0] == step[1]:
                continue  # this is not a transition: takt watch prints the first known state of a module in this form
            if step:
                self.seen.append(self.Seen(came + self._monotonic, device, Step(at, module, *step)))
            elif not module and what.startswith("LOST"):
                self.seen.append(self.Seen(came + self._monotonic, device, None))

    def mark(self):
        self.hear()
        return len(self.seen)

    def first_trouble(self, device, mark, since):
        """Returns the time at which takt watch first showed the device as LOST, or one of its modules in RECOVER or DESTRUCT, after the
        mark and `since`."""
        return next((s.came for s in self.seen[mark:] if s.device == device and s.came > since and
                     (s.step is None or s.step.target in ("RECOVER", "DESTRUCT"))), None)

    def missed(self, device, module, steps):
        """Compares the transitions of a module with those that takt watch showed. Returns those that are missing there, and those that only
        takt watch showed. `steps` has the transitions from all nodes of the device."""
        told = [s.step for s in self.seen if s.device == device and s.step is not None and s.step.module == module]
        missed = []
        position = 0
        for step in steps:
            if position < len(told) and told[position][2:4] == step[2:4] and abs(told[position].at - step.at) < 0.1:
                position += 1
            else:
                missed.append(step)
        return missed, told[position:]


class Record:
    """Reads the events that takt log --follow prints, from the fault records of all nodes."""

    def __init__(self, run):
        self.run = run
        self.events = []
        self._heard = 0

    def hear(self):
        lines = self.run.out_lines
        while self._heard < len(lines):
            self.events.append(json.loads(lines[self._heard][1]))
            self._heard += 1

    def mark(self):
        self.hear()
        return len(self.events)

    def first(self, kind, device, mark, module="", cause=""):
        """Returns the time of the first such event after the mark, by the clock of the device, or None if there is none yet."""
        return next((e["time_ns"] / 1e9 for e in self.events[mark:] if e["kind"] == kind and e["device"] == device and
                     (e["module"] or "") == module and cause in e["cause"]), None)
