#!/usr/bin/env python3
"""Open surfaces as they come: closed by every command that takes surfaces, told, and named.

Usage: surfaces_test.py LUMESH      Exit codes of lumesh: 1 usage, 2 bad input.
"""
import gzip
import json
import math
import pathlib
import random
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from program import BAD_INPUT, USAGE
from surface_files import SurfaceFilesTest, closed_tube, fan, stl_text, tube, with_hole

SHARED = pathlib.Path(__file__).resolve().parents[2].parent / "shared" / "data"


class SurfacesTest(SurfaceFilesTest):
    def test_openings_are_capped_named_and_told(self):
        source = self.stl("tube.stl", *tube(end=lambda i: 0.25 * (i % 2)))
        would = self.info(source)["would_close"]
        self.assertEqual({end["name"] for end in would}, {"inlet_1", "outlet_1"})
        mesh, report, out = self.mesh(source, "--edge-length", 0.8)
        self.assertEqual({end["name"] for end in report["closed"]}, {"inlet_1", "outlet_1"})
        for end in report["closed"]:
            self.assertEqual(end["kind"], "opening")
            self.assertAlmostEqual(end["area_mm2"] / (0.5 * 24 * 4 * math.sin(math.pi / 12)), 1, delta=0.01)
            self.assertIn(f"capped {end['name']}: radius", out)
        self.assertEqual({p["name"] for p in self.info(mesh)["patches"]}, {"wall", "inlet_1", "outlet_1"})

    def test_units_and_frames_of_files_are_followed_or_told(self):
        source = self.stl("tube.stl", *tube())
        text = source.read_text()

        def told(comment, *options, command="info"):
            source.write_text(text.replace("solid vessel", f"solid {comment}", 1))
            run = self.run_well(command, source, "--json", *options)
            return (json.loads(run.stdout) if command == "info" else None), run.stderr

        area = told("")[0]["openings"][0]["area_mm2"]
        for comment, factor in (("UNIT=CM", 10), ("unit=Cm", 10), ("UNIT=M", 1000), ("UNIT=Um", 0.001), ("UNIT=inch", 25.4),
                                ("UNIT=In", 25.4), ("units: inches", 25.4), ("units: millimetres", 1)):
            found, lines = told(comment)
            self.assertAlmostEqual(found["openings"][0]["area_mm2"] / area / factor**2, 1, places=4)
            self.assertNotIn("not known", lines)
        for comment, word in (("UNIT=Cubit", "cubit"), ("units: foo", "foo")):
            found, lines = told(comment)
            self.assertIn(f'its unit is "{word}", which is not known: its lengths are taken as mm; --unit says', lines)
            self.assertAlmostEqual(found["openings"][0]["area_mm2"] / area, 1, places=9)
            self.assertNotIn("not known", told(comment, "--unit", "cm")[1])
        source.write_text(text.replace("solid vessel", "solid UNIT=cubit SPACE=LAS", 1))
        for command, *rest in (("delaunay", "-o", self.folder / "t.vtu"), ("repair", "-o", self.folder / "r.stl"), ("check",),
                               ("centerline", "-o", self.folder / "c.vtp")):
            lines = self.run_lumesh(command, source, *rest).stderr
            self.assertEqual((lines.count('its unit is "cubit"'), lines.count('its frame is "LAS", which is not known: its coordinates are taken as LPS')), (1, 1), command)
        self.assertIn('its unit is "cubit"', self.run_well("convert", source, self.folder / "s.off").stderr)
        found, lines = told("SPACE=ras")
        self.assertEqual((found["frame"], found["openings_frame"]), ("RAS", "LPS"))
        self.assertIn("its coordinates are RAS; places are told, and options of places taken, in LPS", lines)
        found, lines = told("SPACE=LPS")
        self.assertNotIn("openings_frame", found)
        self.assertNotIn("RAS", lines)

    def test_caps_are_planar_where_the_wall_of_another_vessel_passes(self):
        """Within a twentieth of the radius of the first vessel's rims."""
        points, triangles = tube(length=20, around=36)
        second = [(x + 4.1, y + 0.3, z - 10) for x, y, z in points]
        both = triangles + [tuple(v + len(points) for v in t) for t in triangles]
        _, report, _ = self.mesh(self.stl("two.stl", points + second, both))
        self.assertEqual(len(report["openings"]), 4)
        for end in report["openings"]: self.assertLess(end["off_plane_mm"], 1e-12 * end["radius_mm"], end["patches"])

    def test_a_mesh_that_fills_less_than_its_surface_is_told(self):
        """A thin vessel of long triangles, as programs draw cylinders."""
        ring = [(math.cos(math.pi * i / 12), math.sin(math.pi * i / 12)) for i in range(24)]
        points = [(x, y, z) for z in (0.0, 300.0) for x, y in ring]
        wall = [t for i in range(24) for t in ((i, (i + 1) % 24, i + 24), ((i + 1) % 24, (i + 1) % 24 + 24, i + 24))]
        triangles = wall + fan(points, 0, 24, True) + fan(points, 24, 24, False)
        surface = self.folder / "thin.off"
        surface.write_text(f"OFF\n{len(points)} {len(triangles)} 0\n" + "".join("%.17g %.17g %.17g\n" % p for p in points)
                           + "".join("3 %d %d %d\n" % t for t in triangles))
        _, report, _ = self.mesh(surface)
        told = [line for line in report["warnings"] if "less than the surface" in line]
        self.assertEqual(len(told), 1, report["warnings"])
        self.assertRegex(told[0], r"fills [\d.]+ % less than the surface, \d+(\.\d+)? of 931.7 mm3: .*--edge-length")
        _, report, _ = self.mesh(surface, "--edge-length", 0.5)
        self.assertFalse([line for line in report["warnings"] if "than the surface" in line])

    def test_each_end_of_nested_skins_is_found_in_the_mesh(self):
        """A lumen within a wall of two skins: the ends of both stand in the same planes, around the same centres."""
        skins = self.folder / "skins.stl"
        skins.write_text("".join(stl_text(*tube(radius=r, length=6)) for r in (3.0, 2.4, 1.8)))
        _, report, _ = self.mesh(skins, "--edge-length", 0.6, "--strict")
        polygon = 12 * math.sin(math.pi / 12)
        expected = sorted([1.8**2, 1.8**2, 3**2 - 2.4**2, 3**2 - 2.4**2])
        areas = sorted(opening["mesh_area_mm2"] / polygon for opening in report["openings"])
        self.assertEqual(len(areas), 4)
        for area, wanted in zip(areas, expected):
            self.assertAlmostEqual(area / wanted, 1, delta=0.01)

    def test_a_part_that_goes_on_beyond_the_cap_of_another_is_told(self):
        points, triangles = tube(radius=1.5, length=20)
        inner = [(x, y, z - 4) for x, y, z in points]
        skins = self.folder / "skins.stl"
        skins.write_text(stl_text(*tube(radius=2.0, length=12)) + stl_text(inner, triangles))
        self.assert_refused(self.run_lumesh("delaunay", skins, "-o", self.folder / "mesh.vtu"), BAD_INPUT, "skins.stl",
                            "the cap of an open end crosses another part of the surface", "cut both off in one plane")

    def test_the_mesh_takes_layers_and_goes_to_openfoam(self):
        mesh, _, _ = self.mesh(self.stl("tube.stl", *tube()), "--edge-length", 0.8)
        foam = self.folder / "case" / "case.foam"
        foam.parent.mkdir()
        self.run_well("layers", mesh, "--side", "inward", "--first-height", 0.05, "--count", 3, "--cells", "prisms", "-o",
                      foam)
        boundary = (foam.parent / "constant" / "polyMesh" / "boundary").read_text()
        for name in ("wall", "inlet_1", "outlet_1"):
            self.assertIn(name, boundary)

    def test_the_centerline_goes_from_cap_to_cap(self):
        lines = self.folder / "lines.vtp"
        out = self.run_well("centerline", self.stl("tube.stl", *tube()), "-o", lines).stdout
        self.assertEqual(out.count("capped an opening: radius"), 2)
        length = float(out.split("length ")[1].split()[0])
        self.assertAlmostEqual(length, 12, delta=0.5)

    def test_the_centerline_of_a_surface_in_doubt_is_told(self):
        lines = self.folder / "lines.vtp"
        points, triangles = tube()
        beside = [(x + 1.3, y, z) for x, y, z in points]
        source = self.folder / "crossing.stl"
        source.write_text(stl_text(points, triangles) + stl_text(beside, triangles))
        self.assertIn("crosses or touches itself in ", self.run_well("centerline", source, "-o", lines).stderr)
        metres = self.stl("metres.stl", [tuple(0.001 * c for c in p) for p in points], triangles)
        told = self.run_well("centerline", metres, "-o", lines).stderr
        self.assertIn("is it in metres?", told)
        self.assertNotIn("crosses", told)

    def test_the_centerline_of_a_hollow_wall_is_refused(self):
        skins, lines = self.folder / "skins.stl", self.folder / "lines.vtp"
        skins.write_text("".join(stl_text(*tube(radius=r)) for r in (3.0, 2.0)))
        self.assert_refused(self.run_lumesh("centerline", skins, "-o", lines), BAD_INPUT, "skins.stl", "hollow wall",
                            "inner skin alone")
        skins.write_text("".join(stl_text(*tube(radius=r)) for r in (3.0, 2.0, 1.9)))  # The last one is a lumen.
        self.run_well("centerline", skins, "-o", lines)

    def test_a_case_file_takes_them_too(self):
        self.stl("tube.stl", *tube())
        case = self.folder / "case.toml"
        case.write_text('[input]\nsurface = "tube.stl"\n[delaunay]\nedge_length = 0.8\n[output]\nfolder = "out"\n'
                        'meshes = ["mesh.vtu"]\njson = "report.json"\nreport = ""\n')
        self.run_well("run", case)
        self.assertIn("capped inlet_1", (self.folder / "out" / "report.json").read_text())
        case.write_text(case.read_text().replace("[delaunay]", "keep_open = true\n[delaunay]"))
        self.assertEqual(self.run_lumesh("run", case).returncode, BAD_INPUT)

    def test_triangles_that_hang_at_corners_of_a_ragged_end_are_left_out(self):
        points, triangles = tube(around=36)
        end = len(points) - 36
        # Of the last row one triangle of each pair is gone, and pairs of others hang at their tips.
        triangles = [t for t in triangles if sum(v >= end for v in t) != 2 or min(t) % 3]
        for i in range(0, 36, 4):
            x, y, z = points[end + i]
            points += [(x, y, z + 0.3), (0.98 * x - 0.05 * y, 0.98 * y + 0.05 * x, z + 0.3), (x, y, z + 0.5)]
            a = len(points) - 3
            triangles += [(end + i, a + 1, a), (a, a + 1, a + 2)]
        source = self.stl("loose.stl", points, triangles)
        _, report, out = self.mesh(source, "--edge-length", 0.8)
        self.assertIn("18 triangles hang at corners only and are left out", "".join(report["warnings"]))
        self.assertEqual([end["kind"] for end in report["closed"] if end["kind"] == "opening"], ["opening", "opening"])
        for opening in report["openings"]:
            self.assertAlmostEqual(opening["mesh_area_mm2"] / (18 * 4 * math.sin(math.pi / 18)), 1, delta=0.01)
        found = json.loads(self.run_well("check", source, "--json").stdout)["findings"]
        self.assertEqual([f["count"] for f in found if f["kind"] == "loose_triangles"], [18])
        repaired = json.loads(self.run_well("repair", source, "-o", self.folder / "repaired.stl", "--json").stdout)
        self.assertEqual(repaired["loose_triangles"], 18)

    def test_pinholes_become_wall(self):
        points, triangles = tube()
        del triangles[200]
        _, report, out = self.mesh(self.stl("holes.stl", points, triangles), "--edge-length", 0.8)
        self.assertEqual([end["kind"] for end in report["closed"]], ["opening", "opening", "hole"])
        self.assertIn("filled a hole of the wall", out)

    def test_vessels_that_the_mesh_joins_are_told(self):
        points, triangles = tube(length=20)
        for gap, joins in ((0.07, True), (1.5, False)):
            beside = [(x + 4 + gap, y, z + 0.1) for x, y, z in points]
            both = [*triangles, *(tuple(v + len(points) for v in t) for t in triangles)]
            path = self.stl("pair.stl", [*points, *beside], both)
            result = self.run_lumesh("delaunay", path, "-o", self.folder / "pair.mesh")
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual("outside of the mesh has 1 piece" in result.stderr, joins, result.stderr)

    def test_ends_are_cut_and_extended(self):
        surface, mesh = self.stl("tube.stl", *tube()), self.folder / "tube.vtu"
        told = json.loads(self.run_well("info", surface, "--clip-ends", "1r", "--json").stdout)
        self.assertEqual([o["name"] for o in told["openings"]], ["inlet_1", "outlet_1"])
        self.assertEqual(sorted(round(o["centre_mm"][2], 1) for o in told["openings"]), [2, 10])
        self.run_well("delaunay", surface, "-o", mesh, "--clip-ends", "1r", "--extend", "inlet_1=5r,outlet_1=1", "--extend-circle", "1r",
                      "--json", self.folder / "out.json", "-q")
        openings = json.loads((self.folder / "out.json").read_text())["openings"]
        whole = max(o["centre_mm"][2] for o in openings) - min(o["centre_mm"][2] for o in openings)
        radius = math.sqrt(openings[0]["mesh_area_mm2"] / math.pi)
        self.assertAlmostEqual(whole, 8 + 5 * radius + 1, delta=0.1)
        evaluated = json.loads(self.run_well("evaluate", mesh, "--json").stdout)
        self.assertAlmostEqual(evaluated["labels"][0]["volume_mm3"], whole * openings[0]["mesh_area_mm2"], delta=0.01 * whole * 4 * math.pi)
        self.assert_refused(self.run_lumesh("delaunay", surface, "-o", mesh, "--extend", "outlet_7=5r"), BAD_INPUT, "outlet_7", "tube.stl")
        self.assert_refused(self.run_lumesh("delaunay", surface, "-o", mesh, "--cut-at", "40,0,0"), BAD_INPUT, "tube.stl", "(40.0, 0.0, 0.0) mm")
        self.assert_refused(self.run_lumesh("delaunay", surface, "-o", mesh, "--cut-plane", "0", "0", "-1", "0", "0", "1"), BAD_INPUT,
                            "tube.stl", "nothing of the surface is left")

    def test_openings_that_are_extended_get_names_by_their_own_place_and_the_new_one(self):
        surface, mesh = self.stl("tube.stl", *tube()), self.folder / "tube.vtu"
        image = self.folder / "tube.nrrd"
        self.run_well("phantom", "bifurcation", "-o", image)
        told = json.loads(self.run_well("info", image, "--json").stdout)["openings"]
        ends = {surface: [(0, 0, 0), (0, 0, -10), (0, 0, 12), (0, 0, 22)],
                image: [tuple(o["centre_mm"]) for o in told]}
        for path, places in ends.items():
            for place in places:
                name = ",".join(f"{x:.6g}" for x in place)
                self.run_well("delaunay", path, "-o", mesh, "--edge-length", "2", "--extend", "5r", f"--name={name}=mine", "-q")
                self.assertIn("mine", {p["name"] for p in self.info(mesh)["patches"]}, (path, place))
        case = self.folder / "case.toml"
        case.write_text('mesher = "delaunay"\n[input]\nsurface = "tube.stl"\nextend = "5r"\n[openings]\nnames = ["0,0,12=mine"]\n'
                        '[output]\nreport = ""\nmeshes = ["case.vtu"]\n')
        self.run_well("run", case, "-o", self.folder / "out", "-q")
        self.assertIn("mine", {p["name"] for p in self.info(self.folder / "out" / "case.vtu")["patches"]})

    def test_names_stay_where_cuts_took_the_named_ends(self):
        points, triangles = tube(length=20.0)
        points = [*points, (0.0, 0.0, 0.0), (0.0, 0.0, 20.0)]
        ends = [((i + 1) % 24, i, len(points) - 2) for i in range(24)]
        ends += [(len(points) - 26 + i, len(points) - 26 + (i + 1) % 24, len(points) - 1) for i in range(24)]
        named = self.folder / "named.stl"
        named.write_text("".join(stl_text(points, part, name) for part, name in
                                 ((triangles, "aorta"), (ends[:24], "ica"), (ends[24:], "rca"))))
        for options, names in (((), ["aorta", "ica", "rca"]), (("--clip-ends", "1r"), ["aorta", "ica", "rca"]),
                               (("--cut-plane", "0", "0", "10", "0", "0", "1"), ["aorta", "ica", "inlet_1"]),
                               (("--extend", "ica=2r"), ["aorta", "ica", "rca"])):
            self.run_well("delaunay", named, "-o", self.folder / "mesh.vtu", *options, "-q")
            told = json.loads(self.run_well("info", self.folder / "mesh.vtu", "--json").stdout)
            self.assertEqual(sorted(p["name"] for p in told["patches"]), names, options)

    def test_a_case_file_cuts_and_extends(self):
        self.stl("tube.stl", *tube())
        case = self.folder / "case.toml"
        case.write_text('mesher = "delaunay"\n[input]\nsurface = "tube.stl"\ncut_planes = [[0, 0, 9, 0, 0, 1]]\nextend = "2r"\n'
                        '[delaunay]\ndelta = 0.5\n[output]\nreport = ""\nmeshes = ["tube.vtu"]\njson = "out.json"\n')
        self.run_well("run", case, "-o", self.folder / "out", "-q")
        told = json.loads(self.run_well("info", self.folder / "out" / "tube.vtu", "--json").stdout)
        self.assertEqual([p["name"] for p in told["patches"]], ["wall", "inlet_1", "outlet_1"])
        self.assertIn("--extend 2r", told["provenance"]["cuts"])

    def test_a_vessel_in_cm_is_doubted(self):
        surface, case = self.stl("aorta.stl", *tube(radius=1.0, length=34.0)), self.folder / "case.toml"
        case.write_text('mesher = "delaunay"\n[input]\nsurface = "aorta.stl"\n[delaunay]\ndelta = 0.5\n[output]\nreport = ""\n')
        for told in (self.run_lumesh("check", surface).stdout, self.run_well("info", surface).stderr,
                     self.run_well("run", case, "-o", self.folder / "out", "-q").stderr):
            self.assertIn("is it in cm?", told)
        self.assertIn("--unit cm says so", self.run_lumesh("check", surface).stdout)
        self.assertNotIn("is it in", self.run_well("info", surface, "--unit", "cm").stderr)

    def test_triangles_without_three_corners_are_no_pieces_and_no_holes(self):
        points, wall, low, high = closed_tube()
        source = self.folder / "tube.off"
        triangles = [*wall, *low, *high, (5, 5, 5), (7, 7, 8)]
        source.write_text("\n".join(["OFF", f"{len(points)} {len(triangles)} 0", *("%.17g %.17g %.17g" % p for p in points),
                                     *("3 %d %d %d" % t for t in triangles), ""]))
        _, told = self.patches_made(source)
        self.assertEqual(told, "")
        self.assertEqual(self.run_well("centerline", source, "-o", self.folder / "lines.vtp").stderr, "")

    def test_corners_of_triangles_that_hardly_differ_are_one(self):
        points, triangles = tube()
        shaken = random.Random(3)
        corners = [tuple(x + shaken.uniform(-2e-5, 2e-5) for x in points[v]) for t in triangles for v in t]
        own = [(3 * t, 3 * t + 1, 3 * t + 2) for t in range(len(triangles))]
        torn = self.stl("torn.stl", corners, own)
        repaired = self.folder / "repaired.vtp"
        for result in (self.run_well("check", torn), self.run_well("repair", torn, "-o", repaired)):
            told = [line for line in result.stderr.splitlines() if "each triangle has corners of its own" in line]
            self.assertEqual(len(told), 1, result.stderr)
            self.assertIn("e-05 mm apart are one", told[0])
        self.assertEqual(json.loads(self.run_well("check", repaired, "--json").stdout)["size"],
                         f"{len(triangles)} triangles, {len(points)} points")
        _, report, _ = self.mesh(torn, "--edge-length", 0.8)
        self.assertEqual([end["kind"] for end in report["closed"]], ["opening", "opening"])

    def test_a_ragged_end_is_capped_anew_and_clipped_to_be_extended(self):
        def ragged(share):
            points, wall = tube(around=48, end=lambda i: 2 * share * math.cos(2.4 * i * i))
            last = len(points) - 48
            return self.stl("ragged.stl", points, [*wall, *fan(points, 0, 48, True), *fan(points, last, 48, False)])
        told = json.loads(self.run_well("info", ragged(0.03), "--json").stdout)
        self.assertEqual([end["was_capped"] for end in told["would_close"]], [True])
        self.assert_refused(self.run_lumesh("info", ragged(0.02), "--extend", "3r"), BAD_INPUT, "not flat", "--clip-ends 0.5r")
        self.run_well("info", ragged(0.02), "--extend", "3r", "--clip-ends", "0.5r")

    def test_keep_open_refuses(self):
        source = self.stl("tube.stl", *tube())
        out = self.folder / "out.vtu"
        self.assert_refused(self.run_lumesh("delaunay", source, "-o", out, "--keep-open"), BAD_INPUT, "tube.stl",
                            "not closed", "48 edges")
        self.assertFalse(out.exists())
        lines = self.folder / "lines.vtp"
        self.assert_refused(self.run_lumesh("centerline", source, "-o", lines, "--keep-open"), BAD_INPUT, "tube.stl",
                            "surface is open", "2 rims", "leave out --keep-open")
        self.assertFalse(lines.exists())
        points, wall, low, high = closed_tube()
        self.run_well("centerline", self.stl("closed.stl", points, [*wall, *low, *high]), "-o", lines, "--keep-open")
        image = self.folder / "image.nrrd"
        self.run_well("phantom", "sphere", "-o", image)
        self.assert_refused(self.run_lumesh("delaunay", image, "-o", out, "--keep-open"), USAGE, "--keep-open")

    def test_zipped_stl_and_obj_are_the_same_surface(self):
        points, triangles = tube()
        zipped = self.folder / "tube.stl.gz"
        zipped.write_bytes(gzip.compress(stl_text(points, triangles).encode()))
        obj = self.folder / "tube.obj"
        obj.write_text("".join("v %.17g %.17g %.17g\n" % p for p in points) +
                       "".join("f %d//1 %d//1 %d//1\n" % tuple(v + 1 for v in t) for t in triangles))
        ends = [self.info(path)["would_close"] for path in (self.stl("tube.stl", points, triangles), zipped, obj)]
        self.assertEqual([end["area_mm2"] for end in ends[0]], [end["area_mm2"] for end in ends[1]])
        for one, other in zip(ends[0], ends[2]):
            self.assertAlmostEqual(one["area_mm2"], other["area_mm2"], places=9)

    def test_lines_of_obj_may_go_on_in_the_next(self):
        source = self.folder / "cube.obj"
        source.write_text("# of \\\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 \\\n 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
                          "f 4 3 \\\r\n2 1\nf 5 6 7 8\nf 1 2 \\\n6 \\\n5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n")
        told = json.loads(self.run_well("info", source, "--json").stdout)
        self.assertEqual((told["points"], told["patches"]), (8, [{"name": "wall", "kind": "wall", "faces": 12}]))

    def test_one_opening_alone_is_told(self):
        points, wall, low, high = closed_tube()
        tip = points[-1]
        points[-1] = (0.0, 0.0, tip[2] + 1.4)  # A cone, which meets the wall at 35 degrees less than a flat end.
        names, told = self.patches_made(self.stl("cone.stl", points, wall + low + high), "--feature-angle", 70)
        self.assertEqual(names, {"wall": "wall", "inlet_1": "opening"})
        self.assertIn('"inlet_1" is the only opening of the surface, and nothing flows through a vessel with one', told)

    def test_holes_are_those_that_check_finds(self):
        points, triangles = tube(length=20.0, around=48)
        source = self.stl("hole.stl", points, with_hole(points, triangles, 0.75))
        findings = json.loads(self.run_lumesh("check", source, "--json").stdout)["findings"]
        self.assertEqual({f["kind"]: f["count"] for f in findings if f["kind"] in ("holes", "openings")}, {"holes": 1, "openings": 2})
        names, told = self.patches_made(source)
        self.assertEqual(names, {"wall": "wall", "inlet_1": "opening", "outlet_1": "opening"})
        _, report, out = self.mesh(source, "--edge-length", 0.8)
        self.assertEqual([end["kind"] for end in report["closed"]], ["opening", "opening", "hole"])
        self.assertIn("filled a hole of the wall: radius 0.7", out)

    def test_real_open_surfaces(self):
        """How many openings they have was counted by eye."""
        known = {"surfaces/open/artery.vtp": None, "surfaces/open/vampy_vein.stl": 2,
                 "surfaces/open/vampy_ventricle.stl": 1, "vampy/artery.stl": 3, "gmsh-aneurysm/aneurysm_data.stl.gz": 3,
                 "unseen/aorta-surface-open-ends.stl": 3}
        found = {name: SHARED / name for name in known if (SHARED / name).exists()}
        if not found:
            self.skipTest(f"no surfaces in {SHARED}")
        for name, path in found.items():
            with self.subTest(name):
                said = self.info(path)
                ends = [end for end in said["would_close"] if end["kind"] == "opening"]
                self.assertTrue(all(end["name"] for end in ends))
                if known[name]:
                    self.assertEqual(len(ends), known[name])


if __name__ == "__main__":
    unittest.main()
