#!/usr/bin/env python3
"""Openings where vessels leave an image, against the vessels' true sections there.

Beyond its border an image says nothing, so that a section there is the least certain of all. Two kinds of truth:

- vessels known by formula, of 2.5 to 8 voxels in radius (walls: lumen), that leave an image of 64^3 voxels through one face, up to 35 degrees
  off square: straight, tapering, bent (to 4 to 10 of their radii), straight for 2 to 15 voxels after a bend, and bent with a wall around a lumen
  without a label; narrowing or widening by 10 to 40 % within 0.5 to 2 radii of the border, with a throat by as much there or up to 1.75
  radii further in, and round ends that begin from one radius behind the border to three quarters of one before it;
- label images, whole, from their files: cut in two by planes of voxel faces, and the openings of one half against the section there
  of the smooth boundary of the whole image (`--cut-plane`), which knows what lies on both sides. The whole one's error there is that of
  any section inside.

Prints, for each kind, how many openings, and the errors of their areas in per cent of the true ones: mean, r.m.s., median
size, worst, and which that is; and how many of those more than 10 % off a warning names, and of those less than 5 %. Needs numpy.

Usage: border_openings.py [--program PATH] [--first SEED] [--vessels N] [--radii LEAST MOST] [--planes N] [--image FILE.nrrd ...]
"""
import argparse
import json
import math
import pathlib
import sys
import tempfile

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import run  # noqa: E402  (ROOT)
from digitised import across, unit, write_nrrd  # noqa: E402
from extensions import Lumesh, read_nrrd  # noqa: E402

KINDS = ("straight", "tapering", "bent", "bent further in", "bent wall", "narrowing", "widening", "throat", "round end")
WRONG, RIGHT = 10, 5  # Per cent.
SIZE = 64  # Voxels.
STEPS = 10  # Samples a voxel's edge, for the true section.
LEAST_RADIUS = 2.0  # Voxels, of openings of images.
DATA = run.ROOT.parent / "shared/data"
IMAGES = [DATA / "aneurism/aneurism_label_t37.nrrd", DATA / "aneurism/aneurism_x2_smooth_label_t37.nrrd"]


class Vessel:
    """Leaves the image through its face of highest x."""

    def __init__(self, kind, seed, radii):
        draw = np.random.default_rng(seed)
        self.kind, self.radius = kind, draw.uniform(*radii)
        tilt, turn = math.radians(draw.uniform(0, 35)), draw.uniform(0, 2 * math.pi)
        self.tilt = math.degrees(tilt)
        self.along = np.array([math.cos(tilt), math.sin(tilt) * math.cos(turn), math.sin(tilt) * math.sin(turn)])
        self.end = np.array([SIZE - 0.5, SIZE / 2 + draw.uniform(-3, 3), SIZE / 2 + draw.uniform(-3, 3)])
        self.taper = draw.uniform(-0.06, 0.06) if kind == "tapering" else 0.0
        self.bend = draw.uniform(4, 10)
        while True:  # The axis lies on a circle, of which the quarter inside the image ends well inside.
            self.to_centre = across(self.along, draw.uniform(0, 2 * math.pi))
            if (self.along - self.to_centre)[0] > 0.8:
                break
        self.wall = draw.uniform(1.6, 4) if kind == "bent wall" else 0.0
        self.straight_end = draw.uniform(2, 15) if kind == "bent further in" else 0.0
        self.change, self.within, self.depth = draw.uniform(0.1, 0.4), draw.uniform(0.5, 2), draw.uniform(-1, 0.75)

    def off_wall(self, points):
        """Distance to the axis less the radius; negative inside. Of a circle only what lies before the quarter's end."""
        off = points - self.end
        way = off @ self.along
        if not self.kind.startswith("bent"):
            from_axis = np.sqrt(np.maximum((off ** 2).sum(-1) - way ** 2, 0))
            return from_axis - np.maximum(self.radius_at(way), 0.5 if self.kind != "round end" else 0)
        way = np.minimum(way + self.straight_end, 0) if self.straight_end > 0 else way
        circle = self.bend * self.radius
        side = off @ self.to_centre
        out_of_plane = off @ np.cross(self.along, self.to_centre)
        off_wall = np.hypot(np.hypot(circle - side, way) - circle, out_of_plane) - self.radius
        return np.where(side < circle, off_wall, SIZE)

    def radius_at(self, way):
        """Radius of a straight vessel at places along its axis, 0 where that meets the border."""
        at = way / self.radius
        if self.kind in ("narrowing", "widening"):
            sign = 1 if self.kind == "widening" else -1
            return self.radius * (1 + sign * self.change * np.exp(np.minimum(at, 0) / self.within))
        if self.kind == "throat":
            return self.radius * (1 - self.change * np.exp(-((at + 1 + self.depth) / self.within) ** 2))
        if self.kind == "round end":
            return self.radius * np.sqrt(np.clip(1 - np.maximum(at + self.depth, 0) ** 2, 0, 1))
        return self.radius + self.taper * way

    def is_inside(self, points):
        off = self.off_wall(points)
        return (off >= 0) & (off < self.wall) if self.wall > 0 else off < 0

    def labels(self):
        axis = np.arange(float(SIZE))
        return self.is_inside(np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1)).astype(np.uint8)

    def section(self):
        """Its area in the border's plane."""
        axis = (np.arange(SIZE * STEPS) + 0.5) / STEPS - 0.5
        y, z = np.meshgrid(axis, axis, indexing="ij")
        return float(self.is_inside(np.stack([np.full_like(y, SIZE - 0.5), y, z], -1)).sum()) / STEPS ** 2

    def __str__(self):
        bend = f", bent to {self.bend:.1f} radii" if self.kind.startswith("bent") else ""
        return f"radius {self.radius:.1f}, {self.tilt:.0f} degrees off{bend}"


def openings_of(lumesh, image, normal, *options):
    """Those that look that way, and whether a warning names one of them."""
    said, warnings, _ = lumesh("info", image, "--json", *options)
    found = [o for o in json.loads(said)["openings"] if np.dot(o["normal"], normal) > 0.9]
    return found, any(o["name"] + " " in warning for o in found for warning in warnings)


class Errors:
    def __init__(self):
        self.of = {}

    def add(self, kind, error, what, is_told=False):
        self.of.setdefault(kind, []).append((100 * error, what, is_told))

    def print(self):
        print(f"{'kind':32}{'count':>6}{'mean':>8}{'r.m.s.':>8}{'median':>8}{'worst':>8}{'told, wrong':>13}{'right':>10}  which")
        for kind, rows in self.of.items():
            e = np.array([row[0] for row in rows])
            worst = int(np.abs(e).argmax())
            told = np.array([row[2] for row in rows])
            wrong, right = np.abs(e) > WRONG, np.abs(e) < RIGHT
            shares = f"{f'{(told & wrong).sum()}/{wrong.sum()}':>13}{f'{(told & right).sum()}/{right.sum()}':>10}"
            print(f"{kind:32}{len(e):6}{e.mean():8.2f}{math.sqrt((e ** 2).mean()):8.2f}{np.median(np.abs(e)):8.2f}{e[worst]:8.2f}"
                  f"{shares}  {rows[worst][1]}")


def measure_vessels(lumesh, first, count, radii, errors):
    for kind in KINDS:
        for seed in range(first, first + count):
            vessel = Vessel(kind, seed, radii)
            path = lumesh.folder / "vessel.nrrd"
            write_nrrd(path, vessel.labels(), (0, 0, 0))
            found, is_told = openings_of(lumesh, path, (1, 0, 0))
            area = sum(o["area_mm2"] for o in found)
            errors.add(kind, area / vessel.section() - 1, f"seed {seed}: {vessel}", is_told)


def measure_image(lumesh, image, first, count, errors):
    labels, voxel_mm = read_nrrd(image)
    draw = np.random.default_rng(first)
    whole, path = lumesh.folder / "whole.nrrd", lumesh.folder / "half.nrrd"
    write_nrrd(whole, labels, (0, 0, 0), voxel_mm)
    for _ in range(count):
        axis = int(draw.integers(3))
        used = np.flatnonzero((labels > 0).any(axis=tuple(a for a in range(3) if a != axis)))
        place = int(used[0] + len(used) * draw.uniform(0.2, 0.8))
        half = np.take(labels, range(place), axis)
        write_nrrd(path, half, (0, 0, 0), voxel_mm)
        normal = np.eye(3)[axis]
        plane = normal * (place - 0.5) * voxel_mm
        ones, _ = openings_of(lumesh, path, normal)
        for one in openings_of(lumesh, whole, normal, "--cut-plane", *plane, *normal)[0]:
            if one["radius_mm"] < LEAST_RADIUS * voxel_mm:
                continue
            gaps = [np.linalg.norm(np.subtract(o["centre_mm"], one["centre_mm"])) for o in ones]
            if gaps and min(gaps) < 0.5 * one["radius_mm"]:
                errors.add(image.stem, ones[int(np.argmin(gaps))]["area_mm2"] / one["area_mm2"] - 1,
                           f"axis {axis}, place {place}, radius {one['radius_mm'] / voxel_mm:.1f}")
            else:
                errors.add(image.stem + " (missing)", -1.0, f"axis {axis}, place {place}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(run.ROOT / "build/release/bin/lumesh"))
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--vessels", type=int, default=24, help="of each kind")
    parser.add_argument("--radii", type=float, nargs=2, default=(2.5, 8), metavar=("LEAST", "MOST"), help="voxels")
    parser.add_argument("--planes", type=int, default=12, help="of each image; 0: none")
    parser.add_argument("--image", type=pathlib.Path, action="append", help="label images, cubic voxels (.nrrd)")
    options = parser.parse_args()
    errors = Errors()
    with tempfile.TemporaryDirectory() as folder:
        lumesh = Lumesh(str(pathlib.Path(options.program).resolve()), pathlib.Path(folder))
        measure_vessels(lumesh, options.first, options.vessels, options.radii, errors)
        for image in (options.image or [i for i in IMAGES if i.exists()]) if options.planes else ():
            measure_image(lumesh, image, options.first, options.planes, errors)
    errors.print()


if __name__ == "__main__":
    main()
