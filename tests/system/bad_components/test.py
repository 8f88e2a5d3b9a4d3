import os
import re
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system

# For each error: a text from its line in the descriptor, and the expected message.
WRONG = [
    (r"<filename>", r"module lacks_run: \S+/no_run\.so has no function run\(\); define "),
    (r"<filename>", r"module lacks_condition: \S+/no_condition\.so has neither a function condition\(\) nor an event port, so it would never run; "),
    (r"<filename>", r"module no_library: \S+/not_a_library\.so is not a shared object \(\.so\) for this machine; "),
    (r"<filename>", r"module undefined: cannot load \S+/undefined_symbol\.so: undefined symbol: takt_test_defined_nowhere\(int\); "
     r"link the library that defines takt_test_defined_nowhere\(int\)$"),
    (r"<filename>", r"module missing: there is no file no_such_file\.so \(looked in .*/tests/components.*\); "),
    (r"<filename>", r"module missing_program: there is no file no_such_file\.exe \(looked in .*\); "),
    (r"<filename>", r"module not_executable: \S+/not_a_library\.so is not a program that this user may execute; "),
    (r"<filename>", r"module not_a_program: \S+/fine\.so is a shared object; "),
    (r"<filename>", r"module not_a_thread: \S+/fine\.exe is not a shared object \(\.so\) for this machine; "),
    (r'name="gian"', r"module unknown_property: component CppProperties has no property 'gian'; did you mean gain\?"),
    (r'name="enabled"', r"module wrong_properties: property 'enabled' cannot be 'perhaps'; it takes true or false"),
    (r'name="count"', r"module wrong_properties: property 'count' cannot be '11'; it takes a whole number, 1 to 10"),
    (r'name="offset"', r"module wrong_properties: property 'offset' cannot be '1\.5'; it takes a whole number"),
    (r'name="gain"', r"module wrong_properties: property 'gain' cannot be 'nan'; it takes a number, 0 to 100"),
    (r'name="ratio"', r"module wrong_properties: property 'ratio' cannot be '-1'; it takes a number, at least 0"),
    (r"<filename>", r"module background_lacks_run: \S+/no_run\.so has no function run\(\); "),
    (r"<filename>", r"module default_out_of_range: \S+/wrong_default\.so has a property 'speed' whose default 20 is out of its range: 0 to 10; "),
    (r"<filename>", r"module default_out_of_range: \S+/wrong_default\.so has a property 'parts' whose default 0 is out of its range: at least 1; "),
    (r"<filename>", r"module default_out_of_range: \S+/wrong_default\.so declares property 'log-level', but every module already has this property, "),
    (r"<filename>", r"module default_out_of_range: \S+/wrong_default\.so has a property 'bounds' whose minimum 10 is greater than its maximum 0; "),
]


class BadComponents(takt_system.Case):
    def assert_all_told(self, run):
        self.assertEqual(1, run.status)
        self.assertEqual("", run.out)
        with open(self.beside("cell.xml")) as file:
            descriptor = file.read().splitlines()
        told = run.err.splitlines()
        self.assertEqual(len(WRONG), len(told), run.err)
        for (on_the_line, words), line in zip(WRONG, told):
            match = re.match(r"^(.*/cell\.xml):(\d+): error: (.*); .+$", line)
            self.assertTrue(match, line)
            self.assertRegex(descriptor[int(match[2]) - 1], on_the_line)
            self.assertRegex(line, "error: " + words)

    def test_takt_check_reports_every_invalid_component(self):
        self.assert_all_told(self.takt("check", "cell.xml"))
        self.assert_all_told(self.takt("check", "cell.xml", "--json"))

    def test_takt_run_starts_no_module_if_any_component_is_invalid(self):
        run = self.takt("run", "cell.xml", "--for", "5", "--json")
        self.assert_all_told(run)
        self.assertEqual([], run.lines)

    def test_takt_deploy_names_the_same_line_as_takt_check_for_a_missing_component(self):
        cell = self.write("cell.xml", "<cell name='c'><device name='d'>\n<module>\n<name>m</name>\n<filename>no_such.so</filename>\n"
                          "<moduletype>thread</moduletype><operationtype>periodic</operationtype><period>1ms</period><priority>1</priority>\n"
                          "</module></device></cell>")
        node = self.node("d")
        for command in ("check", "deploy"):
            self.assertRegex(self.takt(command, cell).err, r"(?m)cell\.xml:4: error: .*module m: there is no file no_such\.so ")
        self.end({"d": node})

    def test_with_the_option_remote_takt_check_only_warns_about_missing_components(self):
        run = self.takt("check", "cell.xml", "--remote")
        self.assertEqual(1, run.status)
        warnings = [line for line in run.err.splitlines() if ": warning: " in line]
        self.assertEqual(2, len(warnings), run.err)
        self.assertEqual(len(WRONG) - 2, len([line for line in run.err.splitlines() if ": error: " in line]))

    def test_takt_describe_reports_wrong_names_and_failed_constructors(self):
        for file, words in (("wrong_name.so", "wrong_name.so has a property with the invalid name 'belt speed'; a name begins with"),
                            ("wrong_name.exe", "the program has a property with the invalid name 'belt speed'; a name begins with"),
                            ("throws.so", "the constructor of Throws in .*throws.so threw: the sensor does not answer; a constructor only "
                                          "declares ports and properties; work that can fail belongs in initialize")):
            with self.subTest(file=file):
                run = self.takt("describe", file)
                self.assertEqual((1, ""), (run.status, run.out))
                self.assertRegex(run.err, words)

    def module(self, file, kind, operation, more=""):
        return self.write(os.path.basename(file) + ".xml", "<root><module><filename>%s</filename><moduletype>%s</moduletype><operationtype>%s</operationtype>"
                          "%s</module></root>" % (file, kind, operation, more))

    def test_a_property_that_is_created_after_the_constructor_is_an_error(self):
        run = self.takt("run", self.module("late.so", "thread", "periodic", "<period>1000000</period><priority>1</priority>"), "--for", "1")
        self.assertEqual(1, run.status)
        self.assertIn("property 'speed' was created after the constructor, so it would have no effect; make it a member", run.err)

    def test_a_periodic_program_that_waits_in_a_wrong_way_is_told_how_to_wait(self):
        for arguments, words in (("", "waitSporadic(): the module is periodic; call waitPeriod()"),
                                 ("<arguments><argument>thread</argument></arguments>",
                                  "waitPeriod(): call it from the thread that called initPeriodExe() or initSporadicExe()")):
            run = self.takt("run", self.module("waits_wrong.exe", "process", "periodic",
                                               "<period>1000000</period><priority>1</priority>" + arguments), "--for", "1")
            with self.subTest(arguments=arguments):
                self.assertEqual(1, run.status)
                self.assertIn(words, run.err)

    def test_a_program_that_creates_a_port_too_late_or_becomes_a_daemon_ends_with_a_message(self):
        # A daemon prints what is wrong, unless Takt ends it before.
        for how, words in (("late port", r"initPeriodExe\(\): port 'late' was created after this call, so it would have no effect; "),
                           ("late daemon", r"the program calls waitPeriod\(\) in a copy of its process, which daemon\(\) or fork\(\) made; |"
                                           "the process ended with status 0, while processes that it had started still ran")):
            run = self.takt("run", self.module("misuses.exe", "process", "periodic", "<period>1000000</period><priority>1</priority>"
                                               "<arguments><argument>%s</argument></arguments>" % how), "--for", "1")
            with self.subTest(how=how):
                self.assertRegex(run.out + run.err, words)

    def test_takt_check_rejects_a_periodic_program_that_is_declared_non_real(self):
        run = self.takt("check", self.module("grid.exe", "process", "non-real"))
        self.assertEqual(1, run.status)
        self.assertIn("the program calls initPeriodExe(), so it is periodic; use <operationtype>periodic</operationtype> and <period>", run.err)

    def test_takt_check_says_what_is_wrong_with_a_file_that_cannot_be_loaded_or_found(self):
        with open(os.path.join(os.environ["TAKT_COMPONENT_PATH"].split(":")[0], "grid.so"), "rb") as whole, open(os.path.join(self.folder, "cut.so"), "wb") as cut:
            cut.write(whole.read(3000))
        self.write("script.exe", "#!/usr/bin/no-such-interpreter\n")
        os.chmod(os.path.join(self.folder, "script.exe"), 0o755)
        period = "<period>1000000</period><priority>1</priority>"
        for file, kind, words, path in (
                ("./cut.so", "thread", "a part of the file is missing; copy it again", None),
                ("./script.exe", "process", "needs the interpreter /usr/bin/no-such-interpreter, which does not exist; install it", None),
                ("GRID.so", "thread", "did you mean grid.so?", None),
                ("xyzgrid1.so", "thread", "build it, correct the name, or add its folder to TAKT_COMPONENT_PATH", None),
                ("nothing.so", "thread", r"\(\S+ does not exist; separate folders with ':'\)", "/a,/b"),
                ("nothing.so", "thread", r"\(\S+ does not exist; write \$HOME instead of ~\)", "~/components")):
            with self.subTest(file=file):
                run = self.takt("check", self.module(file, kind, "periodic", period),
                                **({"environment": {"TAKT_COMPONENT_PATH": path}} if path else {}))
                self.assertEqual(1, run.status)
                self.assertRegex(run.err, words)

    def test_takt_check_says_how_to_write_a_property(self):
        run = self.takt("check", self.module("grid.so", "thread", "periodic",
                                             '<period>1000000</period><priority>1</priority><property name="x">1</property>'))
        self.assertEqual(1, len(run.err.splitlines()), run.err)
        self.assertIn('write <property><value name="NAME">VALUE</value></property>', run.err)

    def test_takt_run_accepts_property_values_equal_to_their_bounds(self):
        run = self.takt("run", "properties.xml", "--for", "0.2")
        self.assertEqual(0, run.status, run.err)


if __name__ == "__main__":
    takt_system.main()
