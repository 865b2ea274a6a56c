#!/usr/bin/env python3
"""Meshes whose file says another unit than mm: options are in mm all the same, and outputs keep the file's unit.

Usage: units_test.py LUMESH
"""
import json
import math
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from cube import cube, write_medit
from program import BAD_INPUT, ProgramTest


def outwards(points, triangle):
    """A face of the unit cube, turned so that it looks out of it."""
    a, b, c = (points[v - 1] for v in triangle[:3])
    u, v = [[q - p for p, q in zip(a, end)] for end in (b, c)]
    normal = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
    middle = [sum(x) / 3 - 0.5 for x in zip(a, b, c)]
    is_outwards = sum(n * m for n, m in zip(normal, middle)) > 0
    return triangle if is_outwards else (triangle[1], triangle[0], *triangle[2:])


class UnitsTest(ProgramTest):
    """Every command on one mesh in mm and in cm: the results are the same but for the factor 10."""

    def setUp(self):
        super().setUp()
        medit = self.folder / "cube.mesh"
        points, tetrahedra, triangles = cube(4)
        write_medit(medit, points, tetrahedra, [outwards(points, triangle) for triangle in triangles])
        self.mm, self.cm = self.folder / "mm.vtu", self.folder / "cm.vtu"
        self.run_well("rename", medit, "-o", self.mm, "--name", "patch_1=low:inlet", "--name", "patch_2=high:outlet")
        self.run_well("convert", self.mm, self.cm, "--out-unit", "cm")

    def points(self, mesh):
        """Coordinates in the file's own unit."""
        text = self.folder / "points.mesh"
        self.run_well("convert", mesh, text)
        words = text.read_text().split()
        at = words.index("Vertices")
        count = int(words[at + 1])
        return [[float(word) for word in words[at + 2 + 4 * i:at + 5 + 4 * i]] for i in range(count)]

    def info(self, mesh):
        return json.loads(self.run_well("info", mesh, "--json").stdout)

    def assert_same_but_for_unit(self, mm, cm):
        of_mm, of_cm = self.info(mm), self.info(cm)
        self.assertEqual((of_mm["unit"], of_cm["unit"]), ("mm", "cm"))
        for key in ("points", "tetrahedra", "prisms", "labels", "patches"):
            self.assertEqual(of_mm[key], of_cm[key])
        for p, q in zip(self.points(mm), self.points(cm)):
            for x, y in zip(p, q): self.assertTrue(math.isclose(x, 10 * y, rel_tol=1e-9, abs_tol=1e-12), (p, q))

    def compare(self, command, *options):
        made = []
        for unit in ("mm", "cm"):
            made.append(self.folder / f"{command}_{unit}.vtu")
            self.run_well(command, self.folder / f"{unit}.vtu", *options, "-o", made[-1])
        self.assert_same_but_for_unit(*made)
        return made

    def test_layers_are_as_thick_as_asked(self):
        mm, _ = self.compare("layers", "--first-height", 0.01, "--growth", 1.2, "--count", 3)
        self.assertAlmostEqual(max(y for _, y, _ in self.points(mm)), 1 + 0.01 * (1 + 1.2 + 1.44), delta=0.002)

    def test_points_that_stay_keep_their_bits(self):
        """0.075 cm is 0.75 mm, and 0.75 mm is 0.07500000000000001 cm."""
        before = self.points(self.cm)
        self.assertTrue(any(10 * x * 0.1 != x for p in before for x in p))
        metric, layered = self.folder / "metric.vtu", self.folder / "layered.vtu"
        self.run_well("metric", self.cm, "--curvature", "--max-size", 0.3, "-o", metric)
        self.assertEqual(self.points(metric), before)
        self.run_well("layers", self.cm, "--first-height", 0.01, "--count", 2, "-o", layered)
        after = {tuple(p) for p in self.points(layered)}
        self.assertTrue(all(tuple(p) in after for p in before))

    def test_layers_within_and_the_figures_of_layers(self):
        told = []
        for unit in ("mm", "cm"):
            numbers = self.folder / f"{unit}.json"
            self.run_well("layers", self.folder / f"{unit}.vtu", "--side", "inward", "--first-height", 0.01, "--count", 2,
                          "-o", self.folder / f"in_{unit}.vtu", "--json", numbers)
            told.append(json.loads(numbers.read_text()))
        self.assertEqual(told[0]["heights"], told[1]["heights"])
        for one, other in zip(told[0]["patches"], told[1]["patches"]):
            self.assertAlmostEqual(one["area_mm2"], other["area_mm2"], places=9)
        self.assert_same_but_for_unit(self.folder / "in_mm.vtu", self.folder / "in_cm.vtu")

    def test_extensions_are_as_long_as_asked(self):
        mm, _ = self.compare("layers", "--extend", "high=2")
        self.assertAlmostEqual(max(x for x, _, _ in self.points(mm)), 3, places=6)

    def test_improved_meshes(self):
        self.compare("improve", "--cut-plane", 0.6, 0, 0, 1, 0, 0)

    def test_places_of_openings_are_in_mm(self):
        for mesh in (self.mm, self.cm):
            named = self.folder / f"named_{mesh.name}"
            self.run_well("rename", mesh, "-o", named, "--name", "1,0.5,0.5=end")
            self.assertIn("end", {patch["name"] for patch in self.info(named)["patches"]})
            self.assertEqual(self.points(named), self.points(mesh))
        self.assert_refused(self.run_lumesh("rename", self.cm, "-o", self.folder / "no.vtu", "--name", "20,1,1=end"), BAD_INPUT)

    def test_sizes_of_a_metric(self):
        complexities = []
        for unit in ("mm", "cm"):
            numbers = self.folder / f"{unit}.json"
            self.run_well("metric", self.folder / f"{unit}.vtu", "--curvature", "--max-size", 0.3, "-o",
                          self.folder / f"metric_{unit}.vtu", "--json", numbers)
            complexities.append(json.loads(numbers.read_text())["complexity"])
        self.assertAlmostEqual(complexities[1] / complexities[0], 1, places=9)
        self.assert_same_but_for_unit(self.folder / "metric_mm.vtu", self.folder / "metric_cm.vtu")

    def test_adapted_meshes(self):
        """Metrics are not the same to the last bit, so that a few operators may go another way."""
        self.test_sizes_of_a_metric()
        counts, spans = [], []
        for unit in ("mm", "cm"):
            adapted, alone = self.folder / f"adapted_{unit}.vtu", self.folder / f"{unit}.sol"
            self.run_well("metric", self.folder / f"metric_{unit}.vtu", "-o", alone)
            self.run_well("adapt", self.folder / f"{unit}.vtu", "--metric", alone, "-o", adapted)
            counts.append(self.info(adapted)["points"])
            spans.append(max(x for x, _, _ in self.points(adapted)))
        self.assertAlmostEqual(counts[1] / counts[0], 1, delta=0.03)
        self.assertAlmostEqual(spans[0], 10 * spans[1], places=9)

    def stating(self, unit, mesh="stated.mesh"):
        """The mesh in cm as a file that states another unit."""
        stated = self.folder / mesh
        self.run_well("convert", self.cm, stated)
        text = stated.read_text()
        self.assertIn('"unit":"cm"', text)
        stated.write_text(text.replace('"unit":"cm"', f'"unit":"{unit}"'))
        return stated

    def test_every_command_tells_of_a_unit_that_is_not_known(self):
        mesh, out = self.stating("foo"), self.folder / "out.vtu"
        for remedy, command, *rest in (("--unit", "info"), ("--unit", "check"), ("--unit", "convert", out), ("--unit", "centerline", "-o", self.folder / "c.vtp"),
                                       ("lumesh convert --unit", "evaluate"), ("lumesh convert --unit", "improve", "-o", out),
                                       ("lumesh convert --unit", "rename", "-o", out, "--name", "low=a"),
                                       ("lumesh convert --unit", "metric", "--curvature", "--max-size", 0.5, "-o", self.folder / "m.vtu"),
                                       ("lumesh convert --unit", "layers", "--first-height", 0.001, "--count", 1, "-o", out),
                                       ("lumesh convert --unit", "merge", self.mm, "-o", out)):
            told = self.run_lumesh(command, mesh, *rest).stderr
            self.assertEqual(told.count(f'stated.mesh: its unit is "foo", which is not known: its lengths are taken as mm; {remedy} says'), 1, f"{command}: {told}")
        told = self.run_well("adapt", self.folder / "m.vtu", "-o", out).stderr
        self.assertIn('its unit is "foo"', told)

    def test_inches_are_converted(self):
        self.assertEqual(self.info(self.stating("in"))["unit"], "in")
        mm = self.folder / "converted.vtu"
        self.assertEqual(self.run_well("convert", self.folder / "stated.mesh", mm, "--out-unit", "mm").stderr, "")
        for p, q in zip(self.points(mm), self.points(self.cm)):
            for x, y in zip(p, q): self.assertTrue(math.isclose(x, 25.4 * y, rel_tol=1e-9, abs_tol=1e-12), (p, q))

    def test_meshes_of_other_units_are_merged(self):
        one, other = self.folder / "one.mesh", self.folder / "other.mesh"
        points, tetrahedra, _ = cube(2)
        write_medit(one, points, tetrahedra, [])
        write_medit(other, [(x + 1, y, z) for x, y, z in points], tetrahedra, [])
        inches, out = self.folder / "inches.mesh", self.folder / "merged.vtu"
        self.run_well("convert", other, inches, "--out-unit", "in")
        self.assertIn('"unit":"in"', inches.read_text())
        self.run_well("merge", one, inches, "-o", out)
        self.assertEqual(self.info(out)["unit"], "mm")
        self.assertAlmostEqual(max(x for x, _, _ in self.points(out)), 2, places=9)
        inches.write_text(inches.read_text().replace('"unit":"in"', '"unit":"foo"'))
        refused = self.run_lumesh("merge", one, inches, "-o", out)
        self.assertEqual(refused.returncode, BAD_INPUT, refused.stderr)
        self.assertIn("inches.mesh: has another unit or frame than", refused.stderr.splitlines()[-1])


if __name__ == "__main__":
    unittest.main()
