#!/usr/bin/env python3
"""Runs clang-tidy (.clang-tidy) on our own .cpp files; every finding is a fault.

Takes the commands of the release build (build/release/compile_commands.json). A file is looked at again only when
it, a project header that it includes, or .clang-tidy has changed.

Usage: check_tidy.py [FILE...]       only these files, whether changed or not
"""
import concurrent.futures
import json
import os
import pathlib
import subprocess
import sys

import sources
import stamps

# Files that are not looked at, with the reason.
EXCEPTIONS = {
    "src/io/itk_image.cpp": "ITK's headers take clang-tidy a minute",
    "src/geometry/predicates.cpp": "-frounding-math is not known to clang 14 on every target",
}


def findings_of(path, build):
    """What clang-tidy says of a file, or nothing."""
    result = subprocess.run(
        ["clang-tidy", "-p", str(build), "--quiet", "--extra-arg=-Wno-unknown-warning-option",
         "--extra-arg=-Wno-unused-command-line-argument", str(path)], capture_output=True, text=True, check=False)
    return result.stdout + result.stderr if result.returncode else ""


def main():
    build = sources.ROOT / os.environ.get("LUMESH_BUILD", "build/release")
    known = {pathlib.Path(entry["file"]).resolve() for entry in json.loads((build / "compile_commands.json").read_text())}
    files = [sources.ROOT / path for path in sources.source_files(sources.ROOT, ["src", "apps"])
             if path.suffix == ".cpp" and str(path) not in EXCEPTIONS and (sources.ROOT / path).resolve() in known]
    cache = stamps.Stamps("tidy", (sources.ROOT / ".clang-tidy").read_text())
    wanted = [pathlib.Path(name).resolve() for name in sys.argv[1:]]
    todo = wanted or [path for path in files if not cache.is_fresh(path)]
    faults = 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for path, findings in zip(todo, pool.map(lambda path: findings_of(path, build), todo)):
            if findings:
                faults += 1
                print(findings)
            else:
                cache.mark(path)
    print(f"check_tidy: {len(files)} files, {len(todo)} looked at, {faults} with findings")
    return 1 if faults or not files else 0


if __name__ == "__main__":
    sys.exit(main())
