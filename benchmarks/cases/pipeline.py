#!/usr/bin/env python3
"""Measures `lumesh run`: wall time from the image to the final mesh and with the report, memory, tetrahedra, and how well the
mesh fits its metric. Lines on stderr, JSON on stdout.

Usage: pipeline.py [--program PATH] [--threads N] [--options "--set metric.complexity=20000 ..."] CASE...
CASE is a name of examples/ without .toml, or a case file.
"""
import argparse
import json
import pathlib
import shlex
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import run  # noqa: E402  (measure() and ROOT)


def case_file(name):
    path = pathlib.Path(name)
    return path if path.suffix == ".toml" else run.ROOT / "examples" / f"{name}.toml"


def run_case(program, case, threads, options, folder):
    _, wall, mib = run.measure([program, "run", str(case), "-o", str(folder), "--threads", str(threads), "-q", *options])
    report = json.loads((folder / "report.json").read_text())
    last = report["stages"][-1]["evaluation"]
    lengths, ratios = last.get("metric_edge_length"), last.get("metric_mean_ratio")
    result = {"case": case.stem, "options": options, "seconds_by_stage": {s["name"]: s["seconds"] for s in report["stages"]},
              "seconds_to_the_mesh": sum(s["seconds"] for s in report["stages"]), "seconds_with_report": wall,
              "peak_mib": mib, "tetrahedra": last["tetrahedra"], "valid": last["valid"], "complexity": last.get("complexity"),
              "dihedral_deg": [last["dihedral_deg"]["min"], last["dihedral_deg"]["max"]]}
    print(f"{case.stem}: {result['tetrahedra']} tetrahedra, {result['seconds_to_the_mesh']:.1f} s to the mesh, "
          f"{wall:.1f} s with the report, {mib:.0f} MiB", file=sys.stderr)
    if lengths:
        free = lengths["free"]["fraction_in_band"]
        result |= {"in_band": lengths["fraction_in_band"], "in_band_free": free, "longest": lengths["max"],
                   "mean_ratio": [ratios["min"], ratios["mean"]], "below_0.1": ratios["below"]["0.1"]}
        print(f"  edges in band {100 * lengths['fraction_in_band']:.2f} %, with a free end {100 * free:.2f} %, longest "
              f"{lengths['max']:.2f}; mean ratio {ratios['mean']:.3f}, least {ratios['min']:.3f}, {ratios['below']['0.1']} below "
              f"0.1; complexity {last['complexity']:.0f}", file=sys.stderr, flush=True)
    return result


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", nargs="+", type=case_file, metavar="CASE")
    parser.add_argument("--program", default=str(run.ROOT / "build/release/bin/lumesh"))
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--options", default="", help="passed on to `lumesh run`")
    arguments = parser.parse_args()
    results = []
    for case in arguments.cases:
        with tempfile.TemporaryDirectory() as folder:
            results.append(run_case(arguments.program, case, arguments.threads, shlex.split(arguments.options), pathlib.Path(folder)))
    print(json.dumps(results, indent=2))


if __name__ == "__main__":
    main()
