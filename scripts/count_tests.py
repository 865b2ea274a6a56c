#!/usr/bin/env python3
"""Counts the tests in a JUnit report of ctest: `passed failed skipped`, then a line per failed or skipped test.

Usage: count_tests.py REPORT.xml NAME
"""
import sys
import xml.etree.ElementTree as ElementTree


def reason_of_skip(case):
    """What the test itself said: the line after googletest's 'Skipped', or the line that starts with 'SKIP'."""
    lines = (case.findtext("system-out") or "").splitlines()
    for number, line in enumerate(lines):
        if line.startswith("SKIP"):
            return line.partition(":")[2].strip() or line
        if line.endswith(": Skipped") and number + 1 < len(lines):
            return lines[number + 1].strip()
    return "no reason given"


def main():
    report, name = sys.argv[1:]
    passed, lines = 0, []
    failed, skipped = 0, 0
    for case in ElementTree.parse(report).getroot().iter("testcase"):
        title = f"{case.get('name')} ({name})"
        if case.get("status") == "run":
            passed += 1
        elif case.find("skipped") is not None or case.get("status") == "disabled":
            skipped += 1
            lines.append(f"skipped {title}: {reason_of_skip(case)}")
        else:
            failed += 1
            lines.append(f"failed {title}")
    print(passed, failed, skipped)
    print("\n".join(lines), end="")


if __name__ == "__main__":
    main()
