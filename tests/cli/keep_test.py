#!/usr/bin/env python3
"""`--keep` of `lumesh adapt`, `metric` and `improve`: cells of some labels stay to the last bit, the rest changes.

Usage: keep_test.py LUMESH      Exit codes of lumesh: 1 usage, 2 bad input.
"""
import collections
import pathlib
import re
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from cube import cube, write_medit, write_sol
from program import BAD_INPUT, USAGE, MeshTest

CORNERS = {"Tetrahedra": 4, "Pyramids": 5, "Prisms": 6, "Hexahedra": 8}


class KeepTest(MeshTest):
    def sized(self, mesh, label, size):
        """With the same size everywhere, but for what stands at kept cells."""
        sizes, found = self.folder / "sized.vtu", ("--curvature", "--min-size", size, "--max-size", size)
        self.run_well("metric", mesh, "--keep", label, *found, "-o", sizes)
        return sizes

    def cells(self, mesh, label):
        """Every cell of a label by the digits of its corners' coordinates, in their order."""
        text = self.folder / "cells.mesh"
        self.run_well("convert", mesh, text)
        words = text.read_text(encoding="ascii").split()
        first = words.index("Vertices") + 2
        points = [tuple(words[i:i + 3]) for i in range(first, first + 4 * int(words[first - 1]), 4)]
        found = collections.Counter()
        for shape, corners in CORNERS.items():
            if shape not in words:
                continue
            first, width = words.index(shape) + 2, corners + 1
            for i in range(first, first + width * int(words[first - 1]), width):
                if int(words[i + corners]) == label:
                    found[tuple(points[int(v) - 1] for v in words[i:i + corners])] += 1
        return found

    def assert_keeps(self, before, after, label):
        """The cells of a label, volumes, patches and their numbers; the result is valid and conforms."""
        kept = self.cells(before, label)
        self.assertGreater(len(kept), 1000)
        self.assertEqual(self.cells(after, label), kept)
        was, found = self.evaluate(before), self.evaluate(after)
        self.assertTrue(found["valid"], found)
        self.assertEqual(found["components"], was["components"])
        for key in ("volume_mm3", "name"):
            for one, other in zip(was["labels"], found["labels"]):
                self.assertEqual(*(round(of[key], 9) if key == "volume_mm3" else of[key] for of in (one, other)))
        areas = [[(p["name"], round(p["area_mm2"], 9)) for p in of["boundary"]["patches"]] for of in (was, found)]
        self.assertEqual(areas[0], areas[1])
        return found

    def test_prisms_around_a_vessel_stay_while_it_becomes_finer_or_coarser(self):
        mesh = self.layered("--cells", "prisms")
        kept = sum(self.cells(mesh, 2).values())  # prisms, and what stands where columns end
        for size, least, most in ((0.3, 30000, 60000), (1.2, 4000, 10000)):
            with self.subTest(size):
                result = self.run_well("adapt", self.sized(mesh, "vessel_wall", size), "--keep", "vessel_wall", "-o", self.out)
                found = self.assert_keeps(mesh, self.out, 2)
                self.assertGreater(found["prisms"], 0.98 * kept)
                self.assertIn(f"with {kept} cells as they were", result.stdout)
                self.assertGreater(found["tetrahedra"], least)
                self.assertLess(found["tetrahedra"], most)
                self.assertGreater(found["metric_edge_length"]["fraction_in_band"], 0.94)

    def test_layers_within_a_vessel_stay_while_the_rest_changes(self):
        mesh = self.layered("--side", "inward", "--cells", "prisms")
        self.run_well("adapt", self.sized(mesh, "layer", 0.35), "--keep", "layer", "-o", self.out)
        self.assert_keeps(mesh, self.out, 2)

    def test_layers_of_tetrahedra_stay_and_so_does_the_lumen_where_the_wall_changes(self):
        mesh = self.layered()
        for label, number in (("2", 2), ("1", 1)):
            with self.subTest(label):
                self.run_well("adapt", self.sized(mesh, label, 0.6), "--keep", label, "--boundary", "frozen", "-o", self.out)
                self.assert_keeps(mesh, self.out, number)

    def test_a_complexity_is_met_beside_what_is_kept(self):
        mesh = self.layered("--cells", "prisms")
        result = self.run_well("adapt", self.sized(mesh, "vessel_wall", 0.5), "--keep", "vessel_wall", "--complexity", 5000, "-o", self.out)
        self.assertAlmostEqual(float(re.search(r"complexity (\d+)", result.stdout)[1]) / 5000, 1, delta=0.025)
        self.assert_keeps(mesh, self.out, 2)

    def test_improve_keeps_cells_too(self):
        mesh = self.layered("--cells", "prisms")
        result = self.run_well("improve", mesh, "--keep", "vessel_wall", "-o", self.out)
        after, before = map(int, re.search(r"(\d+) tetrahedra outside the targets \(before: (\d+)\)", result.stdout).groups())
        self.assertLess(after, before / 2)
        self.assert_keeps(mesh, self.out, 2)

    def test_every_number_of_threads_gives_the_same_file(self):
        mesh, files = self.sized(self.layered("--cells", "prisms"), "vessel_wall", 0.4), set()
        for threads in (1, 2, 8):
            self.run_well("adapt", mesh, "--keep", "vessel_wall", "--threads", threads, "-o", self.out)
            files.add(self.out.read_bytes())
        self.assertEqual(len(files), 1)

    def test_a_metric_of_all_points_in_a_file_or_a_formula(self):
        mesh, sizes = self.folder / "two.mesh", self.folder / "two.sol"
        points, tetrahedra, triangles = cube(4)
        tetrahedra = [(*t[:4], 1 if sum(points[v - 1][0] for v in t[:4]) < 2 else 2) for t in tetrahedra]
        write_medit(mesh, points, tetrahedra, [])
        write_sol(sizes, [(100, 0, 100, 0, 0, 100)] * len(points))
        for metric in (("--metric", sizes), ("--analytic", "linear")):
            self.run_well("adapt", mesh, "--keep", 2, *metric, "-o", self.out)
            found = self.evaluate(self.out)
            self.assertTrue(found["valid"])
            self.assertEqual(self.cells(self.out, 2), self.cells(mesh, 2))
            self.assertGreater(found["tetrahedra"], 1000)

    def test_what_cannot_be_kept_is_refused(self):
        mesh = self.layered("--cells", "prisms")
        adapt = ("adapt", mesh, "--analytic", "linear", "-o", self.out)
        self.assert_refused(self.run_lumesh(*adapt), BAD_INPUT, "hexahedra, prisms or pyramids", "--keep")
        self.assert_refused(self.run_lumesh(*adapt, "--keep", "door"), BAD_INPUT, "door", "labels present: 1, 2 (vessel_wall)")
        self.assert_refused(self.run_lumesh(*adapt, "--keep", "1,vessel_wall"), BAD_INPUT, "all labels are kept")
        self.assert_refused(self.run_lumesh(*adapt, "--keep", "1"), BAD_INPUT, "label 2", "other than tetrahedra")
        self.assert_refused(self.run_lumesh("adapt", mesh, "--keep", "vessel_wall", "-o", self.out), BAD_INPUT, "no metric")
        self.assert_refused(self.run_lumesh("metric", mesh, "--keep", "vessel_wall", "--hessian", "p", "-o", self.out), USAGE, "--hessian")


if __name__ == "__main__":
    unittest.main()
