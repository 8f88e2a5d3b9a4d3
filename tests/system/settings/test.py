"""Settings for other programs with Fast DDS, in the environment or in the working folder, change neither a node nor a command."""
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import wait_until

# A program with these defaults finds only programs with the same ones.
PROFILE = """<dds xmlns="http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles"><profiles>%s</profiles></dds>""" % "".join(
    '<%s profile_name="%s" is_default_profile="true"><qos><partition><names><name>other</name></names></partition></qos></%s>' % (end, end, end)
    for end in ("publisher", "subscriber"))
SERVER = "127.0.0.1:9"  # no discovery server has this address


class Settings(takt_system.Case):
    def setUp(self):
        super().setUp()
        profile = self.write("profile.xml", PROFILE)
        variables = {"FASTRTPS_DEFAULT_PROFILES_FILE": profile, "FASTDDS_DEFAULT_PROFILES_FILE": profile,
                     "FASTDDS_ENVIRONMENT_FILE": self.write("environment.json", '{"ROS_DISCOVERY_SERVER": "%s"}' % SERVER),
                     "ROS_DISCOVERY_SERVER": SERVER, "FASTDDS_STATISTICS": "NOT_A_TOPIC"}
        self.settings = {name.lower().replace("_", "-"): {"environment": {name: value}} for name, value in variables.items()}
        folder = os.path.join(self.folder, "working")
        os.mkdir(folder)
        for name in ("DEFAULT_FASTRTPS_PROFILES.xml", "DEFAULT_FASTDDS_PROFILES.xml"):
            self.write(os.path.join("working", name), PROFILE)
        self.settings["working-folder"] = {"before": ("env", "-C", folder)}

    def test_a_node_ignores_settings_of_fast_dds(self):
        nodes = {name: self.node(name, **options) for name, options in self.settings.items()}

        def all_found():
            run = self.takt("status", "--json")
            return run.status == 0 and {d["name"] for d in run.report["devices"]} == set(nodes)
        wait_until(all_found, "each node to be found")
        self.end(nodes)
        for name, node in nodes.items():
            self.assertEqual([], node.other_lines, name)

    def test_a_command_ignores_settings_of_fast_dds(self):
        self.node("robot")
        for name, run in {name: self.start("status", **options) for name, options in self.settings.items()}.items():
            self.assertEqual((0, ""), (run.wait().status, run.err), name)

    def test_the_program_of_a_process_module_gets_settings_of_fast_dds(self):
        given = {name: value for options in self.settings.values() for name, value in options.get("environment", {}).items()}
        cell = self.write("cell.xml", """<root><module><name>program</name><filename>fine.exe</filename><moduletype>process</moduletype>
          <operationtype>periodic</operationtype><period>20ms</period><priority>1</priority></module></root>""")
        run = self.start("run", cell, environment=given)
        run.wait_for_state("program", "EXECUTING")
        with open("/proc/%d/environ" % run.one("fine.exe").pid) as file:
            found = dict(entry.split("=", 1) for entry in file.read().split("\0") if entry)
        self.assertEqual(given, {name: value for name, value in found.items() if name in given or name.startswith("SKIP_DEFAULT_XML")})


if __name__ == "__main__":
    takt_system.main()
