import http.client
import json
import os
import re
import signal
import socket
import sys
import threading
import time
import urllib.error
import urllib.parse
import urllib.request

from prometheus_client.parser import text_string_to_metric_families

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import wait_until


class Events:
    """Reads the stream of events, and derives the current states from it as the web page does."""

    def __init__(self, address):
        self.response = urllib.request.urlopen(address + "api/events", timeout=takt_system.LONG)
        self.all = []  # (name, data, when)
        self.ended = False
        self.modules = {}
        self.devices = {}
        self.steps = []
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self):
        name = None
        try:
            for line in self.response:
                line = line.decode().rstrip("\n")
                if line.startswith("event: "):
                    name = line[7:]
                elif line.startswith("data: "):
                    self._take(name, json.loads(line[6:]))
        except (OSError, ValueError, AttributeError, http.client.HTTPException):
            pass
        self.ended = True

    def _take(self, name, data):
        self.all.append((name, data, time.monotonic()))
        if name != "state":
            return
        if data["whole"]:
            self.modules, self.devices = {}, {}
        for known, news in ((self.modules, data["modules"]), (self.devices, data["devices"])):
            for one in news:
                if one.get("gone"):
                    known.pop(one["name"], None)
                else:
                    known[one["name"]] = one
        self.steps += [(m["name"], m["state"], m["sequence"]) for m in data["modules"] if not m.get("gone")]

    def of(self, name):
        return [data for n, data, _ in list(self.all) if n == name]

    def states(self):
        return {name: m["state"] for name, m in dict(self.modules).items()}

    def wait(self, condition, what="an event"):
        return wait_until(lambda: condition(self), what)

    def close(self):
        self.response.close()


class Gateway(takt_system.Case):
    def web(self, *arguments):
        run = self.start("web", "--port", "0", *arguments)
        run.wait_for_out(r"^domain \d+ is shown at http://\S+/$")
        self.address = re.search(r"http://\S+/", run.out).group()
        token = re.search(r"#token=([0-9a-f]+)$", run.out, re.M)
        self.token = token.group(1) if token else None
        return run

    def ask(self, path, body=None, method=None, token=None, headers=()):
        """Sends a request. Returns the HTTP status and the JSON object of the reply."""
        request = urllib.request.Request(self.address + path, method=method,
                                         data=None if body is None else body if isinstance(body, bytes) else json.dumps(body).encode())
        if token:
            request.add_header("Authorization", "Bearer " + token)
        for name, value in headers:
            request.add_header(name, value)
        try:
            with urllib.request.urlopen(request, timeout=takt_system.LONG) as response:
                return response.status, json.loads(response.read())
        except urllib.error.HTTPError as error:
            return error.code, json.loads(error.read())

    def events(self):
        events = Events(self.address)
        self.addCleanup(events.close)
        return events

    def cell(self, *web):
        self.running = self.nodes("left", "right")
        self.deploy("cell.xml")
        self.wait_for_states({"left": "EXECUTING", "right": "EXECUTING"})
        return self.web(*web)

    def finish(self, run):
        run.signal(signal.SIGINT)
        self.assertEqual(0, run.wait().status, run.err)
        self.assertEqual("", run.err)
        self.takt("undeploy", "seen")
        self.end(self.running)

    def test_the_gateway_streams_the_states_that_nodes_publish(self):
        run = self.web()
        events = self.events()
        events.wait(lambda e: e.of("cell"))
        self.assertIsNone(events.of("cell")[0]["cell"])
        self.running = self.nodes("left", "right")
        events.wait(lambda e: {d["state"] for d in e.devices.values()} == {"waiting"} and len(e.devices) == 2)
        self.deploy("cell.xml")
        names = {"left.source", "left.fails", "right.sink", "right.live", "right.program"}
        events.wait(lambda e: e.states() == {name: "EXECUTING" for name in names})
        for name in names:  # the stream must contain every transition
            self.assertEqual([(s, n) for m, s, n in events.steps if m == name][-3:],
                             [("INITIALIZE", 1), ("START", 2), ("EXECUTING", 3)], name)
        cell = events.wait(lambda e: e.of("cell")[-1] if e.of("cell")[-1]["cell"] == "seen" else None)
        self.assertEqual([["source", "fails"], ["source"], ["source"], ["source"], ["source"]],
                         cell["devices"][0]["executors"][0]["rows"])
        self.assertIn('data-module="right.sink"', cell["graph"])
        events.wait(lambda e: e.of("measures") and e.of("measures")[-1]["modules"].get("left.source", {}).get("cycles", 0) > 500)
        events.wait(lambda e: e.of("measures")[-1]["connections"].get("0", {}).get("matched"))

        # The stream must soon show a command of another operator, a fault, a crash of a host, and the loss of a device.
        began = time.monotonic()
        self.done("stop right.live")
        events.wait(lambda e: e.states()["right.live"] == "START")
        print("the stream showed a stop at most %.0f ms after takt stop began" % ((time.monotonic() - began) * 1e3))
        self.done("set left.fails after 1")
        events.wait(lambda e: e.states()["left.fails"] == "RECOVER")
        self.assertIn("as it was asked to", events.modules["left.fails"]["text"])
        events.wait(lambda e: any(f["kind"] == "error" and f["module"] == "fails" for f in self.faults(e)))
        self.running["left"].one("takt-host").kill()
        events.wait(lambda e: any(f["kind"] == "host-restart" for f in self.faults(e)))
        events.wait(lambda e: e.devices["left"]["host_restarts"] == 1)
        self.running["right"].signal(signal.SIGKILL)
        events.wait(lambda e: not e.devices["right"]["alive"])
        self.assertEqual("EXECUTING", events.states()["right.sink"], "the last known state must remain")
        # A new stream must show the same states.
        other = self.events()
        other.wait(lambda e: e.of("faults"))
        self.assertEqual(events.devices["right"], other.devices["right"])
        self.assertEqual(events.states(), other.states())
        self.assertEqual("seen", other.of("cell")[0]["cell"])
        self.running["right"].wait()
        self.running["right"] = self.node("right", "--resume")
        events.wait(lambda e: e.devices["right"]["alive"] and e.states().get("right.sink") == "EXECUTING")
        self.wait_for_states({"right": {"sink": "EXECUTING"}})
        self.done("undeploy seen")
        events.wait(lambda e: not e.modules and e.of("cell")[-1]["cell"] is None)
        self.finish(run)
        events.wait(lambda e: e.ended, what="the end of the stream")

    def faults(self, events):
        """Returns the faults in the order in which the page lists them."""
        told = events.of("faults")
        last = max((i for i, data in enumerate(told) if data["whole"]), default=0)
        return [f for data in told[last:] for f in data["events"]]

    def test_the_gateway_rejects_a_token_file_that_another_user_can_replace(self):
        shared = os.path.join(self.folder, "shared")
        os.mkdir(shared)
        token = self.write("shared/token", "0123456789abcdef0123456789abcdef\n")
        os.chmod(token, 0o600)
        link = os.path.join(self.folder, "link")
        os.symlink(token, link)

        def refused(pattern):
            for path in (token, link):
                run = self.takt("web", "--port", "0", "--token-file", path)
                self.assertEqual(1, run.status, run.out)
                self.assertRegex(run.err, pattern)
        os.chmod(shared, 0o777)
        refused("everybody may write to %s " % shared)
        os.chmod(shared, 0o755)
        if os.getuid() == 0:
            os.chown(token, 12345, -1)
            refused("%s belongs to user 12345, who can replace it" % token)
            os.chown(token, 0, -1)
        self.finish_web(self.web("--token-file", link))

    def finish_web(self, run):
        run.signal(signal.SIGINT)
        self.assertEqual((0, ""), (run.wait().status, run.err))

    def test_the_gateway_accepts_commands_only_with_the_token(self):
        run = self.cell()
        self.assertIsNone(self.token)
        stop = {"device": "right", "module": "live", "verb": "stop"}
        for token in (None, "guess"):
            status, said = self.ask("api/command", stop, token=token)
            self.assertEqual(403, status)
            self.assertRegex(said["what"], "without --commands")
        self.assertEqual((200, {"command": False}), (lambda s, j: (s, {"command": j["command"]}))(*self.ask("api/rights")))
        run.signal(signal.SIGTERM)
        self.assertEqual(0, run.wait().status)
        run = self.web("--commands")
        for token in (None, "guess", self.token[:-1], self.token + "0"):
            self.assertEqual(403, self.ask("api/command", stop, token=token)[0], token)
            self.assertEqual(403, self.ask("api/property", {"module": "right.live", "property": "step", "value": "7"}, token=token)[0])
        self.assertEqual("EXECUTING", self.states_of("right")["live"])
        self.assertTrue(self.ask("api/rights", token=self.token)[1]["command"])
        self.assertEqual((200, "START"), (lambda s, j: (s, j["state"]))(*self.ask("api/command", stop, token=self.token)))
        self.assertEqual("START", self.states_of("right")["live"])
        # The node must reject the command and give the reason.
        status, said = self.ask("api/command", stop, token=self.token)
        self.assertEqual(409, status)
        self.assertRegex(said["what"], "stop is not allowed in state START")
        status, said = self.ask("api/command", {"device": "nobody", "verb": "stop"}, token=self.token)
        self.assertEqual(504, status)
        self.assertIn("nobody", said["what"])
        self.assertEqual(200, self.ask("api/command", {"device": "right", "module": "live", "verb": "start"}, token=self.token)[0])
        self.wait_for_states({"right": "EXECUTING"})

        properties = {p["name"]: p for p in self.ask("api/properties?module=right.live")[1]["properties"]}
        self.assertEqual(("1", "mm", 1, 1000), tuple(properties["step"][k] for k in ("value", "unit", "min", "max")))
        self.assertEqual((200, {"value": "7"}), self.ask("api/property", {"module": "right.live", "property": "step", "value": "7"}, token=self.token))
        self.assertEqual(["7"], self.done("get right.live step"))
        status, said = self.ask("api/property", {"module": "right.live", "property": "step", "value": "0"}, token=self.token)
        self.assertEqual(409, status)
        self.assertRegex(said["what"], "1 to 1000|at least 1|less than")
        # The gateway must reject a value that does not fit into a command, and not shorten it.
        status, said = self.ask("api/property", {"module": "right.live", "property": "step", "value": "8" + " " * 255}, token=self.token)
        self.assertEqual((400, "give a value of at most 255 bytes"), (status, said.get("fix")), said)
        self.assertEqual(["7"], self.done("get right.live step"))
        # A program answers for its own properties, including those that the descriptor does not set. No request is rejected.
        before = self.done("log --json --kind refused-command")[0].count("refused-command")
        properties = {p["name"]: p["value"] for p in self.ask("api/properties?module=right.program")[1]["properties"]}
        self.assertEqual({"gain": "2.5", "label": "none", "log-level": "info"}, properties)
        self.assertEqual(["2.5", "none"], self.done("get right.program gain", "get right.program label"))
        self.assertEqual(before, self.done("log --json --kind refused-command")[0].count("refused-command"))
        self.assertEqual((200, {"value": "3"}), self.ask("api/property", {"module": "right.program", "property": "gain", "value": "3"}, token=self.token))
        properties = {p["name"]: p["value"] for p in self.ask("api/properties?module=right.program")[1]["properties"]}
        self.assertEqual({"gain": "3", "label": "none", "log-level": "info"}, properties)
        self.finish(run)

    def test_a_command_is_answered_while_fifty_clients_read_the_events_of_the_gateway(self):
        run = self.cell("--commands")
        viewers = [self.events() for _ in range(50)]
        for viewer in viewers:
            stream = viewer.wait(lambda e: e.of("stream"))[0]["id"]
            self.assertEqual((200, {"problems": []}), self.ask("api/streams/%s/ports" % stream, {"ports": ["left.source.out"]}, "PUT"))
        took = []
        for verb, state in (("stop", "START"), ("start", "EXECUTING")) * 20:
            began = time.monotonic()
            status, said = self.ask("api/command", {"device": "right", "module": "live", "verb": verb}, token=self.token)
            took.append((time.monotonic() - began) * 1e3)
            self.assertEqual(200, status, said)
            for viewer in viewers:
                viewer.wait(lambda e: e.states()["right.live"] == state)
        took.sort()
        print("from a command until the answer, with fifty clients: %d commands, ms: p50 %.0f, p99 %.0f, longest %.0f"
              % (len(took), took[len(took) // 2], took[len(took) * 99 // 100], took[-1]))
        self.assertEqual([], [viewer for viewer in viewers if viewer.ended])
        self.finish(run)

    def test_a_web_client_can_request_port_values_executor_tables_and_history(self):
        run = self.cell()
        events = self.events()
        stream = events.wait(lambda e: e.of("stream"))[0]["id"]
        path = "api/streams/%s/ports" % stream
        self.assertEqual((200, {"problems": []}), self.ask(path, {"ports": ["left.source.out"]}, "PUT"))
        about = events.wait(lambda e: e.of("port"))[0]
        self.assertEqual("samples::Count", about["type"])
        self.assertEqual([{"name": "number"}, {"name": "same[0]", "unit": "mm"}], about["fields"][:2])

        def numbers():
            return [n for p in events.of("points") for n in p["values"][0]]
        events.wait(lambda e: len(numbers()) > 60)
        self.assertEqual(sorted(numbers()), numbers())
        times = [t for p in events.of("points") for t in p["times_ms"]]
        self.assertEqual(sorted(set(times)), times)
        for begin in times:
            self.assertLessEqual(sum(1 for time in times if begin <= time < begin + 1000), 2 * (51 + 11), "two values per interval and event")
        self.assertTrue(any(b - a < 19 for a, b in zip(times, times[1:])), "the minimum and the maximum of an interval")
        self.assertEqual([True] + [False] * (len(events.of("points")) - 1), [p["whole"] for p in events.of("points")])
        same = [v for p in events.of("points") for v in p["values"][1]]
        self.assertEqual(numbers()[:len(same)], same[:len(numbers())], "all fields must be of the same sample")
        # A stream that is opened later must get the earlier values too.
        other = self.events()
        later = other.wait(lambda e: e.of("stream"))[0]["id"]
        self.ask("api/streams/%s/ports" % later, {"ports": ["left.source.out"]}, "PUT")
        first = other.wait(lambda e: e.of("points"))[0]
        self.assertTrue(first["whole"])
        self.assertGreaterEqual(len(first["times_ms"]), 60)
        # A list that names a port again sends no value twice, unless the request asks for all its values.
        self.ask(path, {"ports": ["left.source.out"]}, "PUT")
        before = len(events.of("points"))
        events.wait(lambda e: len(e.of("points")) > before + 2)
        self.assertEqual([True] + [False] * (len(events.of("points")) - 1), [p["whole"] for p in events.of("points")])
        self.assertEqual(1, len(events.of("port")))
        self.ask(path, {"ports": ["left.source.out"], "again": ["left.source.out"]}, "PUT")
        again = events.wait(lambda e: [p for p in e.of("points") if p["whole"]][1:])[0]
        self.assertEqual(numbers()[:20], again["values"][0][:20])
        self.assertEqual(2, len(events.of("port")))
        # A new list of ports replaces the old list. The gateway must report each wrong port.
        status, said = self.ask(path, {"ports": ["left.source.ouy", "left.nobody.out", "x"]}, "PUT")
        self.assertEqual(200, status)
        self.assertEqual(["left.source.ouy", "left.nobody.out", "x"], [p["port"] for p in said["problems"]])
        self.assertRegex(said["problems"][0]["what"], "no port")
        for wrong in ({}, [], 5, {"ports": [5]}, {"ports": ["a.b.c"] * 33}, b"nonsense"):
            self.assertEqual(400, self.ask(path, wrong, "PUT")[0], wrong)
        self.assertEqual(404, self.ask("api/streams/0123/ports", {"ports": []}, "PUT")[0])

        ports = {p["name"]: p for p in self.ask("api/ports?device=left")[1]["ports"]}
        self.assertEqual({"name": "left.source.out", "direction": "out", "type": "samples::Count"}, ports["left.source.out"])

        def table():
            executors = self.ask("api/table?device=left")[1].get("executors", [])
            return executors if executors and len(executors[0]["rows"]) == 5 else None
        main, = wait_until(table, "a macro period without a missed row")
        self.assertEqual((2000000, 10000000), (main["basic_period_ns"], main["macro_period_ns"]))
        self.assertEqual([0, 1, 2, 3, 4], [row["row"] for row in main["rows"]])
        self.assertEqual(["source", "fails"], [r["module"] for r in main["rows"][0]["runs"]])
        for row in main["rows"]:
            self.assertEqual(row["row"] * 2000000, row["due_ns"])
            self.assertLessEqual(row["due_ns"], row["begin_ns"])
            for run_of in row["runs"]:
                self.assertLessEqual(row["begin_ns"], run_of["begin_ns"])
                self.assertLessEqual(run_of["begin_ns"], run_of["end_ns"])
                self.assertLessEqual(run_of["end_ns"], row["end_ns"])
        def recent(of):
            seen = [m["modules"].get("left.source", {}) for m in of.of("measures")]
            return [m["recent_us"]["jitter"] for m in seen if "recent_us" in m] or [None]
        events.wait(lambda e: recent(e)[-1] is not None and recent(e)[-1] >= 0)
        late = self.events()
        trend = late.wait(lambda e: e.of("trends"))[0]["jitter_us"]["left.source"]
        self.assertGreater(len(trend), 1)
        self.assertLessEqual(set(trend) - {None}, set(recent(events) + recent(late)), "the trend must have the same values")
        history = wait_until(lambda: (lambda h: h if len(h["times_ms"]) >= 3 else None)(
            self.ask("api/history?module=left.source")[1]), "three seconds of history")
        self.assertEqual({len(history["times_ms"])}, {len(values) for values in history.values()})
        self.assertEqual([], self.ask("api/history?module=left.nobody")[1]["times_ms"])
        self.finish(run)

    def test_a_web_client_can_request_only_the_newest_values_of_ports(self):
        run = self.cell()
        events = self.events()
        path = "api/streams/%s/ports" % events.wait(lambda e: e.of("stream"))[0]["id"]
        status, said = self.ask(path, {"newest": ["left.source.out", "left.source.ouy"]}, "PUT")
        self.assertEqual((200, ["left.source.ouy"]), (status, [p["port"] for p in said["problems"]]))

        def numbers():
            return [int(re.fullmatch(r"(\d+) \+\d+", e["values"]["left.source.out"])[1]) for e in events.of("newest")]
        events.wait(lambda e: len(numbers()) >= 3)
        self.assertEqual(sorted(set(numbers())), numbers())
        self.assertEqual([], events.of("points"), "no history is collected")
        # A list that is not given stays.
        self.assertEqual((200, {"problems": []}), self.ask(path, {"ports": ["left.source.out"]}, "PUT"))
        seen = len(numbers())
        events.wait(lambda e: e.of("points") and len(numbers()) > seen)
        self.assertEqual((200, {"problems": []}), self.ask(path, {"newest": []}, "PUT"))
        points = len(events.of("points"))
        events.wait(lambda e: len(e.of("points")) > points)
        self.assertEqual(400, self.ask(path, {"newest": ["a.b.c"] * 501}, "PUT")[0])
        self.finish(run)

    def test_a_web_client_can_request_the_graph_with_collapsed_devices(self):
        run = self.cell()
        wait_until(lambda: self.ask("api/graph")[0] == 200, "the graph")
        self.assertEqual(5, self.ask("api/graph")[1]["graph"].count("data-module="))
        graph = self.ask("api/graph?collapsed=left,nothing")[1]["graph"]
        self.assertEqual(3, graph.count("data-module="))
        self.assertIn("to right", graph)
        self.finish(run)

    def test_the_gateway_follows_the_update_and_undeployment_of_a_cell(self):
        run = self.cell()
        spare = self.node("spare")
        events = self.events()
        stream = events.wait(lambda e: e.of("stream"))[0]["id"]
        self.ask("api/streams/%s/ports" % stream, {"ports": ["left.source.out"]}, "PUT")
        events.wait(lambda e: e.of("points"))
        events.wait(lambda e: e.of("cell")[-1]["cell"] == "seen" and e.devices.get("spare"))
        with urllib.request.urlopen(self.address + "metrics", timeout=takt_system.LONG) as response:
            self.assertIn('takt_faults_total{device="spare",severity="error"} 0\n', response.read().decode())
        cells = len(events.of("cell"))
        ports = len(events.of("port"))
        # The update changes the connection from a queue to the latest value, so the topic of the port gets another QoS.
        with open(self.beside("cell.xml")) as file:
            text = file.read().replace('kind="queue" depth="100"', 'kind="latest" deadline="1000000000"')
        self.done("deploy %s --update" % self.write("other.xml", text))
        events.wait(lambda e: len(e.of("cell")) > cells)
        self.assertEqual("seen", events.of("cell")[-1]["cell"])
        self.assertNotEqual(events.of("cell")[cells - 1]["graph"], events.of("cell")[-1]["graph"])
        events.wait(lambda e: len(e.of("port")) > ports, "the changed port")
        told = len(events.of("points"))
        events.wait(lambda e: len(e.of("points")) > told + 3, what="values of the changed port")
        self.assertTrue(any(p["whole"] for p in events.of("points")[1:]), "the values must begin anew")
        # The loss of a node that does not belong to the cell must not delay anything.
        spare.signal(signal.SIGKILL)
        events.wait(lambda e: not e.devices["spare"]["alive"])
        self.done("undeploy seen")
        events.wait(lambda e: e.of("cell")[-1]["cell"] is None)
        spare.wait()
        self.runs.remove(spare)
        self.finish(run)

    def test_the_gateway_counts_only_faults_that_occur_after_it_finds_the_node(self):
        node = self.node("left")
        self.refused({"stop left.before": "left"})
        node.signal(signal.SIGSTOP)
        run = self.web()
        events = self.events()
        events.wait(lambda e: e.of("faults"))
        time.sleep(2)
        node.signal(signal.SIGCONT)
        events.wait(lambda e: any(f["module"] == "before" for f in self.faults(e)))
        self.refused({"stop left.after": "left"})
        events.wait(lambda e: any(f["module"] == "after" for f in self.faults(e)))
        told = [f["sequence"] for f in self.faults(events)]
        self.assertEqual(sorted(set(told)), told, "each event must be listed once")
        self.assertEqual((200, {"events": [], "older": 0, "complete_since_ms": 0}), self.ask("api/faults?before=1"), "there are no older events")
        for wrong in ("", "x", "-1", "1 "):
            self.assertEqual(400, self.ask("api/faults?before=" + urllib.parse.quote(wrong))[0], wrong)
        other = self.events()
        other.wait(lambda e: e.of("faults"))
        self.assertEqual(told, [f["sequence"] for f in self.faults(other)])
        with urllib.request.urlopen(self.address + "metrics", timeout=takt_system.LONG) as response:
            self.assertIn('takt_faults_total{device="left",severity="warning"} 1\n', response.read().decode())
        run.signal(signal.SIGINT)
        self.assertEqual(0, run.wait().status, run.err)
        self.end({"left": node})

    def test_prometheus_can_read_the_metrics_of_the_gateway(self):
        run = self.cell()
        self.done("stop right.live")

        def families():
            with urllib.request.urlopen(self.address + "metrics", timeout=takt_system.LONG) as response:
                self.assertEqual("text/plain; version=0.0.4; charset=utf-8", response.headers["Content-Type"])
                return {f.name: f for f in text_string_to_metric_families(response.read().decode())}

        def measured():
            found = families()
            ran = any(s.value > 100 for s in found["takt_module_cycles"].samples if s.labels["module"] == "source") \
                if "takt_module_cycles" in found else False
            return found if ran and "takt_connection_matched" in found else None
        found = wait_until(measured, "measures")

        def value(family, **labels):
            values = [s.value for s in found[family].samples if labels.items() <= s.labels.items()]
            self.assertEqual(1, len(values), (family, labels))
            return values[0]
        self.assertEqual(1, value("takt_device_up", device="left"))
        self.assertEqual(1, value("takt_module_state", module="live", state="START"))
        self.assertEqual(0, value("takt_module_state", module="live", state="EXECUTING"))
        self.assertGreater(value("takt_module_cycles", module="source"), 100)
        self.assertLess(value("takt_module_jitter_seconds", module="source", quantile="0.5"), 1)
        self.assertEqual(1, value("takt_connection_matched", **{"from": "left.source.out", "to": "right.sink.in"}))
        for name, family in found.items():
            self.assertRegex(name, "^takt_[a-z_]+$")
            self.assertIn(family.type, ("gauge", "counter"))
            self.assertTrue(family.documentation.endswith("."), name)
            seen = [tuple(sorted(s.labels.items())) for s in family.samples]
            self.assertEqual(len(seen), len(set(seen)), "%s has the same sample twice" % name)
            if family.type == "counter":
                self.assertTrue(all(s.name.endswith("_total") for s in family.samples), name)
        # Counters never decrease.
        later = families()
        for name, family in found.items():
            if family.type != "counter":
                continue
            now = {tuple(sorted(s.labels.items())): s.value for s in later[name].samples}
            for sample in family.samples:
                self.assertGreaterEqual(now[tuple(sorted(sample.labels.items()))], sample.value, name)
        self.finish(run)

    def test_malformed_http_requests_do_not_disturb_other_clients_of_the_gateway(self):
        run = self.cell("--commands")
        events = self.events()
        events.wait(lambda e: len(e.modules) == 5 and e.of("cell")[-1]["cell"] == "seen")
        where = urllib.parse.urlparse(self.address)

        def raw(data, whole=False):
            with socket.create_connection((where.hostname, where.port), timeout=takt_system.LONG) as s:
                s.sendall(data)
                if not whole:
                    s.shutdown(socket.SHUT_WR)
                answer = b""
                while True:
                    try:
                        part = s.recv(65536)
                    except ConnectionError:
                        return answer
                    if not part:
                        return answer
                    answer += part
        for junk in (b"", b"\r\n\r\n", b"\0" * 5000, b"GET / HTTP/9.9\r\n\r\n", b"POST /api/command HTTP/1.1\r\nContent-Length: 99999999999999\r\n\r\n",
                     b"GET /" + b"a" * 100000 + b" HTTP/1.1\r\n\r\n", b"GET / HTTP/1.1\r\n" + b"a: b\r\n" * 20000 + b"\r\n"):
            self.assertNotIn(b" 200 ", raw(junk).split(b"\r\n")[0], junk[:40])
        # The gateway must reject a request whose Host header names another host (DNS rebinding).
        for host in ("evil.example", "127.0.0.1.evil.example", ""):
            self.assertIn(b" 421 ", raw(b"GET /api/events HTTP/1.1\r\nHost: %s\r\nConnection: close\r\n\r\n" % host.encode(), whole=True).split(b"\r\n")[0])
        status, said = self.ask("api/command", b"x" * 70000, token=self.token)
        self.assertEqual((413, "send at most 64 KiB"), (status, said["fix"]))
        # A mistake in the name of the module must not turn a command to this module into a command to the whole device.
        for body in (b"", b"{", b"[]", b'{"verb": 5}', b'{"device": "left", "verb": "explode"}', b'{"device": ["left"], "verb": "stop"}',
                     b'{"device": 5, "module": "source", "verb": "stop"}', b'{"device": "left", "module": 5, "verb": "stop"}',
                     b'{"device": "left", "module": null, "verb": "stop"}', b'{"device": "left", "module": "", "verb": "stop"}',
                     b'{"device": "left", "modul": "source", "verb": "stop"}', b'{"device": "left", "module": "\\u0000", "verb": "stop"}',
                     b'{"device": "left", "module": "\\u0001", "verb": "stop"}', b'{"device": "left", "module": "source", "module": 5, "verb": "stop"}'):
            status, said = self.ask("api/command", body, token=self.token)
            self.assertEqual(400, status, body)
            self.assertTrue(said["what"] and said["fix"])
        for body in (b"{}", b'{"module": "live", "property": "step", "value": "1"}', b'{"module": "right.live", "property": "step", "value": 1}'):
            self.assertEqual(400, self.ask("api/property", body, token=self.token)[0], body)
        for path, status in (("api/nothing", 404), ("../etc/passwd", 404), ("api/table?device=nobody", 404), ("api/properties?module=live", 400),
                             ("api/properties?module=right.nobody", 404), ("api/ports?device=", 504), ("api/table", 404)):
            self.assertEqual(status, self.ask(path)[0], path)
        with urllib.request.urlopen(self.address, timeout=takt_system.LONG) as page:
            self.assertIn("default-src 'self'", page.headers["Content-Security-Policy"])
            self.assertIn(b"<title>", page.read())
        # The number of streams is limited. The existing streams must continue.
        more = []
        for _ in range(63):
            more.append(Events(self.address))
        # Streams to one address must leave places for other addresses.
        where = urllib.parse.urlparse(self.address)
        with socket.create_connection((where.hostname, where.port), timeout=takt_system.LONG, source_address=("127.0.0.2", 0)) as other:
            other.sendall(b"GET /api/events HTTP/1.1\r\nHost: localhost\r\n\r\n")
            self.assertRegex(other.recv(4096), rb"^HTTP/1\.1 200 ")
        with self.assertRaises(urllib.error.HTTPError) as full:
            Events(self.address)
        self.assertEqual(503, full.exception.code)
        full.exception.close()
        self.assertEqual(200, self.ask("api/rights")[0], "other requests must still be answered")
        for one in more:
            one.close()
        self.done("stop right.live")
        events.wait(lambda e: e.states()["right.live"] == "START")
        wait_until(lambda: self.opens(), "a free stream for another page")
        self.assertEqual({"EXECUTING"}, set(self.states_of("left").values()))
        self.finish(run)

    def peak_kib(self, run):
        """Returns the largest resident memory that the process has had so far, in KiB."""
        with open("/proc/%d/status" % run.pid) as status:
            return int(re.search(r"VmHWM:\s+(\d+) kB", status.read())[1])

    def flood(self, start, more):
        """Sends `start` and then `more` again and again: up to 100 MiB, or until takt web closes the connection."""
        where = urllib.parse.urlparse(self.address)
        with socket.create_connection((where.hostname, where.port), timeout=takt_system.LONG) as client:
            try:
                client.sendall(start)
                for _ in range((100 << 20) // len(more)):
                    client.sendall(more)
            except OSError:
                pass

    def test_clients_without_a_token_cannot_fill_the_memory_of_the_gateway(self):
        run = self.web("--commands")
        self.assertEqual(200, self.ask("api/rights")[0])
        get, post = b"GET / HTTP/1.1\r\nHost: localhost\r\n", b"POST /api/command HTTP/1.1\r\nHost: localhost\r\n"
        chunked = post + b"Transfer-Encoding: chunked\r\n\r\n"
        for what, start, more in (("a chunked body", chunked, b"10000\r\n" + b"x" * 0x10000 + b"\r\n"),
                                  ("a chunk size without end", chunked, b"1" * 0x10000),
                                  ("a body without a length", post + b"\r\n", b"x" * 0x10000),
                                  ("a body with a large length", post + b"Content-Length: 1000000000\r\n\r\n", b"x" * 0x10000),
                                  ("header lines without end", get, b"a: b\r\n" * 10000),
                                  ("a header line without end", get + b"a: ", b"x" * 0x10000),
                                  ("an address without end", b"GET /", b"x" * 0x10000)):
            before = self.peak_kib(run)
            clients = [threading.Thread(target=self.flood, args=(start, more)) for _ in range(4)]
            for client in clients:
                client.start()
            self.assertEqual(200, self.ask("api/rights")[0], "another client must be answered during %s" % what)
            for client in clients:
                client.join()
            grown = self.peak_kib(run) - before
            print("%s: the peak memory of takt web grew by %d KiB to %d KiB" % (what, grown, before + grown))
            self.assertLess(grown, 32 << 10, what)
        # A short request must not cause a long response.
        request = urllib.request.Request(self.address + "gantt.js", headers={"Range": "bytes=" + "0-," * 2000 + "0-"})
        with urllib.request.urlopen(request, timeout=takt_system.LONG) as response:
            self.assertEqual(200, response.status)
            self.assertLess(len(response.read()), 100000)
        run.signal(signal.SIGINT)
        self.assertEqual(0, run.wait().status, run.err)

    def test_slow_clients_do_not_keep_other_clients_out_of_the_gateway(self):
        run = self.web()
        where = urllib.parse.urlparse(self.address)

        def connect():
            client = socket.create_connection((where.hostname, where.port), timeout=takt_system.LONG)
            client.sendall(b"PUT /api/streams/0/ports HTTP/1.1\r\nHost: localhost\r\nContent-Length: 60000\r\n\r\n")
            return client
        alone = connect()
        answer = b""
        while part := alone.recv(65536):
            answer += part
        self.assertRegex(answer, rb"^HTTP/1.1 408 [\s\S]*did not arrive within 10 s")
        alone.close()

        # takt web limits the number of its connections. Here, more clients than this limit each send a byte now and then.
        slow = [connect() for _ in range(300)]
        enough = threading.Event()

        def drip():
            while not enough.wait(0.1):
                for client in slow:
                    try:
                        client.send(b"x")
                    except OSError:
                        pass  # takt web has ended this connection
        dripping = threading.Thread(target=drip)
        dripping.start()
        try:
            for _ in range(10):
                self.assertEqual(200, self.ask("api/rights")[0])
            events = self.events()
            events.wait(lambda e: e.of("cell"))
        finally:
            enough.set()
            dripping.join()
            for client in slow:
                client.close()

        # Requests that wait for a device that does not exist must not occupy all threads.
        statuses = []
        waiting = [threading.Thread(target=lambda: statuses.append(self.ask("api/ports?device=nobody")[0])) for _ in range(40)]
        for one in waiting:
            one.start()
        self.assertEqual(200, self.ask("api/rights")[0])
        for one in waiting:
            one.join()
        self.assertEqual({503, 504}, set(statuses))
        run.signal(signal.SIGINT)
        self.assertEqual(0, run.wait().status, run.err)

    def opens(self):
        try:
            Events(self.address).close()
            return True
        except urllib.error.HTTPError as error:
            error.close()
            return False

    def test_takt_web_reports_why_it_cannot_start(self):
        taken = socket.socket()
        self.addCleanup(taken.close)
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        secret = self.write("token", "0123456789abcdef\n")
        os.chmod(secret, 0o644)
        short = self.write("short", "abc\n")
        os.chmod(short, 0o600)
        self.refused({
            "web --listen foo.bar": r"^foo\.bar:8080: error: cannot listen on this address; give --listen an address",
            "web --port %d" % taken.getsockname()[1]: r"error: 127\.0\.0\.1:\d+: cannot listen on this address.*choose another --port|127\.0\.0\.1:\d+: error: cannot listen on this address.*choose another --port",
            "web --listen 192.0.2.1 --port 0": "cannot listen on this address.*an address of this machine",
            "web --token-file %s" % secret: "is readable by other users.*chmod 600",
            "web --token-file %s" % short: "is not a valid token.*at least 16",
            "web --token-file nowhere": "there is no such file",
        })
        os.chmod(secret, 0o600)
        run = self.web("--token-file", secret)
        self.assertNotIn("0123456789abcdef", run.out + run.err)
        self.assertTrue(self.ask("api/rights", token="0123456789abcdef")[1]["command"])
        self.assertFalse(self.ask("api/rights", token="0123456789abcdee")[1]["command"])
        run.signal(signal.SIGTERM)
        self.assertEqual(0, run.wait().status)


if __name__ == "__main__":
    takt_system.main()
