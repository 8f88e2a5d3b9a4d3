#!/usr/bin/env python3
"""The README's component and its descriptor are built, checked and run as they stand there.

Usage: readme_test.py BUILD_DIRECTORY SOURCE_DIRECTORY COMPILER"""
import json
import os
import re
import subprocess
import sys
import tempfile

build, source, compiler = sys.argv[1:]
readme = open(os.path.join(source, "README.md"), encoding="utf-8").read()
component = re.search(r"```cpp\n(.*?)```", readme, re.S).group(1)
cell = re.search(r"```xml\n(.*?)```", readme, re.S).group(1)
takt = os.path.join(build, "bin", "takt")


def run(*command):
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}: exit status {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


code = [line for line in component.splitlines() if line.strip() and not line.startswith("#include")]
if len(code) > 10:
    sys.exit(f"the ten-line component has {len(code)} lines")
with tempfile.TemporaryDirectory() as folder:
    open(os.path.join(folder, "ramp.cpp"), "w").write(component)
    open(os.path.join(folder, "cell.xml"), "w").write(cell)
    run(compiler, "-std=c++20", "-shared", "-fPIC", "-Wall", "-Wextra", "-Werror", f"-I{build}/rooms/component",
        f"-I{build}/rooms/core", f"-I{build}/rooms/channel", os.path.join(folder, "ramp.cpp"), "-o", os.path.join(folder, "ramp.so"),
        f"-L{build}/lib", "-ltakt_component", f"-Wl,-rpath,{build}/lib")
    run(takt, "check", os.path.join(folder, "cell.xml"))
    described = json.loads(run(takt, "describe", os.path.join(folder, "ramp.so"), "--json"))
    if [p["name"] for p in described["properties"]] != ["slope"]:
        sys.exit(f"describe says {described}")
    report = json.loads(run(takt, "run", os.path.join(folder, "cell.xml"), "--for", "0.5", "--json", "--quiet"))
    module = report["devices"][0]["modules"][0]
    if module["state"] != "DESTRUCT" or module["cycles"] == 0:
        sys.exit(f"it did not run: {module}")
print("the README's component ran", module["cycles"], "times")
