#!/usr/bin/env python3
"""Sections of branches behind their mouths in a thick trunk, against the formula.

Labels of round trunks with a round branch square to them, both turned and placed at random. A cut plane across the branch gives the
section of the smooth boundary there (`lumesh info --cut-plane`): errors of areas in per cent of the branch's own, by the distance from
the trunk's wall in voxels, mean and worst of all seeds; and how many voxels the label has between 1 and 4 voxels from the wall, in per
cent of the volume. Needs numpy.

Usage: branch_mouths.py [--program PATH] [--trunk R] [--branches R ...] [--first SEED] [--images N]
"""
import argparse
import json
import pathlib
import sys
import tempfile

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import run  # noqa: E402  (ROOT)
from digitised import across, unit, write_nrrd  # noqa: E402
from extensions import Lumesh  # noqa: E402

DISTANCES = (1, 1.5, 2, 3, 4, 6)  # Voxels.


class Mouth:
    def __init__(self, seed, trunk, branch):
        draw = np.random.default_rng(seed)
        self.trunk, self.branch = trunk, branch
        self.size = int(2 * trunk + 28)
        self.axis = unit(draw.normal(size=3))
        self.along = across(self.axis, draw.uniform(0, 2 * np.pi))
        self.base = self.size / 2 + draw.uniform(-0.5, 0.5, 3) - 0.5 * trunk * self.along

    def labels_and_surplus(self):
        """Labels [x, y, z], and by how much the voxels fill more than the branch from 1 to 4 voxels off the wall, in per cent."""
        axis = np.arange(float(self.size))
        off = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1) - self.base
        way = off @ self.along
        in_trunk = np.linalg.norm(off - (off @ self.axis)[..., None] * self.axis, axis=-1) < self.trunk
        in_branch = (way > 0) & (np.linalg.norm(off - way[..., None] * self.along, axis=-1) < self.branch)
        slab = (way > self.trunk + 1) & (way < self.trunk + 4) & in_branch
        surplus = 100 * (slab.sum() / (3 * np.pi * self.branch ** 2) - 1)
        return (in_trunk | in_branch).astype(np.uint8), surplus

    def section_error(self, lumesh, image, distance):
        place = self.base + (self.trunk + distance) * self.along
        out, _, _ = lumesh("info", image, "--json", "-", "--cut-plane", *place, *self.along, allowed=(0, 3))
        openings = json.loads(out)["openings"]
        area = min(openings, key=lambda o: np.linalg.norm(np.array(o["centre_mm"]) - place))["area_mm2"]
        return 100 * (area / (np.pi * self.branch ** 2) - 1)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(run.ROOT / "build/release/bin/lumesh"))
    parser.add_argument("--trunk", type=float, default=10)
    parser.add_argument("--branches", type=float, nargs="+", default=(2, 2.5, 3, 4))
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--images", type=int, default=8)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        image = pathlib.Path(folder) / "mouth.nrrd"
        lumesh = Lumesh(arguments.program, folder)
        for branch in arguments.branches:
            errors, surpluses = [], []
            for seed in range(arguments.first, arguments.first + arguments.images):
                mouth = Mouth(seed, arguments.trunk, branch)
                labels, surplus = mouth.labels_and_surplus()
                write_nrrd(image, labels, np.zeros(3))
                surpluses.append(surplus)
                errors.append([mouth.section_error(lumesh, image, distance) for distance in DISTANCES])
            errors = np.array(errors)
            by_distance = ", ".join(f"{d:g}: {m:.1f} ({w:.1f})" for d, m, w in zip(DISTANCES, errors.mean(0), errors.min(0)))
            print(f"branch of {branch:g} voxels, voxels {np.mean(surpluses):.1f} %; distance: mean (worst) %: {by_distance}", flush=True)


if __name__ == "__main__":
    main()
