#!/usr/bin/env python3
"""Checks that CMake reports typical mistakes in the calls of Takt's CMake functions, with a cure.

Usage: cmake_test.py PREFIX      PREFIX: where Takt is installed"""
import os
import re
import shutil
import subprocess
import sys
import tempfile

prefix = sys.argv[1]
TYPES = "takt_add_idl(types pick.idl)\n"
# Each case: the calls in a CMakeLists.txt whose folder contains pick.idl, and the error message that CMake must print.
CASES = [
    ("takt_add_idl(types pik.idl)", "takt_add_idl(types): there is no file pik.idl; the IDL files of {folder} are: pick.idl"),
    ("takt_add_idl(types pick.idl line.idl)",
     "takt_add_idl(types): there is no file line.idl; write ${{TAKT_IDL_DIR}}/line.idl, or add the file"),
    ("takt_add_idl(types idl/pick.idl)",
     "takt_add_idl(types): there is no file idl/pick.idl; {folder}/idl has no IDL file; the path is relative to the folder of "
     "CMakeLists.txt"),
    ("takt_add_idl(types)", "takt_add_idl(types) needs at least one IDL file"),
    (TYPES + "takt_add_component(picker picker.cpp TYPES tipes)",
     "picker: TYPES tipes is not a library of port types; write types, or call takt_add_idl(tipes ...)"),
    (TYPES + "takt_add_process(camera camera.c TYPES types motion_types)",
     "camera: TYPES motion_types is not a library of port types; write types, or call takt_add_idl(motion_types ...)"),
    ("takt_add_component(picker picker.cpp TYPES types)",
     "picker: TYPES types is not a library of port types; call takt_add_idl(types ...)"),
    ("takt_add_component(picker picker.cpp TYPES pick.idl)",
     "picker: TYPES pick.idl is not a library of port types; call takt_add_idl(picker_types pick.idl), and write TYPES "
     "picker_types"),
    (TYPES + "takt_add_component(picker picker.cpp TYPE types)",
     "takt_add_component(picker): TYPE is not a source file; did you mean TYPES?"),
    (TYPES + "takt_add_process(camera camera.c types types)",
     "takt_add_process(camera): types is not a source file; did you mean TYPES?"),
    (TYPES + "takt_add_component(picker picker.cpp pick_types)",
     "takt_add_component(picker): pick_types is not a source file; libraries of port types follow the word TYPES"),
    (TYPES + "takt_add_component(picker picker.cpp TYPES types)\ntakt_add_component_test(picker test.cpp TYPES types)",
     "takt_add_component_test(picker): TYPES is not a source file; remove it: a test has the port types of its component"),
    ("takt_add_component(picker picker.cpp)\ntakt_add_process(picker camera.c)",
     "takt_add_process(picker): {folder}/CMakeLists.txt already has a target of this name; change the name here or there"),
    (TYPES + "takt_add_component(types picker.cpp TYPES types)",
     "takt_add_component(types): {folder}/CMakeLists.txt already has a target of this name; change the name here or there"),
    (TYPES + "takt_add_component(picker.cpp TYPES types)",
     "takt_add_component(picker.cpp): the first argument must be a name, not a file; write takt_add_component(picker picker.cpp ...)"),
    ("takt_add_idl(idl/pick.idl)",
     "takt_add_idl(idl/pick.idl): the first argument must be a name, not a file; write takt_add_idl(pick_types idl/pick.idl ...)"),
    ("takt_add_component(picker.so picker.cpp)", "takt_add_component(picker.so): Takt adds .so to the name; write takt_add_component(picker ...)"),
    ("takt_add_process(camera.exe camera.c)", "takt_add_process(camera.exe): Takt adds .exe to the name; write takt_add_process(camera ...)"),
    ("takt_add_component(picker)", "takt_add_component(picker) has no source file; write takt_add_component(picker picker.cpp ...)"),
    (TYPES + "takt_add_process(camera TYPES types)", "takt_add_process(camera) has no source file; write takt_add_process(camera camera.cpp ...)"),
    ("takt_add_process(NAME camera camera.c)",
     "takt_add_process(NAME): the first argument must be a name, without a word before it; write takt_add_process(servo ...)"),
]

COMPONENT = "takt_add_component(picker picker.cpp)\n"
CASES += [
    (TYPES + COMPONENT + "takt_add_component_test(piker test.cpp)", "takt_add_component_test(piker): there is no component piker (there "
     "are: picker); correct the name, or call takt_add_component(piker) or takt_add_process(piker) first"),
    ("takt_add_component_test(picker test.cpp)", "takt_add_component_test(picker): there is no component picker; call "
     "takt_add_component(picker) or takt_add_process(picker) first"),
    (TYPES + COMPONENT + "takt_add_component_test(types test.cpp)", "takt_add_component_test(types): there is no component types"),
]
# Each case: calls that CMake must accept, and the warning that it must print; None means no warning.
TEST = "takt_add_component_test(picker picker.cpp)\n"
UNSEEN = ("takt_add_component_test(picker): ctest will not find these tests; call enable_testing() in {folder}/CMakeLists.txt, before "
          "add_subdirectory()")
ACCEPTED = [
    (COMPONENT + TEST, UNSEEN),
    ("add_subdirectory(tests)\nenable_testing()", UNSEEN),
    (COMPONENT + TEST + "enable_testing()", None),
    ("enable_testing()\nadd_subdirectory(tests)", None),
    ("set(BUILD_TESTING OFF)\n" + COMPONENT + TEST, None),
]
# A source, the call that builds it, and the compiler's first error.
PORT = "#include <takt/module.h>\n#include <pick_c.h>\nTAKT_OUT_PORT(pick_Place, out);\nTAKT_IN_PORT(pick_Place, in);\nvoid run(void) { %s }\n"
CLASS = "#include <takt/component.hpp>\nclass Picker : public takt::Component { void run(const takt::Cycle&) override {} };\nTAKT_COMPONENT(Picker)\n"
WRONG_VALUE = "the second argument must point to a value of the type of this port"
SOURCES = [
    ("write.c", "takt_add_component(%s %s TYPES types)", PORT % "double x = 1; takt_write(&out, &x);", WRONG_VALUE),
    ("read.c", "takt_add_component(%s %s TYPES types)", PORT % "double x; takt_read(&in, &x);", WRONG_VALUE),
    ("write_input.c", "takt_add_component(%s %s TYPES types)", PORT % "pick_Place x = {1}; takt_write(&in, &x);",
     "the first argument must be an output: TAKT_OUT_PORT"),
    ("read_output.c", "takt_add_component(%s %s TYPES types)", PORT % "pick_Place x; takt_read(&out, &x);",
     "the first argument must be an input: TAKT_IN_PORT or TAKT_EVENT_PORT"),
    ("ask_output.c", "takt_add_component(%s %s TYPES types)", PORT % "if (takt_has_news(&out)) takt_log(TAKT_LOG_INFO, \"new\");",
     "the first argument must be an input: TAKT_IN_PORT or TAKT_EVENT_PORT"),
    ("log.c", "takt_add_component(%s %s)", "#include <takt/module.h>\nvoid run(void) { takt_log(TAKT_LOG_INFO, \"%s\", 1); }\n",
     "expects argument of type"),
    ("class.cpp", "takt_add_process(%s %s)", CLASS,
     "<takt/component.hpp> is for components: use takt_add_component; a program includes <takt/process.hpp> or <takt/process.h>"),
    ("module.c", "takt_add_process(%s %s)", "#include <takt/module.h>\nvoid run(void) {}\n",
     "<takt/module.h> is for components: use takt_add_component; a program includes <takt/process.h>"),
    ("component.c", "takt_add_component(%s %s)", "#include <takt/component.hpp>\nvoid run(void) {}\n",
     "<takt/component.hpp> is for C++: a component in C includes <takt/module.h>"),
    ("process.c", "takt_add_process(%s %s)", "#include <takt/process.hpp>\nint main(void) { return 0; }\n",
     "<takt/process.hpp> is for C++: a program in C includes <takt/process.h>"),
]
GOOD = PORT % "pick_Place pick = {1}; if (takt_read(&in, &pick)) { const pick_Place* same = &pick; takt_write(&out, same); takt_log(TAKT_LOG_INFO, \"%d\", 1); }"
# takt_add_idl() may also come after the component, and TYPES may name other libraries.
ACCEPTED.append(("takt_add_component(picker picker.cpp TYPES types shapes)\nadd_library(shapes INTERFACE)\n" + TYPES, None))

# Each case: the whole CMakeLists.txt, and the error message that CMake must print.
WHOLE = [
    ("find_package(takt REQUIRED)\nproject(mistake)",
     "takt: call project() before find_package(takt), for example project(cell LANGUAGES C CXX)"),
    ("project(mistake LANGUAGES C)\nfind_package(takt REQUIRED)\n" + TYPES,
     "takt_add_idl(types): port types need C++, also for components in C; write LANGUAGES C CXX in the call of project()"),
]

# Sources that include the header of a library of types, although the call has no TYPES; for each, the compiler's first error.
BUILD = TYPES + "takt_add_component(picker include.cpp)\ntakt_add_process(camera include.c)\n"
ERRORS = {"include.cpp": "<pick.hpp> belongs to the library types: write TYPES types in the call of takt_add_component or takt_add_process",
          "include.c": "<pick_c.h> belongs to the library types: write TYPES types in the call of takt_add_component or takt_add_process"}

failures = []
with tempfile.TemporaryDirectory(prefix="takt-cmake-") as folder:
    with open(os.path.join(folder, "pick.idl"), "w", encoding="utf-8") as file:
        file.write("module pick { @final struct Place { double x; }; };\n")
    for name in ("picker.cpp", "camera.c"):
        open(os.path.join(folder, name), "w", encoding="utf-8").close()
    os.mkdir(os.path.join(folder, "tests"))
    with open(os.path.join(folder, "tests", "CMakeLists.txt"), "w", encoding="utf-8") as file:
        file.write("takt_add_component(picker ../picker.cpp)\ntakt_add_component_test(picker ../picker.cpp)\n")
    for calls, said in CASES + ACCEPTED + WHOLE:
        start = "" if (calls, said) in WHOLE else "project(mistake LANGUAGES C CXX)\nfind_package(takt REQUIRED)\n"
        with open(os.path.join(folder, "CMakeLists.txt"), "w", encoding="utf-8") as file:
            file.write("cmake_minimum_required(VERSION 3.25)\n" + start + calls + "\n")
        if not start:  # the languages of the last case must not remain
            shutil.rmtree(os.path.join(folder, "build"), ignore_errors=True)
        done = subprocess.run(["cmake", "-S", folder, "-B", os.path.join(folder, "build"), "-DCMAKE_PREFIX_PATH=" + prefix],
                              capture_output=True, text=True)
        accepted = (calls, said) in ACCEPTED
        if said is None:
            if done.returncode != 0 or done.stderr:
                failures.append("%s: should be accepted, but the message is: %s" % (calls, done.stderr))
        elif (done.returncode == 0) != accepted or said.format(folder=folder) not in re.sub(r"\s+", " ", done.stderr):
            failures.append("%s: the message should be '%s', but is: %s" % (calls, said.format(folder=folder), done.stderr or "nothing"))
    with open(os.path.join(folder, "CMakeLists.txt"), "w", encoding="utf-8") as file:
        file.write("cmake_minimum_required(VERSION 3.25)\nproject(mistake LANGUAGES C CXX)\nfind_package(takt REQUIRED)\n" + BUILD)
        for source, call, _, _ in SOURCES:
            file.write(call % ("of_" + source.replace(".", "_"), source) + "\n")
        file.write("takt_add_component(good good.c TYPES types)\n")
    for source, _, text, _ in [*SOURCES, ("good.c", "", GOOD, "")]:
        with open(os.path.join(folder, source), "w", encoding="utf-8") as file:
            file.write(text)
    for source, header in (("include.cpp", "pick.hpp"), ("include.c", "pick_c.h")):
        with open(os.path.join(folder, source), "w", encoding="utf-8") as file:
            file.write("#include <%s>\n" % header)
    subprocess.run(["cmake", "-S", folder, "-B", os.path.join(folder, "build"), "-DCMAKE_PREFIX_PATH=" + prefix], check=True,
                   capture_output=True)
    done = subprocess.run(["cmake", "--build", os.path.join(folder, "build"), "--", "-k"], capture_output=True, text=True)
    if not os.path.exists(os.path.join(folder, "build", "components", "good.so")):
        failures.append("good.c should compile, but the messages are: " + done.stderr)
    for source, _, _, said in SOURCES:
        one = subprocess.run(["cmake", "--build", os.path.join(folder, "build"), "--target", "of_" + source.replace(".", "_")],
                             capture_output=True, text=True)
        first = next((line for line in one.stderr.splitlines() if " error: " in line), "nothing")
        if said not in first:
            failures.append("%s: the first error should be '%s', but is: %s" % (source, said, first))
    errors = [line for line in done.stderr.splitlines() if "error" in line]
    for source, said in ERRORS.items():
        if not any(said in line for line in errors):
            failures.append("%s without TYPES: the message should be '%s', but is: %s" % (source, said, done.stderr or "nothing"))
print("\n".join(failures) or "%d mistakes are reported with a cure" % (len(CASES + ACCEPTED + WHOLE + SOURCES) + len(ERRORS)))
sys.exit(1 if failures else 0)
