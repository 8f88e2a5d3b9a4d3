"""Prints the ten tests of a CTest run that took longest: slowest.py RESULTS.xml, as ctest --output-junit writes it."""

import sys
import xml.etree.ElementTree as xml

cases = [(float(case.get("time")), case.get("name")) for case in xml.parse(sys.argv[1]).getroot().iter("testcase")]
print("\nThe slowest of %d tests:" % len(cases))
for seconds, name in sorted(cases, reverse=True)[:10]:
    print("%8.1f s  %s" % (seconds, name))
print()
