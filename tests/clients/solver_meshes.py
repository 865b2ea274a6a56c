"""The meshes that the tests of files for solvers share, and what lumesh itself measures on them."""
import json
import pathlib
import subprocess


class Meshes:
    """A bifurcation with inlet and outlets, and three labels with interfaces between them."""

    def __init__(self, program, folder):
        self.program = str(program)
        self.folder = pathlib.Path(folder)
        # No tetrahedron of it has three faces in the boundary. One that has leaves a pressure of Taylor-Hood's
        # elements without an equation: all velocities around its corner are given.
        self.bifurcation = self.make("bifurcation", ["--size", 64, 64, 64, "--spacing", 0.4],
                                     ["delaunay", "--delta", 0.8, "--threads", 1])
        self.layered = self.make("layered", ["--size", 48, 48, 48], ["lattice", "--max-tetrahedra", 20000])

    def lumesh(self, *arguments):
        result = subprocess.run([self.program, *map(str, arguments)], capture_output=True, text=True, timeout=300,
                                check=False)
        if result.returncode != 0:
            raise AssertionError(f"lumesh {' '.join(map(str, arguments))}: {result.stderr}")

    def make(self, kind, of_image, meshing):
        mesh = self.folder / f"{kind}.vtu"
        self.lumesh("phantom", kind, "-o", mesh.with_suffix(".nrrd"), *of_image)
        command, *options = meshing
        self.lumesh(command, mesh.with_suffix(".nrrd"), "-o", mesh, *options)
        return mesh

    def measured(self, mesh):
        """Volume by label, and area by the name of the patch."""
        numbers = mesh.with_suffix(".json")
        self.lumesh("evaluate", mesh, "--json", numbers)
        found = json.loads(numbers.read_text())
        return ({label["label"]: label["volume_mm3"] for label in found["labels"]},
                {patch["name"]: patch["area_mm2"] for patch in found["boundary"]["patches"]})
