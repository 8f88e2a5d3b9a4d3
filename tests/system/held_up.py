"""How long threads that were ready to run waited for a CPU, as the kernel counts it. A shared machine can make them wait."""

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
    """For each thread of these processes: the seconds since its start in which it was ready but did not run. Threads with a name in
    `but` are left out."""
    found = {}
    for pid in pids:
        try:
            tasks = os.listdir("/proc/%d/task" % pid)
        except OSError:
            continue  # it has ended
        for task in tasks:
            waited = _waited(pid, task)
            if waited and waited[0] not in but:
                found[pid, task] = waited[1]
    return found


def longest(before, after):
    """The longest time that any thread waited between two calls of waits()."""
    return max((waited - before.get(thread, 0.0) for thread, waited in after.items()), default=0.0)
