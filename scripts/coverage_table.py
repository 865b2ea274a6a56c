#!/usr/bin/env python3
"""Line coverage of each module as a table, of what gcovr says of each file.

Usage: coverage_table.py LINES.json LEAST [MODULE...]      LEAST: percent; exit status 1 if a module has less
"""
import collections
import json
import pathlib
import re
import sys


def main():
    path, least, *wanted = sys.argv[1:]
    known, run = collections.Counter(), collections.Counter()
    for file in json.loads(pathlib.Path(path).read_text())["files"]:
        module = re.fullmatch(r"(?:src|(?:include|internal)/lumesh)/(\w+)/.*", file["file"])
        if not module or (wanted and module[1] not in wanted): continue
        lines = [line for line in file["lines"] if not line.get("gcovr/noncode")]
        known[module[1]] += len(lines)
        run[module[1]] += sum(line["count"] > 0 for line in lines)
    if not known: sys.exit(f"{path}: no file of a module")
    print("| module | lines | run by tests |\n| --- | --- | --- |")
    for module in sorted(known): print(f"| `{module}` | {known[module]:,} | {100 * run[module] / known[module]:.1f} % |")
    print(f"| all | {known.total():,} | {100 * run.total() / known.total():.1f} % |")
    short = [module for module in known if 100 * run[module] < float(least) * known[module]]
    if short: print(f"less than {least} %: {', '.join(sorted(short))}")
    return 1 if short else 0


if __name__ == "__main__":
    sys.exit(main())
