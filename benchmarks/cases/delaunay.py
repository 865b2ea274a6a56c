#!/usr/bin/env python3
"""Measures `lumesh delaunay`: seconds and rates of refinement and with improvement, and the finished mesh as `lumesh evaluate`
sees it: dihedral and facet angles, distances, volume, topology. A markdown table on stdout, all numbers with --json.

Usage: delaunay.py [--program PATH] [--threads N] [--rounds N] [--json FILE] [CASE...]
Cases: PHANTOM@DELTA such as carotid@1.56, or IMAGE@DELTA; options of `lumesh delaunay` may follow in the same word:
"carotid@1.56 --size-points line.vtp --size-floor 1". Without cases: all phantoms and the images of --data, which are skipped
where absent. Rates are medians, without reading, making the domain, and writing. A phantom is held against its true
surface, an image against its voxels.
"""
import argparse
import json
import pathlib
import shlex
import statistics
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import run  # noqa: E402  (measure() and ROOT)

PHANTOMS = ("carotid", "bifurcation", "layered", "sphere", "torus")
DEFAULT = ["carotid@1.56", "bifurcation@0.3", "layered@1.5", "sphere@2", "torus@1.5"]
DATA = ["crtc-cbc3d/nidus.nii.gz@1", "crtc-cbc3d/ventricles.nii.gz@1.5", "crtc-cbc3d/ventricles.nii.gz@1",
        "crtc-cbc3d/brain.nii.gz@2", "aneurism/aneurism_label_t37.nrrd@1.2",
        "aneurism/aneurism_label_t37.nrrd@0.6", "aneurism/aneurism_x2_smooth_label_t37.nrrd@1",
        "aneurism/aneurism_x2_crop_sac_label.nrrd@1", "multi-label/MRIcrop-seg.gipl.gz@1.2",
        "multi-label/MRIcrop-seg.gipl.gz@0.7"]
NO_MESHING = ("read", "shape", "domain", "sizes", "write", "check", "pass")  # A pass is part of improvement.


def image_of(name, program, folder):
    """A file, or the phantom of that name with its true surface."""
    if name not in PHANTOMS:
        return pathlib.Path(name), None
    image, truth = folder / f"{name}.nrrd", folder / f"{name}.phantom.json"
    if not image.is_file():
        run.measure([program, "phantom", name, "-o", str(image), "-q"])
    return image, truth


def meshed(program, image, delta, threads, options, folder):
    """One run: what the program told, peak MiB and the mesh."""
    mesh, report = folder / "mesh.vtu", folder / "report.json"
    _, _, mib = run.measure([program, "delaunay", str(image), "-o", str(mesh), "--delta", delta, "--threads", str(threads),
                             "--json", str(report), "-q", *options])
    told = json.loads(report.read_text())
    phases = told["seconds"]
    whole = sum(seconds for name, seconds in phases.items() if name not in NO_MESHING)
    return {"tetrahedra": told["tetrahedra"], "refinement_seconds": whole - phases.get("improvement", 0), "meshing_seconds": whole,
            "all_seconds": sum(s for name, s in phases.items() if name not in ("pass",)), "peak_mib": mib, "phases": phases}, mesh


def evaluated(program, mesh, image, truth, folder):
    """What counts of `lumesh evaluate`."""
    numbers = folder / "numbers.json"
    against = ["--image", str(image), *(["--reference", str(truth)] if truth else [])]
    run.measure([program, "evaluate", str(mesh), *against, "--json", str(numbers), "-q"], allowed=(0, 3))
    found = json.loads(numbers.read_text())
    labels, voxel = found["labels"], found["image"]["voxel_size_mm"]
    result = {"valid": found["valid"], "dihedral": [found["dihedral_deg"]["min"], found["dihedral_deg"]["max"]],
              "facet": min(p["smallest_angle_deg"] for p in found["boundary"]["patches"]),
              "image_distances_voxels": [[found["hausdorff_mm"][way][k] / voxel for k in ("mean", "max")]
                                         for way in ("mesh_to_image", "image_to_mesh")],
              "labels": len(labels), "components": found["components"], "euler": found["euler"],
              "topology_equal": all(label["components"] == label["image"]["components"] and
                                    label["euler"] == label["image"]["euler"] for label in labels)}
    if truth:
        of_truth = [label["reference"] for label in labels]
        result["volume_error_percent"] = max((t["volume_error_percent"] for t in of_truth), key=abs)
        result["truth_distances_voxels"] = [[max(t[way][k] for t in of_truth) / voxel for k in ("mean", "max")]
                                            for way in ("surface_distance_mm", "truth_to_mesh_mm")]
    else:
        volume, voxels = sum(label["volume_mm3"] for label in labels), sum(label["voxel_volume_mm3"] for label in labels)
        result["volume_error_percent"] = 100 * (volume / voxels - 1)
    return result


def run_case(case, arguments, folder):
    words = shlex.split(case)
    name, _, delta = words[0].rpartition("@")
    image, truth = image_of(name, arguments.program, folder)
    if not image.is_file():
        print(f"{case}: skipped, no {image}", file=sys.stderr)
        return None
    runs = []
    for _ in range(arguments.rounds):
        told, mesh = meshed(arguments.program, image, delta, arguments.threads, words[1:], folder)
        runs.append(told)
    result = {"case": " ".join([image.name.split(".")[0] + "@" + delta, *words[1:]]), "threads": arguments.threads, "runs": runs,
              **evaluated(arguments.program, mesh, image, truth, folder)}
    print(row(result), file=sys.stderr, flush=True)
    return result


HEADER = ("| case | threads | tetrahedra | refinement, s | with improvement, s | tets/s | all, s | dihedral, degrees | "
          "least facet angle | mesh to truth or image and back, mean / max voxels | volume | labels, topology | peak MiB |")


def row(result):
    runs = result["runs"]
    seconds = [statistics.median(r[key] for r in runs) for key in ("refinement_seconds", "meshing_seconds", "all_seconds")]
    against = "truth" if "truth_distances_voxels" in result else "image"
    there, back = result[f"{against}_distances_voxels"]
    topology = "equal" if result["topology_equal"] else f"{result['components']} pieces, Euler {result['euler']}"
    return (f"| {result['case']} | {result['threads']} | {runs[-1]['tetrahedra']:,} | {seconds[0]:.2f} | {seconds[1]:.2f} | "
            f"{runs[-1]['tetrahedra'] / seconds[1]:,.0f} | {seconds[2]:.2f} | {result['dihedral'][0]:.2f}–{result['dihedral'][1]:.2f} | "
            f"{result['facet']:.1f} | {against} {there[0]:.3f} / {there[1]:.2f}, {back[0]:.3f} / {back[1]:.2f} | "
            f"{result['volume_error_percent']:+.2f} % | "
            f"{result['labels']}, {topology}{'' if result['valid'] else ', NOT VALID'} | {max(r['peak_mib'] for r in runs):.0f} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", nargs="*", metavar="CASE")
    parser.add_argument("--program", default=str(run.ROOT / "build/release/bin/lumesh"))
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--data", type=pathlib.Path, default=run.ROOT.parent / "shared/data")
    parser.add_argument("--json", type=pathlib.Path, help="where to write all numbers")
    arguments = parser.parse_args()
    cases = arguments.cases or [*DEFAULT, *(f"{shlex.quote(str(arguments.data))}/{case}" for case in DATA)]
    with tempfile.TemporaryDirectory() as folder:
        results = [run_case(case, arguments, pathlib.Path(folder)) for case in cases]
    results = [result for result in results if result]
    print("\n".join([HEADER, "|" + "---|" * (HEADER.count("|") - 1), *map(row, results)]))
    if arguments.json:
        arguments.json.write_text(json.dumps(results, indent=2) + "\n")


if __name__ == "__main__":
    main()
