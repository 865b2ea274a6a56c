#!/usr/bin/env python3
"""Writes the tables of options in docs/, and that of formats in README.md, from the program's own list (lumesh options --json), or
checks that they agree.

A table stands between the lines `<!-- options SECTION -->`, or `<!-- options SECTION from NAME to NAME -->` for a part of it, and
`<!-- end of options -->`: with the flags of the command line, or, in docs/stages/run.md, with the keys of case files.

The table of formats stands between `<!-- formats -->` and `<!-- end of formats -->`.

--check also looks whether the tables of formats in docs/stages have all of the program's, and whether each list of file names' endings in
a row of options is that of a use of files (`FORMAT_TABLES`, `faults_of_lists()`); and whether each flag of `lumesh COMMAND --help` stands on docs/stages/COMMAND.md or on docs/options.md, to which the
page links then; whether no meaning stands under two names, but those of `SHARED_MEANINGS`; whether each flag at the beginning of a row of that page's options is one of the command; and whether a file that may be
left out (`--json [FILE]`) is written so.

Usage: option_tables.py [--check] [--program PATH]
"""
import argparse
import json
import pathlib
import re
import subprocess
import sys

from sources import ROOT

BLOCK = re.compile(r"(<!-- options (\w+)(?: from (\w+) to (\w+))? -->\n).*?(<!-- end of options -->)", re.DOTALL)
COMMON = "docs/options.md"  # Options of many commands, once for all of them.
FLAG = re.compile(r"(?<![\w-])--?[a-z][\w-]*")
FORMATS = re.compile(r"(<!-- formats -->\n).*?(<!-- end of formats -->)", re.DOTALL)
ENDINGS = re.compile(r"`\.[a-z0-9.]+`(?:, `\.[a-z0-9.]+`)+")
# Tables of formats: page, how the head begins, uses whose formats stand in the first cells.
FORMAT_TABLES = (
    ("docs/stages/convert.md", "| File | Read | Written | Labels |", ("read", "write")),
    ("docs/stages/convert.md", "| File | Read | Written |\n", ("carry metric", "metric alone")),
    ("docs/stages/info.md", "| File | Read by |", ("read image",)),
)
# Names that share a meaning, and why.
SHARED_MEANINGS = {
    ("phantom_size", "size"): "a case has the phantom's with others in one section",
    ("phantom_spacing", "spacing"): "the same",
    ("noise", "phantom_noise"): "the same",
}
NOT_OPTIONS = "formats"  # The key of the program's list that is no section.
OF_HELP = re.compile(r"^  (-[\w,-]+)(.*)$", re.MULTILINE)


def cell(text):
    return text.replace("|", r"\|")


def values_of(option):
    """Unit, range and words."""
    words = "|".join(f"`{word}`" for word in option.get("words", []))
    return ", ".join(text for text in (option.get("unit", ""), option.get("range", ""), words) if text) or "–"


def row_of_flag(option):
    flags = ", ".join(f"`{flag}`" for flag in option["flags"].split(","))
    return f"| {flags} | {cell(values_of(option))} | {cell(option['default'])} | {cell(option['meaning'])} |"


def row_of_key(option):
    names = f"`{option['name']}`" + "".join(f", `{alias}`" for alias in option["aliases"] if len(alias) > 1)
    zero = f"; 0: {option['zero']}" if "zero" in option and option["zero"] != option["default"] else ""
    return f"| {names} | {cell(values_of(option))} | {cell(option['default'])} | {cell(option['meaning'] + zero)} |"


def without(names, others):
    return [name for name in names if name not in others]


def format_table(formats):
    """Rows of README.md: what is read and what is written."""
    surfaces = without(formats["read"], formats["read volume"])
    rows = [("images", formats["read image"], formats["write image"]), ("meshes", formats["read volume"], formats["write volume"]),
            ("surfaces", surfaces, formats["write surface"]), ("metrics", formats["metric alone"], formats["metric alone"]),
            ("metrics and sizes in meshes", formats["carry metric"], formats["carry metric"]),
            ("points", [*without(formats["points"], formats["read"]), "meshes", "surfaces"], []),
            ("velocities at points", formats["point data"], []), ("lines", formats["lines"], formats["lines"])]
    return "| | read | write |\n| --- | --- | --- |\n" + "".join(f"| {kind} | {', '.join(read)} | {', '.join(write) or '–'} |\n"
                                                               for kind, read, write in rows)


def ending_of(name):
    """`.foam` for ".foam for OpenFOAM", `NAME-mesh-complete` for the folder."""
    ending = re.search(r"\.\S+|NAME-\S+", name)
    return ending[0] if ending else name


def faults_of_format_table(name, text, head, wanted):
    """First cells that are not the formats of a use."""
    rows = re.search(re.escape(head) + r"(?:.*\n)?\|[-|]+\n((?:\|.*\n)*)", text)
    cells = re.findall(r"^\|(.*?)\|", rows[1] if rows else "", re.MULTILINE)
    found = {word for cell in cells for word in re.findall(r"`([^`]*)`", cell)}
    wanted = {ending_of(format_name) for format_name in wanted}
    packed = {f"{ending}.gz" for ending in wanted}  # Go without saying.
    wanted = {ending for ending in wanted - packed if "." in ending or "-" in ending}
    for ending in sorted(wanted - found): yield f"{name}: its table of formats has no row of {ending}"
    for ending in sorted(found - wanted - packed): yield f"{name}: its table of formats has a row of {ending}, which is none"


def faults_of_lists(name, text, formats):
    """Lists of endings in rows of options that are not those of a use of files."""
    lists = [*formats.values(), without(formats["read"], formats["read volume"])]
    known = {tuple(ending for ending in map(ending_of, names) if ending.startswith(".")) for names in lists}
    known |= {tuple(ending for ending in endings if ending.removesuffix(".gz") == ending) for endings in known}
    for row in re.findall(r"^\| `(?:-|FROM|MESH).*", text, re.MULTILINE):
        for found in ENDINGS.findall(row):
            if tuple(re.findall(r"`([^`]*)`", found)) not in known: yield f"{name}: {found} are the formats of no use of files"


def faults_of_meanings(sections):
    """Meanings that stand under two names, and names that need no exception any more."""
    names = {}
    for option in (option for options in sections.values() for option in options): names.setdefault(option["meaning"], set()).add(option["name"])
    shared = {tuple(sorted(found)): meaning for meaning, found in names.items() if len(found) > 1}
    for found in sorted(shared.keys() - SHARED_MEANINGS.keys()): yield f"\"{shared[found]}\" is the meaning of {' and '.join(found)}; make them one option"
    for found in sorted(SHARED_MEANINGS.keys() - shared.keys()): yield f"{' and '.join(found)} share no meaning any more; take them from SHARED_MEANINGS"


def faults_of_formats(formats):
    for name, head, uses in FORMAT_TABLES:
        text = (ROOT / name).read_text(encoding="utf-8")
        yield from faults_of_format_table(name, text, head, [one for use in uses for one in formats[use]])
    for page in sorted((ROOT / "docs/stages").glob("*.md")):
        yield from faults_of_lists(f"docs/stages/{page.name}", page.read_text(encoding="utf-8"), formats)


def table_of(options, is_case):
    head = "| Key | Values | Default | Meaning |" if is_case else "| Option | Values | Default | Meaning |"
    return "\n".join([head, "|---|---|---|---|", *map(row_of_key if is_case else row_of_flag, options)]) + "\n"


def part_of(options, first, last):
    """Those from the one named `first` to that named `last`, or all."""
    if not first: return options
    names = [option["name"] for option in options]
    return options[names.index(first):names.index(last) + 1]


def options_of_page(text):
    """The flags at the beginning of rows between the heading "Options" and the next one."""
    section = re.search(r"^## Options\n(.*?)(?=^## |\Z)", text, re.MULTILINE | re.DOTALL)
    for row in re.findall(r"^\| (`-.*?) \|", section[1] if section else "", re.MULTILINE):
        for code in re.findall(r"`([^`]*)`", row): yield from FLAG.findall(code)[:1]


def faults_of_page(command, help_text, text, common):
    """What the page of a command, and that of common options, lack of its help, and what they say besides."""
    name = f"docs/stages/{command}.md"
    known = {flag: rest for flags, rest in OF_HELP.findall(help_text) for flag in flags.split(",")}
    here, there = set(FLAG.findall(text)), set(FLAG.findall(common))
    for flag in known:
        if flag not in here | there: yield f"{name}: {flag} stands neither here nor in {COMMON}"
    if not known.keys() <= here and "(../options.md" not in text: yield f"{name}: has no link to {COMMON}, where the other options are"
    for flag in dict.fromkeys(options_of_page(text)):
        if flag not in known: yield f"{name}: lumesh {command} has no option {flag}"
    for flag, rest in known.items():
        if rest.startswith(" [FILE]") and f"{flag} FILE`" in text: yield f"{name}: {flag} [FILE] it is, a file may be left out"


def faults_of_pages(program):
    common = (ROOT / COMMON).read_text(encoding="utf-8")
    commands = re.search(r"^Subcommands:\n((?:  .*\n)*)", helps(program), re.MULTILINE)[1].split("\n")
    for command in (line.split()[0] for line in commands if line):
        page = ROOT / f"docs/stages/{command}.md"
        if page.is_file(): yield from faults_of_page(command, helps(program, command), page.read_text(encoding="utf-8"), common)


def helps(program, *command):
    return subprocess.run([program, *command, "--help"], check=True, capture_output=True, text=True).stdout


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="change nothing, and fail where a table differs")
    parser.add_argument("--program", default=str(ROOT / "build/release/bin/lumesh"))
    arguments = parser.parse_args()
    sections = json.loads(subprocess.run([arguments.program, "options", "--json"], check=True, capture_output=True,
                                         text=True).stdout)
    formats = sections.pop(NOT_OPTIONS)
    seen, stale = set(), []
    for page in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]:
        is_case = page.name == "run.md"

        def table(match, is_case=is_case):
            seen.add((match[2], is_case))
            return match[1] + table_of(part_of(sections[match[2]], match[3], match[4]), is_case) + match[5]

        text = page.read_text(encoding="utf-8")
        wanted = FORMATS.sub(lambda match: match[1] + format_table(formats) + match[2], BLOCK.sub(table, text))
        if wanted != text:
            stale.append(page.relative_to(ROOT).as_posix())
            if not arguments.check:
                page.write_text(wanted, encoding="utf-8")
    missing = [name for name in sections if (name, True) not in seen and name not in ("improve", "repair", "phantom", "convert", "merge")]  # no sections of a case
    for page in stale if arguments.check else []:
        print(f"{page}: its tables differ from the program's; run scripts/option_tables.py")
    for name in missing:
        print(f"docs/stages/run.md: has no table of options {name}")
    faults = [*faults_of_pages(arguments.program), *faults_of_formats(formats), *faults_of_meanings(sections)] if arguments.check else []
    print("".join(f"{fault}\n" for fault in faults), end="")
    return 1 if missing or faults or (stale and arguments.check) else 0


if __name__ == "__main__":
    sys.exit(main())
