import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import LIFE, NEVER_RAN

WORDS = {"throw": "threw: %s() threw as it was asked to", "fail": "%s() failed as it was asked to",
         "other": "threw something that is not a std::exception"}


class RefusedStart(takt_system.Case):
    def diary(self, name):
        try:
            return self.read(name).splitlines()
        except FileNotFoundError:
            return []

    def assert_none_ran(self, run):
        self.assertEqual(0, run.executor()["cycles"])
        for name, module in run.modules().items():
            self.assertEqual((0, "DESTRUCT"), (module["cycles"], module["state"]), name)
            self.assertNotIn("EXECUTING", run.states(name))
            self.assertEqual(1, run.states(name).count("DESTRUCT"))

    def test_a_failed_initialize_hook_prevents_the_start_of_the_device(self):
        for how, words in WORDS.items():
            with self.subTest(how=how):
                run = self.takt("run", "initialize_%s.xml" % how, "--for", "5", "--json")
                reason = "initialize() failed: " + (words % "initialize" if "%s" in words else words)
                self.assert_refused(run)
                self.assertEqual(["module initialize_%s.bad: error: %s" % (how, reason)], run.other_lines)
                self.assertEqual(["IDLE", "DESTRUCT"], run.states("bad"))
                self.assert_none_ran(run)
                # Takt calls the hooks in the order of the file. So the module before the bad one was initialised, and is destructed.
                self.assertEqual(["initialize", "destruct"], self.diary("first"))
                self.assertIn(self.diary("last"), ([], ["initialize", "destruct"]))
            for name in ("first", "last"):
                if os.path.exists(os.path.join(self.folder, name)):
                    os.remove(os.path.join(self.folder, name))

    def test_a_failed_start_hook_prevents_the_start_of_the_device(self):
        for how, words in WORDS.items():
            with self.subTest(how=how):
                run = self.takt("run", "start_%s.xml" % how, "--for", "5", "--json")
                reason = "start() failed: " + (words % "start" if "%s" in words else words)
                self.assert_refused(run)
                self.assertEqual(1, len(run.other_lines), run.other_lines)
                self.assertIn("module start_%s.bad: error: it was given up: " % how, run.other_lines[0])
                self.assertIn(reason, run.other_lines[0])
                self.assertEqual(["IDLE", "INITIALIZE", "RECOVER", "DESTRUCT"], run.states("bad"))
                attempts = [line for line in run.said("bad") if line.text.startswith("recovery, attempt")]
                self.assertEqual(2 if how == "throw" else 0, len(attempts))
                self.assert_none_ran(run)
                self.assertEqual(NEVER_RAN, run.states("first"))
                for name in ("first", "last"):
                    self.assertEqual(["initialize", "start", "destruct"], self.diary(name))
                    os.remove(os.path.join(self.folder, name))

    def test_recovery_from_a_failed_start_hook_only_delays_the_start(self):
        run = self.takt("run", "start_recovers.xml", "--for", "0.3", "--json")
        self.assertEqual(0, run.status, run.err)
        self.assertEqual(LIFE[:2] + ["RECOVER"] + LIFE[2:], run.states("bad"))
        self.assertEqual(["initialize", "start", "error 3", "recover", "start", "recover", "start", "destruct"], self.diary("bad"))
        for name in ("first", "last", "program"):
            self.assertEqual(LIFE, run.states(name))
        for name, every in (("first", 1), ("bad", 1), ("last", 1), ("program", 2)):
            self.assert_grid(run, name, every=every)
        self.assertEqual(run.executor()["cycles"], run.modules()["bad"]["cycles"])


if __name__ == "__main__":
    takt_system.main()
