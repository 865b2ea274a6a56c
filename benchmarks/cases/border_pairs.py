#!/usr/bin/env python3
"""Openings of pairs of vessels that leave an image side by side, or part a little before its border.

Tubes of 1.7 to 4 voxels in radius, up to 43 degrees off square, leave an image of 37 x 37 x 28 voxels through one face, their walls 0.8 to 4
voxels apart there. Half of the pairs are forks: the second tube begins at the axis of the first, 6 to 12 voxels before the border. Images hold
0.5 + depth / 2, cut off at 0 and 1 (`--threshold 0.5`), or with --labels what is inside only. Truth: pi R^2 / cos.

Prints, by the gap between the walls at the border and for forks apart, how many openings there are, the errors of their areas in per cent of
the true ones: r.m.s. (an error counts as 30 % at most), worst; and how many are missing, as both vessels have one. Needs numpy.

With --beyond N the image goes on for N voxels behind the border, where a plane cuts it instead.

Usage: border_pairs.py [--program PATH] [--first SEED] [--pairs N] [--labels] [--beyond N]
"""
import argparse
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import run  # noqa: E402  (ROOT)

sys.path.insert(0, str(run.ROOT / "tests/cli"))
import nrrd  # noqa: E402

SHAPE = (37, 37, 28)  # Voxels along x, y and z.
END = SHAPE[2] - 0.5  # The border, in voxels.
GAPS = ((0.8, 1.5), (1.5, 2.5), (2.5, math.inf))
HEADER = {"space directions": "(1,0,0) (0,1,0) (0,0,1)", "space origin": "(0,0,0)"}
MOST = 30  # Per cent that an error counts as.


class Tube:
    def __init__(self, centre, axis, radius):
        self.centre, self.axis, self.radius = centre, axis / np.linalg.norm(axis), radius
        self.begin = -math.inf  # Along the axis, from the centre of the section at the border.

    def depth(self, points):
        off = points - self.centre
        along = np.maximum(off @ self.axis, self.begin)
        return self.radius - np.linalg.norm(off - along[..., None] * self.axis, axis=-1)

    def outline(self):
        """Points of the wall in the border's plane."""
        turn = np.linspace(0, 2 * math.pi, 120, endpoint=False)
        out = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
        low, high = np.zeros(len(turn)), np.full(len(turn), 12.0)
        for _ in range(40):
            middle = (low + high) / 2
            inside = self.depth(self.centre + middle[:, None] * out) > 0
            low, high = np.where(inside, middle, low), np.where(inside, high, middle)
        return self.centre + low[:, None] * out

    def area(self):
        return math.pi * self.radius**2 / self.axis[2]


def direction(draw):
    tilt, turn = draw.uniform(0, 0.75), draw.uniform(0, 2 * math.pi)
    return np.array([math.sin(tilt) * math.cos(turn), math.sin(tilt) * math.sin(turn), math.cos(tilt)])


def pair_of(seed):
    """Two tubes, the gap between them at the border, and whether they are a fork; None if they do not suit."""
    draw = np.random.default_rng(seed)
    radii = draw.uniform(1.7, 4, 2)
    first = np.array([*(18 + draw.uniform(-0.5, 0.5, 2)), END])
    turn = draw.uniform(0, 2 * math.pi)
    second = first + (1.1 * radii.sum() + draw.uniform(0.8, 4)) * np.array([math.cos(turn), math.sin(turn), 0])
    tubes = [Tube(first, direction(draw), radii[0]), Tube(second, direction(draw), radii[1])]
    is_fork = draw.random() < 0.5
    if is_fork:
        fork = first - draw.uniform(6, 12) / tubes[0].axis[2] * tubes[0].axis
        tubes[1] = Tube(second, second - fork, radii[1])
        tubes[1].begin = -np.linalg.norm(second - fork)
    outlines = [tube.outline() for tube in tubes]
    gap = np.linalg.norm(outlines[0][:, None] - outlines[1][None], axis=2).min()
    overlap = (tubes[1].depth(outlines[0]) > 0).any()
    reach = np.abs(np.concatenate(outlines)[:, :2] - 18).max()
    if overlap or gap < GAPS[0][0] or reach > 15 or min(tube.axis[2] for tube in tubes) < 0.6:
        return None
    return tubes, gap, is_fork


def areas_of(arguments, tubes, folder):
    """Area of the opening nearest to each tube's section; None where another one is nearer to that."""
    shape = (*SHAPE[:2], SHAPE[2] + arguments.beyond)
    points = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1).astype(float)
    depth = np.maximum(tubes[0].depth(points), tubes[1].depth(points))
    values = (depth >= 0).astype("u1") if arguments.labels else np.clip(0.5 + 0.5 * depth, 0, 1).astype("f4")
    image = folder / "pair.nrrd"
    nrrd.write(image, shape, values.flatten(order="F").tolist(), kind="uint8" if arguments.labels else "float", header=HEADER)
    options = [] if arguments.labels else ["--threshold", "0.5"]
    if arguments.beyond:
        options += ["--cut-plane", "18", "18", str(END), "0", "0", "1"]
    done = subprocess.run([arguments.program, "info", image, "--json", *options], capture_output=True, text=True, check=True)
    openings = [(np.array(o["centre_mm"]), o["area_mm2"]) for o in json.loads(done.stdout)["openings"] if o["normal"][2] > 0.9]
    found = []
    for i, tube in enumerate(tubes):
        nearest = min(openings, key=lambda o: np.linalg.norm(o[0] - tube.centre), default=None)
        is_own = nearest and np.linalg.norm(nearest[0] - tube.centre) < np.linalg.norm(nearest[0] - tubes[1 - i].centre)
        found.append(nearest[1] if is_own and len(openings) > 1 else None)
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(run.ROOT / "build/release/bin/lumesh"))
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--pairs", type=int, default=200)
    parser.add_argument("--labels", action="store_true")
    parser.add_argument("--beyond", type=int, default=0)
    arguments = parser.parse_args()
    errors, missing = {}, {}
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(arguments.first, arguments.first + arguments.pairs):
            if (pair := pair_of(seed)) is None:
                continue
            tubes, gap, is_fork = pair
            which = next(i for i, (low, high) in enumerate(GAPS) if low <= gap < high), is_fork
            for tube, area in zip(tubes, areas_of(arguments, tubes, pathlib.Path(folder))):
                if area is None:
                    missing[which] = missing.get(which, 0) + 1
                else:
                    errors.setdefault(which, []).append(100 * (area / tube.area() - 1))
    for which in sorted(errors.keys() | missing.keys(), key=lambda w: (w[1], w[0])):
        all_errors = np.array(errors.get(which, [0]))
        low, high = GAPS[which[0]]
        rms = math.sqrt((np.minimum(np.abs(all_errors), MOST) ** 2).mean())
        print(f"{'forks' if which[1] else 'pairs'}, gap {low} to {high}: {len(all_errors)} openings, r.m.s. {rms:.1f} %, worst "
              f"{all_errors[np.abs(all_errors).argmax()]:+.0f} %, {missing.get(which, 0)} missing")


if __name__ == "__main__":
    main()
