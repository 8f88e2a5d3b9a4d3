import json
import os
import signal
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import wait_until

FIVE = "number=5 same=[5,5,5,5,5,5] --timeout 10"


class Services(takt_system.Case):
    def seen(self, name):
        return json.loads(self.read(name))

    def running(self, descriptor):
        """Starts the cell and waits until a service and a client are EXECUTING. Returns the run."""
        run = self.start("run", descriptor, "--json")
        for module in ("answers", "near"):
            run.wait_for_state(module, "EXECUTING")
        return run

    def ended(self, run, status=0):
        run.signal(signal.SIGINT)
        run.wait()
        self.assertEqual(status, run.status, run.err)

    def test_every_client_of_a_service_gets_its_own_replies(self):
        run = self.running("cell.xml")
        run.wait_for_state("far", "EXECUTING")
        time.sleep(3)
        self.assertEqual(["number: 10\nsame: [10,10,10,10,10,10]\nfew: []"], self.done("call serve.answers.handled " + FIVE))
        reply = json.loads(self.done("call serve.answers.polled --json " + FIVE)[0])
        self.assertEqual({"number": 10, "same": [10] * 6, "few": []}, reply["reply"])
        self.assertGreater(reply["ms"], 0)
        self.done(*["call ask.relay.pass " + FIVE] * 4)
        self.ended(run)
        for name in ("near", "near_polled", "far", "far_polled", "through"):
            seen = self.seen(name)
            print("%s: %s" % (name, seen))
            self.assertEqual(0, seen["wrong"], name)
            self.assertGreater(seen["replied"], 50, name)
            self.assertGreater(seen["refused"], 5, name)
            self.assertLess(seen["timed_out"], 10, name)
        self.assertRegex(self.seen("near")["refusal"], "^a multiple of 7; ask for another$|^the handler threw: a multiple of 11$")
        self.assertEqual("a multiple of 7", self.seen("through")["refusal"])

    def test_takt_call_reports_wrong_names_and_values(self):
        run = self.running("cell.xml")
        run.wait_for_state("relay", "EXECUTING")
        self.done("call serve.answers.handled " + FIVE)
        def complete():  # on a busy machine, it gives up before it has heard of the devices
            names = set(self.takt("complete", "services").out.split())
            return names if {"serve.answers.handled", "serve.answers.polled"} <= names else None
        offered = wait_until(complete, "the services of the cell")
        self.assertFalse([name for name in offered if name.count(".") != 2 or name.endswith(".ask")], offered)
        self.refused({
            "call serve.answers": r"serve\.answers is a module, not a service; services of the module: serve\.answers\.handled",
            "call serve": "'serve' is not the name of a service; write DEVICE.MODULE.SERVICE",
            "call serve.answers.handle": "module serve.answers has no service 'handle'; did you mean serve.answers.handled",
            "call serve.near.nothing": r"module serve\.near has no service 'nothing'; services of other modules: serve\.answers\.handled",
            "call serve.near": r"module serve\.near has no services; services of other modules: serve\.answers\.handled",
            "call srve.answers.handled": r"^device srve: error: not found on domain \d+; devices found there: ask, serve; did you mean "
                                         r"serve\.answers\.handled\?$",
            "call serve.near.ask": "'ask' of module serve.near is a client and cannot be called",
            "call serve.answers.handled nummer=5": "samples::Count: error: has no field 'nummer'; did you mean number",
            "call serve.answers.handled number": "'number' does not have the form field=value; write field=value",
            "call serve.answers.handled number=five": "samples::Count.number: error: cannot be \"five\"; write a whole number",
            "call serve.answers.handled number=1 number=2": "samples::Count.number: error: is given twice",
            "call serve.answers.handled few=[1,2,3,4,5]": "samples::Count.few: error: .*write a list of length at most 4",
            "call serve.answers.handled '{\"number\": }'": "the sample is not JSON",
            "call serve.answers.handled --timeout 10": "serve.answers.handled rejected the request: a multiple of 7",
            "call serve.answers.handled --timeout 10 number=11 same=[11,11,11,11,11,11] few=[11]":
                "serve.answers.handled rejected the request: the handler threw: a multiple of 11",
            "call nobody.answers.handled": "nobody",
            "record serve.answers.handled --out none.takt --for 6":
                "waits for serve.answers.handled: it is a service; record the client's NAME/request and NAME/reply",
        })
        self.assertEqual(2, self.takt("call", "serve.answers.handled", "--timeout", "0").status)
        self.done("stop serve.answers")
        self.refused({"call serve.answers.handled":
                      "module serve.answers is in START, but answers only in EXECUTING; run takt start serve.answers",
                      "echo serve.answers.handled": "serve.answers"})
        begun = len(run.raw)
        self.done("start serve.answers")
        run.wait_for_line("answers: START -> EXECUTING", after=begun)
        self.done("call serve.answers.handled " + FIVE)
        self.ended(run)
        seen = self.seen("near")
        print("stopped for a while: %s" % seen)
        self.assertEqual(0, seen["wrong"])
        # While the module was stopped, calls to the service with a handler were rejected. Calls to the service without a handler timed out
        # or were answered late, by run().
        self.assertGreater(seen["refused"], 20)

    def test_a_service_answers_new_requests_after_a_restart_of_its_host(self):
        nodes = self.nodes("serve", "ask")
        self.deploy("cell.xml")
        for module in ("far", "far_polled"):
            nodes["ask"].wait_for_state(module, "EXECUTING")
        time.sleep(1)
        begun = len(nodes["serve"].raw)
        nodes["serve"].one("takt-host").kill()
        nodes["serve"].wait_for_line(r"\.answers: START -> EXECUTING", after=begun)
        self.done("call serve.answers.handled " + FIVE, "call serve.answers.polled " + FIVE)
        time.sleep(1)
        self.done("undeploy services")
        for name in ("far", "far_polled"):
            seen = self.seen(name)
            print("%s: %s" % (name, seen))
            self.assertEqual(0, seen["wrong"], name)
            self.assertGreater(seen["replied"], 50, name)
        self.end(nodes)

    def test_a_client_gets_no_wrong_reply_after_the_node_of_the_service_is_killed(self):
        nodes = self.nodes("serve", "ask")
        self.deploy("cell.xml")
        nodes["ask"].wait_for_state("far", "EXECUTING")
        time.sleep(1)
        nodes["serve"].kill_all()
        time.sleep(5)
        self.runs.remove(nodes["serve"])
        undeploy = self.takt("undeploy", "services")
        self.assertEqual((1, "cell services is undeployed from ask\n"), (undeploy.status, undeploy.out))
        self.assertIn("device serve: error: it is lost and did not receive the command", undeploy.err)
        seen = self.seen("far")
        print("far: %s" % seen)
        self.assertEqual(0, seen["wrong"])
        self.assertGreater(seen["nobody"], 100)
        self.end({"ask": nodes["ask"]})

    @takt_system.timing("the other clients must get their replies within a second while a handler hangs")
    def test_a_service_handler_that_hangs_ends_only_its_own_module(self):
        run = self.running("hang.xml")
        run.wait_for_line("answers: EXECUTING -> RECOVER .*the handler of a service did not return within 5 s")
        run.wait_for_state("answers", "DESTRUCT")
        self.refused({"call serve.answers.handled": "module serve.answers is in DESTRUCT"})
        self.done("call serve.others.handled " + FIVE)
        self.done("reset serve.answers")
        self.done("initialize serve.answers")
        self.done("start serve.answers")
        self.done("call serve.answers.handled " + FIVE)
        run.signal(signal.SIGINT)
        run.wait()
        near, other = self.seen("near"), self.seen("other")
        print("near: %s\nother: %s" % (near, other))
        self.assertGreater(near["timed_out"], 10)
        self.assertEqual((0, 0), (near["wrong"], other["wrong"]))
        self.assertLess(other["timed_out"], 5)
        self.assertGreater(other["replied"], 100)

    def test_a_service_handler_that_crashes_ends_only_its_own_module(self):
        run = self.running("crash.xml")
        run.wait_for_line("the host .*in the handler of a service")
        run.wait_for_state("answers", "DESTRUCT")
        wait_until(lambda: run.states("others").count("EXECUTING") == 2, "module others to execute again")
        self.done("call serve.others.handled " + FIVE)
        run.signal(signal.SIGINT)
        run.wait()
        self.assertEqual(0, self.seen("other")["wrong"])

    def test_takt_check_reports_errors_in_service_elements(self):
        check = self.takt("check", "bad.xml")
        self.assertEqual(1, check.status)
        for line, what in {
            20: "client d.asks.ask has requests of type samples::Count, but those of service d.belt.count have type basic::Count; "
                "connect a client and a service that have the same request and reply types",
            21: "module d.answers has no service 'handle'; did you mean handled",
            22: "'handled' of module d.answers is a service, not a client",
            23: "'command' of module d.belt is a port, not a client",
            24: "'ask' of module d.asks is a client, not a port; connect it with <service",
        }.items():
            self.assertRegex(check.err, r"bad\.xml:%d: error: .*%s" % (line, what.replace("(", r"\(")))


if __name__ == "__main__":
    takt_system.main()
