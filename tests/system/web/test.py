import json
import os
import re
import signal
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.parse
import urllib.request

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from shifted_clock import WallClock
from takt_system import wait_until

from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys

from browser import Browser

TOKEN = "a-token-that-only-this-test-knows"
MODULES = ("robot.source", "robot.tuned", "robot.program", "line.sink", "line.fails")
VIEWS = ("cell", "modules", "connections", "alarms", "faults", "table", "plots", "watch")
VALUE = ".legend-table td[data-label=value]"

# This script counts the pixels of the first plot that have a colour of page.css.
PIXELS = """
const canvas = document.querySelector(".plot canvas");
const wanted = getComputedStyle(document.documentElement).getPropertyValue("--" + arguments[0]).match(/[0-9a-f]{2}/g);
const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
let found = 0;
for (let i = 0; i < pixels.length; i += 4) {
  if (pixels[i + 3] > 100 && wanted.every((of, j) => Math.abs(pixels[i + j] - parseInt(of, 16)) < 40)) ++found;
}
return found;
"""

# This script returns the colour of a pixel of a screenshot, at a place in an element.
PIXEL = """
const [shot, selector, across, down] = arguments;
createImageBitmap(new Blob([Uint8Array.from(atob(shot), (letter) => letter.charCodeAt(0))], {type: "image/png"})).then((picture) => {
  const {x, y, width, height} = document.querySelector(selector).getBoundingClientRect();
  const context = new OffscreenCanvas(picture.width, picture.height).getContext("2d");
  context.drawImage(picture, 0, 0);
  done([...context.getImageData(x + across * width, y + down * height, 1, 1).data]);
});
"""


def listens(port):
    with socket.socket() as client:
        return client.connect_ex(("127.0.0.1", port)) == 0


class Web(takt_system.Case):
    def serve(self, *arguments, port=0):
        """Starts takt web with the token of this test, and stores the address in self.address."""
        token = os.path.join(self.folder, "token")
        if not os.path.exists(token):
            self.write("token", TOKEN + "\n")
            os.chmod(token, 0o600)
        web = self.start("web", "--port", str(port), "--token-file", token, *arguments)
        web.wait_for_out(r"http://")
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
        self.assertEqual(0, web.wait().status, web.err)

    def on_dds(self):
        """Returns the states of all modules as `takt status` shows them."""
        return {"%s.%s" % (device["name"], module["name"]): module["state"] + (" (stopped)" if module.get("stopped") else "")
                for device in self.status_of()["devices"] for module in device["modules"]}

    def wait_until_as_on_dds(self):
        """Waits until the page shows every module in the state that takt status reports."""
        def agree():
            told = self.on_dds()
            return told if self.page.states() == told else None  # a state may have changed between the two readings
        return wait_until(agree, "the page to show the states that takt status reports")

    def select(self, module):
        self.page.go("#/modules?select=" + module)
        self.page.wait_for("#details h2", "^%s$" % re.escape(module))

    def order(self, verb):
        button = "#details [data-verb=%s]" % verb
        wait_until(lambda: self.page.script("return document.querySelector(arguments[0])?.disabled", button) is False,
                   "the button %s" % verb)
        self.page.click(button)

    @takt_system.quiet("the browser competes with other tests for the CPUs")
    def test_alarms_are_shown_above_all_views_until_they_are_acknowledged(self):
        web = self.serve()
        self.cell()
        page = self.look("#/modules")
        page.wait_for("#alarms", r"^\d+ unacknowledged alarm")
        row = "tr[data-alarm='line.fails']"
        page.wait_for("tr[data-module='line.fails'] .alarm", "^alarm$")
        page.prefer("light")
        page.wait_for_attribute("html", "data-theme", "light")
        self.assertGreater(min(page.wait_script(PIXEL, page.driver.get_screenshot_as_base64(), "#alarms .sign", 8 / 16, 8 / 16)[:3]), 128,
                           "the exclamation mark in the sign has the colour of the page")
        page.click("#alarms a")  # without a token, the view has no enabled button
        page.wait_for(row, "unacknowledged.*line.fails.*error: failure")
        page.wait_for(".tools", "read-only")
        self.assertTrue(page.script("return [...document.querySelectorAll('#view button')].every((one) => one.disabled)"))

        # The end of a program is a fault whose cause goes; its module needs attention until somebody acknowledges it.
        self.running["robot"].one("grid.exe").kill()
        page.go("#/cell")
        page.wait_for_attribute("[data-module='robot.program']", "data-state", "EXECUTING")
        page.wait_for_attribute("[data-module='robot.program']", "data-look", "poor")
        page.wait_for("[data-module='robot.program'] text", "^alarm$")
        page.wait_for("[role=treeitem]", "^program alarm$")

        page.open(self.address + "#token=" + TOKEN)
        page.wait_for("#rights", "may command")
        page.go("#/alarms")
        page.wait_for("tr[data-alarm='robot.program']", "unacknowledged, returned to normal")
        page.click("tr[data-alarm='robot.program'] button")
        page.wait_for("dialog h3", r"Acknowledge error of robot\.program\?")
        self.assertEqual(255, page.script("return document.querySelector('dialog input').maxLength"))
        page.write("dialog input", "killed by a test <b>\u202e")
        page.click("dialog button[value=yes]")
        wait_until(lambda: not page.texts("tr[data-alarm='robot.program']"), "the alarm to disappear")
        page.click(row + " button")
        page.write("dialog input", "known\n")  # Enter acknowledges
        page.wait_for(row, r"^acknowledged.*acknowledged by \S+@\S+ at [\d:.]+: known")
        if page.texts("#alarms"):  # a busy machine may raise more alarms
            page.click(".tools button")
            page.click("dialog button[value=yes]")
        wait_until(lambda: not page.texts("#alarms"), "the bar to disappear")
        page.go("#/cell")
        page.wait_for_attribute("[data-module='robot.program']", "data-look", "good")
        recorded = self.takt("log", "robot.program", "--kind", "acknowledged").out
        self.assertRegex(" ".join(recorded.split()), r"\(error\) acknowledged by \S+: killed by a test <b>\\xe2\\x80\\xae$")
        with urllib.request.urlopen(self.address + "metrics", timeout=takt_system.LONG) as metrics:
            self.assertIn('takt_device_unacknowledged_alarms{cell="cell",device="line"} 0', metrics.read().decode())

        # The gateway checks what a page sends.
        for body in ({"device": "line", "alarm": "0", "by": "somebody else"}, {"device": "line", "alarm": "one"}, {"alarm": "0"}):
            self.assertEqual(400, self.post("api/acknowledge", body), body)
        self.assertEqual(409, self.post("api/acknowledge", {"device": "line", "alarm": "0", "note": "x" * 256}))
        self.assertEqual(403, self.post("api/acknowledge", {"device": "line", "alarm": "0"}, token=""))
        self.finish(web)

    def test_the_details_of_a_device_show_how_far_its_clock_differs(self):
        clock = WallClock(os.path.join(self.folder, "clock"))
        web = self.serve()
        self.running = {"robot": self.node("robot"), "line": self.node("line", environment=clock.environment)}
        self.deploy("cell.xml")
        page = self.look("#/cell?select=robot")
        page.wait_for("#details h2", "^robot$")
        page.wait_for("#details [data-of='host restarts']", "^0$")
        self.assertEqual([], page.texts("#details [data-of='wall clock']"), "robot is the first device")
        page.go("#/cell?select=line")
        page.wait_for("#details [data-of='wall clock']", r"^\d+ ms (ahead of|behind) that of robot \(±\d+ ms\)$")
        for seconds, words in ((-2, "behind"), (2, "ahead of")):
            clock.set_by(seconds)
            page.wait_for("#details [data-of='wall clock']", r"^(19|20)\d\d ms %s that of robot \(±\d+ ms\)$" % words)
        clock.set_by(0)
        page.wait_for("#details [data-of='wall clock']", r"^\d+ ms (ahead of|behind) that of robot")
        self.finish(web)

    def post(self, path, body, token=TOKEN):
        """Sends a request as a page does, and returns the status of the answer."""
        request = urllib.request.Request(self.address + path, json.dumps(body).encode(), {"Authorization": "Bearer " + token})
        try:
            with urllib.request.urlopen(request, timeout=takt_system.LONG) as answer:
                return answer.status
        except urllib.error.HTTPError as error:
            return error.code

    def viewers(self):
        """Returns the number of event streams that are open."""
        with urllib.request.urlopen(self.address + "metrics", timeout=takt_system.LONG) as metrics:
            return int(re.search(r"^takt_web_viewers (\d+)$", metrics.read().decode(), re.M)[1])

    def wait_for_viewers(self, number):
        wait_until(lambda: self.viewers() == number, "%d event streams" % number)

    @takt_system.quiet("the test looks for the last faults, and rows missed on a busy machine would be newer faults")
    def test_the_web_page_shows_the_states_that_nodes_publish(self):
        web = self.serve()
        page = self.look("#/modules")
        page.wait_for("#summary", "no devices found")
        self.cell()
        page.wait_for("#link", "^live$")
        page.wait_for_attribute("tr[data-module='line.fails']", "data-state", "RECOVER")
        told = self.wait_until_as_on_dds()
        self.assertEqual(set(MODULES), set(told))
        page.wait_for("#summary", r"^running: 4 of 5 modules EXECUTING, line.fails in RECOVER$")

        # The graph must show the states as words too, not only as colours.
        page.go("#/cell")
        for module, state in told.items():
            page.wait_for("[data-module='%s'] .state-word" % module, "^%s$" % state)
        self.assertEqual("bad", page.attribute("[data-module='line.fails']", "data-look"))
        for module, state in told.items():
            hint = page.script("return document.querySelector(arguments[0]).textContent", "[data-module='%s'] > title" % module)
            self.assertRegex(hint, "^%s: .*; %s(, alarm)?$" % (re.escape(module), re.escape(state)))
        self.assertEqual("good", page.attribute("[data-module='robot.tuned']", "data-look"))
        page.wait_for_attribute("path.wire", "data-line", "good")

        # A killed program goes to RECOVER and then executes again. The states of a killed host change too fast to see, but the details list
        # the transitions.
        page.go("#/modules")
        page.wait_for("tr[data-module='robot.program'] .word", "EXECUTING")
        page.watch_states()
        self.running["robot"].one("grid.exe").kill()
        wait_until(lambda: "RECOVER" in page.seen("robot.program"), "RECOVER of the program")
        page.wait_for_attribute("tr[data-module='robot.program']", "data-state", "EXECUTING")
        self.running["robot"].one("takt-host").kill()
        page.go("#/modules?select=robot.tuned")
        page.wait_for(".steps li", "EXECUTING \u2192 DESTRUCT.*its host ended")
        page.wait_for("#details .mark .word", "^EXECUTING")
        page.wait_for("#details .last-faults li", "host-restart")
        self.wait_until_as_on_dds()
        page.go("#/modules?select=line.fails")
        page.wait_for("#details .last-faults li", "error: failure.*run")
        self.assertNotIn("host-restart", " ".join(page.texts("#details .last-faults li")))
        page.go("#/faults")
        page.wait_for("tr[data-kind=host-restart]", "robot")
        self.assertEqual([], page.texts("tr[data-kind=node-start]"), "at first, the page shows only warnings and errors")
        before = len(page.texts("tr[data-kind]"))
        self.running["robot"].one("grid.exe").kill()
        wait_until(lambda: len(page.texts("tr[data-kind]")) > before, "the open record to grow")
        page.wait_for("tr[data-kind=program-restart]", "robot.program")
        page.go("#/modules?select=robot.program")
        page.wait_for("#details .last-faults li", "program-restart")
        page.go("#/modules?select=robot.tuned")
        page.wait_for("#details h2", "robot.tuned")
        page.wait_for("#details .last-faults li", "host-restart")
        self.assertNotIn("program-restart", " ".join(page.texts("#details .last-faults li")))

        # If a node is killed, the page must show its device, its modules and their connections as lost.
        self.running["robot"].signal(signal.SIGKILL)
        self.running["robot"].wait()
        page.wait_for("#summary", "robot lost")
        page.wait_for("#details .mark .word", "^lost, was EXECUTING$")
        page.wait_for("#details .why", "^Its last known state is EXECUTING since ")
        page.go("#/modules")
        page.wait_for_attribute("tr[data-device=robot]", "data-state", "lost")
        page.wait_for("tr[data-module='robot.tuned'] .word", "^lost, was EXECUTING$")
        page.go("#/cell")
        page.wait_for_attribute("[data-device=robot]", "data-state", "lost")
        page.wait_for("[data-device=robot] .state-word", "^lost$")
        page.wait_for("[data-module='robot.tuned'] .state-word", "^lost, was EXECUTING$")
        page.wait_for_attribute("path.wire", "data-line", "broken")
        page.go("#/connections")
        page.wait_for("tr[data-connection] .word", "not matched")
        self.running["robot"] = self.node("robot", "--resume")
        page.go("#/modules")
        page.wait_for_attribute("tr[data-module='robot.tuned']", "data-state", "EXECUTING")
        self.wait_until_as_on_dds()
        self.finish(web, apart=("504",))  # the page may still have waited for a reply of the killed node

    @takt_system.quiet("the browser competes with other tests for the CPUs")
    def test_an_operator_with_the_token_can_command_modules_from_the_web_page(self):
        web = self.serve()
        self.cell()
        page = self.look("#token=" + TOKEN)
        page.wait_for("#rights", "may command")
        self.assertNotIn(TOKEN, page.script("return location.href"))
        self.select("robot.tuned")
        page.wait_for("#details .mark .word", "^EXECUTING")
        self.order("stop")
        page.wait_for("dialog h3", r"Stop robot\.tuned\?")
        page.click("dialog button.danger")
        page.wait_for("#details .commands .answer", "stop done")
        page.wait_for("#details .mark .word", r"^START \(stopped\) since")
        page.wait_for("tr[data-module='robot.tuned'] .word", r"^START \(stopped\)$")
        page.wait_for("#summary", r"3 of 5 modules EXECUTING, line\.fails in RECOVER, robot\.tuned stopped$")
        self.wait_for_states({"robot": {"tuned": "START"}})
        self.order("start")
        self.wait_for_states({"robot": {"tuned": "EXECUTING"}})
        page.wait_for("#details .mark .word", "^EXECUTING")

        # The page asks for confirmation before it stops or ends a module, and Escape cancels the command.
        self.order("destruct")
        page.wait_for("dialog h3", r"Destruct robot\.tuned\?")
        page.press(Keys.ESCAPE)
        wait_until(lambda: page.text("dialog h3") is None, "the question to be gone")
        self.assertEqual("EXECUTING", self.on_dds()["robot.tuned"])
        self.order("destruct")
        page.click("dialog button.danger")
        for state, verb in (("DESTRUCT", "reset"), ("IDLE", "initialize"), ("INITIALIZE", None)):
            page.wait_for("#details .mark .word", "^%s" % state)
            self.wait_for_states({"robot": {"tuned": state}})
            if verb:
                self.order(verb)
        self.order("restart")
        page.wait_for("dialog h3", r"Restart robot\.tuned\?")
        page.click("dialog button.danger")
        page.wait_for("#details .commands .answer", "restart done, now EXECUTING")
        self.wait_for_states({"robot": {"tuned": "EXECUTING"}})
        self.select("line.fails")
        page.wait_for("#details .mark .word", "^RECOVER")
        page.wait_for("#details .why", "^failure: ")
        page.go("#/modules")
        page.watch_states()
        self.select("line.fails")
        self.order("recover")
        wait_until(lambda: "EXECUTING" in page.seen("line.fails"), "line.fails to execute again")

        # Set a property first to a value in its range, then to a value out of its range.
        self.select("robot.tuned")
        gain = "[data-property=gain]"
        page.wait_for(gain + " .about", "0 to 100")
        page.write(gain + " input", "2.5")
        page.click(gain + " button")
        page.wait_for(gain + " .answer", "is now 2.5")
        self.assertEqual(["2.5"], self.done("get robot.tuned gain"))
        page.write(gain + " input", "1000")
        page.click(gain + " button")
        page.wait_for_attribute(gain + " .answer", "data-look", "bad")
        self.assertEqual(["2.5"], self.done("get robot.tuned gain"))
        # The page must show input as text, never as HTML.
        label = "[data-property=label]"
        page.write(label + " input", "<img src=x onerror=document.title='x'>")
        page.click(label + " button")
        page.wait_for(label + " .answer", "is now <img")
        self.assertEqual(0, page.script("return document.querySelectorAll('img').length"))
        self.finish(web, apart=("409",))

    def test_a_command_is_answered_while_twenty_tabs_show_the_web_page(self):
        web = self.serve()
        self.cell()
        # Over plain HTTP, the address must have another host name than localhost. Otherwise, the browser trusts the page, and offers it more.
        here = re.sub(r"127\.0\.0\.1", socket.gethostname(), self.address)
        page = self.look("#/modules", local_names=[socket.gethostname()])
        page.driver.set_page_load_timeout(takt_system.LONG)
        page.open(here + "#token=" + TOKEN)
        self.assertFalse(page.script("return isSecureContext"))
        self.select("robot.tuned")
        first = page.driver.current_window_handle
        others = []
        for _ in range(19):
            others.append(page.open_tab(here + "#/modules"))
            page.wait_for("tr[data-module='robot.tuned'] .word", "^EXECUTING$")
        page.select_tab(first)
        took = []
        for verb in ("stop", "start") * takt_system.how_much("TAKT_TEST_COMMANDS", 10, 50):
            answer, took_ms = page.wait_script(ORDER, verb)
            self.assertRegex(answer, "^robot.tuned: %s done" % verb)
            took.append(took_ms)
        took.sort()
        print("from a click until the answer, with twenty tabs: %d commands, ms: p50 %.0f, p99 %.0f, longest %.0f"
              % (len(took), took[len(took) // 2], took[len(took) * 99 // 100], took[-1]))
        page.wait_script(ORDER, "stop")
        for tab in others:
            page.select_tab(tab)
            page.wait_for("tr[data-module='robot.tuned'] .word", r"^START \(stopped\)$")
        self.assertEqual(1, self.viewers(), "all tabs must share one event stream")
        self.finish(web)

    def proxy(self, server, name):
        """Starts nginx or Caddy with its configuration in docs/web.md, in which the host is `name`. Returns the process, and the address of
        the web page."""
        with open(os.path.join(takt_system.SOURCE, "docs", "web.md")) as docs:
            text = re.search(r"```%s\n([\s\S]*?)```" % server, docs.read())[1]
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-subj", "/CN=" + name, "-addext",
                        "subjectAltName=DNS:" + name, "-out", "cell.crt", "-keyout", "cell.key"],
                       cwd=self.folder, check=True, capture_output=True)
        replaced = {"nginx": (("443", "127.0.0.1:%d" % port), ("/etc/ssl", self.folder), ("cells.example.com", name)),
                    "caddyfile": (("cells.example.com {", "%s:%d {\nbind 127.0.0.1\ntls cell.crt cell.key\n" % (name, port)),)}[server]
        for documented, tested in replaced + (("127.0.0.1:8080", urllib.parse.urlparse(self.address).netloc),):
            self.assertIn(documented, text)
            text = text.replace(documented, tested)
        if server == "nginx":
            folders = "".join("%s_temp_path %s;\n" % (what, what) for what in ("client_body", "proxy", "fastcgi", "uwsgi", "scgi"))
            text = "daemon off;\nmaster_process off;\npid nginx.pid;\nevents {}\nhttp {\naccess_log off;\n%s%s}\n" % (folders, text)
            command = ["/usr/sbin/nginx", "-p", self.folder, "-e", "nginx.log", "-c", "nginx"]
        else:
            text = "{\nadmin off\nauto_https disable_redirects\nservers {\nprotocols h1 h2\n}\n}\n" + text
            command = ["/usr/bin/caddy", "run", "--adapter", "caddyfile", "--config", "caddyfile"]
        self.write(server, text)
        process = subprocess.Popen(command, cwd=self.folder, env=dict(os.environ, HOME=self.folder, XDG_DATA_HOME=self.folder, XDG_CONFIG_HOME=self.folder),
                                   stderr=subprocess.DEVNULL)
        self.addCleanup(process.wait)
        self.addCleanup(process.terminate)
        wait_until(lambda: listens(port), "%s to listen" % server)
        return process, "https://%s:%d/takt/" % (name, port)

    def test_the_web_page_works_behind_the_proxies_that_its_documentation_configures(self):
        name = "cells.test"
        self.running = self.nodes("robot", "line")
        self.deploy("cell.xml")
        for server, options in (("nginx", ()), ("caddyfile", ("--host-name", name))):
            web = self.serve(*options)
            proxy, behind = self.proxy(server, name)
            page = self.look("#/modules", local_names=[name])
            page.open(behind + "#token=" + TOKEN)
            page.wait_for("#rights", "may command")
            self.select("robot.tuned")
            took = []
            for verb, state in (("stop", "START"), ("start", "EXECUTING")) * 10:
                answer, took_ms = page.wait_script(ORDER, verb)
                self.assertRegex(answer, "^robot.tuned: %s done, now %s" % (verb, state))
                page.wait_for("#details .mark .word", "^" + state)
                took.append(took_ms)
            took.sort()
            print("from a click until the answer, behind a proxy (%s): %d commands, ms: p50 %.0f, longest %.0f"
                  % (server, len(took), took[len(took) // 2], took[-1]))
            # nginx does not forward this header, but without it, nginx holds back events until there are more of them.
            with urllib.request.urlopen(self.address + "api/events", timeout=takt_system.LONG) as events:
                self.assertEqual("no", events.headers["X-Accel-Buffering"])
            page.go("#/plots?port=robot.source.out")
            page.wait_for(VALUE, r"^\d+$")
            self.assertEqual(200, page.wait_script("fetch('metrics').then((answer) => done(answer.status))"))
            self.assertEqual([], page.errors())
            page.close()
            proxy.terminate()
            proxy.wait()
            web.signal(signal.SIGTERM)
            self.assertEqual(0, web.wait().status, web.err)
        self.done("undeploy cell")
        self.end(self.running)

    def test_a_hidden_tab_of_the_web_page_gets_no_events_until_it_is_shown(self):
        web = self.serve()
        self.cell()
        page = self.look("#/modules?select=robot.tuned")
        first = page.driver.current_window_handle
        page.wait_for("#details .steps li", "EXECUTING$")
        alone = page.open_tab("about:blank", "window")
        page.without_shared_workers()
        page.open(self.address + "#/modules")
        page.wait_for("tr[data-module='robot.tuned'] .word", "^EXECUTING$")
        third = page.open_tab(self.address + "#/modules?select=robot.tuned", "window")
        self.wait_for_viewers(2)
        page.select_tab(alone)
        page.hide()
        self.wait_for_viewers(1)
        page.select_tab(first)
        page.hide()
        page.select_tab(third)
        for verb, state in (("stop", r"^START \(stopped\)$"), ("start", "^EXECUTING$"), ("stop", r"^START \(stopped\)$")):
            self.done(verb + " robot.tuned")
            page.wait_for("tr[data-module='robot.tuned'] .word", state)
        told = page.texts(".steps li")
        page.select_tab(first)
        self.assertRegex(page.states()["robot.tuned"], "EXECUTING$")  # or "lost, was EXECUTING", on a busy machine
        page.show()
        page.wait_for("tr[data-module='robot.tuned'] .word", r"^START \(stopped\)$")
        wait_until(lambda: page.texts(".steps li") == told, "all state changes, including those while the tab was hidden")
        page.select_tab(third)
        page.driver.close()
        page.select_tab(alone)
        self.assertRegex(page.states()["robot.tuned"], "EXECUTING$")  # or "lost, was EXECUTING", on a busy machine
        page.show()
        page.wait_for("tr[data-module='robot.tuned'] .word", r"^START \(stopped\)$")
        self.wait_for_viewers(2)
        self.finish(web)

    def test_tabs_of_the_web_page_can_plot_different_ports(self):
        with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "cell.xml")) as file:
            cell = file.read().replace("<name>tuned</name> <filename>cpp_properties.so", "<name>other</name> <filename>port_source.so")
        web = self.serve()
        self.cell(self.write("cell.xml", cell))
        page = self.look("#/plots?port=robot.source.out")
        tabs = [page.driver.current_window_handle]
        tabs += [page.open_tab(self.address + "#/plots?port=robot.%s.out" % module, "window") for module in ("other", "source")]

        def number():
            return int(page.wait_for(VALUE, r"^\d+$"))

        def plots():
            last = number()
            wait_until(lambda: number() > last + 50, "newer values")
        for tab in tabs:
            page.select_tab(tab)
            plots()
        # A plot must go on after its tab was hidden, and while another tab chooses another port.
        page.hide()
        page.select_tab(tabs[0])
        page.go("#/plots?port=robot.source.nothing")
        page.wait_for(".tools [role=status]", "no port")
        page.select_tab(tabs[1])
        plots()
        page.select_tab(tabs[2])
        page.show()
        plots()
        self.assertEqual(1, self.viewers(), "all tabs must share one event stream")
        # A tab that plots a port of another tab gets also the values from before it was opened.
        before = number()
        page.open_tab(self.address + "#/plots?port=robot.source.out", "window")
        plots()
        self.assertLess(int(page.text(".legend-table td[data-label=minimum]")), before - 50)
        self.finish(web)

    def test_the_web_page_is_read_only_without_the_token(self):
        web = self.serve()
        self.cell()
        page = self.look("#/modules?select=robot.tuned")
        page.wait_for("#rights", "read-only")
        page.wait_for("#details .mark .word", "^EXECUTING")
        page.wait_for("#commands-why", "^Read-only: .*token")
        page.wait_for("[data-property=gain] .name", "gain")
        self.assertTrue(page.script("return [...document.querySelectorAll('.commands button, .property input, .property button')]"
                                    ".every((one) => one.disabled)"))
        # The gateway must also reject requests that do not come from the page.
        order = json.dumps({"device": "robot", "module": "tuned", "verb": "stop"})
        self.assertEqual(403, page.wait_script("fetch('/api/command', {method: 'POST', body: arguments[0]}).then((a) => done(a.status))",
                                               order))
        for token in (None, "wrong"):
            request = urllib.request.Request(self.address + "api/command", order.encode(),
                                             {"Authorization": "Bearer " + token} if token else {})
            with self.assertRaises(urllib.error.HTTPError) as refused:
                urllib.request.urlopen(request, timeout=takt_system.LONG)
            self.assertEqual(403, refused.exception.code)
            refused.exception.close()
        self.assertEqual("EXECUTING", self.on_dds()["robot.tuned"])
        # If the address with the token is opened in the same tab, the page may send commands.
        page.go("#token=" + TOKEN)
        page.wait_for("#rights", "may command")
        self.assertNotIn(TOKEN, page.script("return location.href"))
        self.finish(web, apart=("403",))

    def test_every_function_of_the_web_page_can_be_used_with_the_keyboard(self):
        web = self.serve()
        self.cell()
        page = self.look("#token=" + TOKEN)
        page.wait_for("[data-module='robot.tuned'] .state-word", "EXECUTING")
        page.press_until(Keys.TAB, lambda focused: focused == "Cell")
        for view in VIEWS[1:]:
            page.press(Keys.ARROW_RIGHT)
            wait_until(lambda: page.script("return location.hash").startswith("#/" + view), view)
        page.press(Keys.HOME)
        # In the graph, keys move from box to box and select a box.
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
        wait_until(lambda: page.text("#details h2") is None, "the details to be closed")
        # In the list, keys select a module and stop it.
        page.press_until(Keys.TAB, lambda focused: focused == "Cell")
        page.press(Keys.ARROW_RIGHT)
        page.wait_for("tr[data-module='robot.tuned'] .word", "EXECUTING")
        page.press_until(Keys.TAB, lambda focused: focused == "robot")
        page.press_until(Keys.ARROW_DOWN, lambda focused: focused == "tuned")
        page.press(Keys.ENTER)
        page.wait_for("#details h2", r"^robot\.tuned$")
        page.press_until(Keys.TAB, lambda focused: focused == "Stop")
        page.press(Keys.ENTER)
        page.wait_for("dialog h3", r"Stop robot\.tuned\?")
        page.press_until(Keys.TAB, lambda focused: focused == "Stop")
        page.press(Keys.ENTER)
        self.wait_for_states({"robot": {"tuned": "START"}})
        page.wait_for("#details .mark .word", "^START")
        wait_until(lambda: page.focused() == "Start", "the focus on Start, because Stop is disabled")
        page.press("6")
        page.wait_for(".executor summary", "Where the time went")
        page.press("t", Keys.PAGE_UP, "2")
        wait_until(lambda: re.match("#/modules.*[?&]at=", page.script("return location.hash")), "an instant a minute ago")
        page.press("t", Keys.END)
        wait_until(lambda: "at=" not in page.script("return location.hash"), "the present")
        # The page announces the change to a screen reader.
        page.wait_for("#spoken", r"robot\.tuned START")
        page.press(Keys.ESCAPE)
        wait_until(lambda: page.focused() == "tuned", "the focus to return")
        self.finish(web)

    def test_the_tree_of_the_web_page_shows_the_worst_first_and_finds_a_module_by_its_name(self):
        web = self.serve()
        self.cell()
        page = self.look("#/connections")
        wait_until(lambda: page.texts("[role=treeitem] .name")[:2] == ["line", "fails"], "the module in RECOVER as the first in the tree")
        page.wait_for("[data-item='line.fails'] .state", "^ RECOVER$")
        page.press("/")
        self.assertEqual("find a device or module by name or state", page.focused())
        page.press(*"tune")
        wait_until(lambda: page.texts("[role=treeitem] .name") == ["robot", "tuned"], "the module that was searched for")
        page.press(Keys.ENTER)
        page.wait_for("#details h2", r"^robot\.tuned$")
        page.press("/", *"sink", Keys.ESCAPE)
        page.wait_for("[data-item='robot.source'] .name", "source")
        self.assertEqual("robot.tuned", page.text("#details h2"), "this Escape only clears the search")
        page.press(Keys.ARROW_DOWN, Keys.ARROW_DOWN, Keys.ENTER)
        page.wait_for("#details h2", r"^line\.fails$")

        # The selection stays in every view, and a folded column stays folded.
        page.click("#tab-faults")
        page.wait_for(".faults .what", "failure")
        self.assertEqual("line.fails", page.text("#details h2"))
        for column in ("tree", "details"):
            page.click("#%s-button" % column)
            page.wait_for_attribute("#%s-button" % column, "aria-expanded", "false")
        page.open("about:blank")
        page.open(self.address + "#/faults?select=line.fails")
        page.wait_for(".faults .what", "failure")
        self.assertEqual([[], []], [page.texts("[role=treeitem]"), page.texts("#details h2")])
        page.click("#details-button")
        page.wait_for("#details h2", r"^line\.fails$")

        # On a narrow screen, neither the tree nor the details cover Stop.
        for width, height in ((390, 844), (768, 1024)):
            page.size(width, height)
            self.select("robot.tuned")
            wait_until(lambda: not page.texts("[role=treeitem]"), "the tree to be closed")
            page.click("#tree-button")
            page.wait_for("[data-item='line.fails']", "fails")
            self.assertTrue(page.script("""
                const stop = document.querySelector("#details [data-verb=stop]"), {left, top, width, height} = stop.getBoundingClientRect();
                return document.elementFromPoint(left + width / 2, top + height / 2) === stop;"""), "%d px" % width)
            page.click("[data-item='line.fails']")
            page.wait_for("#details h2", r"^line\.fails$")
            wait_until(lambda: not page.texts("[role=treeitem]"), "the tree to be closed")
        self.finish(web)

    def test_the_details_show_the_values_of_ports_and_a_star_puts_them_on_the_watch_list(self):
        web = self.serve()
        self.cell()
        page = self.look("#/plots?port=robot.source.out")
        page.wait_for(VALUE, r"^\d+$")

        def number(field):
            return int(page.wait_for(field + " .value", r"^\d+$"))
        # The values of an output, and, for an input, the values of the output that is connected to it.
        for module, direction in (("robot.source", "writes"), ("line.sink", "reads")):
            page.go("#/connections?select=" + module)
            page.wait_for("#details .ports li", " %s " % direction)
            first = number("#details [data-field='robot.source.out.number']")
            wait_until(lambda: number("#details [data-field='robot.source.out.number']") > first + 50, "newer values")
        page.wait_for("#details [data-field='robot.source.out.same[0]'] .value", r"^\d+ mm$")
        wait_until(lambda: page.script("""
            const canvas = document.querySelector("#details [data-field='robot.source.out.number'] canvas");
            return canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.some((of) => of > 0)"""), "the trend")
        page.go("#/connections")
        page.click("tr[data-connection='0'] .ends")
        page.wait_for("#details .ends", "^robot.source.out \u2192 line.sink.in$")
        page.wait_for("#details .facts dd", "latest, .*deadline 500 ms")
        number("#details [data-field='robot.source.out.number']")

        # The watch list stays in the address, so it survives another view and a reload.
        page.click("button[aria-label='watch robot.source.out.number']")
        page.wait_for_attribute("button[aria-label='watch robot.source.out.number']", "aria-pressed", "true")
        page.press(Keys.ESCAPE)
        page.click("#tab-watch")
        self.assertEqual(["robot.source.out.number"], page.texts(".watch tbody th"))
        first = number(".watch")
        wait_until(lambda: number(".watch") > first + 50, "newer values")
        page.click("#tab-faults")
        address = page.script("return location.href")
        page.open("about:blank")
        page.open(address.replace("/faults", "/watch"))
        number(".watch")
        page.wait_for(".watch .age", "^< 1 s$")
        page.click(".tools a")
        page.wait_for(VALUE, r"^\d+$")
        page.click("#tab-watch")
        page.click(".watch .star")
        page.wait_for(".tools [role=status]", "^Nothing is watched")
        self.finish(web, apart=("willReadFrequently",))

    @takt_system.quiet("the test looks for an older event, and rows missed on a busy machine would be many newer events")
    def test_the_strip_of_time_moves_the_faults_and_the_plots_to_an_instant(self):
        web = self.serve()
        self.cell()
        page = self.look("#/cell")
        page.wait_for("#strip .caption", r"\b1 error\b")
        self.done("stop robot.tuned")
        page.go("#/faults?severity=all")
        page.wait_for(".faults .what", "^command")
        page.go("#/cell")

        def at():
            return page.script("return Number(new URLSearchParams(location.hash.split('?')[1]).get('at'))")
        page.press_until(Keys.TAB, lambda focused: focused.startswith("instant that the page shows"))
        told = []
        for _ in range(100):  # from the newest event to the failure of line.fails, which is older than the command
            before = at()
            page.press(Keys.ARROW_LEFT)
            wait_until(lambda: at() != before, "the event before")
            told.append(page.wait_for("#strip .caption", "^[\\d:.]+ "))
            if "failure" in told[-1]:
                break
        self.assertRegex("\n".join(told), r"robot\.tuned: command")
        self.assertRegex(told[-1], r"^[\d:.]+ line\.fails: error: failure: .*run")
        page.wait_for("tr.selected .what", "failure")
        self.assertEqual("true", page.attribute("#tab-faults", "aria-selected"), "the view Cell shows no past")
        listed = "\n".join(page.texts(".faults tbody tr"))
        self.assertRegex(listed, "failure", "the list has the event")
        self.assertNotRegex(listed, r"tuned\s*command", "the list begins at the instant; the command is newer")
        page.wait_for(".tools [role=status]", "; until [\\d:.]+$")
        failed = at()

        address = page.script("return location.href")
        page.open("about:blank")
        page.open(address)
        page.wait_for("tr.selected .what", "failure")
        page.click("#strip .live")
        wait_until(lambda: at() == 0, "the present")
        page.click("#strip .span")
        page.wait_for("#strip .span", "^last 10 min$")
        page.wait_for("#strip .caption", r"\b1 error\b")
        page.click("#strip .span")
        page.wait_for("#strip .span", "^last hour$")
        page.wait_for_attribute("#strip .live", "aria-pressed", "true")

        # A click on the mark of the error does the same, and a second click returns to the present.
        place = page.script("""
            const canvas = document.querySelector(".marks");
            const wanted = getComputedStyle(document.documentElement).getPropertyValue("--bad").match(/[0-9a-f]{2}/g);
            const {data} = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
            for (let i = 0; i < data.length; i += 4) {
              if (data[i + 3] > 200 && wanted.every((of, j) => Math.abs(data[i + j] - parseInt(of, 16)) < 20)) {
                return [i / 4 % canvas.width - canvas.width / 2, Math.floor(i / 4 / canvas.width) - canvas.height / 2];
              }
            }""")
        marks = page.driver.find_element("css selector", ".marks")
        ActionChains(page.driver).move_to_element_with_offset(marks, *map(round, place)).click().perform()
        wait_until(lambda: at() == failed, "the instant of the failure")
        page.go("#/plots?series=robot.source.out.number&at=%s" % failed)
        page.wait_for(".at", "; mark at ")
        self.assertEqual("true", page.attribute(".tools button", "aria-pressed"), "the plot stands still")
        ActionChains(page.driver).move_to_element_with_offset(marks, *map(round, place)).click().perform()
        wait_until(lambda: at() == 0, "the present")
        self.assertEqual("false", page.attribute(".tools button", "aria-pressed"))
        page.go("#/plots?series=robot.source.out.number&at=1000")
        page.wait_for(".tools [role=status]", r"^no values of robot\.source\.out\.number before [\d:.]+$")
        page.click("#strip .live")
        wait_until(lambda: page.text(".tools [role=status]") == "", "values of the present")

        # The strip says which time has no events, and shows many events at one place as one mark with their number.
        self.assertEqual(["20000 warnings, 1 note", "; some from before", "overrun: late; 19999 more events here", 2, "last 10 min: no events"], page.wait_script("""
            Promise.all([import("/store.js"), import("/strip.js")]).then(async ([{Store}, {Strip}]) => {
              const store = new Store();
              const place = document.body.appendChild(document.createElement("section"));
              const strip = new Strip(place, store);
              strip.canvas.element.style.cssText = "display: block; width: 1000px; height: 52px; position: fixed; inset: 0 auto auto 0";
              const begin = Date.now() - 1800000;
              const fault = (i, more) => ({device: "robot", module: "one", kind: "overrun", severity: "warning", cause: "late", time_ms: begin + i, count: 1, ...more});
              let marks = 0;
              const fill = CanvasRenderingContext2D.prototype.fill;
              CanvasRenderingContext2D.prototype.fill = function() { ++marks; return fill.call(this); };
              store.takeFaults({whole: true, events: Array.from({length: 500}, (_, i) => fault(19500 + i))});
              strip.show();
              store.takeFaults({earlier: true, events: Array.from({length: 19000}, (_, i) => fault(500 + i))});
              strip.update({faults: true});
              for (let i = 499; i >= 0; --i) {
                store.takeFaults({events: [fault(i)]});  // of a device whose clock is behind
                strip.update({faults: true});
              }
              store.takeFaults({events: [fault(-7200000), fault(600000, {severity: "note", kind: "command"}), fault(0, {severity: "note", kind: "log-info"})]});
              await new Promise((drawn) => requestAnimationFrame(() => setTimeout(drawn, 100)));
              marks = 0;
              strip.update({faults: true});
              const drawn = marks;
              const all = strip.caption.textContent;
              store.takeFaults({earlier: true, events: [], complete_since_ms: begin});
              strip.update({faults: true});
              const since = strip.caption.textContent.slice(all.length).replace(/ [\\d:]+ are missing$/, "");
              strip.canvas.element.dispatchEvent(new PointerEvent("pointermove", {clientX: strip.canvas.element.clientWidth / 2 - 8, clientY: 18}));
              const pointed = strip.caption.textContent.replace(/^.*robot.one: /, "");
              strip.canvas.element.dispatchEvent(new PointerEvent("pointerleave"));
              history.replaceState(null, "", "#/plots?span=10min");
              strip.show();
              done([all, since, pointed, drawn, `${strip.span.textContent}: ${strip.caption.textContent}`]);
            }).catch((error) => done(String(error)));"""))
        self.finish(web, apart=("willReadFrequently",))

    @takt_system.quiet("the browser competes with other tests for the CPUs")
    def test_the_web_page_marks_its_data_as_outdated_while_the_gateway_is_unreachable(self):
        web = self.serve()
        port = int(re.search(r":(\d+)/", self.address)[1])
        self.cell()
        page = self.look("#token=" + TOKEN)
        self.select("robot.tuned")
        page.wait_for("#details .mark .word", "^EXECUTING")
        web.signal(signal.SIGKILL)
        web.wait()
        page.wait_for("#link", "connection lost, reconnecting")
        page.wait_for("#stale", "The page shows the last known state")
        self.assertEqual("alert", page.attribute("#stale", "role"))
        page.wait_for("#commands-why", "connection to takt web is lost")
        self.assertTrue(page.script("return [...document.querySelectorAll('.commands button')].every((one) => one.disabled)"))
        self.assertNotEqual("none", page.script("return getComputedStyle(document.querySelector('#main')).filter"))
        self.done("stop robot.tuned")
        web = self.serve(port=port)
        page.wait_for("#link", "^live$")
        page.wait_for("#details .mark .word", "^START")
        wait_until(lambda: page.text("#stale") is None, "the warning to be gone")
        page.go("#/modules")
        self.wait_until_as_on_dds()
        self.select("robot.tuned")
        self.order("start")
        self.wait_for_states({"robot": {"tuned": "EXECUTING"}})
        self.finish(web, apart=("ERR_CONNECTION_REFUSED", "ERR_INCOMPLETE_CHUNKED", "ERR_CONTENT_LENGTH_MISMATCH", "ERR_EMPTY",
                                "ERR_CONNECTION_RESET"))

    def test_the_web_page_shows_live_port_values_and_executor_tables(self):
        web = self.serve()
        self.cell()
        page = self.look("#/plots")
        page.wait_for(".tools [role=status]", "^Choose a port")
        page.go("#/plots?port=robot.source.out")
        number = int(page.wait_for(VALUE, r"^\d+$"))
        wait_until(lambda: int(page.text(VALUE)) > number + 300, "values of the next three seconds")
        wait_until(lambda: page.script(PIXELS, "series-1") > 20, "the curve")
        page.go("#/table?device=robot")
        page.wait_for(".executor summary", "Where the time went")
        wait_until(lambda: {"source", "tuned", "program (program)"} <= set(page.texts(".executor details tbody th")), "all modules")
        page.go("#/modules?select=robot.source")
        page.wait_for(".ports li", r"line\.sink\.in.*(ok|\d+ late)")
        page.wait_for("#details .bar .words", r"p99 run time .* us of 5 ms budget")
        self.finish(web, apart=("willReadFrequently",))

    @takt_system.quiet("the browser competes with other tests for the CPUs")
    def test_an_open_web_page_shows_a_new_deployment_without_a_reload(self):
        web = self.serve()
        page = self.look("#/constructor")  # there is no view of this name, but every JavaScript object has a member of this name
        page.wait_for("#tabs [aria-selected=true]", "^Cell$")
        page.go("#/table?device=robot")
        page.wait_for(".table-view .answer", "no cell is running")
        self.cell()
        page.wait_for(".executor summary", "Where the time went")
        self.done("undeploy cell")
        page.wait_for(".table-view .answer", "no cell is running")
        page.go("#/plots?port=robot.source.out")
        page.wait_for(".tools [role=status]", r"^(?!waiting)\w")
        self.deploy("cell.xml")
        page.wait_for(VALUE, r"^\d+$")
        wait_until(lambda: page.script("return document.querySelectorAll('optgroup[label=robot] option').length"), "the list of ports")

        # A new module replaces the old one of the same name. The page must show the new one.
        page.go("#/table?device=robot&select=robot.tuned")
        page.wait_for("[data-property=gain] .name", "gain")
        page.wait_for(".executor summary", "Where the time went")
        with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "cell.xml")) as file:
            text = file.read().replace("cpp_properties.so", "port_source.so")
        self.done("undeploy cell")
        page.wait_for(".table-view .answer", "no cell is running")
        self.deploy(self.write("other.xml", text))
        page.wait_for("#details .ports li", "^out writes")
        page.wait_for(".executor summary", "Where the time went")
        self.assertIsNone(page.text("[data-property=gain]"))
        self.finish(web, apart=("409", "404"))

    def test_the_overrun_filter_of_the_web_page_shows_a_module_after_its_first_overrun(self):
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
        self.assertEqual(0, web.wait().status, web.err)

    def test_the_fault_list_of_the_web_page_counts_new_events_while_it_is_paused(self):
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
              view.body.querySelector("td:nth-child(3) a").click();
              const address = location.hash;
              view.pause.click();
              store.takeFaults({events: [fault("its clock is behind", 1000)]});
              view.update({faults: true});
              const said = view.count.textContent;
              view.pause.click();
              done([address, said, view.body.querySelector(".what").textContent]);
            }).catch((error) => done(String(error)));""")
        self.assertEqual(["#/faults?text=old&select=robot.one", "2000 events; paused, 1 new", "overrun: its clock is behind"], found)
        web.signal(signal.SIGTERM)
        self.assertEqual(0, web.wait().status, web.err)

    def test_the_fault_list_of_the_web_page_joins_equal_faults(self):
        web = self.serve()
        page = self.look()
        found = page.wait_script("""
            Promise.all([import("/store.js"), import("/faults.js")]).then(async ([{Store}, {Faults}]) => {
              const store = new Store();
              const view = new Faults(store);
              document.body.append(view.element);
              const fault = (module, time_ms, more) => ({device: "robot", module, kind: "overrun", severity: "warning", cause: `at ${time_ms}`, time_ms, count: 1, ...more});
              const note = (time_ms) => fault("one", time_ms, {kind: "command", severity: "note"});
              store.takeFaults({whole: true, events: [fault("one", 1000), fault("two", 2000, {count: 3}), note(2500), note(2600), fault("one", 3000)]});
              history.replaceState(null, "", "#/faults?severity=all");
              view.show(new URLSearchParams("severity=all"));
              const said = () => [...view.body.rows].map((row) => [row.cells[2].textContent, row.querySelector(".what").textContent.replace(/until .*/, "until T")]);
              const single = said().length;
              view.equal.click();
              const joined = said();
              const line = view.body.rows[3];
              line.focus();
              store.takeFaults({events: [fault("one", 4000)]});
              view.update({faults: true});
              const address = location.hash;
              const count = said().length;
              store.takeFaults({whole: true, events: [fault("one", 5000, {cause: "left"}), fault("one", 6000, {cause: "right"})]});
              const only = (text) => (view.show(new URLSearchParams(`group=on&text=${text}`)), said()[0][1]);
              done([single, joined, said()[3], document.activeElement === line, address, count, only("left"), only("right")]);
            }).catch((error) => done(String(error)));""")
        self.assertEqual([5, [["robot.one", "command: at 2600"], ["robot.one", "command: at 2500"], ["robot.two", "overrun: at 20003 times until T"],
                              ["robot.one", "overrun: at 30002 times until T"]],
                          ["robot.one", "overrun: at 40003 times until T"], True, "#/faults?severity=all&group=on", 4,
                          "overrun: left", "overrun: right"], found)
        self.assertEqual([], page.errors())
        web.signal(signal.SIGTERM)
        self.assertEqual(0, web.wait().status, web.err)

    def test_the_web_page_reads_the_events_that_are_older_than_those_of_its_stream(self):
        web = self.serve()
        page = self.look()
        self.assertEqual([[1, 2, 3, 4, 5], ["api/faults?before=4", "api/faults?before=2"], 7000], page.wait_script("""
            Promise.all([import("/stream.js"), import("/store.js")]).then(([{Stream}, {Store}]) => {
              const fault = (sequence) => ({device: "robot", module: "one", kind: "overrun", severity: "warning", cause: "", sequence, time_ms: sequence, count: 1});
              const store = new Store();
              const asked = [];
              window.fetch = async (address) => {
                asked.push(address);
                const older = address.endsWith("=4");
                return {ok: true, json: async () => ({events: older ? [fault(2), fault(3)] : [fault(1)], older: older ? 2 : 0, complete_since_ms: 7000})};
              };
              window.EventSource = class {
                addEventListener(name, act) {
                  if (name !== "faults") return;
                  setTimeout(() => act({data: JSON.stringify({whole: true, events: [fault(4)], older: 4, problems: []})}));
                  setTimeout(() => act({data: JSON.stringify({whole: false, events: [fault(5)], problems: []})}));
                }
                close() {}
              };
              new Stream((name, data) => {
                store.take(name, data);
                if (store.faults.length === 5) done([store.faults.map(({sequence}) => sequence), asked, store.faultsSince]);
              }, () => {}).rest(false);
            }).catch((error) => done(String(error)));"""))
        web.signal(signal.SIGTERM)
        self.assertEqual(0, web.wait().status, web.err)

    def test_the_web_page_shows_every_state_change_of_a_hundred_modules(self):
        modules = "".join("<module><name>m%d</name><filename>cpp_properties.so</filename><moduletype>thread</moduletype>"
                          "<operationtype>periodic</operationtype><period>10000000</period><priority>%d</priority></module>\n" % (i, i)
                          for i in range(100))
        file = self.write("cell.xml", '<cell name="cell"><device name="robot">\n%s</device></cell>\n' % modules)
        web = self.serve()
        self.cell(file, ("robot",))
        page = self.look("#/modules")
        wait_until(lambda: list(page.states().values()) == ["EXECUTING"] * 100, "a hundred modules EXECUTING")
        page.watch_states()
        page.script("""window.frames_ms = []; let last = performance.now();
            const frame = (now) => { window.frames_ms.push(now - last); last = now; requestAnimationFrame(frame); };
            requestAnimationFrame(frame);
            window.told = {};  // the time of each step by the node's clock, which is also the browser's
            new EventSource("/api/events").addEventListener("state", (event) => JSON.parse(event.data).modules
              .forEach((module) => (window.told[module.name] ??= []).push([module.state, module.time_ms])));""")
        wait_until(lambda: len(page.script("return window.told")) == 100, "the second stream")
        told = []
        for verb, state in (("stop", "START"), ("start", "EXECUTING")) * 3:
            self.done("%s robot" % verb)
            word = "START (stopped)" if state == "START" else state
            wait_until(lambda: set(page.states().values()) == {word}, "all of them %s" % word)
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
            seen = [state for state, _ in seen if state != "lost"]  # the page shows this text for a moment if the machine stalls
            self.assertEqual(["EXECUTING"] + told, [state for i, state in enumerate(seen) if i == 0 or seen[i - 1] != state], module)
        frames = sorted(page.script("return window.frames_ms"))
        print("frames with a hundred modules: %d, ms: p50 %.1f, p99 %.1f, longest %.1f"
              % (len(frames), frames[len(frames) // 2], frames[len(frames) * 99 // 100], frames[-1]))
        page.go("#/cell")
        page.wait_for("[data-module='robot.m0'] .state-word", "EXECUTING")
        self.finish(web)

    def test_a_tab_of_the_web_page_opens_its_view_as_the_user_left_it_with_the_current_selection(self):
        web = self.serve()
        self.cell()
        page = self.look("#/plots?series=robot.source.out.number&range=60")
        page.wait_for(VALUE, r"^\d+$")
        for name in ("robot.tuned", "robot.source"):
            page.click("[data-item='%s']" % name)
            page.click("#tab-modules")
            page.wait_for("#details h2", "^%s$" % re.escape(name))
            page.click("#tab-plots")
            page.wait_for("#details h2", "^%s$" % re.escape(name))
            self.assertEqual("#/plots?select=%s&series=robot.source.out.number&range=60" % name, page.script("return location.hash"))
            page.wait_for(".legend-table th", "^robot.source.out.number$")
        # The time of an event is a link that takes all views to this instant.
        page.click("#tab-faults")
        page.click(".faults tbody .time a")
        self.assertRegex(page.script("return location.hash"), r"^#/faults\?select=robot\.source&at=\d+")
        page.wait_for_attribute(".faults tbody tr", "class", "selected")
        self.finish(web)

    def test_no_line_of_the_tree_moves_away_below_the_mouse(self):
        web = self.serve()
        self.cell()
        page = self.look("#/modules")
        page.wait_for("[data-item='robot.source']", "source")
        wait_until(lambda: page.states().get("robot.source") == "EXECUTING", "EXECUTING")

        def lines():
            return page.script("return [...document.querySelectorAll('[data-item]')].map((one) => one.dataset.item)")
        page.hover("[data-item='robot.source']")
        before = lines()
        for verb, state in (("stop", "START (stopped)"), ("start", "EXECUTING"), ("stop", "START (stopped)")):
            self.done(verb + " robot.tuned")
            wait_until(lambda: page.states()["robot.tuned"] == state, state)
            self.assertEqual(before, lines())
        page.hover("#view")
        wait_until(lambda: lines() != before, "the stopped module above the others")
        self.finish(web)

    def test_the_view_modules_says_how_often_a_run_time_exceeded_the_budget(self):
        file = self.write("cell.xml", '<cell name="cell"><device name="robot"><module><name>slow</name><filename>slow.so</filename>'
                          '<moduletype>thread</moduletype><operationtype>periodic</operationtype><period>10ms</period><priority>1</priority>'
                          '<budget times="1000">10us</budget></module></device></cell>')
        web = self.serve()
        self.cell(file, ("robot",))
        page = self.look("#/modules?only=over")
        page.wait_for("[data-module='robot.slow'] .some", r"^\d+ over$")
        self.finish(web)

    def test_the_web_page_is_usable_on_phones_tablets_and_desktop_screens(self):
        web = self.serve()
        self.cell()
        page = self.look("#token=" + TOKEN)
        page.wait_for("#summary", "in RECOVER")
        for width, height in ((390, 844), (768, 1024), (1024, 768), (1440, 900)):
            page.size(width, height)
            for view in VIEWS + ("modules?select=robot.tuned", "cell?select=robot"):
                page.go("#/" + view)
                time.sleep(0.3)  # replies of the gateway may make the page wider
                with self.subTest(width=width, view=view):
                    self.assertLessEqual(page.script("return Math.max(document.documentElement.scrollWidth, ...[...document.querySelectorAll("
                                                     "'.scrolled, #details')].map((one) => one.scrollWidth - one.clientWidth + innerWidth))"),
                                         width)
                    self.assertEqual([], page.script("""
                        return [...document.querySelectorAll("button, select, input:not([type=checkbox]), [role=tab]")]
                          .filter((one) => one.checkVisibility() && (one.getBoundingClientRect().height < 39.5 ||
                                                                     (one.role !== "tab" && one.getBoundingClientRect().right > innerWidth)))
                          .map((one) => `${one.textContent}: ${one.getBoundingClientRect().height}`)"""))
                    self.assertEqual([], page.script(CUT), "selects whose text is cut off")
                    self.assertEqual([], page.script("""
                        const left = (one) => one.getBoundingClientRect().left;
                        return [...document.querySelectorAll("tr[data-module][aria-selected=true] .name")]
                          .map((one) => left(one) - left(one.closest("tr"))).filter((away) => away < 8)"""), "text on the bar of the selected row")
                    self.assertEqual([], page.script(TABS), "tabs that are not in one line, or too small for a finger, or not shown when selected")
            if width == 390:
                page.go("#/cell?select=robot")
                page.wait_for("#details h2", "^robot$")
                self.assertEqual([], page.texts(".graph .tools"), "the drawing has too little room for the buttons")
                page.go("#/cell")
                wait_until(lambda: page.texts(".graph .tools"), "the buttons of the drawing")
                page.go("#/modules?select=robot.tuned")
                wait_until(lambda: page.script("return document.querySelector('#details [data-verb=stop]').getBoundingClientRect().height") >= 60,
                           "a button for Stop that is large enough for a thumb")
            page.go("#/cell")
            page.wait_for("[data-module='robot.tuned'] .state-word", ".")
            self.assertEqual([], page.script("""
                const surface = document.querySelector(".surface").getBoundingClientRect();
                return [...document.querySelectorAll(".graph button")].map((one) => [one.textContent, one.getBoundingClientRect()])
                  .filter(([, box]) => box.bottom > surface.top && box.top < surface.bottom && box.height > 0).map(([text]) => text)"""),
                             "buttons that cover the drawing")
            self.assertTrue(page.script("return document.querySelector('.drawing path.trend').checkVisibility()"),
                            "the trend of the jitter at a width of %d px" % width)
            for high in (height, 300):
                page.size(width, high)
                time.sleep(0.3)
                self.assertGreater(page.script("return document.querySelector('.drawing .state-word').getBoundingClientRect().height"), 7,
                                   "the text of the drawing must be legible at %d x %d px" % (width, high))
        page.size(768, 1024)
        page.go("#/alarms")
        page.wait_for(".alarms .mark .word", "^unacknowledged")
        self.assertEqual([], page.script("""
            const top = (one) => one.getBoundingClientRect().top;
            return [...document.querySelectorAll(".alarms .mark")].filter((mark) => {
              mark.querySelector(".word").textContent = "unacknowledged, returned to normal, and some more words in a second line";
              return top(mark.querySelector(".sign")) - top(mark.querySelector(".word")) > 6;
            }).map((mark) => mark.textContent);"""), "signs that do not stand in the first line of their words")
        for width in (768, 801, 1001, 1024, 1280):
            page.size(width, 900)
            for view in ("modules", "modules?select=robot.tuned") if width >= 1280 else ("modules",):
                page.go("#/" + view)
                time.sleep(0.3)
                with self.subTest(width=width, view=view):
                    self.assertGreater(page.script("return document.querySelector('tr[data-module] th').clientWidth"), 150, "name width")
        page.go("#/cell")
        page.wait_for("[data-device=robot] .state-word", ".")
        self.assertEqual([], page.script("""
            return [...document.querySelectorAll(".drawing rect")].filter((one) => Math.abs(one.getBBox().height - one.getAttribute("height")) > 0.1)
              .map((one) => `${one.getAttribute("class")}: ${one.getBBox().height}`)"""), "boxes that do not have their drawn height")
        for theme in ("light", "dark"):
            page.prefer(theme)
            page.wait_for_attribute("html", "data-theme", theme)
            for view in VIEWS + ("modules?select=line.fails",):
                page.go("#/" + view)
                time.sleep(0.3)
                with self.subTest(theme=theme, view=view):
                    self.assertEqual([], page.script(CONTRAST))
            self.assertEqual([True], page.script("""
                const probe = document.body.appendChild(document.createElement("i"));
                return [...new Set([...document.querySelectorAll(".dash line")].map((one) => {
                  probe.style.color = `var(--${one.getAttribute("class")})`;
                  return getComputedStyle(probe).color === getComputedStyle(one).stroke;
                }))]"""),
                             "the lines of a legend must have the colour of the curves")
        self.finish(web)

    def test_the_graph_shows_the_newest_value_of_each_visible_wire(self):
        web = self.serve()
        self.cell()
        page = self.look("#/cell")
        label = ".label[data-connection='0'] .state"
        number = int(page.wait_for(label, r"^\d+ \+\d+ \u00b7 \S+ .?s$").split()[0])
        page.wait_for_attribute(".values", "aria-pressed", "true")
        wait_until(lambda: int(page.text(label).split()[0]) > number, "a newer value")
        # A plot begins with the values that the graph has shown.
        page.go("#/plots?port=robot.source.out")
        page.wait_for(VALUE, r"^\d+$")
        self.assertLessEqual(int(page.wait_for(".legend-table td[data-label=minimum]", r"^\d+$")), number)
        page.go("#/cell")
        page.wait_for(label, r"^\d+ ")
        page.click(".values")
        wait_until(lambda: page.text(label) == "", "no value")
        self.assertIn("values=off", page.script("return location.hash"))
        page.click(".values")
        page.wait_for(label, r"^\d+ ")
        # The value keeps, and turns red, when the connection becomes stale.
        self.done("stop robot.source")
        self.assertRegex(page.wait_for(label + ".bad-word", r"stale"), r"stale \u00b7 \d+ \+")
        self.done("start robot.source")
        page.wait_for(label + ".good-word", r"^\d+ \+")

        # A wire outside the visible part of the drawing has no value, nor has any in another view.
        chosen = """
            const fetched = window.fetch;
            window.asked = [];
            window.fetch = (address, options) => { if (options?.method === "PUT") window.asked.push(options.body); return fetched(address, options); };"""
        page.without_shared_workers()
        page.open("about:blank")
        page.open(self.address + "#/cell")
        page.script(chosen)
        page.wait_for(label, r"^\d+ ")
        page.size(390, 400)
        page.script("document.querySelector('.surface').focus()")
        page.press(*[Keys.ARROW_DOWN] * 10)
        wait_until(lambda: page.script("return window.asked.at(-1)") == '{"newest":[]}', "no value of an invisible wire")
        page.size(1440, 900)
        wait_until(lambda: page.script("return window.asked.at(-1)") == '{"newest":["robot.source.out"]}', "the value again")
        page.go("#/modules")
        wait_until(lambda: page.script("return window.asked.at(-1)") == '{"newest":[]}', "no value in another view")
        page.go("#/cell")
        page.script("document.querySelector(arguments[0]).dispatchEvent(new MouseEvent('click', {bubbles: true}))", label)
        wait_until(lambda: "select=connection%3A0" in page.script("return location.hash"), "the selected connection in the address")
        page.wait_for_attribute(".link[data-connection='0']", "class", "link touched")
        self.finish(web)

    def test_the_graph_shows_run_time_and_jitter_in_each_module_and_collapses_devices(self):
        web = self.serve()
        self.cell()
        page = self.look("#/cell")
        source = "[data-module='robot.source'] "
        page.wait_for(source + ".run", r"^run \S+ us of 5 ms$")
        page.wait_for(source + ".jitter", r"^jitter \S+ .?s$")
        wait_until(lambda: (page.attribute(source + "path.trend", "d") or "").count("L") >= 2, "the trend of the jitter")
        self.assertLess(0, float(page.attribute(source + ".used", "width")))
        for one in ("ok", "degraded", "stale", "not matched"):
            self.assertTrue([text for text in page.texts(".drawing text") if text.startswith(one)], "%r in the legend" % one)
        page.wait_for(".label[data-connection='0'] .state", r"^\d+ ")
        self.assertEqual([], page.script("""
            const all = [...document.querySelectorAll(".drawing text")].filter((one) => one.textContent)
              .map((one) => [one.textContent, one.getBBox()]);
            const crosses = (a, b) => a.x < b.x + b.width && b.x < a.x + a.width && a.y + 2 < b.y + b.height && b.y + 2 < a.y + a.height;
            return all.flatMap(([text, a], i) => all.slice(i + 1).filter(([, b]) => crosses(a, b)).map(([other]) => `${text} on ${other}`));"""))

        # The name that a screen reader says has the texts that a sighted person reads first, so that both speak of the same box.
        self.assertEqual([], page.script("""
            return [...document.querySelectorAll(".drawing [role=button]")].flatMap((box) => {
              const name = box.getAttribute("aria-label") ?? box.querySelector("title").textContent;
              return [...box.querySelectorAll("text.title, text.title + text, text.state-word")]
                .filter((text) => !name.includes(text.textContent)).map((text) => `${text.textContent} in ${name}`);
            });"""))
        wait_until(lambda: re.match(r"line\.fails: thread, periodic, every 10 ms, .*; RECOVER, alarm$", page.script(
            "return document.querySelector('[data-module=\"line.fails\"] title').textContent")), "the alarm in the name of the box")

        heights = page.script("return [...document.querySelectorAll('.drawing .box > .module')].map((one) => one.getAttribute('height'))")
        self.assertEqual(1, len(set(heights[1:3] + heights[4:])), "modules without connections have boxes of one size")
        page.click("[data-fold='robot']")
        wait_until(lambda: not page.texts("[data-module^='robot.']"), "the collapsed device")
        self.assertIn("collapsed=robot", page.script("return location.hash"))
        page.wait_for("[data-device='robot'] .state-word", "^running$")
        page.wait_for(".label[data-connection='0'] .state", r"^\d+ ")
        page.driver.refresh()
        page.wait_for("[data-module='line.fails'] .state-word", "RECOVER")
        self.assertEqual([], page.texts("[data-module^='robot.']"))
        page.script("document.querySelector('[data-device=line]').focus()")
        page.press(Keys.SPACE)
        page.wait_for("[data-device='line'] .state-word", "^fails: RECOVER$")
        self.assertEqual("bad", page.attribute("[data-device='line']", "data-look"))
        page.click("[data-fold='line']")
        page.wait_for("[data-module='line.fails'] .state-word", "RECOVER")
        page.click("[data-fold='robot']")
        page.wait_for("[data-module='robot.source'] .state-word", "EXECUTING")
        self.assertNotIn("collapsed", page.script("return location.hash"))
        self.finish(web)

    @takt_system.quiet("the browser competes with other tests for the CPUs")
    def test_the_wall_view_shows_in_large_letters_what_needs_attention(self):
        web = self.serve()
        self.cell()
        page = self.look("?wall", width=1920, height=1080)
        page.wait_for("[data-device=line] li", "^fails.*RECOVER, alarm$")
        self.assertEqual(["line", "robot"], page.texts(".tiles h2"), "the worst device is first")
        page.wait_for("#alarms .word", r"^\d+ unacknowledged alarms?$")
        self.assertEqual([], page.texts("#alarms .worst"), "the view describes the alarm")
        page.wait_for(".wall-view.alarmed > .mark", r"^line\.fails error: failure since \d\d:\d\d:\d\d(, returned to normal)?: .*run")
        self.assertLess(*page.script("""return [".wall-view > .mark", ".tiles"].map((one) => document.querySelector(one).getBoundingClientRect().top)"""),
                        "the alarm is above the tiles")
        small = page.script("""
            return [...document.querySelectorAll("body *")].filter((one) => one.checkVisibility() && [...one.childNodes]
                .some((node) => node.nodeType === Node.TEXT_NODE && node.data.trim()) && one.getBoundingClientRect().width > 1)
              .filter((one) => parseFloat(getComputedStyle(one).fontSize) < 0.023 * innerWidth).map((one) => one.textContent)""")
        self.assertEqual([], small, "texts that cannot be read from some metres away")
        page.size(390, 844)
        self.assertEqual([], page.script("return [...document.querySelectorAll('.wall-view *')].filter((one) => parseFloat(getComputedStyle(one).fontSize) < 14)"
                                         ".map((one) => one.textContent)"), "texts that cannot be read on a phone")
        page.size(1920, 1080)
        for theme in ("light", "dark"):
            page.prefer(theme)
            page.wait_for_attribute("html", "data-theme", theme)
            self.assertEqual([], page.script(CONTRAST))
        self.running["robot"].signal(signal.SIGKILL)
        self.running["robot"].wait()
        page.wait_for("[data-device=robot] .mark .word", "^lost$")
        page.wait_for("#summary", "robot lost")
        self.running["robot"] = self.node("robot", "--resume")
        page.wait_for("[data-device=robot] .mark .word", "^running$")
        # Without an unacknowledged alarm, the view shows the last fault. The devices may raise further alarms in between.
        def acknowledged():
            for device in ("robot", "line"):
                self.post("api/acknowledge", {"device": device, "alarm": "0"})
            return page.texts(".wall-view:not(.alarmed) > .mark")
        last, = wait_until(acknowledged, "the last fault")
        self.assertRegex(last, r"^\d\d:\d\d:\d\d (robot|line)[.a-z]*: [a-z-]+")
        self.assertGreater(*page.script("""return [".wall-view > .mark", ".tiles"].map((one) => document.querySelector(one).getBoundingClientRect().top)"""))
        self.finish(web, apart=("504",))  # the page may still have waited for a reply of the killed node

    def test_the_web_page_removes_scripts_and_links_from_svg_drawings(self):
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
        self.assertEqual(0, web.wait().status, web.err)

    def test_a_plot_shows_several_ports_and_its_address_restores_it(self):
        module = ("<module><name>source</name><filename>port_source.so</filename><moduletype>thread</moduletype>"
                  "<operationtype>periodic</operationtype><period>10ms</period><priority>1</priority></module>")
        file = self.write("cell.xml", '<cell name="cell"><device name="robot">%s</device><device name="line">%s</device></cell>' % (module, module))
        web = self.serve()
        self.cell(file)
        page = self.look("#/plots")
        for port in ("robot.source.out", "line.source.out"):
            wait_until(lambda: page.script("return [...document.querySelectorAll('.tools option')].some((one) => one.value === arguments[0])", port), port)
            page.script("const add = document.querySelector('.tools select'); add.value = arguments[0];"
                        "add.dispatchEvent(new Event('change'))", port)
            page.wait_for(".legend-table th", "^%s.number$" % re.escape(port))
        series = ["%s.%s" % (port, field) for port in ("robot.source.out", "line.source.out") for field in ("number", "same[0]", "same[1]", "same[2]")]

        def legend():
            return page.texts(".legend-table tbody th")

        def with_units(names):
            return [name + " (mm)" if ".same[" in name else name for name in names]
        self.assertEqual(with_units(series), legend())
        self.assertEqual(1, len(page.texts(".plot")))
        for one in series[1:4] + series[5:7]:
            page.click("label[data-name='%s'] input" % one)
        shown = ["robot.source.out.number", "line.source.out.number", "line.source.out.same[2]"]
        self.assertEqual(with_units(shown), legend())
        wait_until(lambda: len([text for text in page.texts(VALUE) if text.isdigit()]) == 3, "values of both ports")
        wait_until(lambda: any(re.match(r"^\d+ mm$", text) for text in page.texts(".dygraph-axis-label-y2")), "a right axis in mm")
        for colour in ("series-1", "series-2"):
            wait_until(lambda: page.script(PIXELS, colour) > 5, "a curve in the colour " + colour)
        page.script("const range = document.querySelector('select[aria-label=range]'); range.value = 60; range.dispatchEvent(new Event('change'))")
        page.click(".tools button[aria-pressed=false] + button")
        wait_until(lambda: len(page.texts(".plot")) == 3, "one plot for each series")

        address = page.script("return location.href")
        page.open("about:blank")
        page.open(address)
        page.wait_for(VALUE, r"^\d+$")
        wait_until(lambda: legend() == with_units(shown), "the same series")
        self.assertEqual(3, len(page.texts(".plot")))
        self.assertEqual("60", page.script("return document.querySelector('select[aria-label=range]').value"))
        page.click("button[aria-label='remove line.source.out']")
        wait_until(lambda: legend() == shown[:1], "the remaining series")
        page.go("#/plots?series=robot.source.out.nothing")
        page.wait_for(".tools [role=status]", "^robot.source.out.nothing: the port has no such field$")
        self.finish(web, apart=("willReadFrequently",))

    def test_a_plot_can_be_zoomed_paused_measured_and_exported(self):
        web = self.serve()
        self.cell()
        page = self.look("#/plots?series=robot.source.out.number")
        page.driver.execute_cdp_cmd("Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": self.folder})
        page.wait_for(VALUE, r"^[1-9]\d{2,}$")

        def range_s():
            return page.script("return Number(new URLSearchParams(location.hash.split('?')[1]).get('range') ?? 300)")

        def paused():
            return page.attribute(".tools button", "aria-pressed") == "true"
        plot = page.driver.find_element("css selector", ".plot")
        width = plot.size["width"]
        mouse = ActionChains(page.driver)
        mouse.move_to_element(plot).move_by_offset(width // 4, 0).click_and_hold().move_by_offset(width // 8, 3).release().perform()
        wait_until(lambda: 300 / 10 < range_s() < 300 / 6, "the range to be an eighth of 5 min, and not %s s" % range_s())
        self.assertTrue(paused(), "the newest values are outside of the range")
        ActionChains(page.driver).move_to_element(plot).double_click().perform()
        wait_until(lambda: range_s() == 300 and not paused(), "the whole range")

        # The keys do all of it, too.
        ActionChains(page.driver).move_to_element(page.driver.find_element("css selector", "#summary")).perform()
        page.script("document.querySelector('.plot').focus()")
        page.press("+", "+")
        wait_until(lambda: range_s() == 75, "a quarter of the range")
        page.press("-")
        wait_until(lambda: range_s() == 150, "half of the range")
        page.press(Keys.HOME)
        wait_until(lambda: range_s() == 300, "the whole range")
        page.press(Keys.SPACE)
        wait_until(paused, "the plot to stand still")
        newest = page.text(".at")
        wait_until(lambda: page.wait_script("import('/words.js').then(({clock}) => done(clock(Date.now())))") > newest[-8:], "the next second")
        self.assertEqual(newest, page.text(".at"), "a paused plot does not move")

        def measured():
            """Returns the value, the value at the mark, and their difference."""
            cells = page.texts(".legend-table tbody td")
            return [None if cell == "-" else int(cell.replace("\u2212", "-")) for cell in (cells[0], *cells[3:])]
        def saved(kind):
            # Chromium first makes an empty file of this name.
            names = [name for name in os.listdir(self.folder) if re.fullmatch(r"takt-\d{6}\." + kind, name)]
            return next((name for name in names if os.path.getsize(os.path.join(self.folder, name)) > 0), None)
        page.press(Keys.ENTER)
        page.wait_for("td[data-label='at mark']", r"^\d+$")
        page.wait_for("td[data-label=difference]", "^0$")
        page.press(Keys.ARROW_LEFT)
        page.wait_for(".at", r"^at [\d:.]+; mark at [\d:.]+; .3(\.00)? s between them$")
        value, mark, difference = measured()
        self.assertEqual(difference, None if value is None else value - mark)  # a slow machine may have no values of 3 s yet

        page.click(".tools button[title*=table]")
        file = wait_until(lambda: saved("csv"), "the table")
        lines = self.read(file).splitlines()
        self.assertEqual("time_ns,seconds,robot.source.out.number", lines[0])
        cells = [line.split(",") for line in lines[1:]]
        self.assertGreaterEqual(len(cells), 100)
        times, numbers = [int(line[0]) for line in cells], [int(line[2]) for line in cells]
        self.assertEqual((sorted(times), sorted(numbers)), (times, numbers))
        wait_until(lambda: numbers[-1] <= measured()[1] <= numbers[-1] + 20, "the mark to be at the newest value")
        self.assertAlmostEqual((times[-1] - times[0]) / 1e9, float(cells[-1][1]), places=4)
        page.click(".tools button[title*=picture]")
        file = wait_until(lambda: saved("png"), "the picture")
        with open(os.path.join(self.folder, file), "rb") as picture:
            head = picture.read(24)
        self.assertEqual((b"\x89PNG", width), (head[:4], int.from_bytes(head[16:20], "big")))
        page.press_until(Keys.TAB, lambda name: name == "CSV")
        self.finish(web)

    def test_a_plot_shows_a_peak_of_one_sample_in_its_longest_range(self):
        web = self.serve()
        page = self.look()
        found = page.wait_script("""
            Promise.all([import("/plots.js"), import("/ports.js"), import("/value_rows.js")]).then(async ([{Plots}, {Ports}, {ValueRows}]) => {
              const hour = 3600000, begin = Date.UTC(2024, 0, 1);
              const store = {deviceNames: [], now: begin + 6 * hour, ports: new Ports()};
              history.replaceState(null, "", "#/plots?series=a.b.c.x,a.b.c.y&range=14400");
              const view = new Plots(store);
              document.querySelector("#view").replaceChildren(view.element);
              view.show(new URLSearchParams(location.hash.split("?")[1]));
              store.ports.take("port", {port: "a.b.c", type: "T", fields: [{name: "x"}, {name: "y"}]});
              // 6 h at 20 Hz. x has a peak of one sample each minute; y has one in all, 3 h ago.
              for (let from = 0; from < 6 * hour; from += 10000) {
                const times_ms = Array.from({length: 200}, (_, i) => begin + from + i * 50);
                const at = (time, i) => (time - begin) % 60000 === 30050 ? 5 + (time - begin - 30050) / 60000 : Math.sin(i);
                const once = (time) => time === begin + 3 * hour + 50 ? -7 : 1;
                store.ports.take("points", {port: "a.b.c", whole: from === 0, times_ms, values: [times_ms.map(at), times_ms.map(once)]});
              }
              view.redraw();
              const cells = () => [...document.querySelectorAll(".legend-table td")].map((cell) => cell.textContent);
              while (!cells()[6]?.endsWith("7")) await new Promise(requestAnimationFrame);
              // Find the peak in the drawing: a pixel in the colour of y in the lower half of the plot.
              const canvas = document.querySelector(".plot canvas");
              const wanted = getComputedStyle(document.documentElement).getPropertyValue("--series-2").match(/[0-9a-f]{2}/g);
              const {data} = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
              const places = [];
              for (let i = 0; i < data.length; i += 4) {
                if (data[i + 3] > 60 && wanted.every((of, j) => Math.abs(data[i + j] - parseInt(of, 16)) < 60)) places.push([i / 4 % canvas.width, Math.floor(i / 4 / canvas.width)]);
              }
              const lowest = Math.max(...places.map(([, down]) => down));
              const rows = new ValueRows();
              for (let i = 0; i < 500000; ++i) rows.add([begin + i * 100], [[i % 6000 === 17 ? 100 + i / 6000 : Math.sin(i)]]);
              const kept = rows.between(0, Infinity);
              const peaks = kept.filter(([, value]) => value > 50).length;
              const shown = [cells()[2], cells()[6]];
              view.hide();
              done([...shown, peaks, (places.find(([, down]) => down === lowest)[0] - 75) / (canvas.width - 83), kept.length]);
            }).catch((error) => done(String(error)));""")
        self.assertEqual(["364", "\u22127", 24], found[:3])
        self.assertAlmostEqual(0.25, found[3], delta=0.02, msg="the place of the peak in the drawing")
        self.assertLess(found[4], 60000, "memory must be bounded")
        web.signal(signal.SIGTERM)
        self.assertEqual(0, web.wait().status, web.err)

    def test_the_web_page_can_plot_any_values_at_any_width(self):
        web = self.serve()
        page = self.look()
        found = page.wait_script("""
            Promise.all([import("/plot.js"), import("/value_rows.js"), import("/gantt.js")]).then(async ([{Plot}, {ValueRows}, {Gantt}]) => {
              const frame = () => new Promise(requestAnimationFrame);
              const values = [[0.3, 0.30000000000000004], [-1e300, 1e300], [0, 5e-324], [7, 7], [0, null], [null, null], [-1e9, -1e9 - 1e-7], []];
              for (const of of values) {
                const rows = new ValueRows();
                rows.add(of.map((_, i) => 1000 + 1000 * i), [of]);
                const plot = new Plot({title: "plot", pointed: () => {}, series: [{name: "value", index: 0, rows, column: 1}]});
                document.body.append(plot.element);
                plot.show(0, 2000);
                await frame();
                await frame();
              }
              const labels = [...document.querySelectorAll(".dygraph-axis-label")].map((label) => label.textContent);
              const gantt = new Gantt({name: "main", macro_period_ns: 1e7, basic_period_ns: 1e6, rows: []}, [], ["module"]);
              gantt.canvas.element.style.width = "40px";
              document.body.append(gantt.element);
              await frame();
              await frame();
              done([document.querySelectorAll(".plot canvas").length, gantt.canvas.element.clientWidth < gantt.left,
                    labels.filter((label) => /NaN|Infinity|undefined/.test(label))]);
            }).catch((error) => done(String(error)));""")
        self.assertEqual([16, True, []], found)
        self.assertEqual([], page.errors())
        web.signal(signal.SIGTERM)
        self.assertEqual(0, web.wait().status, web.err)

    def test_the_web_page_does_not_send_a_pending_command_twice(self):
        web = self.serve()
        page = self.look()
        page.wait_for("#link", "^live$")
        web.signal(signal.SIGSTOP)  # a gateway that is stopped accepts connections but does not reply
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
        self.assertGreater(limits[1], 30, "the page must wait longer than the gateway waits for a device")
        self.assertEqual(["no answer within %d s" % limits[0],
                          "no answer within %d s; the device may still have carried out the request" % limits[1]], said)
        self.assertEqual([1, 1, 0, 1], page.wait_script("""
            import("/commands.js").then(async ({Commands}) => {
              const [given, fetched] = [[], window.fetch];
              window.fetch = (address) => new Promise((answer) => given.push([address, answer]));
              const modules = new Map(["robot.one", "robot.two"].map((name) => [name, {state: {state: "RECOVER"}}]));
              const commands = new Commands({modules, link: "live", rights: {command: true}, devices: new Map([["robot", {alive: true}]])});
              commands.hold("robot", "robot.one");
              const recover = commands.buttons.find((button) => button.dataset.verb === "recover");
              recover.click();
              commands.update();  // a state arrives while the command is pending
              recover.click();
              const seen = [given.length, Number(recover.disabled)];
              commands.hold("robot", "robot.two");
              seen.push(Number(recover.disabled));
              commands.hold("robot", "robot.one");
              given[0][1](new Response("{}"));
              while (recover.disabled) await new Promise(requestAnimationFrame);
              window.fetch = fetched;
              done([...seen, given.length]);
            }).catch((error) => done(String(error)));"""))
        web.signal(signal.SIGTERM)
        self.assertEqual(0, web.wait().status, web.err)

    def test_the_web_page_writes_dates_and_durations_for_people(self):
        web = self.serve()
        page = self.look()
        page.driver.execute_cdp_cmd("Emulation.setTimezoneOverride", {"timezoneId": "Asia/Tokyo"})
        self.assertEqual("2020-03-02 00:30:00.000", page.wait_script(
            "import('/words.js').then(({instant}) => done(instant(Date.UTC(2020, 2, 1, 15, 30)))).catch((error) => done(String(error)));"))
        self.assertEqual(["999 us", "119 s", "2 min 0 s", "61 min 1 s", "2 h 0 min", "26 h 40 min"], page.wait_script(
            "import('/words.js').then(({duration}) => done([999, 119e6, 119.6e6, 3661e6, 7199.7e6, 96000e6].map(duration)))"
            ".catch((error) => done(String(error)));"))
        web.signal(signal.SIGTERM)
        self.assertEqual(0, web.wait().status, web.err)


# This script clicks the button of a command, and confirms it if the page asks. It calls done() with the answer that the page shows, and with
# the time until then, in ms.
ORDER = """
const answer = document.querySelector("#details .commands .answer");
const button = document.querySelector(`#details [data-verb=${arguments[0]}]`);
const press = () => {
  if (button.disabled) return void requestAnimationFrame(press);
  const began = performance.now();
  button.click();
  document.querySelector("dialog button.danger")?.click();
  new MutationObserver(() => { if (!answer.textContent.endsWith("...")) done([answer.textContent, performance.now() - began]); })
    .observe(answer, {childList: true, characterData: true, subtree: true});
};
press();
"""

# This script finds tabs that are in a second line or, on a phone, too small for a finger, and a selected tab that is not completely visible.
TABS = """
const tabs = [...document.querySelectorAll("[role=tab]")];
const bar = document.querySelector("#tabs").getBoundingClientRect();
return tabs.filter((tab) => {
  const {top, left, right, height, width} = tab.getBoundingClientRect();
  const least = innerWidth <= 600 ? 44 : 0;
  return top !== tabs[0].getBoundingClientRect().top || height < least || width < least
    || (tab.getAttribute("aria-selected") === "true" && (left < bar.left - 0.5 || right > bar.right + 0.5));
}).map((tab) => `${tab.textContent}: ${JSON.stringify(tab.getBoundingClientRect())}`);
"""

# This script finds selects that are too narrow for the text of their option.
CUT = """
return [...document.querySelectorAll("select")].filter((one) => one.checkVisibility()).filter((one) => {
  const copy = document.createElement("select");
  Object.assign(copy.style, {position: "absolute", width: "auto"});
  copy.append(one.selectedOptions[0]?.cloneNode(true) ?? "");
  one.after(copy);
  const cut = copy.offsetWidth > one.offsetWidth + 1;
  copy.remove();
  return cut;
}).map((one) => one.selectedOptions[0].textContent);
"""

# This script finds texts whose contrast to their background is lower than WCAG level AA requires. As in WCAG, disabled elements do not
# count.
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
