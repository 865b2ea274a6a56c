#!/usr/bin/env python3
"""Checks that docs/references.bib has every DOI that code, tests and pages cite, each once, and every work that they cite by author and
year, such as Loseille and Alauzet 2011: one of its authors, with that year; and that the headings are there to which comments point for a
derivation, as docs/stages/metric.md, "Velocity".

Usage: check_references.py [ROOT]
"""
import collections
import pathlib
import re
import sys
import unicodedata

import sources

# As far as it goes in a sentence; brackets within belong to it.
DOI = re.compile(r"10\.\d{4,9}/(?:\([^\s()]*\)|[^\s()\[\]\"'`,;|{}])+(?:;2-[0-9A-Z])?")
# One author or more, and the year: Blum 1967; Geman and McClure (1987); Stimpson et al. 2007; Tsolakis, Drakopoulos and Chrisochoides 2018.
NAME = r"[^\W\d_a-z][\w'’-]+"
CITATION = re.compile(rf"\b({NAME}(?:, {NAME})*(?:,? (?:and|&) {NAME}| et al\.)?),? \(?((?:19|20)\d\d)\b")
NO_AUTHORS = {"AVX2", "OpenFOAM", "Roundtable", "SGP"}  # Other words that years stand behind.
LETTERS = str.maketrans({"æ": "ae", "ø": "o", "ß": "ss", "ł": "l"})
# A page and its heading; a comment may go on in the next line between them, or within the heading.
DERIVATION = re.compile(r'(docs/[a-z_/]+\.md),\s"([^"]+)"')
NEXT_LINE = re.compile(r"\n[ \t]*//[/!]?(?=[ \t])")
FOLDERS = ("include", "internal", "src", "apps", "docs", "tests", "benchmarks", "examples", "scripts")


def dois_in(text):
    return [match.group().rstrip(".:") for match in DOI.finditer(text)]


def plain(name):
    """Without accents, which comments may leave out."""
    return "".join(letter for letter in unicodedata.normalize("NFKD", name.lower().translate(LETTERS)) if not unicodedata.combining(letter))


def authors_with_years(bib):
    """Last names of each entry's authors with its year."""
    for entry in re.split(r"^@", bib, flags=re.MULTILINE):
        authors, year = re.search(r"author = \{(.*)\}", entry), re.search(r"year = \{(\d+)\}", entry)
        if authors and year: yield from ((plain(author.split(",")[0].split()[-1]), year[1]) for author in authors[1].split(" and "))


def unknown_works(text, known):
    """Citations by author and year, of which no author has a work of that year in the bibliography."""
    for authors, year in CITATION.findall(NEXT_LINE.sub("", text)):
        names = [name for name in re.split(r",? (?:and|&) | et al\.|, ", authors) if name]
        if names[-1] not in NO_AUTHORS and not any((plain(name), year) in known for name in names): yield f"{authors} {year}"


def missing_headings(text, root):
    """Pages and headings to which comments point, and which are not there."""
    for page, heading in DERIVATION.findall(NEXT_LINE.sub("", text)):
        lines = (root / page).read_text().splitlines() if (root / page).is_file() else []
        if not any(line.lstrip("#").strip() == heading for line in lines if line.startswith("#")): yield page, heading


def main():
    root = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else sources.ROOT
    bib = root / "docs/references.bib"
    references = bib.read_text() if bib.is_file() else ""
    known, works = collections.Counter(re.findall(r"doi = \{(.*)\}", references)), set(authors_with_years(references))
    faults = [f"{bib.relative_to(root)}: {doi} stands there {count} times" for doi, count in known.items() if count > 1]
    files = [path for folder in FOLDERS for path in sorted((root / folder).rglob("*"))
             if path.suffix in (".hpp", ".cpp", ".md", ".py", ".h") and path.parent != root / "tests/scripts"]
    faults += sources.faults_of_nothing(files, root)
    for path in files:
        text = path.read_text()
        faults += [f"{path.relative_to(root)}: {page} has no heading \"{heading}\"" for page, heading in missing_headings(text, root)]
        faults += [f"{path.relative_to(root)}: {work} is missing in docs/references.bib" for work in unknown_works(text, works)]
        for number, line in enumerate(text.splitlines(), 1):
            faults += [f"{path.relative_to(root)}:{number}: {doi} is missing in docs/references.bib"
                       for doi in dois_in(line) if doi not in known]
    print("\n".join(faults + [f"check_references: {len(files)} files, {len(known)} references with a DOI, {len(works)} authors, {len(faults)} faults"]))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
