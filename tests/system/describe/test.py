import glob
import json
import os
import re
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system

SCHEMA = os.path.join(takt_system.SOURCE, "config", "iso22166-profile.xsd")
FOLDER = os.path.join(os.path.dirname(takt_system.BIN), "components")
# The ready-made components, without the components of the benchmarks.
READY = sorted(f for f in glob.glob(os.path.join(FOLDER, "*.so")) + glob.glob(os.path.join(FOLDER, "*.exe"))
               if not os.path.basename(f).startswith("bench_"))
MODULE = """  <module>
    <name>%s</name> <filename>%s</filename> <moduletype>%s</moduletype> <operationtype>periodic</operationtype>
    <period>1ms</period> <priority>1</priority>
    <property>
%s
    </property>
  </module>
"""


def module(name, filename, *properties, sporadic=False):
    kind = "process" if filename.endswith(".exe") else "thread"
    values = "\n".join('      <value name="%s">%s</value>' % property for property in properties)
    text = MODULE % (name, filename, kind, values)
    if sporadic:
        text = text.replace("periodic", "sporadic").replace("<period>1ms</period>", "<deadline>1ms</deadline>")
    return text if properties else re.sub(r"(?s) *<property>.*</property>\n", "", text)


# The properties that these programs need before takt describe can describe them.
ASKED_WITH = {"modbus_master.exe": ["map=lamp out coil 0"], "modbus_device.exe": ["map=lamp out coil 0"]}


class Describe(takt_system.Case):
    def test_takt_describe_can_print_every_component_in_every_format(self):
        self.assertGreater(len(READY), 10)
        for file in READY:
            with self.subTest(component=os.path.basename(file)):
                words = [file] + ASKED_WITH.get(os.path.basename(file), [])
                text = self.takt("describe", *words)
                self.assertEqual((0, ""), (text.status, text.err))
                self.assertLessEqual(max(map(len, (line for line in text.out.splitlines() if not line.startswith("  file")))), 100)
                said = self.takt("describe", *words, "--json")
                self.assertEqual(1, len(said.out.splitlines()))
                self.assertEqual(file, said.report["file"])
                for port in said.report["ports"]:
                    # A service consists of two ports, but the text shows it as one entry.
                    self.assertIn(port["name"].split("/")[0], text.out)
                    self.assertTrue(json.loads(port["description"])["fields"])
                for property in said.report["properties"]:
                    self.assertIn(property["name"], text.out)
                self.check_profile(*words)

    def test_takt_describe_shows_the_size_and_version_of_the_saved_state(self):
        for file, version, size in (("keeps.so", 1, 8), ("keeps_more.so", 2, 16), ("keeps_c.so", 1, 8)):
            with self.subTest(component=file):
                self.assertIn("  saved       %d bytes, version %d\n" % (size, version), self.takt("describe", file).out)
                self.assertEqual({"version": version, "bytes": size}, self.takt("describe", file, "--json").report["saved"])
        self.assertNotIn("saved  ", self.takt("describe", "fine.so").out)
        self.assertIsNone(self.takt("describe", "fine.so", "--json").report["saved"])

    def test_the_components_of_the_paper_declare_units_and_ranges_of_their_properties(self):
        for name in ("controller1.so", "control2.so", "control3.so", "control4.exe", "emergency.so", "vision.exe", "monitoring.exe"):
            with self.subTest(component=name):
                said = self.takt("describe", name, "--json").report
                self.assertRegex(said["text"], r"^[A-Z].{10,90}\.$")
                if name != "monitoring.exe":
                    self.assertTrue(said["properties"])
                    self.assertTrue(all(p["text"] and p["unit"] and p["min"] is not None for p in said["properties"]))

    def check_profile(self, *words):
        run = self.takt("describe", *words, "--iso22166")
        self.assertEqual((0, ""), (run.status, run.err))
        profile = self.write("profile.xml", run.out)
        xmllint = subprocess.run(["xmllint", "--nonet", "--noout", "--schema", SCHEMA, profile], capture_output=True, text=True)
        self.assertEqual(0, xmllint.returncode, xmllint.stderr + run.out)
        return run.out

    def test_takt_check_accepts_the_module_element_that_takt_describe_prints(self):
        for file in READY:
            if os.path.basename(file) in ASKED_WITH:
                continue
            with self.subTest(component=os.path.basename(file)):
                element = self.takt("describe", file, "--xml").out
                run = self.takt("check", self.write("pasted.xml", "<root>\n%s</root>\n" % element))
                if "needs a connected event port" in element:
                    self.assertRegex(run.err, r"^\S+: error: .* none of its event ports is connected")
                else:
                    self.assertEqual((0, ""), (run.status, run.err), element)

    def test_the_iso22166_profile_of_a_module_states_how_it_is_released(self):
        self.assertIn("<exeType>EVENTDRIVEN<", self.check_profile("vision.exe"))
        self.assertNotIn("<exeType>", self.check_profile("control2.so"))
        self.assertIn("<exeType>NONRT<", self.check_profile("control2.so", "--operation", "non-real"))
        cell = os.path.join(takt_system.SOURCE, "deploy", "module.xml")
        self.assertIn("<exeType>PERIODIC<", self.check_profile(cell, "control2"))
        self.assertIn("<exeType>NONRT<", self.check_profile(cell, "module.monitoring"))
        many = self.takt("describe", cell, "--iso22166")
        self.assertEqual((1, ""), (many.status, many.out))
        self.assertIn("--iso22166 describes one module, but the number of modules here is 7", many.err)
        none = self.takt("describe", cell, "control22")
        self.assertEqual((1, ""), (none.status, none.out))
        self.assertRegex(none.err, r"there is no module 'control22'; did you mean \S*control2\?")

    def test_takt_describe_shows_the_property_values_from_a_descriptor(self):
        file = self.write("cell.xml", "<root>\n%s</root>" % module("belt", "c_properties.so", ("speed", "1.25")))
        run = self.takt("describe", file)
        self.assertEqual((0, ""), (run.status, run.err))
        self.assertRegex(run.out, r"cell\.belt: Properties of every kind")
        self.assertRegex(run.out, r"speed +double +0\.5 +1\.25 +0 to 2 +m/s")
        self.assertEqual({"speed": "1.25"}, self.takt("describe", file, "--json").report["module"]["given"])

    def test_takt_describe_without_a_file_lists_all_components(self):
        run = self.takt("describe")
        self.assertEqual((0, ""), (run.status, run.err))
        self.assertRegex(run.out, r"(?m)^  control2\.so +c\+\+ +Velocity loop of a DC motor")
        self.assertRegex(run.out, r"(?m)^  control4\.exe +process +Temperature loop")
        self.assertRegex(run.out, r"(?m)^  controller1\.so +c +Position loop")
        self.assertRegex(run.out, r"(?m)^  monitoring\.exe +process +Prints the load and memory")
        self.assertIn("segv.so", run.out)  # listing this component must not run its constructors
        listed = {c["file"]: c for c in self.takt("describe", "--json").report["components"]}
        self.assertEqual({"file": "c_properties.exe", "interface": "process", "text": "Properties of every kind, & \"nothing\" else."},
                         {k: v for k, v in listed["c_properties.exe"].items() if k != "path"})
        here = self.takt("describe", FOLDER)
        self.assertNotIn("c_properties", here.out)
        self.assertIn("control2.so", here.out)

    def test_takt_describe_describes_the_good_components_among_bad_ones(self):
        for files in (["cpp_properties.so", "no_such.so"], ["no_such.so", "cpp_properties.so"]):
            run = self.takt("describe", *files)
            self.assertEqual(1, run.status)
            self.assertRegex(run.out, r"(?m)^CppProperties\b")
            self.assertRegex(run.err, r"^error: there is no file no_such\.so ")

    def test_takt_describe_lists_the_same_properties_for_a_c_component_built_as_a_module_and_as_a_program(self):
        of_module, of_program = (self.takt("describe", "c_properties." + kind, "--json").report for kind in ("so", "exe"))
        self.assertEqual(("c", "process"), (of_module["interface"], of_program["interface"]))
        self.assertEqual("periodic", of_program["operation"])
        self.assertEqual(of_module["properties"], of_program["properties"])
        self.assertEqual([("speed", "double", "0.5", 0, 2, "m/s", "Of the belt."), ("free_number", "double", "-1", None, None, "", "Without bounds."),
                          ("count", "integer", "3", 1, None, "parts", "At a time."), ("on", "bool", "true", None, None, "", "Whether it does anything."),
                          ("label", "string", "none", None, None, "", "What it is called.")],
                         [tuple(p[k] for k in ("name", "type", "default", "min", "max", "unit", "text")) for p in of_module["properties"]])

    def test_takt_describe_starts_a_program_with_the_given_property_values(self):
        run = self.takt("describe", "program_properties.exe", "gain=3", "--json")
        self.assertEqual((0, ""), (run.status, run.err))
        self.assertEqual("1.5", run.report["properties"][0]["default"])
        wrong = self.takt("describe", "program_properties.exe", "gain=300", "gian=1")
        self.assertEqual((1, ""), (wrong.status, wrong.out))
        self.assertIn("property 'gain' cannot be '300'; it takes a number, 0 to 100, in 1/s", wrong.err)
        self.assertIn("this program has no property 'gian'; did you mean gain?", wrong.err)

    def test_a_misspelt_hook_in_c_is_a_warning(self):
        names = (("initialise", "initialize"), ("Start", "start"), ("condtion", "condition"))
        words = ["Takt never calls its function %s(); rename it to %s() if it is the hook, or make it static" % each for each in names]
        described = self.takt("describe", "misspelt_hooks.so")
        self.assertEqual(0, described.status)
        self.assertEqual(sorted(words), sorted(line.split(": warning: ")[1] for line in described.err.splitlines()))
        checked = self.takt("check", self.write("m.xml", "<root>\n%s</root>\n" % module("m", "misspelt_hooks.so")))
        self.assertEqual(0, checked.status)
        self.assertEqual(sorted("module m: " + each for each in words),
                         sorted(re.match(r"^.*/m\.xml:\d+: warning: (.*)$", line)[1] for line in checked.err.splitlines()))

    def test_takt_describe_fails_for_a_program_that_crashes_before_its_init_function(self):
        run = self.takt("describe", "misuses.exe", environment={"TAKT_TEST_CRASH": "1"})
        self.assertEqual((1, ""), (run.status, run.out))
        self.assertRegex(run.err, r"misuses\.exe did not call initPeriodExe\(\) or initSporadicExe\(\) before it .*SIGSEGV.*; "
                                  r"find the cause of the crash in a debugger: gdb .*misuses\.exe$")

    def test_takt_check_reports_the_line_of_every_invalid_property(self):
        wrong = [
            (module("cpp", "cpp_properties.so", ("gian", "1")), "gian", r"component CppProperties has no property 'gian'; did you mean gain\?"),
            (module("c", "c_properties.so", ("sped", "1")), "sped", r"component c_properties has no property 'sped'; did you mean speed\?"),
            (module("c2", "c_properties.so", ("on", "yes")), "on", r"property 'on' cannot be 'yes'; it takes true or false"),
            (module("c3", "c_properties.so", ("count", "0")), "count", r"property 'count' cannot be '0'; it takes a whole number, at least 1, in parts"),
            (module("p", "c_properties.exe", ("speed", "2.5")), "speed", r"property 'speed' cannot be '2\.5'; it takes a number, 0 to 2, in m/s"),
            (module("p2", "c_properties.exe", ("nothing_like_it", "1")), "nothing_like_it",
             r"this program has no property 'nothing_like_it'; use speed, free_number, count, on, label or log-level"),
            (module("q", "program_properties.exe", ("gain", "nan"), sporadic=True), "gain", r"property 'gain' cannot be 'nan'; it takes a number, 0 to 100"),
        ]
        file = self.write("wrong.xml", "<root>\n%s</root>\n" % "".join(text for text, _, _ in wrong))
        with open(file) as descriptor:
            lines = descriptor.read().splitlines()
        for command in (["check", file], ["run", file, "--for", "5"]):
            run = self.takt(*command)
            self.assertEqual((1, ""), (run.status, run.out))
            told = run.err.splitlines()
            self.assertEqual(len(wrong), len(told), run.err)
            for (_, name, words), line in zip(wrong, told):
                match = re.match(r"^.*/wrong\.xml:(\d+): error: module \w+: (.*)$", line)
                self.assertTrue(match, line)
                self.assertIn('name="%s"' % name, lines[int(match[1]) - 1])
                self.assertRegex(match[2], words)

    def test_takt_check_warns_of_a_cpu_that_this_machine_does_not_have(self):
        file = self.write("cpu.xml", "<root>\n<executor name='main' cpu='1023'/>\n%s</root>\n" % module("m", "fine.so"))
        run = self.takt("check", file)
        self.assertEqual(0, run.status)
        self.assertRegex(run.err, r"^device \S+: warning: executor main \(line 2\) requests CPU 1023, which this machine does not have or has "
                                  r"switched off; Takt may use CPUs? [\d,-]+, and the node chooses one of them$")

    def test_takt_check_reports_a_program_with_the_wrong_operationtype_in_the_descriptor(self):
        file = self.write("kind.xml", "<root>\n%s</root>\n" % module("q", "program_properties.exe", ("gain", "2")))
        run = self.takt("check", file)
        self.assertEqual(1, run.status)
        self.assertIn("kind.xml:2: error: module q: the program calls initSporadicExe(), so it is sporadic; use <operationtype>sporadic",
                      run.err)

    def test_takt_check_suggests_the_component_for_a_misspelled_file_name(self):
        run = self.takt("check", self.write("c.xml", "<root>\n%s</root>\n" % module("a", "contrl2.so")))
        self.assertEqual(1, run.status)
        self.assertRegex(run.err, r"there is no file contrl2\.so \(looked in .*\); did you mean control2\.so\?")
        # The first module has no <name>, so its name comes from the misspelled file name. This makes the connection wrong too.
        text = "".join(module("", file).replace("<name></name> ", "") for file in ("Port_source.so", "port_sink.so"))
        run = self.takt("check", self.write("case.xml", "<cell name='c'><device name='d'>\n%s</device>\n%s</cell>\n" % (
            text, "<connection from='d.port_source.out' to='d.port_sink.in'/>")))
        self.assertEqual(1, run.status)
        cause, effect = run.err.splitlines()
        self.assertRegex(cause, r"case\.xml:3: error: module Port_source: there is no file Port_source\.so \(looked in .*\); "
                                r"did you mean port_source\.so\?$")
        self.assertRegex(effect, r"case\.xml:11: error: .* did you mean Port_source\? The module on line 2 has this name from its <filename>$")

    def test_modules_and_programs_receive_their_property_values(self):
        given = (("speed", "1.25"), ("count", "7"), ("on", "false"), ("label", "a b"))
        text = module("so", "c_properties.so", *given) + module("exe", "c_properties.exe", *given) + \
            module("cpp", "program_properties.exe", ("gain", "4"), sporadic=True) + module("plain", "c_properties.exe")
        run = self.takt("run", self.write("right.xml", "<root>\n%s</root>\n" % text), "--for", "0.3")
        self.assertEqual(0, run.status, run.err)
        for when in ("begin", "end"):
            self.assertEqual(3, len(re.findall(r"%s: speed 1\.25, free_number -1, count 7, on 0, label a b" % when, run.err))
                             + len(re.findall(r"%s: speed 0\.5, free_number -1, count 3, on 1, label none" % when, run.err)), run.err)
        self.assertRegex(run.err, r"gain 4, label none")

    def test_a_program_started_by_hand_rejects_invalid_properties(self):
        program = os.path.join(os.path.dirname(takt_system.BIN), "tests", "components", "c_properties.exe")
        run = subprocess.run([program, "speed=3", "sped=1"], capture_output=True, text=True, timeout=takt_system.LONG)
        self.assertEqual((1, ""), (run.returncode, run.stdout))
        self.assertEqual("takt: initPeriodExe(): property 'speed' cannot be '3'; it takes a number, 0 to 2, in m/s\n"
                         "takt: initPeriodExe(): this program has no property 'sped'; did you mean speed?\n", run.stderr)

    def test_modules_without_declared_properties_accept_any_property(self):
        file = self.write("any.xml", "<root>\n%s</root>\n" % (module("so", "fine.so", ("anything", "1")) + module("exe", "fine.exe", ("anything", "1"))))
        run = self.takt("check", file)
        self.assertEqual((0, ""), (run.status, run.err))


if __name__ == "__main__":
    takt_system.main()
