import os
import re
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
from takt_system import LIFE, wait_until

SEEDS = [int(seed) for seed in os.environ.get("TAKT_SCRIBBLES", "1 2 3 4").split()]


class Scribbles(takt_system.Case):
    def test_a_node_survives_a_module_that_writes_random_words_to_shared_memory(self):
        with open(self.beside("cell.xml")) as file:
            cell = file.read()
        nodes = self.nodes("hurt", "whole")
        for seed in SEEDS:
            text = cell.replace('"seed">1<', '"seed">%d<' % seed)
            before = len(nodes["whole"].lines)
            self.deploy(self.write("cell.xml", text))
            # The module begins to write random words after 0.2 s. Meanwhile, the test uses the node as operators and observers do.
            for _ in range(4):
                time.sleep(0.4)
                status = self.status_of()
                self.assertEqual({"hurt", "whole"}, {d["name"] for d in status["devices"]})
                self.takt("log", "--device", "hurt", "--json")
                self.takt("trace", "hurt", "--last", "1", "-o", "hurt.json", limit=20)
            for device, node in nodes.items():
                self.assertIsNone(node.status, "seed %d: the node of %s has ended:\n%s" % (seed, device, node.err))
            self.assertEqual({"EXECUTING"}, set(self.states_of("whole").values()), "seed %d" % seed)
            self.takt("undeploy", "scribbled", limit=90)
            wait_until(lambda: not any(d["modules"] for d in self.status_of()["devices"]), 60,
                       "both nodes to be free again after seed %d" % seed)
            new = nodes["whole"].lines[before:]
            self.assertEqual([], [line.text for line in new if re.match(r"\w+ -> RECOVER", line.text)], "seed %d" % seed)
        self.end(nodes)


if __name__ == "__main__":
    takt_system.main()
