#!/usr/bin/env python3
"""Checks that builds of lumesh make the same meshes to the last bit: the first on one and on several threads, others, by other compilers,
with and without optimisation, on several; such as those of the presets release, debug, clang and clang-debug (`scripts/test --compilers`).
A command that fails, or does not write its file, is a fault.

Usage: check_same_bits.py PROGRAM...
"""
import hashlib
import pathlib
import subprocess
import sys
import tempfile

# Each reads what those before it have made; the last word is the file that is compared.
COMMANDS = [
    "phantom bifurcation --size 88 64 80 --spacing 0.3 -o b.nrrd",
    "lattice b.nrrd -o lattice.vtu",
    "delaunay b.nrrd --edge-length 1.2 -o delaunay.vtu",
    "convert delaunay.vtu delaunay.stl",
    "delaunay delaunay.stl --edge-length 1.5 -o surface.vtu",
    "metric delaunay.vtu --curvature --max-size 3 --min-size 0.5 --gradation 1.5 -o sized.vtu",
    "adapt sized.vtu --boundary adapt -o adapted.vtu",
    "improve lattice.vtu -o improved.vtu",
    "layers delaunay.vtu --side inward --first-height 0.05 --count 3 -o layers.vtu",
    "centerline b.nrrd -o lines.vtp",
]


def digests(program, threads):
    """SHA-256 by file, up to the first command that fails, and what is wrong with that one, or nothing."""
    with tempfile.TemporaryDirectory(prefix="lumesh_bits_") as folder:
        found = {}
        for command in COMMANDS:
            words = command.split()
            options = ["--threads", str(threads)] if words[0] != "convert" else []
            run = subprocess.run([program, *words, *options], cwd=folder, capture_output=True, text=True, check=False)
            path = pathlib.Path(folder, words[-1])
            if run.returncode: return found, f"{command}: exit code {run.returncode}, {run.stderr.strip() or 'no message'}"
            if not path.is_file(): return found, f"{command}: {path.name} was not written"
            found[path.name] = hashlib.sha256(path.read_bytes()).hexdigest()
        return found, None


def main():
    programs = [str(pathlib.Path(program).resolve()) for program in sys.argv[1:]]
    if not programs:
        sys.exit(__doc__)
    runs = [(programs[0], 1), *((program, 3) for program in programs)]
    first, differences, failures = {}, 0, 0
    for program, threads in runs:
        found, failure = digests(program, threads)
        different = [name for name, digest in found.items() if first.setdefault(name, digest) != digest]
        differences += len(different)
        failures += failure is not None
        said = [", ".join(different) + " differ"] if different else []
        print(f"{program}, {threads} threads: {'; '.join([*said, failure] if failure else said) or 'same'}", flush=True)
    for name, digest in first.items():
        print(f"{digest}  {name}")
    print(f"check_same_bits: {len(runs)} runs, {differences} differences, {failures} failed")
    return 1 if differences or failures else 0


if __name__ == "__main__":
    sys.exit(main())
