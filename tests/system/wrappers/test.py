import glob
import os
import shutil
import signal
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import wait_until
from terminal import Terminal

CONTAINER = ["unshare", "--pid", "--kill-child", "--fork", "--mount-proc"]
MODULES = ("child", "session", "daemon", "stubborn")


class Wrappers(takt_system.Case):
    def setUp(self):
        super().setUp()
        os.environ["SERVER"] = self.beside("server.py")
        self.addCleanup(os.environ.pop, "SERVER")
        path = os.environ.get("TAKT_COMPONENT_PATH", "")
        os.environ["TAKT_COMPONENT_PATH"] = self.beside("") + ":" + path
        self.addCleanup(os.environ.update, TAKT_COMPONENT_PATH=path)

    def servers(self, run):
        """Returns the processes that execute server.py."""
        return [p for p in run.processes("python3") if p.alive]

    def wait_for_servers(self, run, times=1):
        for module in MODULES:
            wait_until(lambda: run.printed(module).count("listens") == times or run.status is not None,
                       "server %d of %s" % (times, module))
            self.assertEqual(times, run.printed(module).count("listens"), run.err)
        self.assertEqual(len(MODULES), len(self.servers(run)))

    def test_ctrl_c_ends_all_processes_of_process_modules(self):
        run = self.start("run", "cell.xml")
        self.wait_for_servers(run)
        run.signal(signal.SIGINT)
        self.assertEqual(0, run.wait().status, run.err)
        self.assert_nothing_left(run)

    def test_a_module_starts_again_after_every_process_of_its_program_has_ended(self):
        node = self.node("robot")
        self.deploy("cell.xml")
        self.wait_for_servers(node)

        self.done(*("stop robot.%s" % module for module in MODULES))
        self.assertEqual([], self.servers(node))
        self.done(*("start robot.%s" % module for module in MODULES))
        self.wait_for_servers(node, 2)

        self.done(*("restart robot.%s" % module for module in MODULES))
        self.wait_for_servers(node, 3)

        self.done(*("destruct robot.%s" % module for module in MODULES))
        self.assertEqual([], self.servers(node))
        self.done(*("restart robot.%s" % module for module in MODULES))
        self.wait_for_servers(node, 4)

        os.kill(node.one("sleep").pid, signal.SIGSEGV)
        wait_until(lambda: node.printed("daemon").count("listens") == 5, "the server after the crash of the module")
        self.assertEqual(len(MODULES), len(self.servers(node)))

        self.done("undeploy cell")
        self.assertEqual(["takt-node"], [p.program for p in node.processes() if p.alive])
        self.assertNotIn("Address already in use", node.err)
        self.end({"robot": node})

    def test_the_death_of_the_node_ends_all_processes_of_process_modules(self):
        node = self.node("robot")
        self.deploy("cell.xml")
        self.wait_for_servers(node)
        node.signal(signal.SIGKILL)
        self.assertEqual(-9, node.wait().status)
        self.assert_nothing_left(node)

        node = self.node("robot", "--resume")
        self.wait_for_servers(node)
        self.end({"robot": node})

    def test_the_death_of_takt_keeper_ends_all_processes_of_its_program_and_the_module_recovers(self):
        node = self.node("robot")
        self.deploy("cell.xml")
        self.wait_for_servers(node)
        os.kill(node.one("sleep").parent(), signal.SIGKILL)
        node.wait_for_line(r"robot\.daemon: EXECUTING -> RECOVER \(crash: the process was killed by SIGKILL \(Killed\), "
                           r"because its takt-keeper was killed")
        wait_until(lambda: node.printed("daemon").count("listens") == 2, "the server after the recovery")
        self.assertNotIn("Address already in use", node.err)
        self.end({"robot": node})

    def test_an_update_of_a_program_ends_all_processes_of_the_old_program(self):
        for script in glob.glob(self.beside("*.sh")):
            shutil.copy(script, self.folder)
        os.environ["TAKT_COMPONENT_PATH"] = self.folder
        cell = shutil.copy(self.beside("cell.xml"), self.folder)
        node = self.node("robot")
        self.deploy(cell)
        self.wait_for_servers(node)
        for module in MODULES:
            with open(os.path.join(self.folder, module + ".sh"), "a") as script:
                script.write("# a new version\n")
        self.deploy(cell, "--update")
        self.wait_for_servers(node, 2)
        self.assertNotIn("Address already in use", node.err)
        self.end({"robot": node})

    def test_takt_ends_all_processes_of_a_program_that_it_starts_only_to_read_its_ports(self):
        path = os.environ["TAKT_COMPONENT_PATH"].split(":")
        os.environ["PROGRAM"] = next(p for p in (os.path.join(folder, "fine.exe") for folder in path) if os.path.exists(p))
        self.addCleanup(os.environ.pop, "PROGRAM")
        for arguments in (("describe", self.beside("described.sh")), ("check", "described.xml")):
            run = self.takt(*arguments)
            self.assertEqual(0, run.status, run.err)
            self.assertIn("described", run.out)
            self.assert_nothing_left(run)
        node = self.node("robot")
        self.deploy("described.xml")
        self.assertEqual(1, len(node.processes("sleep")))
        self.end({"robot": node})

    def check_that_the_first_process_reaps_orphans(self, run, program):
        first = min(p.pid for p in run.processes(program))
        subprocess.run(["nsenter", "--target", str(first), "--pid", "sh", "-c", "sleep 2000 &"], check=True,
                       env=dict(os.environ, **{takt_system.MARK: run.mark}))
        orphan = wait_until(lambda: next((p for p in run.processes("sleep") if p.arguments == ["2000"]), None), "the orphan")
        wait_until(lambda: orphan.parent() == first, "the first process to adopt the orphan")
        orphan.kill()
        wait_until(lambda: not os.path.exists("/proc/%d" % orphan.pid), "the orphan to be reaped")
        os.kill(first, signal.SIGTERM)
        self.assertEqual(0, run.wait().status, run.err)
        self.assertRegex(run.err, "robot")

    def test_a_node_that_is_the_first_process_of_a_container_reaps_orphans(self):
        node = self.node("robot", before=CONTAINER)
        self.check_that_the_first_process_reaps_orphans(node, "takt-node")

    def test_takt_run_as_the_first_process_of_a_container_reaps_orphans(self):
        run = self.start("run", "cell.xml", before=CONTAINER)
        self.wait_for_servers(run)
        self.check_that_the_first_process_reaps_orphans(run, "takt")

    def test_ctrl_c_ends_takt_run_in_the_terminal_of_a_container(self):
        terminal = Terminal()
        self.addCleanup(terminal.close)
        run = self.start("run", "cell.xml", before=CONTAINER, terminal=terminal.slave, become=terminal.become)
        self.wait_for_servers(run)
        terminal.press("\x03")
        self.assertEqual(0, run.wait().status, run.err)  # a second SIGINT would kill the node


if __name__ == "__main__":
    takt_system.main()
