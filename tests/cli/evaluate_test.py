#!/usr/bin/env python3
"""What evaluate tells of a mesh beside its image: voxels kept, volume, topology, narrowest sections, curvature.

Usage: evaluate_test.py LUMESH
"""
import json
import math
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import cube
import nrrd
from program import BAD_INPUT, USAGE, ProgramTest


def square_vessel(size, length, side):
    """Voxels of a square vessel in the middle of the image; side(k) voxels wide, from end to end."""
    def inside(i, j, k):
        low = (size - side(k)) // 2
        return low <= i < low + side(k) and low <= j < low + side(k)

    return [1 if inside(i, j, k) else 0 for k in range(length) for j in range(size) for i in range(size)]


class EvaluateTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.mesh = self.folder / "vessel.mesh"
        self.json = self.folder / "vessel.json"
        # 8 voxels wide, 6 from slice 28 on to slice 35: about the axis of the voxels at (7.5, 7.5).
        self.image = nrrd.write(self.folder / "vessel.nrrd", [16, 16, 64],
                                square_vessel(16, 64, lambda k: 6 if 28 <= k < 36 else 8))

    def write_mesh(self, throat):
        """The vessel in 32 layers of 2 mm: 8 mm wide, `throat` from z = 27.5 to 35.5."""
        points, tetrahedra, _ = cube.cube(32)

        def place(p):
            z = 64 * p[2] - 0.5
            side = throat if 27.4 < z < 35.6 else 8
            return (7.5 + side * (p[0] - 0.5), 7.5 + side * (p[1] - 0.5), z)

        cube.write_medit(self.mesh, [place(p) for p in points], tetrahedra, [])

    def evaluate(self, *options):
        result = self.run_well("evaluate", self.mesh, "--image", self.image, "--json", self.json, *options)
        return result, json.loads(self.json.read_text())

    def test_a_throat_that_is_tightened_is_told_and_warned_of(self):
        self.write_mesh(5.7)
        report = self.folder / "vessel.html"
        result, numbers = self.evaluate("--report", report)
        self.assertEqual(len(numbers["narrowest_sections"]), 1)
        section = numbers["narrowest_sections"][0]
        self.assertAlmostEqual(section["mesh_area_mm2"], 5.7 ** 2, delta=0.01)
        self.assertAlmostEqual(section["voxel_area_mm2"], 36, delta=0.01)
        self.assertAlmostEqual(section["change_percent"], 100 * (5.7 ** 2 / 36 - 1), delta=0.05)
        self.assertTrue(27.5 < section["centre_mm"][2] < 35.5)
        self.assertIn("TIGHTENED", result.stdout)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        self.assertIn("1 of 1 branches is more than 3 % narrower", result.stderr)
        self.assertEqual(len(numbers["warnings"]), 1)
        for words in ("Narrowest section of each branch", "Voxels kept", "Mean curvature of the wall",
                      "narrower in the mesh than in the voxels"):
            self.assertIn(words, report.read_text())

    def test_a_mesh_on_its_voxels_keeps_all_but_where_it_narrows_too_early(self):
        self.write_mesh(6)
        result, numbers = self.evaluate()
        self.assertEqual(result.stderr, "")
        # In slices 27 and 36 the mesh is 6.5 mm wide: voxels 3.5 mm from the axis are missed, 8^2 - 6^2 of them.
        kept = numbers["labels"][0]["voxels_kept"]
        self.assertEqual((kept["counted"], kept["kept"]), (56 * 64 + 8 * 36, 56 * 64 + 8 * 36 - 2 * 28))
        self.assertIn(kept["worst"]["voxel"][2], (27, 36))
        self.assertEqual(numbers["image"]["background_voxels_kept"]["share"], 1)
        self.assertAlmostEqual(numbers["narrowest_sections"][0]["change_percent"], 0, delta=0.05)
        # What the layers between 8 and 6 mm have too little: (64 - (64 + 48 + 36) / 3) * 2 on both sides.
        self.assertAlmostEqual(numbers["volume_mm3"], 56 * 64 + 8 * 36 - 2 * 2 * (64 - 148 / 3), delta=1e-6)
        self.assertEqual(numbers["topology_differences"], [])
        self.assertTrue(math.isfinite(numbers["mean_curvature_per_mm"]["root_mean_square"]))

    def test_a_piece_that_the_mesh_does_not_have_is_told_with_its_place(self):
        self.write_mesh(6)
        voxels = square_vessel(16, 64, lambda k: 6 if 28 <= k < 36 else 8)
        for i, j, k in ((13, 2, 20), (14, 2, 20), (13, 3, 20)):
            voxels[i + 16 * (j + 16 * k)] = 1
        self.image = nrrd.write(self.folder / "crumb.nrrd", [16, 16, 64], voxels)
        report = self.folder / "vessel.html"
        result, numbers = self.evaluate("--report", report)
        self.assertEqual(numbers["topology_differences"], ["label 1: components 1 (image 2)"])
        self.assertEqual(len(numbers["topology_places"]), 1)
        place = numbers["topology_places"][0]
        self.assertEqual((place["label"], place["change"], place["voxels"]), (1, "missing piece", 3))
        self.assertEqual(place["box"], {"low": [13, 2, 20], "high": [15, 4, 21]})
        for found, truth in zip(place["centre_mm"], (40 / 3, 7 / 3, 20)):
            self.assertAlmostEqual(found, truth, places=9)
        words = "a piece of 3 voxels (3 mm³) that the mesh does not have"
        self.assertIn("label 1 at (13.33, 2.33, 20.00) mm: " + words, result.stdout)
        self.assertIn(words, report.read_text(encoding="utf-8"))

    def test_voxels_have_the_indices_of_the_image_given_however_it_is_extended(self):
        self.mesh = self.folder / "long.vtu"
        self.run_well("delaunay", self.image, "--extend", "5", "-o", self.mesh, "--edge-length", 2, "-q")
        _, numbers = self.evaluate("--extend", "5")
        self.assertEqual(numbers["image"]["size"], [16, 16, 64])
        told = [kept["worst"] for kept in (numbers["image"]["voxels_kept"], numbers["image"]["background_voxels_kept"]) if kept["worst"]]
        self.assertTrue(told)
        for worst in told:  # Voxels of 1 mm, the first in the origin.
            place = [round(x) for x in worst["centre_mm"]]
            is_within = all(0 <= x < n for x, n in zip(place, (16, 16, 64)))
            self.assertEqual(worst["voxel"], place if is_within else None)

    def test_axes_come_from_a_file_or_are_left_out(self):
        self.write_mesh(5.7)
        result, numbers = self.evaluate("--centerline", "none")
        self.assertIsNone(numbers["narrowest_sections"])
        self.assertEqual((result.stderr, numbers["warnings"]), ("", []))
        lines = self.folder / "lines.vtp"
        self.run_well("centerline", self.image, "-o", lines)
        _, by_file = self.evaluate("--centerline", lines)
        _, by_image = self.evaluate()
        self.assertEqual(by_file["narrowest_sections"], by_image["narrowest_sections"])

    def test_axes_that_say_nothing_are_refused(self):
        self.write_mesh(6)
        self.assert_refused(self.run_lumesh("evaluate", self.mesh, "--centerline", "none"), USAGE, "--centerline", "--image")
        with_image = ["evaluate", self.mesh, "--image", self.image, "--centerline"]
        self.assert_refused(self.run_lumesh(*with_image, self.folder / "no.vtp"), BAD_INPUT, "no.vtp")
        lines = self.folder / "lines.vtp"
        self.run_well("centerline", self.image, "-o", lines)
        lines.write_text(lines.read_text(encoding="latin-1").replace('Name="radius"', 'Name="width"'), encoding="latin-1")
        self.assert_refused(self.run_lumesh(*with_image, lines), BAD_INPUT, "lines.vtp", "radius", "lumesh centerline")

    def test_options_of_an_image_need_one(self):
        mesh = self.folder / "cube.mesh"
        points, tetrahedra, _ = cube.cube(2)
        cube.write_medit(mesh, points, tetrahedra, [])
        for option in (("--threshold", 3), ("--largest-component",)):
            self.assert_refused(self.run_lumesh("evaluate", mesh, *option), USAGE, option[0], "--image names none")

    def test_an_object_without_axes_has_no_sections(self):
        ball = nrrd.write(self.folder / "ball.nrrd", [24] * 3, nrrd.ball(24, 8))
        mesh = self.folder / "ball.vtu"
        self.run_well("lattice", ball, "-o", mesh)
        result = self.run_well("evaluate", mesh, "--image", ball, "--json", self.json)
        self.assertEqual(result.stderr, "")
        self.assertIsNone(json.loads(self.json.read_text())["narrowest_sections"])
        self.assertIn("voxels kept", result.stdout)
        self.assertNotIn("narrowest sections", result.stdout)

    def test_a_phantom_is_cut_without_an_image_too(self):
        plane = ("--cut-plane", 32, 32, 35, 0, 0, 1)
        sphere, mesh = self.folder / "sphere.nrrd", self.folder / "sphere.vtu"
        self.run_well("phantom", "sphere", "-o", sphere)
        self.run_well("lattice", sphere, "-o", mesh, *plane)
        self.run_well("evaluate", mesh, "--reference", self.folder / "sphere.phantom.json", *plane, "--json", self.json)
        reference = json.loads(self.json.read_text())["labels"][0]["reference"]
        self.assertLess(reference["surface_distance_mm"]["max"], 1)
        self.assertLess(reference["truth_to_mesh_mm"]["max"], 1)
        self.assert_refused(self.run_lumesh("evaluate", mesh, "--cut-at", "32,32,35"), USAGE, "--cut-at", "--image")


if __name__ == "__main__":
    unittest.main(verbosity=2)
