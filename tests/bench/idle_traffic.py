#!/usr/bin/env python3
"""Measures the network traffic of nodes that wait for a deployment.

    tests/bench/idle_traffic.py [--seconds 5] [--build build/release] [NODES ...]

For each number of nodes (2, 8 and 16 unless given), the script starts the nodes in a network of their own, waits until they have found each
other, and counts the packets that they send: in total, and by kind of RTPS submessage and by topic. The number of packets does not depend
on the speed of the machine, unless the machine is overloaded. This needs root. The script prints the results and never fails."""
import argparse
import os
import subprocess
import sys
import tempfile
import time

here = os.path.dirname(os.path.abspath(__file__))
sys.path.append(os.path.join(here, "..", "system"))
from traffic import Traffic  # in tests/system


def measure(number, seconds, build):
    with tempfile.TemporaryDirectory() as folder, Traffic() as traffic:
        environment = dict(os.environ, TAKT_INTERFACE="127.0.0.1", TAKT_STATE_DIR=folder)
        nodes = [subprocess.Popen([os.path.join(build, "bin", "takt-node"), "--device", "d%d" % i], env=environment,
                                  stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) for i in range(number)]
        try:
            time.sleep(8)  # discovery
            packets, octets, submessages = traffic.over(seconds)
        finally:
            for node in nodes:
                node.terminate()
            for node in nodes:
                node.wait()
    print("%d nodes: one node sends %.0f packets/s, %.0f kbit/s; all nodes send %.0f packets/s" %
          (number, packets / number, octets * 8e-3 / number, packets))
    for (kind, topic), n in sorted(submessages.items(), key=lambda item: -item[1])[:8]:
        print("  %7.1f/s per node: %s of %s" % (n / number, kind, topic), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("nodes", nargs="*", type=int, default=[2, 8, 16], metavar="NODES")
    parser.add_argument("--seconds", type=float, default=5, help="duration of each measurement")
    parser.add_argument("--build", default=os.path.join(here, "..", "..", "build", "release"))
    options = parser.parse_args()
    import machine  # moves this process into a network of its own
    if machine.MISSING:
        sys.exit("idle_traffic.py: " + machine.MISSING)
    for number in options.nodes:
        measure(number, options.seconds, os.path.abspath(options.build))


if __name__ == "__main__":
    main()
