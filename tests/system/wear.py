"""What a process takes while it runs: memory, threads, open files. After hours it is what it was after minutes."""

import os


def taken_by(pid):
    """Memory of its own, threads, open files."""
    with open("/proc/%d/status" % pid) as file:
        status = dict(line.split(":", 1) for line in file if ":" in line)
    return {"rss_kib": int(status["RssAnon"].split()[0]),
            "threads": int(status["Threads"]),
            "files": len(os.listdir("/proc/%d/fd" % pid))}


class Wear:
    """Of one program that is now and then killed and begun anew: look() at it, then assert_none()."""

    def __init__(self, name):
        self.name = name
        self.lives = []  # of each, what it took, in order

    def begin(self):
        """A new process took the place of the one before."""
        self.lives.append([])

    def look(self, pid, **more):
        self.lives[-1].append({**more, **taken_by(pid)})

    @property
    def ends(self):
        """What it took first (after the warm-up) and last, and how often it was looked at."""
        looks = [look for life in self.lives for look in life]
        return {"first": looks[min(1, len(looks) - 1)], "last": looks[-1], "looks": len(looks), "lives": len(self.lives)} if looks else {}

    def assert_none(self, test, memory_from=4):
        """`memory_from`: a life of fewer looks is too short to say what it has come to keep."""
        # A process has its own beginning, and what it needs for a trace of a fault it keeps: the second half of its life is
        # held against the first.
        for life in self.lives:
            first, second = life[1:len(life) // 2], life[len(life) // 2:]
            if not first:
                continue
            for what, more in (("files", 0), ("threads", 0), ("rss_kib", 4096)):
                if more and len(life) < memory_from:
                    continue
                before = max(taken[what] for taken in first)
                test.assertLessEqual(second[-1][what], before * (1.25 if more else 1) + more, (self.name, what, life))
