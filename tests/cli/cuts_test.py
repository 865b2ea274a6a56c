#!/usr/bin/env python3
"""Vessels that are cut at a place: lattice, delaunay, run and evaluate make the same opening of it.

Usage: cuts_test.py LUMESH      Exit codes of lumesh: 1 usage, 2 bad input, 3 request not reached.
"""
import json
import math
import pathlib
import re
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import nrrd
from program import BAD_INPUT, NOT_REACHED, USAGE, ProgramTest

RADIUS = 4.2
TUBES = {"low": 10.3, "high": 27.8}  # z of two tubes along x; the low one leaves the image, the high one ends inside.


class CutsTest(ProgramTest):
    def setUp(self):
        super().setUp()
        size = [48, 22, 38]

        def label(x, y, z):
            across = y - 10.6
            low = math.hypot(across, z - TUBES["low"]) < RADIUS
            joint = abs(x - 8) < RADIUS and abs(across) < RADIUS and TUBES["low"] < z < TUBES["high"]
            high = math.hypot(across, z - TUBES["high"]) < RADIUS and 4 < x < 43
            return 1 if low or high or joint else 0

        voxels = bytes(label(x, y, z) for z in range(size[2]) for y in range(size[1]) for x in range(size[0]))
        self.image = nrrd.write(self.folder / "pair.nrrd", size, voxels)

    def openings(self, *arguments):
        """Names and areas that `lumesh info` or `evaluate` tells."""
        numbers = json.loads(self.run_well(*arguments).stdout)
        return {o["name"]: o for o in numbers["openings"]}

    def test_one_of_two_vessels_that_a_plane_meets_is_cut(self):
        place = f"30,10.6,{TUBES['high']}"
        self.assertEqual(len(self.openings("info", self.image, "--json")), 2)
        openings = self.openings("info", self.image, "--json", "--cut-at", place)
        self.assertEqual(sorted(openings), ["inlet_1", "outlet_1", "outlet_2"])
        cut = [o for o in openings.values() if abs(o["centre_mm"][2] - TUBES["high"]) < 1]
        self.assertEqual(len(cut), 1)
        self.assertAlmostEqual(cut[0]["area_mm2"] / (math.pi * RADIUS**2), 1, delta=0.03)
        self.assertAlmostEqual(cut[0]["centre_mm"][0], 30, delta=0.5)

    def test_both_meshers_and_evaluate_agree(self):
        place = f"30,10.6,{TUBES['high']}"
        for mesher in ("lattice", "delaunay"):
            with self.subTest(mesher):
                mesh, numbers = self.folder / f"{mesher}.vtu", self.folder / f"{mesher}.json"
                made = self.run_well(mesher, self.image, "-o", mesh, "--edge-length", "1.5", "--cut-at", place, "--strict")
                self.assertEqual(len(re.findall(r"patch (?:inlet|outlet)_\d", made.stdout)), 3)
                self.assertNotIn("warning", made.stderr)
                self.run_well("evaluate", mesh, "--image", self.image, "--cut-at", place, "--json", numbers)
                report = json.loads(numbers.read_text())
                self.assertEqual(len(report["openings"]), 3)
                for opening in report["openings"]:
                    self.assertLess(abs(opening["change_percent"]), 2)
                self.assertLess(abs(report["labels"][0]["volume_error_percent"]), 2)

    def test_both_meshers_extend_vessels_as_info_says(self):
        cut = ["--cut-at", f"30,10.6,{TUBES['high']}"]
        extended = [*cut, "--extend", "3r,outlet_2=0"]
        before, after = self.openings("info", self.image, "--json", *cut), self.openings("info", self.image, "--json", *extended)
        self.assertEqual(sorted(before), sorted(after))
        for name, opening in before.items():
            length = math.dist(opening["centre_mm"], after[name]["centre_mm"])
            wanted = 0 if name == "outlet_2" else 3 * opening["radius_mm"]
            self.assertAlmostEqual(length, wanted, delta=0.05 + 0.01 * wanted)
            self.assertAlmostEqual(after[name]["area_mm2"] / opening["area_mm2"], 1, delta=0.01)
        for mesher in ("lattice", "delaunay"):
            with self.subTest(mesher):
                mesh, numbers = self.folder / f"{mesher}.vtu", self.folder / f"{mesher}.json"
                self.run_well(mesher, self.image, "-o", mesh, "--edge-length", "1.5", "--strict", *extended)
                asked = self.run_well("evaluate", mesh, "--image", self.image, *cut)
                self.assertIn("--extend 3r,outlet_2=0", asked.stderr)
                self.run_well("evaluate", mesh, "--image", self.image, *extended, "--json", numbers)
                report = json.loads(numbers.read_text())
                self.assertEqual(sorted(o["patches"] for o in report["openings"]), sorted(after))
                for opening in report["openings"]:
                    self.assertLess(abs(opening["change_percent"]), 2)
                self.assertLess(abs(report["labels"][0]["volume_error_percent"]), 2)

    def test_a_finished_mesh_is_extended(self):
        mesh, longer = self.folder / "mesh.vtu", self.folder / "longer.vtu"
        self.run_well("lattice", self.image, "-o", mesh, "--edge-length", "1.5")
        self.run_well("layers", mesh, "-o", longer, "--extend", "inlet_1=3r")
        self.assert_refused(self.run_lumesh("layers", mesh, "-o", longer, "--extend", "inlet_7=3r"), BAD_INPUT, "inlet_7", "outlet_1")
        self.assert_refused(self.run_lumesh("layers", mesh, "-o", longer), USAGE, "--extend")

    def test_a_finished_mesh_is_cut(self):
        plane = ["30", "10.6", "0", "1", "0", "0.2"]
        whole = self.folder / "whole.vtu"
        for mesher in ("lattice", "delaunay"):  # Of the image, cut alike, for comparison.
            with self.subTest(mesher):
                wanted = self.openings("info", self.image, "--cut-plane", *plane, "--json")
                self.run_well(mesher, self.image, "-o", whole, "--edge-length", "1.5")
                cut, numbers = self.folder / "cut.vtu", self.folder / "cut.json"
                made = self.run_well("improve", whole, "-o", cut, "--cut-plane", *plane, "--json", numbers)
                self.assertNotIn("warning", made.stderr)
                report = json.loads(numbers.read_text())
                self.assertEqual(report["after"]["tetrahedra_outside"], 0)
                # The low vessel's outlet at the border goes, and both cuts are new; voxels make 3 % of the section.
                new = sorted(o["area_mm2"] for o in report["cut"]["openings"])
                section = math.pi * RADIUS**2 * math.hypot(1, 0.2)
                self.assertEqual(len(new), 2)
                for area in new:
                    self.assertAlmostEqual(area / section, 1, delta=0.03)
                self.run_well("evaluate", cut, "--image", self.image, "--cut-plane", *plane, "--json", numbers)
                compared = json.loads(numbers.read_text())["openings"]
                self.assertEqual(len(compared), len(wanted))
                for opening in compared:
                    self.assertLess(abs(opening["change_percent"]), 2)
                self.assertIn("--cut-plane 30 10.6", self.run_well("evaluate", cut, "--image", self.image).stderr)

    def test_a_plane_that_cuts_nothing_off_is_told(self):
        corners = [(x, y, z) for z in (0, 4) for y in (0, 4) for x in (0, 4)]
        faces = ((0, 2, 3), (0, 3, 1), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4),
                 (2, 6, 7), (2, 7, 3), (0, 4, 6), (0, 6, 2), (1, 3, 7), (1, 7, 5))
        box = self.folder / "box.off"
        box.write_text("OFF\n8 12 0\n" + "".join("%d %d %d\n" % c for c in corners) + "".join("3 %d %d %d\n" % f for f in faces))
        for path, misses, meets in ((self.image, "0 0 99 0 0 1", "30 10.6 0 1 0 0"), (box, "0 0 99 0 0 1", "2 2 2 0 0 1")):
            told = self.run_well("delaunay", path, "-o", self.folder / "mesh.vtu", "--cut-plane", *misses.split(), *meets.split()).stderr
            self.assertIn("the plane through (0.0, 0.0, 99.0) mm with the normal (0, 0, 1) cuts nothing off", told)
            self.assertEqual(told.count("cuts nothing off"), 1, told)

    def test_several_planes_may_follow_one_option(self):
        mesh, one, two = (self.folder / f"{name}.vtu" for name in ("mesh", "one", "two"))
        self.run_well("lattice", self.image, "-o", mesh, "--edge-length", "2")
        first, second = "30 0 0 1 0 0".split(), "14 0 0 -1 0 0".split()
        self.run_well("improve", mesh, "-o", one, "--cut-plane", *first, *second)
        self.run_well("improve", mesh, "-o", two, "--cut-plane", *first, "--cut-plane", *second)
        names = [json.loads(self.run_well("info", m, "--json").stdout)["patches"] for m in (one, two)]
        self.assertEqual(names[0], names[1])
        self.assertEqual(len(names[0]), 5)
        self.assert_refused(self.run_lumesh("lattice", self.image, "-o", one, "--cut-plane", *first, "1", "2", "3"), USAGE, "6 numbers", "not 9")
        for normal, why in (("0", "normal is zero"), ("1e-320", "too short or too long"), ("1e200", "too short or too long")):
            self.assert_refused(self.run_lumesh("lattice", self.image, "-o", one, "--cut-plane", *"0 0 0 0 0".split(), normal), USAGE, why)

    def test_cuts_of_a_mesh_that_make_no_sense_are_refused(self):
        mesh, cut = self.folder / "mesh.vtu", self.folder / "cut.vtu"
        self.run_well("lattice", self.image, "-o", mesh, "--edge-length", "1.5")
        self.assert_refused(self.run_lumesh("improve", mesh, "-o", cut, "--cut-plane", "99", "0", "0", "1", "0", "0"), BAD_INPUT, "beyond")
        self.assert_refused(self.run_lumesh("improve", mesh, "-o", cut, "--cut-plane", "-9", "0", "0", "1", "0", "0"), BAD_INPUT, "nothing of the mesh is left")
        self.assertFalse(cut.exists())
        layered = self.folder / "layered.vtu"
        self.run_well("layers", mesh, "-o", layered, "--side", "inward", "--first-height", "0.1", "--count", "2", "--cells", "prisms")
        self.assert_refused(self.run_lumesh("improve", layered, "-o", cut, "--cut-plane", "30", "10.6", "0", "1", "0", "0"), BAD_INPUT, "prisms")

    def test_ends_of_vessels_that_leave_obliquely_are_clipped_farther_inside(self):
        """At 70 degrees to the face's normal a cut one radius before the end would meet the border."""
        radius, angle, size = 3.0, math.radians(70), [88, 14, 26]
        along = (math.sin(angle), 0, math.cos(angle))

        def is_inside(x, y, z):
            offset = (x - 43.6, y - 6.4, z - 12.3)
            height = sum(a * b for a, b in zip(offset, along))
            return sum((a - height * b) ** 2 for a, b in zip(offset, along)) < radius**2

        voxels = bytes(is_inside(x, y, z) for z in range(size[2]) for y in range(size[1]) for x in range(size[0]))
        image = nrrd.write(self.folder / "oblique.nrrd", size, voxels)
        told = self.run_well("info", image, "--json", "--clip-ends", "1r")
        self.assertEqual(len(re.findall(r"is cut [\d.]+ mm before it, not 3[.\d]* mm: the vessel is cut off obliquely", told.stderr)), 2)
        openings = json.loads(told.stdout)["openings"]
        self.assertEqual(len(openings), 2)
        for opening in openings:
            self.assertAlmostEqual(opening["area_mm2"] / (math.pi * radius**2), 1, delta=0.05)
            self.assertGreater(abs(sum(a * b for a, b in zip(opening["normal"], along))), math.cos(math.radians(3)))

    def test_ends_are_clipped_square(self):
        told = self.run_well("info", self.image, "--json", "--clip-ends", "2r")
        self.assertIn("(-0.5, 10.6, 10.4) mm stays", told.stderr)  # Two radii before it the two tubes join.
        clipped = [o for o in json.loads(told.stdout)["openings"] if o["centre_mm"][0] > 20]
        self.assertEqual(len(clipped), 2)
        for opening in clipped:
            self.assertAlmostEqual(opening["area_mm2"] / (math.pi * RADIUS**2), 1, delta=0.045)
            self.assertLess(opening["centre_mm"][0], 40)

    def test_extensions_that_make_no_sense_are_refused(self):
        for lengths, word in (("5x", "5x"), ("inlet_9=5r", "inlet_9"), ("5r,6r", "two lengths")):
            refused = self.run_lumesh("info", self.image, "--extend", lengths)
            self.assertIn(refused.returncode, (USAGE, BAD_INPUT), refused.stderr)
            self.assertIn(word, refused.stderr)

    def test_extensions_of_more_than_a_thousand_radii_are_refused(self):
        for lengths in ("1e7", "1e300", "1e300r", "inlet_1=1e20"):
            refused = self.run_lumesh("info", self.image, "--extend", lengths, "--time-limit", "20")
            self.assert_refused(refused, BAD_INPUT, "--extend: inlet_1 would go on by", "more than 1000 times its radius")

    def test_evaluate_asks_for_the_cuts_that_the_mesh_was_made_with(self):
        place, plane = f"30,10.6,{TUBES['high']}", ("12", "0", "0", "-1", "0", "0")
        mesh, coarse = self.folder / "cut.vtu", self.folder / "coarse.vtu"
        self.run_well("lattice", self.image, "-o", mesh, "--edge-length", "1.5", "--cut-at", place, "--cut-plane", *plane)
        self.run_well("improve", mesh, "-o", coarse)
        hint = f"--cut-plane {' '.join(plane)}", f"--cut-at {place}"
        for made in (mesh, coarse):
            for given in ((), ("--cut-at", place)):
                told = self.run_well("evaluate", made, "--image", self.image, *given).stderr
                self.assertIn("the same cuts", told)
                for option in hint:
                    self.assertIn(option, told)
            told = self.run_well("evaluate", made, "--image", self.image, "--cut-at", place, "--cut-plane", *plane).stderr
            self.assertNotIn("the same cuts", told)

    def test_a_case_file_cuts_as_the_option_does(self):
        case = self.folder / "case.toml"
        case.write_text(f'edge_length = 1.5\n[input]\nimage = "pair.nrrd"\ncut_at = [[30, 10.6, {TUBES["high"]}]]\n'
                        '[output]\nmeshes = ["mesh.vtu"]\nfolder = "out"\n')
        self.run_well("run", case)
        patches = json.loads(self.run_well("info", self.folder / "out/mesh.vtu", "--json").stdout)["patches"]
        self.assertEqual(sum(p["name"].startswith(("inlet", "outlet")) for p in patches), 3)
        told = self.run_well("evaluate", self.folder / "out/mesh.vtu", "--image", self.image).stderr
        self.assertIn(f"the same cuts are given: --cut-at 30,10.6,{TUBES['high']}", told)
        self.assertIn("cut_at = [[30", (self.folder / "out/effective.toml").read_text())

    def test_places_that_are_none_are_refused(self):
        mesh = self.folder / "mesh.vtu"
        for text in ("1,2", "a,b,c", "1,2,nan", "1 2 3"):
            self.assert_refused(self.run_lumesh("lattice", self.image, "-o", mesh, "--cut-at", text), USAGE, "--cut-at")
        far = self.run_lumesh("delaunay", self.image, "-o", mesh, "--cut-at", "30,2,18")
        self.assert_refused(far, BAD_INPUT, "pair.nrrd", "no vessel runs at (30.0, 2.0, 18.0) mm")
        self.assertFalse(mesh.exists())

    def test_strict_wants_an_opening(self):
        ball = nrrd.write(self.folder / "ball.nrrd", [24] * 3, nrrd.ball(24, 8))
        for mesher in ("lattice", "delaunay"):
            with self.subTest(mesher):
                mesh = self.folder / "ball.vtu"
                self.run_well(mesher, ball, "-o", mesh)
                self.assertEqual(self.run_lumesh(mesher, ball, "-o", mesh, "--strict").returncode, NOT_REACHED)


if __name__ == "__main__":
    unittest.main(verbosity=2)
