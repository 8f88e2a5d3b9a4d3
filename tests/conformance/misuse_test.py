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
RESULT = 'for success, return {}; for a failure, return takt::fail("what is wrong", "what to do")'
# Each case: the bodies of start() and run(), and the error message of the compiler; None means that the source compiles.
CASES = [
    ('if (gain < 0) return takt::fail("no air", "open the valve");', "if (in.read()) out.write(in.value());", None),
    ('if (gain < 0) takt::fail("no air", "open the valve");', "", "return it; otherwise the failure is lost"),
    ("return false;", "", RESULT),
    ('return "no air";', "", RESULT),
    ('gain.narrow(0, 1, "as the feeder is");', "", "nodiscard"),
    ("", "basic::Count count; out.write(count);", "basic::Count"),
    ("", "gain = 2;", "gain"),
    ("", "in.value().value(2);", "const"),
    ('log().info("{} {{}} {:.2f}", 1, 2.5);',
     'log().error("failed"); log().debug("{} {}", "text", takt::BoundedString<8>{"bounded"});', None),
]
# Log calls, and a part of the sentence in the compiler's first error. GCC 14 names the call in an error of its own before.
LITERAL = 'the format of a log call must be a literal; to log a text, write log().info("{}", text)'
LOG_CALLS = [
    ('log().info("{} {}", 1);', "this log call has more {} than arguments"),
    ('log().error("failed", 1);', "this log call has more arguments than {}"),
    ('log().error("failed with %d", 1);', "% does not stand for an argument"),
    ('log().warning("{", 1);', "use only {} and {:SPEC} in a log format, and {{ or }} for a brace"),
    ('log().debug("{0}", 1);', "use only {} and {:SPEC} in a log format, and {{ or }} for a brace"),
    ('log().info("%s");' % ("x" * 151), "a log format has at most 150 characters"),
    ("std::string text; log().info(text);", LITERAL),
    ('log().info(std::string{"at "} + "{}", 1);', LITERAL),
    ('const char* text = "x"; log().info(text);', LITERAL),
    ("char text[10]{}; log().info(text);", LITERAL),
    ('log().info("{}", std::vector<int>{});', "an argument of a log call is a number, a bool, a char, an enumerator, a text or a property"),
    ('log("text");', 'log() has no arguments; write log().info("{}", text), or std::log(x) for the logarithm'),
]
# Members of components, each in its own component of one source, and the expected message.
FORGOTTEN = "pass *this as the first argument: takt::%s; only a program"
TEXT_PROPERTY = "the type of a property is bool, a signed integer, float, double or std::string; for a text, write takt::Property<std::string>"
MEMBERS = [
    ('takt::InPort<basic::Number> in{"in"};', FORGOTTEN % 'InPort<T> in{*this, "in"}'),
    ('takt::EventPort<basic::Number> in{"in", {.text = "Parts."}};', FORGOTTEN % 'EventPort<T> in{*this, "in"}'),
    ('takt::OutPort<basic::Number> out{"out"};', FORGOTTEN % 'OutPort<T> out{*this, "out"}'),
    ('takt::Property<double> gain{"gain", 1};', FORGOTTEN % 'Property<double> gain{*this, "gain", 1.0}'),
    ("takt::Saved<double> kept{1};", FORGOTTEN % "Saved<T> kept{*this, 1}"),
    ('takt::Service<basic::Number, basic::Flag> ask{"ask"};',
     FORGOTTEN % 'Service<Request, Reply> service{*this, "service"}'),
    ('takt::Client<basic::Number, basic::Flag> ask{"ask"};', FORGOTTEN % 'Client<Request, Reply> client{*this, "client"}'),
    ('takt::Property<const char*> label{*this, "label", "none"};', TEXT_PROPERTY),
    ('takt::Property<unsigned> count{*this, "count", 1};', TEXT_PROPERTY),
    ('takt::InPort<double> in{*this, "in"};', "PortType<double>"),
    ('takt::EventPort<bool> in{*this, "in"};', "PortType<bool>"),
    ('takt::OutPort<takt::Nanoseconds> out{*this, "out"};', "PortType<std::chrono::duration"),
    ('takt::Client<basic::Number, float> ask{*this, "ask"};', "PortType<float>"),
]

# Each case: a source, and the only error that the compiler may report, even if later lines use the wrongly declared port.
WRONG_TYPE = "the types of ports come from IDL: put a struct into an IDL file"
NO_COMPONENT = "*this is not a component: derive the class from takt::Component or, in a program, omit *this"
PROGRAM = "<takt/process.h> is for programs: use takt_add_process; a component includes <takt/component.hpp> or <takt/module.h>"
SOURCES = [
    ("""#include <takt/component.hpp>
class Feeder : public takt::Component {
  takt::InPort<double> in{*this, "in"};
  takt::OutPort<double> out{*this, "out"};
  void run(const takt::Cycle&) override {
    if (in.read()) out.write(2 * in.value());
  }
};
TAKT_COMPONENT(Feeder)
""", WRONG_TYPE),
    ("""#include <takt/process.hpp>
#include <basic.hpp>
struct Feeder {
  takt::InPort<basic::Number> in{*this, "in"};
  takt::EventPort<basic::Number> event{*this, "event", {.text = "Parts."}};
  takt::OutPort<basic::Number> out{*this, "out"};
  takt::Property<double> gain{*this, "gain", 1};
  takt::Saved<double> kept{*this, 1};
  takt::Service<basic::Number, basic::Flag> service{*this, "service"};
  takt::Client<basic::Number, basic::Flag> client{*this, "client"};
} feeder;
int main() {
  initPeriodExe();
  for (;;) {
    waitPeriod();
    if (feeder.in.read()) feeder.out.write(feeder.in.value());
  }
}
""", NO_COMPONENT),
    # The source of a program that is compiled as a component, and a component that includes the header for programs.
    ("""#include <takt/process.h>
int main() {
  initSporadicExe();
  for (;;) waitSporadic();
}
""", PROGRAM),
    ("""#include <takt/component.hpp>
#include <takt/process.hpp>
class Feeder : public takt::Component {
  void run(const takt::Cycle&) override {}
};
TAKT_COMPONENT(Feeder)
""", PROGRAM),
    ("#include <takt/component.hpp>\nclass Feeder : public takt::Component {};\nTAKT_COMPONENT(Feeder)\n",
     "the class of TAKT_COMPONENT has no run(); write void run(const takt::Cycle& cycle) override"),
    ("#include <takt/component.hpp>\nclass Feeder : public takt::Component { void run() {} };\nTAKT_COMPONENT(Feeder)\n",
     "the class of TAKT_COMPONENT has no run(); write void run(const takt::Cycle& cycle) override"),
    ("#include <takt/component.hpp>\nclass Feeder { void run(const takt::Cycle&) {} };\nTAKT_COMPONENT(Feeder)\n",
     "derive the class of TAKT_COMPONENT from takt::Component"),
    ("#include <takt/component.hpp>\nclass Feeder : public takt::Component {\n  Feeder() = default;\n"
     "  void run(const takt::Cycle&) override {}\n};\nTAKT_COMPONENT(Feeder)\n",
     "the class of TAKT_COMPONENT needs a public constructor without arguments"),
]

build = sys.argv[1]
commands = json.load(open(os.path.join(build, "compile_commands.json")))
entry = next(c for c in commands if c["file"].endswith("tests/unit/testing/subject.cpp"))
arguments = shlex.split(entry["command"])
first = next(i for i, a in enumerate(arguments) if os.path.basename(a).startswith(("c++", "g++", "clang++")))
keep = [a for a in arguments[first + 1:] if a.startswith(("-I", "-D", "-std", "-f", "-W"))]
keep += [a for i, flag in enumerate(arguments) if flag == "-isystem" for a in ("-isystem", arguments[i + 1])]

# The headers of a component are compiled once, into a precompiled header.
includes = COMPONENT.partition("class")[0]
folder = tempfile.TemporaryDirectory()
headers = os.path.join(folder.name, "headers.hpp")
with open(headers, "w") as file:
    file.write(includes)
subprocess.run([arguments[first], *keep, "-Werror", "-x", "c++-header", headers, "-o", headers + ".gch"], check=True)


def compiled(text, flags=keep):
    path = os.path.join(folder.name, "source.cpp")
    with open(path, "w") as source:
        source.write(text)
    precompiled = ["-include", headers] if "<takt/component.hpp>" in text else []
    return subprocess.run([arguments[first], *flags, "-Werror", "-fsyntax-only", *precompiled, path], capture_output=True, text=True)


failures = []
for start, run, said in CASES:
    done = compiled(COMPONENT % (start, run))
    if said is None and done.returncode != 0:
        failures.append("%s %s: this source should compile, but does not: %s" % (start, run, done.stderr))
    if said is not None and (done.returncode == 0 or said not in done.stderr):
        failures.append("%s %s: the message should contain '%s', but is: %s" % (start, run, said, done.stderr or "nothing"))
source = includes + "".join("struct Feeder%d : takt::Component {\n  %s\n  void run(const takt::Cycle&) override {}\n} feeder_%d;\n"
                            % (i, member, i) for i, (member, _) in enumerate(MEMBERS))
done = compiled(source)
errors = [line for line in done.stderr.splitlines() if " error: " in line or ": In instantiation of " in line]
for member, said in MEMBERS:
    if not any(said in line for line in errors):
        failures.append("%s: the message should contain '%s', but is: %s" % (member, said, done.stderr or "nothing"))
if sum(WRONG_TYPE in line for line in errors) != 4:
    failures.append("each of the four types without IDL should be rejected as one, but the messages are: %s" % done.stderr)
if sum(" error: " in line for line in errors) != len(MEMBERS):
    failures.append("each mistake should be one error, but the messages are: %s" % done.stderr)
# In C, a hook that returns a result is rejected, and the compiler shows the line that describes the hook.
for hook in ("initialize", "start", "run", "recover", "destruct"):
    path = os.path.join(folder.name, "source.c")
    with open(path, "w") as file:
        file.write("#include <takt/module.h>\nint %s(void) { return -1; }\n" % hook)
    done = subprocess.run(["cc", *[flag for flag in keep if flag.startswith("-I")], "-fsyntax-only", path], capture_output=True, text=True)
    if done.returncode == 0 or "returns nothing; it reports a failure with takt_fail(text)" not in done.stderr:
        failures.append("int %s(void) in C: the message should name takt_fail(), but is: %s" % (hook, done.stderr or "nothing"))
for source, said in SOURCES:
    flags = [flag for flag in keep if flag != "-DTAKT_THREAD_MODULE"] if said == NO_COMPONENT else keep
    errors = [line for line in compiled(source, [*flags, "-Wno-overloaded-virtual"]).stderr.splitlines() if " error: " in line]
    if len(errors) != 1 or said not in errors[0]:
        failures.append("%s: the only error should be '%s', but the errors are:\n%s" % (source, said, "\n".join(errors)))
for call, said in LOG_CALLS:
    done = compiled(COMPONENT % ("", call))
    errors = [line for line in done.stderr.splitlines() if " error: " in line and "call to consteval function" not in line]
    if not errors or said not in errors[0]:
        failures.append("%s: the first error should contain '%s', but is: %s" % (call, said, errors[0] if errors else "nothing"))
print("\n".join(failures) or
      "%d components compile or are rejected as expected" % (len(CASES) + len(MEMBERS) + len(SOURCES) + len(LOG_CALLS)))
sys.exit(1 if failures else 0)
