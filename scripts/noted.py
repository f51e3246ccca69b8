"""What passing tests noted, and which took longest, from a JUnit report of cargo-nextest.

    noted.py REPORT [COUNT]

A line for each "SKIPPED: .." and "NOTE: .." that a test wrote, then the COUNT (12) slowest tests with their seconds.
"""

import re
import sys
import xml.etree.ElementTree as tree

report, count = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 12
cases = list(tree.parse(report).getroot().iter("testcase"))
for case in cases:
    for stream in ("system-out", "system-err"):
        for line in re.findall(r"(?:SKIPPED|NOTE): .*", case.findtext(stream) or ""):
            print(line)
print("the slowest tests:")
for case in sorted(cases, key=lambda case: -float(case.get("time")))[:count]:
    print(f"  {float(case.get('time')):6.1f} s  {case.get('classname')} {case.get('name')}")
