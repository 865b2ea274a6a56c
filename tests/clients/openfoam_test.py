#!/usr/bin/env python3
"""What OpenFOAM's own checkMesh and splitMeshRegions make of the cases that lumesh writes.

Usage: openfoam_test.py LUMESH      Exit status 77: OpenFOAM is not installed.
"""
import json
import pathlib
import re
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import foam_case
from foam_case import run

LUMESH = str(pathlib.Path(sys.argv.pop(1)).resolve())
SKIPPED = 77


class Case(foam_case.Case):
    """Of a phantom."""

    def __init__(self, folder, phantom, *options):
        super().__init__(folder)
        run(LUMESH, "phantom", *phantom, "-o", folder / "a.nrrd")
        run(LUMESH, "lattice", folder / "a.nrrd", "-o", folder / "a.vtu", *options)
        run(LUMESH, "convert", folder / "a.vtu", folder / "case.foam")

    def volume_mm3(self):
        """Of all cells, as lumesh measures it."""
        run(LUMESH, "evaluate", self.folder / "a.vtu", "--json", self.folder / "a.json")
        return sum(label["volume_mm3"] for label in json.loads((self.folder / "a.json").read_text())["labels"])


class OpenFoamTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="lumesh_openfoam_")
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)

    def assert_mesh_ok(self, said):
        """checkMesh ends with 0 whatever it finds."""
        self.assertIn("\nMesh OK.\n", said)
        self.assertIn("Upper triangular ordering OK.", said)
        self.assertNotIn("***", said)
        self.assertNotIn("Unused points", said)

    def assert_volume(self, case, said):
        volume = float(re.search(r"Total volume = (\S+?)\.? ", said)[1])
        self.assertAlmostEqual(volume * 1e9 / case.volume_mm3(), 1, places=5)

    def test_a_case_opens_as_it_was_written(self):
        run(LUMESH, "phantom", "torus", "--size", "32", "32", "16", "-o", self.root / "a.nrrd")
        run(LUMESH, "lattice", self.root / "a.nrrd", "-o", self.root / "case.foam")
        environment = foam_case.foam_environment()
        self.assert_mesh_ok(run("checkMesh", "-case", self.root, cwd="/", env=environment))
        run("foamToVTK", "-case", self.root, "-constant", cwd="/", env=environment)
        self.assertTrue(list((self.root / "VTK").iterdir()))

    def test_tetrahedra_of_a_bifurcation(self):
        case = Case(self.root / "tetrahedra", ["bifurcation"])
        said = case.foam("checkMesh")
        self.assert_mesh_ok(said)
        self.assert_volume(case, said)
        for patch in ("wall", "inlet_1", "outlet_1", "outlet_2"):
            self.assertRegex(said, rf"\n    {patch} +\d+ +\d+ +ok \(non-closed singly connected\)")

    def test_mixed_cells_of_a_bifurcation(self):
        case = Case(self.root / "mixed", ["bifurcation"], "--mixed")
        said = case.foam("checkMesh")
        self.assert_mesh_ok(said)
        self.assert_volume(case, said)
        for shape in ("hexahedra", "pyramids", "tetrahedra"):
            self.assertRegex(said, rf"\n    {shape}: +[1-9]")

    def test_labels_are_regions(self):
        case = Case(self.root / "labels", ["layered", "--size", 48, 48, 48])
        said = case.foam("checkMesh")
        self.assert_mesh_ok(said)
        faces = {zone: count for zone, count in re.findall(r"\n    (interface_\S+) +(\d+) +\d+ +ok", said)}
        self.assertEqual(set(faces), {"interface_1_2", "interface_2_3"})
        case.foam("splitMeshRegions", "-cellZones", "-overwrite")
        for label in ("label_1", "label_2", "label_3"):
            self.assert_mesh_ok(case.foam("checkMesh", "-region", label))
        self.assertRegex(case.foam("checkMesh", "-region", "label_1"), rf"label_1_to_label_2 +{faces['interface_1_2']} ")


if __name__ == "__main__":
    if foam_case.missing("checkMesh"):
        print("SKIP: OpenFOAM's checkMesh is missing or does not run; scripts/packages.sh solvers installs it")
        sys.exit(SKIPPED)
    unittest.main(verbosity=2)
