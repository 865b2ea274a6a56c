#!/usr/bin/env python3
"""Random crops of real images, as they are cut from larger ones: what both meshers make of walls, sacs and vessels that the border
cuts anywhere. No truth is known: meshes are judged by medit.py (positive cells, faces of two cells at most, closed outside, no
crossings), and what lumesh says of them is counted.

Crops of 12 to 60 voxels along each axis, with 60 voxels of the object or more, each with a seed; only the largest component, default sizes,
one thread. Grey images are left out.

A table on stdout: of all crops, tetrahedra, those with angles outside the targets, seconds, the shortest edge over the median one in the
worst mesh, and how many meshes have each kind of warning; a line on stderr for each crop with an invalid mesh, an exit code besides 0
and 3, or more than 20 s. Exit status 1 if there is any.

Usage: random_crops.py [--program PATH] [--first SEED] [--crops N] [--keep FOLDER] [--mesher lattice,delaunay] IMAGE...
"""
import argparse
import collections
import gzip
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

DEBIAN_PYTHON = "/usr/bin/python3"  # It has numpy and VTK.
if __name__ == "__main__" and os.path.realpath(sys.executable) != os.path.realpath(DEBIAN_PYTHON) and os.access(DEBIAN_PYTHON, os.X_OK):
    os.execv(DEBIAN_PYTHON, [DEBIAN_PYTHON, *sys.argv])

import numpy as np  # noqa: E402
import vtk  # noqa: E402
from vtk.util.numpy_support import vtk_to_numpy  # noqa: E402

import medit  # noqa: E402
import run  # noqa: E402  (ROOT)

SECONDS = 20
KINDS = {
    "opening missing": "is missing in the mesh", "opening's area": r"% (less|more) than the input", "opening's rim": r"the rim of|has \d+ rims",
    "few edges around": "edges around", "opening not flat": "is not flat", "wall in a plane": "of wall lie in the plane",
    "wall folded": "the wall is folded", "broken pieces": r"pieces? of the mesh ha", "another topology": "differs? from the image's voxels",
    "another volume": r"fills [\d.]+ %",
}


def read_nrrd(path):
    head, data = path.read_bytes().split(b"\n\n", 1)
    fields = dict(re.findall(r"^([a-z ]+):=? *(.*)$", head.decode("latin1"), re.M))
    kind = np.dtype({"unsigned char": "u1", "uchar": "u1", "uint8": "u1", "unsigned short": "u2", "uint16": "u2",
                     "short": "i2"}[fields["type"]]).newbyteorder("<")
    data = gzip.decompress(data) if fields["encoding"].startswith("gz") else data
    axes = re.findall(r"\(([^)]*)\)", fields.get("space directions", ""))
    spacing = [float(np.linalg.norm([float(x) for x in axis.split(",")])) for axis in axes]
    sizes = [int(n) for n in fields["sizes"].split()]
    return np.frombuffer(data, kind).reshape(sizes[::-1]), spacing or [float(x) for x in fields["spacings"].split()]


def read(path):
    """Labels by z, y, x, and the spacing; an NRRD file holds its data itself."""
    if path.suffix == ".nrrd":
        return read_nrrd(path)
    reader = vtk.vtkNIFTIImageReader()
    reader.SetFileName(str(path))
    reader.Update()
    image = reader.GetOutput()
    return vtk_to_numpy(image.GetPointData().GetScalars()).reshape(image.GetDimensions()[::-1]), image.GetSpacing()


def crop(images, seed):
    random = np.random.default_rng(seed)
    while True:
        labels, spacing = images[random.integers(len(images))]
        sizes = [min(int(random.integers(12, 60)), count) for count in labels.shape]
        low = [int(random.integers(0, count - size + 1)) for count, size in zip(labels.shape, sizes)]
        part = labels[tuple(slice(a, a + size) for a, size in zip(low, sizes))]
        if (part > 0).sum() >= 60:
            return part.astype("<u2"), spacing


def write(path, labels, spacing):
    sizes = " ".join(str(n) for n in labels.shape[::-1])
    head = (f"NRRD0004\ntype: uint16\ndimension: 3\nsizes: {sizes}\nspacings: {spacing[0]} {spacing[1]} {spacing[2]}\n"
            "endian: little\nencoding: raw\n\n")
    path.write_bytes(head.encode() + np.ascontiguousarray(labels).tobytes())


def edge_ratio(mesh):
    """Shortest edge over the median one."""
    ends = np.concatenate([mesh.cells["Tetrahedra"][:, [i, j]] for i in range(4) for j in range(i + 1, 4)])
    lengths = np.linalg.norm(mesh.points[ends[:, 0]] - mesh.points[ends[:, 1]], axis=1)
    return lengths.min() / np.median(lengths)


def judge(program, mesher, image, folder, row):
    """Adds one mesh to the row; what is wrong with it, in words."""
    mesh, report = folder / "mesh.mesh", folder / "report.json"
    start = time.monotonic()
    done = subprocess.run([program, mesher, image, "-o", mesh, "--json", report, "--largest-component", "--threads", "1"],
                          capture_output=True, text=True, check=False)
    seconds = time.monotonic() - start
    row["meshes"] += 1
    row["seconds"] += seconds
    if done.returncode not in (0, 3):
        return [f"exit code {done.returncode}: {done.stderr.strip().splitlines()[-1:]}"]
    said = json.loads(report.read_text())
    row["tetrahedra"] += said["tetrahedra"]
    row["made again"] += "made again" in done.stdout + done.stderr
    bad = re.search(r"(\d+) of \d+ tetrahedra have dihedral", done.stderr)
    row["outside the targets"] += int(bad.group(1)) if bad else 0
    for kind, words in KINDS.items():
        row[kind] += any(re.search(words, line) for line in done.stderr.splitlines())
    made = medit.Mesh(mesh)
    row["shortest edge"] = min(row.get("shortest edge", 1), edge_ratio(made))
    return medit.faults(made) + ([f"{seconds:.0f} s"] if seconds > SECONDS else [])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", default=run.ROOT / "build/release/bin/lumesh", type=pathlib.Path)
    parser.add_argument("--first", type=int, default=2000)
    parser.add_argument("--crops", type=int, default=80)
    parser.add_argument("--keep", type=pathlib.Path)
    parser.add_argument("--mesher", default="lattice,delaunay")
    parser.add_argument("images", nargs="+", type=pathlib.Path)
    options = parser.parse_args()
    images = [read(path) for path in options.images]
    meshers = options.mesher.split(",")
    rows = {mesher: collections.Counter() for mesher in meshers}
    faulty = 0
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or pathlib.Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        for seed in range(options.first, options.first + options.crops):
            image = folder / f"{seed}.nrrd"
            write(image, *crop(images, seed))
            faults = [(mesher, fault) for mesher in meshers for fault in judge(options.program, mesher, image, folder, rows[mesher])]
            for mesher, fault in faults:
                print(f"{seed}, {mesher}: {fault}", file=sys.stderr, flush=True)
            faulty += bool(faults)
            if not faults and not options.keep:
                image.unlink()
    names = ["meshes", "tetrahedra", "outside the targets", "seconds", "shortest edge", "made again", *KINDS]
    print("| | " + " | ".join(meshers) + " |\n|" + "---|" * (len(meshers) + 1))
    for name in names:
        print(f"| {name} | " + " | ".join(f"{rows[mesher][name]:.4g}" if isinstance(rows[mesher][name], float)
                                          else f"{rows[mesher][name]:,}" for mesher in meshers) + " |")
    return 1 if faulty else 0


if __name__ == "__main__":
    sys.exit(main())
