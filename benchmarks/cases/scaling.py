#!/usr/bin/env python3
"""Measures how delaunay, lattice, adapt and run go faster with more threads, on the carotid phantom and on polar-2 at 500,000, and
looks whether the results have the same bits. Wall seconds of whole commands, with reading, checking and writing; Markdown on
stdout, one line each on stderr.

Usage: scaling.py [--program PATH] [--threads 1,2,4,8,16] [--small]     --small: a tenth of the work, to try the script
"""
import argparse
import hashlib
import os
import pathlib
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import adapt  # noqa: E402  (write_cube())
import run  # noqa: E402  (measure() and ROOT)


def cases(folder, small):
    """Name, command without threads, file to compare."""
    image, cube = folder / "carotid.nrrd", folder / "cube.meshb"
    size = ["--set", "input.phantom_size=[256,256,254]", "--set", "input.phantom_spacing=2"] if small else []
    return {
        "delaunay": (["delaunay", image, "--delta", 1.4 if small else 0.61], "mesh.meshb"),
        "lattice": (["lattice", image, "--spacing", 2 if small else 0.86], "mesh.meshb"),
        "adapt": (["adapt", cube, "--analytic", "polar-2", "--complexity", 50_000 if small else 500_000,
                   "--quality-passes", 1], "mesh.meshb"),
        "run": (["run", run.ROOT / "examples/case1_carotid.toml", *size], "carotid.vtu"),
    }


def measure(program, command, result, threads, folder):
    """Wall seconds, peak MiB, and what the result holds."""
    is_run = command[0] == "run"
    place = ["-o", folder] if is_run else ["-o", folder / result]
    limit = ["--set", f"run.threads={threads}"] if is_run else ["--threads", threads]
    _, seconds, mib = run.measure(list(map(str, [program, *command, *place, *limit])))
    return seconds, mib, hashlib.sha256((folder / result).read_bytes()).hexdigest()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(run.ROOT / "build/release/bin/lumesh"))
    parser.add_argument("--threads", default=",".join(str(2**i) for i in range(5) if 2**i <= len(os.sched_getaffinity(0))))
    parser.add_argument("--small", action="store_true")
    arguments = parser.parse_args()
    counts = sorted(int(n) for n in arguments.threads.split(","))
    print(f"| threads | {' | '.join(map(str, counts))} | times, {counts[0]} to {counts[-1]} | MiB |")
    print("|---" * (len(counts) + 3) + "|")
    differ = []
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        run.measure([arguments.program, "phantom", "carotid", "-o", str(folder / "carotid.nrrd")])
        adapt.write_cube(folder / "cube.meshb", 3)
        for name, (command, result) in cases(folder, arguments.small).items():
            found = [measure(arguments.program, command, result, n, folder) for n in counts]
            seconds = [f[0] for f in found]
            if len({f[2] for f in found}) > 1:
                differ.append(name)
            print(f"| {name} | {' | '.join(f'{s:.2f}' for s in seconds)} | {seconds[0] / seconds[-1]:.1f} | "
                  f"{max(f[1] for f in found):.0f} |", flush=True)
    sys.exit(f"not the same bits: {', '.join(differ)}" if differ else 0)


if __name__ == "__main__":
    main()
