#!/usr/bin/env python3
"""Walls of meshes where they meet the image's border at small angles, against the formula.

Random round tubes of 2.5 to 20 voxels in radius, through images 4.5 radii wide: most leave through several faces or an edge of the
image, and some graze one. Each is meshed with elements of 0.25 and 0.4 radii. Of the wall's triangles: how many stand at more
than 40, 60 (steep) and 90 degrees (folded) to the tube's own wall, and how far the furthest vertex is off it. Lists the meshes
with steep triangles, with the place of the worst. Needs numpy.

Usage: oblique_walls.py [--program PATH] [--mesher lattice|delaunay] [--first SEED] [--tubes N]
"""
import argparse
import pathlib
import sys
import tempfile

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import run  # noqa: E402  (ROOT)
from digitised import unit, write_nrrd  # noqa: E402
from extensions import Lumesh  # noqa: E402
from random_openings import Mesh  # noqa: E402

RADII, SHARES = (2.5, 4, 7, 12, 20), (0.25, 0.4)


class Tube:
    """Around an axis through a point of an image of voxels of 1 mm; as a scene, of which Mesh wants the frame."""

    origin_mm, frame, voxel_mm = np.zeros(3), np.eye(3), 1.0

    def __init__(self, seed):
        draw = np.random.default_rng(seed)
        self.radius = draw.choice(RADII)
        self.size = int(max(24, 4.5 * self.radius))
        self.axis = unit(draw.normal(size=3))
        self.centre = (self.size - 1) / 2 + draw.uniform(-0.25, 0.25, 3) * self.size

    def from_axis(self, points):
        off = points - self.centre
        return off - (off @ self.axis)[..., None] * self.axis

    def labels(self):
        axis = np.arange(float(self.size))
        points = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1)
        return (np.linalg.norm(self.from_axis(points), axis=-1) < self.radius).astype(np.uint8)


def look_at_wall(tube, mesh):
    """Angles of the wall's triangles to the tube's in degrees, their centres, and the furthest vertex in voxels."""
    is_wall = np.array([p["kind"] == "wall" for p in mesh.patches])[mesh.patch_of]
    outwards = tube.from_axis(mesh.centres[is_wall])
    lengths = mesh.areas[is_wall] * np.linalg.norm(outwards, axis=1)
    angles = np.degrees(np.arccos(np.clip((mesh.normals[is_wall] * outwards).sum(1) / lengths, -1, 1)))
    vertices = mesh.points[np.unique(mesh.triangles[is_wall])]
    return angles, mesh.centres[is_wall], np.abs(np.linalg.norm(tube.from_axis(vertices), axis=1) - tube.radius).max()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(run.ROOT / "build/release/bin/lumesh"))
    parser.add_argument("--mesher", default="lattice", choices=("lattice", "delaunay"))
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--tubes", type=int, default=75)
    arguments = parser.parse_args()
    steep, worst, furthest = np.zeros(3, int), [], []
    with tempfile.TemporaryDirectory() as folder:
        image, path = pathlib.Path(folder) / "tube.nrrd", pathlib.Path(folder) / "tube.mesh"
        lumesh = Lumesh(arguments.program, folder)
        for seed in range(arguments.first, arguments.first + arguments.tubes):
            tube = Tube(seed)
            write_nrrd(image, tube.labels(), np.zeros(3))
            for share in SHARES:
                lumesh(arguments.mesher, image, "-o", path, "--edge-length", share * tube.radius, allowed=(0, 3))
                angles, centres, off = look_at_wall(tube, Mesh(path, tube))
                steep += [(angles > limit).sum() for limit in (40, 60, 90)]
                worst.append(angles.max())
                furthest.append(off)
                if worst[-1] > 60:
                    print(f"seed {seed}, radius {tube.radius:g}, elements {share} radii: {worst[-1]:.0f} degrees at "
                          f"{np.round(centres[angles.argmax()], 1)}, a vertex {off:.2f} voxels off", flush=True)
    worst, furthest = np.array(worst), np.array(furthest)
    print(f"{len(worst)} meshes: {(worst > 60).sum()} with steep triangles, {(worst > 90).sum()} with folded ones, {(furthest > 1).sum()} with a "
          f"vertex more than a voxel off; triangles beyond 40, 60, 90 degrees: {steep[0]}, {steep[1]}, {steep[2]}; the median mesh's worst "
          f"{np.median(worst):.0f} degrees")


if __name__ == "__main__":
    main()
