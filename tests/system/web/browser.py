"""Uses a web page as a person does: opens the page, reads it, clicks and presses keys. The browser is headless Chromium, which stores all
its files in a folder of the test."""

import os

from selenium import webdriver
from selenium.common.exceptions import StaleElementReferenceException, WebDriverException
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.action_chains import ActionChains

from takt_system import wait_until

OPTIONS = ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
           "--disable-component-update", "--disable-sync", "--disable-dev-shm-usage", "--disable-breakpad",
           "--force-device-scale-factor=1", "--ignore-certificate-errors")

# This script records every state change of a row with its time, because the page shows only the current state.
WATCH_STATES = """
window.seen = {};
const note = (row) => (window.seen[row.dataset.module] ??= []).push([row.dataset.state, Date.now()]);
document.querySelectorAll("tr[data-module]").forEach(note);
new MutationObserver((changes) => changes.forEach(({target}) => { if (target.dataset.module) note(target); }))
  .observe(document.querySelector("#view"), {subtree: true, attributes: true, attributeFilter: ["data-state"]});
"""


class Browser:
    def __init__(self, folder, width=1440, height=900, local_names=()):
        """`local_names` are host names that mean this machine to the browser."""
        options = Options()
        options.binary_location = "/usr/bin/chromium"
        for option in OPTIONS + ("--user-data-dir=" + os.path.join(folder, "browser"), "--window-size=%d,%d" % (width, height),
                                 "--host-resolver-rules=" + ",".join("MAP %s 127.0.0.1" % name for name in local_names)):
            options.add_argument(option)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        environment = dict(os.environ, TMPDIR=folder, HOME=folder)
        self.driver = webdriver.Chrome(options=options, service=Service("/usr/bin/chromedriver", env=environment))
        self.size(width, height)
        self.complaints = []

    def close(self):
        self.driver.quit()

    def size(self, width, height):
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                                    {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False})

    def prefer(self, theme):
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": theme}]})

    def open(self, address):
        self.driver.get(address)

    def open_tab(self, address, window="tab"):
        """Opens an address in a new tab, or, with `window`="window", in a new window. The test continues there. Returns the tab for
        select_tab()."""
        self.driver.switch_to.new_window(window)
        self.open(address)
        return self.driver.current_window_handle

    def select_tab(self, tab):
        self.driver.switch_to.window(tab)

    def hide(self):
        """Minimises the window of the tab, so that the browser tells the page that it is hidden."""
        self.driver.minimize_window()
        wait_until(lambda: self.script("return document.hidden"), "the tab to be hidden")

    def show(self):
        self.driver.set_window_rect(0, 0, 1440, 900)
        wait_until(lambda: not self.script("return document.hidden"), "the tab to be visible")

    def without_shared_workers(self):
        """Makes each address that is opened later in this tab believe that the browser has no shared workers, as Chrome on Android."""
        self.driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": "delete window.SharedWorker"})

    def go(self, route):
        """Opens another view of the page, as a link on the page does."""
        self.script("location.hash = arguments[0]", route)

    def script(self, text, *arguments):
        return self.driver.execute_script(text, *arguments)

    def wait_script(self, text, *arguments):
        """Runs a script and waits until it calls done(VALUE). Returns this value."""
        self.driver.set_script_timeout(120)
        return self.driver.execute_async_script("const done = arguments[arguments.length - 1];\n" + text, *arguments)

    def texts(self, selector):
        """Returns the texts of all visible elements that match `selector`."""
        return self.script("return [...document.querySelectorAll(arguments[0])].filter((one) => one.checkVisibility())"
                           ".map((one) => one.textContent)", selector)

    def text(self, selector):
        found = self.texts(selector)
        return found[0] if found else None

    def wait_for(self, selector, pattern):
        """Waits until the text of a visible element that matches `selector` also matches the pattern, and returns this text."""
        import re
        expression = re.compile(pattern)
        try:
            return wait_until(lambda: next((text for text in self.texts(selector) if expression.search(text)), None),
                              "%r in %s" % (pattern, selector))
        except AssertionError as error:
            raise AssertionError("%s; there is %r" % (error, self.texts(selector))) from None

    def attribute(self, selector, name):
        return self.script("return document.querySelector(arguments[0])?.getAttribute(arguments[1]) ?? null", selector, name)

    def wait_for_attribute(self, selector, name, value):
        try:
            wait_until(lambda: self.attribute(selector, name) == value, "%s=%r of %s" % (name, value, selector))
        except AssertionError as error:
            raise AssertionError("%s; it is %r" % (error, self.attribute(selector, name))) from None

    def click(self, selector):
        """Clicks at the position of the element. If another element covers it, that other element gets the click."""
        def clicked():
            try:
                self.driver.find_element("css selector", selector).click()
                return True
            except StaleElementReferenceException:  # the page has just replaced the element
                return False
        wait_until(clicked, "a click on %s" % selector)

    def write(self, selector, text):
        field = self.driver.find_element("css selector", selector)
        field.clear()
        field.send_keys(text)

    def press(self, *keys):
        ActionChains(self.driver).send_keys(*keys).perform()

    def focused(self):
        """Returns the label of the element that has the focus, or its text if it has no label."""
        return self.script("const one = document.activeElement;"
                           "return one.getAttribute('aria-label') || one.labels?.[0]?.textContent || one.textContent.slice(0, 80)")

    def press_until(self, key, holds, most=60):
        """Presses the key until `holds` is true for the focused element. Fails if an element on the way shows no visible focus."""
        for _ in range(most):
            self.press(key)
            if self.script("const one = getComputedStyle(document.activeElement);"
                           "return document.activeElement !== document.body && !document.activeElement.closest('.drawing')"
                           " && (one.outlineStyle === 'none' || parseFloat(one.outlineWidth) < 2)"):
                raise AssertionError("the focus on %r is not visible" % self.focused())
            if holds(self.focused()):
                return
        raise AssertionError("pressing %d times %r did not move the focus to the wanted element; the focus is on %r" % (most, key, self.focused()))

    def hover(self, selector):
        ActionChains(self.driver).move_to_element(self.driver.find_element("css selector", selector)).perform()

    def states(self):
        """Returns the states in the list of modules: {"device.module": "EXECUTING"}."""
        return self.script("return Object.fromEntries([...document.querySelectorAll('tr[data-module]')].map((row) =>"
                           "[row.dataset.module, row.querySelector('.mark .word').textContent]))")

    def watch_states(self):
        self.script(WATCH_STATES)

    def seen(self, module=None):
        """Returns the states since watch_states(): those of one module, or those of all modules with their times, in ms of the browser's
        clock."""
        seen = self.script("return window.seen")
        return seen if module is None else [state for state, _ in seen[module]]

    def errors(self, apart=()):
        """Returns the errors and warnings on the browser's console since the last call. Leaves out lines that contain one of the texts in
        `apart`, and lines about values outside a fixed axis, which Debian 13's Dygraphs writes."""
        try:
            lines = [entry["message"] for entry in self.driver.get_log("browser") if entry["level"] in ("SEVERE", "WARNING")]
        except WebDriverException as error:
            return [str(error)]
        return [line for line in lines if not any(one in line for one in (*apart, "points out of "))]
