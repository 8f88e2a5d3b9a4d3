import json
import os
import re
import signal
import sys
import time
import urllib.error
import urllib.request

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import wait_until

from selenium.webdriver.common.keys import Keys

from browser import Browser

TOKEN = "a-token-that-only-this-test-knows"
LONG = 60  # seconds; two processors are shared with a browser
MODULES = ("robot.source", "robot.tuned", "robot.program", "line.sink", "line.fails")
VIEWS = ("cell", "modules", "connections", "faults", "table", "plots")


class Web(takt_system.Case):
    def serve(self, *arguments, port=0):
        """takt web with a token of its own; self.address is where it is."""
        token = os.path.join(self.folder, "token")
        if not os.path.exists(token):
            self.write("token", TOKEN + "\n")
            os.chmod(token, 0o600)
        web = self.start("web", "--port", str(port), "--token-file", token, *arguments)
        web.wait_for_out(r"http://", LONG)
        self.address = re.search(r"http://\S+", web.out)[0]
        return web

    def look(self, route="", **options):
        self.page = Browser(self.folder, **options)
        self.addCleanup(self.page.close)
        self.page.open(self.address + route)
        return self.page

    def cell(self, descriptor="cell.xml", devices=("robot", "line")):
        self.running = self.nodes(*devices)
        self.deploy(descriptor)

    def finish(self, web, apart=()):
        self.assertEqual([], self.page.errors(apart))
        self.done("undeploy cell")
        self.end(self.running)
        web.signal(signal.SIGTERM)
        self.assertEqual(0, web.wait(20).status, web.err)

    def on_dds(self):
        return {"%s.%s" % (device["name"], module["name"]): module["state"]
                for device in self.status_of()["devices"] for module in device["modules"]}

    def wait_until_as_on_dds(self):
        """Until every module is shown in the state that takt status says."""
        for _ in range(20):
            told = self.on_dds()
            try:
                wait_until(lambda: self.page.states() == told, 3)
                return told
            except AssertionError:
                pass  # it changed meanwhile
        self.assertEqual(told, self.page.states())

    def select(self, module):
        self.page.go("#/modules?select=" + module)
        self.page.wait_for("#details h2", "^%s$" % re.escape(module))

    def order(self, verb):
        button = "#details [data-verb=%s]" % verb
        wait_until(lambda: self.page.script("return document.querySelector(arguments[0])?.disabled", button) is False, LONG,
                   "the button %s" % verb)
        self.page.click(button)

    @takt_system.timing("the last faults that it looks for must not make way for those of a machine that stands still")
    def test_what_is_shown_is_what_is_on_dds(self):
        web = self.serve()
        page = self.look("#/modules")
        page.wait_for("#summary", "no device is to be seen")
        self.cell()
        page.wait_for("#link", "^live$")
        page.wait_for_attribute("tr[data-module='line.fails']", "data-state", "RECOVER", LONG)
        told = self.wait_until_as_on_dds()
        self.assertEqual(set(MODULES), set(told))
        page.wait_for("#summary", r"^running: 4 of 5 modules EXECUTING, line.fails in RECOVER$")

        # The graph says the same, in words and not by colour alone.
        page.go("#/cell")
        for module, state in told.items():
            page.wait_for("[data-module='%s'] .state-word" % module, "^%s$" % state)
        self.assertEqual("bad", page.attribute("[data-module='line.fails']", "data-look"))
        for module, state in told.items():
            hint = page.script("return document.querySelector(arguments[0]).textContent", "[data-module='%s'] > title" % module)
            self.assertRegex(hint, "^%s: .*; %s$" % (re.escape(module), state))
        self.assertEqual("good", page.attribute("[data-module='robot.tuned']", "data-look"))
        page.wait_for_attribute("path.wire", "data-line", "good", LONG)

        # A program that is killed turns to RECOVER and comes back; the modules of a host do so in a moment, which the details keep.
        page.go("#/modules")
        page.wait_for("tr[data-module='robot.program'] .word", "EXECUTING")
        page.watch_states()
        self.running["robot"].one("grid.exe").kill()
        wait_until(lambda: "RECOVER" in page.seen("robot.program"), LONG, "RECOVER of the program")
        page.wait_for_attribute("tr[data-module='robot.program']", "data-state", "EXECUTING", LONG)
        self.running["robot"].one("takt-host").kill()
        page.go("#/modules?select=robot.tuned")
        page.wait_for(".steps li", "EXECUTING \u2192 DESTRUCT.*its host ended", LONG)
        page.wait_for("#details .mark .word", "^EXECUTING", LONG)
        page.wait_for("#details .last-faults li", "host-restart", LONG)
        self.wait_until_as_on_dds()
        page.go("#/modules?select=line.fails")
        page.wait_for("#details .last-faults li", "error: failure.*run", LONG)
        self.assertNotIn("host-restart", " ".join(page.texts("#details .last-faults li")))
        page.go("#/faults")
        page.wait_for("tr[data-kind=host-restart]", "robot", LONG)
        before = len(page.texts("tr[data-kind]"))
        self.running["robot"].one("grid.exe").kill()
        wait_until(lambda: len(page.texts("tr[data-kind]")) > before, LONG, "the record to grow while one looks at it")
        page.wait_for("tr[data-kind=program-restart]", "robot.program", LONG)
        page.go("#/modules?select=robot.program")
        page.wait_for("#details .last-faults li", "program-restart", LONG)
        page.go("#/modules?select=robot.tuned")
        page.wait_for("#details h2", "robot.tuned")
        page.wait_for("#details .last-faults li", "host-restart", LONG)
        self.assertNotIn("program-restart", " ".join(page.texts("#details .last-faults li")))

        # A node that is killed: its device is lost, its modules with it, and so is what came from them.
        self.running["robot"].signal(signal.SIGKILL)
        self.running["robot"].wait(10)
        page.wait_for("#summary", "robot lost", LONG)
        page.go("#/modules")
        page.wait_for_attribute("tr[data-device=robot]", "data-state", "lost", LONG)
        page.wait_for("tr[data-module='robot.tuned'] .word", "^lost, was EXECUTING$")
        page.go("#/cell")
        page.wait_for_attribute("[data-device=robot]", "data-state", "lost", LONG)
        page.wait_for("[data-device=robot] .state-word", "^lost$", LONG)
        page.wait_for("[data-module='robot.tuned'] .state-word", "^lost, was EXECUTING$", LONG)
        page.wait_for_attribute("path.wire", "data-line", "broken", LONG)
        page.go("#/connections")
        page.wait_for("tr[data-connection] .word", "not matched", LONG)
        self.running["robot"] = self.node("robot", "--resume")
        page.go("#/modules")
        page.wait_for_attribute("tr[data-module='robot.tuned']", "data-state", "EXECUTING", LONG)
        self.wait_until_as_on_dds()
        self.finish(web)

    def test_who_has_the_token_commands(self):
        web = self.serve()
        self.cell()
        page = self.look("#token=" + TOKEN)
        page.wait_for("#rights", "may command", LONG)
        self.assertNotIn(TOKEN, page.script("return location.href"))
        self.select("robot.tuned")
        page.wait_for("#details .mark .word", "^EXECUTING", LONG)
        self.order("stop")
        page.wait_for("#details .orders .answer", "stop done", LONG)
        page.wait_for("#details .mark .word", "^START", LONG)
        self.wait_for_states({"robot": {"tuned": "START"}})
        self.order("start")
        self.wait_for_states({"robot": {"tuned": "EXECUTING"}})
        page.wait_for("#details .mark .word", "^EXECUTING", LONG)

        # What ends it asks first, and no is no.
        self.order("destruct")
        page.wait_for("dialog h3", r"Destruct robot\.tuned\?")
        page.press(Keys.ESCAPE)
        wait_until(lambda: page.text("dialog h3") is None, LONG, "the question to be gone")
        self.assertEqual("EXECUTING", self.on_dds()["robot.tuned"])
        self.order("destruct")
        page.click("dialog button.danger")
        for state, verb in (("DESTRUCT", "reset"), ("IDLE", "initialize"), ("INITIALIZE", None)):
            page.wait_for("#details .mark .word", "^%s" % state, LONG)
            self.wait_for_states({"robot": {"tuned": state}})
            if verb:
                self.order(verb)
        self.select("line.fails")
        page.wait_for("#details .mark .word", "^RECOVER", LONG)
        page.wait_for("#details .why", "^failure: ")
        page.go("#/modules")
        page.watch_states()
        self.select("line.fails")
        self.order("recover")
        wait_until(lambda: "EXECUTING" in page.seen("line.fails"), LONG, "line.fails to go on")

        # A property, within its range and out of it.
        self.select("robot.tuned")
        gain = "[data-property=gain]"
        page.wait_for(gain + " .about", "0 to 100", LONG)
        page.write(gain + " input", "2.5")
        page.click(gain + " button")
        page.wait_for(gain + " .answer", "is now 2.5", LONG)
        self.assertEqual(["2.5"], self.done("get robot.tuned gain"))
        page.write(gain + " input", "1000")
        page.click(gain + " button")
        page.wait_for_attribute(gain + " .answer", "data-look", "bad", LONG)
        self.assertEqual(["2.5"], self.done("get robot.tuned gain"))
        # Whatever somebody writes is text.
        label = "[data-property=label]"
        page.write(label + " input", "<img src=x onerror=document.title='x'>")
        page.click(label + " button")
        page.wait_for(label + " .answer", "is now <img", LONG)
        self.assertEqual(0, page.script("return document.querySelectorAll('img').length"))
        self.finish(web, apart=("409",))

    def test_without_the_token_it_is_to_look_at(self):
        web = self.serve()
        self.cell()
        page = self.look("#/modules?select=robot.tuned")
        page.wait_for("#rights", "read-only", LONG)
        page.wait_for("#details .mark .word", "^EXECUTING", LONG)
        page.wait_for("#orders-why", "^Read-only: .*token", LONG)
        page.wait_for("[data-property=gain] .name", "gain", LONG)
        self.assertTrue(page.script("return [...document.querySelectorAll('.orders button, .property input, .property button')]"
                                    ".every((one) => one.disabled)"))
        # Nor by going around the page.
        order = json.dumps({"device": "robot", "module": "tuned", "verb": "stop"})
        self.assertEqual(403, page.wait_script("fetch('/api/command', {method: 'POST', body: arguments[0]}).then((a) => done(a.status))",
                                               order))
        for token in (None, "wrong"):
            request = urllib.request.Request(self.address + "api/command", order.encode(),
                                             {"Authorization": "Bearer " + token} if token else {})
            with self.assertRaises(urllib.error.HTTPError) as refused:
                urllib.request.urlopen(request, timeout=20)
            self.assertEqual(403, refused.exception.code)
            refused.exception.close()
        self.assertEqual("EXECUTING", self.on_dds()["robot.tuned"])
        # The address with the token, opened in the tab that shows the page.
        page.go("#token=" + TOKEN)
        page.wait_for("#rights", "may command", LONG)
        self.assertNotIn(TOKEN, page.script("return location.href"))
        self.finish(web, apart=("403",))

    def test_the_keyboard_reaches_all_and_does_it(self):
        web = self.serve()
        self.cell()
        page = self.look("#token=" + TOKEN)
        page.wait_for("[data-module='robot.tuned'] .state-word", "EXECUTING", LONG)
        page.press_until(Keys.TAB, lambda focused: focused == "Cell")
        for view in VIEWS[1:]:
            page.press(Keys.ARROW_RIGHT)
            wait_until(lambda: page.script("return location.hash").startswith("#/" + view), LONG, view)
        page.press(Keys.HOME)
        # The graph: into it, from box to box, and a box is chosen.
        page.press_until(Keys.TAB, lambda focused: focused.startswith("graph of the cell"))
        page.press_until(Keys.TAB, lambda focused: focused.startswith(("device ", "robot.", "line.")))
        reached = set()
        for key in [Keys.ARROW_DOWN] * 5 + [Keys.ARROW_RIGHT] + [Keys.ARROW_UP] * 5 + [Keys.ARROW_LEFT] + [Keys.ARROW_DOWN] * 5:
            reached.add(page.focused().split(":")[0])
            page.press(key)
        self.assertLessEqual({"robot.tuned", "line.fails"}, reached)
        page.press(Keys.ENTER)
        page.wait_for("#details h2", r"\w")
        page.press(Keys.ESCAPE)
        wait_until(lambda: page.text("#details h2") is None, LONG, "the details to be closed")
        # The list: a module is chosen and stopped.
        page.press_until(Keys.TAB, lambda focused: focused == "Cell")
        page.press(Keys.ARROW_RIGHT)
        page.wait_for("tr[data-module='robot.tuned'] .word", "EXECUTING", LONG)
        page.press_until(Keys.TAB, lambda focused: focused == "robot")
        page.press_until(Keys.ARROW_DOWN, lambda focused: focused == "tuned")
        page.press(Keys.ENTER)
        page.wait_for("#details h2", r"^robot\.tuned$")
        page.press_until(Keys.TAB, lambda focused: focused == "Stop")
        page.press(Keys.ENTER)
        self.wait_for_states({"robot": {"tuned": "START"}}, LONG)
        page.wait_for("#details .mark .word", "^START", LONG)
        # Whoever listens is told.
        page.wait_for("#spoken", r"robot\.tuned START", LONG)
        page.press(Keys.ESCAPE)
        wait_until(lambda: page.focused() == "tuned", LONG, "the focus to be where it was")
        self.finish(web)

    def test_a_gateway_that_is_gone_is_told_and_comes_back(self):
        web = self.serve()
        port = int(re.search(r":(\d+)/", self.address)[1])
        self.cell()
        page = self.look("#token=" + TOKEN)
        self.select("robot.tuned")
        page.wait_for("#details .mark .word", "^EXECUTING", LONG)
        web.signal(signal.SIGKILL)
        web.wait(10)
        page.wait_for("#link", "connection lost, trying again", LONG)
        page.wait_for("#stale", "What is shown is from before", LONG)
        self.assertEqual("alert", page.attribute("#stale", "role"))
        page.wait_for("#orders-why", "connection to the gateway is lost", LONG)
        self.assertTrue(page.script("return [...document.querySelectorAll('.orders button')].every((one) => one.disabled)"))
        self.assertNotEqual("none", page.script("return getComputedStyle(document.querySelector('#main')).filter"))
        self.done("stop robot.tuned")
        web = self.serve(port=port)
        page.wait_for("#link", "^live$", LONG)
        page.wait_for("#details .mark .word", "^START", LONG)
        wait_until(lambda: page.text("#stale") is None, LONG, "the warning to be gone")
        page.go("#/modules")
        self.wait_until_as_on_dds()
        self.select("robot.tuned")
        self.order("start")
        self.wait_for_states({"robot": {"tuned": "EXECUTING"}}, LONG)
        self.finish(web, apart=("ERR_CONNECTION_REFUSED", "ERR_INCOMPLETE_CHUNKED", "ERR_EMPTY", "ERR_CONNECTION_RESET"))

    def test_values_of_ports_and_the_table_are_drawn(self):
        web = self.serve()
        self.cell()
        page = self.look("#/plots")
        page.wait_for(".tools [role=status]", "^Choose a port", LONG)
        page.go("#/plots?port=robot.source.out")
        number = int(page.wait_for(".time-plot b", r"^\d+$", LONG))
        wait_until(lambda: int(page.text(".time-plot b")) > number + 300, LONG, "values of the next three seconds")
        self.assertGreater(page.script("""
            const canvas = document.querySelector("canvas.plot");
            const wanted = getComputedStyle(document.documentElement).getPropertyValue("--accent").match(/[0-9a-f]{2}/g);
            const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
            let found = 0;
            for (let i = 0; i < pixels.length; i += 4) {
              if (pixels[i + 3] > 100 && wanted.every((of, j) => Math.abs(pixels[i + j] - parseInt(of, 16)) < 40)) ++found;
            }
            return found"""), 20)
        page.go("#/table?device=robot")
        page.wait_for(".executor summary", "Where the time went", LONG)
        wait_until(lambda: {"source", "tuned", "program (program)"} <= set(page.texts(".executor details tbody th")), LONG, "all modules")
        page.go("#/modules?select=robot.source")
        page.wait_for(".ports li", "line.sink.in.*ok", LONG)
        page.wait_for("#details .bar .words", r"us, p99, of its budget of 5 ms", LONG)
        self.finish(web)

    def test_a_deployment_is_shown_where_one_looked_before_it_came(self):
        web = self.serve()
        page = self.look("#/constructor")  # no view, though every object has one
        page.wait_for("#tabs [aria-selected=true]", "^Cell$", LONG)
        page.go("#/table?device=robot")
        page.wait_for(".table-view .answer", "no cell runs", LONG)
        self.cell()
        page.wait_for(".executor summary", "Where the time went", LONG)
        self.done("undeploy cell")
        page.wait_for(".table-view .answer", "no cell runs", LONG)
        page.go("#/plots?port=robot.source.out")
        page.wait_for(".tools [role=status]", r"^(?!waiting)\w", LONG)
        self.deploy("cell.xml")
        page.wait_for(".time-plot b", r"^\d+$", LONG)
        wait_until(lambda: page.script("return document.querySelectorAll('optgroup[label=robot] option').length"), LONG, "the list of ports")

        # In place of a module another of its name: what is shown of it is of the new one.
        page.go("#/table?device=robot&select=robot.tuned")
        page.wait_for("[data-property=gain] .name", "gain", LONG)
        page.wait_for(".executor summary", "Where the time went", LONG)
        with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "cell.xml")) as file:
            text = file.read().replace("cpp_properties.so", "port_source.so")
        self.done("undeploy cell")
        page.wait_for(".table-view .answer", "no cell runs", LONG)
        self.deploy(self.write("other.xml", text))
        page.wait_for("#details .ports li", "^out writes", LONG)
        page.wait_for(".executor summary", "Where the time went", LONG)
        self.assertIsNone(page.text("[data-property=gain]"))
        self.finish(web, apart=("409", "404"))

    def test_a_module_that_begins_to_overrun_comes_into_the_choice_of_those(self):
        web = self.serve()
        page = self.look("#/faults")
        self.assertEqual([0, 1], page.wait_script("""
            Promise.all([import("/store.js"), import("/modules.js")]).then(async ([{Store}, {Modules}]) => {
              const store = new Store();
              const view = new Modules(store);
              store.takeCell({devices: [{name: "robot", modules: [{name: "one"}]}]});
              store.takeState({whole: true, devices: [], modules: [{name: "robot.one", state: "EXECUTING"}]});
              view.show(new URLSearchParams("only=over"));
              document.body.append(view.element);
              const shown = [];
              store.listen((changes) => {
                view.update(changes);
                if (changes.measures) shown.push(view.body.querySelectorAll("tr[data-module]").length);
              });
              for (const overruns of [0, 1]) {
                store.takeMeasures({time_ms: 1, modules: {"robot.one":
                  {jitter_us: {p50: 1, p99: 2}, run_us: {p99: 1}, overruns, recoveries: 0}}});
                while (shown.length <= overruns) await new Promise(requestAnimationFrame);
              }
              done(shown);
            }).catch((error) => done(String(error)));"""))
        web.signal(signal.SIGTERM)
        self.assertEqual(0, web.wait(20).status, web.err)

    def test_a_link_keeps_the_filters_and_a_pause_counts_what_comes(self):
        web = self.serve()
        page = self.look()
        found = page.wait_script("""
            Promise.all([import("/store.js"), import("/faults.js")]).then(async ([{Store}, {Faults}]) => {
              const store = new Store();
              const view = new Faults(store);
              document.body.append(view.element);
              const fault = (cause, time_ms) => ({device: "robot", module: "one", kind: "overrun", severity: "warning", cause, time_ms, count: 1});
              store.takeFaults({whole: true, events: Array.from({length: 2000}, () => fault("old", 2000))});
              view.show(new URLSearchParams());
              history.replaceState(null, "", "#/faults?text=old");
              view.body.querySelector("a").click();
              const address = location.hash;
              view.pause.click();
              store.takeFaults({events: [fault("its clock is behind", 1000)]});
              view.update({faults: true});
              const said = view.count.textContent;
              view.pause.click();
              done([address, said, view.body.querySelector(".what").textContent]);
            }).catch((error) => done(String(error)));""")
        self.assertEqual(["#/faults?text=old&select=robot.one", "2000 events; paused, 1 new", "overrun its clock is behind"], found)
        web.signal(signal.SIGTERM)
        self.assertEqual(0, web.wait(20).status, web.err)

    def test_a_hundred_modules_are_all_shown_as_they_change(self):
        modules = "".join("<module><name>m%d</name><filename>cpp_properties.so</filename><moduletype>thread</moduletype>"
                          "<operationtype>periodic</operationtype><period>10000000</period><priority>%d</priority></module>\n" % (i, i)
                          for i in range(100))
        file = self.write("cell.xml", '<cell name="cell"><device name="robot">\n%s</device></cell>\n' % modules)
        web = self.serve()
        self.cell(file, ("robot",))
        page = self.look("#/modules")
        wait_until(lambda: list(page.states().values()) == ["EXECUTING"] * 100, LONG, "a hundred modules EXECUTING")
        page.watch_states()
        page.script("""window.frames_ms = []; let last = performance.now();
            const frame = (now) => { window.frames_ms.push(now - last); last = now; requestAnimationFrame(frame); };
            requestAnimationFrame(frame);
            window.told = {};  // when each step was taken, by the clock of the node, which is the browser's here
            new EventSource("/api/events").addEventListener("state", (event) => JSON.parse(event.data).modules
              .forEach((module) => (window.told[module.name] ??= []).push([module.state, module.time_ms])));""")
        wait_until(lambda: len(page.script("return window.told")) == 100, LONG, "the other stream")
        told = []
        for verb, state in (("stop", "START"), ("start", "EXECUTING")) * 3:
            self.done("%s robot" % verb)
            wait_until(lambda: set(page.states().values()) == {state}, LONG, "all of them %s" % state)
            told.append(state)
        seen_at, told_at = page.seen(), page.script("return window.told")
        ages = []
        for module, shown in seen_at.items():
            steps = [step for step in told_at[module][1:] if step[0] in ("START", "EXECUTING")]
            if [state for state, _ in steps] == [state for state, _ in shown[1:]]:
                ages += [at - step_at for (_, at), (_, step_at) in zip(shown[1:], steps)]
        ages.sort()
        if ages:
            print("from a step until it is shown: %d steps, ms: p50 %.0f, p99 %.0f, longest %.0f"
                  % (len(ages), ages[len(ages) // 2], ages[len(ages) * 99 // 100], ages[-1]))
        for module, seen in seen_at.items():
            seen = [state for state, _ in seen if state != "lost"]  # for a moment, where the machine stands still
            self.assertEqual(["EXECUTING"] + told, [state for i, state in enumerate(seen) if i == 0 or seen[i - 1] != state], module)
        frames = sorted(page.script("return window.frames_ms"))
        print("frames with a hundred modules: %d, ms: p50 %.1f, p99 %.1f, longest %.1f"
              % (len(frames), frames[len(frames) // 2], frames[len(frames) * 99 // 100], frames[-1]))
        page.go("#/cell")
        page.wait_for("[data-module='robot.m0'] .state-word", "EXECUTING", LONG)
        self.finish(web)

    def test_it_fits_screens_and_fingers_and_is_legible(self):
        web = self.serve()
        self.cell()
        page = self.look("#token=" + TOKEN)
        page.wait_for("#summary", "in RECOVER", LONG)
        for width, height in ((768, 1024), (1024, 768), (1440, 900)):
            page.size(width, height)
            for view in VIEWS + ("modules?select=robot.tuned", "cell?select=robot"):
                page.go("#/" + view)
                time.sleep(0.3)  # what is asked of the gateway may make it wider
                with self.subTest(width=width, view=view):
                    self.assertLessEqual(page.script("return Math.max(document.documentElement.scrollWidth, ...[...document.querySelectorAll("
                                                     "'.scrolled, #details')].map((one) => one.scrollWidth - one.clientWidth + innerWidth))"),
                                         width)
                    self.assertEqual([], page.script("""
                        return [...document.querySelectorAll("button, select, input:not([type=checkbox]), [role=tab]")]
                          .filter((one) => one.checkVisibility() && one.getBoundingClientRect().height < 39.5)
                          .map((one) => `${one.textContent}: ${one.getBoundingClientRect().height}`)"""))
        for width in (768, 801, 1001, 1024, 1280):
            page.size(width, 900)
            for view in ("modules", "modules?select=robot.tuned") if width >= 1280 else ("modules",):
                page.go("#/" + view)
                time.sleep(0.3)
                with self.subTest(width=width, view=view):
                    self.assertGreater(page.script("return document.querySelector('tr[data-module] th').clientWidth"), 150, "of a name")
        page.go("#/cell")
        page.wait_for("[data-device=robot] .state-word", ".", LONG)
        self.assertEqual([], page.script("""
            return [...document.querySelectorAll(".drawing rect")].filter((one) => Math.abs(one.getBBox().height - one.getAttribute("height")) > 0.1)
              .map((one) => `${one.getAttribute("class")}: ${one.getBBox().height}`)"""), "boxes that are not as they were drawn")
        for theme in ("light", "dark"):
            page.prefer(theme)
            page.wait_for_attribute("html", "data-theme", theme)
            for view in VIEWS + ("modules?select=line.fails",):
                page.go("#/" + view)
                time.sleep(0.3)
                with self.subTest(theme=theme, view=view):
                    self.assertEqual([], page.script(CONTRAST))
            self.assertEqual([True], page.script("""
                const accent = getComputedStyle(document.querySelector("#details a, .list a")).color;
                return [...new Set([...document.querySelectorAll(".dash line")].map((one) => getComputedStyle(one).stroke === accent))]"""),
                             "the lines of a legend have the colour of the curves")
        self.finish(web)

    def test_nothing_but_a_drawing_comes_out_of_a_drawing(self):
        web = self.serve()
        page = self.look()
        found = page.wait_script("""
            import("/drawing.js").then(({drawingOf}) => {
              const evil = `<svg xmlns="http://www.w3.org/2000/svg" onload="document.title='x'"><style>a{}</style>
                <script>document.title = "x"</script><foreignObject><img xmlns="http://www.w3.org/1999/xhtml" src="x"/></foreignObject>
                <a href="javascript:0"><text>link</text></a><use href="//elsewhere"/><image href="//elsewhere"/>
                <g data-module="a.b" onclick="0" style="x"><title>t</title><rect x="1" fill="url(//elsewhere)"/></g></svg>`;
              const drawing = drawingOf(evil);
              document.body.append(drawing);
              done([drawing.outerHTML, drawingOf("no picture"), document.title]);
            }).catch((error) => done(String(error)));""")
        self.assertEqual('<svg><g data-module="a.b"><title>t</title><rect x="1"></rect></g></svg>', re.sub(r">\s+<", "><", found[0]))
        self.assertIsNone(found[1])
        self.assertNotEqual("x", found[2])
        web.signal(signal.SIGTERM)
        self.assertEqual(0, web.wait(20).status, web.err)

    def test_a_plot_is_drawn_whatever_its_values_and_its_width(self):
        web = self.serve()
        page = self.look()
        found = page.wait_script("""
            Promise.all([import("/time_plot.js"), import("/gantt.js")]).then(async ([{TimePlot}, {Gantt}]) => {
              const frame = () => new Promise(requestAnimationFrame);
              const values = [[0.3, 0.30000000000000004], [-1e300, 1e300], [0, 5e-324], [7, 7], [0, null], [-1e9, -1e9 - 1e-7]];
              for (const of of values) {
                const plot = new TimePlot({title: "plot", lines: ["value"], span_ms: 60000});
                document.body.append(plot.element);
                plot.show([1000, 2000], [of], 2000);
                await frame();
                await frame();
              }
              const gantt = new Gantt({name: "main", macro_period_ns: 1e7, basic_period_ns: 1e6, rows: []}, [], ["module"]);
              gantt.canvas.element.style.width = "40px";
              document.body.append(gantt.element);
              await frame();
              await frame();
              done([document.querySelectorAll("canvas.plot").length, gantt.canvas.element.clientWidth < gantt.left]);
            }).catch((error) => done(String(error)));""")
        self.assertEqual([6, True], found)
        self.assertEqual([], page.errors())
        web.signal(signal.SIGTERM)
        self.assertEqual(0, web.wait(20).status, web.err)

    def test_an_order_is_waited_for_and_not_given_twice_meanwhile(self):
        web = self.serve()
        page = self.look()
        page.wait_for("#link", "^live$", LONG)
        web.signal(signal.SIGSTOP)  # it takes what is asked, and does not answer
        try:
            limits, said = page.wait_script("""
                import("/api.js").then(async ({get, post}) => {
                  const [limits, said, timeout] = [[], [], AbortSignal.timeout];
                  AbortSignal.timeout = (ms) => { limits.push(ms / 1000); return timeout.call(AbortSignal, 300); };
                  for (const ask of [() => get("/api/rights"), () => post("/api/command", {})]) await ask().catch((problem) => said.push(problem.text));
                  AbortSignal.timeout = timeout;
                  done([limits, said]);
                }).catch((error) => done([[], String(error)]));""")
        finally:
            web.signal(signal.SIGCONT)
        self.assertGreater(limits[1], 30, "seconds that the gateway waits for a device")
        self.assertEqual(["no answer within %d s" % limits[0],
                          "no answer within %d s; whether it was done is not known" % limits[1]], said)
        self.assertEqual([1, 1, 0, 1], page.wait_script("""
            import("/orders.js").then(async ({Orders}) => {
              const [given, fetched] = [[], window.fetch];
              window.fetch = (address) => new Promise((answer) => given.push([address, answer]));
              const modules = new Map(["robot.one", "robot.two"].map((name) => [name, {state: {state: "EXECUTING"}}]));
              const orders = new Orders({modules, link: "live", rights: {command: true}, devices: new Map([["robot", {alive: true}]])});
              orders.hold("robot", "robot.one");
              const stop = orders.buttons.find((button) => button.dataset.verb === "stop");
              stop.click();
              orders.update();  // news come meanwhile
              stop.click();
              const seen = [given.length, Number(stop.disabled)];
              orders.hold("robot", "robot.two");
              seen.push(Number(stop.disabled));
              orders.hold("robot", "robot.one");
              given[0][1](new Response("{}"));
              while (stop.disabled) await new Promise(requestAnimationFrame);
              window.fetch = fetched;
              done([...seen, given.length]);
            }).catch((error) => done(String(error)));"""))
        web.signal(signal.SIGTERM)
        self.assertEqual(0, web.wait(20).status, web.err)

    def test_a_day_is_of_the_same_clock_as_the_hour(self):
        web = self.serve()
        page = self.look()
        page.driver.execute_cdp_cmd("Emulation.setTimezoneOverride", {"timezoneId": "Asia/Tokyo"})
        self.assertEqual("2020-03-02 00:30:00.000", page.wait_script(
            "import('/words.js').then(({instant}) => done(instant(Date.UTC(2020, 2, 1, 15, 30)))).catch((error) => done(String(error)));"))
        web.signal(signal.SIGTERM)
        self.assertEqual(0, web.wait(20).status, web.err)


# Texts whose contrast with what is behind them is less than WCAG's level AA asks for; what cannot be used is left out, as there.
CONTRAST = """
const parts = (text) => text.match(/[\\d.]+/g).map(Number);
const light = ([r, g, b]) => [r, g, b].map((c) => c / 255).map((c) => c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4)
  .reduce((sum, c, i) => sum + c * [0.2126, 0.7152, 0.0722][i], 0);
const behind = (one) => {
  for (; one; one = one.parentElement) {
    const colour = parts(getComputedStyle(one).backgroundColor);
    if (colour.length === 3 || colour[3] > 0) return colour;
  }
  return [255, 255, 255];
};
return [...document.querySelectorAll("body *")]
  .filter((one) => one.checkVisibility() && !one.closest("svg, :disabled, .unseen, select")
    && [...one.childNodes].some((child) => child.nodeType === 3 && child.data.trim()))
  .map((one) => {
    const [a, b] = [light(parts(getComputedStyle(one).color)), light(behind(one))];
    return [(Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05), one];
  }).filter(([ratio]) => ratio < 4.5).map(([ratio, one]) => `${ratio.toFixed(2)}: ${one.textContent.slice(0, 40)}`);
"""


if __name__ == "__main__":
    takt_system.main()
