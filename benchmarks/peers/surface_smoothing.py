#!/usr/bin/env python3
"""Compares the surfaces that today's tools make from label images with lumesh's, on shapes known by a formula.

Shapes: tubes of R = 2, 3, 5, 10 voxels along an axis, two degrees off one, and in random directions; a torus (20, 4); a stenosis
(R = 5, 2.5 in the middle). A voxel belongs to a shape if its centre does. Each is made at --places random places from seeds.

slicer         3D Slicer's default: discrete flying edges, windowed sinc with pass band 10^(-4 f), f = 0.5, 20 iterations
vmtk           marching cubes of the labels, vmtksurfacesmoothing as its tutorials say: windowed sinc, pass band 0.1, 30 iterations
surfacenets    vtkSurfaceNets3D with its default smoothing, if this VTK has it (9.3 and later)
antialias-R    itk::AntiAliasBinaryImageFilter to an r.m.s. change of R = 0.07, its default, and 0.01, flying edges of its zero level;
               needs --itk-antialias
gauss          the indicator blurred by a Gaussian of sigma 1 voxel, much as ITK-SNAP does, flying edges of its level 0.5
lumesh         the boundary that `lumesh delaunay --surface` writes, R / 5 but at most 0.6 voxels between points

Figures over the vertices, weighted with their areas, away from the round ends of the vessels: r.m.s. angle between the vertices'
normals (means of the triangles', weighted by angles) and the exact ones, in degrees; roughness, the r.m.s. distance to the exact
surface about its mean, in voxels; error of the radius (tubes: mean of 41 sections by area) or of the volume (torus; stenosis: sum
of 41 sections), in %. Over the places: r.m.s. of the first two, the mean of the third and its largest absolute value.
A markdown table on stdout, all figures as JSON lines with --json.

Usage: surface_smoothing.py [--program PATH] [--itk-antialias PATH] [--places 5] [--seed 1] [--json FILE] [SHAPE...]
"""
import argparse
import collections
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import zlib

DEBIAN_PYTHON = "/usr/bin/python3"  # It has numpy and VTK.
if __name__ == "__main__" and os.path.realpath(sys.executable) != os.path.realpath(DEBIAN_PYTHON) and os.access(DEBIAN_PYTHON, os.X_OK):
    os.execv(DEBIAN_PYTHON, [DEBIAN_PYTHON, *sys.argv])

import numpy as np  # noqa: E402
import vtk  # noqa: E402
from vtk.util import numpy_support  # noqa: E402

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cases"))
import digitised  # noqa: E402
import run  # noqa: E402  (ROOT)

SHAPES = [f"R{radius}-{kind}" for radius in (2, 3, 5, 10) for kind in ("axis", "2deg", "oblique")] + ["torus", "stenosis"]
ANTIALIAS_ITERATIONS = 1000
FINEST_VOXELS = 0.6


def shape_at(name, seed):
    random = np.random.default_rng([seed, zlib.crc32(name.encode())])
    centre, direction = random.uniform(-0.5, 0.5, 3), np.array([0.0, 0.0, 1.0])
    angle = random.uniform(0, 2 * np.pi)
    if name == "torus":
        return digitised.Torus(20, 4, direction + random.uniform(0, 0.3, 3), centre)
    if name == "stenosis":
        return digitised.Vessel(5, direction + 0.06 * digitised.across(direction, angle), centre, 30, narrowing=2.5)
    radius, kind = int(name.split("-")[0][1:]), name.split("-")[1]
    if kind == "2deg":
        direction = np.cos(np.radians(2)) * direction + np.sin(np.radians(2)) * digitised.across(direction, angle)
    elif kind == "oblique":
        direction = digitised.unit(random.normal(size=3))
        while np.abs(direction).min() < np.sin(np.radians(20)):  # Off each axis and each plane of two.
            direction = digitised.unit(random.normal(size=3))
    return digitised.Vessel(radius, direction, centre, 36 + radius)  # 72 long: two terraces of a tube two degrees off an axis.


def vtk_image(values):
    image = vtk.vtkImageData()
    image.SetDimensions(*values.shape)
    image.GetPointData().SetScalars(numpy_support.numpy_to_vtk(values.ravel(order="F"), deep=1))
    return image


def output(filter_, data):
    filter_.SetInputData(data)
    filter_.Update()
    return filter_.GetOutput()


def level_surface(values, level, contour=vtk.vtkFlyingEdges3D):
    filter_ = contour()
    filter_.SetValue(0, level)
    filter_.ComputeNormalsOff()
    filter_.ComputeGradientsOff()
    return output(filter_, vtk_image(values))


def windowed_sinc(surface, iterations, pass_band):
    """As 3D Slicer and VMTK set it but for what concerns borders and seams of labels, which these surfaces have not."""
    filter_ = vtk.vtkWindowedSincPolyDataFilter()
    filter_.SetNumberOfIterations(iterations)
    filter_.SetPassBand(pass_band)
    filter_.NormalizeCoordinatesOn()
    filter_.BoundarySmoothingOff()
    filter_.FeatureEdgeSmoothingOff()
    filter_.NonManifoldSmoothingOn()
    return output(filter_, surface)


def blurred(labels, sigma=1.0):
    values, reach = labels.astype(float), int(np.ceil(4 * sigma))
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2)
    for axis in range(3):
        values = np.apply_along_axis(np.convolve, axis, values, kernel / kernel.sum(), mode="same")
    return values.astype(np.float32)


def antialiased(labels, rms, program, folder):
    (folder / "labels.raw").write_bytes(labels.tobytes(order="F"))
    words = ["labels.raw", "levels.raw", *labels.shape, rms, ANTIALIAS_ITERATIONS]
    subprocess.run([program, *map(str, words)], cwd=folder, check=True)
    return np.fromfile(folder / "levels.raw", np.float32).reshape(labels.shape, order="F")


def surface_nets(labels):
    filter_ = vtk.vtkSurfaceNets3D()
    filter_.SetValue(0, 1)
    return output(filter_, vtk_image(labels))


def of_lumesh(labels, shape, program, folder):
    digitised.write_nrrd(folder / "shape.nrrd", labels, (0, 0, 0))
    delta = min(FINEST_VOXELS, shape.radius / 5)
    command = [program, "delaunay", "shape.nrrd", "-o", "shape.vtu", "--delta", delta, "--surface", "shape.vtp", "--threads", 1, "-q"]
    subprocess.run([*map(str, command)], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(str(folder / "shape.vtp"))
    reader.Update()
    return reader.GetOutput()


def makers(arguments, folder):
    """By method: what makes a surface of labels; the methods that can run here."""
    found = {
        "slicer": lambda labels, _: windowed_sinc(level_surface(labels, 1, vtk.vtkDiscreteFlyingEdges3D), 20, 10 ** (-4 * 0.5)),
        "vmtk": lambda labels, _: windowed_sinc(level_surface(labels.astype(np.float32), 0.5, vtk.vtkMarchingCubes), 30, 0.1),
        "surfacenets": lambda labels, _: surface_nets(labels),
        "antialias-0.07": lambda labels, _: level_surface(antialiased(labels, 0.07, arguments.itk_antialias, folder), 0.0),
        "antialias-0.01": lambda labels, _: level_surface(antialiased(labels, 0.01, arguments.itk_antialias, folder), 0.0),
        "gauss": lambda labels, _: level_surface(blurred(labels), 0.5),
        "lumesh": lambda labels, shape: of_lumesh(labels, shape, arguments.program, folder)}
    if not hasattr(vtk, "vtkSurfaceNets3D"):
        print(f"left out: surfacenets: VTK {vtk.vtkVersion.GetVTKVersion()} has no vtkSurfaceNets3D", file=sys.stderr)
        del found["surfacenets"]
    if not arguments.itk_antialias.exists():
        print(f"left out: antialias: no {arguments.itk_antialias}; benchmarks/peers/README.md says how to build it", file=sys.stderr)
        del found["antialias-0.07"], found["antialias-0.01"]
    return found


def points_and_triangles(surface):
    """The largest piece, its triangles turned outwards."""
    triangulated = output(vtk.vtkTriangleFilter(), surface)
    largest = vtk.vtkPolyDataConnectivityFilter()
    largest.SetExtractionModeToLargestRegion()
    clean = output(vtk.vtkCleanPolyData(), output(largest, triangulated))
    points = numpy_support.vtk_to_numpy(clean.GetPoints().GetData()).astype(float)
    triangles = numpy_support.vtk_to_numpy(clean.GetPolys().GetData())
    if clean.GetPolys().GetMaxCellSize() != 3 or len(triangles) % 4 != 0:
        raise SystemExit("a surface has cells that are not triangles")
    triangles = triangles.reshape(-1, 4)[:, 1:]
    return points, triangles if volume(points, triangles) > 0 else triangles[:, ::-1]


def volume(points, triangles):
    return float((digitised.area_vectors(points, triangles) * points[triangles[:, 0]]).sum()) / 3


def size_error(shape, points, triangles):
    """Of the radius of tubes, else of the volume, in %."""
    if isinstance(shape, digitised.Torus):
        return 100 * (volume(points, triangles) / shape.volume() - 1)
    places = shape.section_places()
    radii = digitised.section_radii(points, triangles, shape.centre, shape.direction, places)
    exact = shape.radius_at(places)
    return 100 * ((radii ** 2).sum() / (exact ** 2).sum() - 1) if shape.narrowing else 100 * float((radii / exact).mean() - 1)


def measure(shape, points, triangles):
    areas = np.linalg.norm(digitised.area_vectors(points, triangles), axis=1)
    weights = digitised.to_vertices(triangles, areas, len(points)) * shape.measured(points)
    used = weights > 0
    distances, normals = shape.distance_and_normal(points[used])
    cosines = (normals * digitised.vertex_normals(points, triangles)[used]).sum(1)
    angles = np.degrees(np.arccos(np.clip(cosines, -1, 1)))
    return {"vertices": len(points), "normal_deg": float(np.sqrt((weights[used] * angles ** 2).sum() / weights.sum())),
            "roughness_voxels": digitised.weighted(distances, weights[used])[1], "size_percent": size_error(shape, points, triangles)}


def cell(figures):
    """Of one method and shape, over the places."""
    def rms(name):
        return float(np.sqrt(np.mean([figure[name] ** 2 for figure in figures])))
    sizes = [figure["size_percent"] for figure in figures]
    return f"{rms('normal_deg'):.1f} / {rms('roughness_voxels'):.3f} / {np.mean(sizes):+.1f} ({np.abs(sizes).max():.1f})"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("shapes", nargs="*", metavar="SHAPE", help=f"of {', '.join(SHAPES)}; default: all")
    parser.add_argument("--program", type=pathlib.Path, default=run.ROOT / "build/release/bin/lumesh")
    parser.add_argument("--itk-antialias", type=pathlib.Path, default=run.ROOT / "build/peers/itk_antialias")
    parser.add_argument("--places", type=int, default=5, help="random places of each shape")
    parser.add_argument("--seed", type=int, default=1, help="of the first place; the next has the next")
    parser.add_argument("--json", type=pathlib.Path, help="add all figures to this file, a line for each surface")
    arguments = parser.parse_args()
    unknown = set(arguments.shapes) - set(SHAPES)
    if unknown:
        parser.error(f"no shape {', '.join(sorted(unknown))}; there are {', '.join(SHAPES)}")
    arguments.program, arguments.itk_antialias = arguments.program.resolve(), arguments.itk_antialias.resolve()
    seeds, found = range(arguments.seed, arguments.seed + arguments.places), collections.defaultdict(list)
    with tempfile.TemporaryDirectory(prefix="lumesh_surfaces_") as folder:
        ways = makers(arguments, pathlib.Path(folder))
        print(f"Seeds {seeds[0]} to {seeds[-1]}. R.m.s. error of normals in degrees / roughness in voxels / error of the radius or "
              f"volume in %: mean (largest).\n\n| | {' | '.join(ways)} |\n|---{'|---' * len(ways)}|", flush=True)
        for name in arguments.shapes or SHAPES:
            for seed in seeds:
                shape = shape_at(name, seed)
                labels, low = digitised.rasterise(shape)
                shape.centre = shape.centre - low  # Surfaces come in units of voxels from the first one's centre.
                for method, make in ways.items():
                    figures = measure(shape, *points_and_triangles(make(labels, shape)))
                    found[name, method].append(figures)
                    if arguments.json:
                        with arguments.json.open("a") as file:
                            file.write(json.dumps({"shape": name, "seed": seed, "method": method} | figures) + "\n")
            print(f"| {name} | {' | '.join(cell(found[name, method]) for method in ways)} |", flush=True)


if __name__ == "__main__":
    main()
