"""Cases of OpenFOAM around the meshes that lumesh writes: checkMesh, laminar flow by simpleFoam, and what came out of them."""
import math
import os
import pathlib
import re
import shutil
import subprocess

DEBIAN_PROJECT_DIR = "/usr/share/openfoam"  # Where Debian keeps etc/controlDict; its programs do not know it themselves.
BLOOD_M2_S = 3.3e-6
SECONDS = 1800


def foam_environment():
    return os.environ | {"WM_PROJECT_DIR": os.environ.get("WM_PROJECT_DIR", DEBIAN_PROJECT_DIR)}


def runs(program):
    """Whether it is here and starts, which MPI may keep it from in a container."""
    return shutil.which(program) is not None and subprocess.run(
        [program, "-help"], capture_output=True, check=False, env=foam_environment()).returncode == 0


def missing(*programs):
    return [program for program in programs if not runs(program)]


def require(parser, *programs):
    """Ends a script with a message of its argument parser if a program is not there."""
    absent = missing(*programs)
    if absent:
        parser.error(f"OpenFOAM's {', '.join(absent)}: the Debian package openfoam has them")


def run(*command, **options):
    result = subprocess.run([*map(str, command)], capture_output=True, text=True, timeout=SECONDS, check=False, **options)
    if result.returncode != 0:
        raise AssertionError(f"{' '.join(map(str, command))}: {result.stdout[-2000:]}{result.stderr}")
    return result.stdout


def dictionary(path, content="", kind="dictionary"):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"FoamFile{{version 2.0; format ascii; class {kind}; object {path.name};}}\n{content}\n")


class Case:
    """A folder with what OpenFOAM's programs ask for besides the mesh."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        dictionary(self.folder / "system/controlDict", "deltaT 1; endTime 1; writeInterval 1;")
        dictionary(self.folder / "system/fvSchemes", "ddtSchemes{} gradSchemes{} divSchemes{} laplacianSchemes{}")
        dictionary(self.folder / "system/fvSolution")

    def foam(self, *command):
        return run(*command, cwd=self.folder, env=foam_environment())


def check_mesh(case):
    """What checkMesh finds; it ends with 0 whatever that is."""
    said = case.foam("checkMesh")

    def number(pattern):
        found = re.search(pattern, said)
        return float(found[1]) if found else None

    return {"ok": "\nMesh OK.\n" in said and "***" not in said,
            "failed": re.findall(r"\*\*\*(.*)", said),
            "severely_non_orthogonal_faces": int(number(r"non-orthogonal \(> 70 degrees\) faces: (\d+)") or 0),
            "non_orthogonality_deg": number(r"non-orthogonality Max: (\S+)"),
            "skewness": number(r"Max skewness = ([^,\s]+)"),
            "aspect_ratio": number(r"Max aspect ratio = ([^,\s]+)"),
            "cells": {shape: int(count) for shape, count in re.findall(r"\n    (\w+): +([1-9]\d*)", said)},
            "patches": re.findall(r"\n    (\S+) +\d+ +\d+ +ok \(", said.split("faceZone topology")[0]),
            "zones": re.findall(r"\n    (\S+) +\d+ +\d+ +\S+ +\(", said.split("cellZone addressing")[-1]),
            "said": said}


def minus(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def norm(a):
    return math.sqrt(dot(a, a))


class PolyMesh:
    """constant/polyMesh as it stands in its files, in metres."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder) / "constant/polyMesh"
        self.cell_faces = None
        self.points = [tuple(map(float, point.split())) for point in re.findall(r"\(([^()]+)\)", self.body("points"))]
        self.faces = [tuple(map(int, face.split())) for face in re.findall(r"\d+\(([^()]+)\)", self.body("faces"))]
        self.owner = [int(cell) for cell in self.body("owner").split()]
        self.neighbour = [int(cell) for cell in self.body("neighbour").split()]
        self.patches = {name: range(int(start), int(start) + int(count)) for name, count, start in
                        re.findall(r"(\S+)\s*\{[^}]*nFaces\s+(\d+);\s*startFace\s+(\d+);", self.body("boundary"))}

    def body(self, name):
        """The outermost list of a file."""
        text = (self.folder / name).read_text()
        text = text[text.index("}", text.index("FoamFile")) + 1:]
        return text[text.index("(") + 1:text.rindex(")")]

    def zone(self, file, name):
        """Labels of the faces or cells of a zone."""
        found = re.search(rf"\n\s*{re.escape(name)}\s*\{{.*?\((.*?)\)", "\n" + self.body(file), re.DOTALL)
        return [int(label) for label in found[1].split()] if found else []

    def faces_of(self, cell):
        if self.cell_faces is None:
            self.cell_faces = [[] for _ in range(max(self.owner + self.neighbour) + 1)]
            for cells in (self.owner, self.neighbour):
                for face, of in enumerate(cells):
                    self.cell_faces[of].append(face)
        return self.cell_faces[cell]

    def shape(self, cell):
        sides = sorted(len(self.faces[face]) for face in self.faces_of(cell))
        return {(3, 3, 3, 3): "tetrahedron", (3, 3, 3, 3, 4): "pyramid", (3, 3, 4, 4, 4): "prism", (4,) * 6: "hexahedron"}[tuple(sides)]

    def marked(self, name):
        """The faces or cells of a set that checkMesh wrote."""
        return [int(label) for label in self.body(f"sets/{name}").split()]

    def corners(self, face):
        return [self.points[point] for point in self.faces[face]]

    def centre_and_area(self, face):
        """Of a face by its triangles around the mean corner; the area as a vector out of the owner."""
        corners = self.corners(face)
        middle = tuple(sum(corner[i] for corner in corners) / len(corners) for i in range(3))
        area, moment, size = [0.0] * 3, [0.0] * 3, 0.0
        for a, b in zip(corners, corners[1:] + corners[:1]):
            part = cross(minus(a, middle), minus(b, middle))
            weight = norm(part)
            size += weight
            for i in range(3):
                area[i] += part[i] / 2
                moment[i] += weight * (a[i] + b[i] + middle[i]) / 3
        return tuple(m / size for m in moment), tuple(area)


def first_layer_heights(mesh, layers, patch="wall"):
    """For each triangle of the patch with a stack of as many prisms on it: its area, how far the three upper corners of the first
    prism are from its plane, and the corners of the last are; in metres."""
    layer = set(mesh.zone("cellZones", "layer") or mesh.zone("cellZones", "vessel_wall"))
    found = []
    for face in mesh.patches.get(patch) or mesh.zone("faceZones", patch):
        plane, area = mesh.centre_and_area(face)
        size, lower, ends = norm(area), face, []
        cell = next(cell for cell in [mesh.owner[face], *mesh.neighbour[face:face + 1]] if cell in layer or face not in range(len(mesh.neighbour)))
        while cell in layer and mesh.shape(cell) == "prism" and len(ends) < layers:
            upper = next(side for side in mesh.faces_of(cell) if len(mesh.faces[side]) == 3 and side != lower)
            ends.append([abs(dot(minus(corner, plane), area)) / size for corner in mesh.corners(upper)])
            beyond = [other for other in [mesh.owner[upper], *mesh.neighbour[upper:upper + 1]] if other != cell]
            lower, cell = upper, beyond[0] if beyond else -1
        if len(ends) == layers:
            found.append((size, ends[0], ends[-1]))
    return found


def where_bad(folder):
    """Of each set of faces that checkMesh wrote: how many lie between which cells, such as "layer prism | core tetrahedron", and the
    place of one in mm."""
    mesh, found = PolyMesh(folder), {}
    layer = set(mesh.zone("cellZones", "layer") or mesh.zone("cellZones", "vessel_wall"))
    for path in sorted((mesh.folder / "sets").glob("*Faces")):
        for face in mesh.marked(path.name):
            cells = [mesh.owner[face]] + mesh.neighbour[face:face + 1]
            sides = " | ".join(sorted(f"{'layer' if cell in layer else 'core'} {mesh.shape(cell)}" for cell in cells))
            place = " ".join(f"{1000 * x:.3f}" for x in mesh.centre_and_area(face)[0])
            entry = found.setdefault(path.name, {}).setdefault(sides, {"faces": 0, "at": place})
            entry["faces"] += 1
    return found


FLOW_CONTROL = """application simpleFoam; startFrom startTime; startTime 0; stopAt endTime; endTime {iterations}; deltaT 1;
writeControl timeStep; writeInterval {iterations}; purgeWrite 1; writeFormat ascii; writePrecision 12; timeFormat general;
timePrecision 8; runTimeModifiable false;"""
FLOW_SCHEMES = """ddtSchemes{{default steadyState;}}
gradSchemes{{default {gradient};}}
divSchemes{{default none; div(phi,U) {convection}; div((nuEff*dev2(T(grad(U))))) Gauss linear;}}
laplacianSchemes{{default Gauss linear {laplacian};}}
interpolationSchemes{{default linear;}} snGradSchemes{{default {laplacian};}}"""
FLOW_SOLUTION = """solvers{{p{{{pressure}}}
U{{solver smoothSolver; smoother symGaussSeidel; tolerance 1e-12; relTol 0.1;}}}}
SIMPLE{{nNonOrthogonalCorrectors {correctors}; consistent yes; residualControl{{p {residual}; U {residual};}}}}
relaxationFactors{{equations{{U 0.9;}}}}"""
CONJUGATE_GRADIENTS = "solver PCG; preconditioner DIC; tolerance 1e-12; relTol 0.01; maxIter 2000;"
MULTIGRID = "solver GAMG; smoother DICGaussSeidel; nCellsInCoarsestLevel 50; tolerance 1e-12; relTol 0.03; maxIter 60;"
# Gradients by the neighbours across points: those by faces alone lose a tenth of the wall's shear on tetrahedra.
SECOND_ORDER = {"gradient": "pointCellsLeastSquares", "convection": "bounded Gauss linearUpwind grad(U)", "laplacian": "corrected", "correctors": 1,
                "pressure": CONJUGATE_GRADIENTS}


def velocities(mesh, patch, speed):
    """Into the patch, by the place of each face; a line of OpenFOAM's boundaryField."""
    values = []
    for face in mesh.patches[patch]:
        centre, area = mesh.centre_and_area(face)
        scale = -speed(centre) / norm(area)
        values.append(f"({scale * area[0]:.10g} {scale * area[1]:.10g} {scale * area[2]:.10g})")
    return f"{patch}{{type fixedValue; value nonuniform List<vector> {len(values)}({' '.join(values)});}}"


def prepare_flow(case, mesh, inlet, speed, iterations=2000, residual=1e-6, start=None, **schemes):
    """Laminar blood that comes in through the patch `inlet` with a speed, goes out of the other openings at
    p = 0, and sticks to the rest. start: velocities and pressures over density of all cells to begin with, else at rest."""
    schemes = SECOND_ORDER | schemes | {"iterations": iterations, "residual": residual}
    inlets = [name for name in mesh.patches if name == inlet]
    outlets = [name for name in mesh.patches if name.startswith(("inlet", "outlet")) and name not in inlets]
    walls = [name for name in mesh.patches if name not in inlets + outlets]
    dictionary(case.folder / "system/controlDict", FLOW_CONTROL.format(**schemes))
    dictionary(case.folder / "system/fvSchemes", FLOW_SCHEMES.format(**schemes))
    dictionary(case.folder / "system/fvSolution", FLOW_SOLUTION.format(**schemes))
    dictionary(case.folder / "constant/transportProperties", f"transportModel Newtonian; nu {BLOOD_M2_S};")
    dictionary(case.folder / "constant/turbulenceProperties", "simulationType laminar;")
    velocity, pressure = start_lists(*start) if start else ("uniform (0 0 0)", "uniform 0")
    in_velocity = [velocities(mesh, patch, speed) for patch in inlets]
    write_field(case, "U", "volVectorField", "[0 1 -1 0 0 0 0]", velocity,
                in_velocity + [f"{patch}{{type zeroGradient;}}" for patch in outlets] + [f"{patch}{{type noSlip;}}" for patch in walls])
    write_field(case, "p", "volScalarField", "[0 2 -2 0 0 0 0]", pressure,
                [f"{patch}{{type fixedValue; value uniform 0;}}" for patch in outlets] +
                [f"{patch}{{type zeroGradient;}}" for patch in inlets + walls])
    return inlets, outlets, walls


def start_lists(velocities_m_s, pressures_m2_s2):
    vectors = "\n".join("({:.10g} {:.10g} {:.10g})".format(*velocity) for velocity in velocities_m_s)
    scalars = "\n".join(f"{pressure:.10g}" for pressure in pressures_m2_s2)
    return (f"nonuniform List<vector> {len(velocities_m_s)}({vectors})", f"nonuniform List<scalar> {len(pressures_m2_s2)}({scalars})")


def write_field(case, name, kind, dimensions, inside, patches):
    dictionary(case.folder / "0" / name, f"dimensions {dimensions}; internalField {inside};\nboundaryField{{\n" +
               "\n".join(patches) + "\n}", kind)


def patch_values(path, patch):
    """Numbers of a patch of a field that has one for each face, as tuples."""
    text = path.read_text()
    text = text[text.index("boundaryField"):]
    found = re.search(rf"\n    {re.escape(patch)}\s*\{{.*?nonuniform List<\w+>\s*\d+\s*\((.*?)\)\s*;", text, re.DOTALL)
    if found is None:
        return []
    return [tuple(map(float, value.strip("()").split())) for value in re.findall(r"\([^()]+\)|[^\s()]+", found[1])]


def solve_flow(case, mesh, inlet, speed, **schemes):
    """Runs simpleFoam. What it says of convergence, flows in m3/s, and the stress at the walls over the density, in m2/s2."""
    inlets, outlets, walls = prepare_flow(case, mesh, inlet, speed, **schemes)
    said = case.foam("simpleFoam")
    case.foam("simpleFoam", "-postProcess", "-latestTime", "-func", "wallShearStress")
    latest = max((folder for folder in case.folder.iterdir() if folder.name.isdigit()), key=lambda folder: int(folder.name))
    flows = {patch: sum(value[0] for value in patch_values(latest / "phi", patch)) for patch in inlets + outlets}
    into, out = -sum(flows[patch] for patch in inlets), sum(flows[patch] for patch in outlets)
    converged = re.search(r"SIMPLE solution converged in (\d+) iterations", said)
    continuity = re.findall(r"continuity errors : sum local = (\S+), global = (\S+), cumulative", said)
    stresses = {patch: [norm(value) for value in patch_values(latest / "wallShearStress", patch)] for patch in walls}
    return {"converged": converged is not None, "iterations": int(converged[1]) if converged else int(latest.name),
            "flows_m3_s": flows, "in_m3_s": into, "mass_error": abs(into - out) / into,
            "continuity": float(continuity[-1][0]), "seconds": float(re.findall(r"ExecutionTime = (\S+) s", said)[-1]),
            "stresses_m2_s2": stresses}
