#!/usr/bin/env python3
"""Checks that the compiler reports typical mistakes of component authors.

Usage: misuse_test.py BUILD_DIRECTORY. Compiles the sources of this test with the compile command of a component in the build."""
import json
import os
import shlex
import subprocess
import sys
import tempfile

COMPONENT = """#include <takt/component.hpp>
#include <basic.hpp>
class Feeder : public takt::Component {
  takt::InPort<basic::Number> in{*this, "in"};
  takt::OutPort<basic::Number> out{*this, "out"};
  takt::Property<double> gain{*this, "gain", 1};
  takt::Result<void> start() override {
    %s
    return {};
  }
  void run(const takt::Cycle&) override { %s }
};
TAKT_COMPONENT(Feeder)
"""
# The bodies of start() and run(), and the expected message. None: the source compiles.
CASES = [
    ('if (gain < 0) return takt::fail("no air", "open the valve");', "if (in.read()) out.write(in.value());", None),
    ('if (gain < 0) takt::fail("no air", "open the valve");', "", "return it; otherwise the failure is lost"),
    ('gain.narrow(0, 1, "as the feeder is");', "", "nodiscard"),
    ("", "basic::Count count; out.write(count);", "basic::Count"),
    ("", "gain = 2;", "gain"),
    ("", "in.value().value(2);", "const"),
]

build = sys.argv[1]
commands = json.load(open(os.path.join(build, "compile_commands.json")))
entry = next(c for c in commands if c["file"].endswith("tests/unit/testing/subject.cpp"))
arguments = shlex.split(entry["command"])
first = next(i for i, a in enumerate(arguments) if os.path.basename(a).startswith(("c++", "g++", "clang++")))
keep = [a for a in arguments[first + 1:] if a.startswith(("-I", "-D", "-std", "-f", "-W"))]
keep += [a for i, flag in enumerate(arguments) if flag == "-isystem" for a in ("-isystem", arguments[i + 1])]

failures = []
for start, run, said in CASES:
    with tempfile.NamedTemporaryFile("w", suffix=".cpp") as source:
        source.write(COMPONENT % (start, run))
        source.flush()
        done = subprocess.run([arguments[first], *keep, "-Werror", "-fsyntax-only", source.name], capture_output=True, text=True)
    if said is None and done.returncode != 0:
        failures.append("%s %s: this source should compile, but does not: %s" % (start, run, done.stderr))
    if said is not None and (done.returncode == 0 or said not in done.stderr):
        failures.append("%s %s: the message should contain '%s', but is: %s" % (start, run, said, done.stderr or "nothing"))
print("\n".join(failures) or "%d components compile or are rejected as expected" % len(CASES))
sys.exit(1 if failures else 0)
