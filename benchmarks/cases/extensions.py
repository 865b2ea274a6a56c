#!/usr/bin/env python3
"""Flow extensions of images, surfaces and finished meshes, measured in the meshes that are written and not asked of lumesh.

Inputs: the phantoms (torus and layered ball cut by a plane), the bifurcation with a wall four voxels thick, the crop of the sac, the
open surfaces of the data, closed ones that are clipped or cut raggedly here, and tubes by formula (bent, oblique, elliptic, conical, ragged).
Forms: `lattice` and `delaunay` of images, `delaunay` of surfaces, `layers --extend` of finished meshes; each with 5r at all openings,
images and surfaces also with --extend-circle 2r. Every opening is compared with that of the mesh without --extend, of images with
that by `delaunay`, whose openings have the areas of smooth sections:

length   of the end's plane from the centre of the opening along the end's normal d, over five radii of the section square to d
area     of the end, over that of the opening's section square to d
flat     farthest vertex of the end from its plane, in radii
seam     mean angle between normals of the wall within one edge before and behind the opening's plane: of means over eighths of the way around
         the axis, in axes that turn with it, which leaves out that facets are flat; in brackets the same of single triangles, each with that
         which is nearest around the axis, and of means one edge further in, where nothing was joined on
tilt     of the vessel's wall within one edge before the plane, against the extension's: by a first harmonic around the axis of the angle of its
         normals with the plane square to d; taper: the mean of it, > 0 where the vessel narrows towards its end
round    with --extend-circle: largest less least distance of the rim from its centre, over its mean
volume   that the mesh has more, over the sum of areas by lengths
extra    CPU seconds of `info --extend` (of meshes: of `layers`) less those without (of `convert`), medians of three; in brackets of the mesher
truth    tubes by formula: degrees between the end's normal and the tube's axis

Bars: length 0.5 %, area 1 %, flat 1e-6, seam 3 degrees, round 2 %, volume 1 % (and 0.3 % of the mesh before), extra 0.2 s, names kept, mesh
without faults (medit.py). A table on stdout; what misses is in bold, with lumesh's warning if there is one ("told").

Usage: extensions.py [--program PATH] [--data FOLDER] [--keep FOLDER] [INPUT...]
"""
import argparse
import gzip
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile

DEBIAN_PYTHON = "/usr/bin/python3"  # It has numpy.
if __name__ == "__main__" and os.path.realpath(sys.executable) != os.path.realpath(DEBIAN_PYTHON) and os.access(DEBIAN_PYTHON, os.X_OK):
    os.execv(DEBIAN_PYTHON, [DEBIAN_PYTHON, *sys.argv])

import numpy as np  # noqa: E402

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import digitised  # noqa: E402
import medit  # noqa: E402
import run  # noqa: E402  (ROOT)
import surface_repair  # noqa: E402  (STL files)

RADII, CIRCLE_RADII = 5, 2
PARTS_AROUND = 8
BARS = {"length": 0.005, "area": 0.01, "flat": 1e-6, "seam": 3.0, "round": 0.02, "volume": 0.01, "extra": 0.2}
WALL_VOXELS = 4
IMAGES = ["carotid", "bifurcation", "torus", "layered", "walled", "crop"]
OPEN = {"artery.stl": "vampy/artery.stl", "artery.vtp": "surfaces/open/artery.vtp", "atrium": "surfaces/open/atrium.vtp",
        "vein": "surfaces/open/vampy_vein.stl", "ventricle": "surfaces/open/vampy_ventricle.stl",
        "gmsh": "gmsh-aneurysm/aneurysm_data.stl.gz", "aorta": "unseen/aorta-surface-open-ends.stl"}
CLOSED = {"fenics": ("fenics-aneurysm/aneurysm_boundary.stl", "1r"), "tagged": ("surfaces/tagged/bifurcation.vtp", None),
          "tagged-clipped": ("surfaces/tagged/bifurcation.vtp", "1r")}
CUTS = {"fenics-ragged": "fenics-aneurysm/aneurysm_boundary.stl"}
TUBES = ["bent", "oblique", "elliptic", "conical", "ragged"]


class Failed(Exception):
    pass


class Lumesh:
    def __init__(self, program, folder):
        self.program, self.folder = program, folder

    def __call__(self, *words, allowed=(0,)):
        """What it says, warnings and CPU seconds."""
        command = [self.program, *map(str, words)]
        command += [] if words[0] in ("convert", "phantom") else ["--threads", "1"]
        before = os.times()
        done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=self.folder)
        after = os.times()
        if done.returncode not in allowed:
            raise Failed(f"exit {done.returncode}: {done.stderr.strip().splitlines()[-1:]}")
        seconds = after.children_user - before.children_user + after.children_system - before.children_system
        return done.stdout, [line.removeprefix("lumesh: warning: ") for line in done.stderr.splitlines() if "warning" in line], seconds


def read_nrrd(path):
    data = pathlib.Path(path).read_bytes()
    head, body = data.split(b"\n\n", 1)
    fields = dict(line.split(": ", 1) for line in head.decode().splitlines() if ": " in line)
    body = gzip.decompress(body) if fields["encoding"] == "gzip" else body
    sizes = tuple(map(int, fields["sizes"].split()))
    return np.frombuffer(body, np.uint8).reshape(sizes, order="F"), float(fields["space directions"][1:].split(",")[0])


def with_wall(labels, voxels):
    """Label 2 around label 1, as thick as that, open where the vessel leaves the image."""
    near, grid = labels > 0, np.arange(-voxels, voxels + 1)
    wide = near.copy()
    for shift in np.stack(np.meshgrid(grid, grid, grid, indexing="ij"), -1).reshape(-1, 3):
        if (shift ** 2).sum() <= voxels ** 2:
            there = tuple(slice(max(0, s), n + min(0, s)) for s, n in zip(shift, near.shape))
            here = tuple(slice(max(0, -s), n + min(0, -s)) for s, n in zip(shift, near.shape))
            wide[there] |= near[here]
    return np.where(near, 1, np.where(wide, 2, 0)).astype(np.uint8)


def tube_by_formula(name):
    """Points and triangles of an open tube in mm, radius 1, and the directions that its ends have."""
    rings, around, bend, random = 61, 32, 7.5, np.random.default_rng(5)
    turn = np.linspace(0, 1.2, rings)
    points = []
    for i, t in enumerate(turn):
        phi = 2 * np.pi * (np.arange(around) + 0.5 * (i % 2)) / around
        x, y = np.cos(phi), np.sin(phi)
        radius = np.full(around, 1.4 - 0.6 * t if name == "conical" else 1.0)
        x, y = (1.25 * x, 0.8 * y) if name == "elliptic" else (x * radius, y * radius)
        along = np.zeros(around)
        if name == "oblique":  # Both ends lean by 30 degrees.
            along = np.tan(np.radians(30)) * y * abs(2 * i / (rings - 1) - 1) ** 3 * np.sign(2 * i / (rings - 1) - 1)
        if name == "ragged" and i in (0, rings - 1):
            along = random.uniform(-0.07, 0.07, around)
        if name in ("bent", "ragged"):
            angle = t + along / bend
            points.append(np.stack([(bend + x) * np.cos(angle), y, (bend + x) * np.sin(angle)], 1))
        else:
            points.append(np.stack([x, y, bend * t + along], 1))
    points, triangles = np.concatenate(points), []
    for i in range(rings - 1):
        for j in range(around):
            a, b = i * around + j, i * around + (j + 1) % around
            c, d = a + around, b + around
            triangles += [[a, b, c], [b, d, c]] if i % 2 == 0 else [[a, b, d], [a, d, c]]
    if name in ("bent", "ragged"):
        directions = [(0, 0, -1), (-np.sin(turn[-1]), 0, np.cos(turn[-1]))]
        triangles = np.array(triangles)[:, ::-1]
    else:
        directions = [(0, 0, -1), (0, 0, 1)]
    return points, np.array(triangles), np.array(directions, float)


def cut_raggedly(path, ends, deep):
    """A closed surface without the triangles beyond planes before its flat ends."""
    points, triangles = surface_repair.read_stl(path)
    kept = np.ones(len(triangles), bool)
    for centre, normal, radius in ends:
        from_end = points[triangles] - centre
        kept &= ~((from_end @ normal > -deep * radius) & (np.linalg.norm(from_end, axis=-1) < (deep + 2) * radius)).any(1)
    return points, triangles[kept]


class Opening:
    def __init__(self, mesh, name):
        self.name, triangles = name, mesh.patch(name)
        areas, normals = medit.areas_and_normals(mesh.points, triangles)
        self.area = float(areas.sum())
        self.normal = digitised.unit((areas[:, None] * normals).sum(0))
        self.centre = (areas[:, None] * mesh.points[triangles].mean(1)).sum(0) / self.area
        corners = mesh.points[np.unique(triangles)]
        self.off = float(np.abs((corners - self.centre) @ self.normal).max())
        edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        rim, times = np.unique(edges, axis=0, return_counts=True)
        away = mesh.points[np.unique(rim[times == 1])] - self.centre
        far = np.linalg.norm(away, axis=1)
        self.reach, self.oval = float(far.max()), float((far.max() - far.min()) / far.mean())

    def radius(self, direction):
        return (self.area * abs(self.normal @ direction) / np.pi) ** 0.5


def seam_angles(mesh, opening, direction, kinds):
    """At the opening's plane, and one edge before it."""
    triangles = mesh.of_kind(*kinds)
    if not len(triangles):
        return None
    centres = mesh.points[triangles].mean(1) - opening.centre
    along, height = centres @ direction, centres @ opening.normal
    off = centres - along[:, None] * direction
    near = (np.linalg.norm(off, axis=1) < 1.3 * opening.reach) & (np.abs(height) < opening.reach)
    corners = mesh.points[triangles]
    lengths = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).mean(1)
    before, after = near & (height < 0), near & (height > 0) & (height < 2 * lengths)
    if not before.any() or not after.any():
        return None
    # Rows of an extension may be higher than the vessel's edges are long.
    height = np.where(height < 0, height / lengths[before].mean(), height / lengths[after].mean())
    areas, normals = medit.areas_and_normals(mesh.points, triangles)
    first = digitised.across(direction, 0.0)
    second = np.cross(direction, first)

    def between(low, middle, high):
        sides = []
        for a, b in ((low, middle), (middle, high)):
            side = near & (height > a) & (height < b)
            around = np.arctan2(off[side] @ second, off[side] @ first)
            radial = np.cos(around)[:, None] * first + np.sin(around)[:, None] * second
            tangent = np.cross(direction, radial)
            n = normals[side]
            sides.append((around, np.stack([(n * radial).sum(1), (n * tangent).sum(1), n @ direction], 1), areas[side]))
        (one, one_normals, weights), (other, other_normals, _) = sides
        if not len(one) or not len(other):
            return (float("nan"),) * 4
        gap = np.abs((one[:, None] - other[None] + np.pi) % (2 * np.pi) - np.pi)
        facets = mean_angle(one_normals, other_normals[gap.argmin(1)], weights)
        parts = [np.minimum(((a + np.pi) / (2 * np.pi) * PARTS_AROUND).astype(int), PARTS_AROUND - 1) for a in (one, other)]
        means = [np.stack([np.bincount(part, n[:, k] * w, PARTS_AROUND) for k in range(3)], 1)
                 for part, (_, n, w) in zip(parts, sides)]
        there = (np.linalg.norm(means[0], axis=1) > 0) & (np.linalg.norm(means[1], axis=1) > 0)
        means = [m[there] / np.linalg.norm(m[there], axis=1)[:, None] for m in means]
        around = 2 * np.pi * (np.flatnonzero(there) + 0.5) / PARTS_AROUND
        waves = np.stack([np.ones(len(around)), np.cos(around), np.sin(around)], 1)
        taper, *tilt = np.linalg.lstsq(waves, np.degrees(np.arcsin(means[0][:, 2])), rcond=None)[0]
        return mean_angle(means[0], means[1], np.ones(there.sum())), facets, float(np.hypot(*tilt)), float(taper)
    return (*between(-1, 0, 1), between(-2, -1, 0)[0])


def mean_angle(ones, others, weights):
    cosines = np.clip(np.abs((ones * others).sum(1)), -1, 1)  # Normals of interfaces may point either way.
    return float((np.degrees(np.arccos(cosines)) * weights).sum() / weights.sum())


def companions(openings, one):
    """Those in the plane of one that share its axis: a lumen and its wall."""
    return [o for o in openings.values() if abs((o.centre - one.centre) @ one.normal) < 0.01 * one.reach and
            np.linalg.norm(o.centre - one.centre) < 0.5 * max(o.reach, one.reach) and o.normal @ one.normal > 0.99]


def compare(reference, before, after, round_after, told, directions):
    """A row for each opening of the reference."""
    old = {name: Opening(reference, name) for name in reference.openings()}
    new = {name: Opening(after, name) for name in after.openings()}
    rounded = {name: Opening(round_after, name) for name in round_after.openings()} if round_after else {}
    rows, grown = [], 0.0
    for name, one in old.items():
        words = [w for w in told if name in w]
        if name not in new:
            rows.append({"end": name, "lost": True, "told": words})
            continue
        end = new[name]
        way, direction = end.centre - one.centre, end.normal
        length = float(way @ direction)
        beside = companions(old, one)
        radius = min(beside, key=lambda o: o.reach).radius(direction)  # Of the lumen.
        seams = [s for s in (seam_angles(after, one, direction, kinds) for kinds in (("wall",), ("interface",))) if s]
        seam = max(seams, key=lambda s: s[0]) if seams else (float("nan"),) * 5
        section = one.area * abs(one.normal @ direction)
        grown += section * length
        row = {"end": name, "lost": False, "radius": radius, "lean": float(np.degrees(np.arccos(min(1.0, one.normal @ direction)))),
               "length": length / (RADII * radius) - 1, "area": end.area / section - 1, "flat": end.off / radius,
               **dict(zip(("seam", "facets", "tilt", "taper", "control"), seam)),
               "aside": float(np.linalg.norm(way - length * direction)) / radius, "told": words}
        if name in rounded:
            row |= {"round": rounded[name].oval if len(beside) == 1 else None,
                    "round_area": rounded[name].area / (one.area * abs(one.normal @ rounded[name].normal)) - 1}
        if directions is not None:
            row["truth"] = float(np.degrees(np.arccos(np.clip((directions @ direction).max(), -1, 1))))
        rows.append(row)
    old_volume, new_volume = (sum(mesh.volumes()[1].values()) for mesh in (before, after))
    more = new_volume - old_volume
    volume = more / grown - 1 if grown else 0.0
    is_off = abs(more - grown) > BARS["volume"] * grown + 0.003 * old_volume
    return rows, volume, is_off, sorted(set(new) - set(old))


def misses(row):
    if row["lost"]:
        return ["gone"]
    found = [key for key in ("length", "area", "flat", "seam") if abs(row[key]) > BARS[key]]
    if row.get("round") is not None and row["round"] > BARS["round"]:
        found.append("round")
    if abs(row.get("round_area", 0)) > BARS["area"]:
        found.append("round area")
    if row["aside"] > 0.5:
        found.append("name")
    return found


HEAD = ["input, form", "end", "radius, mm", "lean, degrees", "length, %", "area, %", "flat, radii", "seam (facets, before), degrees",
        "tilt, taper, degrees", "round, %", "truth, degrees", "missed"]


def print_rows(what, rows, volume, is_off, others, bad, extra, told):
    for row in rows:
        missed = misses(row)
        note = f"**{', '.join(missed)}**{' (told)' if row['told'] else ''}" if missed else ""
        if row["lost"]:
            print(f"| {what} | {row['end']} |" + " |" * 9 + f" {note} |")
            continue
        oval = "" if row.get("round") is None else f"{100 * row['round']:.2f}, area {100 * row['round_area']:+.2f}"
        print("| " + " | ".join([what, row["end"], f"{row['radius']:.3f}", f"{row['lean']:.1f}", f"{100 * row['length']:+.2f}",
                                 f"{100 * row['area']:+.2f}", f"{row['flat']:.0e}", f"{row['seam']:.2f} ({row['facets']:.2f}, {row['control']:.2f})",
                                 f"{row['tilt']:.1f}, {row['taper']:+.1f}", oval,
                                 f"{row['truth']:.2f}" if "truth" in row else "", note]) + " |")
    whole = [f"volume {100 * volume:+.2f} %" if not is_off else f"**volume {100 * volume:+.2f} %**"]
    seconds = f"extra {extra[0]:.2f}" if extra[0] <= BARS["extra"] else f"**extra {extra[0]:.2f}**"
    whole.append(f"{seconds} ({extra[1]:.2f}) s")
    whole += [f"**other openings: {', '.join(others)}**"] if others else []
    whole += [f"**{fault}**" for fault in bad]
    whole += [f"told: {' / '.join(told)}"] if told else []
    print(f"| {what} | all |" + " |" * 9 + f" {'; '.join(whole)} |", flush=True)


class Inputs:
    def __init__(self, lumesh, data):
        self.lumesh, self.data, self.folder = lumesh, data, lumesh.folder

    def image(self, name):
        """Path and options."""
        path = self.folder / f"{name}.nrrd"
        if name == "crop":
            return self.data / "aneurism/aneurism_x2_crop_sac_label.nrrd", []
        if name == "walled":
            bare, _ = self.image("bifurcation")
            labels, voxel = read_nrrd(bare)
            digitised.write_nrrd(path, with_wall(labels, WALL_VOXELS), np.zeros(3), voxel)
            return path, []
        if not path.exists():
            self.lumesh("phantom", name, "-o", path)
        if name in ("torus", "layered"):
            labels, voxel = read_nrrd(path)
            middle = 0.5 * voxel * (np.array(labels.shape) - 1)
            return path, ["--cut-plane", *(middle + 0.123), *((1, 0, 0) if name == "torus" else (0, 0, 1))]
        return path, []

    def surface(self, name):
        """Path, options, and the directions and the number of ends where they are known."""
        path = self.folder / f"{name}.stl"
        if name in OPEN:
            return self.data / OPEN[name], [], None, None
        if name in CLOSED:
            file, clip = CLOSED[name]
            return self.data / file, ["--clip-ends", clip] if clip else [], None, None
        if name in CUTS:
            closed = self.folder / "closed.mesh"
            self.lumesh("delaunay", self.data / CUTS[name], "-o", closed)
            mesh = medit.Mesh(closed)
            ends = [(o.centre, o.normal, o.reach) for o in (Opening(mesh, n) for n in mesh.openings())]
            surface_repair.write_stl(path, *cut_raggedly(self.data / CUTS[name], ends, 1.5))
            return path, [], None, len(ends)
        points, triangles, directions = tube_by_formula(name)
        surface_repair.write_stl(path, points, triangles)
        return path, [], directions, len(directions)


def median_seconds(call):
    return statistics.median(call()[2] for _ in range(3))


def measure(lumesh, what, mesher, source, options, reference=None, directions=None, ends=None):
    folder = lumesh.folder
    before, after, rounded = (folder / f"{what.replace(', ', '-')}-{kind}.mesh" for kind in ("before", "after", "round"))
    extend = ["--extend", f"{RADII}r"]
    plain = lumesh(mesher, source, *options, "-o", before)
    longer = lumesh(mesher, source, *options, *extend, "-o", after)
    try:
        _, circle_told, _ = lumesh(mesher, source, *options, *extend, "--extend-circle", f"{CIRCLE_RADII}r", "-o", rounded)
        round_mesh = medit.Mesh(rounded)
    except Failed as error:
        round_mesh, circle_told = None, [f"with a circle: {error}"]
    extra = median_seconds(lambda: lumesh("info", source, *options, *extend)) - median_seconds(lambda: lumesh("info", source, *options))
    meshes = medit.Mesh(reference or before), medit.Mesh(before), medit.Mesh(after)
    report(what, meshes, round_mesh, plain, longer, (extra, longer[2] - plain[2]), circle_told, directions, ends)


def report(what, meshes, round_mesh, plain, longer, extra, circle_told, directions=None, ends=None):
    told = [w for w in longer[1] if w not in plain[1]]
    rows, volume, is_off, others = compare(*meshes, round_mesh, told, directions)
    bad = medit.faults(meshes[-1]) + ([f"circle: {fault}" for fault in medit.faults(round_mesh)] if round_mesh else [])
    if ends is not None and len(rows) != ends:
        bad.append(f"{len(rows)} of {ends} ends are openings")
    print_rows(what, rows, volume, is_off, others, bad, extra, told + [w for w in circle_told if w not in longer[1] + plain[1]])


def measure_finished(lumesh, what, mesh):
    folder = lumesh.folder
    for cells in ("prisms", "tetrahedra"):
        name = f"{what}, {cells}"
        before, after = (folder / f"{name.replace(', ', '-')}-{kind}.mesh" for kind in ("before", "after"))
        plain = lumesh("convert", mesh, before)
        longer = lumesh("layers", mesh, "--extend", f"{RADII}r", "--cells", cells, "-o", after)
        seconds = (median_seconds(lambda: lumesh("layers", mesh, "--extend", f"{RADII}r", "--cells", cells, "-o", after)) -
                   median_seconds(lambda: lumesh("convert", mesh, before)))
        report(name, [medit.Mesh(before)] * 2 + [medit.Mesh(after)], None, plain, longer, (seconds, seconds), [])


def tried(what, call, *arguments):
    try:
        call(*arguments)
    except (Failed, ValueError, IndexError) as error:
        print(f"| {what} | all |" + " |" * 9 + f" **{error}** |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    every = IMAGES + [*OPEN, *CLOSED, *CUTS] + TUBES
    parser.add_argument("inputs", nargs="*", metavar="INPUT", help=f"of {', '.join(every)}; default: all")
    parser.add_argument("--program", default=str(run.ROOT / "build/release/bin/lumesh"))
    parser.add_argument("--data", type=pathlib.Path, default=run.ROOT.parent / "shared/data")
    parser.add_argument("--keep", type=pathlib.Path, help="folder for all meshes")
    arguments = parser.parse_args()
    unknown = set(arguments.inputs) - set(every)
    if unknown:
        parser.error(f"no input {', '.join(sorted(unknown))}; there are {', '.join(every)}")
    print("| " + " | ".join(HEAD) + " |\n" + "|---" * len(HEAD) + "|", flush=True)
    with tempfile.TemporaryDirectory() as name:
        folder = arguments.keep or pathlib.Path(name)
        folder.mkdir(parents=True, exist_ok=True)
        lumesh = Lumesh(str(pathlib.Path(arguments.program).resolve()), folder)
        inputs = Inputs(lumesh, arguments.data.resolve())
        for each in arguments.inputs or every:
            if each in IMAGES:
                source, options = inputs.image(each)
                reference = folder / f"{each}.mesh"
                lumesh("delaunay", source, *options, "-o", reference)
                for mesher in ("lattice", "delaunay"):
                    tried(f"{each}, {mesher}", measure, lumesh, f"{each}, {mesher}", mesher, source, options, reference)
            else:
                source, options, directions, ends = inputs.surface(each)
                tried(f"{each}, delaunay", measure, lumesh, f"{each}, delaunay", "delaunay", source, options, None, directions, ends)
            mesh = folder / f"{each}.vtu"
            lumesh("delaunay", source, *options, "-o", mesh)
            tried(f"{each}, layers", measure_finished, lumesh, f"{each}, layers", mesh)
    return 0


if __name__ == "__main__":
    sys.exit(main())
