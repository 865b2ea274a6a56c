#!/usr/bin/env python3
"""Checks that every pattern of tests in tests/CMakeLists.txt (LUMESH_NOT_SANITIZED, LUMESH_NOT_ASAN, LUMESH_NOT_TSAN) matches a test, and
that every program in LUMESH_THREAD_TESTS has a folder: a test that gets another name would otherwise leave or enter these sets in silence.
Names are those of TEST, TEST_F and TEST_P in the sources; those of TEST_P are taken as INSTANTIATION/SUITE.NAME/0.

Usage: check_test_patterns.py [ROOT]
"""
import fnmatch
import pathlib
import re
import sys

import sources

PATTERNS = ("LUMESH_NOT_SANITIZED", "LUMESH_NOT_ASAN", "LUMESH_NOT_TSAN")
TEST = re.compile(r"^(TEST|TEST_F|TEST_P)\(\s*(\w+),\s*(\w+)\s*\)", re.MULTILINE)
INSTANTIATION = re.compile(r"^INSTANTIATE_TEST_SUITE_P\(\s*(\w+),\s*(\w+)", re.MULTILINE)


def names_of_tests(text):
    for kind, suite, name in TEST.findall(text):
        if kind != "TEST_P": yield f"{suite}.{name}"
        else: yield from (f"{prefix}/{suite}.{name}/0" for prefix, of in INSTANTIATION.findall(text) if of == suite)


def words_of(text, variable):
    """The words that CMake's set() gives a variable, or nothing where there is none of the name."""
    match = re.search(rf"^set\({variable}\s+([^)]*)\)", text, re.MULTILINE)
    return match[1].split() if match else []


def main():
    root = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else sources.ROOT
    files = [path for path in sources.source_files(root, ["tests"]) if path.suffix == ".cpp"]
    names = [name for path in files for name in names_of_tests((root / path).read_text())]
    page = root / "tests/CMakeLists.txt"
    text = page.read_text() if page.is_file() else ""
    faults = sources.faults_of_nothing(files, root)
    for variable in PATTERNS:
        patterns = words_of(text, variable)
        if not patterns: faults.append(f"tests/CMakeLists.txt: {variable} has no pattern")
        faults += [f"tests/CMakeLists.txt: {variable}: no test has a name like {pattern}" for pattern in patterns
                   if not fnmatch.filter(names, pattern)]
    faults += [f"tests/CMakeLists.txt: LUMESH_THREAD_TESTS: {program} has no folder tests/unit/{program.removeprefix('test_')}"
               for program in words_of(text, "LUMESH_THREAD_TESTS") if not (root / "tests/unit" / program.removeprefix("test_")).is_dir()]
    print("\n".join(faults + [f"check_test_patterns: {len(files)} files, {len(names)} tests, {len(faults)} faults"]))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
