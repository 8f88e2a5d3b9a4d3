#!/usr/bin/env python3
"""How long a cell of many devices takes to be deployed, seen and undeployed on this machine, and what memory it needs.

    tests/bench/devices.py [--devices 16] [--modules 10] [--build build/release]

Every device has a node of its own; of its modules every second one is connected to the device after it. Prints; never fails."""
import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--devices", type=int, default=16)
parser.add_argument("--modules", type=int, default=10, help="of each device; at least 2")
parser.add_argument("--period", type=int, default=10_000_000, help="ns, of every module")
parser.add_argument("--domain", type=int, default=88)
parser.add_argument("--seconds", type=float, default=10, help="to run")
parser.add_argument("--build", default=os.path.join(os.path.dirname(__file__), "..", "..", "build", "release"))
options = parser.parse_args()
build = os.path.abspath(options.build)
environment = dict(os.environ, TAKT_DOMAIN=str(options.domain), TAKT_INTERFACE="127.0.0.1",
                   TAKT_COMPONENT_PATH=os.path.join(build, "components"))


def module(name, component, priority):
    return f"""    <module><name>{name}</name><filename>{component}.so</filename><moduletype>thread</moduletype>
      <operationtype>periodic</operationtype><period>{options.period}</period><priority>{priority}</priority></module>\n"""


def cell():
    text = f'<cell name="many" domain="{options.domain}">\n'
    for d in range(options.devices):
        text += f'  <device name="d{d}">\n'
        for m in range(options.modules):
            text += module(f"m{m}", "arm" if m % 2 == 0 else "servo", m + 1)
        text += "  </device>\n"
    for d in range(options.devices):  # the arm of one device is what the servo of the next one measures
        for m in range(0, options.modules - 1, 2):
            text += (f'  <connection from="d{d}.m{m}.measured" to="d{(d + 1) % options.devices}.m{m + 1}.measured" kind="latest"/>\n')
    return text + "</cell>\n"


def takt(*arguments):
    began = time.monotonic()
    done = subprocess.run([os.path.join(build, "bin", "takt"), *arguments], env=environment, capture_output=True, text=True)
    if done.returncode != 0:
        print(done.stderr, file=sys.stderr)
    return time.monotonic() - began, done


def memory(pids):
    total = 0
    for pid in pids:
        try:
            with open(f"/proc/{pid}/smaps_rollup") as file:
                total += sum(int(line.split()[1]) for line in file if line.startswith("Pss:"))
        except OSError:
            pass
    return total / 1024


def processes(parents):
    found = set(parents)
    while True:
        more = set(found)
        for pid in os.listdir("/proc"):
            if pid.isdigit():
                try:
                    with open(f"/proc/{pid}/stat") as file:
                        if int(file.read().rsplit(")", 1)[1].split()[1]) in found:
                            more.add(int(pid))
                except OSError:
                    pass
        if more == found:
            return found
        found = more


def stolen():
    with open("/proc/stat") as file:
        return int(file.readline().split()[8]) / os.sysconf("SC_CLK_TCK")


with tempfile.TemporaryDirectory() as folder:
    path = os.path.join(folder, "many.xml")
    with open(path, "w") as file:
        file.write(cell())
    nodes = [subprocess.Popen([os.path.join(build, "bin", "takt-node"), "--device", f"d{d}", "--quiet", "--state-dir",
                               os.path.join(folder, f"d{d}")], env=environment) for d in range(options.devices)]
    try:
        steal = stolen()
        seconds, done = takt("deploy", path)
        print(f"{options.devices} devices of {options.modules} modules, {options.period / 1e6:g} ms, {os.cpu_count()} processors")
        print(f"deploy    {seconds:6.2f} s{'' if done.returncode == 0 else '  FAILED'}")
        time.sleep(options.seconds)
        seconds, done = takt("status", "--json")
        report = json.loads(done.stdout or '{"devices": []}')
        states = {}
        for device in report["devices"]:
            for m in device["modules"]:
                states[m["state"]] = states.get(m["state"], 0) + 1
        print(f"status    {seconds:6.2f} s  {len(report['devices'])} devices, modules {states}")
        rows = sum(e["cycles"] for d in report["devices"] for e in d["executors"])
        missed = sum(e["missed"] for d in report["devices"] for e in d["executors"])
        print(f"rows      {rows} walked, {missed} missed")
        pids = processes([n.pid for n in nodes])
        print(f"memory    {memory(pids):6.0f} MB in {len(pids)} processes (proportional set size)")
        seconds, done = takt("undeploy", "many")
        print(f"undeploy  {seconds:6.2f} s{'' if done.returncode == 0 else '  FAILED'}")
        print(f"steal     {stolen() - steal:6.2f} s")
    finally:
        for node in nodes:
            node.send_signal(signal.SIGTERM)
        for node in nodes:
            try:
                node.wait(10)
            except subprocess.TimeoutExpired:
                node.kill()
