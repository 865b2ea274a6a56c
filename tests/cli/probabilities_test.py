#!/usr/bin/env python3
"""Images of probabilities and grey values: where the boundary runs, what is said of it, what is refused.

Usage: probabilities_test.py LUMESH      Exit codes of lumesh: 1 usage, 2 bad input.
"""
import json
import math
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import nrrd
from program import BAD_INPUT, USAGE, ProgramTest

SIZES, MIDDLE, RADIUS = [24, 24, 24], (11.3, 11.6, 11.1), 7.4


def ball():
    """Of a ball: 0.5 on its surface, rising by a half in a voxel; i fastest."""
    return [min(1, max(0, 0.5 + 0.5 * (RADIUS - math.dist((i, j, k), MIDDLE))))
            for k in range(SIZES[2]) for j in range(SIZES[1]) for i in range(SIZES[0])]


class ProbabilitiesTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.values = ball()
        self.soft = self.write("soft.nrrd", self.values, "float")
        self.labels = self.write("labels.nrrd", [2 if p >= 0.5 else 0 for p in self.values])
        self.mesh = self.folder / "out.mesh"

    def write(self, name, voxels, kind="uint8", **options):
        return nrrd.write(self.folder / name, SIZES, voxels, kind=kind, **options)

    def boundary(self, *arguments):
        return json.loads(self.run_well("info", *arguments, "--json").stdout)["boundary"]

    def distance_from_ball(self):
        """R.m.s. of the mesh's surface vertices, in voxels."""
        words = iter(self.mesh.read_text().split())
        points, on_surface = [], set()
        for word in words:
            if word == "Vertices":
                points = [[float(next(words)) for _ in range(4)][:3] for _ in range(int(next(words)))]
            elif word == "Triangles":
                for _ in range(int(next(words))):
                    on_surface.update(int(next(words)) for _ in range(3))
                    next(words)
        squares = [(math.dist(points[v - 1], MIDDLE) - RADIUS) ** 2 for v in on_surface]
        return math.sqrt(sum(squares) / len(squares))

    def test_the_mesh_follows_the_values_between_the_voxels(self):
        self.run_well("lattice", self.labels, "--spacing", 1.2, "-o", self.mesh)
        by_labels = self.distance_from_ball()
        self.run_well("lattice", self.labels, "--spacing", 1.2, "--probabilities", self.soft, "-o", self.mesh)
        self.assertLess(self.distance_from_ball(), min(0.02, by_labels))
        self.run_well("lattice", self.soft, "--spacing", 1.2, "-o", self.mesh)
        self.assertLess(self.distance_from_ball(), 0.02)

    def test_delaunay_meshes_follow_them_too(self):
        self.run_well("delaunay", self.labels, "--delta", 0.8, "--probabilities", self.soft, "-o", self.mesh)
        self.assertLess(self.distance_from_ball(), 0.02)

    def test_info_says_whether_values_place_the_boundary(self):
        found = self.boundary(self.soft)
        self.assertEqual(found["placed_by_values"], found["faces"])
        self.assertEqual(self.boundary(self.labels), {"faces": found["faces"], "placed_by_values": 0})
        self.assertEqual(self.boundary(self.labels, "--probabilities", self.soft), found)
        grey = self.write("grey.nrrd", [round(255 * p) for p in self.values])
        self.assertEqual(self.boundary(grey, "--threshold", 127.5), found)
        self.assertEqual(self.boundary(self.labels, "--threshold", 2)["placed_by_values"], 0)
        self.assertIn("placed_by_values", self.run_well("info", self.soft).stdout)

    def test_a_case_takes_them_and_its_report_says_so(self):
        case = self.folder / "case.toml"
        case.write_text(f'[input]\nimage = "labels.nrrd"\nprobabilities = "soft.nrrd"\n'
                        f'[output]\nfolder = "out"\nreport = ""\n')
        self.run_well("run", case)
        text = (self.folder / "out" / "report.json").read_text()
        self.assertIn("Boundary placed by values", text)

    def test_what_is_no_map_of_probabilities_on_the_grid_is_refused(self):
        for name, path, word in (
                ("scaled", self.write("scaled.nrrd", [255 * p for p in self.values], "float"), "255"),
                ("logits", self.write("logits.nrrd", [p - 0.5 for p in self.values], "float"), "-0.5"),
                ("spacing", self.write("spacing.nrrd", self.values, "float", spacing=[1, 1, 1.1]), "grid"),
                ("size", nrrd.write(self.folder / "size.nrrd", [24, 24, 23], self.values[:-576], kind="float"), "grid"),
                ("missing", self.folder / "missing.nrrd", "no such file")):
            with self.subTest(name):
                result = self.run_lumesh("lattice", self.labels, "--probabilities", path, "-o", self.mesh)
                self.assert_refused(result, BAD_INPUT, path.name, word)
                self.assertFalse(self.mesh.exists())

    def test_what_says_nothing_is_warned_of(self):
        nothing = float("nan")
        for name, voxels, kind, word in (("nan", [nothing] + self.values[1:], "float", "1 voxels"), ("other", [1 - p for p in self.values], "float", "100 %"),
                                         ("mask", [1 if p >= 0.5 else 0 for p in self.values], "uint8", "labels")):
            with self.subTest(name):
                path = self.write(f"{name}.nrrd", voxels, kind)
                result = self.run_well("info", self.labels, "--probabilities", path)
                self.assertEqual(len(result.stderr.splitlines()), 1)
                self.assertIn("warning", result.stderr)
                self.assertIn(word, result.stderr)

    def test_options_that_do_not_go_together_are_refused(self):
        result = self.run_lumesh("info", self.labels, "--probabilities", self.soft, "--threshold", 1)
        self.assert_refused(result, USAGE, "--threshold", "--probabilities")
        stl = self.folder / "a.stl"
        stl.write_text("")
        result = self.run_lumesh("delaunay", stl, "--delta", 1, "--probabilities", self.soft, "-o", self.mesh)
        self.assert_refused(result, USAGE, "--probabilities", "images")
        result = self.run_lumesh("lattice", self.labels, "--probabilities", self.soft, "-o", self.mesh, "--surface", self.soft)
        self.assertEqual(result.returncode, USAGE)
        case = self.folder / "case.toml"
        case.write_text('[input]\nphantom = "sphere"\nprobabilities = "soft.nrrd"\n')
        self.assert_refused(self.run_lumesh("run", case), BAD_INPUT, "probabilities", "phantom")


if __name__ == "__main__":
    unittest.main()
