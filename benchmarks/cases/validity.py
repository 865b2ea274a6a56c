#!/usr/bin/env python3
"""Random label images, as nasty as vessels get, through both meshers: how many meshes are wrong, by lumesh's own check and by a
check that knows nothing of it (points of space that lie in more than one tetrahedron, or outside of the image).

Kinds: blobs, tubes, checkerboards, thin sheets, mixtures of them, vessels that kiss; 1 to 20 labels, some in a frame of background,
voxels 1:1:1 and 1:1:2. Lines on stderr, JSON on stdout. Needs numpy.

Usage: validity.py [--program PATH] [--threads N] [--first SEED] [--images N] [--time-limit S]
"""
import argparse
import collections
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import run  # noqa: E402  (ROOT)

sys.path.insert(0, str(run.ROOT / "tests/cli"))
import nrrd  # noqa: E402
from cube import read_medit  # noqa: E402

KINDS = ("blobs", "tubes", "checkerboard", "sheets", "mixture", "kissing")


class Scene:
    """One image: labels by voxel, first axis x."""

    def __init__(self, seed):
        self.random = numpy.random.default_rng(seed)
        self.kind = KINDS[seed % len(KINDS)]
        size = self.random.integers(18, 34, 3)
        self.labels = numpy.zeros(size, int)
        self.places = numpy.stack(numpy.meshgrid(*[numpy.arange(n) for n in size], indexing="ij"), -1).astype(float)
        getattr(self, "make_" + self.kind)(int(self.random.integers(1, 21)))
        if self.random.random() < 0.5:
            for axis in range(3):
                numpy.moveaxis(self.labels, axis, 0)[[0, -1]] = 0
        self.spacing = (1, 1, 1) if self.random.random() < 0.7 else (1, 1, 2)

    def direction(self):
        d = self.random.normal(size=3)
        return d / numpy.linalg.norm(d)

    def add_blob(self, label):
        centre, radii = self.random.uniform(0, self.labels.shape), self.random.uniform(1.5, 7, 3)
        self.labels[(((self.places - centre) / radii) ** 2).sum(-1) < 1] = label

    def add_tube(self, label, centre=None, along=None, radius=None):
        centre = self.random.uniform(0, self.labels.shape) if centre is None else centre
        along = self.direction() if along is None else along
        off = self.places - centre
        off -= (off @ along)[..., None] * along
        self.labels[numpy.linalg.norm(off, axis=-1) < (radius or self.random.uniform(1, 5))] = label

    def add_sheet(self, label):
        centre = self.random.uniform(0, self.labels.shape)
        self.labels[numpy.abs((self.places - centre) @ self.direction()) < self.random.uniform(0.5, 1.6)] = label

    def make_blobs(self, count):
        for label in range(1, count + 1):
            self.add_blob(label)

    def make_tubes(self, count):
        for label in range(1, count + 1):
            self.add_tube(label)

    def make_sheets(self, count):
        for label in range(1, count + 1):
            (self.add_sheet, self.add_tube)[self.random.integers(2)](label)

    def make_mixture(self, count):
        for label in range(1, count + 1):
            (self.add_blob, self.add_tube, self.add_sheet)[self.random.integers(3)](label)

    def make_checkerboard(self, count):
        block = (self.places // self.random.integers(2, 6)).astype(int)
        self.labels = self.random.integers(0, count + 1, (20, 20, 20))[tuple(numpy.moveaxis(block, -1, 0))]

    def make_kissing(self, _):
        along, radii = self.direction(), self.random.uniform(1.5, 4, 2)
        across = numpy.cross(along, (1, 0, 0.3))
        across /= numpy.linalg.norm(across)
        centre = numpy.array(self.labels.shape) / 2
        apart = radii.sum() + self.random.uniform(-0.3, 1.5)
        self.add_tube(1, centre, along, radii[0])
        turned = along + 0.15 * self.direction()
        self.add_tube(int(self.random.integers(1, 3)), centre + apart * across, turned / numpy.linalg.norm(turned), radii[1])

    def write(self, path):
        nrrd.write(path, self.labels.shape, self.labels.flatten(order="F").tolist(), spacing=self.spacing)


def doubled_points(points, tetrahedra, seed, per_voxel=2):
    """How many of random places lie within more than one tetrahedron; `points` in voxels."""
    random = numpy.random.default_rng(seed)
    corners = points[tetrahedra]
    low, high = numpy.floor(corners.min(1)).astype(int), numpy.ceil(corners.max(1)).astype(int)
    origin, size = low.min(0), high.max(0) - low.min(0) + 1
    offsets = random.random((*size, per_voxel, 3))
    covered = numpy.zeros((*size, per_voxel), int)
    inverse = numpy.linalg.inv(numpy.moveaxis(corners[:, 1:] - corners[:, :1], 1, 2))
    for t in range(len(tetrahedra)):
        cells = tuple(slice(a - o, b - o) for a, b, o in zip(low[t], high[t], origin))
        index = numpy.stack(numpy.meshgrid(*[numpy.arange(s.start, s.stop) for s in cells], indexing="ij"), -1)
        local = (offsets[cells] + (index + origin)[..., None, :] - corners[t, 0]) @ inverse[t].T
        covered[cells] += (local.min(-1) > 1e-7) & (local.sum(-1) < 1 - 1e-7)
    return int((covered > 1).sum())


def check(scene, mesh, program, seed):
    text = mesh.with_suffix(".mesh")
    subprocess.run([program, "convert", str(mesh), str(text), "-q"], check=True, capture_output=True)
    points, tetrahedra, _ = read_medit(text)
    points = numpy.array(points) / scene.spacing
    tetrahedra = numpy.array(tetrahedra)[:, :4] - 1
    beyond = float(max((-0.5 - points).max(), (points - numpy.array(scene.labels.shape) + 0.5).max()))
    is_valid = subprocess.run([program, "evaluate", str(mesh), "-q"], capture_output=True).returncode == 0
    return {"valid": is_valid, "doubled": doubled_points(points, tetrahedra, seed), "beyond_voxels": beyond}


def run_one(arguments, seed, mesher, scene, folder):
    image, mesh = folder / "image.nrrd", folder / "mesh.vtu"
    mesh.unlink(missing_ok=True)
    options = ["--delta", "1.5"] if mesher == "delaunay" else []
    command = [arguments.program, mesher, str(image), "-o", str(mesh), "-q", "--threads", str(arguments.threads), *options]
    result = {"seed": seed, "kind": scene.kind, "mesher": mesher}
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=arguments.time_limit)
    except subprocess.TimeoutExpired:
        return result | {"code": "time"}
    result["code"] = done.returncode
    if mesh.exists():
        result |= check(scene, mesh, arguments.program, seed)
    return result


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(run.ROOT / "build/release/bin/lumesh"))
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--first", type=int, default=1000)
    parser.add_argument("--images", type=int, default=60)
    parser.add_argument("--time-limit", type=float, default=120)
    arguments = parser.parse_args()
    results = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for seed in range(arguments.first, arguments.first + arguments.images):
            scene = Scene(seed)
            if not scene.labels.any():
                continue
            scene.write(folder / "image.nrrd")
            for mesher in ("lattice", "delaunay"):
                results.append(run_one(arguments, seed, mesher, scene, folder))
                r = results[-1]
                if r["code"] != 0 or not r["valid"] or r["doubled"] or r["beyond_voxels"] > 0.01:
                    print(r, file=sys.stderr, flush=True)
    for mesher in ("lattice", "delaunay"):
        of = [r for r in results if r["mesher"] == mesher]
        codes = dict(collections.Counter(r["code"] for r in of))
        print(f"{mesher}: {len(of)} images, exit codes {codes}; invalid by evaluate {sum(not r.get('valid', True) for r in of)}, "
              f"overlapping by sampling {sum(r.get('doubled', 0) > 0 for r in of)}, "
              f"outside of the image {sum(r.get('beyond_voxels', 0) > 0.01 for r in of)}", file=sys.stderr)
    print(json.dumps(results, indent=1))


if __name__ == "__main__":
    main()
