import os
import signal
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import LIFE, wait_until

STARTED = LIFE[:4]
AGAIN = ["RECOVER", "EXECUTING"]


class NonReal(takt_system.Case):
    def test_non_real_time_threads_and_programs_run_outside_the_tables(self):
        run = self.takt("run", "cell.xml", "--for", "4", "--json")
        self.assertEqual(1, run.status, run.err)
        modules = run.modules()

        self.assertEqual(LIFE, run.states("paced"))
        self.assertGreater(modules["paced"]["cycles"], 0)
        at = {(s.source, s.target): s.at for s in run.steps("paced")}
        seconds = (at["EXECUTING", "START"] - at["START", "EXECUTING"]) % 86400
        self.assertLessEqual(modules["paced"]["cycles"], seconds / 0.01 + 5, "a period must be the shortest time between two runs")
        self.assertEqual(["initialize", "start", "destruct"], self.read("paced").splitlines())

        self.assertEqual(LIFE, run.states("free"))
        self.assertGreater(modules["free"]["cycles"], modules["paced"]["cycles"])
        self.assertEqual(modules["free"]["cycles"], int(self.read("free")))

        self.assertEqual(STARTED + AGAIN + ["RECOVER", "DESTRUCT"], run.states("fails"))
        self.assertEqual((20, 2), (modules["fails"]["cycles"], modules["fails"]["errors"]))
        self.assertEqual(["initialize", "start", "error 1", "recover", "error 1", "destruct"], self.read("fails").splitlines())

        self.assertEqual(LIFE, run.states("ends_well"))
        self.assertEqual("it has finished", run.steps("ends_well")[-1].text)
        self.assertEqual(0, modules["ends_well"]["errors"])
        self.assertEqual(1, len(run.printed("ends_well")))

        self.assertEqual(STARTED + AGAIN * 2 + ["RECOVER", "DESTRUCT"], run.states("ends_badly"))
        self.assertEqual(3, modules["ends_badly"]["errors"])
        self.assertEqual(3, len(run.printed("ends_badly")))
        self.assertEqual(2, len(run.other_lines), run.other_lines)
        self.assertRegex("\n".join(run.other_lines),
                         r"module cell\.ends_badly: error: it was given up: crash: the process ended with status 3; its last line "
                         r"was: started \d+; ")

        # The non-real-time programs must start after the first row.
        self.assertEqual(LIFE, run.states("grid"))
        self.assert_grid(run, "grid")
        t0 = int(self.read("grid").split()[0])
        for module in ("ends_well", "ends_badly"):
            self.assertGreater(int(run.printed(module)[0].split()[1]), t0)

    def test_a_non_real_time_module_that_never_returns_from_run_does_not_block_the_shutdown(self):
        run = self.start("run", "endless.xml", "--json")
        wait_until(lambda: os.path.exists(os.path.join(self.folder, "endless")), "the endless run to begin")
        run.signal(signal.SIGINT)
        self.assertEqual(1, run.wait().status)
        self.assertEqual(1, len(run.other_lines), run.other_lines)
        # The module runs only in idle time, so its thread may get no time to report where it was.
        self.assertRegex(run.other_lines[0], r"^module endless\.endless: error: run\(\) did not return within 2 s, so the node killed "
                         r"the host(; run\(\) was in run at endless\.cpp:\d+ in endless\.so)?$")
        self.assertEqual({"DESTRUCT"}, {m["state"] for m in run.modules().values()})
        self.assertEqual(LIFE, run.states("steady"))
        self.assert_grid(run, "steady")


if __name__ == "__main__":
    takt_system.main()
