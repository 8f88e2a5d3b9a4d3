"""Measures how long threads that were ready to run waited for a CPU, as the kernel counts it. On a shared machine they may wait."""

import os


def _waited(pid, task):
    try:
        with open("/proc/%d/task/%s/comm" % (pid, task)) as file:
            name = file.read().strip()
        with open("/proc/%d/task/%s/schedstat" % (pid, task)) as file:
            return name, int(file.read().split()[1]) / 1e9
    except (OSError, IndexError):
        return None


def waits(pids, but=()):
    """Returns for each thread of these processes the time, in seconds since its start, in which it was ready but did not run. Leaves out
    threads with a name in `but`."""
    found = {}
    for pid in pids:
        try:
            tasks = os.listdir("/proc/%d/task" % pid)
        except OSError:
            continue  # the process has ended
        for task in tasks:
            waited = _waited(pid, task)
            if waited and waited[0] not in but:
                found[pid, task] = waited[1]
    return found


def longest(before, after):
    """Returns the longest time that any thread waited between two calls of waits()."""
    return max((waited - before.get(thread, 0.0) for thread, waited in after.items()), default=0.0)
