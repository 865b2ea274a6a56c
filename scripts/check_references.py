#!/usr/bin/env python3
"""Checks that docs/references.bib has every DOI that code, tests and pages cite, each once.

Usage: check_references.py [ROOT]
"""
import collections
import pathlib
import re
import sys

import sources

# As far as it goes in a sentence; brackets within belong to it.
DOI = re.compile(r"10\.\d{4,9}/(?:\([^\s()]*\)|[^\s()\[\]\"'`,;|{}])+(?:;2-[0-9A-Z])?")
FOLDERS = ("include", "internal", "src", "apps", "docs", "tests", "benchmarks", "examples", "scripts")


def dois_in(text):
    return [match.group().rstrip(".:") for match in DOI.finditer(text)]


def main():
    root = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else sources.ROOT
    bib = root / "docs/references.bib"
    known = collections.Counter(re.findall(r"doi = \{(.*)\}", bib.read_text()))
    faults = [f"{bib.relative_to(root)}: {doi} stands there {count} times" for doi, count in known.items() if count > 1]
    files = [path for folder in FOLDERS for path in sorted((root / folder).rglob("*"))
             if path.suffix in (".hpp", ".cpp", ".md", ".py", ".h") and path.parent != root / "tests/scripts"]
    for path in files:
        for number, line in enumerate(path.read_text().splitlines(), 1):
            faults += [f"{path.relative_to(root)}:{number}: {doi} is missing in docs/references.bib"
                       for doi in dois_in(line) if doi not in known]
    print("\n".join(faults + [f"check_references: {len(files)} files, {len(known)} references with a DOI, {len(faults)} faults"]))
    return 1 if faults or not files else 0


if __name__ == "__main__":
    sys.exit(main())
