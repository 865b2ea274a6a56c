#!/usr/bin/env python3
"""What Gmsh, VTK and meshio make of the files that lumesh writes.

Usage: clients_test.py LUMESH      Exit status 77: the clients' Debian packages are missing.
"""
import functools
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import debian_python

debian_python.run_here_or_under_debian()

import numpy as np
import readers
from readers import VOLUME_SHAPES

LUMESH = str(pathlib.Path(sys.argv.pop(1)).resolve())
# Format -> the array in which meshio keeps its labels.
MESH_FORMATS = {"a.vtu": "label", "a.vtk": "label", "a.mesh": "medit:ref", "a.meshb": "medit:ref",
                "a41.msh": "gmsh:physical", "a22.msh": "gmsh:physical"}

# A unit cube, a pyramid on it, a prism beside it (corners 0 1 2 turned outwards, as VTK wants it), a tetrahedron.
EVERY_SHAPE = """<VTKFile type="UnstructuredGrid" version="0.1"><UnstructuredGrid>
<Piece NumberOfPoints="12" NumberOfCells="4"><Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">
0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1 2 0 0 2 1 0 0.5 0.5 2 0.5 -1 1.5</DataArray></Points>
<Cells><DataArray type="Int32" Name="connectivity" format="ascii">0 1 2 3 4 5 6 7  4 5 6 7 10  1 8 5 2 9 6  4 5 10 11</DataArray>
<DataArray type="Int32" Name="offsets" format="ascii">8 13 19 23</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">12 14 13 10</DataArray></Cells>
<CellData><DataArray type="Int32" Name="label" format="ascii">1 2 3 7</DataArray></CellData></Piece></UnstructuredGrid></VTKFile>
"""
EVERY_VOLUME = {"hexahedron": 1, "pyramid": 1 / 3, "wedge": 1 / 2, "tetra": 1.25 / 6}


def lumesh(*arguments):
    result = subprocess.run([LUMESH, *map(str, arguments)], capture_output=True, text=True, timeout=300, check=False)
    if result.returncode != 0:
        raise AssertionError(f"lumesh {' '.join(map(str, arguments))}: {result.stderr}")
    return result.stdout


class Files:
    """One mesh in every format."""

    def __init__(self, folder, make):
        self.folder = folder
        folder.mkdir()
        make(folder, folder / "a.vtu")
        for name in ("a.vtk", "a.mesh", "a.meshb", "a.vtp", "a.stl", "a.off", "a.foam", "a41.msh"):
            lumesh("convert", folder / "a.vtu", folder / name)
        lumesh("convert", folder / "a.vtu", folder / "a22.msh", "--msh-version", "2.2")
        self.info = json.loads(lumesh("info", folder / "a.vtu", "--json"))
        self.reference = readers.vtk_mesh(readers.vtk_data(folder / "a.vtu"))

    def __truediv__(self, name):
        return self.folder / name

    @property
    def faces(self):
        return sum(patch["faces"] for patch in self.info["patches"])

    @property
    def outside(self):
        """The faces of one cell alone, as VTK finds them."""
        return readers.vtk_outer_faces(readers.vtk_data(self.folder / "a.vtu"))

    @property
    def cells(self):
        return self.reference.count(VOLUME_SHAPES)


def make_sphere(folder, mesh):
    lumesh("phantom", "sphere", "-o", folder / "a.nrrd", "--size", 40, 40, 40)
    lumesh("lattice", folder / "a.nrrd", "-o", mesh, "--mixed", "--spacing", "1.5")


def make_layered(folder, mesh):
    lumesh("phantom", "layered", "-o", folder / "a.nrrd", "--size", 48, 48, 48, "--rotate", 20, 30, 40)
    lumesh("lattice", folder / "a.nrrd", "-o", mesh, "--max-tetrahedra", 40000)


def make_every_shape(folder, mesh):
    (folder / "by_hand.vtu").write_text(EVERY_SHAPE)
    lumesh("convert", folder / "by_hand.vtu", mesh)


def setUpModule():
    global ALL
    folder = tempfile.TemporaryDirectory(prefix="lumesh_clients_")
    unittest.addModuleCleanup(folder.cleanup)
    root = pathlib.Path(folder.name)
    ALL = {name: Files(root / name, make) for name, make in
           (("sphere", make_sphere), ("layered", make_layered), ("every_shape", make_every_shape))}


def for_each(*names):
    """Runs a test for every mesh, or for every mesh with each of the files."""
    def decorate(test):
        @functools.wraps(test)
        def run(self):
            for title, files in ALL.items():
                for name in names or [None]:
                    with self.subTest(mesh=title, file=name):
                        test(self, files, *([name] if names else []))
        return run
    return decorate


class PhantomTest(unittest.TestCase):
    def test_the_meshes_hold_what_these_tests_are_about(self):
        self.assertEqual(set(ALL["sphere"].reference.cells), {"tetra", "pyramid", "hexahedron"})
        self.assertGreater(ALL["sphere"].reference.count(["hexahedron"]), 20)
        self.assertEqual([label["label"] for label in ALL["layered"].info["labels"]], [1, 2, 3])
        names = {patch["name"] for patch in ALL["layered"].info["patches"]}
        self.assertLessEqual({"interface_1_2", "interface_2_3", "wall_3"}, names)
        self.assertEqual(set(ALL["every_shape"].reference.cells), {"tetra", "pyramid", "hexahedron", "wedge"})


class VtkTest(unittest.TestCase):
    @for_each("a.vtu", "a.vtk", "a.vtp", "a.stl")
    def test_every_cell_is_valid(self, files, name):
        data = readers.vtk_data(files / name)
        self.assertEqual(data.GetNumberOfCells(), files.cells if name in MESH_FORMATS else data.GetNumberOfPolys())
        self.assertGreater(data.GetNumberOfCells(), 0)
        self.assertEqual(readers.vtk_faults(data), {})

    @for_each("a.vtu", "a.vtk")
    def test_every_volume_is_positive(self, files, name):
        self.assertGreater(readers.vtk_sizes(readers.vtk_data(files / name), "Volume").min(), 0)

    def test_volumes_known_by_hand(self):
        files = ALL["every_shape"]
        data = readers.vtk_data(files / "a.vtu")
        shapes = [readers.VTK_SHAPES[data.GetCellType(i)] for i in range(data.GetNumberOfCells())]
        for shape, volume in zip(shapes, readers.vtk_sizes(data, "Volume"), strict=True):
            self.assertAlmostEqual(volume, EVERY_VOLUME[shape], places=12, msg=shape)

    @for_each("a.vtu", "a.vtk")
    def test_label_is_an_int32_cell_array(self, files, name):
        array = readers.vtk_data(files / name).GetCellData().GetArray("label")
        self.assertEqual((array.GetDataTypeAsString(), array.GetNumberOfComponents()), ("int", 1))

    @for_each()
    def test_legacy_file_equals_the_xml_file(self, files):
        self.assert_same(readers.vtk_mesh(readers.vtk_data(files / "a.vtk")), files.reference)

    def assert_same(self, mesh, reference):
        np.testing.assert_array_equal(mesh.points, reference.points)
        for shape in reference.cells:
            np.testing.assert_array_equal(mesh.rows(shape), reference.rows(shape))

    @for_each("a.vtu", "a.vtp")
    def test_field_data_say_unit_and_frame_in_plain_words(self, files, name):
        data = readers.vtk_data(files / name)
        self.assertEqual((readers.vtk_field_text(data, "unit"), readers.vtk_field_text(data, "frame")), ("mm", "LPS"))

    @for_each("a.vtu", "a.vtp", "a.vtk")
    def test_field_data_hold_patches_and_provenance(self, files, name):
        info = json.loads(readers.vtk_field_text(readers.vtk_data(files / name), "lumesh_info"))
        self.assertEqual((info["unit"], info["frame"]), ("mm", "LPS"))
        self.assertEqual([patch["name"] for patch in info["patches"]], [patch["name"] for patch in files.info["patches"]])
        self.assertEqual(info["provenance"], files.info["provenance"])
        if files is not ALL["every_shape"]:
            self.assertLessEqual({"program", "input", "input_sha256"}, set(info["provenance"]))

    @for_each()
    def test_surface_has_the_faces_of_each_patch(self, files):
        array = readers.vtk_data(files / "a.vtp").GetCellData().GetArray("patch")
        self.assertEqual(array.GetDataTypeAsString(), "int")
        patches = np.bincount(readers.vtk_to_numpy(array), minlength=len(files.info["patches"]))
        self.assertEqual(patches.tolist(), [patch["faces"] for patch in files.info["patches"]])

    @for_each()
    def test_stl_has_the_area_of_the_outer_surface(self, files):
        area = readers.vtk_sizes(files.outside, "Area").sum()
        self.assertAlmostEqual(readers.vtk_sizes(readers.vtk_data(files / "a.stl"), "Area").sum() / area, 1, places=6)


class OffTest(unittest.TestCase):
    @for_each()
    def test_off_holds_every_outer_triangle_where_it_has_no_others(self, files):
        if "quad" not in readers.meshio_mesh(files / "a41.msh", "gmsh:physical").cells:  # meshio takes triangles alone.
            mesh = readers.meshio_mesh(files / "a.off", None)
            outside = files.outside
            self.assertEqual(mesh.count(["triangle"]), outside.GetNumberOfCells())
            self.assertEqual(len(mesh.points), outside.GetNumberOfPoints())


class OpenFoamTest(unittest.TestCase):
    """VTK's reader of OpenFOAM's cases, which is ParaView's; it keeps points in single precision."""

    @for_each()
    def test_cells_keep_their_order_shape_and_volume(self, files):
        grid = readers.vtk_blocks(files / "a.foam")["internalMesh"]
        reference = readers.vtk_data(files / "a.vtu")
        self.assertEqual(grid.GetNumberOfCells(), files.cells)
        shapes = readers.vtk_to_numpy(reference.GetCellTypesArray())
        np.testing.assert_array_equal(readers.vtk_to_numpy(grid.GetCellTypesArray()), shapes)
        np.testing.assert_allclose(readers.vtk_sizes(grid, "Volume") * 1e9, readers.vtk_sizes(reference, "Volume"), rtol=1e-3)

    @for_each()
    def test_patches_and_zones_have_the_faces_of_each_patch(self, files):
        blocks = readers.vtk_blocks(files / "a.foam")
        self.assertEqual({patch["name"]: blocks[patch["name"]].GetNumberOfCells() for patch in files.info["patches"]},
                         {patch["name"]: patch["faces"] for patch in files.info["patches"]})

    @for_each()
    def test_zones_have_the_cells_of_each_label(self, files):
        blocks = readers.vtk_blocks(files / "a.foam")
        labels = np.concatenate([tags for shape, (_, tags) in files.reference.cells.items() if shape in VOLUME_SHAPES])
        for label, count in zip(*np.unique(labels, return_counts=True)):
            self.assertEqual(blocks[f"label_{label}"].GetNumberOfCells(), count)


def assert_meshio_cells(mesh, files):
    """meshio turns prisms of VTK into Gmsh's order, which has the triangles the other way round."""
    for shape in files.reference.cells:
        expected = files.reference.rows(shape)
        if shape == "wedge":
            expected = expected[:, [0, 2, 1, 3, 5, 4, 6]]
        np.testing.assert_array_equal(mesh.rows(shape), expected)


class MeshioTest(unittest.TestCase):
    @for_each(*MESH_FORMATS)
    def test_every_format_holds_the_same_cells_labels_and_points(self, files, name):
        mesh = readers.meshio_mesh(files / name, MESH_FORMATS[name])
        np.testing.assert_allclose(mesh.points, files.reference.points, rtol=1e-6, atol=0)
        self.assertEqual(mesh.count(VOLUME_SHAPES), files.cells)
        assert_meshio_cells(mesh, files)

    @for_each("a.mesh", "a.meshb", "a41.msh", "a22.msh")
    def test_formats_with_boundary_faces_hold_each_patch(self, files, name):
        mesh = readers.meshio_mesh(files / name, MESH_FORMATS[name])
        tags = np.concatenate([mesh.cells[shape][1] for shape in ("triangle", "quad") if shape in mesh.cells])
        expected = {number + 1: patch["faces"] for number, patch in enumerate(files.info["patches"]) if patch["faces"] > 0}
        self.assertEqual({int(tag): int(count) for tag, count in zip(*np.unique(tags, return_counts=True))}, expected)

    @for_each("a41.msh", "a22.msh")
    def test_gmsh_files_name_patches_and_labels(self, files, name):
        expected = {(2, number + 1): patch["name"] for number, patch in enumerate(files.info["patches"])}
        expected |= {(3, label["label"]): f"label_{label['label']}" for label in files.info["labels"]}
        self.assertEqual(readers.meshio_mesh(files / name, "gmsh:physical").names, expected)

    @for_each()
    def test_stl_holds_every_outer_face(self, files):
        outside = files.outside
        triangles = sum(outside.GetCell(i).GetNumberOfPoints() - 2 for i in range(outside.GetNumberOfCells()))
        self.assertEqual(readers.meshio_mesh(files / "a.stl", None).count(["triangle"]), triangles)

    @for_each()
    def test_other_programs_find_labels_under_their_own_names(self, files):
        for program, array in (("gmsh", "gmsh:physical"), ("medit", "medit:ref"), ("simvascular", "ModelRegionID")):
            path = files / f"{program}.vtu"
            lumesh("convert", files / "a.vtu", path, "--compat", program)
            mesh = readers.meshio_mesh(path, array)
            assert_meshio_cells(mesh, files)


class ForeignFilesTest(unittest.TestCase):
    """What other programs make of a file of ours, lumesh reads again."""

    def assert_read_alike(self, files, path):
        info = json.loads(lumesh("info", path, "--json"))
        for key in ("points", "tetrahedra", "pyramids", "prisms", "hexahedra", "labels"):
            self.assertEqual(info[key], files.info[key], f"{path.name}: {key}")
        np.testing.assert_allclose(info["box"], files.info["box"], rtol=1e-9, atol=1e-9)

    @for_each("inline", "ascii", "appended base64", "appended raw")
    def test_vtu_in_every_encoding_of_vtk(self, files, encoding):
        for compression in ("zlib", "none"):
            path = files / f"by_vtk_{encoding.replace(' ', '_')}_{compression}.vtu"
            readers.write_vtu_with_vtk(readers.vtk_data(files / "a.vtu"), path, encoding, compression)
            self.assert_read_alike(files, path)

    @for_each("binary", "ascii")
    def test_legacy_vtk_by_vtk(self, files, kind):
        for version in (42, 51):
            path = files / f"by_vtk_{kind}_{version}.vtk"
            readers.write_legacy_with_vtk(readers.vtk_data(files / "a.vtu"), path, kind, version)
            self.assert_read_alike(files, path)

    @for_each(".vtu", ".vtk", ".mesh", ".meshb")
    def test_files_by_meshio(self, files, suffix):
        mesh = readers.meshio_data(files / "a.vtu")
        self.assertEqual({values.ndim for values in mesh.cell_data["label"]}, {1})
        if suffix.startswith(".mesh"):
            mesh.cell_data = {"medit:ref": mesh.cell_data["label"]}
            mesh.field_data = {}
        path = files / f"by_meshio{suffix}"
        mesh.write(path)
        self.assert_read_alike(files, path)


class MetricTest(unittest.TestCase):
    """A metric tensor per point, all six numbers different: given as full matrices, written in VTK's order."""
    MATRIX = np.array([[4, 0.5, -0.25], [0.5, 9.25, 1.5], [-0.25, 1.5, 16]])
    IN_VTK_ORDER = np.array([4, 9.25, 16, 0.5, 1.5, -0.25])
    SCALES = np.arange(1, 13) / 3

    @classmethod
    def setUpClass(cls):
        cls.folder = ALL["every_shape"].folder
        numbers = " ".join(map(repr, np.concatenate([scale * cls.MATRIX.ravel() for scale in cls.SCALES]).tolist()))
        array = f'<DataArray type="Float64" Name="metric" NumberOfComponents="9" format="ascii">{numbers}</DataArray>'
        by_hand = cls.folder / "metric_by_hand.vtu"
        by_hand.write_text(EVERY_SHAPE.replace("<Points>", f"<PointData>{array}</PointData><Points>"))
        for suffix in ("vtu", "vtk"):
            lumesh("convert", by_hand, cls.folder / f"metric.{suffix}")
        cls.expected = np.outer(cls.SCALES, cls.IN_VTK_ORDER)

    def vtk_array(self, name):
        return readers.vtk_data(self.folder / name).GetPointData().GetArray("metric")

    def test_vtk_sees_the_tensors(self):
        for name in ("metric.vtu", "metric.vtk"):
            array = self.vtk_array(name)
            self.assertEqual((array.GetDataTypeAsString(), array.GetNumberOfComponents()), ("double", 6), name)
            np.testing.assert_array_equal(readers.vtk_to_numpy(array), self.expected, name)

    def test_vtk_sees_the_names_of_the_components(self):
        array = self.vtk_array("metric.vtu")
        self.assertEqual([array.GetComponentName(i) for i in range(6)], ["XX", "YY", "ZZ", "XY", "YZ", "XZ"])

    def test_vtk_takes_it_as_the_tensors_of_the_points(self):
        tensors = readers.vtk_data(self.folder / "metric.vtu").GetPointData().GetTensors()
        self.assertEqual(tensors.GetName(), "metric")

    def test_meshio_sees_the_tensors(self):
        for name in ("metric.vtu", "metric.vtk"):
            np.testing.assert_array_equal(readers.meshio_data(self.folder / name).point_data["metric"], self.expected, name)

    def test_lumesh_reads_what_vtk_writes(self):
        """VTK writes the tensors of points as the section TENSORS6, other arrays as a field."""
        for kind in ("binary", "ascii"):
            for version in (42, 51):
                for role in ("tensors", "array"):
                    with self.subTest(kind=kind, version=version, role=role):
                        data = readers.vtk_data(self.folder / "metric.vtu")
                        if role == "array":
                            data.GetPointData().SetActiveTensors(None)
                        path = self.folder / f"metric_by_vtk_{kind}_{version}_{role}.vtk"
                        readers.write_legacy_with_vtk(data, path, kind, version)
                        self.assertEqual(b"TENSORS6 metric" in path.read_bytes(), role == "tensors")
                        self.assert_read_alike(path)

    def test_lumesh_reads_what_meshio_writes(self):
        for suffix in (".vtu", ".vtk"):
            path = self.folder / f"metric_by_meshio{suffix}"
            readers.meshio_data(self.folder / "metric.vtu").write(path)
            self.assert_read_alike(path)

    def assert_read_alike(self, path):
        lumesh("convert", path, self.folder / "metric_again.vtu")
        np.testing.assert_allclose(readers.vtk_to_numpy(self.vtk_array("metric_again.vtu")), self.expected, rtol=1e-9)


class GmshTest(unittest.TestCase):
    # Gmsh 4.8 of Debian 12 does not read .meshb, leaves the pyramids and prisms of .mesh out, and takes VTK's
    # prisms in its own order.
    @for_each("a41.msh", "a22.msh", "a.stl")
    def test_check_finds_nothing_to_complain_about(self, files, name):
        nodes, elements = readers.gmsh_check(files / name)
        if name != "a.stl":
            self.assertEqual((nodes, elements), (len(files.reference.points), files.cells + files.faces))

    @for_each("a.mesh")
    def test_check_finds_nothing_to_complain_about_in_medit_files(self, files, name):
        if "wedge" not in files.reference.cells:
            nodes, elements = readers.gmsh_check(files / name)
            self.assertEqual(nodes, len(files.reference.points))
            self.assertEqual(elements, files.cells + files.faces - files.reference.count(["pyramid"]))

    @for_each("a.vtk")
    def test_check_finds_nothing_to_complain_about_in_legacy_vtk(self, files, name):
        if "wedge" not in files.reference.cells:
            self.assertEqual(readers.gmsh_check(files / name), (len(files.reference.points), files.cells))

    def test_check_does_complain_about_a_broken_file(self):
        broken = ALL["sphere"] / "broken.msh"
        broken.write_text((ALL["sphere"] / "a41.msh").read_text().replace("$Nodes\n1 ", "$Nodes\n2 ", 1))
        with self.assertRaises(readers.Complaint):
            readers.gmsh_check(broken)

    @for_each("a41.msh", "a22.msh")
    def test_no_cell_is_inside_out(self, files, name):
        self.assertGreater(readers.gmsh_smallest_jacobian(files / name, files / "quality.geo"), 0)

    @for_each()
    def test_lumesh_reads_what_gmsh_writes(self, files):
        for version in ("msh41", "msh22"):
            path = files / f"by_gmsh_{version}.msh"
            readers.gmsh("-", files / "a41.msh", "-save", "-format", version, "-o", path)
            info = json.loads(lumesh("info", path, "--json"))
            for key in ("points", "tetrahedra", "pyramids", "prisms", "hexahedra", "labels"):
                self.assertEqual(info[key], files.info[key], key)
            names_and_faces = [[(patch["name"], patch["faces"]) for patch in of["patches"]] for of in (info, files.info)]
            self.assertEqual(*names_and_faces)  # Gmsh keeps no kinds.


if __name__ == "__main__":
    unittest.main(verbosity=2)
