#!/usr/bin/env python3
"""Patches of surfaces: face ids, solids, groups and arrays, which of them are ends, and their names in every format.

Usage: surface_patches_test.py LUMESH      Exit codes of lumesh: 2 bad input.
"""
import json
import math
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from program import BAD_INPUT
from surface_files import SurfaceFilesTest, closed_tube, tube


class SurfacePatchesTest(SurfaceFilesTest):
    def test_numbers_of_patches_may_be_written_as_floating_point(self):
        points, *parts = closed_tube()
        triangles = sum(parts, [])
        numbers = [float(i + 1) for i, part in enumerate(parts) for _ in part]
        self.assertIn("1.0", map(str, numbers))
        self.vtp(points, triangles, number="Float64", ModelFaceID=numbers)
        patches, _ = self.patches_made(self.folder / "tube.vtp")
        self.assertEqual(len(patches), 3, patches)
        source = self.vtp(points, triangles, number="Float64", ModelFaceID=[n + 0.5 for n in numbers])
        self.assert_refused(self.run_lumesh("info", source), BAD_INPUT, "ModelFaceID holds fractions where whole numbers are needed")

    def test_numbers_that_no_patch_has_are_told_with_their_array(self):
        points, *parts = closed_tube()
        triangles = sum(parts, [])
        for number in (-3, 70_000):
            numbers = [number if i == 2 else i for i, part in enumerate(parts) for _ in part]
            self.assert_refused(self.run_lumesh("info", self.vtp(points, triangles, patch=numbers)), BAD_INPUT,
                                f'tube.vtp: a boundary face has no valid patch: its number in the array "patch" is {number}, not from 0 to 65534; number')
            given = self.run_lumesh("delaunay", self.vtp(points, triangles, groups=numbers), "--patch-array", "groups", "-o", self.folder / "m.vtu")
            self.assert_refused(given, BAD_INPUT, f'array "groups" holds numbers that are negative or above 65000, which patches cannot have, such as {number}; number')

    def test_different_names_stay_different_patches(self):
        points, wall, low, high = closed_tube()
        names, told = self.patches_made(self.solids(("wall", points, wall), ("outlet:1", points, low), ("outlet 1", points, high)))
        self.assertEqual(names, {"wall": "wall", "outlet_1": "opening", "outlet_1_2": "opening"})
        self.assertIn('"outlet:1" is outlet_1, "outlet 1" is outlet_1_2', told)
        names, told = self.patches_made(self.solids(("стенка wall", points, wall), ("вход", points, low), ("出口1", points, high)))
        self.assertEqual(names, {"wall": "wall", "solid_2": "opening", "solid_3": "opening"})
        self.assertIn('"вход" is solid_2, "出口1" is solid_3', told)

    def test_ends_of_one_name_are_told(self):
        points, wall, low, high = closed_tube()
        names, told = self.patches_made(self.solids(("wall", points, wall), ("end", points, low), ("end", points, high)))
        self.assertEqual(names, {"wall": "wall", "end": "opening"})
        self.assertIn('patch "end" lies in 2 separate places, at (0.0, 0.0, 0.0) mm and (0.0, 0.0, 12.0) mm', told)
        self.assertNotIn("only opening", told)

    def test_an_end_of_several_patches_stays_open(self):
        points, wall, low, high = closed_tube()
        names, told = self.patches_made(
            self.solids(("lumen", points, wall), ("in", points, low), ("left", points, high[:12]), ("right", points, high[12:])))
        self.assertEqual(names, {"lumen": "wall", "in": "opening", "left": "opening", "right": "opening"})
        self.assertEqual(told, "")
        ids = [1] * len(wall) + [2] * len(low) + [3] * 8 + [4] * 16
        names, _ = self.patches_made(self.vtp(points, wall + low + high, ModelFaceID=ids))
        self.assertEqual(names, {"face_1": "wall", "face_2": "opening", "face_3": "opening", "face_4": "opening"})

    def test_an_end_with_triangles_of_the_wall_is_told(self):
        points, wall, low, high = closed_tube()
        names, told = self.patches_made(
            self.solids(("lumen", points, wall[:-48]), ("in", points, low), ("out", points, high + wall[-48:])))
        self.assertEqual(names, {"lumen": "wall", "in": "opening", "out": "wall"})
        self.assertRegex(told, 'patch "out" is flat in [67]. % of its area, at .0.0, 0.0, 12.0. mm, but is taken as wall')
        self.assertIn('"in" is the only opening of the surface', told)

    def test_a_wall_within_the_patch_of_an_opening_is_told(self):
        points, wall, low, high = closed_tube()
        names, told = self.patches_made(self.solids(("inlet", points, wall + low), ("out", points, high)))
        self.assertEqual(names, {"inlet": "opening", "out": "opening"})
        self.assertRegex(told, 'patch "inlet" is taken as an opening, all of it, though 9[0-9] % of its area are bent')

    def test_an_array_of_one_number_hides_nothing(self):
        points, wall, low, high = closed_tube()
        triangles = wall + low + high
        ones, ids = [1] * len(triangles), [7] * len(wall) + [8] * len(low) + [9] * len(high)
        for options in ((), ("--patch-array", "ModelFaceID")):
            names, told = self.patches_made(self.vtp(points, triangles, ModelFaceID=ones), *options)
            self.assertEqual(names, {"wall": "wall", "inlet_1": "opening", "outlet_1": "opening"})
            self.assertEqual(told, "")
        names, _ = self.patches_made(self.vtp(points, triangles, ModelFaceID=ones, CellEntityIds=ids))
        self.assertEqual(names, {"face_7": "wall", "face_8": "opening", "face_9": "opening"})
        names, _ = self.patches_made(self.solids(("vessel", points, triangles), ("nothing", points, [])))
        self.assertEqual(names, {"wall": "wall", "inlet_1": "opening", "outlet_1": "opening"})

    def test_ends_of_a_channel_with_flat_sides_are_openings(self):
        points, wall, low, high = closed_tube(around=4)
        ids = [7] * len(wall) + [8] * len(low) + [9] * len(high)
        source = self.vtp(points, wall + low + high, ModelFaceID=ids)
        for options in ((), ("--extend", "2r")):
            told = json.loads(self.run_well("info", source, "--json", *options).stdout)
            self.assertEqual({p["name"]: p["kind"] for p in told["patches"]},
                             {"face_7": "wall", "face_8": "opening", "face_9": "opening"})
            self.assertEqual(sorted(o["name"] for o in told["openings"]), ["face_8", "face_9"])
            for opening in told["openings"]:
                self.assertAlmostEqual(opening["area_mm2"], 8, places=6)

    def openings_of_ids(self, points, triangles, ids):
        run = self.run_well("info", self.vtp(points, triangles, ModelFaceID=ids), "--json")
        return sorted(o["name"] for o in json.loads(run.stdout)["openings"]), run.stderr

    def test_flat_pieces_of_a_wall_are_no_openings(self):
        points, wall, low, high = closed_tube()
        strip = [10 if t // 2 % 24 == 5 else 7 for t in range(len(wall))]  # One facet from end to end.
        names, told = self.openings_of_ids(points, wall + low + high, strip + [8] * len(low) + [9] * len(high))
        self.assertEqual(names, ["face_8", "face_9"])
        self.assertIn('patch "face_10"', told)
        self.assertIn("goes on almost in its plane", told)

    def test_ends_between_flat_sides_are_openings(self):
        """Channels, a tube with a flat bottom, and tubes with a strip or a plate all along, straight and bent."""
        def bent(p):
            return ((20 + p[0]) * math.cos(p[2] / 20), p[1], (20 + p[0]) * math.sin(p[2] / 20))

        def circle(around, lowest):  # From the bottom on; what lies below is flat.
            angles = [2 * math.pi * (i + 0.5) / around - math.pi / 2 for i in range(around)]
            return [(4 * math.cos(a), 4 * math.sin(a)) for a in angles if 4 * math.sin(a) > lowest]

        def channel(width, height):  # Three edges to each side.
            corners = [(0, 0), (width, 0), (width, height), (0, height), (0, 0)]
            return [(a[0] + k / 3 * (b[0] - a[0]), a[1] + k / 3 * (b[1] - a[1])) for a, b in zip(corners, corners[1:]) for k in range(3)]

        sections = {"square": channel(4, 4), "flat channel": channel(6, 2),
                    "half": circle(24, 0), "plate": circle(24, -3.2), "strip": circle(24, -9)}
        rows = 24
        for name, section in sections.items():
            n = len(section)
            middle = [sum(p[k] for p in section) / n for k in (0, 1)]
            flat = [(*p, 30 * row / rows) for row in range(rows + 1) for p in section] + [(*middle, 0), (*middle, 30)]
            wall = [t for row in range(rows) for i in range(n) for a, b in [(row * n + i, row * n + (i + 1) % n)]
                    for t in ((a, b, b + n), (a, b + n, a + n))]
            low = [((i + 1) % n, i, len(flat) - 2) for i in range(n)]
            high = [(rows * n + i, rows * n + (i + 1) % n, len(flat) - 1) for i in range(n)]
            area = abs(sum(p[0] * q[1] - p[1] * q[0] for p, q in zip(section, section[1:] + section[:1]))) / 2
            edges = 3 if n == 12 else 1  # Of a side.
            last = [11 if t // 2 % n >= n - edges else 7 for t in range(len(wall))]  # The side that ends in the first corner.
            each = [20 + t // 2 % n // edges for t in range(len(wall))]
            for points in (flat, [bent(p) for p in flat]):
                for ids in (last, each) if n == 12 else (last,):
                    for ends, triangles in (([8] * len(low) + [9] * len(high), wall + low + high), ([], wall)):
                        with self.subTest(name, is_bent=points is not flat, is_each=ids is each, is_open=not ends):
                            source = self.vtp(points, triangles, ModelFaceID=ids + ends)
                            for options in ((), ("--extend", "1r")):
                                openings = json.loads(self.run_well("info", source, "--json", *options).stdout)["openings"]
                                wanted = ["face_8", "face_9"] if ends else ["inlet_1", "outlet_1"]
                                self.assertEqual(sorted(o["name"] for o in openings), wanted)
                                for opening in openings:
                                    self.assertAlmostEqual(opening["area_mm2"] / area, 1, delta=0.01)
                bare = self.vtp(points, wall + low + high, ModelFaceID=[1] * len(wall + low + high))
                openings = json.loads(self.run_well("info", bare, "--json").stdout)["openings"]
                self.assertEqual([round(o["area_mm2"] / area, 2) for o in openings], [1, 1], name)

    def test_the_face_of_a_step_is_no_opening(self):
        profile = [(0, 1), (4, 1), (4, 0), (10, 0), (10, 2), (4, 2), (0, 2)]  # Of a channel that widens at x = 4.
        ids_of_sides = [7, 10, 7, 9, 7, 7, 8]
        points = [(x, y, z) for y in (0, 2) for x, z in profile]
        triangles, ids = [], []
        for i, number in enumerate(ids_of_sides):
            a, b = i, (i + 1) % 7
            triangles += [(a, b, b + 7), (a, b + 7, a + 7)]
            ids += [number, number]
        for a, b, c in ((0, 1, 5), (0, 5, 6), (1, 2, 3), (1, 3, 4), (1, 4, 5)):
            triangles += [(a, c, b), (a + 7, b + 7, c + 7)]
            ids += [7, 7]
        names, _ = self.openings_of_ids(points, [t[::-1] for t in triangles], ids)
        self.assertEqual(names, ["face_8", "face_9"])

    def test_an_array_of_numbers_that_no_patch_has_is_told(self):
        points, wall, low, high = closed_tube()
        good = [7] * len(wall) + [8] * len(low) + [9] * len(high)
        for bad in (-1, 100_000):
            ids = [bad if id == 7 else id for id in good]
            names, told = self.patches_made(self.vtp(points, wall + low + high, ModelFaceID=ids))
            self.assertEqual(names, {"wall": "wall", "inlet_1": "opening", "outlet_1": "opening"})
            self.assertIn("its array ModelFaceID is not taken for patches, for it holds numbers that are negative", told)
            self.assertIn("by --patch-array", told)

    def test_groups_of_obj_are_patches(self):
        points, triangles = tube()
        obj = self.obj(points, triangles, "lower part", "upper")
        mesh, _, _ = self.mesh(obj, "--edge-length", 0.8)
        self.assertEqual({p["name"] for p in self.info(mesh)["patches"]}, {"lower_part", "upper", "inlet_1", "outlet_1"})
        obj.write_text("v 0 0 0\nf 1 2 3\n")
        self.assert_refused(self.run_lumesh("info", obj), BAD_INPUT, "tube.obj", "not there")

    def test_names_survive_every_stage_and_writer(self):
        points, triangles = tube(length=8.0)
        obj = self.obj(points, triangles, "proximal", "distal")
        mesh, _, _ = self.mesh(obj, "--edge-length", 0.8, "--name", "outlet_1=mca")
        names = {"proximal", "distal", "inlet_1", "mca"}

        def names_of(path):
            return {patch["name"] for patch in self.info(path)["patches"] if patch["faces"] > 0}

        self.assertEqual(names_of(mesh), names)
        stages = {"improve": (), "layers": ("--side", "inward", "--first-height", 0.05)}
        for stage, options in stages.items():
            out = self.folder / f"{stage}.vtu"
            self.run_well(stage, mesh, *options, "-o", out)
            self.assertLessEqual(names, names_of(out), stage)
        for extension in (".vtu", ".vtk", ".msh", ".mesh", ".vtp"):
            out = self.folder / f"again{extension}"
            self.run_well("convert", mesh, out)
            self.assertEqual(names_of(out), names, extension)
        self.run_well("convert", mesh, self.folder / "m.xdmf")
        self.run_well("convert", mesh, self.folder / "a.foam")
        self.run_well("convert", mesh, self.folder / "a-mesh-complete")
        files = {path.stem for path in (self.folder / "a-mesh-complete" / "mesh-surfaces").iterdir()}
        self.assertEqual(files, names)
        for said in (self.folder / "m_tags.json", self.folder / "constant" / "polyMesh" / "boundary"):
            for name in names:
                self.assertIn(name, said.read_text())

    def test_an_array_may_be_chosen_for_the_patches(self):
        points, triangles = tube(length=8.0)
        part = " ".join(str(7 if i < len(triangles) // 2 else 9) for i in range(len(triangles)))

        def array(kind, name, values, components=1):
            return f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{components}" format="ascii">{values}</DataArray>'

        source = self.folder / "tube.vtp"
        source.write_text(
            f'<VTKFile type="PolyData" version="0.1"><PolyData><Piece NumberOfPoints="{len(points)}" '
            f'NumberOfPolys="{len(triangles)}"><CellData>{array("Int32", "part", part)}</CellData><Points>'
            + array("Float64", "Points", " ".join("%.17g %.17g %.17g" % p for p in points), 3)
            + "</Points><Polys>" + array("Int64", "connectivity", " ".join("%d %d %d" % t for t in triangles))
            + array("Int64", "offsets", " ".join(str(3 * (i + 1)) for i in range(len(triangles))))
            + "</Polys></Piece></PolyData></VTKFile>")
        names = lambda mesh: {p["name"] for p in self.info(mesh)["patches"]}
        mesh, _, _ = self.mesh(source, "--edge-length", 0.8)
        self.assertEqual(names(mesh), {"wall", "inlet_1", "outlet_1"})
        mesh, _, _ = self.mesh(source, "--edge-length", 0.8, "--patch-array", "part")
        self.assertEqual(names(mesh), {"face_7", "face_9", "inlet_1", "outlet_1"})
        out = self.folder / "none.vtu"
        self.assert_refused(self.run_lumesh("delaunay", source, "-o", out, "--patch-array", "prat"), BAD_INPUT, "prat",
                            "part")


if __name__ == "__main__":
    unittest.main()
