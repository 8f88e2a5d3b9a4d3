#!/usr/bin/env python3
"""A wrong include does not compile: each room sees the rooms above it and no library of another room.

Usage: rooms_test.py BUILD_DIRECTORY. Takes the compile command of one source of each room, as the build has it, and gives it
another source with one include."""
import json
import os
import shlex
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

build = sys.argv[1]
commands = json.load(open(os.path.join(build, "compile_commands.json")))

# room: (includes that must compile, includes that must not)
CASES = {
    "core": (["takt/core/result.hpp", "mutex", "thread"],
             ["takt/model/cell.hpp", "takt/os/fd.hpp", "unistd.h", "sys/mman.h", "tinyxml2.h"]),
    "model": (["takt/core/result.hpp"], ["takt/schedule/table.hpp", "tinyxml2.h", "fcntl.h"]),
    "schedule": (["takt/model/cell.hpp"], ["takt/executor/executor.hpp", "takt/os/clock.hpp", "pthread.h", "sched.h"]),
    "lifecycle": (["takt/core/time.hpp"], ["takt/model/cell.hpp", "takt/host/host.hpp", "signal.h"]),
    "descriptor": (["takt/model/cell.hpp", "tinyxml2.h"], ["takt/os/fd.hpp", "takt/host/inspect.hpp", "unistd.h"]),
    "os": (["sys/mman.h", "linux/futex.h", "takt/model/cell.hpp"], ["takt/channel/seat.hpp", "takt/executor/executor.hpp", "tinyxml2.h"]),
    "security": (["takt/model/cell.hpp", "takt/os/files.hpp", "openssl/x509.h"],
                 ["takt/dds/participant.hpp", "takt/descriptor/descriptor.hpp", "sys/stat.h", "fastdds/dds/domain/DomainParticipant.hpp"]),
    "channel": (["takt/os/shared_memory.hpp"], ["takt/executor/executor.hpp", "takt/host/host.hpp", "sys/mman.h"]),
    "check": (["takt/channel/violations.hpp", "sys/mman.h"], ["takt/component/component.hpp", "takt/executor/executor.hpp", "takt/host/host.hpp"]),
    "component": (["takt/core/result.hpp", "takt/channel/link.hpp"], ["takt/executor/body.hpp", "takt/host/host.hpp", "unistd.h"]),
    "executor": (["takt/schedule/plan.hpp", "takt/channel/seat.hpp"], ["takt/host/host.hpp", "takt/node/supervisor.hpp", "sys/syscall.h"]),
    "simulation": (["takt/executor/executor.hpp", "takt/lifecycle/machine.hpp", "takt/os/fiber.hpp"],
                   ["takt/host/host.hpp", "takt/node/supervisor.hpp", "takt/descriptor/descriptor.hpp", "ucontext.h", "takt/wire/takt.h"]),
    "host": (["takt/executor/executor.hpp"], ["takt/descriptor/descriptor.hpp", "takt/node/supervisor.hpp", "dlfcn.h", "tinyxml2.h", "takt/dds/gateway.hpp", "takt/wire/takt.h"]),
    "flight": (["takt/channel/flight_record.hpp", "takt/schedule/plan.hpp", "takt/model/json.hpp"],
               ["takt/host/host.hpp", "takt/node/supervisor.hpp", "takt/dds/participant.hpp", "unistd.h", "tinyxml2.h"]),
    "testing": (["takt/host/thread_module.hpp", "takt/executor/executor.hpp", "takt/lifecycle/machine.hpp", "takt/testing.hpp"],
                ["takt/descriptor/descriptor.hpp", "takt/node/supervisor.hpp", "dlfcn.h", "ucontext.h"]),
    "dds": (["takt/channel/link.hpp", "takt/security/identity.hpp", "takt/wire/takt.h", "fastdds/dds/domain/DomainParticipant.hpp"],
            ["takt/host/inspect.hpp", "takt/node/supervisor.hpp", "takt/component/component.hpp", "sys/socket.h", "tinyxml2.h"]),
    "client": (["takt/dds/topics.hpp", "takt/wire/takt.h", "takt/model/ports.hpp"],
               ["openssl/x509.h", "takt/node/agent.hpp", "takt/host/host.hpp", "fastdds/dds/domain/DomainParticipant.hpp", "sys/socket.h"]),
    "node": (["takt/host/inspect.hpp", "takt/descriptor/descriptor.hpp", "takt/dds/gateway.hpp"], ["sys/wait.h", "poll.h", "tinyxml2.h", "takt/dds/inside.hpp", "fastdds/dds/log/Log.hpp",
                                                                              "fastrtps/utils/IPLocator.h", "takt/wire/taktPubSubTypes.h"]),
}

failures = []


def compiles(room, includes, *how):
    entry = next(c for c in commands if f"CMakeFiles/takt_{room}.dir/" in c["command"])
    arguments = shlex.split(entry["command"])
    if "ccache" in os.path.basename(arguments[0]):
        arguments = arguments[1:]
    keep = [a for a in arguments[1:] if a.startswith(("-I", "-D", "-std", "-f", "-W"))]
    keep += [a for i, first in enumerate(arguments) if first == "-isystem" for a in ("-isystem", arguments[i + 1])]
    with tempfile.NamedTemporaryFile("w", suffix=".cpp") as source:
        source.writelines(f"#include <{include}>\n" for include in includes)
        source.flush()
        return subprocess.run([arguments[0], *keep, "-Wfatal-errors", *how, source.name], stdout=subprocess.DEVNULL,
                              stderr=subprocess.PIPE, text=True)


def check_right(room):
    done = compiles(room, CASES[room][0], "-fsyntax-only")
    if done.returncode != 0:
        failures.append(f"{room}: {CASES[room][0]} should compile and do not: {done.stderr}")


# The preprocessor alone refuses what is wrong: it finds no such header, or the guard in its place.
def check_wrong(case):
    room, include = case
    if compiles(room, [include], "-E").returncode == 0:
        failures.append(f"{room}: <{include}> should not compile and does")


with ThreadPoolExecutor(os.cpu_count()) as pool:
    list(pool.map(check_right, CASES))
    list(pool.map(check_wrong, [(room, include) for room, (_, wrong) in CASES.items() for include in wrong]))

# A path around the include roots would not be stopped by them.
source = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
for folder, _, names in os.walk(os.path.join(source, "framework")):
    for name in names:
        for number, line in enumerate(open(os.path.join(folder, name), encoding="utf-8"), 1):
            if line.startswith("#include") and ".." in line:
                failures.append(f"{folder}/{name}:{number}: an include goes by a relative path")

rooms = {d.name for d in os.scandir(os.path.join(source, "framework")) if d.is_dir()}
if rooms != set(CASES):
    failures.append(f"rooms without a case here: {sorted(rooms ^ set(CASES))}")

print("\n".join(failures) or f"{sum(len(r) + len(w) for r, w in CASES.values())} includes are as they should be")
sys.exit(1 if failures else 0)
