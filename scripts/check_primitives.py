#!/usr/bin/env python3
"""Checks that threads and locks stay where they are looked after, and that no variable is left without an owner.

Threads, mutexes, atomics, oneTBB and OpenMP belong to the module parallel; all other code uses lumesh/parallel/loops.hpp. There are no
static variables but constants: each is a global by another name.

Usage: check_primitives.py [ROOT]
"""
import pathlib
import re
import sys

import sources

PRIMITIVE = re.compile(
    r"\btbb::|#\s*include\s+<(?:tbb/|oneapi/|thread>|mutex>|shared_mutex>|atomic>|condition_variable>|semaphore>|barrier>"
    r"|latch>|future>|omp\.h>|pthread\.h>)|#\s*pragma\s+omp|\bomp_\w+\s*\("
    r"|\bstd::(?:j?thread|(?:recursive_|timed_|shared_)?mutex|atomic\w*|condition_variable\w*|async|future|barrier|latch"
    r"|counting_semaphore|execution::par\w*)\b")

STATIC = re.compile(r"^\s+(?:static|thread_local)\s(?!.*\bconst(?:expr)?\b)[^(]*[;={]")


def is_allowed(path):
    return "parallel" in path.parts


def main():
    root = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else sources.ROOT
    files = sources.source_files(root, ["include", "internal", "src", "apps"])
    faults = sources.faults_of_nothing(files, root)
    for path in files:
        for number, line in enumerate(sources.without_comments((root / path).read_text()).splitlines(), 1):
            match = PRIMITIVE.search(line)
            if match and not is_allowed(path):
                faults.append(f"{path}:{number}: {match.group().strip()} belongs to the module parallel")
            if STATIC.match(line):
                faults.append(f"{path}:{number}: {line.strip()} is a variable without an owner")
    print("\n".join(faults + [f"check_primitives: {len(files)} files, {len(faults)} faults"]))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
