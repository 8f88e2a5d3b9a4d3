"""The demo cell with additional modules for this test. Each device gets a module that fails on command and runs in its own host, and
readers that check the samples of such modules."""

import os
import re
import xml.etree.ElementTree as ElementTree

import takt_system

DEMO = os.path.join(takt_system.SOURCE, "deploy", "palletizing.xml")
DEVICES = ("robot", "line", "station")
EXECUTORS = {"robot": "motion", "line": "plc", "station": "main"}
PERIOD_NS = 4_000_000
DEADLINE_NS = 100_000_000
BACKOFF_NS = 50_000_000
ATTEMPTS = 3  # the default value, which the modules of the demo cell use
# If an input of the demo cell is older than this time, the cell stops and needs a manual reset, which this test does not cover. So the time
# is longer than any fault of this test.
STOP_TIMEOUT_S = 10

_SAFE = """
      <safe> <port name="out"> <field name="number">0</field> <field name="same">[-1, -1, -1, -1, -1, -1]</field> </port> </safe>"""


def _module(name, file, executor, more="", priority=100):
    kind = "process" if file.endswith(".exe") else "thread"
    return f"""
    <module>
      <name>{name}</name> <filename>{file}</filename>
      <moduletype>{kind}</moduletype> <operationtype>periodic</operationtype>
      <period>{PERIOD_NS}</period> <priority>{priority}</priority> <executor>{executor}</executor>
      <recovery attempts="{ATTEMPTS}" backoff="{BACKOFF_NS}"/>{more}
    </module>"""


def _watches(who):
    return f"""
      <property> <value name="who">{who}</value> <value name="oldest">{DEADLINE_NS}</value> </property>"""


def _added(device):
    main = EXECUTORS[device]
    return "".join((
        # This executor has the lowest priority, so that an endless loop of its module disturbs no other executor.
        '\n    <executor name="risky" priority="10" host="own"/>',
        _module("source", "failing_source.so", "risky", _SAFE, 1),
        _module("bystander", "fine.so", "risky", "", 2),
        _module("relay", "port_relay.exe", main, _SAFE),
        _module("near", "safe_reader.so", main, _watches("near")),
        _module("far", "safe_reader.so", main, _watches("far")),
        _module("relayed", "safe_reader_program.exe", main, _watches("relayed"))))


def next_to(device):
    """Returns the device that reads the samples of `device`."""
    return DEVICES[(DEVICES.index(device) + 1) % len(DEVICES)]


def text():
    with open(DEMO, encoding="utf-8") as file:
        cell = file.read()
    cell, timeouts = re.subn(r'(timeout">)2<', r"\g<1>%g<" % STOP_TIMEOUT_S, cell)
    assert timeouts == 3, timeouts
    head, *rest = cell.split("</device>")
    parts = [head]
    for device, after in zip(DEVICES, rest):
        parts += [_added(device), "\n  </device>", after]
    cell = "".join(parts)
    links = ""
    for device in DEVICES:
        links += f"""
  <connection from="{device}.source.out" to="{device}.near.in" deadline="{DEADLINE_NS}"/>
  <connection from="{device}.source.out" to="{device}.relay.in" kind="queue" depth="64"/>
  <connection from="{device}.source.out" to="{next_to(device)}.far.in" deadline="{DEADLINE_NS}"/>
  <connection from="{device}.relay.out" to="{next_to(device)}.relayed.in" deadline="{DEADLINE_NS}"/>"""
    return cell.replace("</cell>", links + "\n</cell>")


def _elements():
    for device in ElementTree.fromstring(text()).iter("device"):
        for module in device.iter("module"):
            yield device.get("name"), module.findtext("name").strip(), module


def modules():
    """Returns the type ("thread" or "process") of each module, by device and module name."""
    found = {device: {} for device in DEVICES}
    for device, name, module in _elements():
        found[device][name] = module.findtext("moduletype").strip()
    return found


def programs():
    """Returns the program file of each process module, by device and module name."""
    found = {device: {} for device in DEVICES}
    for device, name, module in _elements():
        if module.findtext("moduletype").strip() == "process":
            found[device][name] = os.path.basename(module.findtext("filename").strip())
    return found


def period(device, module):
    """Returns the period of a module, in seconds."""
    text = next(e.findtext("period") for d, name, e in _elements() if (d, name) == (device, module))
    return float(text.removesuffix("ms")) / 1e3 if text.endswith("ms") else int(text) / 1e9
