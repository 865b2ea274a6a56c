#!/usr/bin/env python3
"""Measures `lumesh adapt` on the unit cube and the cube-cylinder with the UGAWG metrics: conformity by `lumesh evaluate`, seconds of
adaptation without reading and writing, peak memory. One line each on stderr, JSON on stdout.

Usage: adapt.py [--program PATH] [--threads N] [--options "..."] CASE...
Cases: linear, polar-1, polar-2 (at their own complexity), METRIC@COMPLEXITY such as polar-2@500000; all from 3 x 3 x 3
cubes; METRIC@COMPLEXITY/N from N x N x N cubes, such as polar-2@49000/93 (4.8 million tetrahedra) for coarsening;
cube-cylinder/METRIC: from the benchmark's own coarse mesh, with its cylinder adapted, where --data has it.
"""
import argparse
import json
import pathlib
import shlex
import struct
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import run  # noqa: E402  (measure() and ROOT)

sys.path.insert(0, str(run.ROOT / "tests/cli"))
from cube import cube  # noqa: E402


def write_cube(path, n):
    """As binary Medit file."""
    points, tetrahedra, triangles = cube(n)
    with open(path, "wb") as file:
        def section(keyword, items, layout):
            size = struct.calcsize("<" + layout) * len(items)
            file.write(struct.pack("<iii", keyword, file.tell() + 12 + size, len(items)))
            file.write(b"".join(struct.pack("<" + layout, *item) for item in items))
        file.write(struct.pack("<ii", 1, 2))
        file.write(struct.pack("<iii", 3, file.tell() + 12, 3))
        section(4, [(*p, 0) for p in points], "3di")
        section(6, triangles, "4i")
        section(8, tetrahedra, "5i")
        file.write(struct.pack("<ii", 54, 0))


def start_of(case, data, folder):
    """The mesh that a case begins with, the name of its metric and its complexity, if it asks for one."""
    domain, _, name = case.partition("/")
    if domain == "cube-cylinder":
        return data / "ugawg/cube-cylinder/cube-cylinder.meshb", name, ""
    metric, _, complexity = domain.partition("@")
    cube = folder / "cube.meshb"
    write_cube(cube, int(name or 3))
    return cube, metric, complexity


def run_case(program, case, data, threads, options, folder):
    start, metric, complexity = start_of(case, data, folder)
    if not start.is_file():
        print(f"{case}: skipped, no {start}", file=sys.stderr)
        return {"case": case, "skipped": str(start)}
    adapted, report, numbers = (folder / f for f in ("adapted.vtu", "adapt.json", "numbers.json"))
    command = [program, "adapt", start, "-o", adapted, "--analytic", metric, "--threads", str(threads), "--json", report,
               *(["--complexity", complexity] if complexity else []), *options]
    _, _, mib = run.measure(list(map(str, command)))
    run.measure([program, "evaluate", str(adapted), "--json", str(numbers)])
    times, found = json.loads(report.read_text()), json.loads(numbers.read_text())
    steps = times["seconds_by_step"]
    seconds = sum(value for step, value in steps.items() if step not in ("read", "build", "write"))
    lengths, ratio = found["metric_edge_length"], found["metric_mean_ratio"]
    tetrahedra = times["passes"][-1]["tetrahedra"]
    result = {"case": case, "threads": threads, "tetrahedra": tetrahedra, "complexity": times["complexity"],
              "seconds": seconds, "seconds_by_step": steps, "in_band": lengths["fraction_in_band"],
              "shortest": lengths["min"], "longest": lengths["max"], "mean_ratio_mean": ratio["mean"],
              "mean_ratio_min": ratio["min"], "peak_mib": mib, "bytes_per_tetrahedron": mib * 2**20 / tetrahedra}
    print("{case}, {threads} threads: {tetrahedra} tetrahedra, {seconds:.1f} s, in band {in_band:.4f}, lengths {shortest:.3f} to "
          "{longest:.2f}, mean ratio {mean_ratio_mean:.3f} (min {mean_ratio_min:.3f}), {peak_mib:.0f} MiB".format(**result),
          file=sys.stderr, flush=True)
    return result


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", nargs="+", metavar="CASE")
    parser.add_argument("--program", default=str(run.ROOT / "build/release/bin/lumesh"))
    parser.add_argument("--data", type=pathlib.Path, default=run.ROOT.parent / "shared/data", help="folder with ugawg/")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--options", default="", help="passed on to `lumesh adapt`")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        results = [run_case(arguments.program, case, arguments.data, arguments.threads, shlex.split(arguments.options),
                            pathlib.Path(folder)) for case in arguments.cases]
    print(json.dumps(results, indent=2))


if __name__ == "__main__":
    main()
