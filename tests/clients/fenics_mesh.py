"""A mesh in dolfinx as users of FEniCS read it, and Stokes flows on it. Import it where dolfinx is known to be there."""
import json
import logging
import os
import pathlib
import tempfile

# What dolfinx compiles goes here: the home of who runs the tests may be closed to writing.
_compiled_forms = tempfile.TemporaryDirectory(prefix="lumesh_fenics_cache_")
os.environ["XDG_CACHE_HOME"] = _compiled_forms.name
os.environ.setdefault("OMP_NUM_THREADS", "1")  # MUMPS is slower with threads that wait for each other.

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.io import XDMFFile
from mpi4py import MPI
from petsc4py import PETSc

logging.disable(logging.WARNING)  # How each form was compiled.
TAYLOR_HOOD, STABILISED = "P2/P1", "P1/P1"


class TaggedMesh:
    """A mesh as a user reads it, with what is measured on it."""

    def __init__(self, path):
        path = pathlib.Path(path)
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

    def inlets_and_outlets(self):
        """Tags of the first opening with the ring of layers around it, and of all others."""
        named = {entry["tag"]: entry["name"] for entry in self.names["facet_tags"]}
        openings = self.facets("opening")
        first = named[openings[0]]
        inlets = [tag for tag in openings if named[tag] == first]
        return inlets, [tag for tag in openings if tag not in inlets]


class Stokes:
    """A flow of viscosity 1: velocities given at the inlets, none at the walls, outlets free of stress."""

    def __init__(self, tagged, inflow=None, elements=TAYLOR_HOOD):
        """inflow: velocities (3, n) at points (3, n); default: the same everywhere, in through the inlet."""
        mesh, self.tagged = tagged.mesh, tagged
        degree = 2 if elements == TAYLOR_HOOD else 1
        space = fem.FunctionSpace(mesh, ufl.MixedElement([ufl.VectorElement("CG", mesh.ufl_cell(), degree),
                                                          ufl.FiniteElement("CG", mesh.ufl_cell(), 1)]))
        self.unknowns = space.dofmap.index_map.size_global
        velocities, _ = space.sub(0).collapse()
        self.normal = ufl.FacetNormal(mesh)
        self.inlets, self.outlets = tagged.inlets_and_outlets()

        def fixed(tag, velocity):
            values = fem.Function(velocities)
            values.interpolate(velocity)
            dofs = fem.locate_dofs_topological((space.sub(0), velocities), 2, tagged.facet_tags.find(tag))
            return fem.dirichletbc(values, dofs, space.sub(0))

        conditions = [fixed(inlet, inflow or self.plug()) for inlet in self.inlets]
        conditions += [fixed(wall, np.zeros_like) for wall in tagged.facets("wall")]
        (u, p), (v, q) = ufl.TrialFunctions(space), ufl.TestFunctions(space)
        left = (ufl.inner(ufl.grad(u), ufl.grad(v)) - p * ufl.div(v) - q * ufl.div(u)) * ufl.dx
        if elements == STABILISED:  # Hughes, Franca and Balestra 1986, doi:10.1016/0045-7825(86)90025-3.
            left -= ufl.CellVolume(mesh) ** (2 / 3) / 12 * ufl.inner(ufl.grad(p), ufl.grad(q)) * ufl.dx
        right = ufl.inner(fem.Constant(mesh, PETSc.ScalarType((0, 0, 0))), v) * ufl.dx
        problem = fem.petsc.LinearProblem(left, right, conditions, petsc_options={
            "ksp_type": "preonly", "pc_type": "lu", "pc_factor_mat_solver_type": "mumps"})
        self.velocity, self.pressure = ufl.split(problem.solve())

    def plug(self):
        tagged = self.tagged
        inward = np.array([-tagged.integral(self.normal[i] * tagged.ds(self.inlets[0])) for i in range(3)])
        return lambda x: np.outer(inward, np.ones(x.shape[1]))

    def flow(self, tags):
        """Out through them together."""
        return sum(self.tagged.integral(ufl.dot(self.velocity, self.normal) * self.tagged.ds(tag)) for tag in tags)

    def mean_stress_along_z(self, wall, weight):
        """On the wall, weighted by a function of points that is 0 at inlets and outlets: what the flow pulls with, by the equations
        themselves, tested with the weight."""
        function = fem.Function(fem.FunctionSpace(self.tagged.mesh, ("CG", 1)))
        function.interpolate(weight)
        test = ufl.as_vector([0, 0, function])
        pull = self.tagged.integral((ufl.inner(ufl.grad(self.velocity), ufl.grad(test)) - self.pressure * ufl.div(test)) * ufl.dx)
        return abs(pull) / self.tagged.integral(function * self.tagged.ds(wall))

    def wall_stresses(self, wall):
        """Of each cell with a face on the wall: the face's mean shear stress, its area and its middle."""
        mesh, ds, normal = self.tagged.mesh, self.tagged.ds, self.normal
        test = ufl.TestFunction(fem.FunctionSpace(mesh, ("DG", 0)))
        traction = 2 * ufl.sym(ufl.grad(self.velocity)) * normal
        shear = traction - ufl.dot(traction, normal) * normal

        def by_cell(value):
            return fem.petsc.assemble_vector(fem.form(value * test * ds(wall, metadata={"quadrature_degree": 4}))).array.copy()

        x = ufl.SpatialCoordinate(mesh)
        area = by_cell(fem.Constant(mesh, PETSc.ScalarType(1)))
        here = area > 0
        stress = by_cell(ufl.sqrt(ufl.dot(shear, shear)))
        middles = np.stack([by_cell(x[i]) for i in range(3)], axis=1)
        return stress[here] / area[here], area[here], middles[here] / area[here][:, None]
