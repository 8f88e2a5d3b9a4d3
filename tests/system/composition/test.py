import os
import re
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import LIFE

HERE = os.path.dirname(os.path.abspath(__file__))
EXAMPLE = os.path.join(takt_system.SOURCE, "deploy", "arms.xml")
MODULES = {"robot": ["trajectory", "left_servo", "left_joints", "right_servo", "right_joints"],
           "far": ["pair_arm_servo", "pair_arm_joints", "pair_mirror"]}


class Composition(takt_system.Case):
    def with_parts(self, change):
        """Writes the cell, and a changed copy of the file that it includes. Returns both paths."""
        with open(os.path.join(HERE, "cell.xml")) as file:
            cell = self.write("cell.xml", file.read())
        with open(os.path.join(HERE, "parts", "arm.xml")) as file:
            text = file.read()
        os.makedirs(os.path.join(os.path.dirname(cell), "parts"), exist_ok=True)
        self.assertNotEqual(text, change(text))
        return cell, self.write("parts/arm.xml", change(text))

    def test_a_cell_of_templates_runs_like_the_equivalent_cell_without_templates(self):
        run = self.takt("run", "cell.xml", "--for", "1", "--json")
        self.assertEqual(0, run.status, run.err)
        for device, modules in MODULES.items():
            self.assertEqual(modules, list(run.modules(device)))
            for module in modules:
                self.assertEqual(LIFE, run.states(module, device))
                self.assert_grid(run, module, device=device)

    def test_the_template_example_and_its_expanded_form_describe_the_same_cell(self):
        expanded = self.takt("check", EXAMPLE, "--expanded")
        self.assertEqual(0, expanded.status, expanded.err)
        for gone in ("<include", "<template", "<use", "${"):
            self.assertNotIn(gone, expanded.out)
        self.assertRegex(expanded.out, r"<!-- \S+parts/arm\.xml:9, used at \S+arms\.xml:\d+ -->")
        flat = self.write("arms.xml", expanded.out)
        self.assertEqual(self.takt("check", EXAMPLE, "--json").report, self.takt("check", flat, "--json").report)
        run = self.takt("run", EXAMPLE, "--for", "1", "--json")
        self.assertEqual(0, run.status, run.err)
        self.assertEqual(["trajectory", "left_servo", "left_joints", "right_servo", "right_joints", "worn_servo", "worn_joints"],
                         list(run.modules("robot")))

    def test_takt_deploy_works_when_the_nodes_do_not_have_the_included_files(self):
        nodes = self.nodes(*MODULES)
        run = self.deploy("cell.xml")
        self.assertEqual("cell cell runs on robot, far\n", run.out)
        for device, modules in MODULES.items():
            for module in modules:
                nodes[device].wait_for_state(module, "EXECUTING")
        self.assertEqual(["12", "15"], self.done("get robot.right_servo bandwidth", "get far.pair_arm_servo bandwidth"))
        self.done("undeploy cell")
        # If a node finds an error, the message must name the lines of the original files.
        cell, parts = self.with_parts(lambda text: text.replace("<name>mirror</name> <filename>arm.so", "<name>mirror</name> <filename>nobody.so"))
        run = self.takt("deploy", cell)
        self.assertEqual(1, run.status)
        self.assertRegex(run.err, r"(?m)^%s:23: error: device far: module pair_mirror: there is no file nobody\.so on .* \(used at %s:13\);" %
                         (re.escape(parts), re.escape(cell)))
        self.end(nodes)

    def assert_wrong(self, change, *expected):
        cell, parts = self.with_parts(change)
        run = self.takt("check", cell)
        self.assertEqual(1, run.status)
        lines = run.err.splitlines()
        self.assertEqual(len(expected), len(lines), run.err)
        for line, pattern in zip(lines, expected):
            self.assertRegex(line, pattern.replace("PARTS", re.escape(parts)).replace("CELL", re.escape(cell)))

    def test_errors_in_a_template_cite_the_line_in_the_template_and_the_line_of_its_use(self):
        # The parser reports this error once for all three uses.
        self.assert_wrong(lambda text: text.replace("<priority>2</priority>", "<priority>two</priority>"),
                          r"^PARTS:7: error: <priority> is not a whole number: 'two' \(used at CELL:9, and 2 more\);")
        # The planner finds these errors.
        self.assert_wrong(lambda text: text.replace("<priority>4</priority>", "<priority>4</priority> <budget>3000000</budget>"),
                          r"^PARTS:22: error: the budget of 'pair_mirror', 3 ms, is larger than its period, 2 ms \(used at CELL:13\);",
                          r"^PARTS:22: error: the budgets of row 0 .* \(used at CELL:13\);")
        # The component reports these errors: an invalid property and an unknown port.
        self.assert_wrong(lambda text: text.replace('name="bandwidth">${', 'name="bandwith">${'),
                          *[r"^PARTS:8: error: module %s: .*'bandwith'.* \(used at %s\)" % (module, where) for module, where in
                            (("left_servo", "CELL:9"), ("right_servo", "CELL:10"), ("pair_arm_servo", "PARTS:21, used at CELL:13"))])
        self.assert_wrong(lambda text: text.replace('of="servo.setpoint"', 'of="servo.setpont"'),
                          *[r"^CELL:%d: error: module \S+_servo has no port 'setpont'" % line for line in (15, 16, 17)])


if __name__ == "__main__":
    takt_system.main()
