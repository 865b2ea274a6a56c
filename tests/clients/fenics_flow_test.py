#!/usr/bin/env python3
"""What FEniCSx (dolfinx) makes of boundary layers of tetrahedra: volumes and areas by tag, Stokes flows, the wall's shear stress.

Usage: fenics_flow_test.py LUMESH      Exit status 77: a Debian package is missing, mostly python3-dolfinx (420 MB).
"""
import math
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import debian_python

debian_python.run_here_or_under_debian({"dolfinx": "python3-dolfinx"})
debian_python.skip_unless_fenics_runs()

import numpy as np
import tubes
from fenics_mesh import STABILISED, Stokes, TaggedMesh
from solver_meshes import Meshes

LUMESH = pathlib.Path(sys.argv.pop(1)).resolve()
RADIUS_MM, LENGTH_MM = 3, 6


def parabola(x):
    return np.stack([0 * x[0], 0 * x[0], np.maximum(0, 2 - 2 * (x[0] ** 2 + x[1] ** 2) / RADIUS_MM ** 2)])


class FenicsFlowTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="lumesh_fenics_flow_")
        cls.addClassCleanup(folder.cleanup)
        cls.meshes = Meshes(LUMESH, folder.name)

    def layered(self, mesh, side, *heights):
        layered = mesh.with_name(f"{mesh.stem}_{side}.vtu")
        self.meshes.lumesh("layers", mesh, "--side", side, *heights, "-o", layered)
        return layered, self.tagged(layered)

    def tagged(self, mesh):
        self.meshes.lumesh("convert", mesh, mesh.with_suffix(".xdmf"))
        return TaggedMesh(mesh.with_suffix(".xdmf"))

    def assert_equal(self, found, expected):
        self.assertEqual(set(found), set(expected))
        for key, value in expected.items():
            self.assertAlmostEqual(found[key] / value, 1, delta=1e-9, msg=key)

    def test_volumes_and_areas_are_those_of_lumesh_and_what_flows_in_flows_out(self):
        for side in ("inward", "outward"):
            with self.subTest(side):
                mesh, tagged = self.layered(self.meshes.bifurcation, side, "--first-height", 0.08, "--count", 2)
                volumes, areas = self.meshes.measured(mesh)
                self.assertEqual(len(volumes), 2)
                self.assert_equal(tagged.volumes(), volumes)
                self.assert_equal(tagged.areas(), areas)
                if side == "outward":
                    continue
                stokes = Stokes(tagged)
                into, out = -stokes.flow(stokes.inlets), stokes.flow(stokes.outlets)
                print(f"flow {into:.9g} in, {out:.9g} out, mass error {abs(into - out) / into:.1e}")
                self.assertGreater(into, 0)
                self.assertLess(abs(into - out), 1e-9 * into)

    def shear(self, tagged):
        """Mean of the wall's middle half over that of Poiseuille's flow."""
        stokes = Stokes(tagged, parabola, STABILISED)
        wall = next(entry["tag"] for entry in tagged.names["facet_tags"] if entry["name"] == "wall")
        stresses, areas, places = stokes.wall_stresses(wall)
        middle = np.abs(2 * places[:, 2] / LENGTH_MM - 1) < 0.5
        return np.average(stresses[middle], weights=areas[middle]) * math.pi * RADIUS_MM ** 3 / (4 * -stokes.flow(stokes.inlets))

    def test_layers_bring_the_wall_s_shear_of_linear_elements_within_two_per_cent(self):
        bare = self.meshes.folder / "tube.msh"
        tubes.write_tube_mesh(bare, RADIUS_MM, LENGTH_MM, 5, 8)
        without, layered = self.shear(self.tagged(bare)), self.shear(
            self.layered(bare, "inward", "--first-height", 0.05, "--count", 4)[1])
        print(f"wall's shear stress {without:.4f} of the exact one without layers, {layered:.4f} with them")
        self.assertGreater(abs(without - 1), 0.05)
        self.assertLess(abs(layered - 1), 0.02)


if __name__ == "__main__":
    unittest.main(verbosity=2, warnings="ignore")
