#!/usr/bin/env python3
"""How well meshes adapted to a velocity carry it: error of its linear interpolation between the vertices, at equal complexity, in a
straight tube of radius 1 and length 6 with three flows known by formula:

poiseuille  1 - r^2 along the axis
blunt       1 - r^8: a thin layer at the wall
bend        Poiseuille's, faster on one side, with two vortices across, as in bends

20,000 random samples. Of each mesh: root mean square of the error over that of the velocity; the error that 1 in 1000 tetrahedra exceeds;
root mean square of the error of the wall's shear stress (the normal derivative in the tetrahedra on the wall) over the exact stress, where
it is the same everywhere. A line each on stderr, JSON on stdout.

Usage: velocity.py [--program PATH] [--complexity C] [--options "..."]...   The options are those of `lumesh metric`; several are compared.
"""
import argparse
import json
import math
import os
import pathlib
import shlex
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import run  # noqa: E402  (measure() and ROOT)

sys.path.insert(0, str(run.ROOT / "tests/cli"))
sys.path.insert(0, str(run.ROOT / "tests/clients"))
import cube  # noqa: E402  (read_medit())
import tubes  # noqa: E402

DEBIAN_PYTHON = "/usr/bin/python3"  # It has numpy.
LENGTH, RINGS, SLICES, SAMPLES, PLACES_IN_TET = 6, 10, 40, 20000, 24


def flows(np):
    """Velocity by place, and the stress at the wall where it is one number."""
    def along(speed):
        return np.stack([0 * speed, 0 * speed, speed], -1)

    def bend(x):
        speed = np.maximum(0, 1 - x[..., 0] ** 2 - x[..., 1] ** 2)
        return np.stack([0.3 * speed * (1 - 3 * x[..., 1] ** 2 - x[..., 0] ** 2), 0.6 * speed * x[..., 0] * x[..., 1],
                         speed * (1 + 0.7 * x[..., 0])], -1)

    def radius(x):
        return np.hypot(x[..., 0], x[..., 1])

    return {"poiseuille": (lambda x: along(np.maximum(0, 1 - radius(x) ** 2)), 2), "blunt": (lambda x: along(np.maximum(0, 1 - radius(x) ** 8)), 8),
            "bend": (bend, None)}


def outer_faces(np, tets):
    """Faces of one tetrahedron only, and that tetrahedron."""
    faces = np.concatenate([tets[:, [1, 2, 3]], tets[:, [0, 3, 2]], tets[:, [0, 1, 3]], tets[:, [0, 2, 1]]])
    _, first, count = np.unique(np.sort(faces, 1), axis=0, return_index=True, return_counts=True)
    return faces[first[count == 1]], first[count == 1] % len(tets)


def errors(np, mesh, flow, stress):
    points, tets, _ = cube.read_medit(mesh)
    points, tets = np.array(points), np.array(tets)[:, :4] - 1
    corners, values = points[tets], flow(points)
    volumes = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6
    weights = np.random.default_rng(1).dirichlet([1] * 4, PLACES_IN_TET)
    exact = flow(np.einsum("qb,nbi->nqi", weights, corners))
    off = np.linalg.norm(np.einsum("qb,nbi->nqi", weights, values[tets]) - exact, axis=2)
    mean_speed = math.sqrt((volumes * (exact ** 2).sum(2).mean(1)).sum() / volumes.sum())
    found = {"tetrahedra": len(tets), "rms": math.sqrt((volumes * (off ** 2).mean(1)).sum() / volumes.sum()) / mean_speed,
             "p99_9": float(np.quantile(off.max(1), 0.999)) / mean_speed}
    if stress:
        faces, of = outer_faces(np, tets)
        wall = (np.hypot(points[faces, 0], points[faces, 1]) > 0.98).all(1)
        faces, of = faces[wall], of[wall]
        normals = np.cross(points[faces[:, 1]] - points[faces[:, 0]], points[faces[:, 2]] - points[faces[:, 0]])
        areas = np.linalg.norm(normals, axis=1)
        gradients = np.linalg.solve(corners[of][:, 1:] - corners[of][:, :1], values[tets[of]][:, 1:] - values[tets[of]][:, :1])
        stresses = np.linalg.norm(np.einsum("ni,nik->nk", normals / areas[:, None], gradients), axis=1)
        found["stress"] = math.sqrt((areas * (stresses / stress - 1) ** 2).sum() / areas.sum())
    return found


def main():
    import numpy as np
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(run.ROOT / "build/release/bin/lumesh"))
    parser.add_argument("--complexity", type=float, default=1500)
    parser.add_argument("--options", action="append", default=[])
    arguments = parser.parse_args()
    random, results = np.random.default_rng(3), []
    places = random.uniform(-1, 1, (2 * SAMPLES, 3))
    places = places[np.hypot(places[:, 0], places[:, 1]) < 1][:SAMPLES] * [1, 1, LENGTH / 2] + [0, 0, LENGTH / 2]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        tube, samples, sized, adapted = (str(folder / f) for f in ("tube.msh", "samples.csv", "metric.vtu", "adapted.mesh"))
        tubes.write_tube_mesh(tube, 1, LENGTH, RINGS, SLICES)
        for flow, (velocity, stress) in flows(np).items():
            np.savetxt(samples, np.concatenate([places, velocity(places)], 1), delimiter=",", header="x,y,z,u,v,w", comments="")
            for options in arguments.options or [""]:
                run.measure([arguments.program, "metric", tube, "--velocity", samples, *shlex.split(options), "--complexity",
                             str(arguments.complexity), "-o", sized])
                run.measure([arguments.program, "adapt", sized, "--complexity", str(arguments.complexity), "-o", adapted])
                found = {"flow": flow, "options": options} | errors(np, adapted, velocity, stress)
                results.append(found)
                print("{flow:10} {options:40} {tetrahedra} tetrahedra, rms {rms:.5f}, 99.9 % {p99_9:.4f}".format(**found) +
                      (f", stress {found['stress']:.4f}" if stress else ""), file=sys.stderr, flush=True)
    json.dump(results, sys.stdout, indent=1)
    print()


if __name__ == "__main__":
    if os.path.realpath(sys.executable) != os.path.realpath(DEBIAN_PYTHON) and os.access(DEBIAN_PYTHON, os.X_OK):
        os.execv(DEBIAN_PYTHON, [DEBIAN_PYTHON, *sys.argv])
    main()
