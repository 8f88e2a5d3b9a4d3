#!/usr/bin/env python3
"""Measures by how much the open pages of takt web change the jitter of an executor's rows.

    tests/bench/viewers.py [--modules 100] [--browsers 3] [--turns 3] [--seconds 20] [--build build/release]

The modules run every millisecond. Headless browsers show the views of the page in turn, with all modules. Each turn measures one run
without and one run with browsers. The browsers run on the same machine as the executor, unlike the browser of an operator.
The script prints the results and never fails."""
import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import time

here = os.path.dirname(os.path.abspath(__file__))
sys.path += [os.path.join(here, "..", "system"), os.path.join(here, "..", "system", "web")]
from browser import Browser  # noqa: E402

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--modules", type=int, default=100)
parser.add_argument("--browsers", type=int, default=3)
parser.add_argument("--turns", type=int, default=3)
parser.add_argument("--seconds", type=float, default=20, help="duration of each run of a turn")
parser.add_argument("--build", default=os.path.join(here, "..", "..", "build", "release"))
options = parser.parse_args()
build = os.path.abspath(options.build)
environment = dict(os.environ, TAKT_DOMAIN="89", TAKT_INTERFACE="127.0.0.1",
                   TAKT_COMPONENT_PATH=os.path.join(build, "tests", "components"))
takt = os.path.join(build, "bin", "takt")
MODULE = """    <module><name>m{0:03}</name><filename>fine.so</filename><moduletype>thread</moduletype>
      <operationtype>periodic</operationtype><period>1000000</period><priority>1</priority></module>
"""


def ticks():
    with open("/proc/stat") as file:
        values = [int(v) for v in file.readline().split()[1:]]
    return values[7], sum(values[:8])


def turn(browsers):
    """Returns the report of a run, and the share of CPU time that the hypervisor took during the run."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "cell.xml")
        with open(path, "w") as file:
            file.write('<cell name="viewed">\n  <device name="d">\n%s  </device>\n</cell>\n'
                       % "".join(MODULE.format(i) for i in range(options.modules)))
        opened = []
        web = None
        try:
            if browsers:
                web = subprocess.Popen([takt, "web", "--port", "0"], env=environment, stdout=subprocess.PIPE, text=True)
                address = re.search(r"http://\S+/", web.stdout.readline()).group()
                for i in range(browsers):  # opens the browsers before the run, so that the run does not include their start
                    place = os.path.join(folder, str(i))
                    os.mkdir(place)
                    opened.append(Browser(place))
                    opened[-1].open(address)
            stolen, all_ticks = ticks()
            run = subprocess.Popen([takt, "run", path, "--for", str(options.seconds), "--json", "--quiet"], env=environment,
                                   stdout=subprocess.PIPE, text=True, cwd=folder)
            views = ("#/cell", "#/modules", "#/table")
            at = 0
            while run.poll() is None:
                if opened:
                    opened[at % len(opened)].go(views[at // len(opened) % len(views)])
                    at += 1
                time.sleep(2)
            now_stolen, now_all = ticks()
            return json.loads(run.stdout.read()), (now_stolen - stolen) / max(1, now_all - all_ticks)
        finally:
            for browser in opened:
                browser.close()
            if web:
                web.terminate()
                web.wait()


print("%d modules every millisecond, %d turns of %g s each" % (options.modules, options.turns, options.seconds))
print("%-12s %9s %8s %8s %8s %8s %7s" % ("", "rows", "missed", "p50 us", "p99 us", "max us", "steal"))
for _ in range(options.turns):
    for browsers in (0, options.browsers):
        report, steal = turn(browsers)
        executor = report["devices"][0]["executors"][0]
        jitter = executor["jitter_us"]
        print("%-12s %9d %8d %8.2f %8.2f %8.1f %6.1f%%" % ("%d browsers" % browsers, executor["cycles"], executor["missed"], jitter["p50"],
                                                          jitter["p99"], jitter["max"], 100 * steal), flush=True)
