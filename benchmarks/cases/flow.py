#!/usr/bin/env python3
"""Flow on meshes with boundary layers: what OpenFOAM and FEniCS make of them. A table on stderr, JSON on stdout; exit status 1 if
anything leaves its bounds. Parts whose program is missing are skipped, with a line that says so.

checkmesh  straight tube and bifurcation, prisms inwards and outwards: checkMesh says "Mesh OK."
heights    the first layer's height, from the points of the same meshes, against what was asked for
flow       simpleFoam on both with layers inwards: converges, and what flows in flows out
shear      Poiseuille flow through a tube with its wall's points on the cylinder: shear stress of the wall against 4 mu Q / (pi R^3), of
           simpleFoam on prisms and dolfinx on tetrahedra, with layers and without
stokes     dolfinx on layered tetrahedra of the bifurcation: volumes, areas, and what flows in flows out

Usage: flow.py [--program PATH] [PART...]
"""
import argparse
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import run  # noqa: E402  (ROOT)

sys.path.insert(0, str(run.ROOT / "tests/clients"))
import foam_case  # noqa: E402
import tubes  # noqa: E402

PARTS = ["checkmesh", "heights", "flow", "shear", "stokes"]
DEBIAN_PYTHON = "/usr/bin/python3"  # It has dolfinx.
REYNOLDS, SHEAR_REYNOLDS = 300, 100
LAYERS, FIRST_MM, GROWTH = 4, 0.05, 1.2
HEIGHTS = ["--first-height", FIRST_MM, "--growth", GROWTH, "--count", LAYERS]
TUBE_RADIUS_MM, TUBE_LENGTH_MM = 3, 24
SHEAR_LENGTH_MM, RINGS, SLICES = 18, 8, 40
STOKES_LENGTH_MM, STOKES_RINGS, STOKES_SLICES = 6, 5, 8


class Meshes:
    """What the parts share; each mesh is made when it is first asked for."""

    def __init__(self, program, folder):
        self.program, self.folder, self.cases = program, folder, {}

    def lumesh(self, *arguments):
        result = subprocess.run([self.program, *map(str, arguments)], capture_output=True, text=True, check=False)
        if result.returncode != 0:
            raise SystemExit(f"lumesh {' '.join(map(str, arguments))}: {result.stderr}")

    def bare(self, kind):
        """tube, bifurcation: of images; cylinder: points of the wall on it; small: a coarse bifurcation; short: a coarse cylinder."""
        mesh, image = self.folder / f"{kind}.vtu", self.folder / f"{kind}.nrrd"
        if mesh.exists():
            return mesh
        if kind in ("cylinder", "short"):
            sizes = (SHEAR_LENGTH_MM, RINGS, SLICES) if kind == "cylinder" else (STOKES_LENGTH_MM, STOKES_RINGS, STOKES_SLICES)
            tubes.write_tube_mesh(mesh.with_suffix(".msh"), TUBE_RADIUS_MM, *sizes)
            self.lumesh("convert", mesh.with_suffix(".msh"), mesh)
        elif kind == "small":
            self.lumesh("phantom", "bifurcation", "--size", 64, 64, 64, "--spacing", 0.4, "-o", image)
            self.lumesh("delaunay", image, "--delta", 0.8, "-o", mesh)
        else:
            if kind == "tube":
                tubes.write_tube_image(image, TUBE_RADIUS_MM, TUBE_LENGTH_MM, 0.25)
            else:
                self.lumesh("phantom", kind, "-o", image)
            self.lumesh("lattice", image, "-o", mesh, *(["--spacing", 0.7] if kind == "tube" else []))
        return mesh

    def layered(self, kind, side, cells, *heights):
        mesh = self.folder / f"{kind}_{side}_{cells}.vtu"
        if not mesh.exists():
            self.lumesh("layers", self.bare(kind), "--side", side, *(heights or HEIGHTS), "--cells", cells, "-o", mesh, "--json",
                        mesh.with_suffix(".json"))
        return mesh

    def case(self, kind, side=None):
        """A case of OpenFOAM, and its mesh."""
        if (kind, side) not in self.cases:
            mesh = self.layered(kind, side, "prisms") if side else self.bare(kind)
            case = foam_case.Case(self.folder / f"{kind}_{side}")
            self.lumesh("convert", mesh, case.folder / "case.foam")
            self.cases[kind, side] = case, foam_case.PolyMesh(case.folder)
        return self.cases[kind, side]


def check(meshes):
    for kind in ("tube", "bifurcation"):
        for side in ("inward", "outward"):
            case, _ = meshes.case(kind, side)
            found = foam_case.check_mesh(case)
            found.pop("said")
            bad = {} if found["ok"] else foam_case.where_bad(case.folder)
            complete = json.loads(meshes.layered(kind, side, "prisms").with_suffix(".json").read_text())["complete"]
            yield found | {"mesh": f"{kind}, {side}", "complete": complete, "where_bad": bad, "good": found["ok"]}, (
                "{said}; non-orthogonality {non_orthogonality_deg:.1f} deg, skewness {skewness:.2f}, aspect ratio "
                "{aspect_ratio:.1f}".format(said="Mesh OK" if found["ok"] else found["failed"], **found))


def spread(values):
    values = sorted(values)
    return {"least": values[0], "mean": sum(values) / len(values), "most": values[-1]}


def heights(meshes):
    whole = FIRST_MM * sum(GROWTH ** k for k in range(LAYERS))
    for kind in ("tube", "bifurcation"):
        for side in ("inward", "outward"):
            case, mesh = meshes.case(kind, side)
            stacks = foam_case.first_layer_heights(mesh, LAYERS)
            complete = [stack for stack in stacks if 1000 * min(stack[2]) > 0.98 * whole]
            area, all_area = sum(stack[0] for stack in complete), sum(stack[0] for stack in stacks)
            ratios = spread([1000 * height / FIRST_MM for stack in complete for height in stack[1]])
            near = sum(stack[0] for stack in complete if all(abs(1000 * height / FIRST_MM - 1) < 0.02 for height in stack[1])) / area
            good = 0.98 < ratios["least"] and ratios["most"] < 1.02 if kind == "tube" else near > 0.95
            yield {"mesh": f"{kind}, {side}", "ratios": ratios, "near": near, "complete": area / all_area, "good": good}, (
                f"first layer {ratios['least']:.3f} to {ratios['most']:.3f} of what was asked for, mean {ratios['mean']:.4f}; "
                f"{100 * near:.1f} % of complete columns' area within 2 %")


def inflow(mesh, reynolds, parabolic):
    """Speed into the inlet by place: a parabola, or the same everywhere."""
    inlet = next(name for name in mesh.patches if name.startswith("inlet"))
    faces = [mesh.centre_and_area(face) for name in (inlet, f"{inlet}_layer") for face in mesh.patches.get(name, [])]
    areas = [foam_case.norm(area) for _, area in faces]
    centre = [sum(a * c[i] for (c, _), a in zip(faces, areas)) / sum(areas) for i in range(3)]
    radius = math.sqrt(sum(areas) / math.pi)
    mean = reynolds * foam_case.BLOOD_M2_S / (2 * radius)

    def parabola(place):
        from_axis = foam_case.norm(foam_case.minus(place, centre))
        return 2 * mean * max(0, 1 - (from_axis / radius) ** 2)
    return inlet, radius, parabola if parabolic else lambda place: mean


def of_exact(ratios_and_areas):
    """Mean and spread of stresses over the exact one."""
    area = sum(a for _, a in ratios_and_areas)
    mean = sum(r * a for r, a in ratios_and_areas) / area
    deviation = math.sqrt(sum(a * (r - mean) ** 2 for r, a in ratios_and_areas) / area)
    ratios = [r for r, _ in ratios_and_areas]
    return {"mean": mean, "deviation": deviation, "least": min(ratios), "most": max(ratios)}


def in_words(shear):
    return "mean {mean:.4f}, standard deviation {deviation:.4f}, {least:.3f} to {most:.3f} of the exact stress".format(**shear)


def shear_in_the_middle(mesh, found, radius, length):
    """Stresses of the middle half of a tube's wall over 4 nu Q / (pi R^3); lengths in m."""
    exact = 4 * foam_case.BLOOD_M2_S * found["in_m3_s"] / (math.pi * radius ** 3)
    places = [mesh.centre_and_area(face) for face in mesh.patches["wall"]]
    return of_exact([(stress / exact, foam_case.norm(area)) for stress, (place, area) in zip(found["stresses_m2_s2"]["wall"], places)
                     if abs(2 * place[2] / length - 1) < 0.5])


def flow(meshes):
    for kind in ("tube", "bifurcation"):
        case, mesh = meshes.case(kind, "inward")
        inlet, radius, speed = inflow(mesh, REYNOLDS, kind == "tube")
        found = foam_case.solve_flow(case, mesh, inlet, speed)
        if kind == "tube":
            found["shear"] = shear_in_the_middle(mesh, found, radius, TUBE_LENGTH_MM / 1000)
        found.pop("stresses_m2_s2")
        good = found["converged"] and found["mass_error"] < 1e-6 and found["continuity"] < 1e-5
        words = ("converged in {iterations} iterations, {seconds:.0f} s; in - out {mass_error:.1e} of the flow, local continuity error "
                 "{continuity:.1e}".format(**found) if found["converged"] else "NOT converged")
        yield found | {"mesh": f"{kind}, inward", "reynolds": REYNOLDS, "good": good}, (
            words + (f"; wall's shear stress with R = {1000 * radius:.3f} mm: {in_words(found['shear'])}" if kind == "tube" else ""))


def shear_of_simple_foam(meshes):
    for side in (None, "inward"):
        case, mesh = meshes.case("cylinder", side)
        inlet, _, speed = inflow(mesh, SHEAR_REYNOLDS, True)
        found = foam_case.solve_flow(case, mesh, inlet, speed)
        shear = shear_in_the_middle(mesh, found, TUBE_RADIUS_MM / 1000, SHEAR_LENGTH_MM / 1000)
        found.pop("stresses_m2_s2")
        good = found["converged"] and (side is None or abs(shear["mean"] - 1) < 0.02)
        yield found | {"mesh": f"simpleFoam, {'prisms' if side else 'no layers'}", "shear": shear, "good": good}, in_words(shear)


def shear_of_dolfinx(meshes):
    from fenics_mesh import STABILISED, TAYLOR_HOOD, Stokes, TaggedMesh
    import numpy as np
    radius, length = TUBE_RADIUS_MM, STOKES_LENGTH_MM
    for mesh in (meshes.bare("short"), meshes.layered("short", "inward", "tetrahedra")):
        meshes.lumesh("convert", mesh, mesh.with_suffix(".xdmf"))
        tagged = TaggedMesh(mesh.with_suffix(".xdmf"))
        wall = next(entry["tag"] for entry in tagged.names["facet_tags"] if entry["name"] == "wall")
        for elements in (STABILISED, TAYLOR_HOOD):
            stokes = Stokes(tagged, lambda x: np.stack([0 * x[0], 0 * x[0], np.maximum(0, 2 - 2 * (x[0] ** 2 + x[1] ** 2) / radius ** 2)]),
                            elements)
            into = -stokes.flow(stokes.inlets)
            exact = 4 * into / (math.pi * radius ** 3)
            stresses, areas, places = stokes.wall_stresses(wall)
            middle = np.abs(2 * places[:, 2] / length - 1) < 0.5
            shear = of_exact(list(zip((stresses[middle] / exact).tolist(), areas[middle].tolist())))
            pull = stokes.mean_stress_along_z(wall, lambda x: np.minimum(x[2], length - x[2])) / exact
            layered = mesh != meshes.bare("short")
            good = not layered or abs((shear["mean"] if elements == STABILISED else pull) - 1) < 0.02
            yield {"mesh": f"dolfinx {elements}, {'tetrahedra' if layered else 'no layers'}", "unknowns": stokes.unknowns, "shear": shear,
                   "pull": pull, "mass_error": abs(into - stokes.flow(stokes.outlets)) / into, "good": bool(good)}, (
                f"{in_words(shear)}; by the pull on the wall {pull:.4f}")


def stokes(meshes):
    from fenics_mesh import Stokes, TaggedMesh
    for mesh in (meshes.layered("bifurcation", "inward", "tetrahedra"), meshes.layered("bifurcation", "outward", "tetrahedra"),
                 meshes.layered("small", "inward", "tetrahedra", "--first-height", 0.08, "--count", 2)):
        meshes.lumesh("convert", mesh, mesh.with_suffix(".xdmf"))
        numbers = mesh.with_suffix(".evaluated.json")
        meshes.lumesh("evaluate", mesh, "--json", numbers)
        ours, tagged = json.loads(numbers.read_text()), TaggedMesh(mesh.with_suffix(".xdmf"))
        volumes, areas = tagged.volumes(), tagged.areas()
        errors = [abs(volumes[label["label"]] / label["volume_mm3"] - 1) for label in ours["labels"]]
        errors += [abs(areas[patch["name"]] / patch["area_mm2"] - 1) for patch in ours["boundary"]["patches"]]
        result = {"mesh": f"dolfinx, {mesh.stem}", "largest_error": max(errors), "compared": len(errors), "good": max(errors) < 1e-9}
        words = f"{len(errors)} volumes and areas, largest difference {max(errors):.1e}"
        if mesh.stem.startswith("small"):  # The other has too many unknowns for a direct solver.
            problem = Stokes(tagged)
            into, out = -problem.flow(problem.inlets), problem.flow(problem.outlets)
            result |= {"unknowns": problem.unknowns, "mass_error": abs(into - out) / into}
            result["good"] = result["good"] and result["mass_error"] < 1e-9
            words += f"; Stokes, P2/P1, {problem.unknowns} unknowns: in - out {result['mass_error']:.1e} of the flow"
        yield result, words


def parts_here(wanted):
    """The steps that can run, by part; says which cannot, and why."""
    steps = {"checkmesh": [check], "heights": [heights], "flow": [flow], "shear": [shear_of_simple_foam, shear_of_dolfinx],
             "stokes": [stokes]}
    unfit = set()
    missing = foam_case.missing("checkMesh", "simpleFoam")
    if missing:
        print(f"skipped: OpenFOAM's {', '.join(missing)}: the Debian package openfoam has them", file=sys.stderr)
        unfit |= {check, flow, shear_of_simple_foam}
    try:
        import dolfinx  # noqa: F401
    except ImportError:
        print("skipped: dolfinx: the Debian package python3-dolfinx has it", file=sys.stderr)
        unfit |= {stokes, shear_of_dolfinx}
    return [(part, step) for part in wanted for step in steps[part] if step not in unfit]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", default=PARTS, metavar="PART")
    parser.add_argument("--program", default=str(run.ROOT / "build/release/bin/lumesh"))
    arguments = parser.parse_args()
    unknown = set(arguments.parts) - set(PARTS)
    if unknown:
        parser.error(f"no part {', '.join(sorted(unknown))}; there are {', '.join(PARTS)}")
    results = []
    with tempfile.TemporaryDirectory(prefix="lumesh_flow_") as name:
        meshes = Meshes(str(pathlib.Path(arguments.program).resolve()), pathlib.Path(name))
        for part, step in parts_here(arguments.parts):
            for result, words in step(meshes):
                results.append({"part": part} | result)
                print(f"{part:9}  {result['mesh']:28}  {'' if result['good'] else 'BAD: '}{words}", file=sys.stderr, flush=True)
    print(json.dumps(results, indent=1))
    return 0 if all(result["good"] for result in results) else 1


if __name__ == "__main__":
    if os.path.realpath(sys.executable) != os.path.realpath(DEBIAN_PYTHON) and os.access(DEBIAN_PYTHON, os.X_OK):
        os.execv(DEBIAN_PYTHON, [DEBIAN_PYTHON, *sys.argv])
    sys.exit(main())
