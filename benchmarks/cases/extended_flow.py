#!/usr/bin/env python3
"""Steady flow with flow extensions at the outlets and without: does OpenFOAM's simpleFoam converge, and how far from developed is the
profile at the outlets?

Cases: the artery of the data (a surface with three open ends) and the phantom of a bifurcation, meshed by `lumesh delaunay`, without
layers; a plug profile at inlet_1, Reynolds number 150 there, pressure 0 at the outlets. At each outlet the speeds through its faces (flux over
area) are compared with

developed  the profile of Poiseuille's flow through this section, by linear finite elements on the outlet's triangles, with the same flux
parabola   that of a circle with the section's area around its centre, with the same flux

as root mean square over the area, over the mean speed. A markdown table on stdout. Exit status 1 if a run does not converge, mass is not kept
(1e-4), or an outlet's profile is not nearer to both with the extension.

Usage: extended_flow.py [--program PATH] [--data FOLDER] [--length 5r] [--edge-length MM] [--keep FOLDER] [CASE...]      CASE: artery, bifurcation
"""
import argparse
import os
import pathlib
import subprocess
import sys
import tempfile

DEBIAN_PYTHON = "/usr/bin/python3"  # It has numpy.
if __name__ == "__main__" and os.path.realpath(sys.executable) != os.path.realpath(DEBIAN_PYTHON) and os.access(DEBIAN_PYTHON, os.X_OK):
    os.execv(DEBIAN_PYTHON, [DEBIAN_PYTHON, *sys.argv])

import numpy as np  # noqa: E402

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import run  # noqa: E402  (ROOT)

sys.path.insert(0, str(run.ROOT / "tests/clients"))
import foam_case  # noqa: E402

REYNOLDS, RESIDUAL, MASS = 150, 1e-5, 1e-4
EDGES_MM = {"artery": 0.25, "bifurcation": 0.3}
OUTLETS = ("outlet_1", "outlet_2")


def developed(points, triangles):
    """Mean over each triangle of w with -div grad w = 1 and w = 0 at the rim, by linear elements."""
    used, corners = np.unique(triangles, return_inverse=True)
    corners, places = corners.reshape(-1, 3), points[used]
    edges = np.sort(corners[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    rim, times = np.unique(edges, axis=0, return_counts=True)
    is_free = np.ones(len(used), bool)
    is_free[rim[times == 1]] = False
    matrix, load = np.zeros((len(used),) * 2), np.zeros(len(used))
    for t in corners:
        a, b, c = places[t]
        normal = np.cross(b - a, c - a)
        area = 0.5 * np.linalg.norm(normal)
        across = np.stack([c - b, a - c, b - a])  # Turned by a right angle these are the gradients times 2 area.
        matrix[np.ix_(t, t)] += across @ across.T / (4 * area)
        load[t] += area / 3
    w = np.zeros(len(used))
    w[is_free] = np.linalg.solve(matrix[np.ix_(is_free, is_free)], load[is_free])
    return w[corners].mean(1)


def profile_errors(mesh, latest, patch):
    faces = list(mesh.patches[patch])
    centres, vectors = (np.array(x) for x in zip(*(mesh.centre_and_area(face) for face in faces)))
    areas, points = np.linalg.norm(vectors, axis=1), np.array(mesh.points)
    speeds = np.array([value[0] for value in foam_case.patch_values(latest / "phi", patch)]) / areas
    mean, centre = (speeds * areas).sum() / areas.sum(), (areas[:, None] * centres).sum(0) / areas.sum()
    away = ((centres - centre) ** 2).sum(1)
    shapes = {"developed": developed(points, np.array([mesh.faces[face] for face in faces])),
              "parabola": np.maximum(0, 1 - away * np.pi / areas.sum())}
    found = {"mean_m_s": float(mean), "back": float(areas[speeds < 0].sum() / areas.sum())}
    for name, shape in shapes.items():
        wanted = shape * mean / ((shape * areas).sum() / areas.sum())
        found[name] = float((((speeds - wanted) ** 2 * areas).sum() / areas.sum()) ** 0.5 / mean)
    return found


class Lumesh:
    def __init__(self, program):
        self.program = program

    def __call__(self, *words):
        done = subprocess.run([self.program, *map(str, words)], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise SystemExit(f"lumesh {' '.join(map(str, words))}: {done.stderr}")


def flow(lumesh, source, name, extension, edge_mm, folder):
    folder.mkdir(parents=True)
    options = ["--extend", ",".join(f"{outlet}={extension}" for outlet in OUTLETS)] if extension else []
    lumesh("delaunay", source, "-o", folder / "mesh.vtu", "--edge-length", edge_mm, "--threads", 1, *options)
    case = foam_case.Case(folder / "case")
    lumesh("convert", folder / "mesh.vtu", case.folder / "case.foam")
    mesh = foam_case.PolyMesh(case.folder)
    area = sum(foam_case.norm(mesh.centre_and_area(face)[1]) for face in mesh.patches["inlet_1"])
    mean = REYNOLDS * foam_case.BLOOD_M2_S / (2 * (area / np.pi) ** 0.5)
    checked = foam_case.check_mesh(case)
    found = foam_case.solve_flow(case, mesh, "inlet_1", lambda place: mean, residual=RESIDUAL, iterations=600, pressure=foam_case.MULTIGRID)
    latest = max((f for f in case.folder.iterdir() if f.name.isdigit()), key=lambda f: int(f.name))
    profiles = {outlet: profile_errors(mesh, latest, outlet) for outlet in OUTLETS}
    print(f"{name}, {extension or 'none'}: {checked['failed'] or 'Mesh OK'}, {profiles}", file=sys.stderr, flush=True)
    return found | {"cells": max(mesh.owner) + 1, "ok": checked["ok"], "profiles": profiles}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", nargs="*", metavar="CASE", help="artery, bifurcation; default: both")
    parser.add_argument("--program", default=str(run.ROOT / "build/release/bin/lumesh"))
    parser.add_argument("--data", type=pathlib.Path, default=run.ROOT.parent / "shared/data")
    parser.add_argument("--length", default="5r", help="of the extensions")
    parser.add_argument("--edge-length", type=float, help="mm; default: 0.25 of the artery, 0.3 of the bifurcation")
    parser.add_argument("--keep", type=pathlib.Path, help="folder for all cases")
    arguments = parser.parse_args()
    foam_case.require(parser, "checkMesh", "simpleFoam")
    unknown = set(arguments.cases) - set(EDGES_MM)
    if unknown:
        parser.error(f"no case {', '.join(sorted(unknown))}; there are {', '.join(EDGES_MM)}")
    lumesh, good = Lumesh(str(pathlib.Path(arguments.program).resolve())), True
    print("| case | extension | cells | checkMesh | steps, s | in - out | " +
          " | ".join(f"{outlet}: off developed, off a parabola, %" for outlet in OUTLETS) + " | |\n" + "|---" * 9 + "|")
    with tempfile.TemporaryDirectory(prefix="lumesh_flow_") as name:
        folder = arguments.keep or pathlib.Path(name)
        for kind in arguments.cases or EDGES_MM:
            source = arguments.data.resolve() / "vampy/artery.stl"
            if kind == "bifurcation":
                source = folder / "bifurcation.nrrd"
                source.parent.mkdir(parents=True, exist_ok=True)
                lumesh("phantom", "bifurcation", "-o", source)
            before = None
            for extension in (None, arguments.length):
                found = flow(lumesh, source, kind, extension, arguments.edge_length or EDGES_MM[kind], folder / f"{kind}-{extension or 'none'}")
                profiles = found["profiles"]
                faults = [] if found["converged"] else ["not converged"]
                faults += ["mass"] if found["mass_error"] > MASS else []
                faults += [f"{outlet} is not nearer" for outlet in OUTLETS if before and any(
                    profiles[outlet][shape] >= before[outlet][shape] for shape in ("developed", "parabola"))]
                before, good = profiles, good and not faults
                cells = [kind, extension or "none", f"{found['cells']:,}", "ok" if found["ok"] else "**not ok**",
                         f"{found['iterations']}, {found['seconds']:.0f}", f"{found['mass_error']:.0e}",
                         *(f"{100 * profiles[o]['developed']:.1f}, {100 * profiles[o]['parabola']:.1f}" for o in OUTLETS),
                         f"**{', '.join(faults)}**" if faults else ""]
                print("| " + " | ".join(cells) + " |", flush=True)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
