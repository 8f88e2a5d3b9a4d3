import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system

EXAMPLE = os.path.join(takt_system.SOURCE, "deploy", "module.xml")


class Usage(takt_system.Case):
    def test_wrong_usage_is_status_2(self):
        for arguments in ([], ["nonsense"], ["run"], ["check"], ["describe"], ["run", EXAMPLE, "more"], ["run", EXAMPLE, "--nope"],
                          ["check", "--for", "1", EXAMPLE], ["run", EXAMPLE, "--for"], ["run", EXAMPLE, "--for", "soon"],
                          ["run", EXAMPLE, "--for", "-1"], ["run", EXAMPLE, "--for", "0"], ["run", EXAMPLE, "--for", "inf"],
                          ["run", EXAMPLE, "--for", "nan"], ["run", EXAMPLE, "--for", "1e300"]):
            with self.subTest(arguments=arguments):
                run = self.takt(*arguments)
                self.assertEqual((2, ""), (run.status, run.out), run.err)
                self.assertIn("Usage: takt", run.err)
                self.assertLess(max(map(len, run.err.splitlines())), 200)

    def test_help_and_version_are_no_errors(self):
        for arguments in (["--help"], ["run", "--help"], ["--version"]):
            run = self.takt(*arguments)
            self.assertEqual((0, ""), (run.status, run.err))
            self.assertNotEqual("", run.out)

    def test_what_is_no_descriptor_is_refused_at_its_line(self):
        garbage = self.write("garbage.xml", "\0\1\2 no descriptor")
        empty = self.write("empty.xml", "")
        for command in (["check"], ["check", "--json"], ["run", "--json"]):
            for file, line in ((os.path.join(self.folder, "absent.xml"), 1), (self.folder, 1), (garbage, 1), (empty, 1),
                               (self.beside("not_well_formed.xml"), 4)):
                with self.subTest(command=command, file=file):
                    run = self.takt(*command, file)
                    self.assertEqual((1, ""), (run.status, run.out))
                    self.assertEqual(1, len(run.err.splitlines()), run.err)
                    self.assertTrue(run.err.startswith("%s:%d: error: " % (file, line)), run.err)

    def test_describe_a_component_in_cpp(self):
        run = self.takt("describe", "cpp_properties.so", "--json")
        self.assertEqual((0, ""), (run.status, run.err))
        self.assertEqual(["name", "interface", "hooks", "properties"], list(run.report))
        self.assertEqual(("CppProperties", "c++"), (run.report["name"], run.report["interface"]))
        properties = {p["name"]: p for p in run.report["properties"]}
        self.assertEqual(["enabled", "count", "offset", "gain", "ratio", "label"], list(properties))
        self.assertEqual({"name": "count", "type": "integer", "default": "3", "range": "1 to 10", "unit": "parts",
                          "text": "At a time."}, properties["count"])
        self.assertEqual(["bool", "integer", "integer", "double", "double", "string"], [p["type"] for p in properties.values()])
        text = self.takt("describe", "cpp_properties.so").out
        for word in list(properties) + ["c++", "1 to 10", "parts", "At a time."]:
            self.assertIn(word, text)

    def test_describe_a_module_in_c_and_a_process(self):
        c = self.takt("describe", "fine.so", "--json").report
        self.assertEqual(("fine", "c", []), (c["name"], c["interface"], c["properties"]))
        self.assertEqual(["initialize", "start", "run", "error", "recover", "destruct"], c["hooks"])
        self.assertIn("condition", self.takt("describe", "fine_sporadic.so").out)
        process = self.takt("describe", "fine.exe", "--json").report
        self.assertEqual({"name": "fine", "interface": "process", "hooks": [], "properties": []}, process)
        self.assertIn("process", self.takt("describe", "fine.exe").out)

    def test_what_describe_gives_to_paste_runs(self):
        elements = ""
        for component in ("cpp_properties.so", "fine.so", "fine_sporadic.so", "grid.exe"):
            elements += self.takt("describe", component, "--xml").out
        file = self.write("pasted.xml", "<root>\n%s</root>\n" % elements)
        run = self.takt("run", file, "--for", "0.2", "--json")
        self.assertEqual(0, run.status, run.err)
        self.assertEqual(4, len(run.modules()))

    def test_describe_what_is_no_component(self):
        for file, words in (("not_a_library.so", "neither a shared object nor a program"), ("no_such_file.so", "there is no file"),
                            ("no_run.so", "has no function run()"), ("undefined_symbol.so", "takt_test_defined_nowhere"),
                            (self.folder, "is not a file")):
            with self.subTest(file=file):
                run = self.takt("describe", file)
                self.assertEqual((1, ""), (run.status, run.out))
                self.assertRegex(run.err, "^error: .*")
                self.assertIn(words, run.err)


if __name__ == "__main__":
    takt_system.main()
