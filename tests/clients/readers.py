"""Meshes as VTK, meshio and Gmsh see them, in one shape: a Mesh of numpy arrays. Whatever a client says besides is a fault."""
import contextlib
import dataclasses
import io
import re
import subprocess

import meshio
import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkOutputWindow, vtkStringOutputWindow
from vtkmodules.vtkFiltersGeneral import vtkCellValidator
from vtkmodules.vtkFiltersGeometry import vtkDataSetSurfaceFilter
from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter
from vtkmodules.vtkIOGeometry import vtkOpenFOAMReader, vtkSTLReader
from vtkmodules.vtkIOLegacy import vtkUnstructuredGridReader, vtkUnstructuredGridWriter
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLUnstructuredGridReader, vtkXMLUnstructuredGridWriter

VTK_READERS = {".vtu": vtkXMLUnstructuredGridReader, ".vtk": vtkUnstructuredGridReader, ".vtp": vtkXMLPolyDataReader,
               ".stl": vtkSTLReader}
VTK_SHAPES = {5: "triangle", 9: "quad", 10: "tetra", 12: "hexahedron", 13: "wedge", 14: "pyramid"}
VOLUME_SHAPES = ("tetra", "hexahedron", "wedge", "pyramid")


class Complaint(AssertionError):
    """A client has read the file but says that something is wrong with it."""


@dataclasses.dataclass
class Mesh:
    points: np.ndarray
    cells: dict                                        # shape -> (corners, tags): int arrays, a row per cell
    names: dict = dataclasses.field(default_factory=dict)  # (dimension, tag) -> physical name

    def count(self, shapes):
        return sum(len(self.cells[shape][0]) for shape in shapes if shape in self.cells)

    def rows(self, shape):
        """Corners and tag of every cell, sorted: formats may reorder cells, but not corners."""
        corners, tags = self.cells[shape]
        rows = np.column_stack([corners, tags]).astype(np.int64)
        return rows[np.lexsort(rows.T[::-1])]


def vtk_data(path):
    """What VTK's own reader gives."""
    window = vtkStringOutputWindow()
    before = vtkOutputWindow.GetInstance()
    vtkOutputWindow.SetInstance(window)
    reader = VTK_READERS[path.suffix]()
    reader.SetFileName(str(path))
    reader.Update()
    vtkOutputWindow.SetInstance(before)
    if window.GetOutput():
        raise Complaint(f"VTK on {path.name}: {window.GetOutput()}")
    return reader.GetOutput()


def vtk_outer_faces(data):
    """The faces of cells that no other cell has."""
    surface = vtkDataSetSurfaceFilter()
    surface.SetInputData(data)
    surface.Update()
    return surface.GetOutput()


def vtk_blocks(path):
    """The blocks of an OpenFOAM case by name, as VTK and ParaView see them: internalMesh, patches and zones."""
    reader = vtkOpenFOAMReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    reader.EnableAllPatchArrays()
    reader.SetReadZones(True)
    reader.DecomposePolyhedraOff()
    reader.Update()
    found = {}

    def gather(blocks):
        for number in range(blocks.GetNumberOfBlocks()):
            block = blocks.GetBlock(number)
            if block.IsA("vtkMultiBlockDataSet"):
                gather(block)
            else:
                found[blocks.GetMetaData(number).Get(blocks.NAME())] = block

    gather(reader.GetOutput())
    return found


def vtk_mesh(grid):
    kinds = vtk_to_numpy(grid.GetCellTypesArray())
    connectivity = vtk_to_numpy(grid.GetCells().GetConnectivityArray())
    offsets = vtk_to_numpy(grid.GetCells().GetOffsetsArray())
    labels = vtk_to_numpy(grid.GetCellData().GetArray("label"))
    cells = {}
    for kind in np.unique(kinds):
        of_kind = np.flatnonzero(kinds == kind)
        corners = offsets[of_kind[0] + 1] - offsets[of_kind[0]]
        cells[VTK_SHAPES[kind]] = (connectivity[offsets[of_kind][:, None] + np.arange(corners)], labels[of_kind])
    return Mesh(vtk_to_numpy(grid.GetPoints().GetData()), cells)


def vtk_faults(data):
    """The cells that vtkCellValidator objects to, by its words."""
    validator = vtkCellValidator()
    validator.SetInputData(data)
    validator.Update()
    states = vtk_to_numpy(validator.GetOutput().GetCellData().GetArray("ValidityState"))
    words = {1: "wrong number of points", 2: "intersecting edges", 4: "intersecting faces", 8: "edges not contiguous",
             16: "not convex", 32: "faces oriented incorrectly"}
    found = {word: int(np.count_nonzero(states & bit)) for bit, word in words.items()}
    return {word: count for word, count in found.items() if count > 0}


def vtk_sizes(data, name):
    """Volume or Area of every cell."""
    sizes = vtkCellSizeFilter()
    sizes.SetInputData(data)
    sizes.Update()
    return vtk_to_numpy(sizes.GetOutput().GetCellData().GetArray(name))


def write_vtu_with_vtk(data, path, encoding, compression):
    writer = vtkXMLUnstructuredGridWriter()
    writer.SetInputData(data)
    writer.SetFileName(str(path))
    {"inline": writer.SetDataModeToBinary, "ascii": writer.SetDataModeToAscii}.get(encoding, writer.SetDataModeToAppended)()
    writer.SetEncodeAppendedData(encoding == "appended base64")
    (writer.SetCompressorTypeToZLib if compression == "zlib" else writer.SetCompressorTypeToNone)()
    writer.Write()


def write_legacy_with_vtk(data, path, kind, version):
    writer = vtkUnstructuredGridWriter()
    writer.SetInputData(data)
    writer.SetFileName(str(path))
    writer.SetFileVersion(version)
    (writer.SetFileTypeToBinary if kind == "binary" else writer.SetFileTypeToASCII)()
    writer.Write()


def vtk_field_text(data, name):
    array = data.GetFieldData().GetArray(name)
    return bytes(vtk_to_numpy(array).astype(np.uint8)).decode() if array is not None else None


def meshio_data(path):
    said = io.StringIO()
    with contextlib.redirect_stderr(said), contextlib.redirect_stdout(said):
        mesh = meshio.read(path)
    if said.getvalue().strip():
        raise Complaint(f"meshio on {path.name}: {said.getvalue().strip()}")
    return mesh


def meshio_mesh(path, tag_name):
    data = meshio_data(path)
    cells = {}
    for number, block in enumerate(data.cells):
        tags = np.asarray(data.cell_data[tag_name][number]) if tag_name else np.zeros(len(block.data), int)
        before = cells.get(block.type)
        cells[block.type] = (block.data, tags) if before is None else (np.vstack([before[0], block.data]),
                                                                       np.concatenate([before[1], tags]))
    physical = path.suffix == ".msh"
    names = {(int(value[1]), int(value[0])): name for name, value in data.field_data.items()} if physical else {}
    return Mesh(np.asarray(data.points), cells, names)


def gmsh(*arguments):
    """What Gmsh prints; its exit status says nothing."""
    return subprocess.run(["gmsh", *map(str, arguments)], capture_output=True, text=True, errors="replace", timeout=300,
                          check=False, stdin=subprocess.DEVNULL)


def gmsh_check(path):
    """Gmsh's own check of a file: how many nodes and elements it found."""
    result = gmsh("-check", path)
    said = result.stdout + result.stderr
    if result.returncode != 0 or re.search(r"error|warning|duplicate (?!nodes\.\.\.|elements\.\.\.)", said, re.IGNORECASE) \
            or "Done checking mesh coherence" not in said:
        raise Complaint(f"gmsh -check {path.name}: {said}")
    nodes = re.search(r"(\d+) (?:nodes|points)", said)  # It does not say so of STL.
    return int(nodes.group(1)) if nodes else None, int(re.search(r"\((\d+) elements\)", said).group(1))


def gmsh_smallest_jacobian(path, scratch):
    """Of all cells: positive if none is inside out in Gmsh's order of corners."""
    scratch.write_text(f'Merge "{path}";\nPlugin(AnalyseMeshQuality).JacobianDeterminant = 1;\n'
                       "Plugin(AnalyseMeshQuality).Run;\n")
    said = gmsh("-", scratch).stdout
    return float(re.search(r"minJ\s*=\s*(\S+),", said).group(1))
