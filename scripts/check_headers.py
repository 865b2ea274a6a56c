#!/usr/bin/env python3
"""Checks that every shared header says in its first lines what it is and has an include guard, and that every header of
the API compiles alone and where only the API is installed.

Takes the compiler flags of the C++ files of the release build (build/release/compile_commands.json). A header that ends
in .h is for C as well, and is compiled as that, too. A header is compiled again only when it, or a header that it
includes, has changed.

Usage: check_headers.py [BUILD_FOLDER]
"""
import concurrent.futures
import json
import os
import pathlib
import shlex
import subprocess
import sys

import sources
import stamps


def compiler_flags(build):
    """Flags that make the public headers and the libraries in them visible."""
    flags = []
    for entry in json.loads((build / "compile_commands.json").read_text()):
        if not entry["file"].endswith(".cpp"):
            continue
        words = shlex.split(entry["command"])
        for index, word in enumerate(words):
            pair = [word, words[index + 1]] if word in ("-I", "-isystem") else [word]
            if word.startswith(("-I", "-isystem", "-std=", "-f")) and pair[0] not in flags[:0]:
                if " ".join(pair) not in flags:
                    flags.append(" ".join(pair))
    words = [word for flag in flags for word in flag.split(" ")]
    return [word for word in words if not word.startswith("-fdiagnostics") and word != f"-I{sources.ROOT / 'internal'}"]


def fault_of(path, flags):
    # A guard macro such as __INCLUDE_LEVEL__ complains about '#pragma once in main file': compile a file that includes it.
    languages = [["g++", *flags, "-x", "c++"]] + ([["gcc", "-std=c99", "-x", "c"]] if path.suffix == ".h" else [])
    for compiler in languages:
        result = subprocess.run([*compiler, "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only", "-"],
                                input=f'#include "{path}"\n', capture_output=True, text=True, check=False)
        if result.returncode:
            return f"{path} does not compile alone:\n{result.stderr[:2000]}"
    return None


def main():
    build = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else sources.ROOT / "build/release")
    flags = compiler_flags(build)
    headers = [sources.ROOT / path for path in sources.source_files(sources.ROOT, ["include"])]
    internal = [sources.ROOT / path for path in sources.source_files(sources.ROOT, ["internal"])]
    cache = stamps.Stamps("headers", " ".join(flags))
    todo = [header for header in headers if not cache.is_fresh(header)]
    faults = [f"{path}: start with '#pragma once' and '/// @file' and what it is for" for path in headers + internal
              if not path.read_text().startswith("#pragma once\n/// @file ")]
    faults += sources.faults_of_nothing(headers, sources.ROOT / "include")
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for header, fault in zip(todo, pool.map(lambda path: fault_of(path, flags), todo)):
            if fault:
                faults.append(fault)
            else:
                cache.mark(header)
    print("\n".join(faults + [f"check_headers: {len(headers)} headers, {len(todo)} compiled, {len(faults)} faults"]))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
