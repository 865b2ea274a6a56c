#!/usr/bin/env python3
"""Checks that docs/references.bib has every DOI that code, tests and pages cite, each once, and that the headings are there to which
comments point for a derivation, as docs/stages/metric.md, "Velocity".

Usage: check_references.py [ROOT]
"""
import collections
import pathlib
import re
import sys

import sources

# As far as it goes in a sentence; brackets within belong to it.
DOI = re.compile(r"10\.\d{4,9}/(?:\([^\s()]*\)|[^\s()\[\]\"'`,;|{}])+(?:;2-[0-9A-Z])?")
# A page and its heading; a comment may go on in the next line between them, or within the heading.
DERIVATION = re.compile(r'(docs/[a-z_/]+\.md),\s"([^"]+)"')
NEXT_LINE = re.compile(r"\n[ \t]*//[/!]?(?=[ \t])")
FOLDERS = ("include", "internal", "src", "apps", "docs", "tests", "benchmarks", "examples", "scripts")


def dois_in(text):
    return [match.group().rstrip(".:") for match in DOI.finditer(text)]


def missing_headings(text, root):
    """Pages and headings to which comments point, and which are not there."""
    for page, heading in DERIVATION.findall(NEXT_LINE.sub("", text)):
        lines = (root / page).read_text().splitlines() if (root / page).is_file() else []
        if not any(line.lstrip("#").strip() == heading for line in lines if line.startswith("#")): yield page, heading


def main():
    root = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else sources.ROOT
    bib = root / "docs/references.bib"
    known = collections.Counter(re.findall(r"doi = \{(.*)\}", bib.read_text() if bib.is_file() else ""))
    faults = [f"{bib.relative_to(root)}: {doi} stands there {count} times" for doi, count in known.items() if count > 1]
    files = [path for folder in FOLDERS for path in sorted((root / folder).rglob("*"))
             if path.suffix in (".hpp", ".cpp", ".md", ".py", ".h") and path.parent != root / "tests/scripts"]
    faults += sources.faults_of_nothing(files, root)
    for path in files:
        text = path.read_text()
        faults += [f"{path.relative_to(root)}: {page} has no heading \"{heading}\"" for page, heading in missing_headings(text, root)]
        for number, line in enumerate(text.splitlines(), 1):
            faults += [f"{path.relative_to(root)}:{number}: {doi} is missing in docs/references.bib"
                       for doi in dois_in(line) if doi not in known]
    print("\n".join(faults + [f"check_references: {len(files)} files, {len(known)} references with a DOI, {len(faults)} faults"]))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
