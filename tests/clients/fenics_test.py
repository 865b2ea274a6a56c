#!/usr/bin/env python3
"""What FEniCSx (dolfinx) makes of our XDMF: volumes and areas by tag, and a Stokes flow from inlet to outlets.

Usage: fenics_test.py LUMESH      Exit status 77: a Debian package is missing, mostly python3-dolfinx (420 MB).
"""
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import debian_python

debian_python.run_here_or_under_debian({"dolfinx": "python3-dolfinx"})
debian_python.skip_unless_fenics_runs()

from fenics_mesh import Stokes, TaggedMesh
from solver_meshes import Meshes

LUMESH = pathlib.Path(sys.argv.pop(1)).resolve()


class FenicsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="lumesh_fenics_")
        cls.addClassCleanup(folder.cleanup)
        cls.meshes = Meshes(LUMESH, folder.name)
        cls.tagged = {}
        for mesh in (cls.meshes.bifurcation, cls.meshes.layered):
            cls.meshes.lumesh("convert", mesh, mesh.with_suffix(".xdmf"))
            cls.tagged[mesh] = TaggedMesh(mesh.with_suffix(".xdmf"))

    def test_volumes_by_cell_tag_and_areas_by_facet_tag_are_those_of_lumesh(self):
        for mesh, tagged in self.tagged.items():
            with self.subTest(mesh.name):
                volumes, areas = self.meshes.measured(mesh)
                self.assert_equal(tagged.volumes(), volumes)
                self.assert_equal(tagged.areas(), areas)

    def assert_equal(self, found, expected):
        self.assertEqual(set(found), set(expected))
        for key, value in expected.items():
            self.assertAlmostEqual(found[key] / value, 1, delta=1e-9, msg=key)

    def test_what_flows_in_flows_out(self):
        stokes = Stokes(self.tagged[self.meshes.bifurcation])
        into, out = stokes.flow(stokes.inlets), [stokes.flow([outlet]) for outlet in stokes.outlets]
        print(f"flow through the inlet {into:.9g}, the outlets {out}, mass error {abs(into + sum(out)) / abs(into):.1e}")
        self.assertLess(into, 0)
        self.assertGreater(min(out), 0)
        self.assertLess(abs(into + sum(out)), 1e-10 * abs(into))


if __name__ == "__main__":
    unittest.main(verbosity=2, warnings="ignore")
