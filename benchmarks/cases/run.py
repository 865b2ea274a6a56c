#!/usr/bin/env python3
"""Measures wall time and peak memory of `lumesh lattice` on named cases; JSON on stdout, one line each on stderr.

Usage: run.py [--program PATH] [--repeats N] [--threads N] [CASE...]
Cases: carotid, bifurcation, layered, sphere, torus; image-128 … image-512 (carotid of that size along each axis, its
radii in proportion); elements-1.5 … elements-6 (default carotid, lattice spacing in mm). Default: carotid.
"""
import argparse
import json
import os
import pathlib
import platform
import re
import subprocess
import sys
import tempfile
import time
import typing

ROOT = pathlib.Path(__file__).resolve().parents[2]
CAROTID_SIZE, CAROTID_RADIUS, CAROTID_END_RADIUS, CAROTID_SAC_RADIUS = 512, 14, 4, 35


def arguments_of(case):
    """The options of `phantom` and of `lattice` for a case."""
    kind, _, value = case.partition("-")
    if kind == "image":
        scale = int(value) / CAROTID_SIZE
        return ["carotid", "--size", value, value, value, "--radius", str(CAROTID_RADIUS * scale), "--end-radius",
                str(CAROTID_END_RADIUS * scale), "--sac-radius", str(CAROTID_SAC_RADIUS * scale)], []
    if kind == "elements":
        return ["carotid"], ["--spacing", value]
    return [kind], []


class Timed(typing.NamedTuple):
    """One run of a command; CPU seconds are those of all its threads, user and system."""
    output: str
    seconds: float
    cpu_seconds: float
    peak_mib: float
    exit: int


def timed(command):
    start = time.monotonic()
    with tempfile.TemporaryFile("w+") as output:
        process = subprocess.Popen(command, stdout=output, stdin=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        seconds = time.monotonic() - start
        output.seek(0)
        return Timed(output.read(), seconds, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024, os.waitstatus_to_exitcode(status))


def measure(command, allowed=(0,)):
    """Output, wall seconds and peak MiB of one run; exit codes that are not allowed end the script."""
    run = timed(command)
    if run.exit not in allowed:
        raise SystemExit(f"{' '.join(command)}: exit {run.exit}")
    return run.output, run.seconds, run.peak_mib


def run_case(program, case, repeats, threads, folder):
    phantom, lattice = arguments_of(case)
    image, mesh = str(folder / "case.nrrd"), str(folder / "case.vtu")
    measure([program, "phantom", *phantom, "-o", image])
    command = [program, "lattice", image, "-o", mesh, "--threads", str(threads), *lattice]
    runs = [measure(command) for _ in range(repeats)]
    seconds = sorted(run[1] for run in runs)
    found = re.search(r"(\d+) tetrahedra", runs[0][0])
    result = {"case": case, "tetrahedra": int(found.group(1)) if found else None, "seconds_median": seconds[len(seconds) // 2],
              "seconds_min": seconds[0], "seconds_max": seconds[-1], "peak_mib": max(run[2] for run in runs)}
    print("{case}: {tetrahedra} tetrahedra, {seconds_median:.2f} s ({seconds_min:.2f} to {seconds_max:.2f}), "
          "{peak_mib:.0f} MiB".format(**result), file=sys.stderr)
    return result


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", nargs="*", default=["carotid"])
    parser.add_argument("--program", default=str(ROOT / "build/release/bin/lumesh"))
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--threads", type=int, default=0)
    options = parser.parse_args()
    commit = subprocess.run(["git", "rev-parse", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=False).stdout.strip()
    with tempfile.TemporaryDirectory() as folder:
        results = [run_case(options.program, case, options.repeats, options.threads, pathlib.Path(folder))
                   for case in options.cases]
    json.dump({"commit": commit, "cores": os.cpu_count(), "machine": platform.machine(), "threads": options.threads,
               "repeats": options.repeats, "results": results}, sys.stdout, indent=2)
    print()


if __name__ == "__main__":
    main()
