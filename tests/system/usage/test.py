import hashlib
import json
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system

TRACE = json.dumps({"otherData": {"format": "takt trace 1", "cell": "c", "device": "d", "machine": "m", "kernel": "k", "why": "requested",
                                  "taken_utc_ns": 0, "lasts_us": 1000.0, "lost": 0, "threads": []}, "traceEvents": []})
EXAMPLE = os.path.join(takt_system.SOURCE, "deploy", "module.xml")


class Usage(takt_system.Case):
    def test_takt_exits_with_status_2_on_invalid_arguments(self):
        for arguments in ([], ["nonsense"], ["run"], ["check"], ["graph"], ["describe", "--json", "--xml"], ["run", EXAMPLE, "more"], ["run", EXAMPLE, "--nope"],
                          ["check", "--for", "1", EXAMPLE], ["run", EXAMPLE, "--for"], ["run", EXAMPLE, "--for", "soon"],
                          ["run", EXAMPLE, "--for", "-1"], ["run", EXAMPLE, "--for", "0"], ["run", EXAMPLE, "--for", "inf"],
                          ["run", EXAMPLE, "--for", "nan"], ["run", EXAMPLE, "--for", "1e300"]):
            with self.subTest(arguments=arguments):
                run = self.takt(*arguments)
                self.assertEqual((2, ""), (run.status, run.out), run.err)
                if arguments == ["nonsense"]:
                    self.assertEqual("takt: there is no command 'nonsense'; takt --help lists all commands", run.err.strip())
                    continue
                self.assertIn("Usage: takt", run.err)
                self.assertRegex(run.err, "^error: ")
                if arguments and arguments[0] in ("run", "check", "graph", "describe"):
                    self.assertEqual(3, len(run.err.splitlines()), run.err)
                    self.assertEqual("takt %s --help explains all options" % arguments[0], run.err.splitlines()[2])
                self.assertLess(max(map(len, run.err.splitlines())), 200)

    def test_takt_help_prints_the_help_of_a_command(self):
        self.assertEqual(self.takt("--help").out, self.takt("help").out)
        self.assertEqual(self.takt("check", "--help").out, self.takt("help", "check").out)
        self.assertEqual(0, self.takt("help", "check").status)

    def test_takt_suggests_the_correct_spelling_of_a_misspelled_command(self):
        run = self.takt("staus")
        self.assertEqual((2, "", "takt: there is no command 'staus'; did you mean status?"), (run.status, run.out, run.err.strip()))
        run = self.takt("stat")
        self.assertEqual((2, "takt: there is no command 'stat'; did you mean status?"), (run.status, run.err.strip()))
        run = self.takt("secure", "list")
        self.assertEqual((2, "", "takt secure: there is no command 'list'; the commands are init, add, update, renew, revoke, show"),
                         (run.status, run.out, run.err.splitlines()[0]))
        run = self.takt("graph", "cell.xml", "--svgg", "out.svg")
        self.assertEqual((2, ""), (run.status, run.out))
        self.assertRegex(run.err, r"(?m)^there is no option --svgg; did you mean --svg\?$")
        run = self.takt("get", "line.belt.speed", "speed")
        self.assertEqual((1, ""), (run.status, run.out))
        self.assertIn("'line.belt.speed' is not the name of a module; write DEVICE.MODULE, a space and the property", run.err)

    def test_takt_says_that_the_command_stands_before_its_options(self):
        for arguments in (["--domain", "7", "status"], ["--json", "status"], ["--foo"]):
            run = self.takt(*arguments)
            self.assertEqual((2, ""), (run.status, run.out), run.err)
            self.assertIn("takt: the command must stand before its options", run.err)
            self.assertIn("'%s' is not a command" % arguments[0], run.err)
        self.assertEqual(self.takt("status", "--help").out, self.takt("--help", "status").out)

    def test_wrong_addresses_are_rejected_before_the_network_is_used(self):
        for given, reason in ((("--server", "10.0.0.1"), "'10.0.0.1' is not an address and a port, as in 10.0.0.1:11811"),
                              (("--server", "10.0.0.1:0"), "'10.0.0.1:0' is not an address and a port"),
                              (("--peers", ""), "it names no address; write it as in 10.0.0.1,10.0.0.2"),
                              (("--peers", "10.0.0.1,10.0.0"), "'10.0.0' is not an IPv4 address or a host name without a port")):
            for run in (self.takt("status", *given), self.program("takt-node", "--device", "d", *given)):
                with self.subTest(given=given):
                    run.wait()
                    self.assertEqual((2, ""), (run.status, run.out))
                    self.assertIn("%s: %s" % (given[0], reason), run.err)

    def test_takt_set_rejects_a_name_and_a_value_in_one_argument(self):
        run = self.takt("set", "line.belt", "feed=3")
        self.assertEqual((2, ""), (run.status, run.out))
        self.assertIn("'feed=3' is not the name of a property; write the name and the value as two arguments: feed 3", run.err)

    def test_takt_set_says_what_is_missing(self):
        for given, reason in ((["line.belt.feed", "3"], "'line.belt.feed' is not the name of a module; write takt set line.belt feed 3"),
                              (["feed", "3"], "'feed' is not the name of a module; write takt set DEVICE.MODULE feed 3"),
                              (["line.belt", "feed"], "the value is missing; write takt set line.belt feed VALUE"),
                              (["line.belt"], "the property and its value are missing; write takt set line.belt PROPERTY VALUE")):
            with self.subTest(given=given):
                run = self.takt("set", *given)
                self.assertEqual((2, ""), (run.status, run.out))
                self.assertIn("error: " + reason + "\n", run.err)

    def test_takt_node_says_which_option_a_word_without_option_needs(self):
        for given, words in ((["spool"], "\nwrite --device spool\n"),
                             (["--device", "spool", "--interface", "lo"],
                              "\nthere is no option --interface; set the environment variable TAKT_INTERFACE to the address\n")):
            with self.subTest(given=given):
                run = self.program("takt-node", *given)
                run.wait()
                self.assertEqual((2, ""), (run.status, run.out))
                self.assertIn(words, run.err)

    def test_a_domain_that_is_no_number_is_named(self):
        run = self.takt("status", "--domain", "x")
        self.assertEqual((2, ""), (run.status, run.out))
        self.assertIn("error: --domain takes a number, 0 to 232, not 'x'\n", run.err)

    def test_takt_log_says_that_a_descriptor_is_not_a_fault_record(self):
        run = self.takt("log", "--file", EXAMPLE)
        self.assertEqual((1, ""), (run.status, run.out))
        self.assertIn("%s: error: is not a fault record; name the file DEVICE.DOMAIN.faults" % EXAMPLE, run.err)

    def test_takt_deploy_says_that_the_environment_replaces_the_domain_of_the_descriptor(self):
        other = (self.domain + 1) % 200 + 1
        cell = self.write("cell.xml", "<cell name='c' domain='%d'><device name='d'><module>"
                          "<filename>fine.so</filename><moduletype>thread</moduletype><operationtype>periodic</operationtype>"
                          "<period>1000000</period><priority>1</priority></module></device></cell>" % other)
        note = "note: TAKT_DOMAIN sets domain %d instead of the descriptor's domain %d" % (self.domain, other)
        self.assertIn(note, self.takt("deploy", cell).err)
        self.assertNotIn("TAKT_DOMAIN sets", self.takt("deploy", cell, "--domain", str(self.domain)).err)

    def test_the_advice_to_start_a_node_has_the_discovery_options_of_the_command(self):
        for options in (["--peers", "127.0.0.1,no-such-host.invalid"], ["--server", "127.0.0.1:11811"]):
            run = self.takt("status", *options)
            self.assertEqual((1, ""), (run.status, run.out))
            self.assertIn("start a node with takt-node --device NAME --domain %d %s" % (self.domain, " ".join(options)), run.err)
            self.assertEqual("--peers" in options, "peer 'no-such-host.invalid' cannot be resolved: " in run.err)

    def test_files_that_cannot_be_written_as_wanted_are_rejected_before_any_work(self):
        for command in ("graph", "check", "trace", "plot"):
            run = self.takt(command, "x", "--svg", "out.png")
            with self.subTest(command=command):
                self.assertEqual((2, ""), (run.status, run.out))
                self.assertIn("--svg: 'out.png' ends in .png, but the drawing is an SVG file; write out.svg", run.err)

    def test_a_file_in_a_missing_folder_is_rejected_alike_by_every_command(self):
        recorded = self.write("recorded.trace", TRACE)
        for arguments in (["graph", EXAMPLE, "--svg"], ["check", EXAMPLE, "--svg"], ["simulate", EXAMPLE, "--for", "0.01", "--trace"],
                          ["trace", recorded, "-o"], ["trace", recorded, "--svg"], ["bench", "table1", "--html"], ["record", "d.m.p", "--out"]):
            path = os.path.join(self.folder, "none", "file.svg")
            run = self.takt(*arguments, path)
            with self.subTest(arguments=arguments):
                self.assertEqual((1, ""), (run.status, run.out))
                self.assertIn("%s: error: cannot be written: the folder %s does not exist; create it, or choose another file"
                              % (path, os.path.dirname(path)), run.err)
                self.assertFalse(os.path.exists(os.path.dirname(path)))

    def test_all_users_may_read_a_drawing_as_the_umask_says(self):
        recorded = self.write("recorded.trace", TRACE)
        for number, arguments in enumerate((["graph", EXAMPLE, "--svg"], ["trace", recorded, "-o"], ["trace", recorded, "--svg"])):
            path = os.path.join(self.folder, "%d.svg" % number)
            run = self.takt(*arguments, path, become=lambda: os.umask(0o027))
            self.assertEqual((0, ""), (run.status, run.err))
            self.assertEqual(0o640, os.stat(path).st_mode & 0o777, arguments)

    def test_takt_echo_accepts_n_and_count_as_options_for_the_number_of_lines(self):
        for option in ("-n", "--count"):
            run = self.takt("echo", option, "1", "line.belt")
            self.assertEqual((1, ""), (run.status, run.out))
            self.assertEqual("error: 'line.belt' is not a port name; write DEVICE.MODULE.PORT", run.err.strip())
            run = self.takt("echo", option, "0", "line.belt.scene")
            self.assertEqual((2, ""), (run.status, run.out))
            self.assertIn("--count: it must be at least 1; leave it out to print until Ctrl-C", run.err)
            run = self.takt("echo", option, "x", "line.belt.scene")
            self.assertEqual((2, ""), (run.status, run.out))
            self.assertIn("error: --count takes a number, not 'x'\n", run.err)

    def test_takt_undeploy_names_the_cell_of_a_file(self):
        cell = self.write("cell.xml", "<cell name='belt'><device name='d'><module><filename>fine.so</filename><moduletype>thread</moduletype>"
                          "<operationtype>periodic</operationtype><period>1ms</period><priority>1</priority></module></device></cell>")
        self.refused({"undeploy " + cell: r"^error: '%s' is a file, but the name of a cell is needed; write takt undeploy belt$" % cell})

    def test_takt_trace_names_what_is_neither_a_file_nor_a_device(self):
        self.refused({"trace line.belt": r"^error: 'line\.belt' is neither an existing file nor a valid device name; give the name of a device, "})

    def test_takt_log_lists_the_valid_event_kinds_after_an_unknown_kind(self):
        kinds = self.takt("log", "--help").out.split("Kinds:")[1].rstrip(".\n").replace(",", " ").split()
        self.assertLess(20, len(kinds))
        run = self.takt("log", "--kind", "nosuchkind")
        self.assertEqual((2, ""), (run.status, run.out))
        for kind in kinds:
            self.assertRegex(run.err, r"[ ,]%s\b" % kind)
        self.assertNotRegex(run.err, r"\d more")
        self.refused({"log --file /nowhere --kind " + ",".join(kinds): "there is no such file"})

    def test_the_options_help_and_version_exit_with_status_0(self):
        for arguments in (["--help"], ["run", "--help"], ["--version"]):
            run = self.takt(*arguments)
            self.assertEqual((0, ""), (run.status, run.err))
            self.assertNotEqual("", run.out)

    def test_takt_rejects_an_invalid_descriptor_and_names_the_line(self):
        garbage = self.write("garbage.xml", "\0\1\2 no descriptor")
        empty = self.write("empty.xml", "")
        for command in (["check"], ["check", "--json"], ["graph"], ["graph", "--json"], ["run", "--json"]):
            for file, line in ((os.path.join(self.folder, "absent.xml"), ""), (self.folder, ""), (garbage, ":1"), (empty, ":1"),
                               (self.beside("not_well_formed.xml"), ":4")):
                with self.subTest(command=command, file=file):
                    run = self.takt(*command, file)
                    self.assertEqual((1, ""), (run.status, run.out))
                    self.assertEqual(1, len(run.err.splitlines()), run.err)
                    self.assertTrue(run.err.startswith("%s%s: error: " % (file, line)), run.err)

    def test_takt_graph_draws_a_cell_whose_components_are_missing(self):
        cell = self.write("cell.xml", """<cell name="c">
  <device name="d">
    <module><filename>nowhere.so</filename><moduletype>thread</moduletype><operationtype>periodic</operationtype>
      <period>1000000</period><priority>1</priority></module>
  </device>
  <connection from="d.nowhere.out" topic="rt/x"/>
</cell>""")
        text = self.takt("graph", cell)
        self.assertEqual((0, ""), (text.status, text.err))
        self.assertIn("d.nowhere.out", text.out)
        report = self.takt("graph", cell, "--json").report
        self.assertEqual([{"from": "d.nowhere.out", "to": None, "kind": "latest", "reliability": "best-effort", "topic": "rt/x"}],
                         report["connections"])
        picture = os.path.join(self.folder, "c.svg")
        drawn = self.takt("graph", cell, "--svg", picture)
        self.assertEqual((0, "", ""), (drawn.status, drawn.out, drawn.err))
        with open(picture, encoding="utf-8") as file:
            self.assertIn(">rt/x<", file.read())
        self.assertEqual("c", self.takt("graph", cell, "--svg", picture, "--json").report["cell"])
        refused = self.takt("graph", cell, "--svg", os.path.join(self.folder, "nowhere", "c.svg"))
        self.assertEqual((1, ""), (refused.status, refused.out))
        self.assertIn("cannot be written", refused.err)

    def test_takt_describe_shows_the_hooks_and_properties_of_a_cpp_component(self):
        run = self.takt("describe", "cpp_properties.so", "--json")
        self.assertEqual((0, ""), (run.status, run.err))
        self.assertEqual(["name", "text", "version", "interface", "operation", "hooks", "properties", "ports", "saved", "file", "hash"],
                         list(run.report))
        self.assertEqual("1.2.0", run.report["version"])
        with open(run.report["file"], "rb") as file:
            self.assertEqual(hashlib.sha256(file.read()).hexdigest()[:8], run.report["hash"])
        self.assertEqual(("CppProperties", "c++"), (run.report["name"], run.report["interface"]))
        properties = {p["name"]: p for p in run.report["properties"]}
        self.assertEqual(["enabled", "count", "offset", "gain", "ratio", "label"], list(properties))
        self.assertEqual({"name": "count", "type": "integer", "default": "3", "range": "1 to 10", "min": 1, "max": 10,
                          "unit": "parts", "text": "At a time."}, properties["count"])
        self.assertEqual(["bool", "integer", "integer", "double", "double", "string"], [p["type"] for p in properties.values()])
        text = self.takt("describe", "cpp_properties.so").out
        for word in list(properties) + ["version     1.2.0, hash " + run.report["hash"], "c++", "1 to 10", "parts", "At a time."]:
            self.assertIn(word, text)

    def test_takt_describe_shows_the_hooks_of_a_c_component_and_the_kind_of_a_program(self):
        c = self.takt("describe", "fine.so", "--json").report
        self.assertEqual(("fine", "c", []), (c["name"], c["interface"], c["properties"]))
        self.assertEqual(["initialize", "start", "run", "error", "recover", "destruct"], c["hooks"])
        self.assertIn("condition", self.takt("describe", "fine_sporadic.so").out)
        process = self.takt("describe", "fine.exe", "--json").report
        self.assertEqual(("fine", "process", "periodic", [], [], []),
                         tuple(process[key] for key in ("name", "interface", "operation", "hooks", "properties", "ports")))
        self.assertIn("process", self.takt("describe", "fine.exe").out)

    def test_takt_run_accepts_the_module_element_that_takt_describe_prints(self):
        elements = ""
        for component in ("cpp_properties.so", "fine.so", "fine_sporadic.so", "grid.exe"):
            elements += self.takt("describe", component, "--xml").out
        file = self.write("pasted.xml", "<root>\n%s</root>\n" % elements)
        run = self.takt("run", file, "--for", "0.2", "--json")
        self.assertEqual(0, run.status, run.err)
        self.assertEqual(4, len(run.modules()))

    def test_the_module_element_of_a_component_with_an_event_port_is_valid_once_the_port_is_connected(self):
        events = self.takt("describe", "port_events.so", "--xml").out
        for line in ("<name>port_events</name>", "<operationtype>sporadic</operationtype>", "<deadline>1ms</deadline>",
                     "<dispatch>immediate</dispatch>"):
            self.assertIn(line, events)
        modules = self.takt("describe", "port_source.so", "--xml").out + events
        cell = "<cell name='c'><device name='d'>%s</device>%s</cell>"
        alone = self.takt("check", self.write("alone.xml", cell % (modules, "")))
        self.assertEqual(1, len(alone.err.splitlines()), alone.err)
        self.assertIn("none of its event ports is connected", alone.err)
        connection = "<connection from='d.port_source.out' to='d.port_events.event' kind='queue' depth='4'/>"
        fed = self.takt("check", self.write("fed.xml", cell % (modules, connection)))
        self.assertEqual((0, ""), (fed.status, fed.err))
        self.assertNotIn("without a connection", fed.out)
        shallow = self.takt("check", self.write("shallow.xml", cell % (modules, "\n" + connection.replace("depth='4'", ""))))
        self.assertEqual(0, shallow.status, shallow.err)
        self.assertRegex(shallow.err, r'^\S*shallow\.xml:\d+: warning: the queue to d\.port_events\.event has no depth, so it holds 1 '
                                      r'sample: .*; write depth="8" [^\n]*$')
        row = events.replace("<dispatch>immediate</dispatch>", "")
        unfed = self.takt("check", self.write("unfed.xml", cell % (row, "")))
        self.assertEqual((0, ""), (unfed.status, unfed.err))
        self.assertRegex(unfed.out, r"\ninputs without a connection, .*\n  d\.port_events, on line \d+: event\n$")
        latest = self.takt("check", self.write("latest.xml", cell % (modules, "\n" + connection.replace("kind='queue' depth='4'", ""))))
        self.assertEqual(0, latest.status, latest.err)
        self.assertRegex(latest.err, r'^\S*latest\.xml:\d+: warning: the connection to event port d\.port_events\.event holds only the '
                                     r'latest value, .*; write kind="queue" depth="8"')

    def test_takt_describe_rejects_files_that_are_not_components(self):
        for file, words in (("not_a_library.so", "neither a shared object nor a program"), ("no_such_file.so", "there is no file"),
                            ("no_run.so", "has no function run()"), ("undefined_symbol.so", "takt_test_defined_nowhere"),
                            ("wrong_default.so", "a property 'speed' whose default 20 is out of its range: 0 to 10"),
                            ("wrong_default.so", "declares property 'log-level', but every module already has this property"),
                            ("tank", "; to describe a module of a cell, write takt describe CELL.xml tank"),
                            ("port_events", "did you mean port_events.so? To describe a module of a cell"),
                            (self.folder, "no components found")):
            with self.subTest(file=file):
                run = self.takt("describe", file)
                self.assertEqual((1, ""), (run.status, run.out))
                self.assertRegex(run.err, "^error: .*")
                self.assertIn(words, run.err)


if __name__ == "__main__":
    takt_system.main()
