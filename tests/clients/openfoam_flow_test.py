#!/usr/bin/env python3
"""What OpenFOAM makes of boundary layers of prisms: checkMesh's verdict, the first layer's height in its files, and simpleFoam's flow.

Usage: openfoam_flow_test.py LUMESH      Exit status 77: OpenFOAM is not installed.
"""
import math
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import foam_case
import tubes
from foam_case import run

LUMESH = str(pathlib.Path(sys.argv.pop(1)).resolve())
SKIPPED = 77
LAYERS, FIRST_MM = 4, 0.05
RADIUS_MM, LENGTH_MM = 3, 12


class LayersTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="lumesh_openfoam_flow_")
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)

    def layered(self, mesh, side):
        case = foam_case.Case(self.root / f"{mesh.stem}_{side}")
        run(LUMESH, "layers", mesh, "--side", side, "--first-height", FIRST_MM, "--count", LAYERS, "--cells", "prisms", "-o",
            case.folder / "a.vtu")
        run(LUMESH, "convert", case.folder / "a.vtu", case.folder / "a.foam")
        return case

    def image_of_tube(self):
        image = self.root / "tube.nrrd"
        tubes.write_tube_image(image, RADIUS_MM, LENGTH_MM, 0.25)
        return self.mesh_of(image, "--spacing", 0.7)

    def mesh_of(self, image, *options):
        mesh = image.with_suffix(".vtu")
        run(LUMESH, "lattice", image, "-o", mesh, *options)
        return mesh

    def assert_mesh_ok(self, case, patches, label):
        found = foam_case.check_mesh(case)
        self.assertTrue(found["ok"], found["said"])
        self.assertLessEqual(set(patches), set(found["patches"]))
        self.assertEqual(set(found["zones"]), {"label_1", label})
        self.assertGreater(found["cells"]["prisms"], 0)
        self.assertGreater(found["cells"]["tetrahedra"], 0)

    def test_mesh_of_a_tube_is_ok_and_its_first_layer_as_high_as_asked_for(self):
        for side, wall, label in (("inward", "wall", "layer"), ("outward", "layer_outer", "vessel_wall")):
            with self.subTest(side):
                case = self.layered(self.image_of_tube(), side)
                rings = ["inlet_1_layer", "outlet_1_layer"] if side == "outward" else []
                self.assert_mesh_ok(case, [wall, "inlet_1", "outlet_1", *rings], label)
                stacks = foam_case.first_layer_heights(foam_case.PolyMesh(case.folder), LAYERS)
                self.assertGreater(len(stacks), 1000)
                for _, first, _ in stacks:
                    self.assertLess(max(abs(1000 * height / FIRST_MM - 1) for height in first), 0.02)

    def test_mesh_of_a_bifurcation_is_ok(self):
        run(LUMESH, "phantom", "bifurcation", "-o", self.root / "bifurcation.nrrd")
        mesh = self.mesh_of(self.root / "bifurcation.nrrd")
        for side, wall, label in (("inward", "wall", "layer"), ("outward", "layer_outer", "vessel_wall")):
            with self.subTest(side):
                self.assert_mesh_ok(self.layered(mesh, side), [wall, "inlet_1", "outlet_1", "outlet_2"], label)

    def test_flow_through_a_tube_converges_to_that_of_poiseuille(self):
        tubes.write_tube_mesh(self.root / "tube.msh", RADIUS_MM, LENGTH_MM, 6, 20)
        case = self.layered(self.root / "tube.msh", "inward")
        mesh, radius = foam_case.PolyMesh(case.folder), RADIUS_MM / 1000
        self.assertEqual(set(mesh.patches), {"wall", "inlet", "outlet"})
        mean = 100 * foam_case.BLOOD_M2_S / (2 * radius)  # Reynolds number 100
        found = foam_case.solve_flow(case, mesh, "inlet", lambda x: 2 * mean * max(0, 1 - (x[0] ** 2 + x[1] ** 2) / radius ** 2),
                                     iterations=500)
        self.assertTrue(found["converged"])
        self.assertLess(found["mass_error"], 1e-6)
        self.assertAlmostEqual(found["in_m3_s"] / (mean * math.pi * radius ** 2), 1, delta=0.02)
        shear = [(foam_case.norm(area), stress) for (place, area), stress in
                 ((mesh.centre_and_area(face), stress) for face, stress in zip(mesh.patches["wall"], found["stresses_m2_s2"]["wall"]))
                 if abs(2000 * place[2] / LENGTH_MM - 1) < 0.5]
        stress = sum(area * stress for area, stress in shear) / sum(area for area, _ in shear)
        exact = 4 * foam_case.BLOOD_M2_S * found["in_m3_s"] / (math.pi * radius ** 3)
        print(f"wall's shear stress {stress / exact:.4f} of the exact one, in - out {found['mass_error']:.1e} of the flow")
        self.assertAlmostEqual(stress / exact, 1, delta=0.02)


if __name__ == "__main__":
    if foam_case.missing("checkMesh", "simpleFoam"):
        print("SKIP: OpenFOAM is missing or does not run; scripts/packages.sh solvers installs it")
        sys.exit(SKIPPED)
    unittest.main(verbosity=2)
