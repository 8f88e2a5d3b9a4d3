import os
import re
import shutil
import signal
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import LIFE, wait_until


class Copies(takt_system.Case):
    def test_modules_of_one_component_do_not_share_global_variables(self):
        run = self.start("run", "counters.xml", "--json")
        for module in ("four", "sporadic_two", "program_two"):
            run.wait_for_state(module, "EXECUTING")
        self.assertEqual(2, len(run.processes("fine.exe")))
        time.sleep(0.5)
        run.signal(signal.SIGINT)
        run.wait()
        self.assertEqual(0, run.status, run.err)
        modules = run.modules()
        for module in modules:
            self.assertEqual(LIFE, run.states(module))
        for module, every in (("one", 1), ("two", 2), ("three", 5), ("four", 10)):
            self.assert_grid(run, module, every=every)
            self.assertEqual(modules[module]["cycles"], int(self.read(module)), module)
        for module in ("sporadic_one", "sporadic_two"):
            self.assertEqual(modules[module]["cycles"], int(self.read(module)), module)
        for module, every in (("program_one", 2), ("program_two", 5)):
            self.assert_grid(run, module, every=every)
            counted = int(re.search(r"released (\d+) times", " ".join(run.printed(module)))[1])
            self.assertIn(modules[module]["cycles"] - counted, (0, 1), module)
        self.assertNotEqual(modules["program_one"]["pid"], modules["program_two"]["pid"])

    def test_an_overwritten_file_changes_neither_the_running_modules_nor_those_of_a_restarted_host(self):
        folders = os.environ["TAKT_COMPONENT_PATH"].split(":")
        for file in ("grid.so", "cpp_properties.so", "fine.so"):
            shutil.copy(next(p for p in (os.path.join(folder, file) for folder in folders) if os.path.exists(p)), self.folder)
        run = self.start("run", shutil.copy(self.beside("overwritten.xml"), self.folder), "--json")
        modules = ("grid", "properties", "fine")
        for module in modules:
            run.wait_for_state(module, "EXECUTING")
        host = run.one("takt-host")
        sizes = {"grid.so": 0, "cpp_properties.so": 4096}
        for file, size in sizes.items():
            path = os.path.join(self.folder, file)
            with open(path, "r+b") as component:
                component.write(bytes(os.path.getsize(path)))
                component.truncate(size)
        cycles = lambda: [m["cycles"] for m in self.status_of("d")["modules"]]
        before = cycles()
        wait_until(lambda: all(now > then + 100 for now, then in zip(cycles(), before)), "100 more cycles")
        self.assertEqual(set(modules), {m["name"] for m in self.status_of("d")["modules"] if m["state"] == "EXECUTING"})

        # The next host loads what was deployed. Only an operator can load the present files.
        host.kill()
        for module in modules:
            wait_until(lambda: [s.target for s in run.steps(module)].count("EXECUTING") == 2, module + " to run in the new host")
        self.done("destruct d.grid", "destruct d.properties")
        self.refused({"reset d.%s" % module: r"cannot load %s: (file too short|invalid ELF header)" % os.path.join(self.folder, file)
                      for module, file in (("grid", "grid.so"), ("properties", "cpp_properties.so"))})
        run.signal(signal.SIGINT)
        self.assertEqual(0, run.wait().status, run.err)

    def test_takt_rejects_two_modules_that_would_share_a_variable(self):
        for command in (["check"], ["run", "--for", "1"]):
            run = self.takt(command[0], "unique.xml", *command[1:])
            self.assert_refused(run, r"\S*unique\.xml:9: error: module two: .*/unique\.so cannot be loaded with its own globals for a "
                                     r"second module: the loader would share the variable \w*shared_count\w*; compile it with "
                                     r"-fno-gnu-unique, or make it a takt::Component")
            self.assertEqual(1, len(run.err.splitlines()), run.err)

    def test_a_component_that_cannot_be_loaded_twice_can_still_have_one_module(self):
        run = self.takt("run", "unique_once.xml", "--for", "0.2", "--json")
        self.assertEqual(0, run.status, run.err)
        self.assertEqual(run.modules()["one"]["cycles"], int(self.read("one")))


if __name__ == "__main__":
    takt_system.main()
