"""Checks that tests/run.py tells a broken product from a busy machine, and that tools/test, tools/build and tools/on reject wrong arguments.
Usage: run_test.py SOURCE_FOLDER"""

import os
import shutil
import subprocess
import sys
import tempfile
import unittest

SOURCE = sys.argv.pop(1)
RUN = os.path.join(SOURCE, "tests/run.py")
SECOND_TIME = "rmdir %s 2>/dev/null || { mkdir %s; echo the first failure; exit 1; }"


class Run(unittest.TestCase):
    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)
        self.folder = self._folder.name
        self._tests = 0

    def add(self, name, command, labels=""):
        """Adds a test that runs `command` with sh; each %s in it becomes a path of this test alone."""
        self._tests += 1
        path = os.path.join(self.folder, "mark%d" % self._tests)
        with open(os.path.join(self.folder, "CTestTestfile.cmake"), "a") as file:
            file.write('add_test([==[%s]==] sh -c [==[%s]==])\n' % (name, command.replace("%s", path)))
            if labels:
                file.write('set_tests_properties([==[%s]==] PROPERTIES LABELS "%s")\n' % (name, labels))

    def run_tests(self):
        """Returns the exit status, the output, and CTest's summary."""
        run = subprocess.run([sys.executable, "-B", RUN, self.folder], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        with open(os.path.join(self.folder, "summary")) as file:
            return run.returncode, run.stdout, file.read()

    def test_a_run_without_failures_is_green(self):
        self.add("one", "true", "system")
        self.add("other", "true")
        status, out, summary = self.run_tests()
        self.assertEqual(0, status, out)
        self.assertTrue(summary.startswith("100% tests passed, 0 tests failed out of 2"), summary)
        self.assertNotIn("Unstable", out)
        self.assertIn("The slowest of 2 tests", out)
        self.assertIn("highest load average", out)

    def test_a_test_that_fails_once_is_unstable_and_its_output_is_kept(self):
        for label in ("system", "dds", "real", "timing", "asan", "tsan"):
            self.add("of %s/with # <odd> characters" % label, SECOND_TIME, label + ";other")
        status, out, summary = self.run_tests()
        self.assertEqual(0, status, out)
        self.assertIn("Unstable: these tests", out)
        self.assertTrue(summary.startswith("100% tests passed, 0 tests failed out of 6"), summary)
        files = os.listdir(os.path.join(self.folder, "unstable"))
        self.assertEqual(6, len(files))
        for name in files:
            with open(os.path.join(self.folder, "unstable", name)) as file:
                self.assertEqual("the first failure\n", file.read())

    def test_a_test_that_fails_twice_is_red(self):
        self.add("unstable", SECOND_TIME, "system")
        self.add("broken", "false", "system")
        status, out, summary = self.run_tests()
        self.assertNotEqual(0, status, out)
        self.assertIn("2 tests failed out of 2", summary)

    def test_a_test_that_does_not_depend_on_the_load_gets_no_second_look(self):
        self.add("pure", SECOND_TIME)
        status, out, summary = self.run_tests()
        self.assertNotEqual(0, status, out)
        self.assertIn("1 tests failed out of 1", summary)

    def test_a_broken_test_is_red_beside_unstable_tests(self):
        self.add("pure", "false")
        self.add("unstable", SECOND_TIME, "system")
        status, out, _ = self.run_tests()
        self.assertNotEqual(0, status, out)

    def test_ten_unstable_tests_are_green_and_eleven_are_red(self):
        for number in range(10):
            self.add("unstable %d" % number, SECOND_TIME, "system")
        status, out, _ = self.run_tests()
        self.assertEqual(0, status, out)
        self.add("one more", SECOND_TIME, "system")
        status, out, _ = self.run_tests()
        self.assertNotEqual(0, status, out)
        self.assertIn("more than 10 tests failed", out)

    def test_the_second_look_runs_one_test_at_a_time(self):
        for name in ("one", "other"):
            self.add(name, "rmdir %%s 2>/dev/null || { mkdir %%s; exit 1; }; mkdir %s/alone && sleep 0.2 && rmdir %s/alone"
                     % (self.folder, self.folder), "system")
        status, out, _ = self.run_tests()
        self.assertEqual(0, status, out)

    def test_a_missing_program_is_red(self):
        with open(os.path.join(self.folder, "CTestTestfile.cmake"), "w") as file:
            file.write("add_test(missing %s/missing)\n" % self.folder)
        status, out, _ = self.run_tests()
        self.assertNotEqual(0, status, out)


class Arguments(unittest.TestCase):
    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)
        self.root = self._folder.name
        for name in ("tools/test", "tools/build", "tools/on", "tests/run.py"):
            os.makedirs(os.path.dirname(self.path(name)), exist_ok=True)
            shutil.copy(os.path.join(SOURCE, name), self.path(name))
        with open(self.path("tools/setup"), "w") as file:  # the first program that tools/test calls
            file.write("#!/bin/sh\necho installing; exit 1\n")
        os.chmod(self.path("tools/setup"), 0o755)

    def path(self, name):
        return os.path.join(self.root, name)

    def run_script(self, command):
        name, *arguments = command.split()
        return subprocess.run([self.path(name), *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def test_a_word_that_ctest_would_ignore_ends_tools_test_at_once(self):
        for command, message in (("--nonsense", "CTest has no option --nonsense; ctest --help lists its options"),
                                 ("-R one --tests-regx two", "CTest has no option --tests-regx; ctest --help lists its options"),
                                 ("--tests-regex=one", "CTest has no option --tests-regex=one; ctest --help lists its options"),
                                 ("-L system --full", "CTest has no option --full; ctest --help lists its options"),
                                 ("--full one", "CTest ignores the argument one; to run the tests whose names contain it, write -R one"),
                                 ("-j 2 -R", "a value must follow the option -R")):
            with self.subTest(command=command):
                run = self.run_script("tools/test " + command)
                self.assertEqual((2, "", "tools/test: " + message), (run.returncode, run.stdout, run.stderr.strip()))

    def test_tools_test_accepts_the_options_of_ctest(self):
        for command in ("--full -R one -E one -L system -LE full -j3 -I 1,2 -U -V -VV -Q -N -FA one -FS one -FC one",
                        "--tests-regex one --label-exclude -j -j 3 --parallel 3 --repeat until-fail:20 --repeat-until-fail 2 --show-only",
                        "--show-only=json-v1 --stop-on-failure --rerun-failed --timeout 5 --schedule-random --test-load 2 --print-labels",
                        "--no-tests=error --interactive-debug-mode 0 --progress --output-log log", ""):
            with self.subTest(command=command):
                run = self.run_script("tools/test " + command)
                self.assertEqual((1, ""), (run.returncode, run.stderr))
                self.assertIn("installing", run.stdout)

    def test_tools_setup_rejects_other_arguments_before_it_installs_anything(self):
        shutil.copy(os.path.join(SOURCE, "tools/setup"), self.path("tools/setup"))
        for command in ("tools/setup --nonsense", "tools/setup --for-tests twice"):
            with self.subTest(command=command):
                run = self.run_script(command)
                self.assertEqual((2, "", "usage: tools/setup [--for-tests]"), (run.returncode, run.stdout, run.stderr.strip()))

    def test_tools_build_has_no_options(self):
        for command in ("tools/build --nonsense", "tools/build release --nonsense", "tools/build release takt -j3"):
            with self.subTest(command=command):
                run = self.run_script(command)
                self.assertEqual((2, ""), (run.returncode, run.stdout))
                self.assertRegex(run.stderr, r"^usage: ")

    def test_tools_on_rejects_an_unknown_release_and_a_missing_command(self):
        for command, message in (("", "which release? tools/on --help describes the arguments"),
                                 ("debian11 true", "unknown release 'debian11'; write debian12, debian13 or debian13-arm64"),
                                 ("--nonsense debian12 true", "unknown release '--nonsense'; write debian12, debian13 or debian13-arm64"),
                                 ("--keep", "a folder must follow --keep"),
                                 ("debian12 --keep folder true",
                                  "no command begins with '-', as --keep does; options must precede debian12"),
                                 ("--keep folder", "which release? tools/on --help describes the arguments"),
                                 ("debian13", "no command for debian13; tools/on --help describes the arguments")):
            with self.subTest(command=command):
                run = self.run_script("tools/on " + command)
                self.assertEqual((2, "", "tools/on: " + message), (run.returncode, run.stdout, run.stderr.strip()))

    def test_tools_on_runs_a_command_only_in_a_folder_that_it_has_made_for_this_release(self):
        for command in (["init", "-q"], ["add", "."], ["-c", "user.name=x", "-c", "user.email=x", "commit", "-qm", "x"]):
            subprocess.run(["git", "-C", self.root, *command], check=True)
        root = self.path("root")
        os.mkdir(root)
        run = self.run_script("tools/on --keep %s debian12 true" % root)
        self.assertEqual((1, "tools/on: tools/on has not made %s; name a folder that does not exist\n" % root),
                         (run.returncode, run.stderr))
        os.makedirs(root + "/takt/.git")
        with open(root + "/takt/.git/system", "w") as file:
            file.write("debian13\n")
        for system in ("debian12", "debian13-arm64"):
            run = self.run_script("tools/on --keep %s %s true" % (root, system))
            self.assertEqual((1, "tools/on: %s has debian13, not %s; name another folder\n" % (root, system)), (run.returncode, run.stderr))

    def test_each_tool_describes_its_arguments_and_does_nothing_else(self):
        for name, usage in (("setup", r"\[--for-tests\]"), ("build", r"release\|debug\|asan\|tsan \[TARGET \.\.\.\]"),
                            ("demo", r"\[--for SECONDS\] \[OPTION \.\.\.\]"), ("test", r"\[--full\] \[CTEST ARGUMENT \.\.\.\]"),
                            ("on", r"\[--keep FOLDER\] debian12\|debian13\|debian13-arm64 COMMAND")):
            with self.subTest(tool=name):
                shutil.copy(os.path.join(SOURCE, "tools", name), self.path("tools/" + name))
                run = self.run_script("tools/%s --help" % name)
                self.assertEqual((0, ""), (run.returncode, run.stderr))
                self.assertRegex(run.stdout, "^usage: tools/%s %s" % (name, usage))
                self.assertNotRegex(run.stdout, "installing|set -")


if __name__ == "__main__":
    unittest.main()
