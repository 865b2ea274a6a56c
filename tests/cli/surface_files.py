"""Tubes as files of surfaces, and what `lumesh` makes of them, for tests."""
import json
import math

from program import ProgramTest


def tube(radius=2.0, length=12.0, around=24, end=lambda i: 0.0):
    """Points and triangles around the z axis, open at both ends; the last ring moved along z."""
    rows = round(length / (2 * math.pi * radius / around))
    points = []
    for row in range(rows + 1):
        for i in range(around):
            angle = 2 * math.pi * i / around
            z = length * row / rows + (end(i) if row == rows else 0)
            points.append((radius * math.cos(angle), radius * math.sin(angle), z))
    triangles = []
    for row in range(rows):
        for i in range(around):
            a, b = row * around + i, row * around + (i + 1) % around
            triangles += [(a, b, a + around), (b, b + around, a + around)]
    return points, triangles


def stl_text(points, triangles, name="vessel"):
    lines = [f"solid {name}"]
    for t in triangles:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex %.17g %.17g %.17g" % points[v] for v in t]
        lines += ["endloop", "endfacet"]
    return "\n".join([*lines, f"endsolid {name}", ""])


def fan(points, first, around, is_low):
    """A flat end of a tube, from its middle, which is added to the points."""
    points.append((0.0, 0.0, points[first][2]))
    ring = [(first + i, first + (i + 1) % around) for i in range(around)]
    return [(b, a, len(points) - 1) if is_low else (a, b, len(points) - 1) for a, b in ring]


def closed_tube(around=24):
    """Points, and triangles of the wall, the low end and the high one."""
    points, wall = tube(around=around)
    last = len(points) - around
    return points, wall, fan(points, 0, around, True), fan(points, last, around, False)


def with_hole(points, triangles, radius):
    """Without the triangles near the middle of a side of the tube."""
    def is_near(t):
        middle = [sum(points[v][i] for v in t) / 3 for i in range(3)]
        return math.dist(middle, (2, 0, 6)) < radius
    return [t for t in triangles if not is_near(t)]


class SurfaceFilesTest(ProgramTest):
    def stl(self, name, points, triangles):
        path = self.folder / name
        path.write_text(stl_text(points, triangles))
        return path

    def obj(self, points, triangles, *groups):
        """The triangles in so many groups of equal size."""
        path, size = self.folder / "tube.obj", len(triangles) // len(groups)
        text = "".join("v %.17g %.17g %.17g\n" % p for p in points)
        for i, name in enumerate(groups):
            text += f"g {name}\n" + "".join("f %d %d %d\n" % tuple(v + 1 for v in t) for t in triangles[i * size:(i + 1) * size])
        path.write_text(text)
        return path

    def solids(self, *parts):
        """A file of named solids: (name, points, triangles) each."""
        path = self.folder / "solids.stl"
        path.write_text("".join(stl_text(points, triangles, name) for name, points, triangles in parts))
        return path

    def vtp(self, points, triangles, number="Int32", **arrays):
        """Triangles with whole numbers, one for each, in named arrays."""
        def array(kind, name, values, components=1):
            return (f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{components}" format="ascii">'
                    + " ".join(map(str, values)) + "</DataArray>")
        path = self.folder / "tube.vtp"
        path.write_text(
            '<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64"><PolyData>'
            f'<Piece NumberOfPoints="{len(points)}" NumberOfPolys="{len(triangles)}" NumberOfVerts="0" NumberOfLines="0" '
            'NumberOfStrips="0"><CellData>' + "".join(array(number, name, values) for name, values in arrays.items())
            + "</CellData><Points>" + array("Float64", "points", [x for p in points for x in p], 3) + "</Points><Polys>"
            + array("Int64", "connectivity", [v for t in triangles for v in t])
            + array("Int64", "offsets", range(3, 3 * len(triangles) + 1, 3)) + "</Polys></Piece></PolyData></VTKFile>")
        return path

    def patches_made(self, source, *options):
        """Patches of the mesh with their kinds, and what stderr says."""
        mesh, report = self.folder / "mesh.vtu", self.folder / "converted.json"
        told = self.run_well("delaunay", source, "-o", mesh, "--edge-length", 0.8, *options).stderr
        self.run_well("convert", mesh, self.folder / "converted.vtu", "--json", report)
        return {p["name"]: p["kind"] for p in json.loads(report.read_text())["patches"]}, told

    def info(self, path):
        return json.loads(self.run_well("info", path, "--json").stdout)

    def mesh(self, source, *options):
        mesh, report = self.folder / "mesh.vtu", self.folder / "mesh.json"
        out = self.run_well("delaunay", source, "-o", mesh, "--json", report, *options).stdout
        return mesh, json.loads(report.read_text()), out
