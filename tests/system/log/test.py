import json
import os
import re
import resource
import signal
import subprocess
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import networks
import takt_system
from takt_system import wait_until

DEVICES = ("robot", "line")


class Log(takt_system.Case):
    def log(self, *arguments, status=0):
        run = self.takt("log", "--json", *arguments)
        self.assertEqual(status, run.status, run.err)
        events = [json.loads(line) for line in run.out.splitlines()]
        for event in events:
            self.assertEqual({"sequence", "time_ns", "cell", "device", "module", "kind", "severity", "error", "cause",
                              "attachment", "count", "cycle"}, set(event))
        for device in {e["device"] for e in events}:
            numbers = [e["sequence"] for e in events if e["device"] == device]
            self.assertEqual(len(set(numbers)), len(numbers), "an event was printed twice: %s" % device)
        times = [e["time_ns"] for e in events]
        self.assertEqual(sorted(times), times, "events out of order")
        return events

    def log_of_both(self):
        """Repeats takt log until it finds both nodes, because takt log may miss a node whose machine stalls."""
        def both():
            events = self.log()
            return events if {e["device"] for e in events} == set(DEVICES) else None
        return wait_until(both, "the records of both devices")

    def file(self, device):
        return os.path.join(self.folder, "state", "%s.%d.faults" % (device, self.domain))

    def of(self, events, kind, module=None, device=None):
        return [e for e in events if e["kind"] == kind and module in (None, e["module"]) and device in (None, e["device"])]

    def crashed(self):
        """Starts both nodes and deploys the cell. Returns when module culprit on robot has crashed and was given up."""
        nodes = self.nodes(*DEVICES)
        self.deploy("crash.xml")
        nodes["robot"].wait_for_line("the host is started again")
        self.wait_for_states({"robot": {"grid": "EXECUTING", "culprit": "DESTRUCT"}})
        return nodes

    def test_the_fault_record_lists_crashes_overruns_and_commands(self):
        begun = time.time_ns()
        began = time.monotonic()
        nodes = self.crashed()
        # Two of these commands are rejected, and one is carried out.
        self.refused({"start robot.culprit": "is not allowed in state DESTRUCT", "stop robot.none": "no module"})
        self.done("stop line.program")
        time.sleep(1.5)
        self.done("undeploy shop")
        seconds = time.monotonic() - began
        events = self.log_of_both()

        crash, = self.of(events, "error", "culprit")
        self.assertEqual(("robot", "shop", "crash", 1), (crash["device"], crash["cell"], crash["error"], crash["count"]))
        self.assertEqual("error", crash["severity"])
        self.assertRegex(crash["cause"], r"^the host was killed by SIGSEGV \(Segmentation fault\) in run\(\), "
                                         r"in \w.* at segv\.cpp:1\d in segv\.so, called by run at segv\.cpp:\d+ in segv\.so \(segv\.so [0-9a-f]{8}\)$|"
                                         r"^the host was killed by SIGSEGV .* in run\(\), in run at segv\.cpp:\d+ in segv\.so \(segv\.so [0-9a-f]{8}\)$")
        self.assertIn(crash["cycle"], (199, 200))
        self.assertLess(begun, crash["time_ns"])
        self.assertLess(crash["time_ns"], time.time_ns())
        self.assertEqual(1, len(self.of(events, "given-up", "culprit")))
        restart, = self.of(events, "host-restart", device="robot")
        self.assertRegex(restart["cause"], r" in segv\.so$")
        refused = self.of(events, "refused-command")
        self.assertEqual({"culprit", "none"}, {e["module"] for e in refused})
        done, = self.of(events, "command", "program")
        self.assertEqual("stop was carried out", done["cause"])
        self.assertEqual({"robot", "line"}, {e["device"] for e in self.of(events, "deployed")})
        self.assertEqual({"robot", "line"}, {e["device"] for e in self.of(events, "undeployed")})
        self.assertEqual({"robot", "line"}, {e["device"] for e in self.of(events, "node-start")})
        overruns = self.of(events, "overrun", "slow")
        self.assertGreater(sum(e["count"] for e in overruns), 0)
        self.assertLessEqual(len(overruns), seconds + 2, "at most one event a second, and one at the end")
        self.end(nodes)

    def test_takt_undeploy_lists_a_module_only_once_even_if_it_failed_twice(self):
        nodes = self.crashed()
        begun = len(nodes["robot"].raw)
        for order in ("reset", "initialize", "start"):
            self.done(order + " robot.culprit")
        nodes["robot"].wait_for_line("robot.culprit: RECOVER -> DESTRUCT", after=begun)
        self.wait_for_states({"robot": {"grid": "EXECUTING", "culprit": "DESTRUCT"}})
        run = self.takt("undeploy", "shop")
        self.assertEqual(0, run.status, run.err)
        self.assertEqual(1, run.err.count("failed earlier: module robot.culprit"), run.err)
        self.end(nodes)

    def test_the_fault_record_and_the_run_report_contain_the_same_counts(self):
        run = self.takt("run", "crash.xml", "--for", "3", "--json", "--state-dir", os.path.join(self.folder, "state"))
        for device in DEVICES:
            events = self.log("--file", self.file(device))
            for name, module in run.modules(device).items():
                counted = sum(e["count"] for e in self.of(events, "overrun", name))
                self.assertEqual(module["overruns"], counted, name)
            missed = sum(e["count"] for e in self.of(events, "missed-rows"))
            self.assertEqual(sum(e["missed"] for e in run.device(device)["executors"]), missed, device)
            self.assertEqual("node-end", events[-1]["kind"])
        self.assertGreater(run.modules("line")["slow"]["overruns"], 0)

    def test_takt_log_prints_only_the_events_that_its_filter_options_select(self):
        nodes = self.crashed()
        self.assertEqual([], [e for e in self.log("line") if e["device"] != "line"])
        self.assertEqual({"culprit"}, {e["module"] for e in self.log("--module", "culprit")})
        self.assertEqual({("robot", "culprit")}, {(e["device"], e["module"]) for e in self.log("robot.culprit")})
        self.assertEqual({"error", "host-restart"}, {e["kind"] for e in self.log("robot", "--kind", "error,host-restart")})
        self.assertEqual(2, len(self.log("--last", "2")))
        self.assertEqual([], self.log("--since", "2100-01-01"))
        self.assertLess(3, len(self.log("--since", "1h")))
        text = self.takt("log", "robot")
        self.assertRegex(text.out, r"(?m)^\d\d\d\d-\d\d-\d\d$")
        self.assertRegex(text.out, r"(?m)^\d\d:\d\d:\d\d\.\d\d\d X robot\.culprit +error$")
        self.assertRegex(text.out, r"segv\.cpp:\d+")
        for line in text.out.splitlines():
            self.assertLessEqual(len(line), 100, line)
        for arguments, pattern in {("--kind", "eror"): "did you mean error", ("--since", "soon"): "10m",
                                   ("--last", "-1"): "last", ("--file", "x", "--follow"): "excludes"}.items():
            run = self.takt("log", *arguments)
            self.assertEqual((2, ""), (run.status, run.out), arguments)
            self.assertRegex(run.err, pattern)
        self.refused({"log --module culprid": "did you mean culprit", "log lime": r"^device lime: error: not found on domain \d+; devices found there: .*; did you mean line\?$",
                      "log robot.culprid": r"device robot has no module 'culprid', .*did you mean culprit\?",
                      "log robot.culprit --module slow": r"^error: both 'robot\.culprit' and --module name a module; leave out one of them$",
                      "log --file /nowhere/x.faults": "/nowhere/x.faults: error: there is no such file"})
        self.end(nodes)

    def test_the_fault_record_survives_a_crash_of_the_host_or_the_node(self):
        nodes = self.crashed()
        begun = len(nodes["robot"].raw)
        nodes["robot"].one("takt-host").kill()
        nodes["robot"].wait_for_line("the host is started again", after=begun)
        before = self.log("robot")
        restarts = self.of(before, "host-restart")
        self.assertEqual(2, len(restarts))
        self.assertIn("SIGKILL", restarts[-1]["cause"])
        nodes["robot"].signal(signal.SIGKILL)
        nodes["robot"].wait()

        # takt log can read the record while the node is dead, and the other node records the loss of the device.
        dead = self.log("--file", self.file("robot"))
        self.assertEqual([], [event for event in before if event not in dead])
        text = self.takt("log", "--file", self.file("robot"), "--kind", "host-restart")
        self.assertEqual(2, text.out.count("host-restart"))
        lost = wait_until(lambda: self.of(self.log("line"), "device-lost"), "line to record the loss of robot")
        self.assertIn("device robot is lost", lost[0]["cause"])
        run = self.takt("log")
        self.assertEqual(1, run.status)
        self.assertRegex(run.err, "device robot: error: it is lost")
        self.assertIn("line", run.out)

        nodes["robot"] = self.node("robot")
        after = self.log("robot")
        self.assertEqual(dead, after[:len(dead)])
        restart, = self.of(after, "node-restart")
        self.assertEqual(max(event["sequence"] for event in dead) + 1, restart["sequence"])
        self.assertIn("did not shut down cleanly", restart["cause"])
        self.end(nodes)
        self.assertEqual("node-end", self.log("--file", self.file("robot"))[-1]["kind"])

    def test_takt_log_prints_all_undamaged_events_of_a_damaged_file(self):
        nodes = self.crashed()
        self.end(nodes)
        path = self.file("robot")
        whole = self.log("--file", path)
        with open(path, "r+b") as file:
            file.seek(4096 + 1024 + 500)
            file.write(b"x")
        run = self.takt("log", "--file", path, "--json")
        self.assertEqual(len(whole) - 1, len(run.out.splitlines()))
        self.assertRegex(run.err, "1 damaged event was left out")
        with open(path, "r+b") as file:
            file.write(b"x")
        self.refused({"log --file " + path: "is not a fault record of this version"})
        node = self.node("robot")
        self.assertIn("it was renamed to", node.err)
        self.assertEqual({"robot"}, {e["device"] for e in self.log()})
        self.end({"robot": node})

    def test_a_node_keeps_running_if_it_cannot_write_its_fault_record(self):
        place = self.write("file", "")
        node = self.node("robot", "--state-dir", os.path.join(place, "folder"))
        self.assertRegex(node.err, "warning: the fault record: .*(Not a directory|File exists); a file stands where a folder is needed: name another folder")
        self.assertEqual(["node-start", "error"], [e["kind"] for e in self.log()])
        self.end({"robot": node})

    def test_the_crash_event_of_a_program_names_its_core_dump(self):
        unlimited = resource.RLIM_INFINITY
        with open("/proc/sys/kernel/core_pattern") as file:
            piped = file.read().startswith("|")

        def crash(name, limit):
            def become():
                resource.setrlimit(resource.RLIMIT_CORE, (limit, resource.getrlimit(resource.RLIMIT_CORE)[1]))
            run = self.takt("run", "program.xml", "--for", "2", "--json", "--state-dir", os.path.join(self.folder, name),
                            become=become)
            events = self.log("--file", os.path.join(self.folder, name, "robot.%d.faults" % self.domain))
            errors = self.of(events, "error", "program")
            self.assertEqual(run.modules()["program"]["errors"], sum(e["count"] for e in errors))
            error = errors[0]
            self.assertIn("SIGSEGV", error["cause"])
            return error

        error = crash("none", 0)
        self.assertIsNone(error["attachment"])
        self.assertIn("no core dump: core_pattern passes core dumps to" if piped else "no core dump: RLIMIT_CORE is 0", error["cause"])
        if piped or resource.getrlimit(resource.RLIMIT_CORE)[1] != unlimited:
            self.skipTest("this system writes no core dumps to files")
        error = crash("some", unlimited)
        self.assertTrue(os.path.isfile(error["attachment"]), error)

    def lines(self, *arguments):
        return [(e["module"], e["kind"], e["cause"], e["cycle"]) for e in self.log("robot", *arguments)
                if e["kind"].startswith("log-")]

    def wait_for_line(self, *wanted):
        """Waits until the record has a line of this module, kind and cause, and returns the cycles of all such lines."""
        return wait_until(lambda: [line[3] for line in self.lines() if line[:3] == wanted], str(wanted))

    def test_takt_log_shows_the_lines_that_modules_log_while_they_run(self):
        nodes = self.nodes("robot")
        begun = time.time_ns()
        self.deploy("lines.xml")
        text = "line 1 of 1 in a period of 0.005 s, as expected"
        self.wait_for_line("cpp", "log-info", "logs every 100 cycles")
        self.assertEqual({0}, {(cycle or 0) % 100 for cycle in self.wait_for_line("cpp", "log-info", text)})
        for module in ("c", "program"):
            cycles = self.wait_for_line(module, "log-warning", "level is at  1.50 of 3")
            self.assertEqual({0}, {(cycle or 0) % 100 for cycle in cycles})
        nodes["robot"].wait_for_line(r"robot\.program: warning: level is at  1\.50 of 3$")
        nodes["robot"].wait_for_line(r"robot\.cpp: info: %s$" % re.escape(text))
        for event in self.log("--kind", "log-info,log-warning"):
            self.assertLess(begun, event["time_ns"])
            self.assertLess(event["time_ns"], time.time_ns())
        shown = self.takt("log", "--kind", "log-warning").out
        self.assertRegex(shown, r"(?m)! robot\.program +log-warning +level is at 1\.50 of 3|level is at  1\.50 of 3")
        self.done("undeploy shop")
        self.end(nodes)

    def test_the_log_level_of_a_module_can_be_changed_while_the_module_runs(self):
        nodes = self.nodes("robot")
        self.deploy("lines.xml")
        self.wait_for_line("program", "log-warning", "level is at  1.50 of 3")
        self.assertEqual(["info"], self.done("get robot.cpp log-level"))
        for module in ("cpp", "c", "program"):
            wait_until(lambda: "log-level" in self.takt("complete", "properties", "", "robot." + module).out.split(), "log-level")
        self.assertFalse([line for line in self.lines() if line[1] == "log-debug"])
        self.refused({"set robot.cpp log-level loud": r"^module robot\.cpp: error: property 'log-level' cannot be 'loud'; .*debug",
                      "set robot.cpp log-levl debug": "has no property 'log-levl'; did you mean log-level",
                      "set robot.program log-levl debug": "declares no properties: it gets them, except log-level, as arguments when it starts"})
        self.assertEqual(["debug", "error"], self.done("set robot.cpp log-level debug", "set robot.program log-level error"))
        self.assertEqual(["debug", "error"], self.done("get robot.cpp log-level", "get robot.program log-level"))
        self.assertRegex(self.done("get robot.program")[0], r"(?m)^log-level +error +")
        wait_until(lambda: [line for line in self.lines() if line[:2] == ("cpp", "log-debug")], "a debug line")
        before = len([line for line in self.lines() if line[0] == "program"])
        time.sleep(1.5)
        self.assertLessEqual(len([line for line in self.lines() if line[0] == "program"]), before + 1)
        self.done("undeploy shop")
        self.end(nodes)

    def test_a_successful_restart_leaves_no_rejected_command_in_the_fault_record(self):
        nodes = self.nodes("robot")
        self.deploy("lines.xml")
        for before in ((), ("destruct",), ("destruct", "reset")):
            for command in before:
                self.done(command + " robot.cpp")
            self.assertEqual(["robot.cpp: EXECUTING"], self.done("restart robot.cpp"))
        commands = [e["cause"].split()[0] for e in self.log("--module", "cpp") if e["kind"].endswith("command")]
        self.assertEqual(3 * ["destruct", "reset", "initialize", "start"], commands)
        self.assertEqual([], self.of(self.log(), "refused-command"))
        self.done("undeploy shop")
        self.end(nodes)

    def test_log_lines_of_a_module_above_the_rate_limit_are_dropped_and_counted(self):
        nodes = self.nodes("robot")
        self.deploy("lines.xml")
        self.done("set robot.cpp lines 500")
        def left_out():
            return [int(cause.split()[0]) for _, kind, cause, _ in self.lines() if "log lines were left out" in cause]
        self.assertGreater(wait_until(left_out, "a count of lost lines")[0], 400)
        time.sleep(3)
        self.assertLess(len(self.lines("--module", "cpp")), 400)
        self.assertEqual({"EXECUTING"}, set(self.states_of("robot").values()))
        self.done("undeploy shop")
        self.end(nodes)

    def test_no_line_of_level_error_is_dropped_while_a_module_logs_too_many_lines_of_level_info(self):
        nodes = self.nodes("robot")
        self.deploy("lines.xml")
        self.done("set robot.cpp lines 500", "set robot.cpp fails true")

        def errors():
            return [(cause, cycle) for module, kind, cause, cycle in self.lines() if (module, kind) == ("cpp", "log-error")]
        wait_until(lambda: len(errors()) >= 6, "six errors")
        cycles = [cycle for _, cycle in errors()]
        self.assertEqual(list(range(cycles[0], cycles[-1] + 1, 100)), cycles)
        self.assertEqual([("failed in release %d" % cycle, cycle) for cycle in cycles], errors()[:len(cycles)])
        counts = [cause for _, _, cause, _ in self.lines() if "left out" in cause]
        self.assertRegex(counts[0], r"^\d+ log lines were left out: \d+ info; a module can log 10 lines of each level per second$")
        self.done("undeploy shop")
        self.end(nodes)

    def test_takt_log_follow_prints_every_event_once(self):
        nodes = self.nodes(*DEVICES)
        follower = self.start("log", "--follow", "--json")
        follower.wait_for_out("node-start")
        self.deploy("crash.xml")
        follower.wait_for_out("host-restart")
        self.done("stop robot.grid")
        follower.wait_for_out("stop was carried out")
        self.done("undeploy shop")
        follower.wait_for_out("undeployed")
        # takt log --follow must print the same events as takt log.
        last = {e["device"]: e for e in self.log_of_both()}

        def told(device):
            return [e for e in [json.loads(line) for _, line in list(follower.out_lines)] if e["device"] == device]
        wait_until(lambda: all(last[device] in told(device) for device in DEVICES), "the last events of both records")
        time.sleep(0.5)  # an event that is printed twice would be printed again in this time
        follower.signal(signal.SIGINT)
        self.assertEqual(0, follower.wait().status, follower.err)
        everything = self.log_of_both()
        self.assertIn("node-start", [e["kind"] for device in DEVICES for e in told(device)])
        for device in DEVICES:
            # takt log --follow prints only events that occur after it finds the device. There may already be newer events in the record.
            seen = told(device)
            since = [e for e in everything if e["device"] == device and e["sequence"] >= seen[0]["sequence"]]
            self.assertEqual(since[:len(seen)], seen)
            self.assertIn("deployed", [e["kind"] for e in seen])
        self.end(nodes)

    def test_a_command_that_prints_until_ctrl_c_ends_with_its_reader(self):
        def ends(command, lines):
            # The reader ends after these lines. Then the command has nothing more to print, so that no write can fail.
            run = self.takt(*command.split(), before=["bash", "-c", 'set -o pipefail; "$0" "$@" | head -n %d' % lines])
            self.assertEqual((141, lines, ""), (run.status, len(run.out_lines), run.err), command)
        ends("watch", 0)
        node = self.node("d")
        self.deploy(os.path.join(os.path.dirname(self.beside(".")), "..", "recording", "source.xml"))
        self.done("stop d")
        ends("log --follow", 1)
        ends("echo d.source.out", 0)
        self.done("undeploy source")
        self.end({"d": node})

    def test_takt_log_follow_begins_with_the_last_events(self):
        node = self.node("robot")
        self.refused({"stop robot.m%d" % n: "robot" for n in range(14)})

        def followed(count, *arguments):
            """Starts takt log --follow, waits until it has printed `count` events, and then causes a new event. Returns all printed
            events."""
            follower = self.start("log", "--follow", "--json", *arguments)
            wait_until(lambda: len(follower.out_lines) >= count, "%d events" % count)
            name = "new%s" % "".join(arguments).replace("-", "")
            self.refused({"stop robot.%s" % name: "robot"})
            follower.wait_for_out(name)
            follower.signal(signal.SIGINT)
            self.assertEqual(0, follower.wait().status, follower.err)
            return [json.loads(line) for line in follower.out.splitlines()]

        self.assertEqual(followed(10), self.log()[-11:])
        self.assertEqual(followed(3, "--last", "3"), self.log()[-4:])
        self.assertEqual(followed(15, "--since", "1h"), self.log())
        self.end({"robot": node})

    def test_takt_log_follow_prints_only_new_events_of_a_node_that_it_finds_late(self):
        node = self.node("robot")
        self.refused({"start robot.one": "robot", "stop robot.two": "robot", "recover robot.three": "robot"})
        self.assertGreater(len(self.log()), 3)
        node.signal(signal.SIGSTOP)
        begun = time.time_ns()
        follower = self.start("log", "--follow", "--json")
        time.sleep(4)  # in this time, takt log finds no node and so reads no record
        self.assertEqual("", follower.out)
        node.signal(signal.SIGCONT)
        self.refused({"stop robot.four": "robot"})
        follower.wait_for_out("four")
        for line in follower.out.splitlines():
            self.assertGreaterEqual(json.loads(line)["time_ns"], begun, line)
        follower.signal(signal.SIGINT)
        follower.wait()
        self.end({"robot": node})


class Cable(networks.NetworkCase):
    MACHINES = DEVICES

    def test_takt_log_reports_an_unreachable_device_that_other_nodes_list(self):
        nodes = self.nodes(*DEVICES)
        self.deploy("cable.xml")
        for machine, other in (("operator", "line"), ("line", "operator")):
            subprocess.run(self.net.on(machine) + ["ip", "route", "add", "blackhole", self.net.address(other)], check=True)
        begun = time.monotonic()
        run = self.takt("log", "--json")
        self.assertEqual({"robot"}, {json.loads(line)["device"] for line in run.out.splitlines()})
        self.assertEqual(1, run.status)
        self.assertRegex(run.err, "(?m)^device line: error: other devices of its cell list it, but this program did not find it; try again")
        self.assertGreater(time.monotonic() - begun, 3, "takt log must wait for the device")
        for machine, other in (("operator", "line"), ("line", "operator")):
            subprocess.run(self.net.on(machine) + ["ip", "route", "del", "blackhole", self.net.address(other)], check=True)
        run = self.takt("log", "--json")
        self.assertEqual((0, ""), (run.status, run.err))
        self.assertEqual(set(DEVICES), {json.loads(line)["device"] for line in run.out.splitlines()})
        self.end(nodes)

    def test_both_devices_record_the_loss_and_return_of_their_network_connection(self):
        nodes = self.nodes(*DEVICES)

        since = {}

        def kinds(device):
            run = self.takt("log", "--json", device, on=device)
            self.assertEqual(0, run.status, run.err)
            return {e["kind"]: e for e in map(json.loads, run.out.splitlines()) if e["sequence"] > since.get(device, -1)}

        def newest(device):
            """Returns the number of the newest event of the device, because a stall of the machine may have caused events before the cable
            is pulled."""
            return max(e["sequence"] for e in kinds(device).values())

        def wait_for(wanted, what):
            for device in DEVICES:
                expected = wanted[0] | (wanted[1] if device == "line" else set())
                seen = wait_until(lambda: [k for k in [kinds(device)] if expected <= set(k)], what + device)[0]
                print(device, {k: e["cause"] for k, e in seen.items() if "-" in k})

        self.deploy("cable.xml")
        time.sleep(1.5)
        since = {device: newest(device) for device in DEVICES}
        self.net.cut("line")
        wait_for(({"device-lost", "connection-lost"}, {"stale-input"}), "the loss to be recorded by ")
        since = {device: newest(device) for device in DEVICES}
        self.net.join("line")
        wait_for(({"device-back", "connection-back"}, {"fresh-input"}), "the return to be recorded by ")
        self.done("undeploy shop")
        self.end(nodes)


if __name__ == "__main__":
    takt_system.main()
