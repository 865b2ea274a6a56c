#!/usr/bin/env python3
"""Openings of meshes against the image's boundary: how many there are, and how far their areas are off, by both meshers at
several sizes. Lines on stderr, JSON on stdout.

Usage: openings.py [--program PATH] [--threads N] [--delta D,...] [--spacing H,...] IMAGE...   (D and H in voxels)
"""
import argparse
import json
import math
import pathlib
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import run  # noqa: E402  (measure() and ROOT)

WIDE = 2  # voxels in radius: from there on 2 % are asked for


def voxel_mm(program, image):
    text = subprocess.run([program, "info", str(image), "--json"], check=True, capture_output=True, text=True).stdout
    return math.prod(json.loads(text)["spacing_mm"]) ** (1 / 3)


def run_case(program, image, voxel, threads, mesher, size, folder):
    mesh, numbers = folder / "mesh.vtu", folder / "numbers.json"
    option = "--delta" if mesher == "delaunay" else "--spacing"
    _, seconds, _ = run.measure([program, mesher, str(image), option, str(size * voxel), "-o", str(mesh), "--threads",
                                 str(threads), "-q"])
    run.measure([program, "evaluate", str(mesh), "--image", str(image), "--centerline", "none", "--json", str(numbers), "-q"])
    found = json.loads(numbers.read_text())
    openings = [o for o in found["openings"] if o["image_area_mm2"] is not None]
    off = {"wide": [], "thin": []}
    for opening in openings:
        if opening["patches"]:
            off["wide" if opening["radius_mm"] >= WIDE * voxel else "thin"].append(opening["change_percent"])
    worst = {kind: max(values, key=abs, default=0) for kind, values in off.items()}
    result = {"image": image.name, "mesher": mesher, "size_voxels": size, "openings": len(openings),
              "missing": sum(not o["patches"] for o in openings), "others": len(found["openings"]) - len(openings),
              "worst_percent": worst, "tetrahedra": found["tetrahedra"], "seconds": seconds}
    print(f"{image.name} {mesher} {size:g}: {result['openings'] - result['missing']} of {result['openings']} openings, "
          f"{result['others']} others; worst {worst['wide']:+.2f} % from {WIDE} voxels in radius on, {worst['thin']:+.2f} % below; "
          f"{result['tetrahedra']} tetrahedra, {seconds:.2f} s", file=sys.stderr, flush=True)
    return result


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("images", nargs="+", type=pathlib.Path, metavar="IMAGE")
    parser.add_argument("--program", default=str(run.ROOT / "build/release/bin/lumesh"))
    parser.add_argument("--threads", type=int, default=0)
    sizes = {"type": lambda text: [float(size) for size in text.split(",")]}
    parser.add_argument("--delta", default=[0.8, 1.4, 1.6, 2.4, 3, 4], **sizes)
    parser.add_argument("--spacing", default=[1.4, 2.5, 4, 6], **sizes)
    arguments = parser.parse_args()
    results = []
    with tempfile.TemporaryDirectory() as folder:
        for image in arguments.images:
            voxel = voxel_mm(arguments.program, image)
            for mesher, all_sizes in (("delaunay", arguments.delta), ("lattice", arguments.spacing)):
                for size in all_sizes:
                    results.append(run_case(arguments.program, image, voxel, arguments.threads, mesher, size,
                                            pathlib.Path(folder)))
    print(json.dumps(results, indent=1))


if __name__ == "__main__":
    main()
