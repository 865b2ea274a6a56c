#!/usr/bin/env python3
"""Grows boundary layers on vessels, inwards and outwards: cells, share of the area complete, rate, angles and how well the object's
volume is kept. Vessels of shared/data (or --data) are left out, saying so, where they are absent. Rows on stderr, JSON on stdout; exit
status 1 if a mesh is invalid or an object's volume changes by more than 0.1 %.

Usage: vessel_layers.py [--program PATH] [--data FOLDER] [--threads N] [--repeats N] [VESSEL...]
Vessels: tube carotid bifurcation aneurism-sac aneurism-sac-radius gmsh-aneurysm fenics-aneurysm case1-outward. Default: all.
"""
import argparse
import gzip
import json
import pathlib
import re
import statistics
import struct
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import run  # noqa: E402  (ROOT)

sys.path.insert(0, str(run.ROOT / "tests/clients"))
import tubes  # noqa: E402

INWARD = ["--side", "inward", "--growth", 1.2, "--count", 4]
# What is meshed, how, and the layers. The surface's wall is its first patch; the rest are its openings.
VESSELS = {
    "tube": ("tube", ["lattice", "--spacing", 0.7], [*INWARD, "--first-height", 0.05]),
    "carotid": ("phantom carotid", ["lattice"], [*INWARD, "--first-height", 0.5]),
    "bifurcation": ("phantom bifurcation", ["lattice"], [*INWARD, "--first-height", 0.05]),
    "aneurism-sac": ("aneurism/aneurism_x2_crop_sac_label.nrrd", ["lattice"], [*INWARD, "--first-height", 0.1]),
    "aneurism-sac-radius": ("aneurism/aneurism_x2_crop_sac_label.nrrd", ["lattice"],
                            [*INWARD, "--first-height", 0.05, "--relative-to", "radius"]),
    "gmsh-aneurysm": ("gmsh-aneurysm/aneurysm_data.stl.gz", ["delaunay", "--delta", 0.5],
                      [*INWARD, "--first-height", 0.1]),
    "fenics-aneurysm": ("fenics-aneurysm/aneurysm_boundary.stl", ["delaunay", "--delta", 0.25], [*INWARD, "--first-height", 0.1]),
    "case1-outward": ("phantom carotid", ["lattice"], ["--growth", 1, "--count", 5, "--first-height", 1.2]),
}


def triangles_of_stl(data):
    """Corners of each triangle of a binary or text STL."""
    if data[:5] == b"solid" and b"facet" in data[:1000]:
        numbers = [tuple(map(float, line.split()[1:])) for line in data.decode().splitlines() if line.strip().startswith("vertex")]
        return [tuple(numbers[i:i + 3]) for i in range(0, len(numbers), 3)]
    count = struct.unpack_from("<I", data, 80)[0]
    corners = (struct.unpack_from("<9f", data, 84 + 50 * i + 12) for i in range(count))
    return [(c[0:3], c[3:6], c[6:9]) for c in corners]


def close_openings(source, target):
    """Writes the surface with fans around the middles of its open ends."""
    triangles = triangles_of_stl(gzip.decompress(source.read_bytes()))
    edges = {(t[i], t[(i + 1) % 3]) for t in triangles for i in range(3)}
    following = {b: a for a, b in edges if (b, a) not in edges}
    while following:
        loop = [next(iter(following))]
        while following[loop[-1]] != loop[0]:
            loop.append(following[loop[-1]])
        middle = tuple(sum(p[i] for p in loop) / len(loop) for i in range(3))
        triangles += [(loop[i], loop[(i + 1) % len(loop)], middle) for i in range(len(loop))]
        for point in loop:
            del following[point]
    lines = ["solid closed"]
    for corners in triangles:
        lines += ["facet normal 0 0 0", "outer loop", *("vertex {!r} {!r} {!r}".format(*p) for p in corners), "endloop", "endfacet"]
    target.write_text("\n".join([*lines, "endsolid closed", ""]))


class Bench:
    def __init__(self, arguments, folder):
        self.program, self.threads, self.repeats, self.data = arguments.program, arguments.threads, arguments.repeats, arguments.data
        self.folder = folder

    def lumesh(self, *arguments):
        command = [self.program, *map(str, arguments), "--threads", str(self.threads)]
        return subprocess.run(command, capture_output=True, text=True, check=True)

    def input_of(self, source):
        """The image or surface; None where data are absent."""
        image = self.folder / "image.nrrd"
        if source == "tube":
            tubes.write_tube_image(image, 3, 20, 0.25)
            return image
        if source.startswith("phantom "):
            self.lumesh("phantom", source.split()[1], "-o", image)
            return image
        path = self.data / source
        if path.exists() and path.suffix == ".gz":
            close_openings(path, self.folder / "closed.stl")
            return self.folder / "closed.stl"
        return path if path.exists() else None

    def evaluate(self, mesh):
        report = self.folder / "report.json"
        subprocess.run([self.program, "evaluate", mesh, "--json", report], capture_output=True, check=False)
        found = json.loads(report.read_text())
        angles = found["dihedral_deg"]
        return {"valid": found["valid"], "volume": sum(label["volume_mm3"] for label in found["labels"]), "least": angles["min"],
                "most": angles["max"]}

    def measure(self, source, mesher, layers):
        given = self.input_of(source)
        if given is None:
            return None
        bare, out, numbers = self.folder / "bare.vtu", self.folder / "layers.vtu", self.folder / "layers.json"
        self.lumesh(mesher[0], given, "-o", bare, *mesher[1:])
        times = []
        for _ in range(self.repeats):
            said = self.lumesh("layers", bare, "-o", out, "--json", numbers, *layers, "--verbose").stderr
            phases = dict(re.findall(r"lumesh: ([\w ]+) took ([\d.]+) s", said))
            times.append(sum(float(phases.get(name, 0)) for name in ("surface", "directions", "heights", "shape", "skin", "interior deformation", "cells")))
        before, after, told = self.evaluate(bare), self.evaluate(out), json.loads(numbers.read_text())
        seconds = statistics.median(times)
        row = {"cells": told["cells"], "complete": told["complete"], "bare": told["patches"][0]["bare"],
               "first_height_kept": told["patches"][0]["first_height_kept"], "least_first_height": told["patches"][0]["least_first_height"],
               "seconds": seconds,
               "cells_per_s": told["cells"] / seconds, "valid": after["valid"], "dihedral_deg": [after["least"], after["most"]],
               "volume": after["volume"] / before["volume"]}
        row["good"] = row["valid"] and ("inward" not in layers or abs(row["volume"] - 1) < 1e-3)
        return row


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(run.ROOT / "build/release/bin/lumesh"))
    parser.add_argument("--data", type=pathlib.Path, default=run.ROOT.parent / "shared/data")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("vessels", nargs="*", metavar="VESSEL")
    arguments = parser.parse_args()
    results = {}
    for name in arguments.vessels or VESSELS:
        with tempfile.TemporaryDirectory() as folder:
            row = Bench(arguments, pathlib.Path(folder)).measure(*VESSELS[name])
        if row is None:
            print(f"{name}: skipped, its data are not in {arguments.data}", file=sys.stderr)
            continue
        results[name] = row
        print("{:20} {:8} cells, {:5.1f} % complete, {:4.1f} % bare, first height kept on {:5.1f} %, least {:.3f}, {:6.2f} s, "
              "{:8.0f} cells/s, {:.2f}-{:.1f} deg, volume 1{:+.1e}{}".format(
            name, row["cells"], 100 * row["complete"], 100 * row["bare"], 100 * row["first_height_kept"],
            row["least_first_height"], row["seconds"], row["cells_per_s"], *row["dihedral_deg"],
            row["volume"] - 1, "" if row["good"] else "  FAULT"), file=sys.stderr, flush=True)
    json.dump(results, sys.stdout, indent=2)
    print()
    return 0 if all(row["good"] for row in results.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
