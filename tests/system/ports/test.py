import json
import os
import re
import signal
import sys
import time
import urllib.request

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import wait_until
from terminal import DOWN, ENTER, ESCAPE, Terminal


class Ports(takt_system.Case):
    def seen(self, name):
        return json.loads(self.read(name))

    def port(self, run, module, port):
        return next(p for p in run.modules("d")[module]["ports"] if p["name"] == port)

    def test_every_reader_with_a_sufficient_queue_gets_all_samples_in_order(self):
        run = self.takt("run", "cell.xml", "--for", "3", "--json")
        self.assertEqual(0, run.status, run.err)
        for name in ("objects", "bytes", "events"):
            seen = self.seen(name)
            self.assertGreater(seen["read"], 300, name)
            self.assertEqual((1, 0, 0), (seen["first"], seen["gaps"], seen["wrong"]), name)
        self.assertEqual(0, self.port(run, "bytes", "in")["dropped"])
        slow = self.seen("slow")
        self.assertEqual(0, slow["wrong"])
        self.assertGreater(slow["gaps"], slow["read"])
        self.assertGreater(self.port(run, "slow", "in")["dropped"], 100)

    def test_the_fault_record_shows_once_that_a_queue_began_to_drop_samples(self):
        run = self.start("run", "cell.xml")
        run.wait_for_state("relay", "EXECUTING")
        events = lambda: [json.loads(line) for line in self.takt("log", "--kind", "dropped-samples", "--json").out.splitlines()]
        wait_until(lambda: any(e["module"] == "slow" for e in events()), "the entry")
        time.sleep(2)
        slow = [e for e in events() if e["module"] == "slow"]
        self.assertEqual(1, len(slow), "it drops samples all the time: %s" % slow)
        self.assertEqual("the queue of input 'in' is full and drops its oldest samples", slow[0]["cause"])
        self.assertGreater(slow[0]["count"], 0)
        run.signal(signal.SIGINT)
        self.assertEqual(0, run.wait().status, run.err)

    def judged(self, module, port, device="d"):
        """Returns the judgement of a port in takt status --json: (rating, reason)."""
        for each in self.status_of(device)["modules"]:
            for one in each.get("ports", []):
                if (each["name"], one["name"]) == (module, port):
                    return one.get("rating"), one.get("reason")

    def live(self, descriptor):
        """Returns the rating of each connection in takt graph --live, by the ends of the connection."""
        run = self.takt("graph", descriptor, "--live", "--json")
        self.assertEqual(0, run.status, run.err)
        return {(c["from"], c["to"]): c["health"]["rating"] for c in run.report["connections"] if "health" in c}

    def measures(self):
        """Returns the ratings and reasons that the page of takt web gets once a second, by the number of the connection."""
        web = self.start("web", "--port", "0")
        web.wait_for_out(r"http://\S+")
        with urllib.request.urlopen(web.out.split()[-1] + "api/events", timeout=takt_system.LONG) as events:
            event = None
            for line in events:
                line = line.decode().rstrip("\n")
                event = line[7:] if line.startswith("event: ") else event
                if event == "measures" and line.startswith("data: "):
                    yield {i: (c["rating"], c["reason"]) for i, c in json.loads(line[6:])["connections"].items()}

    def test_a_queue_that_drops_samples_is_amber_everywhere_until_it_has_stopped(self):
        run = self.start("run", "cell.xml")
        run.wait_for_state("slow", "EXECUTING")
        drops = ("poor", "degraded: drops samples")
        wait_until(lambda: self.judged("slow", "in") == drops, "the queue to drop samples")
        self.assertEqual(("good", "ok"), self.judged("bytes", "in"))
        self.assertRegex(self.takt("status").out, r"(?m)^  slow\.in .* ! degraded: drops samples$")
        ratings = self.live("cell.xml")
        self.assertEqual("poor", ratings.pop(("d.source.out", "d.slow.in")))
        self.assertEqual({"good"}, set(ratings.values()))
        self.assertRegex(self.takt("graph", "cell.xml", "--live").out, r"! degraded: drops samples, ")
        page = self.measures()
        wait_until(lambda: next(page).get("4") == drops, "the page to get the judgement")
        terminal = Terminal(30, 100)
        self.addCleanup(terminal.close)
        watch = self.start("watch", terminal=terminal.slave, become=terminal.become, environment={"LC_ALL": "C", "NO_COLOR": ""})
        terminal.wait_for("source")
        terminal.press("c")
        terminal.wait_for(r"d\.slow\.in +! degraded: drops samples, ")

        self.done("stop d.source")
        wait_until(lambda: self.judged("slow", "in") == ("good", "ok"), "the judgement after the last dropped sample")
        self.assertEqual({"good"}, set(self.live("cell.xml").values()))
        wait_until(lambda: next(page).get("4") == ("good", "ok"), "the page to get the new judgement")
        terminal.wait_for(r"d\.slow\.in +\* ok, ")
        terminal.press("q")
        watch.wait()
        run.signal(signal.SIGINT)
        self.assertEqual(0, run.wait().status, run.err)

    def test_what_is_no_fault_now_is_no_alarm(self):
        run = self.start("run", "quiet.xml")
        run.wait_for_state("sink", "EXECUTING")
        wait_until(lambda: self.judged("sink", "in") == ("good", "ok"), "the first value")
        self.assertEqual(("good", "ok: no value yet"), self.judged("alarm", "in"), "its event has never happened")
        self.assertEqual(("good", "no other program reads it"), self.judged("lonely", "out"))
        self.assertEqual({"good"}, set(self.live("quiet.xml").values()))
        self.done("stop d.source")
        wait_until(lambda: self.judged("sink", "in") == ("bad", "stale"), "the value to become stale")
        self.assertEqual("bad", self.live("quiet.xml")[("d.source.out", "d.sink.in")])
        self.done("start d.source")
        wait_until(lambda: self.judged("sink", "in") == ("good", "ok"), "a new value")
        sink = next(m for m in self.status_of("d")["modules"] if m["name"] == "sink")
        self.assertGreater(sink["ports"][0]["late"], 0)
        page = self.measures()
        wait_until(lambda: next(page) == {"0": ("good", "ok"), "1": ("good", "no other program reads it"), "2": ("good", "ok: no value yet")},
                   "the page to show no alarm")
        run.signal(signal.SIGINT)
        self.assertEqual(0, run.wait().status, run.err)

    def test_a_connection_to_a_lost_device_is_red_everywhere(self):
        nodes = self.nodes("robot", "line")
        self.deploy("lost.xml")
        for port in (("source", "out"), ("sink", "in")):
            wait_until(lambda: self.judged(*port, "robot") == ("good", "ok"), "the first value")
        page = self.measures()
        wait_until(lambda: next(page) == {"0": ("good", "ok"), "1": ("good", "ok")}, "the page to show both connections")
        terminal = Terminal(30, 100)
        self.addCleanup(terminal.close)
        watch = self.start("watch", terminal=terminal.slave, become=terminal.become, environment={"LC_ALL": "C", "NO_COLOR": ""})
        terminal.wait_for("robot")
        terminal.press("/robot.source" + ENTER)
        terminal.wait_for("Esc: show all")
        terminal.wait_for("^ +source")
        terminal.press(DOWN)  # from the row of the device
        terminal.wait_for("^> +source")
        terminal.press(ENTER)
        terminal.wait_for(r"out +out .* \* ok, ")

        nodes["line"].kill_all()
        terminal.wait_for("1 LOST")
        def known():
            """The status once the node of robot knows that line is lost: only this node still knows the modules of line."""
            run = self.takt("status")
            return run.out if re.search(r"(?m)^device line  LOST$\n  source +LOST, was EXECUTING$", run.out) else None
        # DDS itself keeps the connections matched for some seconds. A status in which line is lost must not show them as matched.
        status = wait_until(known, "robot to lose line")
        for port in (r"sink\.in +in ", r"source\.out +out"):
            self.assertRegex(status, r"(?m)^  %s +0/1 .* X not matched$" % port)
        graph = self.takt("graph", "lost.xml", "--live").out
        self.assertRegex(graph, r"(?m)^  sink .* LOST, was EXECUTING$")
        self.assertEqual(2, len(re.findall("X NOT MATCHED", graph)), graph)
        wait_until(lambda: next(page) == {"0": ("broken", "not matched"), "1": ("broken", "not matched")}, "the page to show the loss")
        terminal.wait_for(r"out +out .* X NOT MATCHED")
        terminal.press(ESCAPE + "c")
        terminal.wait_for(r"line\.sink\.in +X NOT MATCHED")
        terminal.press("q")
        watch.wait()
        self.takt("undeploy", "lost")
        self.end({"robot": nodes["robot"]})

    def test_a_module_gets_the_events_that_arrived_while_it_was_stopped(self):
        def module(name, filename, operation, time, more=""):
            return ("<module><name>%s</name> <filename>%s</filename> <moduletype>%s</moduletype> <operationtype>%s</operationtype>"
                    "%s <priority>1</priority>%s</module>" % (name, filename, "process" if filename.endswith("exe") else "thread",
                                                              operation, time, more))
        readers = {"object": ("port_events.so", "immediate"), "row": ("port_events.so", "row"),
                   "program": ("port_events_program.exe", "immediate")}
        cell = module("source", "port_source.so", "periodic", "<period>10ms</period>")
        for name, (filename, dispatch) in readers.items():
            cell += module(name, filename, "sporadic", "<deadline>10ms</deadline>", "<dispatch>%s</dispatch>" % dispatch)
        connections = "".join('<connection from="d.source.out" to="d.%s.event" kind="queue" depth="4"/>' % name for name in readers)
        run = self.start("run", self.write("stopped.xml", '<cell name="c"><device name="d">%s</device>%s</cell>' % (cell, connections)))
        for name in readers:
            run.wait_for_state(name, "EXECUTING")

        def counts(name):
            """Returns the number of events that the reader has taken, and the number of samples that the source has written."""
            modules = {m["name"]: m for m in self.status_of("d")["modules"]}
            taken = next(p["samples"] for p in modules[name]["ports"] if p["name"] == "event")
            return taken, next(p["samples"] for p in modules["source"]["ports"] if p["name"] == "out")

        for name in readers:
            self.done("set d.source burst 1")
            wait_until(lambda: counts(name)[0] > 0, "the first event of " + name)
            self.done("stop d." + name)
            taken, written = counts(name)
            wait_until(lambda: counts(name)[1] > written + 8, "more events than the queue holds")
            self.done("set d.source burst 0")
            self.assertEqual(taken, counts(name)[0], "a stopped module reads nothing")
            self.done("start d." + name)
            wait_until(lambda: counts(name)[0] >= taken + 4, "%s to get the events" % name)
            self.assertEqual(taken + 4, counts(name)[0], "the queue holds 4 events")
        run.signal(signal.SIGINT)
        self.assertEqual(0, run.wait().status, run.err)

    def test_a_killed_program_continues_to_pass_on_samples_after_its_restart(self):
        run = self.start("run", "cell.xml", "--json")
        run.wait_for_state("relay", "EXECUTING")
        time.sleep(1)
        begun = len(run.raw)
        os.kill(run.one("port_relay.exe").pid, signal.SIGKILL)
        run.wait_for_line(r"\.relay: RECOVER -> EXECUTING", after=begun)
        time.sleep(1)
        run.signal(signal.SIGINT)
        run.wait()
        self.assertEqual(0, run.status, run.err)
        seen = self.seen("bytes")
        self.assertEqual(0, seen["wrong"])
        # Only samples that the program had read and not yet passed on are lost.
        self.assertLess(seen["gaps"], 20)
        self.assertGreater(seen["last"], 250)
        self.assertEqual((0, 0), (self.seen("objects")["gaps"], self.seen("objects")["wrong"]))

    def test_takt_echo_does_not_count_as_a_connection_of_the_port_that_it_reads(self):
        run = self.start("run", "cell.xml", "--json")
        run.wait_for_state("relay", "EXECUTING")
        output = lambda: next(p for m in self.status_of("d")["modules"] if m["name"] == "source" for p in m["ports"] if p["name"] == "out")
        before = output()["connections"]
        self.assertGreater(before, 0)
        echo = self.start("echo", "d.source.out")
        echo.wait_for_out("number")
        wait_until(lambda: output()["samples"] > 1000, "the node to check the port several times")
        self.assertEqual((before, before), (output()["connections"], output()["matched"]))
        echo.signal(signal.SIGINT)
        echo.wait()
        time.sleep(1)  # a wrong report would appear in this time
        self.assertEqual(([""], before), (self.done("log --kind connection-lost --json"), output()["matched"]))
        run.signal(signal.SIGINT)
        run.wait()
        self.assertEqual(0, run.status, run.err)

    def test_a_property_can_define_which_ports_a_program_has(self):
        run = self.takt("run", "named.xml", "--for", "3", "--json")
        self.assertEqual(0, run.status, run.err)
        self.assertEqual(["b"], [p["name"] for p in run.modules("d")["first"]["ports"] if p["samples"] > 50])
        self.assertEqual(["c"], [p["name"] for p in run.modules("d")["second"]["ports"] if p["samples"] > 50])
        out, = self.done("describe --json port_named.exe ports=x,y")
        self.assertEqual(["x", "y"], [p["name"] for p in json.loads(out)["ports"]])

    def test_takt_check_reports_the_line_of_each_property_error_of_a_program(self):
        with open(self.beside("named.xml")) as file:
            text = file.read()
        wrong = self.write("wrong.xml", text.replace(">c<", "><").replace(">a,b<", ">a<"))
        run = self.takt("check", wrong)
        self.assertEqual(1, run.status)
        self.assertRegex(run.err, r"wrong.xml:13: error: module second: property 'ports' is missing; name the ports")
        self.assertRegex(run.err, r"wrong.xml:11: error: module second: there is nothing to do\n")
        self.assertRegex(run.err, r"wrong.xml:21: error: .*first has no port")
        self.refused({"describe port_named.exe": r"property 'ports' is missing; name the ports",
                      "describe port_named.exe ports=": r"property 'ports' is missing; name the ports",
                      "describe port_named.exe ports=a,a": r"the program has two ports 'a'",
                      "describe port_sink.so file=x": r"cannot depend on properties, because it is not a program"})


if __name__ == "__main__":
    takt_system.main()
