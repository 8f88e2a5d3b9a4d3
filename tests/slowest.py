"""Prints the ten slowest tests of a CTest run. Usage: slowest.py RESULTS.xml. ctest --output-junit writes this file."""

import sys
import xml.etree.ElementTree as xml

cases = [(float(case.get("time")), case.get("name")) for case in xml.parse(sys.argv[1]).getroot().iter("testcase")]
print("\nThe slowest of %d tests:" % len(cases))
for seconds, name in sorted(cases, reverse=True)[:10]:
    print("%8.1f s  %s" % (seconds, name))
print()
