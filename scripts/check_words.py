#!/usr/bin/env python3
"""Checks the words of doc comments, texts that stand twice, and that pages of stages are whole.

A doc line says what it documents ("Planes of the patch."), not whose it is ("Of its planes.") or where ("What it has of planes."). Doc
lines (`///`, `///<`) that begin without a noun, with "Of", "What", "Where", "As", "The same" and the like, are counted against a budget, which
only ever becomes smaller: what remains stands behind members whose name is the noun. A page of docs/stages has the headings "## Limits" and "## Sources" and a picture, which is there.

A text of 25 characters or more (of messages, helps, words of files) stands in one file of the program. Those that stand in two are counted
against a budget, too, of none by now.

A default is a constant, from which its text is made: no number stands in the text of by_default() or zero(), in digits or in words, nor
behind the word "default" in another text. An option is described in one place; names that options of several stages share stand in
`OF_SEVERAL` with how many they are and why.

Usage: check_words.py [--list] [ROOT]      --list: the lines and texts that count
"""
import pathlib
import re
import sys

import sources

BUDGET = 414
TEXT_BUDGET = 0
TEXT_LENGTH = 25
PROGRAM = ("include", "internal", "src", "apps")
FOLDERS = ("include", "internal", "src", "apps", "tests", "benchmarks", "examples")
NO_NOUN = re.compile(r"///<?\s+(?:Of|Those|What|Where|Whose|As|The same|All|But|Also|Only|By how|None)\s")
# Names that several options have: how many are described, and why.
OF_SEVERAL = {
    "boundary": (3, "what the voxels bind, what adaptation moves and what improvement moves"),
    "centerline": (2, "axes that evaluate reads, and those that phantom writes"),
    "complexity": (2, "that of a metric that is made, and that to which a mesh is adapted"),
    "edge_length": (3, "each mesher's, and that of a case for both"),
    "feature_angle": (2, "edges of surfaces that are read, and creases that adaptation keeps"),
    "gradation": (2, "that of a metric that is made, and that of one that is there"),
    "image": (2, "what a case meshes, and what a mesh was made of"),
    "json": (2, "a file of a case, and the option of all commands, which may go without one"),
    "max_dihedral": (2, "the ceiling of the lattice, and the target of improvement"),
    "metric": (2, "a source of sizes, and sizes that improvement keeps to"),
    "min_dihedral": (2, "the floor of the lattice, and the target of improvement"),
    "output": (7, "each command says what it writes"),
    "report": (3, "the report of a mesh, and pages that show what check and layers did"),
    "surface": (3, "what a case meshes, a file of a case, and what commands write besides"),
    "velocity": (2, "samples for a metric, and a file that phantom writes"),
}
DESCRIBED = re.compile(r"""(?:\.|->)\s*(?:(?:number|flag|texts?|integers|of_labels|path|parsed|labelled_files|rows|choice)\(\s*"(?P<name>\w+)"
    | add_(?:option|flag)\w*(?:<[^"()]*(?:\([^()]*\))?[^"()]*>)?\(\s*"(?P<flags>[^"]*)")""", re.VERBOSE)
OF_DEFAULT = re.compile(r"\.(?:by_default|zero)\(")
SAID_DEFAULT = re.compile(r"\bdefaults?:?(?: is| are)? \d")
NUMBER = re.compile(r"\d|\b(?:half|thirds?|quarters?|eighth|tenth|one|two|three|four|five|six|eight|ten|dozen|hundred|thousand|millions?)\b")
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


def arguments_at(text, begin):
    """What stands in the parentheses of a call, from behind the first of them."""
    depth, at = 1, begin
    while depth > 0 and at < len(text):
        token = sources.TOKENS.match(text, at)
        if token:
            at = token.end()
            continue
        depth += {"(": 1, ")": -1}.get(text[at], 0)
        at += 1
    return text[begin:at]


def faults_of_defaults(path, text):
    """Numbers of defaults in texts, whose constant they would repeat. What fmt::format() fills in is left out."""
    for call in OF_DEFAULT.finditer(text):
        for said in texts_of(arguments_at(text, call.end())):
            if NUMBER.search(re.sub(r"\{[^}]*\}", "", said)): yield f"{path}: \"{said}\" has the number of a default; make it of the constant"
    for said in texts_of(text):
        if SAID_DEFAULT.search(said): yield f"{path}: \"{said}\" has the number of a default; make it of the constant"


def described_options(text):
    """Names of the options that a file describes, with those of single commands, --split-above as split_above. Help that another one's
    description gives (meaning_of()) is none."""
    for one in DESCRIBED.finditer(text):
        if "meaning_of(" in arguments_at(text, one.end()): continue
        flags = [one["name"]] if one["name"] else [flag[2:].replace("-", "_") for flag in one["flags"].split(",") if flag.startswith("--")]
        yield from flags


def faults_of_options(root, files):
    places, faults = {}, []
    for path in files:
        text = (root / path).read_text()
        faults += faults_of_defaults(path, text)
        for name in described_options(text): places.setdefault(name, []).append(str(path))
    for name, where in sorted(places.items()):
        count, why = OF_SEVERAL.get(name, (1, ""))
        if len(where) != count:
            faults.append(f"option {name} is described {len(where)} times ({', '.join(where)}), {count} may{'; they are ' * bool(why)}{why}")
    return faults


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
    faults += faults_of_options(root, sources.source_files(root, PROGRAM))
    texts = texts_that_stand_twice(root)
    if len(texts) > TEXT_BUDGET:
        faults.append(f"{len(texts)} texts stand in two files, {TEXT_BUDGET} may; give them one place (--list shows them)")
    if listed or len(texts) > TEXT_BUDGET: print("\n".join(texts))
    if listed or len(lines) > BUDGET: print("\n".join(lines))
    print("\n".join(faults + [f"check_words: {len(files)} files, {len(pages)} pages, {len(lines)} of {BUDGET} doc lines without their noun, {len(texts)} of {TEXT_BUDGET} texts twice, {len(faults)} faults"]))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
