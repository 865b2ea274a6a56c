#!/usr/bin/env python3
"""Pairs of vessels side by side, known by formula: what `check` finds, what `--touching` makes of them, and whether meshes of both meshers,
adapted ones and those with layers are valid.

Pairs, each with a seed: radii 2 to 6 voxels, gaps -1 to 3, angles 0 to 90 degrees in any direction; straight, or bent away from each other or
sideways (12 to 40 voxels); through the image, or capsules that end in it. Of those with a gap of a voxel or more, half have a bridge between them,
one or two voxels thick. Voxels of 0.5 mm.

contact    `check` names vessels that touch if and only if voxels of both share a face (or are the same); near ones where they have an edge, a
           corner or a voxel between them at most; nothing at gaps above 2.5 voxels; a bridge within three voxels of where it is ("bridge" or
           "touching")
pieces     voxels joined through faces, of the image, of what `info --touching` counts, and of meshes: keep as the image has, separate what both vessels
           have (2, or more where one leaves the image and returns), join one less
changed    voxels that `info` counts more or less, against the warning's number and volume; meshes' volumes within 10 % and 0.5 % of the whole
valid      each mesh by medit.py: positive cells, faces of two cells at most, closed outside, every outer face in a patch, no crossings outside
adapt      of the meshes of `delaunay`, kept and separated, to a curvature metric, with odd seeds of 0.4 of its complexity
layers     on the same inwards, three of 0.25 voxels; prisms with odd seeds; `lattice` kept too; outwards on `delaunay` kept

Images given instead are asked for the same where it can be told without a formula: changed (by `info`), pieces (meshes have those of voxels), valid.

A table on stdout, a line on stderr for each fault. Exit status 1 if there is any.

Usage: kissing.py [--program PATH] [--first SEED] [--pairs N] [--time-limit S] [--keep FOLDER] [--mesher lattice,delaunay] [IMAGE...]
"""
import argparse
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

DEBIAN_PYTHON = "/usr/bin/python3"  # It has numpy.
if __name__ == "__main__" and os.path.realpath(sys.executable) != os.path.realpath(DEBIAN_PYTHON) and os.access(DEBIAN_PYTHON, os.X_OK):
    os.execv(DEBIAN_PYTHON, [DEBIAN_PYTHON, *sys.argv])

import numpy as np  # noqa: E402

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import digitised  # noqa: E402
import medit  # noqa: E402
import run  # noqa: E402  (ROOT)

SIZE, VOXEL_MM = 56, 0.5
CHOICES = ("keep", "separate", "join")
TIME_LIMIT = 120


class Pair:
    def __init__(self, seed):
        self.random = random = np.random.default_rng(seed)
        self.radii, self.gap = random.uniform(2, 6, 2), random.uniform(-1, 3)
        self.angle = np.radians(random.uniform(0, 90))
        self.across = digitised.unit(random.normal(size=3))
        turn = random.uniform(0, 2 * np.pi)
        middle = (SIZE - 1) / 2 + random.uniform(-0.5, 0.5, 3)
        self.kinds, self.inside, self.middle = [], [], middle
        places = np.stack(np.meshgrid(*[np.arange(SIZE)] * 3, indexing="ij"), -1).astype(float)
        for k, sign in enumerate((-1, 1)):
            centre = middle + sign * (self.radii[k] + 0.5 * self.gap) * self.across
            way = digitised.across(self.across, turn + k * self.angle)
            self.inside.append(self.vessel(places - centre, way, sign * self.across, self.radii[k]))
        self.bridge = None
        if self.gap >= 1 and not self.touch() and random.random() < 0.5:
            self.add_bridge(int(random.integers(1, 3)))
        self.object = self.inside[0] | self.inside[1]
        if self.bridge is not None:
            self.object = self.object | self.bridge

    def vessel(self, from_centre, way, away, radius):
        kind = self.random.choice(["straight", "bent away", "bent sideways"])
        half = self.random.uniform(12, 18) if self.random.random() < 0.3 else 1e9
        self.kinds.append(kind + (", capsule" if half < 1e9 else ""))
        if kind == "straight":
            beyond = np.maximum(np.abs(from_centre @ way) - half, 0)
            off = from_centre - (from_centre @ way)[..., None] * way
            return np.hypot(np.linalg.norm(off, axis=-1), beyond) <= radius
        bend = self.random.uniform(max(12, 2 * radius), 40)
        aside = away if kind == "bent away" else np.cross(way, away)
        from_axis = from_centre - bend * aside
        x, y, z = from_axis @ way, -(from_axis @ aside), from_axis @ np.cross(way, aside)
        most = min(half / bend, 0.75 * np.pi)
        angle = np.clip(np.arctan2(x, y), -most, most)
        return np.sqrt((x - bend * np.sin(angle)) ** 2 + (y - bend * np.cos(angle)) ** 2 + z ** 2) <= radius

    def add_bridge(self, thick):
        """From one vessel to the other, straight, voxels joined through faces."""
        reach = 0.5 * self.gap + 1.5
        voxels, last = [], None
        for step in np.linspace(-reach, reach, 200):
            voxel = np.round(self.middle + step * self.across - 0.5 * (thick - 1)).astype(int)
            if last is not None:
                for axis in range(3):
                    if voxel[axis] != last[axis]:
                        last = last.copy()
                        last[axis] = voxel[axis]
                        voxels.append(last)
            else:
                voxels.append(voxel)
            last = voxel
        self.bridge = np.zeros((SIZE,) * 3, bool)
        for voxel in voxels:
            self.bridge[tuple(slice(v, v + thick) for v in voxel)] = True
        self.thick = thick

    def touch(self):
        one, other = self.inside
        return bool((one & other).any() or (widened(one, 1, True) & other).any())

    def near(self):
        """An edge, a corner, or a voxel in a row between them."""
        one, other = self.inside
        return bool((widened(one, 1, False) & other).any() or (widened(widened(one, 1, True), 1, True) & other).any())

    def write(self, path):
        digitised.write_nrrd(path, self.object.astype(np.uint8), np.zeros(3), VOXEL_MM)

    def words(self):
        bridge = f", bridge of {self.thick}" if self.bridge is not None else ""
        return (f"radii {self.radii[0]:.1f} {self.radii[1]:.1f}, gap {self.gap:.2f}, {np.degrees(self.angle):.0f} degrees, "
                f"{' and '.join(self.kinds)}{bridge}")


def widened(voxels, reach, through_faces):
    wide = voxels.copy()
    for step in np.ndindex(3, 3, 3):
        shift = [s - 1 for s in step]
        if sum(map(abs, shift)) == 0 or (through_faces and sum(map(abs, shift)) > 1):
            continue
        there = tuple(slice(max(0, s), n + min(0, s)) for s, n in zip(shift, voxels.shape))
        here = tuple(slice(max(0, -s), n + min(0, -s)) for s, n in zip(shift, voxels.shape))
        wide[there] |= voxels[here]
    return wide


def voxel_pieces(voxels):
    number = np.full(voxels.shape, -1)
    number[voxels] = np.arange(voxels.sum())
    joined = []
    for axis in range(3):
        a, b = np.moveaxis(number, axis, 0)[:-1], np.moveaxis(number, axis, 0)[1:]
        both = (a >= 0) & (b >= 0)
        joined.append(np.stack([a[both], b[both]], 1))
    return int(medit.pieces(np.concatenate(joined), int(voxels.sum())).max()) + 1


class Asked:
    """Results: (what, good or not)."""

    def __init__(self, program, name, folder, image):
        self.program, self.name, self.folder, self.image, self.results, self.told = program, name, folder, image, [], {}

    def note(self, what, good, words=""):
        self.results.append((what, bool(good)))
        if not good:
            print(f"{self.name}: {what}: {words}", file=sys.stderr, flush=True)

    def lumesh(self, *words):
        command = [self.program, *map(str, words)] + (["--threads", "1"] if words[0] != "convert" else [])
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=TIME_LIMIT, cwd=self.folder, check=False)
        except subprocess.TimeoutExpired:
            return "time", "", ""
        return done.returncode, done.stdout, done.stderr

    def changes(self, choice, errors, more, voxel_mm3):
        """Whether what `info` counts has changed as its warning says."""
        told = [(int(n), float(v)) for n, v in re.findall(r"(\d+) voxels?, (\S+) mm[^a-z]*, between", errors)]
        voxels, volume = sum(n for n, _ in told), sum(v for _, v in told)
        good = voxels == abs(more) and abs(volume - voxels * voxel_mm3) <= 0.006 * volume
        self.note(f"info, {choice}: changed as told", good, f"{more:+d} voxels, told {told}")

    def judge(self, what, path, code, errors, pieces=None):
        """The mesh, if there is one."""
        is_thin = code == 3 and "of the area has layers" in errors  # There is no room for layers on half of the area: as documented.
        self.note(f"{what}: exit code", code == 0 or is_thin, f"exit {code} {errors.strip()[-300:]}")
        if not path.exists():
            return None
        mesh = medit.Mesh(path)
        faults = medit.faults(mesh)
        self.note(f"{what}: valid", not faults, "; ".join(faults))
        if pieces is not None:
            here = medit.components(mesh)
            self.note(f"{what}: pieces", here == pieces, f"{here}, not {pieces}; {errors.strip() or 'silent'}")
            if not what.startswith("adapt"):  # It does not see the voxels.
                self.note(f"{what}: other pieces told", here == pieces or "label in the mesh differs" in errors)
        return mesh

    def mesh(self, mesher, choice):
        path, text = self.folder / f"{mesher}-{choice}.vtu", self.folder / f"{mesher}-{choice}.mesh"
        code, _, errors = self.lumesh(mesher, self.image, "--touching", choice, "-o", path)
        if path.exists():
            self.lumesh("convert", path, text)
        return self.judge(f"{mesher}, {choice}", text, code, errors, self.expected.get(choice))


class ImageTrial(Asked):
    def all(self, meshers):
        code, said, errors = self.lumesh("check", self.image, "--json")
        self.note("check ends", code in (0, 3), f"exit {code} {errors}")
        if code in (0, 3):
            found = {f["kind"]: f["count"] for f in json.loads(said)["findings"]}
            print(f"{self.name}: check finds {found}", file=sys.stderr, flush=True)
        self.expected, before = {}, 0
        for choice in CHOICES:
            code, said, errors = self.lumesh("info", self.image, "--touching", choice, "--json")
            self.note(f"info, {choice}: exit code", code == 0, f"exit {code} {errors}")
            if code != 0:
                continue
            info = json.loads(said)
            voxels = sum(label["voxels"] for label in info["labels"])
            before = voxels if choice == "keep" else before
            self.changes(choice, errors, voxels - before, float(np.prod(info["spacing_mm"])))
            if len(info["labels"]) == 1:
                self.expected[choice] = info["labels"][0]["components"]
            print(f"{self.name}, {choice}: {voxels - before:+d} voxels, {self.expected.get(choice)} pieces", file=sys.stderr, flush=True)
        for mesher in meshers:
            for choice in CHOICES:
                self.mesh(mesher, choice)
        return self.results


class Trial(Asked):
    """All that is asked of one pair."""

    def __init__(self, program, seed, folder):
        self.pair, self.seed = Pair(seed), seed
        super().__init__(program, f"{seed} ({self.pair.words()})", folder, folder / "pair.nrrd")
        self.pair.write(self.image)

    def all(self, meshers):
        self.look()
        counted = {choice: self.count(choice) for choice in CHOICES}
        for mesher in meshers:
            kept = None
            for choice in CHOICES:
                mesh = self.mesh(mesher, choice)
                if mesh is None:
                    continue
                volume = sum(mesh.volumes()[1].values())
                kept = volume if choice == "keep" else kept
                changed = (counted[choice] - counted["keep"]) * VOXEL_MM ** 3
                if kept is not None and choice != "keep":
                    self.note(f"{mesher}, {choice}: volume as changed", abs(volume - kept - changed) <= 0.1 * abs(changed) + 0.005 * kept,
                              f"{volume - kept:+.2f} mm3 of {kept:.1f}, voxels {changed:+.2f}")
        for choice in CHOICES[:2]:
            self.adapt(choice)
            self.layers("delaunay", choice, "inward")
        self.layers("lattice", "keep", "inward")
        self.layers("delaunay", "keep", "outward")
        return self.results

    def look(self):
        code, said, errors = self.lumesh("check", self.image, "--json")
        found = {f["kind"]: f for f in json.loads(said)["findings"]} if code in (0, 3) else {}
        self.found, pair = set(found) & {"touching", "near", "bridges"}, self.pair
        if code not in (0, 3):
            self.note("check ends", False, f"exit {code} {errors}")
        if pair.bridge is not None:
            centre = np.argwhere(pair.bridge).mean(0) * VOXEL_MM
            places = [p for kind in ("bridges", "touching") for p in found.get(kind, {}).get("places_mm", [])]
            nearest = min((np.linalg.norm(np.array(p) - centre) / VOXEL_MM for p in places), default=np.inf)
            self.note(f"check: bridge of {pair.thick} found", nearest <= 3, f"nearest finding {nearest:.1f} voxels away; {sorted(self.found)}")
        elif pair.touch():
            self.note("check: contact found", "touching" in found, f"found {sorted(self.found)}")
        elif pair.near():
            self.note("check: near vessels found, no contact", "near" in found and "touching" not in found, f"found {sorted(self.found)}")
        else:
            self.note("check: no contact found", not self.found & {"touching", "bridges"}, f"found {sorted(self.found)}")
        if pair.bridge is None and pair.gap > 2.5:
            self.note("check: nothing found at gaps above 2.5", not self.found, f"found {sorted(self.found)}")
        if pair.bridge is None:
            self.note("check: no bridge found where there is none", "bridges" not in found, f"{found.get('bridges', {}).get('places_mm')}")

    def count(self, choice):
        """Voxels by `info`; its warnings are kept."""
        code, said, errors = self.lumesh("info", self.image, "--touching", choice, "--json")
        if code != 0:
            self.note(f"info --touching {choice} ends", False, f"exit {code} {errors}")
            return 0
        label = json.loads(said)["labels"][0]
        self.told[choice], own = errors.strip(), int(self.pair.object.sum())
        more = label["voxels"] - own
        self.changes(choice, errors, more, VOXEL_MM ** 3)
        if choice == "separate":
            expected = sum(map(voxel_pieces, self.pair.inside)) if self.pair.bridge is None else None
            if not self.pair.touch():
                self.note("separate: nothing changed without contact", more == 0 or self.pair.bridge is not None,
                          f"{more:+d} voxels, found {sorted(self.found)}")
        elif choice == "join":
            specks = sum(voxel_pieces(one) - 1 for one in self.pair.inside)
            expected = 1 + specks if self.pair.bridge is not None or self.pair.touch() or self.pair.near() else None
            if self.pair.gap > 3 ** 0.5 + 1 and self.pair.bridge is None:
                self.note("join: nothing changed at gaps above 2.7", more == 0, f"{more:+d} voxels")
        else:
            expected = voxel_pieces(self.pair.object)
        if expected is not None:
            self.note(f"info, {choice}: pieces", label["components"] == expected, f"{label['components']}, not {expected}; told {self.told[choice]}")
        self.expected = getattr(self, "expected", {}) | {choice: label["components"]}
        return label["voxels"]

    def adapt(self, choice):
        mesh, metric, adapted = (self.folder / name for name in (f"delaunay-{choice}.vtu", "metric.vtu", f"adapted-{choice}.mesh"))
        if not mesh.exists():
            return
        code, said, errors = self.lumesh("metric", mesh, "--curvature", "-o", metric)
        if code != 0:
            self.note(f"metric, {choice}: exit code", False, errors)
            return
        complexity = 0.4 * float(re.search(r"complexity (\S+)", said)[1])
        options = ["--complexity", complexity] if self.seed % 2 else []
        code, _, errors = self.lumesh("adapt", metric, "--allow-pieces", *options, "-o", adapted)
        self.judge(f"adapt, {choice}", adapted, code, errors, self.expected.get(choice))

    def layers(self, mesher, choice, side):
        mesh, layered = self.folder / f"{mesher}-{choice}.vtu", self.folder / f"layers-{mesher}-{choice}-{side}.mesh"
        if not mesh.exists():
            return
        cells = "prisms" if self.seed % 2 else "tetrahedra"
        code, _, errors = self.lumesh("layers", mesh, "--side", side, "--first-height", 0.25 * VOXEL_MM, "--count", 3, "--cells", cells, "-o",
                                      layered)
        self.judge(f"layers {side}, {mesher}, {choice}", layered, code, errors)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("images", nargs="*", type=pathlib.Path, metavar="IMAGE", help="instead of pairs")
    parser.add_argument("--program", default=str(run.ROOT / "build/release/bin/lumesh"))
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--pairs", type=int, default=200)
    parser.add_argument("--mesher", default="delaunay,lattice")
    parser.add_argument("--time-limit", type=float, default=1e9, help="seconds after which no pair is begun")
    parser.add_argument("--keep", type=pathlib.Path, help="folder for all files of pairs and images with faults")
    arguments = parser.parse_args()
    start, counts, done = time.monotonic(), {}, 0
    program, meshers = str(pathlib.Path(arguments.program).resolve()), arguments.mesher.split(",")
    for one in arguments.images or range(arguments.first, arguments.first + arguments.pairs):
        if time.monotonic() - start > arguments.time_limit:
            break
        with tempfile.TemporaryDirectory() as name:
            if arguments.images:
                results = ImageTrial(program, one.name, pathlib.Path(name), one.resolve()).all(meshers)
            else:
                results = Trial(program, one, pathlib.Path(name)).all(meshers)
            if arguments.keep and not all(good for _, good in results):
                shutil.copytree(name, arguments.keep / str(one.name if arguments.images else one), dirs_exist_ok=True)
        done += 1
        for what, good in results:
            right, wrong = counts.setdefault(what, [0, []])
            counts[what] = [right + good, wrong if good else wrong + [one.name if arguments.images else one]]
    what = "images" if arguments.images else f"pairs, seeds from {arguments.first} on"
    print(f"{done} {what}, {time.monotonic() - start:.0f} s\n\n| what | of | good | those that are not |\n|---|---|---|---|")
    for what, (right, wrong) in counts.items():
        print(f"| {what} | {right + len(wrong)} | {right} | {' '.join(map(str, wrong[:20]))}{' …' if len(wrong) > 20 else ''} |")
    return 1 if any(wrong for _, wrong in counts.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
