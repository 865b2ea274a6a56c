#!/usr/bin/env python3
"""Checks that builds of lumesh make the same meshes to the last bit: by other compilers, with and without optimisation, on one and on
several threads. Give it two programs or more, such as those of the presets release and debug, and of
`cmake --preset release -B build/clang -DCMAKE_CXX_COMPILER=clang++`.

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
    """SHA-256 by file."""
    with tempfile.TemporaryDirectory(prefix="lumesh_bits_") as folder:
        found = {}
        for command in COMMANDS:
            words = command.split()
            options = ["--threads", str(threads)] if words[0] != "convert" else []
            run = subprocess.run([program, *words, *options], cwd=folder, capture_output=True, text=True, check=False)
            path = pathlib.Path(folder, words[-1])
            found[path.name] = hashlib.sha256(path.read_bytes()).hexdigest() if run.returncode == 0 else run.stderr.strip()
        return found


def main():
    programs = [str(pathlib.Path(program).resolve()) for program in sys.argv[1:]]
    if not programs:
        sys.exit(__doc__)
    runs = [(program, threads) for program in programs for threads in (1, 3)]
    first, differences = None, 0
    for program, threads in runs:
        found = digests(program, threads)
        first = first or found
        different = [name for name in first if first[name] != found[name]]
        differences += len(different)
        print(f"{program}, {threads} threads: {', '.join(different) + ' differ' if different else 'same'}", flush=True)
    for name, digest in first.items():
        print(f"{digest}  {name}")
    print(f"check_same_bits: {len(runs)} runs, {differences} differences")
    return 1 if differences else 0


if __name__ == "__main__":
    sys.exit(main())
