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
