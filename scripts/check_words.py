#!/usr/bin/env python3
"""Checks the words of doc comments, texts that stand twice, and that pages of stages are whole.

A doc line says what it documents ("Planes of the patch."), not whose it is ("Of its planes.") or where ("What it has of planes."). Doc
lines (`///`, `///<`) that begin without a noun, with "Of", "What", "Where", "As", "The same" and the like, are counted against a budget, which
only ever becomes smaller: what remains stands behind members whose name is the noun. A page of docs/stages has the headings "## Limits" and "## Sources" and a picture, which is there.

A text of 25 characters or more (of messages, helps, words of files) stands in one file of the program. Those that stand in two are counted
against a budget, too, which only ever becomes smaller: they are messages of readers of two formats, or of the two ways a thing is cut.

Usage: check_words.py [--list] [ROOT]      --list: the lines and texts that count
"""
import pathlib
import re
import sys

import sources

BUDGET = 414
TEXT_BUDGET = 27
TEXT_LENGTH = 25
PROGRAM = ("include", "internal", "src", "apps")
FOLDERS = ("include", "internal", "src", "apps", "tests", "benchmarks", "examples")
NO_NOUN = re.compile(r"///<?\s+(?:Of|Those|What|Where|Whose|As|The same|All|But|Also|Only|By how|None)\s")
PICTURE = re.compile(r"!\[[^\]]*\]\(([^)]*)\)")


def lines_without_noun(root, files):
    for path in files:
        is_within = False  # A comment's second and further lines may begin with any word.
        for number, line in enumerate((root / path).read_text().splitlines(), 1):
            if not is_within and NO_NOUN.search(line): yield f"{path}:{number}: {line.strip()}"
            is_within = line.lstrip().startswith("///") and not line.rstrip().endswith(".")


def texts_of(text):
    """String literals of a file, joined where only white space stands between them."""
    joined, last = "", 0
    for token in sources.TOKENS.finditer(text):
        if not token.group().startswith('"'): continue
        if text[last:token.start()].strip():
            yield joined
            joined = ""
        joined, last = joined + token.group()[1:-1], token.end()
    yield joined


def texts_that_stand_twice(root):
    files_of = {}
    for path in sources.source_files(root, PROGRAM):
        for text in texts_of((root / path).read_text()):
            if len(text) >= TEXT_LENGTH and not text.startswith("lumesh/"): files_of.setdefault(text, set()).add(str(path))
    return [f"{', '.join(sorted(files))}: \"{text}\"" for text, files in sorted(files_of.items()) if len(files) > 1]


def faults_of_page(page, root):
    text, name = page.read_text(), page.relative_to(root)
    for heading in ("## Limits", "## Sources"):
        if not re.search(f"^{heading}$", text, re.MULTILINE): yield f"{name}: no heading '{heading}'"
    pictures = PICTURE.findall(text)
    if not pictures: yield f"{name}: no picture; scripts/stage_pictures.py makes them"
    for picture in pictures:
        if not (page.parent / picture).is_file(): yield f"{name}: the picture {picture} is not there"


def main():
    arguments = sys.argv[1:]
    listed = "--list" in arguments
    if listed: arguments.remove("--list")
    root = pathlib.Path(arguments[0]) if arguments else sources.ROOT
    files, pages = sources.source_files(root, FOLDERS), sorted((root / "docs/stages").glob("*.md"))
    lines = list(lines_without_noun(root, files))
    faults = [fault for page in pages for fault in faults_of_page(page, root)] + sources.faults_of_nothing(files, root)
    if len(lines) > BUDGET:
        faults.append(f"{len(lines)} doc lines begin without a noun (Of, What, Where, As, …), {BUDGET} may; name what they document (--list shows them)")
    texts = texts_that_stand_twice(root)
    if len(texts) > TEXT_BUDGET:
        faults.append(f"{len(texts)} texts stand in two files, {TEXT_BUDGET} may; give them one place (--list shows them)")
    if listed or len(texts) > TEXT_BUDGET: print("\n".join(texts))
    if listed or len(lines) > BUDGET: print("\n".join(lines))
    print("\n".join(faults + [f"check_words: {len(files)} files, {len(pages)} pages, {len(lines)} of {BUDGET} doc lines without their noun, {len(texts)} of {TEXT_BUDGET} texts twice, {len(faults)} faults"]))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
