#!/usr/bin/env python3
"""Runs clang-tidy (.clang-tidy) on our own .cpp files; every finding is a fault.

Takes the commands of the asan preset (configured, not built), which joins the files of a module: clang-tidy spends
most of its time on library headers, and so reads them once per module. What was joined is looked at again only when
one of its files, a project header that they include, or .clang-tidy has changed.

Usage: check_tidy.py [FILE...]       only these files, with the commands of the release build
"""
import concurrent.futures
import json
import os
import pathlib
import re
import subprocess
import sys

import stamps
from sources import ROOT, faults_of_nothing

# Files that are not looked at, with the reason.
EXCEPTIONS = {
    "src/io/itk_image.cpp": "ITK's headers take clang-tidy a minute",
    "src/geometry/predicates.cpp": "-frounding-math is not known to clang 14 on every target",
}

JOINED_TESTS = re.compile(r"/(tests|examples|benchmarks)/")


def commands(build):
    """The files that the build compiles."""
    database = ROOT / build / "compile_commands.json"
    if not database.exists():
        sys.exit(f"check_tidy: {database} is missing; configure it: cmake --preset {pathlib.Path(build).name}")
    return [pathlib.Path(entry["file"]).resolve() for entry in json.loads(database.read_text())]


def is_ours(path):
    """Whether a file of src or apps, or a join of such files."""
    relative = path.relative_to(ROOT).as_posix()
    if relative in EXCEPTIONS:
        return False
    return relative.startswith(("src/", "apps/")) or ("/Unity/" in relative and not JOINED_TESTS.search(relative))


def findings_of(path, build):
    """What clang-tidy says of a file, or nothing."""
    result = subprocess.run(
        ["clang-tidy", "-p", str(ROOT / build), "--quiet", "--extra-arg=-Wno-unknown-warning-option",
         "--extra-arg=-Wno-unused-command-line-argument", str(path)], capture_output=True, text=True, check=False)
    return result.stdout + result.stderr if result.returncode else ""


def main():
    wanted = [pathlib.Path(name).resolve() for name in sys.argv[1:]]
    build = "build/release" if wanted else "build/asan"
    files = [path for path in commands(build) if is_ours(path)]
    cache = stamps.Stamps("tidy", (ROOT / ".clang-tidy").read_text())
    todo = wanted or [path for path in files if not cache.is_fresh(path)]
    todo.sort(key=lambda path: -path.read_text().count("#include"))  # the long ones first
    nothing = faults_of_nothing(files, build)
    print("".join(f"{fault}\n" for fault in nothing), end="")
    faults = len(nothing)
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for path, findings in zip(todo, pool.map(lambda path: findings_of(path, build), todo)):
            if findings:
                faults += 1
                print(findings)
            else:
                cache.mark(path)
    print(f"check_tidy: {len(files)} parts, {len(todo)} looked at, {faults} with findings")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
