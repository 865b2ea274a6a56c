#!/usr/bin/env python3
"""`lumesh check` and `lumesh repair`: what they find, make good, refuse, and how they end.

Usage: check_test.py LUMESH      Exit codes of lumesh: 0 good, 2 bad input, 3 unfit or not repaired.
"""
import json
import math
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import nrrd
from cube import cube, write_medit
from program import BAD_INPUT, NOT_REACHED, USAGE, ProgramTest

SHARED = pathlib.Path(__file__).resolve().parents[3] / "shared/data"


def tube(length, shift=(0, 0, 0), axis=2, radius=2.0, around=24):
    """Triangles, each of three points, of a closed tube along an axis, in coordinates that single precision holds."""
    rows = round(length / 0.5)

    def point(row, i, factor=1.0):
        angle = 2 * math.pi * i / around
        p = [factor * radius * math.cos(angle), factor * radius * math.sin(angle), -length / 2 + row * 0.5]
        p = [round(1024 * p[(k - axis - 1) % 3] + 1024 * shift[k]) / 1024 for k in range(3)]
        return tuple(p)

    triangles = []
    for row in range(rows):
        for i in range(around):
            a, b, c, d = point(row, i), point(row, i + 1), point(row + 1, i), point(row + 1, i + 1)
            triangles += [(a, b, c), (b, d, c)]
    for i in range(around):
        triangles += [(point(0, 0, 0), point(0, i + 1), point(0, i)), (point(rows, 0, 0), point(rows, i), point(rows, i + 1))]
    return triangles


def write_stl(path, solids):
    with open(path, "w", encoding="utf-8") as file:
        for name, triangles in solids.items():
            file.write(f"solid {name}\n")
            for triangle in triangles:
                file.write("facet normal 0 0 0\nouter loop\n")
                file.writelines("vertex {!r} {!r} {!r}\n".format(*p) for p in triangle)
                file.write("endloop\nendfacet\n")
            file.write(f"endsolid {name}\n")


class CheckTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.stl, self.out = self.folder / "in.stl", self.folder / "out.vtp"

    def write(self, *parts):
        write_stl(self.stl, {f"part_{n}": triangles for n, triangles in enumerate(parts)})

    def check(self, path, code=0):
        result = self.run_lumesh("check", path, "--json")
        self.assertEqual(result.returncode, code, result.stderr)
        told = json.loads(result.stdout)
        self.assertEqual(told["fit"], code == 0)
        return {finding["kind"]: finding for finding in told["findings"]}

    def test_a_sound_surface_has_no_findings(self):
        self.write(tube(10))
        self.assertEqual(self.check(self.stl), {})
        self.assertIn("nothing found", self.run_well("check", self.stl).stdout)

    def test_faults_are_told_with_count_place_and_remedy(self):
        triangles = tube(10)
        double = triangles[200]
        self.write([*triangles, double])
        found = self.check(self.stl, NOT_REACHED)["duplicate_triangles"]
        self.assertEqual((found["severity"], found["count"]), ("fault", 1))
        middle = [sum(p[k] for p in double) / 3 for k in range(3)]
        self.assertLess(math.dist(found["places_mm"][0], middle), 0.3)
        self.assertIn("lumesh repair", found["remedy"])
        self.assert_refused(self.run_lumesh("check", self.stl, "-q"), NOT_REACHED, "in.stl")

    def test_what_meshing_mends_is_a_remark_and_what_it_refuses_a_fault(self):
        triangles = tube(10)
        cut, mesh = triangles[:200] + triangles[201:202] + triangles[203:], self.folder / "mesh.vtu"
        self.write(cut)
        found = self.check(self.stl)
        self.assertEqual({kind: finding["severity"] for kind, finding in found.items()}, {"holes": "remark", "non_manifold_vertices": "remark"})
        self.assertIn("filled when meshed", found["holes"]["text"])
        self.assertIn("lumesh repair", found["holes"]["remedy"])
        self.assertIn("filled a hole", self.run_well("delaunay", self.stl, "-o", mesh, "--delta", "1").stdout)
        flat = self.folder / "flat.off"
        flat.write_text("OFF\n4 4 0\n0 0 0\n1e-200 0 0\n0 1e-200 0\n0 0 1e-200\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n")
        found = self.check(flat, NOT_REACHED)
        self.assertIn("encloses nothing", found["refused"]["text"])
        self.assertNotIn("repair", found["refused"]["text"])  # That refuses it, too.
        self.assert_refused(self.run_lumesh("delaunay", flat, "-o", mesh), BAD_INPUT, "encloses nothing")

    def test_a_stray_triangle_is_told_and_left_out(self):
        triangles, done = tube(10), self.folder / "done.json"
        self.write([*triangles, ((40, 0, 0), (42, 0, 0), (41, 1, 1))])
        found = self.check(self.stl, NOT_REACHED)
        self.assertEqual(found["stray_pieces"]["count"], 1)
        self.assertNotIn("holes", found)
        self.assertLess(math.dist(found["stray_pieces"]["places_mm"][0], (41, 1 / 3, 1 / 3)), 1e-4)
        said = self.run_well("repair", self.stl, "-o", self.out, "--json", done).stdout
        self.assertIn("left out", said)
        told = json.loads(done.read_text())
        self.assertAlmostEqual(told["stray_area_mm2"], math.sqrt(2), 4)
        self.assertLess(math.dist(told["stray_at_mm"], (41, 1 / 3, 1 / 3)), 1e-4)
        self.assertEqual(self.check(self.out), {})

    def test_what_cannot_be_read_is_bad_input(self):
        self.stl.write_text("solid x\nfacet")
        self.assert_refused(self.run_lumesh("check", self.stl), BAD_INPUT, "in.stl")
        self.assert_refused(self.run_lumesh("check", self.folder / "none.stl"), BAD_INPUT, "none.stl")

    def test_a_mesh_is_looked_at_as_a_whole(self):
        self.write(tube(10))
        mesh = self.folder / "mesh.vtu"
        self.run_well("delaunay", self.stl, "-o", mesh, "--delta", "1", "-q")
        self.assertEqual(self.check(mesh), {})

    def test_a_report_shows_where_the_findings_are(self):
        page = self.folder / "page <1>.html"
        triangles = tube(10)
        self.write(triangles)
        self.run_well("check", self.stl, "--report", page, "-q")
        html = page.read_text(encoding="utf-8")
        self.assertIn("fit for meshing", html)
        self.assertEqual(html.count("<img "), 1, "the surface alone")
        self.write([*triangles, triangles[200]])
        result = self.run_lumesh("check", self.stl, "--report", page, "--json")
        self.assertEqual(result.returncode, NOT_REACHED, result.stderr)
        double = json.loads(result.stdout)["findings"][0]
        html = page.read_text(encoding="utf-8")
        self.assertIn("unfit for meshing", html)
        self.assertEqual(html.count("<img "), 2, "overview and close-up")
        self.assertIn("({:.4g}, {:.4g}, {:.4g})".format(*double["places_mm"][0]), html)
        self.assertIn(double["remedy"], html)

    def test_a_report_of_an_image_names_voxels(self):
        page, image = self.folder / "page.html", self.folder / "in.nrrd"
        voxels = nrrd.ball(16, 5)
        voxels[0] = 1
        nrrd.write(image, [16, 16, 16], voxels)
        self.run_well("check", image, "--report", page)
        html = page.read_text(encoding="utf-8")
        self.assertIn("<code>islands</code>", html)
        self.assertIn("voxel (0, 0, 0)", html)
        self.assertEqual(html.count("<img "), 2)

    def test_vessels_a_voxel_apart_are_not_said_to_be_separated(self):
        image = self.folder / "in.nrrd"
        middles = (9.5, 18.5)  # A voxel lies between the two tubes.
        voxels = [int(any(math.hypot(x - middle, y - 9.5) < 4 + 0.1 for middle in middles))
                  for z in range(24) for y in range(20) for x in range(28)]
        nrrd.write(image, [28, 20, 24], bytearray(voxels))
        text = self.run_well("check", image).stdout
        self.assertIn("at most a voxel apart", text)
        self.assertIn("separate parts only what touches", text)
        result = self.run_well("info", image, "--touching", "separate")
        self.assertIn("no vessels that touch were found", result.stderr)

    def test_a_report_of_a_mesh_shows_its_outside(self):
        page, mesh = self.folder / "page.html", self.folder / "mesh.vtu"
        self.write(tube(10))
        self.run_well("delaunay", self.stl, "-o", mesh, "--delta", "1", "-q")
        self.run_well("check", mesh, "--report", page)
        self.assertEqual(page.read_text(encoding="utf-8").count("<img "), 1)

    def test_faults_of_meshes_have_places_and_pictures(self):
        page, mesh = self.folder / "page.html", self.folder / "mesh.mesh"
        points, tetrahedra, triangles = cube(3)
        a, b, *rest = tetrahedra[0]
        write_medit(mesh, points, [(b, a, *rest), *tetrahedra[1:]], triangles)
        result = self.run_lumesh("check", mesh, "--report", page, "--json")
        self.assertEqual(result.returncode, NOT_REACHED, result.stderr)
        turned = json.loads(result.stdout)["findings"][0]
        self.assertIn("1 cell is flat or turned inside out", turned["text"])
        self.assertEqual(len(turned["places_mm"]), 1)
        self.assertLess(math.dist(turned["places_mm"][0], (0, 0, 0)), 1)
        self.assertGreaterEqual(page.read_text(encoding="utf-8").count("<img "), 2)

    def test_a_report_does_not_replace_the_input(self):
        self.write(tube(10))
        before = self.stl.read_bytes()
        self.assert_refused(self.run_lumesh("check", self.stl, "--report", self.stl), USAGE, "in.stl")
        self.assertEqual(self.stl.read_bytes(), before)
        page = self.folder / "none" / "page.html"
        self.assert_refused(self.run_lumesh("check", self.stl, "--report", page), BAD_INPUT, "page.html")

    def test_repair_makes_faults_good_and_says_what_it_did(self):
        triangles = tube(10)
        del triangles[200:204]
        triangles[50] = triangles[50][::-1]
        self.write(triangles, triangles[300:330])  # A piece of the wall is there twice.
        done = self.folder / "done.json"
        said = self.run_well("repair", self.stl, "-o", self.out, "--json", done).stdout
        self.assertIn("holes filled", said)
        told = json.loads(done.read_text())
        self.assertEqual((told["method"], told["holes"], told["duplicate_triangles"]), ("local", 1, 30))
        self.assertEqual(told["turned_triangles"], 1)
        self.assertEqual(self.check(self.out), {})
        self.run_well("delaunay", self.out, "-o", self.folder / "mesh.vtu", "--delta", "1", "-q")

    def test_rims_count_as_when_meshed(self):
        # One end has two points that reach out so far that no plane cuts one off within a radius.
        wall = [t for t in tube(10) if not all(abs(abs(p[2]) - 5) < 1e-6 for p in t)]
        bent = lambda p: (p[0], p[1], p[2] + (0.8 * p[0] ** 2 if p[2] > 4.9 else 0))
        self.write([tuple(bent(p) for p in t) for t in wall])
        found = self.check(self.stl)
        info = json.loads(self.run_well("info", self.stl, "--json", "-q").stdout)
        self.assertEqual(len(info["openings"]), 1)
        self.assertEqual((found["openings"]["count"], found["holes"]["count"]), (1, 1))

    def test_names_that_a_format_cannot_hold_are_warned_of(self):
        triangles, named = tube(10), self.folder / "named.stl"
        write_stl(named, {"left": triangles[:300], "right": triangles[300:]})
        self.assertIn("left, right are lost", self.run_well("repair", named, "-o", self.folder / "binary.stl").stderr)

    def test_openings_stay_open_and_patches_keep_their_names(self):
        wall = [t for t in tube(10) if not all(abs(abs(p[2]) - 5) < 1e-6 for p in t)]
        write_stl(self.stl, {"left": [t for t in wall if sum(p[0] for p in t) < 0],
                             "right": [t for t in wall if sum(p[0] for p in t) >= 0 and t is not wall[100]]})
        self.run_well("repair", self.stl, "-o", self.out)
        found = self.check(self.out)
        self.assertEqual((list(found), found["openings"]["count"]), (["openings"], 2))
        info = json.loads(self.run_well("info", self.out, "--json", "-q").stdout)
        self.assertEqual([patch["name"] for patch in info["patches"]], ["left", "right"])
        self.assertEqual(sum(patch["faces"] for patch in info["patches"]), len(wall))

    def test_tubes_that_cross_become_one(self):
        self.write(tube(10), tube(10, axis=0, shift=(0.1, 0.3, 0.2)))
        self.assertIn("self_intersections", self.check(self.stl, NOT_REACHED))
        done = self.folder / "done.json"
        for method in ("rebuild", "local"):  # The last one is meshed.
            warned = self.run_well("repair", self.stl, "-o", self.out, "--json", done, "--method", method).stderr
            self.assertIn("2 components have become 1", warned)
            told = json.loads(done.read_text())
            self.assertEqual((told["method"], told["given_components"], told["components"]), (method, 2, 1))
            self.assertLessEqual(told["moved_mm"], told["max_distance_mm"])
            self.assertNotIn("self_intersections", self.check(self.out))
        self.assertGreater(told["cut_triangles"], 0)
        self.assertLess(told["moved_mm"], 1e-6)
        self.run_well("delaunay", self.out, "-o", self.folder / "mesh.vtu", "--delta", "1", "-q")

    def test_what_encloses_nothing_is_not_written(self):
        flat = self.folder / "flat.off"
        flat.write_text("OFF\n4 2 0\n0 0 0\n1 0 0\n2 0 0\n3 0 0\n3 0 1 2\n3 1 2 3\n")
        self.assert_refused(self.run_lumesh("repair", flat, "-o", self.out), NOT_REACHED, "encloses nothing")
        self.assertFalse(self.out.exists())

    def test_what_encloses_nothing_gets_no_advice_of_meshers(self):
        one = self.folder / "one.obj"
        one.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        result = self.run_lumesh("repair", one, "-o", self.out)
        self.assert_refused(result, NOT_REACHED, "nothing of its inside is left", "--max-distance")
        self.assertNotIn("delta", result.stderr)
        self.assertFalse(self.out.exists())

    def test_a_distance_that_is_none_is_refused(self):
        self.write(tube(10))
        for text in ("0", "-1%", "wide", "nan"):
            self.assert_refused(self.run_lumesh("repair", self.stl, "-o", self.out, f"--max-distance={text}"), USAGE,
                                "--max-distance")

    def test_surfaces_of_others_are_repaired_or_refused_with_a_place(self):
        if not SHARED.is_dir():
            self.skipTest(f"no {SHARED}")
        for name in ("palabos_aneurysm.stl", "aorta-surface-two-segments.vtp"):
            with self.subTest(name):
                result = self.run_lumesh("repair", SHARED / "unseen" / name, "-o", self.out)
                if result.returncode == 0:
                    self.check(self.out)
                else:
                    self.assert_refused(result, NOT_REACHED, " mm")


if __name__ == "__main__":
    unittest.main()
