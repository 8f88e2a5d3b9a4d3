"""Makes the screenshots and drawings of docs/pictures. tools/pictures builds all programs and then runs this script."""
import os
import re
import subprocess
import sys
import tempfile
import time

here = os.path.dirname(os.path.abspath(__file__))
root = os.path.dirname(here)
sys.path += [os.path.join(root, "tests", "system"), os.path.join(root, "tests", "system", "web")]
from browser import Browser  # noqa: E402
import takt_system  # noqa: E402

BIN = os.path.join(root, "build", "release", "bin")
OUT = os.path.join(root, "docs", "pictures")
TERMINAL = (100, 34)  # columns, rows
domain = takt_system.free_domain()
environment = dict(os.environ, TAKT_DOMAIN=str(domain), TAKT_INTERFACE="127.0.0.1", PATH=BIN + ":" + os.environ["PATH"],
                   TAKT_COMPONENT_PATH=os.path.join(root, "build", "release", "components"), LC_ALL="C.UTF-8")


def out(name):
    return os.path.join(OUT, name)


def takt(*arguments):
    done = subprocess.run(["takt", *arguments], env=environment, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit("takt %s: %s" % (" ".join(arguments), done.stderr))
    return done.stdout


def page(folder, address):
    """Takes screenshots of the web page, in both themes."""
    browser = Browser(folder, 1440, 900)
    try:
        browser.open(address)
        for name, route, theme, width, height in (
                ("page.png", "#/cell", "light", 1440, 900), ("page-modules.png", "#/modules", "dark", 1440, 900),
                ("page-table.png", "#/table?device=line", "light", 1440, 900)):
            browser.size(width, height)
            browser.prefer(theme)
            browser.go(route)
            time.sleep(4)  # wait until the page has drawn its first values
            browser.driver.save_screenshot(out(name))
    finally:
        browser.close()


class Terminal:
    """A tmux terminal that runs takt watch."""

    def __init__(self, folder):
        self.folder = folder
        self.tmux = ["tmux", "-S", os.path.join(folder, "tmux"), "-f", "/dev/null"]
        subprocess.run(self.tmux + ["new-session", "-d", "-x", str(TERMINAL[0]), "-y", str(TERMINAL[1]), "takt watch"],
                       env=environment, check=True)

    def screenshot(self):
        shown = subprocess.run(self.tmux + ["capture-pane", "-e", "-p"], env=environment, check=True, capture_output=True).stdout
        html = subprocess.run(["aha", "--black", "--title", "takt watch"], input=shown, check=True, capture_output=True).stdout.decode()
        html = html.replace("<body style=\"", "<body style=\"overflow: hidden; margin: 0; ")
        html = html.replace("<pre>", "<pre style=\"font: 14px/1.2 'DejaVu Sans Mono', monospace; margin: 12px; display: inline-block\">")
        path = os.path.join(self.folder, "watch.html")
        with open(path, "w") as file:
            file.write(html)
        browser = Browser(self.folder, 1200, 900)
        try:
            browser.open("file://" + path)
            right, bottom = browser.script("const r = document.querySelector('pre').getBoundingClientRect(); return [r.right, r.bottom];")
            browser.size(round(right) + 12, round(bottom) + 12)
            browser.driver.save_screenshot(out("watch.png"))
        finally:
            browser.close()

    def close(self):
        subprocess.run(self.tmux + ["kill-server"], env=environment, check=False)


def bench(folder):
    """Measures the paper's Table 1 on this machine and takes a screenshot of the report. Call this before starting the cell."""
    measured = os.path.join(folder, "table1.html")
    takt("bench", "table1", "--for", "3", "--html", measured)
    browser = Browser(folder, 1200, 900)
    try:
        browser.open("file://" + measured)
        browser.prefer("light")
        time.sleep(1)
        browser.driver.save_screenshot(out("bench.png"))
    finally:
        browser.close()


def reports(folder):
    takt("graph", os.path.join(root, "deploy", "palletizing.xml"), "--svg", out("graph.svg"))
    takt("check", os.path.join(root, "deploy", "module.xml"), "--svg", out("tables.svg"))
    takt("trace", "line", "--last", "0.05", "--svg", out("trace.svg"))
    recording = os.path.join(folder, "belt.db")
    takt("record", "line.conveyor.state", "robot.arm.measured", "--out", recording, "--for", "12")
    takt("plot", recording, "line.conveyor.state", "--svg", out("plot.svg"))


def main():
    os.makedirs(OUT, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        os.mkdir(os.path.join(folder, "terminal"))
        bench(folder)
        processes = [subprocess.Popen(["takt", "run", os.path.join(root, "deploy", "palletizing.xml")], env=environment,
                                      stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd=folder)]
        try:
            time.sleep(5)
            web = subprocess.Popen(["takt", "web", "--port", "0", "--commands"], env=environment, stdout=subprocess.PIPE, text=True)
            processes.insert(0, web)
            address = re.search(r"http://\S+/", web.stdout.readline()).group()
            token = re.search(r"#token=\S+", web.stdout.readline()).group()
            terminal = Terminal(os.path.join(folder, "terminal"))
            try:
                reports(folder)
                time.sleep(40)
                page(folder, address + token)
                terminal.screenshot()
            finally:
                terminal.close()
        finally:
            for process in processes:
                process.terminate()
                process.wait()
    for name in sorted(os.listdir(OUT)):
        print(os.path.relpath(out(name), root), os.path.getsize(out(name)), "bytes")


main()
