"""How long a shared machine kept threads waiting that were ready to run, as the kernel counts it."""

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
    """Of each thread of these processes, in seconds: how long it has been ready and did not run, since it began. `but`: threads of
    these names are not asked for."""
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
    """What any thread has waited between two looks."""
    return max((waited - before.get(thread, 0.0) for thread, waited in after.items()), default=0.0)
