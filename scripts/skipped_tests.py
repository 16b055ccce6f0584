#!/usr/bin/python3
"""One line: how many tests of a run of CTest were skipped, and why. skipped_tests.py build/release/Testing/Temporary/LastTest.log"""
import collections
import re
import sys

# unittest, with -v; GoogleTest: "FILE:LINE: Skipped", the reason on the next line.
SKIPPED = re.compile(r"\.\.\. skipped (?:'(.*)'|\"(.*)\")$|^\S+:\d+: Skipped\n(.*)$", re.MULTILINE)


def told(log):
    reasons = collections.Counter(next(filter(None, found.groups()), "no reason given") for found in SKIPPED.finditer(log))
    if not reasons:
        return "no test was skipped"
    listed = "; ".join(f"{count} x {reason}" for reason, count in reasons.most_common())
    return f"skipped tests: {reasons.total()} ({listed})"


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: skipped_tests.py build/release/Testing/Temporary/LastTest.log")
    with open(sys.argv[1], encoding="utf-8", errors="replace") as file:
        print(told(file.read()))
