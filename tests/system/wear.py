"""Checks that a long-running process does not leak memory, threads or open files."""

import os


def taken_by(pid):
    """Returns how much memory, how many threads and how many open files a process has."""
    with open("/proc/%d/status" % pid) as file:
        status = dict(line.split(":", 1) for line in file if ":" in line)
    return {"rss_kib": int(status["RssAnon"].split()[0]),
            "threads": int(status["Threads"]),
            "files": len(os.listdir("/proc/%d/fd" % pid))}


class Wear:
    """Measures the resources of one program that is sometimes killed and restarted. Call look() regularly, and assert_none() at the end."""

    def __init__(self, name):
        self.name = name
        self.lives = []  # for each process of the program, a list of the values that look() read

    def begin(self):
        """Starts the measurement of a new process of this program."""
        self.lives.append([])

    def look(self, pid, **more):
        self.lives[-1].append({**more, **taken_by(pid)})

    @property
    def ends(self):
        """Returns the first values after the warm-up, the last values, and the numbers of measurements and processes."""
        looks = [look for life in self.lives for look in life]
        return {"first": looks[min(1, len(looks) - 1)], "last": looks[-1], "looks": len(looks), "lives": len(self.lives)} if looks else {}

    def assert_none(self, test, memory_from=4):
        """Fails if the use of a resource has grown. Ignores the memory of a process that was measured less than `memory_from` times."""
        # A process needs more memory after it has written its first fault trace. So this function compares the last values with those of the
        # first half of the process's life, not with those of its start.
        for life in self.lives:
            first, second = life[1:len(life) // 2], life[len(life) // 2:]
            if not first:
                continue
            for what, more in (("files", 0), ("threads", 0), ("rss_kib", 4096)):
                if more and len(life) < memory_from:
                    continue
                before = max(taken[what] for taken in first)
                test.assertLessEqual(second[-1][what], before * (1.25 if more else 1) + more, (self.name, what, life))
