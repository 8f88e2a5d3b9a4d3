#!/usr/bin/env python3
"""Measures how a storm of events to a sporadic module changes the jitter of the periodic rows of its executor.

    tests/bench/storm.py [--rate 20000] [--turns 5] [--seconds 4] [--program] [--build build/release]

A periodic module (500 us) and a sporadic module with immediate dispatch share an executor. A module of another executor sends the events.
Each turn consists of three runs: without events, with one event every millisecond, and with the storm. The script prints the results
and never fails."""
import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--rate", type=int, default=20_000, help="events a second, sent as one burst every millisecond")
parser.add_argument("--turns", type=int, default=5)
parser.add_argument("--seconds", type=float, default=4, help="duration of each run of a turn")
parser.add_argument("--program", action="store_true", help="the sporadic module is a process module")
parser.add_argument("--build", default=os.path.join(os.path.dirname(__file__), "..", "..", "build", "release"))
options = parser.parse_args()
build = os.path.abspath(options.build)
environment = dict(os.environ, TAKT_DOMAIN="89", TAKT_INTERFACE="127.0.0.1",
                   TAKT_COMPONENT_PATH=os.path.join(build, "tests", "components"))
sink = ("port_events_program.exe", "process") if options.program else ("port_events.so", "thread")


def cell(burst):
    return f"""<cell name="storm">
  <device name="d">
    <executor name="main" priority="80"/>
    <executor name="storm" priority="70"/>
    <module><name>rows</name><filename>fine.so</filename><moduletype>thread</moduletype>
      <operationtype>periodic</operationtype><period>500000</period><priority>1</priority><executor>main</executor></module>
    <module><name>events</name><filename>{sink[0]}</filename><moduletype>{sink[1]}</moduletype>
      <operationtype>sporadic</operationtype><deadline>10000000</deadline><priority>1</priority><executor>main</executor>
      <dispatch>immediate</dispatch><property><value name="file">seen</value></property></module>
    <module><name>source</name><filename>port_source.so</filename><moduletype>thread</moduletype>
      <operationtype>periodic</operationtype><period>1000000</period><priority>1</priority><executor>storm</executor>
      <property><value name="burst">{burst}</value></property></module>
  </device>
  <connection from="d.source.out" to="d.events.event" kind="queue" depth="64"/>
</cell>
"""


def ticks():
    with open("/proc/stat") as file:
        values = [int(v) for v in file.readline().split()[1:]]
    return values[7], sum(values[:8])


def turn(burst):
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "storm.xml")
        with open(path, "w") as file:
            file.write(cell(burst))
        done = subprocess.run([os.path.join(build, "bin", "takt"), "run", path, "--for", str(options.seconds), "--json", "--quiet"],
                              env=environment, capture_output=True, text=True, cwd=folder)
        if done.returncode != 0:
            sys.exit(done.stderr)
        events = {"age_p50_us": "-", "age_p99_us": "-"}  # a process module does not record the ages of the events
        if not options.program:
            with open(os.path.join(folder, "seen")) as file:
                events = json.load(file)
    device = json.loads(done.stdout)["devices"][0]
    executor = next(e for e in device["executors"] if e["name"] == "main")
    modules = {m["name"]: m for m in device["modules"]}
    return executor, modules, events


stolen, total = ticks()
seen = {"none": [], "one": [], "storm": []}
print(f"{'events':8} {'rows':>7} {'missed':>7} {'p50 us':>8} {'p99 us':>8} {'p99.9':>8}   {'events/s':>9} {'dropped':>8} {'p50 us':>8} {'p99 us':>8}")
for _ in range(options.turns):
    for name, burst in (("none", 0), ("one", 1), ("storm", options.rate // 1000)):
        executor, modules, arrived = turn(burst)
        jitter = modules["rows"]["jitter_us"]
        events = modules["events"]
        port = next(p for p in events["ports"] if p["direction"] == "event")
        seen[name].append((jitter["p50"], jitter["p99"]))
        print(f"{name:8} {executor['cycles']:7} {executor['missed']:7} {jitter['p50']:8.2f} {jitter['p99']:8.2f} {jitter['p999']:8.1f}   "
              f"{port['samples'] / options.seconds:9.0f} {port['dropped']:8} {arrived['age_p50_us']:8} {arrived['age_p99_us']:8}")
now = ticks()
for name, pairs in seen.items():
    print(f"{name:8} median over {options.turns} turns: rows' jitter p50 {statistics.median(p for p, _ in pairs):.2f} us, "
          f"p99 {statistics.median(p for _, p in pairs):.2f} us")
print("the last two columns: from the run that writes an event to the one that reads it; of a burst, the later wait for the former")
print(f"stolen by other machines: {100 * (now[0] - stolen) / max(1, now[1] - total):.1f} % of the time")
