#!/usr/bin/env python3
"""`lumesh improve`: what it makes of a cube with bad angles, and what it refuses.

Usage: improve_test.py LUMESH      Exit codes of lumesh: 1 usage, 2 bad input, 3 an invalid mesh.
"""
import json
import pathlib
import random
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from cube import cube, write_medit, write_sol
from program import BAD_INPUT, NOT_REACHED, USAGE, MeshTest


def surface_of(path):
    """The triangles of a Medit text file by the places of their corners."""
    words = path.read_text(encoding="ascii").split()

    def rows(keyword, width):
        start = words.index(keyword) + 2
        return [words[i:i + width] for i in range(start, start + width * int(words[start - 1]), width)]

    points = [tuple(map(float, row[:3])) for row in rows("Vertices", 4)]
    return {frozenset(points[int(v) - 1] for v in row[:3]) for row in rows("Triangles", 4)}


def volume(points, tetrahedron):
    a, b, c, d = (points[v - 1] for v in tetrahedron[:4])
    u, v, w = ([q[k] - a[k] for k in range(3)] for q in (b, c, d))
    return (u[0] * (v[1] * w[2] - v[2] * w[1]) + u[1] * (v[2] * w[0] - v[0] * w[2]) + u[2] * (v[0] * w[1] - v[1] * w[0])) / 6


def rough_cube(n):
    """The unit cube with its inner vertices moved at random, as far as all tetrahedra stay positive."""
    points, tetrahedra, triangles = cube(n)
    chance = random.Random(1)
    around = {v: [t for t in tetrahedra if v in t[:4]] for v in range(1, len(points) + 1)}
    for v, tets in around.items():
        old = points[v - 1]
        if min(old) == 0 or max(old) == 1:
            continue
        points[v - 1] = tuple(x + chance.uniform(-0.6, 0.6) / n for x in old)
        if min(volume(points, t) for t in tets) < 1e-3 / n ** 3:
            points[v - 1] = old
    return points, tetrahedra, triangles


class ImproveTest(MeshTest):
    def setUp(self):
        super().setUp()
        self.rough = self.folder / "rough.mesh"
        write_medit(self.rough, *rough_cube(5))

    def test_bad_angles_become_good_ones(self):
        before = self.evaluate(self.rough)
        self.assertLess(before["dihedral_deg"]["min"], 10)
        report = self.folder / "improve.json"
        result = self.run_well("improve", self.rough, "-o", self.out, "--json", report)
        self.assertEqual(len(result.stdout.splitlines()), 1)
        after = self.evaluate(self.out)
        self.assertTrue(after["valid"])
        self.assertGreaterEqual(after["dihedral_deg"]["min"], 22)
        self.assertLessEqual(after["dihedral_deg"]["max"], 145)
        self.assertAlmostEqual(after["labels"][0]["volume_mm3"], 1, places=9)
        written = json.loads(report.read_text())
        self.assertAlmostEqual(written["before"]["min"], before["dihedral_deg"]["min"], places=4)
        self.assertAlmostEqual(written["after"]["max"], after["dihedral_deg"]["max"], places=4)
        self.assertEqual(written["after"]["tetrahedra_outside"], 0)
        self.assertGreater(sum(p["operators"]["smoothing"]["applied"] for p in written["passes"]), 10)
        self.assertNotIn("metric_edge_length", after)

    def test_targets_and_passes_are_followed(self):
        self.run_well("improve", self.rough, "-o", self.out, "--min-dihedral", 5, "--max-dihedral", 170)
        few = self.evaluate(self.out)["dihedral_deg"]
        self.assertGreaterEqual(few["min"], 5)
        self.run_well("improve", self.rough, "-o", self.out, "--passes", 0)
        self.assertEqual(self.evaluate(self.out)["dihedral_deg"]["min"], self.evaluate(self.rough)["dihedral_deg"]["min"])

    def test_every_number_of_threads_gives_the_same_file(self):
        files = []
        for threads in (1, 2, 8):
            path = self.folder / f"{threads}.meshb"
            self.run_well("improve", self.rough, "-o", path, "--threads", threads)
            files.append(path.read_bytes())
        self.assertEqual(files[1:], files[:1] * 2)

    def test_a_frozen_surface_stays(self):
        path = self.folder / "frozen.mesh"
        self.run_well("improve", self.rough, "-o", path, "--boundary", "frozen", "--min-dihedral", 40)
        self.assertEqual(surface_of(path), surface_of(self.rough))

    def test_sizes_are_carried_along(self):
        count, size = 6 ** 3, 0.25
        sizes, stretched = self.folder / "sizes.sol", self.folder / "stretched.sol"
        write_sol(sizes, [[size ** -2, 0, size ** -2, 0, 0, size ** -2]] * count)
        write_sol(stretched, [[1, 0, 1, 0, 0, 9]] * count)
        self.assert_refused(self.run_lumesh("improve", self.rough, "-m", stretched, "-o", self.out), BAD_INPUT, "stretched.sol")
        with_sizes = self.folder / "with_sizes.vtu"
        self.run_well("improve", self.rough, "-m", sizes, "-o", with_sizes)
        numbers = self.evaluate(with_sizes)
        self.assertGreaterEqual(numbers["dihedral_deg"]["min"], 22)
        self.assertAlmostEqual(numbers["complexity"], size ** -3, places=6)
        # The mesh's own sizes do as well, but not stretched ones.
        self.run_well("improve", with_sizes, "-o", self.out, "--passes", 0)
        for name in ("min", "max", "mean"):
            self.assertAlmostEqual(self.evaluate(self.out)["metric_edge_length"][name], numbers["metric_edge_length"][name])
        self.run_well("improve", with_sizes, "-o", self.out, "--ignore-sizes")
        self.assertNotIn("metric_edge_length", self.evaluate(self.out))
        stretched_mesh = self.folder / "stretched.vtu"
        self.run_well("metric", self.rough, "-m", stretched, "-o", stretched_mesh)
        result = self.run_well("improve", stretched_mesh, "-o", self.out)
        self.assertIn("stretched.vtu is left out", result.stderr)
        self.assertNotIn("metric_edge_length", self.evaluate(self.out))

    def test_an_invalid_result_is_told_after_it_was_written(self):
        """Two cubes of which one reaches into the other: no step of improvement could mend that."""
        points, tetrahedra, triangles = cube(2)
        count = len(points)
        points += [(x + 0.3, y + 0.4, z + 0.45) for x, y, z in points]
        tetrahedra += [(*(v + count for v in t[:4]), t[4]) for t in tetrahedra]
        triangles += [(*(v + count for v in t[:3]), t[3]) for t in triangles]
        write_medit(self.rough, points, tetrahedra, triangles)
        result = self.run_lumesh("improve", self.rough, "-o", self.out, "--boundary", "frozen")
        self.assertEqual(result.returncode, NOT_REACHED, result.stderr)
        self.assertIn("the mesh is invalid, as the one that it was made from: the outside crosses or touches itself", result.stderr)
        self.assertTrue(self.out.exists())

    def test_what_cannot_be_improved_is_refused(self):
        improve = ("improve", self.rough, "-o", self.out)
        self.assert_refused(self.run_lumesh(*improve, "--min-dihedral", 80), USAGE, "--min-dihedral")
        self.assert_refused(self.run_lumesh(*improve, "--boundary", "liquid"), USAGE, "liquid")
        self.assert_refused(self.run_lumesh(*improve, "--passes", -1), USAGE, "passes")
        self.assert_refused(self.run_lumesh("improve", self.folder / "none.mesh", "-o", self.out), BAD_INPUT, "none.mesh")
        points, tetrahedra, triangles = cube(2)
        surface = self.folder / "surface.mesh"
        write_medit(surface, points, [], triangles)
        self.assert_refused(self.run_lumesh("improve", surface, "-o", self.out), BAD_INPUT, "surface.mesh")
        a, b, *rest = tetrahedra[3]
        inverted = self.folder / "inverted.mesh"
        write_medit(inverted, points, [*tetrahedra[:3], (b, a, *rest), *tetrahedra[4:]], triangles)
        self.assert_refused(self.run_lumesh("improve", inverted, "-o", self.out), BAD_INPUT, "inverted.mesh")


if __name__ == "__main__":
    unittest.main(verbosity=2)
