import glob
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system

HERE = os.path.dirname(os.path.abspath(__file__))
SOURCE = takt_system.SOURCE
BUILD = os.path.dirname(takt_system.BIN)
PAGE = open(os.path.join(SOURCE, "docs", "install.md"), encoding="utf-8").read()
PREFIX = "/opt/takt"  # the installation folder that the page docs/install.md uses
CELL = os.path.join("share", "takt", "deploy", "palletizing.xml")


def hidden(empty):
    """Returns a command prefix that hides the source tree and the build tree from the command after it. Returns None if the system does not
    permit this."""
    alone = ["unshare", "--mount"] if os.getuid() == 0 else ["unshare", "--map-root-user", "--mount"]
    before = alone + ["sh", "-c", 'for tree in "$1" "$2"; do mount --bind "$0" "$tree" || exit 9; done; shift 2; exec "$@"',
                      empty, BUILD, SOURCE]
    return before if subprocess.run(before + ["true"], capture_output=True).returncode == 0 else None


def block(language, containing=""):
    """Returns the code block of docs/install.md in this language that contains this text. The page must have exactly one such block."""
    found = [text for text in re.findall(r"```%s\n(.*?)```" % language, PAGE, re.S) if containing in text]
    assert len(found) == 1, (language, containing, len(found))
    return found[0]


def setUpModule():
    global WORK, INSTALLED, HIDDEN
    WORK = tempfile.mkdtemp(prefix="takt-install-")
    staged = os.path.join(WORK, "staged")
    command = "cmake --install build/release --prefix /opt/takt"
    assert command in PAGE
    arguments = command.replace("build/release", BUILD).split()
    subprocess.run(arguments, check=True, env=dict(os.environ, DESTDIR=staged), stdout=subprocess.DEVNULL)
    INSTALLED = os.path.join(WORK, "moved", "takt")
    shutil.move(staged + PREFIX, INSTALLED)
    empty = os.path.join(WORK, "empty")
    os.mkdir(empty)
    HIDDEN = hidden(empty)


def tearDownModule():
    shutil.rmtree(WORK)


class Installed(takt_system.Case):
    def installed(self, *arguments, program="takt", folder="bin", root=None, hide=True, components="", **options):
        """Runs an installed program. The program cannot see the source tree and the build tree."""
        if hide and HIDDEN is None:
            self.skipTest("no mount namespace is granted here")
        environment = {"TAKT_COMPONENT_PATH": components, "PATH": "/usr/bin:/bin", "LD_LIBRARY_PATH": ""}
        return self.program(program, *arguments, programs=os.path.join(root or INSTALLED, folder), environment=environment,
                            before=HIDDEN if hide else (), **options).wait()

    def assert_ran(self, run, modules):
        self.assertEqual(0, run.status, run.err)
        found = {m["name"]: m for d in run.report["devices"] for m in d["modules"]}
        self.assertLessEqual(set(modules), set(found))
        for name in modules:
            self.assertEqual("DESTRUCT", found[name]["state"], name)
            self.assertGreater(found[name]["cycles"], 0, name)
        return found

    def command(self, line, folder):
        """Runs a command from the page, with the installation folder of this test instead of the folder on the page."""
        self.assertIn(line, PAGE)
        run = subprocess.run(line.replace(PREFIX, INSTALLED), shell=True, cwd=folder, capture_output=True, text=True, timeout=5 * takt_system.LONG,
                             env=dict(os.environ, TAKT_DOMAIN=str(self.domain)))
        self.assertEqual(0, run.returncode, run.stdout + run.stderr)
        return run

    def test_cmake_find_package_rejects_a_build_tree(self):
        """Because the programs of the build tree are in PATH, find_package() also searches the build tree."""
        project = os.path.join(self.folder, "project")
        os.mkdir(project)
        with open(os.path.join(project, "CMakeLists.txt"), "w") as file:
            file.write("cmake_minimum_required(VERSION 3.25)\nproject(x LANGUAGES NONE)\nfind_package(takt REQUIRED)\n")
        # This option excludes the system's folders, so that find_package() does not find a takt that is installed on this machine.
        configured = subprocess.run(["cmake", "-S", project, "-B", os.path.join(self.folder, "out"),
                                     "-DCMAKE_FIND_USE_CMAKE_SYSTEM_PATH=OFF"], capture_output=True, text=True,
                                    env=dict(os.environ, PATH=takt_system.BIN + ":" + os.environ["PATH"]))
        self.assertNotEqual(0, configured.returncode)
        self.assertIn("this is a build tree; install it, as docs/install.md says: cmake --install " + BUILD, configured.stderr)

    def test_an_installed_takt_runs_without_the_source_and_build_trees(self):
        run = self.installed("run", os.path.join(INSTALLED, CELL), "--for", "2", "--json", "--quiet")
        self.assert_ran(run, ["trajectory", "servo", "arm", "conveyor", "counter", "panel"])

    def test_an_installed_takt_finds_its_installed_components_and_libraries(self):
        for component in ("servo.so", "panel.exe"):
            self.assertEqual(0, self.installed("describe", component).status)
        run = self.installed("describe", "nowhere.so")
        self.assertIn(os.path.join(INSTALLED, "lib", "takt", "components"), run.err)
        run = self.installed("run", os.path.join(INSTALLED, "share/takt/deploy/module.xml"), "--for", "0.5", "--check-realtime")
        self.assertNotIn("libtakt_check", run.err)
        self.assertRegex(run.err, "EXECUTING")

    def test_an_installed_node_starts_without_the_source_and_build_trees(self):
        if HIDDEN is None:
            self.skipTest("no mount namespace is granted here")
        node = self.program("takt-node", "--device", "robot", programs=os.path.join(INSTALLED, "bin"), before=HIDDEN)
        node.wait_for_line("waits for a deployment")
        node.signal(signal.SIGTERM)
        self.assertEqual(0, node.wait().status, node.err)

    def test_no_installed_file_refers_to_the_source_and_build_trees(self):
        for folder, _, names in os.walk(INSTALLED):
            for name in names:
                path = os.path.join(folder, name)
                if os.path.islink(path):
                    self.assertFalse(os.path.isabs(os.readlink(path)), path)
                    self.assertTrue(os.path.exists(path), path)
                    continue
                with open(path, "rb") as file:
                    content = file.read()
                if content[:4] == b"\x7fELF":
                    dynamic = subprocess.run(["objdump", "-p", path], capture_output=True, text=True).stdout
                    for paths in re.findall(r"R(?:UN)?PATH +(\S+)", dynamic):
                        self.assertRegex(paths, r"^\$ORIGIN[/.a-z]*$", path)
                elif not path.endswith(".a"):
                    self.assertNotIn(BUILD.encode(), content, path)
                    # If this is /takt, neither /opt/takt/cell.xml nor the address /takt/ of a web page is meant.
                    self.assertNotRegex(content, rb"(?<![\w.-])" + re.escape(SOURCE.encode()) + rb"/[\w.-]", path)

    def test_the_installed_c_and_cpp_headers_compile_without_errors(self):
        include = os.path.join(INSTALLED, "include")
        headers = sorted(os.path.relpath(path, include) for path in glob.glob(include + "/takt/**/*.h*", recursive=True))
        self.assertLess(20, len(headers))
        in_c = [header for header in headers if header.endswith(".h")]
        in_cpp = [header for header in headers if header not in in_c]
        for compiler, standard, of_it in (("gcc", "c11", in_c), ("g++", "c++20", in_cpp)):
            # The preset `debug` already compiles each header alone. So the short form only checks that all included headers are installed.
            for together in [[header] for header in of_it] if takt_system.FULL else [of_it]:
                run = subprocess.run([compiler, "-x", "c" if of_it is in_c else "c++", "-std=" + standard, "-Wall", "-Wextra",
                                      "-fsyntax-only", "-I", include, "-"],
                                     input="".join("#include <%s>\n" % header for header in together), capture_output=True, text=True)
                self.assertEqual((0, ""), (run.returncode, run.stderr), together)

    def test_the_example_project_of_the_installation_page_builds_and_runs(self):
        folder = os.path.join(self.folder, "project")
        os.mkdir(folder)
        for name, text in {"CMakeLists.txt": block("cmake"), "press.idl": block("idl"), "press.cpp": block("cpp", "// press.cpp"),
                           "gauge.cpp": block("cpp", "// gauge.cpp"), "press_test.cpp": block("cpp", "// press_test.cpp"),
                           "cell.xml": block("xml")}.items():
            self.write(os.path.join("project", name), text)
        self.command("cmake -S . -B build -DCMAKE_PREFIX_PATH=/opt/takt", folder)
        self.command("cmake --build build", folder)
        tests = self.command("ctest --test-dir build --output-on-failure", folder)
        self.assertIn("press.Press.CountsItsStrokes", tests.stdout)
        run = self.command("TAKT_COMPONENT_PATH=build/components /opt/takt/bin/takt run cell.xml --for 2", folder)
        self.assertRegex(run.stderr, r"press\.gauge: \| stroke \d+ at 0\.0\d\d m")
        run = self.installed("run", os.path.join(folder, "cell.xml"), "--for", "1.5", "--json", "--quiet",
                             components=os.path.join(folder, "build", "components"))
        self.assert_ran(run, ["press", "gauge"])
        # find_package() must not find the package if the project asks for another version.
        self.write("project/CMakeLists.txt", block("cmake").replace("takt 0.2", "takt 0.3"))
        refused = subprocess.run(["cmake", "-S", folder, "-B", os.path.join(self.folder, "other"), "-DCMAKE_PREFIX_PATH=" + INSTALLED],
                                 capture_output=True, text=True)
        self.assertNotEqual(0, refused.returncode)
        self.assertIn('compatible with requested version "0.3"', re.sub(r"\s+", " ", refused.stderr))

    def build(self, lines):
        """Builds a project from these CMake lines in the folder of the test. Returns the folder that contains its components."""
        self.write("CMakeLists.txt", "cmake_minimum_required(VERSION 3.25)\nproject(outside LANGUAGES C CXX)\n"
                   "find_package(takt REQUIRED)\n" + "\n".join(lines) + "\n")
        build = os.path.join(self.folder, "build")
        for command in (["cmake", "-S", self.folder, "-B", build, "-DCMAKE_PREFIX_PATH=" + INSTALLED], ["cmake", "--build", build]):
            run = subprocess.run(command, capture_output=True, text=True, timeout=5 * takt_system.LONG)
            self.assertEqual(0, run.returncode, run.stdout + run.stderr)
        return os.path.join(build, "components")

    def test_the_programs_in_the_figures_of_the_paper_build_and_run(self):
        names = ["figure8.cpp", "figure9.c", "figure10.cpp", "figure11.cpp"]
        for name in names:
            shutil.copy(os.path.join(SOURCE, "tests", "unit", "component", "figures", name), self.folder)
        components = self.build(["takt_add_%s(%s %s)" % ("process" if name[6:8] in ("9.", "11") else "component",
                                                         name.split(".")[0], name) for name in names])
        descriptor = shutil.copy(self.beside("figures.xml"), self.folder)
        run = self.installed("run", descriptor, "--for", "1", "--json", components=components)
        self.assert_ran(run, [name.split(".")[0] for name in names])
        for name in names:
            self.assertEqual(takt_system.LIFE, run.states(name.split(".")[0]))

    def test_a_legacy_program_becomes_periodic_with_three_changed_lines(self):
        with open(self.beside("legacy.c"), encoding="utf-8") as file:
            legacy = file.read()
        adapted = legacy.replace("#include <unistd.h>\n", "#include <unistd.h>\n#include <takt/process.h>\n")
        adapted = adapted.replace("  while (1) {\n", "  initPeriodExe();\n  while (1) {\n").replace("usleep(1000);", "waitPeriod();")
        self.write("legacy.c", legacy)
        self.write("adapted.c", adapted)
        components = self.build(["add_executable(legacy legacy.c)", "takt_add_process(adapted adapted.c)"])
        self.write("cell.xml", """<cell name="legacy"><device name="d"><module><filename>adapted.exe</filename>
          <moduletype>process</moduletype><operationtype>periodic</operationtype><period>1000000</period><priority>1</priority>
          </module></device></cell>""")
        before = subprocess.Popen([os.path.join(self.folder, "build", "legacy")], stdout=subprocess.PIPE, text=True)
        time.sleep(2)
        before.terminate()
        usleep = before.communicate(timeout=takt_system.LONG)[0]
        run = self.installed("run", os.path.join(self.folder, "cell.xml"), "--for", "2", components=components)
        self.assertEqual(0, run.status, run.err)
        takt = "".join(run.printed("adapted"))
        said = r"off by: median (\d+) us, p99 \d+ us, most \d+ us, in (\d+) periods"
        for words in (usleep, takt):
            self.assertGreater(int(re.search(said, words)[2]), 10)
        print("\n  with usleep(): %s\n  with Takt:     %s" % (usleep.strip(), takt))

    # Tests of the manual, of the completion in bash, and of the systemd unit.

    def test_the_installed_manual_is_complete_and_all_its_links_are_valid(self):
        manual = os.path.join(INSTALLED, "share", "doc", "takt")
        pages = glob.glob(manual + "/**/*.md", recursive=True)
        text_of, anchors = {}, {}
        for page in pages:
            with open(page, encoding="utf-8") as file:
                text_of[page] = re.sub(r"(?ms)^```.*?^```$", "", file.read())
            headings = re.findall(r"(?m)^#+ +(.*?) *$", text_of[page])
            anchors[page] = {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}
        broken, seen = [], 0
        for page, text in text_of.items():
            links = re.findall(r"\]\(([^()\s#]*)#?([^()\s]*)\)", text) + re.findall(r"(?m)^\[[^\[\]]+\]: +([^\s#]+)#?(\S*)", text)
            for target, anchor in links:
                if re.match(r"[a-z]+:", target):
                    continue
                to = os.path.normpath(os.path.join(os.path.dirname(page), target)) if target else page
                seen += 1
                if not os.path.isfile(to) or (anchor and anchor not in anchors[to]):
                    broken.append("%s: %s#%s" % (os.path.relpath(page, manual), target, anchor))
        self.assertEqual([], broken)
        self.assertLess(100, seen)
        # The manual must contain every page that a page names, even if the name is not a link.
        named = {(os.path.relpath(page, manual), name) for page, text in text_of.items()
                 for name in re.findall(r"(?<![\w./-])[\w./-]+\.md\b", re.sub(r"\]\([^)]*\)", "]", text))}
        self.assertEqual([], sorted((page, name) for page, name in named if not any(
            os.path.isfile(os.path.join(manual, folder, name)) for folder in ("", os.path.dirname(page)))))
        source = {os.path.relpath(path, SOURCE) for path in glob.glob(SOURCE + "/docs/*.md") + glob.glob(SOURCE + "/components/*/README.md")}
        explained = {"README.md", "framework/component/README.md", "framework/component/include/takt/port.h", "framework/testing/README.md",
                     "framework/lifecycle/README.md", "idl/README.md", "config/takt.xsd"}
        missing = [path for path in (source | explained) - {"docs/api.md"} if not os.path.isfile(os.path.join(manual, path))]
        self.assertEqual([], sorted(missing))

    def test_each_takt_command_has_a_manual_page(self):
        manual = os.path.join(INSTALLED, "share", "man")
        commands = re.findall(r"^  ([a-z]+)  ", self.installed("--help").out.split("Subcommands:")[1].split("Environment:")[0], re.M)
        self.assertLess(15, len(commands))
        self.assertEqual(sorted("takt%s.1" % name for name in [""] + ["-" + c for c in commands]),
                         sorted(os.listdir(os.path.join(manual, "man1"))))
        for page in glob.glob(manual + "/man*/*"):
            run = subprocess.run(["groff", "-man", "-ww", "-Tutf8", "-z", page], capture_output=True, text=True)
            self.assertEqual((0, ""), (run.returncode, run.stderr), page)
        with open(os.path.join(manual, "man1", "takt-run.1"), encoding="utf-8") as file:
            run = subprocess.run(["groff", "-man", "-Tascii", "-P-cbou"], stdin=file, capture_output=True, text=True)
        self.assertIn("--for SECONDS", run.stdout)
        self.assertIn("end after this many seconds", run.stdout)

    def completed(self, line):
        """Returns the words that bash offers as completions at the end of this line."""
        script = os.path.join(INSTALLED, "share", "bash-completion", "completions", line.split()[0])
        words = line.split(" ")
        run = subprocess.run(["bash", "-c", 'source "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); '
                              'complete_with=$(complete -p "$1"); complete_with=${complete_with#*-F }; "${complete_with%% *}"; '
                              'printf "%s\\n" "${COMPREPLY[@]}"', "bash", script] + words,
                             capture_output=True, text=True, cwd=self.folder, timeout=takt_system.LONG)
        self.assertEqual((0, ""), (run.returncode, run.stderr), line)
        return set(run.stdout.split())

    def test_bash_completes_takt_commands_options_and_files(self):
        self.write("cell.xml", "")
        os.mkdir(os.path.join(self.folder, "case"))
        offered = self.completed("takt s")
        self.assertLessEqual({"status", "start", "stop", "set", "simulate"}, offered)
        self.assertEqual({"s"}, {word[0] for word in offered})
        self.assertEqual({"check"}, self.completed("takt che"))
        self.assertLessEqual({"--for", "--json", "--domain", "--help"}, self.completed("takt run -"))
        self.assertEqual({"--for"}, self.completed("takt run cell.xml --fo"))
        self.assertEqual({"cell.xml", "case"}, self.completed("takt run c"))
        self.assertEqual({"cell.xml", "case"}, self.completed("takt run --profile c"))
        self.assertEqual(set(), self.completed("takt run --for c"))
        self.assertEqual({"table1"}, self.completed("takt bench t"))
        self.assertIn("--html", self.completed("takt bench table1 --"))
        self.assertNotIn("--html", self.completed("takt run --"))
        self.assertEqual({"--device"}, self.completed("takt-node --dev"))
        self.assertEqual({"case"}, self.completed("takt-node --state-dir c"))

    def assert_unit(self, path, program):
        with open(path, encoding="utf-8") as file:
            unit = file.read()
        self.assertIn("\nExecStart=%s --device %%i --resume " % program, unit)
        self.assertNotIn("@CMAKE", unit)

    def test_systemd_accepts_the_installed_unit_file(self):
        path = os.path.join(INSTALLED, "lib", "systemd", "system", "takt-node@.service")
        self.assert_unit(path, PREFIX + "/bin/takt-node")
        if not shutil.which("systemd-analyze"):
            self.skipTest("no systemd-analyze")
        here = os.path.join(self.folder, "takt-node@.service")
        with open(path, encoding="utf-8") as file:
            self.write("takt-node@.service", file.read().replace(PREFIX, INSTALLED))
        run = subprocess.run(["systemd-analyze", "verify", "--man=no", "--recursive-errors=no", here], capture_output=True, text=True)
        self.assertEqual((0, ""), (run.returncode, run.stderr))

    # Tests of real time without root.

    def start_as_nobody(self, *rights, **options):
        """Starts a cell as an ordinary user who has only these rights, which are arguments of setpriv, or prlimit and its arguments."""
        for folder in (WORK, self.folder):
            os.chmod(folder, 0o755)
        before = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"] + list(rights)
        return self.program("takt", "run", os.path.join(INSTALLED, "share", "takt", "deploy", "module.xml"), "--json", "--require-realtime",
                            programs=os.path.join(INSTALLED, "bin"), before=before, environment={"TAKT_COMPONENT_PATH": "", "LD_LIBRARY_PATH": ""},
                            **options)

    def assert_real_time(self, run):
        """Checks that the host and a process module have SCHED_FIFO and locked memory."""
        for module in ("controller1", "control4"):
            run.wait_for_state(module, "EXECUTING")
        for process in (run.one("takt-host"), run.one("control4.exe")):
            self.assertEqual({65534}, {os.stat("/proc/%d" % process.pid).st_uid})
            self.assertIn(os.SCHED_FIFO | os.SCHED_RESET_ON_FORK,
                          [os.sched_getscheduler(int(thread)) for thread in os.listdir("/proc/%d/task" % process.pid)], process)
            with open("/proc/%d/status" % process.pid, encoding="ascii") as status:
                self.assertGreater(int(re.search(r"VmLck:\s+(\d+)", status.read())[1]), 1024, process)
        run.signal(signal.SIGINT)
        self.assertEqual(0, run.wait().status, run.err)
        self.assertIs(True, run.device()["real_time"])
        self.assertNotIn("not real-time", run.err)

    @unittest.skipUnless(os.getuid() == 0 and all(map(shutil.which, ("setpriv", "prlimit", "setcap"))), "needs root, setpriv, prlimit and setcap")
    def test_file_capabilities_of_takt_node_suffice_for_real_time(self):
        node = os.path.join(INSTALLED, "bin", "takt-node")
        commands = block("sh", "setcap")
        for command in ("echo /opt/takt/lib > /etc/ld.so.conf.d/takt.conf", "ldconfig", "setcap cap_sys_nice,cap_ipc_lock+ep /opt/takt/bin/takt-node"):
            self.assertIn(command, commands)
        if subprocess.run(["setcap", "cap_sys_nice,cap_ipc_lock+ep", node], capture_output=True).returncode != 0:
            self.skipTest("files cannot have capabilities here")
        self.addCleanup(subprocess.run, ["setcap", "-r", node], check=True)
        no_limits = ["prlimit", "--rtprio=0", "--memlock=65536"]

        def priority():
            """Returns what takt doctor finds about the priority."""
            run = self.program("takt", "doctor", "--json", programs=os.path.join(INSTALLED, "bin"), environment={"LD_LIBRARY_PATH": ""},
                               before=["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"] + no_limits).wait()
            return next(finding for finding in run.report["findings"] if finding["check"] == "priority")

        run = self.start_as_nobody(*no_limits).wait()
        self.assertEqual(1, run.status)
        self.assertRegex(priority()["found"], r"^takt-node does not start: .*libtakt_component\.so")
        self.assertIn("echo %s/lib > /etc/ld.so.conf.d/takt.conf; ldconfig" % INSTALLED, priority()["cure"])
        # The same as the commands of the page, but only in the mount namespace of this test.
        with open("/etc/ld.so.conf", encoding="utf-8") as machine:
            conf = self.write("ld.so.conf", os.path.join(INSTALLED, "lib") + "\n" + machine.read())
        cache = os.path.join(self.folder, "ld.so.cache")
        subprocess.run(["ldconfig", "-X", "-f", conf, "-C", cache], check=True)
        subprocess.run(["mount", "--bind", cache, "/etc/ld.so.cache"], check=True)
        self.addCleanup(subprocess.run, ["umount", "/etc/ld.so.cache"], check=True)
        self.assertEqual("SCHED_FIFO is granted to takt-node, whose file has capabilities", priority()["found"])
        self.assert_real_time(self.start_as_nobody(*no_limits))

    @unittest.skipUnless(os.getuid() == 0 and all(map(shutil.which, ("setpriv", "prlimit"))), "needs root, setpriv and prlimit")
    def test_ambient_capabilities_of_a_service_suffice_for_real_time(self):
        self.assert_real_time(self.start_as_nobody("--inh-caps=+sys_nice,+ipc_lock", "--ambient-caps=+sys_nice,+ipc_lock",
                                                   "prlimit", "--rtprio=0", "--memlock=65536"))

    @unittest.skipUnless(os.getuid() == 0 and all(map(shutil.which, ("setpriv", "prlimit"))), "needs root, setpriv and prlimit")
    def test_the_limits_of_the_service_suffice_for_real_time(self):
        limits = ["prlimit", "--rtprio=99", "--memlock=unlimited"]
        if subprocess.run(limits + ["true"], capture_output=True).returncode != 0:
            self.skipTest("root may not raise limits here (CAP_SYS_RESOURCE)")
        with open(os.path.join(INSTALLED, "lib", "systemd", "system", "takt-node@.service"), encoding="utf-8") as unit:
            self.assertRegex(unit.read(), r"(?m)^LimitRTPRIO=99\nLimitMEMLOCK=infinity$")

        def raise_limits():
            resource.setrlimit(resource.RLIMIT_RTPRIO, (99, 99))
            resource.setrlimit(resource.RLIMIT_MEMLOCK, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
        self.assert_real_time(self.start_as_nobody(become=raise_limits))

    # Tests of the Debian packages.

    @unittest.skipUnless(shutil.which("dpkg-shlibdeps"), "no dpkg-dev")
    def test_each_debian_package_has_the_correct_files_and_dependencies(self):
        command = "cd build/release && cpack -G DEB"
        self.assertIn(command, PAGE)
        packages = os.path.join(self.folder, "packages")
        run = subprocess.run(["cpack", "-G", "DEB", "--config", os.path.join(BUILD, "CPackConfig.cmake"), "-B", packages],
                             capture_output=True, text=True, timeout=5 * takt_system.LONG)
        self.assertEqual(0, run.returncode, run.stdout + run.stderr)
        self.assertEqual(["takt-dev_0.2.0", "takt_0.2.0"],
                         sorted(os.path.basename(p).rsplit("_", 1)[0] for p in glob.glob(packages + "/*.deb")))
        root = os.path.join(self.folder, "root")
        fields = {}
        content = {}
        for name in ("takt", "takt-dev"):
            package = glob.glob("%s/%s_*.deb" % (packages, name))[0]
            fields[name] = subprocess.run(["dpkg-deb", "-f", package, "Depends"], capture_output=True, text=True, check=True).stdout
            content[name] = subprocess.run(["dpkg-deb", "-c", package], capture_output=True, text=True, check=True).stdout
            subprocess.run(["dpkg-deb", "-x", package, root], check=True)
        for dependency in ("libfast(rtps|dds)", "libtinyxml2", "libc6"):
            self.assertRegex(fields["takt"], dependency)
        # takt_add_idl() needs neither Fast DDS nor Java, so takt-dev must not depend on them.
        self.assertEqual("takt (= 0.2.0), g++, cmake (>= 3.25), python3 (>= 3.9)", fields["takt-dev"].strip())
        for path in ("bin/takt", "lib/takt/takt-host", "lib/takt/components/servo.so", "share/takt/takt.xsd", "share/man/man1/takt.1",
                     "share/bash-completion/completions/takt", "lib/systemd/system/takt-node@.service"):
            self.assertRegex(content["takt"], r" \./usr/%s\n" % re.escape(path))
        self.assertNotIn("./usr/include/", content["takt"])
        self.assertRegex(content["takt-dev"], r" \./usr/include/takt/component\.hpp\n")
        self.assertNotIn("/bin/", content["takt-dev"])
        for listing in content.values():
            self.assertNotRegex(listing, r" \./(?!usr/)\S")
        self.assert_unit(os.path.join(root, "usr", "lib", "systemd", "system", "takt-node@.service"), "/usr/bin/takt-node")
        run = self.installed("run", os.path.join(root, "usr", CELL), "--for", "1", "--json", "--quiet", root=os.path.join(root, "usr"))
        self.assert_ran(run, ["trajectory", "conveyor", "panel"])


if __name__ == "__main__":
    takt_system.main()
