#!/usr/bin/env python3
"""Checks the projects that `takt new` writes: each kind of component, and a cell. A project must build outside the repository, pass its
tests, and run.

Usage: new_test.py PREFIX      PREFIX: where Takt is installed"""
import itertools
import json
import os
import re
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True  # leave no bytecode of takt_system in the source tree
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "system"))
import takt_system

prefix = sys.argv[1]
environment = {name: value for name, value in os.environ.items() if not name.startswith("TAKT_")}
environment.update({"PATH": os.path.join(prefix, "bin") + ":" + environment["PATH"], "CMAKE_PREFIX_PATH": prefix,
                    "TAKT_INTERFACE": "127.0.0.1", "TAKT_DOMAIN": str(takt_system.free_domain())})
KINDS = list(itertools.product(("thread", "process"), ("periodic", "sporadic"), ("c++", "c")))
if not takt_system.FULL:  # half of the kinds; these still contain each combination of two choices
    KINDS = [kind for kind in KINDS if (kind[0] == "thread") ^ (kind[1] == "periodic") ^ (kind[2] == "c++")]


def run(*command, cwd, status=0):
    done = subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True, timeout=300)
    if done.returncode != status:
        sys.exit(f"{' '.join(command)}: exit status {done.returncode}, not {status}\n{done.stdout}{done.stderr}")
    return done


def name_of(kind):
    return "_".join(kind).replace("c++", "cpp")


def test_a_new_component_of_every_kind_builds_and_runs(folder):
    for kind in KINDS:
        type_, operation, language = kind
        run("takt", "new", name_of(kind), "--type", type_, "--operation", operation, "--language", language, cwd=folder)
    # A folder from takt new works alone, and as a part of a project that has found Takt.
    with open(os.path.join(folder, "CMakeLists.txt"), "w", encoding="utf-8") as file:
        file.write("cmake_minimum_required(VERSION 3.25)\nproject(all LANGUAGES C CXX)\nfind_package(takt REQUIRED)\nenable_testing()\n")
        file.writelines(f"add_subdirectory({name_of(kind)})\n" for kind in KINDS[1:])
    alone = os.path.join(folder, name_of(KINDS[0]))
    for project, count in ((folder, len(KINDS) - 1), (alone, 1)):
        configured = run("cmake", "-S", ".", "-B", "build", "-G", "Ninja", "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON", cwd=project).stdout
        assert configured.count("takt: the build type is RelWithDebInfo, because none was given") == 1, configured
        run("cmake", "--build", "build", cwd=project)
        with open(os.path.join(project, "build", "CMakeCache.txt"), encoding="utf-8") as file:
            assert "FASTDDSGEN" not in file.read().upper(), "takt_add_idl must not need fastddsgen, which needs Java"
        with open(os.path.join(project, "build", "compile_commands.json"), encoding="utf-8") as file:
            commands = [entry["command"] for entry in json.load(file)]
        assert all(" -O2 -g " in command for command in commands), commands
        passed = run("ctest", "--test-dir", "build", cwd=project).stdout
        assert f"0 tests failed out of {3 * count}" in passed, passed
    environment["TAKT_COMPONENT_PATH"] = ":".join(os.path.join(project, "build", "components") for project in (folder, alone))
    for kind in KINDS:
        name = name_of(kind)
        place = os.path.join(folder, name)
        file = name + (".so" if kind[0] == "thread" else ".exe")
        described = json.loads(run("takt", "describe", file, "--json", cwd=place).stdout)
        assert {p["name"] for p in described["ports"]} == {"in", "out"} and [p["name"] for p in described["properties"]] == ["gain"], described
        run("takt", "check", name + ".xml", cwd=place)
        with open(os.path.join(place, name + ".xml"), encoding="utf-8") as file:
            assert re.search(r"<(period|deadline)>1ms</", file.read()), "times have units"
        report = json.loads(run("takt", "run", name + ".xml", "--for", "3", "--json", cwd=place).stdout)
        module, executor = report["devices"][0]["modules"][0], report["devices"][0]["executors"][0]
        assert (module["type"], module["operation"], module["state"], module["errors"]) == (kind[0], kind[1], "DESTRUCT", 0), module
        if kind[1] == "periodic":
            assert module["cycles"] > 0 and module["cycles"] + executor["missed"] > 500, (module, executor)
        refused = run("takt", "new", name, cwd=folder, status=1)
        assert "already exists" in refused.stderr, refused.stderr


def test_a_new_component_keeps_the_given_build_type(folder):
    run("takt", "new", "pump", cwd=folder)
    configured = run("cmake", "-S", "pump", "-B", "build", "-DCMAKE_BUILD_TYPE=Debug", cwd=folder).stdout
    with open(os.path.join(folder, "build", "CMakeCache.txt"), encoding="utf-8") as file:
        assert "CMAKE_BUILD_TYPE:STRING=Debug" in file.read().split()
    assert "RelWithDebInfo" not in configured, configured


def test_a_new_cell_runs(folder):
    run("takt", "new", "cell", "plant", cwd=folder)
    done = run("takt", "run", "plant/plant.xml", "--for", "2", "--json", cwd=folder)
    report = json.loads(done.stdout)
    assert [d["name"] for d in report["devices"]] == ["sensor", "controller"] and report["cell"] == "plant", report
    missed = {m["name"]: d["executors"][0]["missed"] for d in report["devices"] for m in d["modules"]}
    modules = {m["name"]: m for d in report["devices"] for m in d["modules"]}
    assert set(modules) == {"level", "filter", "limit"}, modules
    assert all(m["cycles"] > 0 and m["cycles"] + missed[name] > 100 for name, m in modules.items()), (modules, missed)
    # If the machine stalls, the level may arrive later than the allowed 50 ms.
    late = len(re.findall(r"controller\.filter: \w+ -> RECOVER \(.*the newest value of input 'in' is older than", done.stderr))
    assert {name: m["errors"] for name, m in modules.items()} == {"level": 0, "filter": late, "limit": 0}, (modules, done.stderr)


def test_takt_new_rejects_invalid_names_and_options(folder):
    for name, words in (("Pump", "is not a valid component name"), ("2nd", "is not a valid component name"), ("test", "is reserved for a build target")):
        assert words in run("takt", "new", name, cwd=folder, status=1).stderr
    run("takt", "new", "pump", "--type", "fibre", cwd=folder, status=2)
    assert os.listdir(folder) == [], "takt new must not write anything after an error"


for test in (test_takt_new_rejects_invalid_names_and_options, test_a_new_component_keeps_the_given_build_type, test_a_new_cell_runs,
             test_a_new_component_of_every_kind_builds_and_runs):
    with tempfile.TemporaryDirectory(prefix="takt-new-") as scratch:
        test(scratch)
print(f"{len(KINDS)} kinds of components and a cell build and run")
