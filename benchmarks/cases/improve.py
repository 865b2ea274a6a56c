#!/usr/bin/env python3
"""Measures `lumesh improve` on lattice meshes of images: dihedral angles, distances to the image, volume, topology before
and after, and tetrahedra per second of a pass. Lines on stderr, JSON on stdout.

Usage: improve.py [--program PATH] [--threads N] [--options "..."] IMAGE...
"""
import argparse
import json
import pathlib
import shlex
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import run  # noqa: E402  (measure() and ROOT)


def measured(program, mesh, image, numbers):
    """What must not become worse, and what should become better."""
    run.measure([program, "evaluate", str(mesh), "--image", str(image), "--json", str(numbers), "-q"])
    found = json.loads(numbers.read_text())
    distances = found["hausdorff_mm"]
    return {"angles": [found["dihedral_deg"]["min"], found["dihedral_deg"]["max"]],
            "mesh_to_image": [distances["mesh_to_image"][k] for k in ("mean", "p95", "max")],
            "image_to_mesh": [distances["image_to_mesh"][k] for k in ("mean", "p95", "max")],
            "volume_mm3": [label["volume_mm3"] for label in found["labels"]],
            "valid": found["valid"], "components": found["components"], "euler": found["euler"],
            "tetrahedra": found["tetrahedra"]}


def run_case(program, image, threads, options, folder):
    lattice, improved, report, numbers = (folder / f for f in ("lattice.vtu", "improved.vtu", "improve.json", "numbers.json"))
    run.measure([program, "lattice", str(image), "-o", str(lattice), "-q"])
    before = measured(program, lattice, image, numbers)
    _, _, mib = run.measure([program, "improve", str(lattice), "-o", str(improved), "--threads", str(threads), "--json",
                             str(report), *options])
    after = measured(program, improved, image, numbers)
    passes = json.loads(report.read_text())["passes"]
    seconds = [p["seconds"] for p in passes]
    result = {"image": image.name, "before": before, "after": after, "passes": len(passes), "seconds": sum(seconds),
              "tetrahedra_per_second_of_a_pass": sum(p["tetrahedra"] for p in passes) / sum(seconds) if passes else None,
              "peak_mib": mib}
    for name, m in (("before", before), ("after", after)):
        print(f"{image.name} {name}: {m['tetrahedra']} tetrahedra, {m['angles'][0]:.2f} to {m['angles'][1]:.2f} degrees; mean, "
              "95 %, max in mm: mesh to image " + ", ".join(f"{d:.4f}" for d in m["mesh_to_image"]) + "; image to mesh "
              + ", ".join(f"{d:.4f}" for d in m["image_to_mesh"]) + f"; volume {sum(m['volume_mm3']):.2f} mm3, Euler {m['euler']}",
              file=sys.stderr)
    if passes:
        print("  {passes} passes, {seconds:.2f} s, {tetrahedra_per_second_of_a_pass:.3g} tetrahedra/s and pass, {peak_mib:.0f} MiB"
              .format(**result), file=sys.stderr, flush=True)
    return result


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("images", nargs="+", type=pathlib.Path, metavar="IMAGE")
    parser.add_argument("--program", default=str(run.ROOT / "build/release/bin/lumesh"))
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--options", default="", help="passed on to `lumesh improve`")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        results = [run_case(arguments.program, image, arguments.threads, shlex.split(arguments.options), pathlib.Path(folder))
                   for image in arguments.images]
    print(json.dumps(results, indent=2))


if __name__ == "__main__":
    main()
