#!/usr/bin/env python3
"""Checks that fastddsgen and Cyclone's idlc accept the port types that takt_idl.py accepts, that the generated code compiles, and that
takt_idl.py rejects other types with the expected messages.

Usage: idl_test.py SOURCE_DIRECTORY BUILD_DIRECTORY CXX CC FASTDDSGEN IDLC. Reads idl/, and idl/good and idl/bad in the folder of
this file. Each NAME.idl of idl/bad has a NAME.expected with the expected lines on standard error."""
import glob
import os
import subprocess
import sys
import tempfile

source, build, cxx, cc, fastddsgen, idlc = sys.argv[1:]
here = os.path.join(source, "tests", "conformance", "idl")
script = os.path.join(source, "cmake", "takt_idl.py")
failures = []
checked = 0


def run(*command, cwd=None):
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, timeout=300)


def expect(right, what, result=None):
    global checked
    checked += 1
    if not right:
        failures.append(what + (":\n" + (result.stdout + result.stderr).strip() if result else ""))


def takt_idl(folder, *arguments):
    return run(sys.executable, script, *arguments, cwd=folder)


def accepted_by_others(folder, names, scratch):
    """Checks that fastddsgen and idlc accept the files as their authors wrote them."""
    for tool in ("dds", "dds_tmp", "idlc"):
        os.makedirs(os.path.join(scratch, tool), exist_ok=True)
    # fastddsgen 4 fails to write the description of some types. Takt does not use descriptions (cmake/fastddsgen4.sh).
    only_types = [] if " version 2." in run(fastddsgen, "-version").stdout else ["-no-typeobjectsupport"]
    result = run(fastddsgen, "-replace", "-cs", *only_types, "-t", os.path.join(scratch, "dds_tmp"), "-d", os.path.join(scratch, "dds"),
                 *names, cwd=folder)
    expect(result.returncode == 0 and "error" not in result.stdout + result.stderr, f"fastddsgen refuses one of {names}", result)
    for name in names:
        result = run(idlc, "-l", "c", "-o", os.path.join(scratch, "idlc"), name, cwd=folder)
        expect(result.returncode == 0, f"idlc refuses {name}", result)


def idl_files(folder):
    return sorted(os.path.basename(path) for path in glob.glob(os.path.join(folder, "*.idl")))


def test_the_idl_files_of_takt_are_accepted_by_every_compiler(scratch):
    folder = os.path.join(source, "idl")
    names = idl_files(folder)
    expect({"takt.idl", "motion.idl", "line.idl"} <= set(names), f"idl/ has only {names}")
    accepted_by_others(folder, names, scratch)
    ports = [name for name in names if name != "takt.idl"]
    result = takt_idl(folder, "--check", *ports)
    expect(result.returncode == 0 and not result.stderr, "takt_idl.py refuses a type of ours", result)
    # `ports` omits takt.idl, because its types have keys, so ports cannot use them.
    ros2 = os.path.join(folder, "ros2")
    accepted_by_others(ros2, idl_files(ros2), scratch)
    result = takt_idl(ros2, "--check", *idl_files(ros2))
    expect(result.returncode == 0 and not result.stderr, "takt_idl.py refuses a message of ROS 2", result)
    result = takt_idl(folder, "--check", "takt.idl")
    expect(result.returncode == 1 and "takt::LifecycleStatus.path is a key" in result.stderr, "takt.idl has no keys", result)


def test_valid_port_types_are_accepted_by_every_compiler(scratch):
    folder = os.path.join(here, "good")
    names = idl_files(folder)
    expect(len(names) >= 6, f"{folder} has only {names}")
    out = os.path.join(scratch, "out")
    for name in names:
        result = takt_idl(folder, "--check", name)
        expect(result.returncode == 0 and not result.stdout and not result.stderr, f"takt_idl.py refuses {name}", result)
    every = names + sorted(os.path.relpath(path, folder) for path in glob.glob(os.path.join(folder, "*", "*.idl")))
    accepted_by_others(folder, names, scratch)
    # Generate all files as one library, then compile all sources of each kind together.
    result = takt_idl(folder, "--out", out, *every)
    expect(result.returncode == 0, "takt_idl.py makes nothing", result)
    stems = [os.path.splitext(os.path.basename(name))[0] for name in every]
    includes = ["-I", out] + [f"-I{os.path.join(source, 'framework', room, 'include')}" for room in ("core", "component")]
    for kind, end in (("types", "_types.cpp"), ("in_c", "_c.cpp")):
        unit = os.path.join(scratch, kind + ".cpp")
        with open(unit, "w", encoding="utf-8") as stream:
            stream.writelines(f'#include "{stem}{end}"\n' for stem in stems)
        result = run(cxx, "-std=c++20", "-fsyntax-only", "-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Wno-unused-parameter", "-Werror",
                     *includes, unit)
        expect(result.returncode == 0, f"{kind} of {stems} do not compile", result)
    unit = os.path.join(scratch, "headers.c")
    with open(unit, "w", encoding="utf-8") as stream:
        stream.writelines(f"#include <{stem}_c.h>\n" for stem in stems + stems)
        stream.write("long long smallest(void) { return odd_names_SMALLEST; }\n")
    result = run(cc, "-std=c11", "-fsyntax-only", "-Wall", "-Wextra", "-Wpedantic", "-Werror", *includes, unit)
    expect(result.returncode == 0, f"the C headers of {stems} do not compile", result)


def test_every_accepted_construct_is_accepted_by_idlc(scratch):
    """Checks the types whose bytes the unit tests compare with those of Fast DDS, and the example of the manual."""
    folder = os.path.join(source, "tests", "unit", "types")
    names = idl_files(folder)
    expect({"everything.idl", "nested.idl", "parts.idl"} <= set(names), f"{folder} has only {names}")
    with open(os.path.join(source, "docs", "types.md"), encoding="utf-8") as page:
        example = page.read().split("```idl\n")[1].split("```")[0]
    with open(os.path.join(scratch, "motion.idl"), "w", encoding="utf-8") as file:
        file.write(example)
    for at, name in [(folder, name) for name in names] + [(scratch, "motion.idl")]:
        result = takt_idl(at, "--check", name)
        expect(result.returncode == 0 and not result.stderr, f"takt_idl.py refuses {name}", result)
        accepted_by_others(at, [name], scratch)


def test_invalid_port_types_are_rejected_with_the_expected_message(scratch):
    folder = os.path.join(here, "bad")
    # The following cases consist of several files.
    more = {"sees.idl": ["part_a.idl", "sees.idl"], "twins.idl": ["folder/twins.idl", "twins.idl"]}
    parts = {"part_a.idl", "part_b.idl", "part_base.idl"}
    cases = [name for name in idl_files(folder) if name not in parts]
    expect(len(cases) >= 15, f"{folder} has only {cases}")
    for name in cases:
        with open(os.path.join(folder, name[:-4] + ".expected"), encoding="utf-8") as stream:
            expected = stream.read()
        out = os.path.join(scratch, "refused")
        for arguments in (["--check"], ["--out", out]):
            result = takt_idl(folder, *arguments, *more.get(name, [name]))
            lines = result.stderr
            if arguments[0] == "--out":
                # With --out, takt_idl.py also reports files that are missing from the library.
                lines = "".join(line for line in lines.splitlines(True) if "not in the same library" not in line)
            expect(result.returncode == 1, f"{name} is not refused", result)
            expect(lines == expected and not result.stdout, f"{name} is refused with other words", result)
        expect(not os.path.exists(out), f"of {name} something is written")
    for name in parts | {"missing.idl"}:
        result = takt_idl(folder, "--out", out, name)
        expect((result.returncode == 1) == (name != "part_base.idl"), f"{name}: a file that is included is to be in the library", result)
    result = takt_idl(folder, "--check", "missing.idl")
    expect(result.stderr == "missing.idl: error: the file cannot be read: No such file or directory\n", "missing.idl", result)


for test in (test_the_idl_files_of_takt_are_accepted_by_every_compiler, test_valid_port_types_are_accepted_by_every_compiler,
             test_every_accepted_construct_is_accepted_by_idlc, test_invalid_port_types_are_rejected_with_the_expected_message):
    with tempfile.TemporaryDirectory() as scratch:
        test(scratch)
print("\n".join(failures) or f"{checked} expectations are met")
sys.exit(1 if failures else 0)
