import os
import re
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import LIFE

STARTED = ["IDLE", "INITIALIZE", "START", "EXECUTING"]
AGAIN = ["RECOVER", "EXECUTING"]


class Recovery(takt_system.Case):
    def diary(self, name):
        return self.read(name).splitlines()

    def attempts(self, run, module):
        return [line for line in run.said(module) if line.text.startswith("recovery, attempt")]

    def assert_others_unaffected(self, run):
        for module, every in (("steady", 1), ("program", 2)):
            self.assertEqual(LIFE, run.states(module))
            self.assert_grid(run, module, every=every)

    def assert_backoff(self, run, module, seconds):
        """Checks that each attempt began at least `seconds` after the transition to RECOVER, or after the failed attempt before it."""
        before = None
        for line in run.said(module):
            if "-> RECOVER" in line.text or line.text.startswith("could not recover"):
                before = line.at
            elif line.text.startswith("recovery, attempt"):
                self.assertGreaterEqual((line.at - before) % 86400, seconds - 0.0015, line)  # the printed times are truncated to 1 ms

    def test_a_failed_module_recovers_and_runs_again(self):
        run = self.takt("run", "recovers.xml", "--for", "2.5", "--json")
        modules = run.modules()
        # For each module: the reason, and the number that error() gets.
        reasons = {
            "throws": ("failure: run() threw as it was asked to", 1),
            "returns": ("failure: run() failed as it was asked to", 1),
            "budget": ("budget: one run() took N ms, longer than its budget of 1 ms", 2),
            "condition": ("failure: condition() threw as it was asked to", 1),
        }
        for module, (reason, number) in reasons.items():
            diary = self.diary(module)
            # An error during the stop of the device is counted, but the module ends like all others.
            errors = diary.count("error %d" % number)
            self.assertGreaterEqual(errors, 1, module)
            self.assertIn(modules[module]["errors"], (errors, errors + 1), module)
            recovered = diary.count("recover")
            self.assertEqual(["initialize", "start"] + ["error %d" % number, "recover"] * recovered +
                             ["error %d" % number] * (errors - recovered) + ["destruct"], diary)
            for step in run.steps(module):
                if step.target == "RECOVER":
                    self.assertEqual(reason, re.sub(r"took [\d.]+ ms", "took N ms", step.text))
            self.assertEqual(STARTED + AGAIN * recovered, run.states(module)[:4 + 2 * recovered], module)
            self.assertEqual(["recovery, attempt %d of %d" % (i + 1, 2 if module == "throws" else 3) for i in range(recovered)],
                             [line.text for line in self.attempts(run, module)])
            self.assert_backoff(run, module, 0.05)
            self.assertEqual("DESTRUCT", modules[module]["state"])
        self.assert_others_unaffected(run)

        # Module `throws` may recover twice. So it runs three times for 0.1 s, with two backoffs in between, long before the end of the run.
        self.assertEqual(STARTED + AGAIN * 2 + ["RECOVER", "DESTRUCT"], run.states("throws"))
        self.assertEqual("after 2 attempts: failure: run() threw as it was asked to; to start it again, run takt restart recovers.throws",
                         run.steps("throws")[-1].text)
        self.assertEqual(3, modules["throws"]["errors"])
        self.assertLessEqual(modules["throws"]["cycles"], 300)
        self.assertEqual(1, run.status)
        self.assertIn("module recovers.throws: error: it was given up: failure: run() threw as it was asked to; correct the module, "
                      "or give it more attempts in <recovery>", run.other_lines)

    def test_a_module_that_cannot_recover_is_given_up(self):
        run = self.takt("run", "gives_up.xml", "--for", "3", "--json")
        self.assertEqual(1, run.status)
        modules = run.modules()
        threw = "recover() failed: recover() failed as it was asked to"
        for module, attempts, backoff, reason in (("throws", 2, 0.05, threw), ("returns", 1, 0, threw + r":\n\xc2\x9b31mred"),
                                                  ("in_c", 3, 0.05, "recover() failed: threw: recover() threw as it was asked to")):
            self.assertEqual(STARTED + ["RECOVER", "DESTRUCT"], run.states(module))
            self.assertEqual(attempts, len(self.attempts(run, module)))
            self.assertEqual(attempts, [line.text for line in run.said(module)].count("could not recover: " + reason))
            self.assert_backoff(run, module, backoff)
            self.assertEqual("after %d attempt%s: %s; to start it again, run takt restart gives_up.%s" %
                             (attempts, "" if attempts == 1 else "s", reason, module), run.steps(module)[-1].text)
            self.assertEqual((100, 1), (modules[module]["cycles"], modules[module]["errors"]))
            self.assertIn("module gives_up.%s: error: it was given up: %s; correct the module, or give it more attempts in <recovery>" %
                          (module, reason), run.other_lines)
        # Module `again` recovers each time, but fails again before the recovery counts as successful.
        self.assertEqual(STARTED + AGAIN * 3 + ["RECOVER", "DESTRUCT"], run.states("again"))
        self.assertEqual((40, 4), (modules["again"]["cycles"], modules["again"]["errors"]))
        # With no recovery attempts, an error ends the module. Takt still calls its error() and destruct().
        self.assertEqual(STARTED + ["RECOVER", "DESTRUCT"], run.states("at_once"))
        self.assertEqual(["initialize", "start", "error 1", "destruct"], self.diary("at_once"))
        self.assertEqual(5, len(run.other_lines), run.other_lines)
        self.assert_others_unaffected(run)

    def test_a_device_ends_when_a_stop_device_module_cannot_recover(self):
        run = self.takt("run", "stop_device.xml", "--for", "60", "--json")
        self.assertEqual(1, run.status)
        self.assertEqual(STARTED + AGAIN + ["RECOVER", "DESTRUCT"], run.states("needed"))
        self.assertEqual(1, len(run.other_lines), run.other_lines)
        self.assertRegex(run.other_lines[0], "^module stop_device.needed: error: it was given up: failure: run\\(\\) threw")
        self.assert_others_unaffected(run)


if __name__ == "__main__":
    takt_system.main()
