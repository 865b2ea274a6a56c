#!/usr/bin/env python3
"""Generated faults in sound surfaces, and what `lumesh repair` makes of them.

Faults, each with a seed: five holes; 5 % of the triangles turned; five vertices pulled over the opposite edge; three pieces of
the wall there twice, the copies turned a little; the whole twice, exactly or 0.1 % larger; five fins on edges of the wall; folds,
holes and turned triangles together. Pieces are up to 5 % of the diagonal wide. --kinds wider: those of wider_faults.py.

Asked of each: `lumesh check` finds no fault in the result, it has the components of the sound surface, and the two-sided distance to
the sound surface is at most 1 % of its diagonal (corners and middles of edges and triangles of up to 600 triangles that differ; not
asked of lumesh).
Else it must have been refused with a place. One line on stderr for each that is not repaired; JSON on stdout. Needs numpy.

Usage: surface_repair.py [--program PATH] [--seeds N] [--kinds KIND,…|wider] SURFACE…      SURFACE: .off or .stl, sound
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile
import time

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import run  # noqa: E402  (ROOT)
from wider_faults import FAULTS as WIDER_FAULTS  # noqa: E402

KINDS = ("holes", "turned", "folds", "overlaps", "same shell", "scaled shell", "fins", "all")
SHARE = 0.01  # Of the diagonal.
MOST_TRIANGLES = 300  # Of those that differ, looked at on each side.


def read_off(path):
    words = path.read_text().split()
    points, triangles = int(words[1]), int(words[2])
    numbers = numpy.array(words[4:4 + 3 * points], float).reshape(-1, 3)
    faces = numpy.array(words[4 + 3 * points:4 + 3 * points + 4 * triangles], int).reshape(-1, 4)
    return numbers, faces[:, 1:]


def read_stl(path):
    data = path.read_bytes()
    count = int.from_bytes(data[80:84], "little")
    if len(data) == 84 + 50 * count:
        facets = numpy.frombuffer(data[84:], numpy.dtype([("n", "<f4", 12), ("a", "<u2")]))["n"][:, 3:]
        corners = facets.reshape(-1, 3).astype(float)
    else:
        corners = numpy.array([line.split()[1:4] for line in data.decode().splitlines() if line.split()[:1] == ["vertex"]], float)
    points, number = numpy.unique(corners, axis=0, return_inverse=True)
    triangles = number.reshape(-1, 3)
    return points, triangles[[len(set(t)) == 3 for t in triangles.tolist()]]


def write_stl(path, points, triangles):
    """As text, in which no digit is lost."""
    with open(path, "w", encoding="utf-8") as file:
        file.write("solid wall\n")
        for triangle in triangles:
            file.write("facet normal 0 0 0\nouter loop\n")
            file.writelines("vertex {!r} {!r} {!r}\n".format(*points[v].tolist()) for v in triangle)
            file.write("endloop\nendfacet\n")
        file.write("endsolid wall\n")


def small_patch(points, triangles, rings, diagonal, random):
    """The triangles around a place, as many rings as stay small."""
    for wanted in range(rings, -1, -1):
        for _ in range(50):
            chosen = numpy.zeros(len(triangles), bool)
            chosen[random.integers(len(triangles))] = True
            for _ in range(wanted):
                chosen = numpy.isin(triangles, triangles[chosen]).any(axis=1)
            box = points[triangles[chosen]].reshape(-1, 3)
            if numpy.linalg.norm(numpy.ptp(box, axis=0)) < 0.05 * diagonal:
                return numpy.flatnonzero(chosen)
    return numpy.array([], int)


def turned(triangles, random):
    return numpy.where((random.random(len(triangles)) < 0.05)[:, None], triangles[:, ::-1], triangles)


def folded(points, triangles, diagonal, random):
    points = points.copy()
    for t in random.integers(len(triangles), size=5):
        a, b, c = points[triangles[t]]
        middle = (b + c) / 2
        if numpy.linalg.norm(middle - a) < 0.005 * diagonal:
            points[triangles[t][0]] = a + 1.4 * (middle - a)
    return points, triangles


def holed(points, triangles, diagonal, random):
    gone = numpy.concatenate([small_patch(points, triangles, 1, diagonal, random) for _ in range(5)])
    return points, numpy.delete(triangles, gone, axis=0)


def rotation(angle, axis):
    x, y, z = axis
    cross = numpy.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return numpy.eye(3) + numpy.sin(angle) * cross + (1 - numpy.cos(angle)) * cross @ cross


def unit(random):
    direction = random.normal(size=3)
    return direction / numpy.linalg.norm(direction)


def overlapped(points, triangles, diagonal, random):
    for _ in range(3):
        patch = small_patch(points, triangles, 2, diagonal, random)
        if len(patch) == 0:
            continue
        corners = points[triangles[patch]].reshape(-1, 3)
        centre = corners.mean(axis=0)
        copies = centre + (corners - centre) @ rotation(0.05, unit(random)).T + 2e-4 * diagonal
        triangles = numpy.concatenate([triangles, len(points) + numpy.arange(len(corners)).reshape(-1, 3)])
        points = numpy.concatenate([points, copies])
    return points, triangles


def doubled(points, triangles, factor):
    centre = (points.min(axis=0) + points.max(axis=0)) / 2
    copies = points if factor == 1 else centre + factor * (points - centre)
    return numpy.concatenate([points, copies]), numpy.concatenate([triangles, triangles + len(points)])


def finned(points, triangles, diagonal, random):
    for t in random.integers(len(triangles), size=5):
        tip = points[triangles[t]].mean(axis=0) + 0.005 * diagonal * unit(random)
        triangles = numpy.concatenate([triangles, [[triangles[t][0], triangles[t][1], len(points)]]])
        points = numpy.concatenate([points, [tip]])
    return points, triangles


def with_faults(kind, points, triangles, diagonal, random):
    if kind in WIDER_FAULTS:
        return WIDER_FAULTS[kind](points, triangles, diagonal, random)
    if kind == "holes":
        return holed(points, triangles, diagonal, random)
    if kind == "turned":
        return points, turned(triangles, random)
    if kind == "folds":
        return folded(points, triangles, diagonal, random)
    if kind == "overlaps":
        return overlapped(points, triangles, diagonal, random)
    if kind == "same shell":
        return doubled(points, triangles, 1)
    if kind == "scaled shell":
        return doubled(points, triangles, 1.001)
    if kind == "fins":
        return finned(points, triangles, diagonal, random)
    points, triangles = holed(*folded(points, triangles, diagonal, random), diagonal, random)
    return points, turned(triangles, random)


def distances_to_triangles(samples, corners):
    """Of each sample to the nearest triangle; Ericson 2005, section 5.1.5, by the least of inside and edges."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normal = numpy.cross(b - a, c - a)
    normal /= numpy.maximum(numpy.linalg.norm(normal, axis=1), 1e-300)[:, None]
    nearest = numpy.empty(len(samples))
    for n, p in enumerate(samples):
        inside = numpy.ones(len(a), bool)
        best = numpy.full(len(a), numpy.inf)
        for u, v in ((a, b), (b, c), (c, a)):
            way = v - u
            inside &= numpy.einsum("ij,ij->i", numpy.cross(way, p - u), normal) >= 0
            along = numpy.einsum("ij,ij->i", p - u, way) / numpy.maximum(numpy.einsum("ij,ij->i", way, way), 1e-300)
            gap = p - u - numpy.clip(along, 0, 1)[:, None] * way
            best = numpy.minimum(best, numpy.linalg.norm(gap, axis=1))
        height = numpy.abs(numpy.einsum("ij,ij->i", p - a, normal))
        nearest[n] = numpy.where(inside, height, best).min()
    return nearest


def farthest(points, triangles, other_points, other_triangles):
    """Of what one surface has and the other has not, to the other."""
    def key(corners):
        return frozenset(map(tuple, corners.tolist()))
    known = {key(other_points[t]) for t in other_triangles}
    new = [t for t in triangles if key(points[t]) not in known]
    samples = [weights @ points[t] for t in new[::max(1, len(new) // MOST_TRIANGLES)]
               for weights in numpy.concatenate([numpy.eye(3), (1 - numpy.eye(3)) / 2, numpy.full((1, 3), 1 / 3)])]
    return distances_to_triangles(numpy.array(samples), other_points[other_triangles]).max() if samples else 0


def components(triangles):
    parent = list(range(triangles.max() + 1))

    def find(x):
        while parent[x] != x:
            parent[x] = parent[parent[x]]
            x = parent[x]
        return x
    for a, b, c in triangles.tolist():
        parent[find(a)] = parent[find(b)] = find(c)
    return len({find(v) for v in triangles.ravel().tolist()})


def try_one(program, folder, surface, kind, seed):
    points, triangles = surface
    diagonal = numpy.linalg.norm(numpy.ptp(points, axis=0))
    faulty, repaired, done = folder / "faulty.stl", folder / "repaired.stl", folder / "done.json"
    write_stl(faulty, *with_faults(kind, points, triangles, diagonal, numpy.random.default_rng(seed)))
    start = time.perf_counter()
    result = subprocess.run([program, "repair", faulty, "-o", folder / "repaired.vtp", "--json", done, "-q"], capture_output=True,
                            text=True, check=False)
    seconds = time.perf_counter() - start
    if result.returncode != 0:
        good = result.returncode == 3 and " mm" in result.stderr
        return {"outcome": "refused" if good else "failed", "why": result.stderr.strip(), "seconds": seconds}
    told = json.loads(done.read_text())
    check = json.loads(subprocess.run([program, "check", folder / "repaired.vtp", "--json"], capture_output=True, text=True,
                                      check=False).stdout)
    subprocess.run([program, "convert", folder / "repaired.vtp", repaired, "-q"], check=True, capture_output=True)
    made = read_stl(repaired)
    rounded = points.astype(numpy.float32).astype(float)  # As .stl has them.
    share = max(farthest(rounded, triangles, *made), farthest(*made, rounded, triangles)) / diagonal
    good = check["fit"] and share <= SHARE and components(made[1]) == components(triangles)
    return {"outcome": "repaired" if good else "wrong", "why": "" if good else f"{share:.4f} off, {check['findings']}"[:200],
            "method": told["method"], "share": share, "seconds": seconds}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(run.ROOT / "build/release/bin/lumesh"))
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("surfaces", nargs="+", type=pathlib.Path)
    arguments = parser.parse_args()
    kinds = tuple(WIDER_FAULTS) if arguments.kinds == "wider" else arguments.kinds.split(",")
    results = []
    with tempfile.TemporaryDirectory() as folder:
        for path in arguments.surfaces:
            surface = read_off(path) if path.suffix == ".off" else read_stl(path)
            for kind in kinds:
                for seed in range(1, arguments.seeds + 1):
                    one = try_one(arguments.program, pathlib.Path(folder), surface, kind, seed)
                    results.append({"surface": path.name, "triangles": len(surface[1]), "kind": kind, "seed": seed, **one})
                    if one["outcome"] != "repaired":
                        print(f"{path.name}, {kind}, seed {seed}: {one['outcome']}: {one['why']}", file=sys.stderr, flush=True)
    counts = {kind: {outcome: sum(r["kind"] == kind and r["outcome"] == outcome for r in results)
                     for outcome in ("repaired", "refused", "wrong", "failed")} for kind in kinds}
    print(json.dumps({"counts": counts, "results": results}, indent=1))
    return 1 if any(r["outcome"] in ("wrong", "failed") for r in results) else 0


if __name__ == "__main__":
    sys.exit(main())
