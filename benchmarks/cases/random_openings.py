#!/usr/bin/env python3
"""Openings of random vessels, known by formula, against those of meshes by both meshers at four sizes of elements.

Images: 40 to 90 voxels a side, vessels of 1.5 to 20 voxels in radius: crossing at random, trees, several through one face,
thin, oblique (60 to 80 degrees), grazing a border, through an image's edge, merging at the border, two labels, walls with
a lumen; half of those with one label are label images, half hold how deep each voxel lies (--threshold). Some have voxels that are
not cubes, or a turned frame.

Truth: the shapes' section by the border plane, sampled where no formula of an ellipse holds, and checked by it where one does
(opening_scenes.py). What is in a mesh is read from its .mesh file, not asked of lumesh. Asked of each:

- every opening is one patch of triangles joined by edges, within 0.001 voxels of the plane, its area right, its rim of
  closed loops (one more than it has holes) of at least 8 edges, each shared with one other patch;
- names: by falling area (either order where two are within their tolerances), rims of walls and labels as documented, the same for
  both meshers and all sizes, and the same file with 1 and 2 threads;
- no other opening; no wall of more than a voxel's face in the border's plane.

Classes, and how far an area may be off the truth. `wall` is what the area changes by if the wall moves by 0.1 voxels:
  plain       radius of 2 voxels or more                      2 %
  thin        below                                           5 %
  oblique     wall less than 30 degrees off the plane         2 % or 5 % by radius, + wall
  at an edge  in two faces, or within half a voxel of that    2 % or 5 % by radius, + wall
  unclear     one opening, several or none, depending on where the wall stands within half a voxel (a graze, two that
              nearly touch): any number; names have to be the same in all meshes that have it
Radius: of the largest ball in the vessel around a point of the opening. Label images know no better than half a voxel where each
point of the wall is: + wall in all classes (single tubes of 1.6 to 6 voxels come out 0.04 voxels off at the border, r.m.s.).
Areas are also compared with `lumesh info`, the smooth boundary's section: 2 % and 5 % in all classes. What lumesh itself warns of
counts as wrong all the same, and is marked "told".

One line on stderr for each bad image or mesh, which begins with seed, kind, mesher and size; JSON on stdout. Needs numpy.

Usage: random_openings.py [--program PATH] [--first SEED] [--images N] [--jobs J] [--time-limit S] [--keep FOLDER]
"""
import argparse
import collections
import json
import multiprocessing
import pathlib
import subprocess
import sys
import tempfile
import time

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import opening_scenes  # noqa: E402
import run  # noqa: E402  (ROOT)

sys.path.insert(0, str(run.ROOT / "tests/cli"))
import nrrd  # noqa: E402
from cube import lines_of  # noqa: E402

MESHERS = ("lattice", "delaunay")
CLASSES = ("plain", "thin", "oblique", "at an edge")
SIZES = (1.5, 2.5, 4, 6)  # Edges in voxels.
FLAT, LEAST_EDGES, LARGEST_WALL = 1e-3, 8, 1.0  # Voxels, edges, voxel faces.
WALL_OFFSET = 0.1
MESHER_SECONDS = 120


class Mesh:
    """Outside and interfaces of a Medit text file, points in the scene's voxels."""

    def __init__(self, path, scene):
        text = path.read_text(encoding="ascii")
        lines = text[:text.index("\nVertices\n")].splitlines()
        # A line of the header ends in "|".
        header = "".join(line.removeprefix("# lumesh_info ")[:-1] for line in lines if line.startswith("# lumesh_info "))
        self.patches = json.loads(header)["patches"]
        points = self.section(text, "Vertices", 4, float)[:, :3]
        self.points = (points - scene.origin_mm) @ scene.frame / scene.voxel_mm
        triangles = self.section(text, "Triangles", 4, int)
        self.triangles, self.patch_of = triangles[:, :3] - 1, triangles[:, 3] - 1
        corners = self.points[self.triangles]
        self.normals = 0.5 * numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        self.areas = numpy.linalg.norm(self.normals, axis=1)
        self.centres = corners.mean(1)

    @staticmethod
    def section(text, keyword, width, kind):
        start = text.index("\n" + keyword + "\n") + len(keyword) + 2
        end = text.index("\n", start)
        count = width * int(text[start:end])
        return numpy.fromstring(text[end:], kind, count, sep=" ").reshape(-1, width)

    def edges(self, which):
        """Edges of triangles, a row of three after another, lower vertex first."""
        t = self.triangles[which]
        return numpy.sort(t[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)


def parts_of(edges_of_each, count):
    """How many pieces triangles make that are joined by edges: rows of edge numbers for each."""
    parent = list(range(count))
    first = {}
    for triangle, row in enumerate(edges_of_each.tolist()):
        for edge in row:
            other = first.setdefault(edge, triangle)
            parent[opening_scenes.find(parent, other)] = opening_scenes.find(parent, triangle)
    return numpy.array([opening_scenes.find(parent, t) for t in range(count)])


class PatchCheck:
    """What one patch of a mesh is."""

    def __init__(self, mesh, scene, number):
        self.name, self.label = mesh.patches[number]["name"], mesh.patches[number]["labels"][0]
        which = numpy.flatnonzero(mesh.patch_of == number)
        self.area = float(mesh.areas[which].sum())
        normal = mesh.normals[which].sum(0)
        self.axis = int(numpy.abs(normal).argmax())
        self.face = scene.faces[2 * self.axis + int(normal[self.axis] > 0)]
        self.is_folded = abs(normal[self.axis]) < (1 - 1e-6) * self.area
        self.off = float(numpy.abs(mesh.points[mesh.triangles[which]][..., self.axis] - self.face.height).max())
        groups = self.face.group_at(self.label, mesh.centres[which]) if self.label in scene.labels() else numpy.array([-1])
        areas = mesh.areas[which] if len(groups) == len(which) else numpy.ones(1)
        held = {int(g): float(areas[groups == g].sum()) for g in set(groups.tolist())}
        best = max(held, key=held.get)
        self.group = self.face.groups[best] if best >= 0 else None
        self.look_at_rim(mesh, which)

    def look_at_rim(self, mesh, which):
        edges, number, times = numpy.unique(mesh.edges(which), axis=0, return_inverse=True, return_counts=True)
        self.parts = len(set(parts_of(number.reshape(-1, 3), len(which)).tolist()))
        rim = edges[times == 1]
        at, degrees = numpy.unique(rim, return_counts=True)
        self.is_closed = bool((times <= 2).all() and (degrees == 2).all())
        parent = list(range(len(at)))
        for a, b in numpy.searchsorted(at, rim).tolist():
            parent[opening_scenes.find(parent, a)] = opening_scenes.find(parent, b)
        loops = collections.Counter(opening_scenes.find(parent, v) for v in range(len(at)))
        self.loops, self.least_edges = len(loops), min(loops.values(), default=0)
        others = mesh.edges(numpy.flatnonzero(mesh.patch_of != mesh.patch_of[which[0]]))
        keys = others[:, 0] * len(mesh.points) + others[:, 1]
        self.is_joined = bool(numpy.isin(rim[:, 0] * len(mesh.points) + rim[:, 1], keys).all())


def tolerance(scene, group):
    """In square voxels."""
    relative = 0.02 if group.depth >= 2 else 0.05
    wall = scene.has_labels_only() or group.kind() in ("oblique", "at an edge")
    return relative * group.area + (WALL_OFFSET * group.area_per_offset if wall else 0)


def patch_faults(scene, patch):
    group, faults = patch.group, []
    if group is None:
        return [f"other: {patch.name} of {patch.area:.2f} is no opening"]
    if patch.parts != 1:
        faults.append(f"parts: {patch.name} has {patch.parts}")
    if patch.off > FLAT or patch.is_folded:
        faults.append(f"flat: {patch.name} is not, by {patch.off:.4f}")
    if not patch.is_closed or not patch.is_joined:
        faults.append(f"rim: of {patch.name} is not closed")
    if patch.least_edges < LEAST_EDGES:
        faults.append(f"edges: {patch.name} ({group.kind()}, {patch.area:.2f}) has {patch.least_edges} around")
    if not group.is_sure:
        return faults
    if patch.loops != 1 + group.holes:
        faults.append(f"rim: of {patch.name} has {patch.loops} loops, not {1 + group.holes}")
    if abs(patch.area - group.area) > tolerance(scene, group):
        faults.append(f"truth: {patch.name} ({group.kind()}) has {patch.area:.2f}, {100 * (patch.area / group.area - 1):+.1f} % "
                      f"off the truth of {group.area:.2f}, allowed {100 * tolerance(scene, group) / group.area:.1f} %")
    return faults


def expected_ending(scene, group):
    """Of its name; None where openings that may be or not decide it."""
    groups = scene.groups()
    if any(not g.is_sure or g.is_rim is None for g in groups) and len(scene.labels()) > 1:
        return None
    labels = {g.label for g in groups if g.is_rim == group.is_rim}
    return f"_label_{group.label}" if len(labels) > 1 else ""


def number_of(name):
    """Its place by falling area, as the name says it: inlet_1 is 0."""
    kind, number = name.split("_label_")[0].rsplit("_", 1)
    return (kind == "wall_rim", 0 if kind == "inlet" else int(number) - (kind == "wall_rim"))


def name_faults(scene, patches):
    faults = []
    known = [p for p in patches if p.group is not None and p.group.is_sure and p.group.is_rim is not None]
    for p in known:
        if p.name.startswith("wall_rim") != p.group.is_rim:
            faults.append(f"name: {p.name} is {'a' if p.group.is_rim else 'no'} rim of a wall")
        ending = expected_ending(scene, p.group)
        if ending is not None and p.name != p.name.split("_label_")[0] + ending:
            faults.append(f"name: {p.name} should end in '{ending}'")
    for a in known:
        for b in known:
            apart = a.group.area - b.group.area > tolerance(scene, a.group) + tolerance(scene, b.group)
            if a.group.is_rim == b.group.is_rim and apart and number_of(a.name) > number_of(b.name):
                faults.append(f"name: {a.name} is smaller than {b.name}")
    is_clear = all(g.is_sure and g.is_rim is not None for g in scene.groups())
    numbers = sorted(number_of(p.name) for p in patches)
    rims = sum(g.is_rim is True for g in scene.groups())
    every = [(False, i) for i in range(len(scene.groups()) - rims)] + [(True, i) for i in range(rims)]
    if is_clear and numbers != every:
        faults.append("name: they are " + ", ".join(sorted(p.name for p in patches)))
    return faults


def wall_faults(mesh, scene):
    """Pieces of wall in the border's planes that look like openings."""
    is_wall = numpy.array([p["kind"] == "wall" for p in mesh.patches])
    faults = []
    for face in scene.faces:
        off = numpy.abs(mesh.points[mesh.triangles][..., face.axis] - face.height).max(1)
        flat = numpy.flatnonzero((off < FLAT) & is_wall[mesh.patch_of])
        if not len(flat):
            continue
        _, number = numpy.unique(mesh.edges(flat), axis=0, return_inverse=True)
        part = parts_of(number.reshape(-1, 3), len(flat))
        areas = {p: float(mesh.areas[flat][part == p].sum()) for p in set(part.tolist())}
        voxel_face = 1 / scene.spacing[face.axis]
        faults += [f"wall: {area:.2f} of it lies in the border" for area in areas.values() if area > LARGEST_WALL * voxel_face]
    return faults


def check_mesh(path, scene, domain_areas):
    """Faults of a mesh, names by group, and how far each sure opening is off: class, from the truth, from lumesh info."""
    mesh = Mesh(path, scene)
    numbers = [n for n, p in enumerate(mesh.patches) if p["kind"] != "wall" and p["kind"] != "interface"]
    numbers = [n for n in numbers if (mesh.patch_of == n).any()]
    patches = [PatchCheck(mesh, scene, n) for n in numbers]
    faults = [fault for patch in patches for fault in patch_faults(scene, patch)]
    off, names, groups = [], {}, scene.groups()
    for i, group in enumerate(groups):
        mine = [p for p in patches if p.group is group]
        if group.is_sure and len(mine) != 1:
            faults.append(f"{'many' if mine else 'missing'}: {len(mine)} patches for an opening ({group.kind()}) of "
                          f"{group.area:.2f}, axis {group.axis}, side {group.side}, label {group.label}")
        if mine:
            names[i] = sorted(p.name for p in mine)
        if group.is_sure and len(mine) == 1:
            section = domain_areas.get(mine[0].name)
            from_info = mine[0].area / section - 1 if section else None
            off.append((group.kind(), mine[0].area / group.area - 1, from_info))
            if from_info is None or abs(from_info) > (0.02 if group.depth >= 2 else 0.05):
                faults.append(f"section: {mine[0].name} ({group.kind()}) has {mine[0].area:.2f}, but {section or 0:.2f} by "
                              "lumesh info")
    return faults + name_faults(scene, patches) + wall_faults(mesh, scene), names, off


def write_image(scene, path):
    directions = [scene.frame[:, a] * scene.spacing[a] * scene.voxel_mm for a in range(3)]
    header = {"space directions": " ".join("(" + ",".join(map(repr, map(float, d))) + ")" for d in directions),
              "space origin": "(" + ",".join(map(repr, map(float, scene.origin_mm))) + ")"}
    voxels = scene.voxels()
    nrrd.write(path, voxels.shape, voxels.flatten(order="F").tolist(), kind="float" if scene.is_grey else "uint8", header=header)


def look_at_image(scene, program, options):
    """What lumesh finds in the image: areas in square voxels by name, by how much they are off the truth, and faults."""
    done = subprocess.run([program, "info", *options, "--json", "--threads", "1"], capture_output=True, text=True)
    if done.returncode:
        return {}, [], [f"info ends with {done.returncode}: {done.stderr.strip()}"]
    off, faults, found = [], [], json.loads(done.stdout)["openings"]
    areas = {o["name"]: o["area_mm2"] / scene.voxel_mm ** 2 for o in found}
    group_of = {}
    for o in found:
        normal = numpy.array(o["normal"]) @ scene.frame
        axis = int(numpy.abs(normal).argmax())
        face = scene.faces[2 * axis + int(normal[axis] > 0)]
        centre = (numpy.array(o["centre_mm"]) - scene.origin_mm) @ scene.frame / scene.voxel_mm
        at = face.group_at(o["label"], centre[None])[0]
        group_of[o["name"]] = face.groups[at] if at >= 0 else None
    for group in scene.groups():
        if not group.is_sure:
            continue
        mine = [areas[name] for name, other in group_of.items() if other is group]
        # The centre of a ring, or of a sickle, lies in none: the nearest one then.
        area = min(mine or areas.values(), key=lambda a: abs(a - group.area), default=0)
        off.append((group.kind(), area / group.area - 1))
        if abs(area - group.area) > tolerance(scene, group):
            faults.append(f"info: the opening ({group.kind()}) of {group.area:.2f} is {area:.2f}, {100 * off[-1][1]:+.1f} %, "
                          f"allowed {100 * tolerance(scene, group) / group.area:.1f} %")
    return areas, off, faults


def make_mesh(program, mesher, options, edge_mm, threads, path):
    path.unlink(missing_ok=True)
    command = [program, mesher, *options, "--edge-length", repr(edge_mm), "-o", str(path), "--threads", str(threads), "-q"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=MESHER_SECONDS)
    except subprocess.TimeoutExpired:
        return "time", ""
    return done.returncode, done.stdout + done.stderr


def check_image(arguments, seed, folder):
    scene = opening_scenes.Scene(seed)
    image = folder / f"{seed}.nrrd"
    write_image(scene, image)
    options = [str(image), *(["--threshold", "0"] if scene.is_grey else [])]
    domain_areas, domain_off, faults = look_at_image(scene, arguments.program, options)
    result = {"seed": seed, "kind": scene.kind, "grey": scene.is_grey, "meshes": [],
              "openings": dict(collections.Counter(g.kind() for g in scene.groups())),
              "image_faults": faults, "off": domain_off}
    names_of_group = {}
    for mesher in MESHERS:
        for size in SIZES:
            start, path = time.monotonic(), folder / f"{seed}.mesh"
            code, words = make_mesh(arguments.program, mesher, options, size * scene.voxel_mm, 1, path)
            mesh_faults, names, off = check_mesh(path, scene, domain_areas) if path.exists() else (["exit: no mesh"], {}, [])
            if code != 0:
                mesh_faults.append(f"exit: {code}")
            for group, of_group in names.items():
                if names_of_group.setdefault(group, of_group) != of_group:
                    mesh_faults.append(f"name: {of_group}, elsewhere {names_of_group[group]}")
            if size == SIZES[seed % len(SIZES)]:
                other = folder / f"{seed}-2.mesh"
                make_mesh(arguments.program, mesher, options, size * scene.voxel_mm, 2, other)
                if not (path.exists() and other.exists() and lines_of(path) == lines_of(other)):
                    mesh_faults.append("threads: other bits with 2")
            told = [line for line in words.splitlines() if line.strip()]
            result["meshes"].append({"mesher": mesher, "size": size, "faults": mesh_faults, "told": told, "off": off,
                                     "seconds": round(time.monotonic() - start, 2)})
    return result


def work(job):
    arguments, seed, deadline, folder = job
    if time.monotonic() > deadline:
        return None
    folder = pathlib.Path(folder)
    try:
        return check_image(arguments, seed, folder)
    except Exception as error:  # One image must not lose the others.
        print(f"{seed}: not checked: {error!r}", file=sys.stderr, flush=True)
        return None
    finally:
        if not arguments.keep:
            for path in (folder / f"{seed}.nrrd", folder / f"{seed}.mesh", folder / f"{seed}-2.mesh"):
                path.unlink(missing_ok=True)


def print_faults(result):
    what = f"{result['seed']} {result['kind']}{' grey' if result['grey'] else ''}"
    if result["image_faults"]:
        print(f"{what}: {'; '.join(result['image_faults'])}", file=sys.stderr, flush=True)
    for mesh in result["meshes"]:
        if mesh["faults"]:
            told = f" [told: {'; '.join(mesh['told'])}]" if mesh["told"] else ""
            print(f"{what} {mesh['mesher']} {mesh['size']}: {'; '.join(mesh['faults'])}{told}", file=sys.stderr, flush=True)


def kinds_of(faults):
    return {fault.split(":")[0] for fault in faults}


def spread(off):
    """Count, median, 99 % and worst in per cent."""
    off = sorted(map(abs, off))
    return [len(off)] + [round(100 * off[min(len(off) - 1, int(share * len(off)))], 2) for share in (0.5, 0.99, 1)]


def spreads(offs):
    """By class, of rows of class, off the truth, and off the section by lumesh info."""
    rows = {}
    for kind in CLASSES:
        for which, index in (("truth", 1), ("info", 2)):
            off = [o[index] for o in offs if o[0] == kind and len(o) > index and o[index] is not None]
            if off:
                rows[f"{kind}, off {which}"] = spread(off)
    return rows


def summary(results):
    """Rows of numbers are those of spread()."""
    kinds = collections.Counter()
    for r in results:
        kinds.update(r["openings"])
    bad = sum(any(m["faults"] for m in r["meshes"]) for r in results)
    total = {"images": len(results), "openings": dict(kinds), "bad_images": bad}
    for name, is_grey in (("grey", True), ("labels", False)):
        of = [r for r in results if r["grey"] == is_grey]
        total["info, " + name] = {"images": len(of), "bad": sum(bool(r["image_faults"]) for r in of),
                                  **spreads([o for r in of for o in r["off"]])}
    for mesher in MESHERS:
        of = [m for r in results for m in r["meshes"] if m["mesher"] == mesher]
        faults = collections.Counter(f for m in of for f in kinds_of(m["faults"]))
        total[mesher] = {"meshes": len(of), "bad": sum(bool(m["faults"]) for m in of),
                         "bad_told": sum(bool(m["faults"] and m["told"]) for m in of), "meshes_by_fault": dict(faults),
                         **spreads([o for m in of for o in m["off"]])}
    return total


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(run.ROOT / "build/release/bin/lumesh"))
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--images", type=int, default=300)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--time-limit", type=float, default=1e9, help="seconds after which no image is begun")
    parser.add_argument("--keep", type=pathlib.Path, help="folder for the images and the last mesh of each")
    arguments = parser.parse_args()
    deadline = time.monotonic() + arguments.time_limit
    with tempfile.TemporaryDirectory() as name, multiprocessing.Pool(arguments.jobs) as pool:
        if arguments.keep:
            arguments.keep.mkdir(parents=True, exist_ok=True)
        seeds = range(arguments.first, arguments.first + arguments.images)
        jobs = [(arguments, seed, deadline, str(arguments.keep or name)) for seed in seeds]
        results = []
        for result in pool.imap_unordered(work, jobs):
            if result:
                results.append(result)
                print_faults(result)
    results.sort(key=lambda r: r["seed"])
    total = summary(results)
    for name, rows in total.items():
        print(f"{name}: {json.dumps(rows)}", file=sys.stderr)
    print(json.dumps({"summary": total, "images": results}, indent=1))


if __name__ == "__main__":
    main()
