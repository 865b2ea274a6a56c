#!/usr/bin/env python3
"""Random label images, as nasty as vessels get, through every stage that makes meshes: how many are wrong, by lumesh's own check and by a
check that knows nothing of it (points of space that lie in more than one tetrahedron, or outside of the image), and how many differ
between numbers of threads.

Kinds: blobs, tubes, checkerboards, thin sheets, mixtures of them, vessels that kiss; 1 to 20 labels, some in a frame of background,
voxels 1:1:1 and 1:1:2. Stages: `lattice`, `delaunay --delta 1.5`, `run` (Delaunay, adapted to the curvature of its surface), `adapt` (of the
lattice's mesh, to the same) and `layers` (three inwards in the mesh of `delaunay`).

A fault is: a crash or any exit code but 0, 2 (refused) and 3 (told); with 0, a mesh that `evaluate` calls invalid, or one outside of the
image by more than 0.05 voxels without a warning; places within two tetrahedra; other bits with other numbers of threads. Lines on stderr, JSON
on stdout; exit status 1 if there is any. Needs numpy. Looking at places takes a minute for each checkerboard.

Usage: validity.py [--program PATH] [--threads N,N,...] [--first SEED] [--images N] [--jobs J] [--stages A,B,...] [--time-limit S]
"""
import argparse
import collections
import hashlib
import json
import multiprocessing
import pathlib
import subprocess
import sys
import tempfile

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import run  # noqa: E402  (ROOT)

sys.path.insert(0, str(run.ROOT / "tests/cli"))
import nrrd  # noqa: E402
from cube import lines_of, read_medit  # noqa: E402

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


def medit_text(program, mesh):
    """The file, and the hash of what does not tell of the command that made it."""
    text = mesh.with_suffix(".mesh")
    subprocess.run([program, "convert", str(mesh), str(text), "-q"], check=True, capture_output=True)
    return text, hashlib.sha256("\n".join(lines_of(text)).encode()).hexdigest()


def check(scene, mesh, text, program, seed):
    points, tetrahedra, _ = read_medit(text)
    points = numpy.array(points) / scene.spacing
    tetrahedra = numpy.array(tetrahedra)[:, :4] - 1
    beyond = float(max((-0.5 - points).max(), (points - numpy.array(scene.labels.shape) + 0.5).max()))
    is_valid = subprocess.run([program, "evaluate", str(mesh), "-q"], capture_output=True).returncode == 0
    return {"valid": is_valid, "doubled": doubled_points(points, tetrahedra, seed), "beyond_voxels": beyond}


class Stages:
    """All stages on one image; those that follow take the mesh of the one before."""

    ALL = ("lattice", "delaunay", "run", "adapt", "layers")

    def __init__(self, arguments, seed, scene, folder):
        self.arguments, self.seed, self.scene, self.folder = arguments, seed, scene, folder
        self.image = folder / "image.nrrd"
        self.scene.write(self.image)

    def commands(self, stage, threads):
        """One after another; the last one makes the mesh that is checked."""
        made = self.folder / f"{stage}-{threads}.vtu"
        common = ["-q", "--threads", str(threads)]
        first = self.folder / f"{'delaunay' if stage == 'layers' else 'lattice'}-{self.arguments.threads[0]}.vtu"
        if stage == "lattice":
            return [["lattice", self.image, "-o", made, *common]], made
        if stage == "delaunay":
            return [["delaunay", self.image, "-o", made, "--delta", "1.5", *common]], made
        if stage == "run":
            case, results = self.folder / "case.toml", self.folder / f"run-{threads}"
            case.write_text(f'[input]\nimage = "{self.image}"\n[metric]\ncurvature = true\n[adapt]\n[output]\nmeshes = ["run.vtu"]\n')
            return [["run", case, "-o", results, *common]], results / "run.vtu"
        if stage == "adapt":
            metric = self.folder / f"metric-{threads}.vtu"
            return [["metric", first, "--curvature", "-o", metric, "-q"],
                    ["adapt", metric, "-o", made, "--allow-pieces", *common]], made
        return [["layers", first, "--side", "inward", "--first-height", "0.25", "--count", "3", "-o", made, *common]], made

    def run(self, stage, threads):
        result = {"seed": self.seed, "kind": self.scene.kind, "stage": stage, "threads": threads}
        commands, made = self.commands(stage, threads)
        for command in commands:
            try:
                done = subprocess.run([self.arguments.program, *map(str, command)], capture_output=True, text=True,
                                      timeout=self.arguments.time_limit)
            except subprocess.TimeoutExpired:
                return result | {"code": "time"}
            result |= {"code": done.returncode, "said": done.stderr.strip()[-600:]}
            if done.returncode != 0:
                break
        if made.exists():
            text, result["hash"] = medit_text(self.arguments.program, made)
            if threads == self.arguments.threads[0]:
                result |= check(self.scene, made, text, self.arguments.program, self.seed)
        return result

    def run_all(self):
        results = []
        for stage in self.arguments.stages:
            of_stage = [self.run(stage, threads) for threads in self.arguments.threads]
            same = len({r.get("hash") for r in of_stage}) == 1
            results.append(of_stage[0] | {"same_bits": same})
        return results


def faults(result):
    """What is wrong that the command itself did not tell, or what it may not do at all."""
    code = result["code"]
    found = [] if code in (0, 2, 3) else [f"exit {code}"]
    if code == 0 and not result.get("valid", True):
        found.append("invalid, not told")
    if result.get("doubled", 0) > 0 and code != 3:
        found.append("overlaps")
    if result.get("beyond_voxels", 0) > 0.05 and code != 3 and "beyond the image" not in result["said"]:
        found.append("outside of the image")
    if not result["same_bits"]:
        found.append("other bits")
    return found


def work(job):
    arguments, seed = job
    scene = Scene(seed)
    if not scene.labels.any():
        return []
    with tempfile.TemporaryDirectory() as name:
        return Stages(arguments, seed, scene, pathlib.Path(name)).run_all()


def numbers(text):
    return [int(n) for n in text.split(",")]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(run.ROOT / "build/release/bin/lumesh"))
    parser.add_argument("--threads", type=numbers, default=[1, 2, 5])
    parser.add_argument("--first", type=int, default=1000)
    parser.add_argument("--images", type=int, default=60)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--stages", type=lambda text: text.split(","), default=list(Stages.ALL))
    parser.add_argument("--time-limit", type=float, default=120)
    arguments = parser.parse_args()
    results = []
    with multiprocessing.Pool(arguments.jobs) as pool:
        jobs = [(arguments, seed) for seed in range(arguments.first, arguments.first + arguments.images)]
        for of_image in pool.imap_unordered(work, jobs):
            for result in of_image:
                result["faults"] = faults(result)
                results.append(result)
                if result["faults"]:
                    print({key: value for key, value in result.items() if key != "hash"}, file=sys.stderr, flush=True)
    for stage in arguments.stages:
        of = [r for r in results if r["stage"] == stage]
        codes = dict(collections.Counter(r["code"] for r in of))
        kinds = dict(collections.Counter(fault for r in of for fault in r["faults"]))
        print(f"{stage}: {len(of)} images, exit codes {codes}, faults {kinds}", file=sys.stderr)
    print(json.dumps(results, indent=1))
    sys.exit(any(r["faults"] for r in results))


if __name__ == "__main__":
    main()
