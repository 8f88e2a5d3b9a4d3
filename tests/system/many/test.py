import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import takt_system
import traffic
from takt_system import LIFE, wait_until

MODULE = ("<module><name>%s</name><filename>%s</filename><moduletype>%s</moduletype><operationtype>periodic</operationtype>"
          "<period>%d</period><priority>%d</priority></module>\n")


class Many(takt_system.Case):
    @takt_system.alone("a thousand modules in each row take a CPU for most of its time")
    def test_a_table_with_a_thousand_modules_runs_each_of_them_in_every_row(self):
        threads = ["m%d" % i for i in range(1000)]
        copies = ["c%d" % i for i in range(50)]
        programs = ["p%d" % i for i in range(30)]
        modules = "".join(MODULE % (name, "cpp_properties.so", "thread", 1000000, i % 7) for i, name in enumerate(threads))
        modules += "".join(MODULE % (name, "fine.so", "thread", 10000000, 8) for name in copies)
        modules += "".join(MODULE % (name, "fine.exe", "process", 50000000, 9) for name in programs)
        file = self.write("many.xml", '<cell name="many"><device name="d">\n%s</device></cell>\n' % modules)

        run = self.takt("run", file, "--for", "2", "--json")
        self.assertEqual(0, run.status, run.err[-2000:])
        rows = run.executor()["cycles"]
        report = run.modules()
        for name in threads:
            self.assertEqual(LIFE, run.states(name))
            self.assertEqual(rows, report[name]["cycles"], name)
        for name in copies:
            self.assert_grid(run, name, every=10)
        for name in programs:
            self.assertEqual(LIFE, run.states(name))
            self.assert_grid(run, name, every=50)

    def test_a_node_sends_its_status_once_however_many_nodes_receive_it(self):
        with traffic.Traffic() as network:
            self.nodes("a", "b", "c", "d")
            wait_until(lambda: len(self.status_of()["devices"]) == 4, "all devices in the status")
            before = network.sent("takt/device")
            acknowledged = network.count("ACKNACK", "takt/device")
            announced = network.count("DATA", "the discovery of participants")

            def later():
                new = network.sent("takt/device") - before
                return new if len(new) >= 200 else None
            new = wait_until(later, "200 samples of takt/device")
            acknowledged = network.count("ACKNACK", "takt/device") - acknowledged
            announced = network.count("DATA", "the discovery of participants") - announced
        # Three other nodes receive each sample. A lost one is sent again, and each node acknowledges every 3 s.
        self.assertLess(sum(new.values()), 1.5 * len(new))
        self.assertLess(acknowledged, 0.2 * len(new))
        # A node publishes its status every 100 ms, and announces itself every second.
        self.assertLess(announced, 0.15 * len(new))


if __name__ == "__main__":
    takt_system.main()
