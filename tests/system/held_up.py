"""Measures how long threads that were ready to run waited for a CPU, according to the kernel. On a machine that other programs use, they
may have to wait."""

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
    """Returns, for each thread of these processes, how many seconds it has waited for a CPU since its start. Ignores threads whose name is
    in `but`."""
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
    """Returns the longest time that any thread waited for a CPU between two calls of waits(), whose results are `before` and `after`."""
    return max((waited - before.get(thread, 0.0) for thread, waited in after.items()), default=0.0)
