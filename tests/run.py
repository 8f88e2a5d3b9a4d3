"""Runs the tests of all builds in one CTest run, so that a test of one build can run while a test of another build waits.

    run.py FOLDER [CTEST ARGUMENTS]         FOLDER holds the CTestTestfile.cmake of all builds
    run.py --check [CTEST ARGUMENTS]        only checks the arguments

CTest ignores words that it does not know, and runs all tests. So run.py rejects them, with exit status 2.

A failed test that uses real processes, a network or real time (LABELS) runs once more, alone, after all other tests. If it passes then, it
is unstable: a busy machine can make it fail. The run fails if a test fails twice, if any other test fails, or if more than MOST_UNSTABLE
tests are unstable. FOLDER/unstable keeps the output of the first failure of each unstable test, FOLDER/summary the end of the report.
"""

import collections
import json
import os
import pathlib
import re
import shutil
import statistics
import subprocess
import sys
import threading
import time
import xml.etree.ElementTree as xml

LABELS = {"system", "dds", "real", "timing", "asan", "tsan"}
MOST_UNSTABLE = 10
TESTS_AT_ONCE = 3 * len(os.sched_getaffinity(0)) - 1  # most tests wait more than they compute
USUAL_START = 0.004  # seconds
USUAL_WAKE_UP = 0.0005
RESOURCES = pathlib.Path(__file__).resolve().parent / "resources.json"

Failed = collections.namedtuple("Failed", "number name")


class Load:
    """Notes the highest load average of the last minute while it is active."""

    def __enter__(self):
        self.highest = 0.0
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._watch)
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._ended.set()
        self._thread.join()

    def _watch(self):
        while True:
            self.highest = max(self.highest, os.getloadavg()[0])
            if self._ended.wait(1):
                return


def slowness():
    """Returns how many times slower than usual this machine starts a process or wakes a thread: between 1 and 5. The usual times are those
    of an idle virtual machine with two CPUs."""
    def median_of(function):
        times = []
        for _ in range(20):
            begin = time.perf_counter()
            function()
            times.append(time.perf_counter() - begin)
        return statistics.median(times)
    started = median_of(lambda: subprocess.run(["true"], check=True))
    woken = median_of(lambda: time.sleep(0.001)) - 0.001
    print("starting a process takes %.1f ms here, waking a thread %.2f ms" % (1000 * started, 1000 * woken), flush=True)
    return min(5.0, max(1.0, started / USUAL_START, woken / USUAL_WAKE_UP))


def ctest(folder, arguments, results):
    """Runs CTest and shows its output. Returns the exit status, the failed tests, and the summary at the end of the output."""
    log = folder / "Testing/Temporary/LastTestsFailed.log"
    log.unlink(missing_ok=True)  # CTest leaves the file of an earlier run if no test fails
    command = ["ctest", "--test-dir", str(folder), "--resource-spec-file", str(RESOURCES), "--output-on-failure", "--output-junit",
               str(results), *arguments]
    summary = []
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, errors="replace") as run:
        for line in run.stdout:
            sys.stdout.write(line)
            sys.stdout.flush()
            if summary or re.match(r"[0-9]+% tests passed", line):
                summary.append(line)
    failed = [Failed(*line.split(":", 1)) for line in log.read_text().splitlines()] if log.exists() else []
    return run.returncode, failed, "".join(summary)


def options_of_ctest():
    """Returns the options of CTest: True if a value follows as the next word. Options that end with "=" contain their value."""
    options = {}
    for line in subprocess.run(["ctest", "--help"], stdout=subprocess.PIPE, text=True, check=True).stdout.splitlines():
        head = re.match(r"  (-.*?)(?:= [A-Z].*)?$", line)
        found = re.findall(r"(?:^|, ?)(-[-\w.]*\w)(\[?=|)( [<\[ua]|)", head[1]) if head else []
        for name, within, _ in found:
            if within:
                options[name + "="] = False
            if within != "=":
                options[name] = any(value for _, _, value in found)
    return options | {"--test-load": True}  # the help does not show its value


def mistake_in(arguments):
    """Returns what is wrong with these arguments for CTest, or an empty string."""
    options = options_of_ctest()
    words = iter(arguments)
    for word in words:
        if not word.startswith("-"):
            return "CTest ignores the argument %s; to run the tests whose names contain it, write -R %s" % (word, word)
        is_known = word in options or word[:word.find("=") + 1] in options or re.fullmatch(r"-j\d+", word)
        if not is_known:
            return "CTest has no option %s; ctest --help lists its options" % word
        if options.get(word) and next(words, None) is None:
            return "a value must follow the option %s" % word
    return ""


def labels_by_name(folder):
    listing = subprocess.run(["ctest", "--test-dir", str(folder), "--show-only=json-v1"], stdout=subprocess.PIPE, check=True).stdout
    return {test["name"]: {label for each in test.get("properties", []) if each["name"] == "LABELS" for label in each["value"]}
            for test in json.loads(listing)["tests"]}


def slowest(results):
    cases = sorted(((float(case.get("time")), case.get("name")) for case in xml.parse(results).getroot().iter("testcase")), reverse=True)
    rows = ["%8.1f s  %s\n" % case for case in cases[:10]]
    return "\nThe slowest of %d tests:\n%s" % (len(cases), "".join(rows))


def keep_output(results, names, folder):
    """Writes the output of each named test to a file in `folder`."""
    folder.mkdir()
    for case in xml.parse(results).getroot().iter("testcase"):
        if case.get("name") in names:
            (folder / re.sub(r"[^\w.-]+", "_", case.get("name"))).write_text(case.findtext("system-out") or "")


def second_look(folder, failed):
    """Runs the failed tests that may depend on the load once more, one at a time. Returns the unstable tests and the summary of CTest."""
    labels = labels_by_name(folder)
    again = [test for test in failed if LABELS & labels[test.name]]
    if not again or len(again) > MOST_UNSTABLE:
        print("\nNo second look: %s." % ("more than %d tests failed" % MOST_UNSTABLE if again else "these tests do not depend on the load of the machine"))
        return [], ""
    print("\nRunning %d failed tests once more, one at a time, because a busy machine can make them fail:" % len(again), flush=True)
    numbers = ",".join(test.number for test in again)
    _, twice, summary = ctest(folder, ["-I", "0,0,0," + numbers], folder / "second_look.xml")
    return [test for test in again if test not in twice], summary


def main(folder, arguments):
    folder = pathlib.Path(folder).resolve()
    results = folder / "results.xml"
    results.unlink(missing_ok=True)
    shutil.rmtree(folder / "unstable", ignore_errors=True)
    os.environ["TAKT_TEST_SLOWNESS"] = "%.1f" % slowness()  # takt_system.py and long_enough.hpp read it
    cpus = len(os.sched_getaffinity(0))
    with Load() as load:
        status, failed, summary = ctest(folder, ["--parallel", str(TESTS_AT_ONCE), *arguments], results)
    if failed:
        unstable, second_summary = second_look(folder, failed)
        if unstable:
            keep_output(results, {test.name for test in unstable}, folder / "unstable")
            print("\nUnstable: these tests failed beside other tests and passed alone; build/tests/unstable has the output of the failures")
            print("".join("%12s  %s\n" % (test.number, test.name) for test in unstable), end="")
        if len(unstable) == len(failed):
            status, summary = 0, second_summary
    if results.exists():
        print(slowest(results))
    print("highest load average %.1f on %d CPUs" % (load.highest, cpus), flush=True)
    (folder / "summary").write_text(summary)
    return status


if __name__ == "__main__":
    mistake = mistake_in(sys.argv[2:])
    if mistake:
        print("tools/test: " + mistake, file=sys.stderr)
        sys.exit(2)
    sys.exit(0 if sys.argv[1] == "--check" else main(sys.argv[1], sys.argv[2:]))
