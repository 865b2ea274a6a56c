#!/usr/bin/env python3
"""What FEniCSx (dolfinx) makes of our XDMF: volumes and areas by tag, and a Stokes flow from inlet to outlets.

Usage: fenics_test.py LUMESH      Exit status 77: a Debian package is missing, mostly python3-dolfinx (420 MB).
"""
import json
import logging
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import debian_python

debian_python.run_here_or_under_debian({"dolfinx": "python3-dolfinx"})

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.io import XDMFFile
from mpi4py import MPI
from petsc4py import PETSc
from solver_meshes import Meshes

LUMESH = pathlib.Path(sys.argv.pop(1)).resolve()
logging.disable(logging.WARNING)  # How each form was compiled.


class TaggedMesh:
    """A mesh as a user reads it, with what is measured on it."""

    def __init__(self, path):
        with XDMFFile(MPI.COMM_WORLD, str(path), "r") as file:
            self.mesh = file.read_mesh(name="Grid")
            self.cell_tags = file.read_meshtags(self.mesh, name="Grid")
        self.mesh.topology.create_connectivity(2, 3)
        self.mesh.topology.create_connectivity(2, 0)
        with XDMFFile(MPI.COMM_WORLD, str(path.with_name(f"{path.stem}_facets.xdmf")), "r") as file:
            self.facet_tags = file.read_meshtags(self.mesh, name="Grid")
        self.names = json.loads(path.with_name(f"{path.stem}_tags.json").read_text())
        self.dx = ufl.Measure("dx", domain=self.mesh, subdomain_data=self.cell_tags)
        self.ds = ufl.Measure("ds", domain=self.mesh, subdomain_data=self.facet_tags)
        self.dS = ufl.Measure("dS", domain=self.mesh, subdomain_data=self.facet_tags)

    def integral(self, form):
        return self.mesh.comm.allreduce(fem.assemble_scalar(fem.form(form)), MPI.SUM)

    def volumes(self):
        one = fem.Constant(self.mesh, PETSc.ScalarType(1))
        return {entry["tag"]: self.integral(one * self.dx(entry["tag"])) for entry in self.names["cell_tags"]}

    def areas(self):
        one = fem.Constant(self.mesh, PETSc.ScalarType(1))
        measures = {"interface": self.dS}
        return {entry["name"]: self.integral(one * measures.get(entry["kind"], self.ds)(entry["tag"]))
                for entry in self.names["facet_tags"]}

    def facets(self, kind):
        """The tags of a kind of patch."""
        return [entry["tag"] for entry in self.names["facet_tags"] if entry["kind"] == kind]


def stokes_flows(tagged):
    """Flows out through each opening, of Taylor-Hood's elements: given into the first, free out of the others."""
    mesh = tagged.mesh
    space = fem.FunctionSpace(mesh, ufl.MixedElement([ufl.VectorElement("CG", mesh.ufl_cell(), 2),
                                                      ufl.FiniteElement("CG", mesh.ufl_cell(), 1)]))
    velocities, _ = space.sub(0).collapse()

    def fixed(tag, velocity):
        values = fem.Function(velocities)
        values.interpolate(lambda x: np.outer(velocity, np.ones(x.shape[1])))
        dofs = fem.locate_dofs_topological((space.sub(0), velocities), 2, tagged.facet_tags.find(tag))
        return fem.dirichletbc(values, dofs, space.sub(0))

    inlet, *outlets = tagged.facets("opening")
    normal = ufl.FacetNormal(mesh)
    inward = [-tagged.integral(normal[i] * tagged.ds(inlet)) for i in range(3)]
    conditions = [fixed(inlet, inward), *(fixed(wall, [0, 0, 0]) for wall in tagged.facets("wall"))]
    (u, p), (v, q) = ufl.TrialFunctions(space), ufl.TestFunctions(space)
    left = (ufl.inner(ufl.grad(u), ufl.grad(v)) - p * ufl.div(v) - q * ufl.div(u)) * ufl.dx
    right = ufl.inner(fem.Constant(mesh, PETSc.ScalarType((0, 0, 0))), v) * ufl.dx
    problem = fem.petsc.LinearProblem(left, right, conditions, petsc_options={
        "ksp_type": "preonly", "pc_type": "lu", "pc_factor_mat_solver_type": "mumps"})
    velocity, _ = ufl.split(problem.solve())
    flow = {tag: tagged.integral(ufl.dot(velocity, normal) * tagged.ds(tag)) for tag in (inlet, *outlets)}
    return flow[inlet], [flow[tag] for tag in outlets]


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
        into, out = stokes_flows(self.tagged[self.meshes.bifurcation])
        print(f"flow through the inlet {into:.9g}, the outlets {out}, mass error {abs(into + sum(out)) / abs(into):.1e}")
        self.assertLess(into, 0)
        self.assertGreater(min(out), 0)
        self.assertLess(abs(into + sum(out)), 1e-10 * abs(into))


if __name__ == "__main__":
    unittest.main(verbosity=2, warnings="ignore")
