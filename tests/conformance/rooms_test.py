#!/usr/bin/env python3
"""Checks that a wrong include fails the build with an error that names the file, both rooms and the rule, and so does a call of write().

Usage: rooms_test.py SOURCE_DIRECTORY ROOMS_FILE. Adds allowed and wrong includes to a copy of each room, and checks the copy as the
build does.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile

source, rooms_file = sys.argv[1:]
CHECK = [sys.executable, "-B", os.path.join(source, "cmake", "check_includes.py")]

# For each room: its allowed includes, and its wrong includes.
CASES = {
    "core": (["takt/core/result.hpp", "mutex", "thread"],
             ["takt/model/cell.hpp", "takt/os/fd.hpp", "unistd.h", "sys/mman.h", "tinyxml2.h"]),
    "model": (["takt/core/result.hpp"], ["takt/schedule/table.hpp", "tinyxml2.h", "fcntl.h"]),
    "schedule": (["takt/model/cell.hpp"], ["takt/executor/executor.hpp", "takt/os/clock.hpp", "pthread.h", "sched.h"]),
    "lifecycle": (["takt/core/time.hpp"], ["takt/model/cell.hpp", "takt/host/host.hpp", "signal.h"]),
    "descriptor": (["takt/model/cell.hpp", "tinyxml2.h"], ["takt/os/fd.hpp", "takt/host/inspect.hpp", "unistd.h"]),
    "os": (["sys/mman.h", "linux/futex.h", "takt/model/cell.hpp"], ["takt/channel/release_slot.hpp", "takt/executor/executor.hpp", "tinyxml2.h"]),
    "security": (["takt/model/cell.hpp", "takt/os/files.hpp", "openssl/x509.h"],
                 ["takt/dds/participant.hpp", "takt/descriptor/descriptor.hpp", "sys/stat.h", "fastdds/dds/domain/DomainParticipant.hpp"]),
    "channel": (["takt/os/shared_memory.hpp"], ["takt/executor/executor.hpp", "takt/host/host.hpp", "sys/mman.h"]),
    "check": (["takt/channel/violations.hpp", "sys/mman.h"], ["takt/component.hpp", "takt/executor/executor.hpp", "takt/host/host.hpp"]),
    "component": (["takt/core/result.hpp", "takt/channel/link.hpp"], ["takt/executor/body.hpp", "takt/host/host.hpp", "unistd.h"]),
    "executor": (["takt/schedule/plan.hpp", "takt/channel/release_slot.hpp"], ["takt/host/host.hpp", "takt/node/node.hpp", "sys/syscall.h"]),
    "simulation": (["takt/executor/executor.hpp", "takt/supervision/supervisor.hpp", "takt/os/fiber.hpp"],
                   ["takt/dds/gateway.hpp", "takt/node/node.hpp", "takt/descriptor/descriptor.hpp", "ucontext.h"]),
    "host": (["takt/executor/executor.hpp"],
             ["takt/descriptor/descriptor.hpp", "takt/node/node.hpp", "dlfcn.h", "tinyxml2.h", "takt/dds/gateway.hpp", "takt/wire/takt.h"]),
    "flight": (["takt/channel/flight_record.hpp", "takt/schedule/plan.hpp", "takt/model/json.hpp"],
               ["takt/host/host.hpp", "takt/node/node.hpp", "takt/dds/participant.hpp", "unistd.h", "tinyxml2.h"]),
    "testing": (["takt/host/thread_module.hpp", "takt/executor/executor.hpp", "takt/lifecycle/machine.hpp", "takt/testing.hpp"],
                ["takt/descriptor/descriptor.hpp", "takt/node/node.hpp", "dlfcn.h", "ucontext.h"]),
    "wire": (["takt/model/cell.hpp", "takt/wire/takt.h", "fastrtps/utils/fixed_size_string.hpp"],
             ["takt/dds/participant.hpp", "takt/os/clock.hpp", "fastdds/dds/domain/DomainParticipant.hpp", "takt/wire/taktPubSubTypes.h"]),
    "dds": (["takt/channel/link.hpp", "takt/security/identity.hpp", "takt/wire/takt.h", "fastdds/dds/domain/DomainParticipant.hpp"],
            ["takt/host/inspect.hpp", "takt/node/node.hpp", "takt/component/in_port.hpp", "sys/socket.h", "tinyxml2.h"]),
    "client": (["takt/dds/topics.hpp", "takt/wire/takt.h", "takt/model/ports.hpp"],
               ["openssl/x509.h", "takt/node/node.hpp", "takt/host/host.hpp", "fastdds/dds/domain/DomainParticipant.hpp", "sys/socket.h", "sqlite3.h"]),
    "recording": (["takt/client/tap.hpp", "takt/dds/gateway.hpp", "sqlite3.h"], ["takt/node/node.hpp", "takt/security/access.hpp", "unistd.h"]),
    "supervision": (["takt/host/protocol.hpp", "takt/lifecycle/machine.hpp", "takt/wire/flow_health.hpp"],
                    ["takt/os/clock.hpp", "takt/dds/gateway.hpp", "takt/node/node.hpp", "takt/descriptor/descriptor.hpp", "unistd.h"]),
    "transaction": (["takt/core/result.hpp"], ["takt/os/clock.hpp", "takt/model/cell.hpp", "takt/agent/agent.hpp", "unistd.h"]),
    "agent": (["takt/supervision/supervisor.hpp", "takt/wire/assembly.hpp"],
              ["takt/descriptor/descriptor.hpp", "takt/os/clock.hpp", "takt/dds/commands.hpp", "takt/node/node.hpp", "takt/host/inspect.hpp", "unistd.h"]),
    "node": (["takt/host/inspect.hpp", "takt/descriptor/descriptor.hpp", "takt/dds/gateway.hpp", "fastrtps/utils/fixed_size_string.hpp"],
             ["sys/wait.h", "poll.h", "tinyxml2.h", "fastdds/dds/log/Log.hpp", "fastrtps/utils/IPLocator.h", "takt/wire/taktPubSubTypes.h"]),
}

failures = []


def expect(holds, what):
    if not holds:
        failures.append(what)


with tempfile.TemporaryDirectory() as copy:
    shutil.copytree(os.path.join(source, "framework"), os.path.join(copy, "framework"))
    os.makedirs(os.path.join(copy, "tools"))
    wrong = {}
    for room, cases in CASES.items():
        lines = [f"#include <{include}>\n" for include in cases[0] + cases[1]] + [f'#include "../../{"model" if room == "core" else "core"}/src/json.cpp"\n']
        with open(os.path.join(copy, "framework", room, "src", "added.cpp"), "w", encoding="utf-8") as file:
            file.writelines(lines)
        first = len(cases[0]) + 1
        for number, include in enumerate(cases[1] + [".."], first):
            wrong[f"framework/{room}/src/added.cpp:{number}"] = (room, include)
    with open(os.path.join(copy, "framework", "dds", "src", "added.cpp"), "a", encoding="utf-8") as file:
        file.write("const bool taken = writer_->write(&sample);\n")
    wrong[f"framework/dds/src/added.cpp:{len(sum(CASES['dds'], [])) + 2}"] = ("dds", "..")
    with open(os.path.join(copy, "tools", "added.cpp"), "w", encoding="utf-8") as file:
        file.write("#include <takt/node/node.hpp>\n#include <unistd.h>\n#include <tinyxml2.h>\n")
    wrong["tools/added.cpp:2"] = ("", "unistd.h")
    wrong["tools/added.cpp:3"] = ("", "tinyxml2.h")

    done = subprocess.run([*CHECK, copy, rooms_file], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    expect(done.returncode == 1, f"exit status {done.returncode} for wrong includes, not 1")
    said = dict(line.split(": error: ", 1) for line in done.stderr.splitlines())
    for place in sorted(set(wrong) ^ set(said)):
        failures.append(f"{place}: " + (f"an allowed include is rejected: {said[place]}" if place in said else f"the wrong include {wrong[place]} is not rejected"))
    for place, (room, include) in wrong.items():
        other = re.match("takt/([a-z]+)/", include)
        if place in said and other and include != "takt/wire/taktPubSubTypes.h":
            expect(f"room {room} " in said[place] and f"of room {other[1]};" in said[place], f"{place}: the message does not name both rooms: {said[place]}")
        elif place in said and include != "..":
            expect(f"<{include}>" in said[place], f"{place}: the message does not name the header: {said[place]}")

done = subprocess.run([*CHECK, source, rooms_file], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
expect(done.returncode == 0, f"the sources of the repository are rejected: {done.stderr}")

rooms = {d.name for d in os.scandir(os.path.join(source, "framework")) if d.is_dir()}
expect(rooms == set(CASES), f"rooms without a case in this test, or cases without a room: {sorted(rooms ^ set(CASES))}")

print("\n".join(failures) or f"{len(wrong)} wrong includes are rejected")
sys.exit(1 if failures else 0)
