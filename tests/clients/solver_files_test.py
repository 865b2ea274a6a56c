#!/usr/bin/env python3
"""What meshio makes of our XDMF for FEniCS, and VTK of our folder for SimVascular, by the rules of its solver.

svMultiPhysics casts the arrays of the folder to vtkIntArray, takes its numbers from 1, finds the nodes of a face by
GlobalNodeID and its element by GlobalElementID, and wants elements of one kind.
Usage: solver_files_test.py LUMESH      Exit status 77: the clients' Debian packages are missing.
"""
import collections
import json
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import debian_python

debian_python.run_here_or_under_debian()

import numpy as np
import readers
from readers import vtk_to_numpy
from solver_meshes import Meshes
from vtkmodules.vtkCommonCore import vtkIntArray

LUMESH = pathlib.Path(sys.argv.pop(1)).resolve()


def setUpModule():
    global MESHES
    folder = tempfile.TemporaryDirectory(prefix="lumesh_solver_files_")
    unittest.addModuleCleanup(folder.cleanup)
    MESHES = Meshes(LUMESH, folder.name)


class XdmfTest(unittest.TestCase):
    def test_meshio_reads_cells_and_facets_with_their_tags(self):
        for mesh in (MESHES.bifurcation, MESHES.layered):
            with self.subTest(mesh.name):
                MESHES.lumesh("convert", mesh, mesh.with_suffix(".xdmf"))
                reference = readers.vtk_mesh(readers.vtk_data(mesh))
                cells = readers.meshio_mesh(mesh.with_suffix(".xdmf"), "cell_tags")
                np.testing.assert_array_equal(cells.points, reference.points)
                np.testing.assert_array_equal(cells.rows("tetra"), reference.rows("tetra"))
                facets = readers.meshio_mesh(mesh.with_name(f"{mesh.stem}_facets.xdmf"), "facet_tags")
                np.testing.assert_array_equal(facets.points, reference.points)
                self.assert_areas(facets, mesh)

    def assert_areas(self, facets, mesh):
        tags = json.loads(mesh.with_name(f"{mesh.stem}_tags.json").read_text())["facet_tags"]
        corners, found = facets.cells["triangle"]
        a, b, c = (facets.points[corners[:, i]] for i in range(3))
        areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
        _, expected = MESHES.measured(mesh)
        self.assertEqual({tag["name"] for tag in tags}, set(expected))
        for tag in tags:
            self.assertAlmostEqual(areas[found == tag["tag"]].sum() / expected[tag["name"]], 1, delta=1e-9)


class Volume:
    """What the solver reads first."""

    def __init__(self, folder):
        grid = readers.vtk_data(folder / "mesh-complete.mesh.vtu")
        self.points = vtk_to_numpy(grid.GetPoints().GetData())
        kinds = np.unique(vtk_to_numpy(grid.GetCellTypesArray())).tolist()
        assert kinds == [10], f"cells of the kinds {kinds}"
        self.elements = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 4)
        self.node_ids = solver_array(grid.GetPointData(), "GlobalNodeID")
        self.element_ids = solver_array(grid.GetCellData(), "GlobalElementID")
        self.regions = solver_array(grid.GetCellData(), "ModelRegionID")


def solver_array(data, name):
    array = vtkIntArray.SafeDownCast(data.GetArray(name))
    assert array is not None, f"{name} is missing or not of 32-bit integers"
    return vtk_to_numpy(array)


class Faces:
    def __init__(self, path):
        data = readers.vtk_data(path)
        self.data = data
        self.points = vtk_to_numpy(data.GetPoints().GetData())
        self.corners = vtk_to_numpy(data.GetPolys().GetConnectivityArray()).reshape(-1, 3)
        self.node_ids = solver_array(data.GetPointData(), "GlobalNodeID")
        self.element_ids = solver_array(data.GetCellData(), "GlobalElementID")
        self.regions = solver_array(data.GetCellData(), "ModelRegionID")
        self.face_ids = solver_array(data.GetCellData(), "ModelFaceID")

    def nodes(self):
        """Corners as indices of the volume's points."""
        return self.node_ids[self.corners] - 1

    def area(self):
        return readers.vtk_sizes(self.data, "Area").sum()


class SimVascularTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folders = {}
        for mesh in (MESHES.bifurcation, MESHES.layered):
            cls.folders[mesh] = mesh.with_name(f"{mesh.stem}-mesh-complete")
            MESHES.lumesh("convert", mesh, cls.folders[mesh])

    def each(self):
        for mesh, folder in self.folders.items():
            with self.subTest(mesh.name):
                yield mesh, folder, Volume(folder)

    def test_volume_counts_nodes_and_elements_from_1(self):
        for mesh, _, volume in self.each():
            reference = readers.vtk_mesh(readers.vtk_data(mesh))
            np.testing.assert_array_equal(volume.points, reference.points)
            np.testing.assert_array_equal(volume.node_ids, np.arange(len(volume.points)) + 1)
            np.testing.assert_array_equal(volume.element_ids, np.arange(len(volume.elements)) + 1)
            np.testing.assert_array_equal(volume.elements, reference.cells["tetra"][0])
            np.testing.assert_array_equal(volume.regions, reference.cells["tetra"][1])

    def test_every_face_is_one_of_its_element_at_the_same_points_and_looks_out(self):
        for _, folder, volume in self.each():
            files = list(folder.rglob("*.vtp"))
            self.assertGreaterEqual(len(files), 4)
            for path in files:
                faces = Faces(path)
                np.testing.assert_array_equal(volume.points[faces.node_ids - 1], faces.points)
                elements = volume.elements[faces.element_ids - 1]
                inside = (elements[:, None, :] == faces.nodes()[:, :, None]).any(axis=2)
                self.assertTrue(inside.all(), path.name)
                np.testing.assert_array_equal(faces.regions, volume.regions[faces.element_ids - 1])
                a, b, c = (volume.points[faces.nodes()[:, i]] for i in range(3))
                outward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a - volume.points[elements].mean(axis=1))
                self.assertGreater(outward.min(), 0, path.name)

    def test_exterior_is_every_face_that_one_element_has_alone(self):
        for _, folder, volume in self.each():
            sides = collections.Counter(tuple(sorted(np.delete(element, i))) for element in volume.elements.tolist()
                                        for i in range(4))
            exterior = Faces(folder / "mesh-complete.exterior.vtp")
            found = [tuple(sorted(face)) for face in exterior.nodes().tolist()]
            self.assertEqual(sorted(found), sorted(side for side, count in sides.items() if count == 1))

    def test_files_of_patches_have_their_names_areas_and_numbers(self):
        for mesh, folder, _ in self.each():
            _, expected = MESHES.measured(mesh)
            inner = {name for name in expected if name.startswith("interface")}
            surfaces = {path.stem: Faces(path) for path in (folder / "mesh-surfaces").iterdir()}
            interfaces = {path.stem: Faces(path) for path in folder.glob("mesh-interfaces/*")}
            self.assertEqual((set(surfaces), set(interfaces)), (set(expected) - inner, inner))
            numbers = {name: position + 1 for position, name in enumerate(expected)}
            for name, faces in (surfaces | interfaces).items():
                self.assertAlmostEqual(faces.area() / expected[name], 1, delta=1e-9)
                self.assertEqual(set(faces.face_ids.tolist()), {numbers[name]})
            exterior = Faces(folder / "mesh-complete.exterior.vtp")
            self.assertEqual(len(exterior.corners), sum(len(faces.corners) for faces in surfaces.values()))
            walls = sum(len(faces.corners) for name, faces in surfaces.items() if name.startswith("wall"))
            self.assertEqual(len(Faces(folder / "walls_combined.vtp").corners), walls)

    def test_arrays_are_inline_and_packed_with_zlib(self):
        for _, folder, _ in self.each():
            for path in folder.rglob("*.vt?"):
                text = path.read_text()
                self.assertIn('compressor="vtkZLibDataCompressor"', text)
                self.assertNotIn("<AppendedData", text)


if __name__ == "__main__":
    unittest.main(verbosity=2)
