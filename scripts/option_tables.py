#!/usr/bin/env python3
"""Writes the tables of options in docs/ from the program's own list (lumesh options --json), or checks that they agree.

A table stands between the lines `<!-- options SECTION -->` and `<!-- end of options -->`: with the flags of the command line,
or, in docs/stages/run.md, with the keys of case files.

Usage: option_tables.py [--check] [--program PATH]
"""
import argparse
import json
import pathlib
import re
import subprocess
import sys

from sources import ROOT

BLOCK = re.compile(r"(<!-- options (\w+) -->\n).*?(<!-- end of options -->)", re.DOTALL)


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


def table_of(options, is_case):
    head = "| Key | Values | Default | Meaning |" if is_case else "| Option | Values | Default | Meaning |"
    return "\n".join([head, "|---|---|---|---|", *map(row_of_key if is_case else row_of_flag, options)]) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="change nothing, and fail where a table differs")
    parser.add_argument("--program", default=str(ROOT / "build/release/bin/lumesh"))
    arguments = parser.parse_args()
    sections = json.loads(subprocess.run([arguments.program, "options", "--json"], check=True, capture_output=True,
                                         text=True).stdout)
    seen, stale = set(), []
    for page in sorted((ROOT / "docs").rglob("*.md")):
        is_case = page.name == "run.md"

        def table(match, is_case=is_case):
            seen.add((match[2], is_case))
            return match[1] + table_of(sections[match[2]], is_case) + match[3]

        text = page.read_text(encoding="utf-8")
        wanted = BLOCK.sub(table, text)
        if wanted != text:
            stale.append(page.relative_to(ROOT).as_posix())
            if not arguments.check:
                page.write_text(wanted, encoding="utf-8")
    missing = [name for name in sections if (name, True) not in seen and name not in ("improve", "repair")]  # no sections of a case
    for page in stale if arguments.check else []:
        print(f"{page}: its tables of options differ from the program's; run scripts/option_tables.py")
    for name in missing:
        print(f"docs/stages/run.md: has no table of options {name}")
    return 1 if missing or (stale and arguments.check) else 0


if __name__ == "__main__":
    sys.exit(main())
