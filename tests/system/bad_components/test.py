import os
import re
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system

# For each error: a text from its line in the descriptor, and the expected message.
WRONG = [
    (r"<module>", r"module lacks_run: \S+/no_run\.so has no function run\(\); define "),
    (r"<module>", r"module lacks_condition: \S+/no_condition\.so has neither a function condition\(\) nor an event port, so it would never run; "),
    (r"<module>", r"module no_library: \S+/not_a_library\.so is not a shared object \(\.so\) for this machine; "),
    (r"<module>", r"module undefined: cannot load \S+/undefined_symbol\.so: .*undefined symbol: takt_test_defined_nowhere; "),
    (r"<module>", r"module missing: there is no file no_such_file\.so \(looked in .*/tests/components.*\); "),
    (r"<module>", r"module missing_program: there is no file no_such_file\.exe \(looked in .*\); "),
    (r"<module>", r"module not_executable: \S+/not_a_library\.so is not a program that this user may execute; "),
    (r"<module>", r"module not_a_program: \S+/fine\.so is a shared object; "),
    (r"<module>", r"module not_a_thread: \S+/fine\.exe is not a shared object \(\.so\) for this machine; "),
    (r'name="gian"', r"module unknown_property: component CppProperties has no property 'gian'; did you mean gain\?"),
    (r'name="enabled"', r"module wrong_properties: property 'enabled' cannot be 'perhaps'; it takes true or false"),
    (r'name="count"', r"module wrong_properties: property 'count' cannot be '11'; it takes a whole number, 1 to 10"),
    (r'name="offset"', r"module wrong_properties: property 'offset' cannot be '1\.5'; it takes a whole number"),
    (r'name="gain"', r"module wrong_properties: property 'gain' cannot be 'nan'; it takes a number, 0 to 100"),
    (r'name="ratio"', r"module wrong_properties: property 'ratio' cannot be '-1'; it takes a number, at least 0"),
    (r"<module>", r"module background_lacks_run: \S+/no_run\.so has no function run\(\); "),
    (r"<module>", r"module default_out_of_range: \S+/wrong_default\.so has a property 'speed' whose default 20 is out of its range: 0 to 10; "),
    (r"<module>", r"module default_out_of_range: \S+/wrong_default\.so has a property 'parts' whose default 0 is out of its range: at least 1; "),
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
        run = self.takt("run", "cell.xml", "--for", "5", "--json", limit=15)
        self.assert_all_told(run)
        self.assertEqual([], run.lines)

    def test_with_the_option_remote_takt_check_only_warns_about_missing_components(self):
        run = self.takt("check", "cell.xml", "--remote")
        self.assertEqual(1, run.status)
        warnings = [line for line in run.err.splitlines() if ": warning: " in line]
        self.assertEqual(2, len(warnings), run.err)
        self.assertEqual(len(WRONG) - 2, len([line for line in run.err.splitlines() if ": error: " in line]))

    def test_takt_run_accepts_property_values_equal_to_their_bounds(self):
        run = self.takt("run", "properties.xml", "--for", "0.2")
        self.assertEqual(0, run.status, run.err)


if __name__ == "__main__":
    takt_system.main()
