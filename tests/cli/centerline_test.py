#!/usr/bin/env python3
"""The command centerline: what it writes, what it says, what it refuses.

Usage: centerline_test.py LUMESH      Exit codes of lumesh: 1 usage, 2 bad input.
"""
import base64
import hashlib
import json
import math
import pathlib
import re
import sys
import unittest
import zlib

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import nrrd
from program import BAD_INPUT, USAGE, ProgramTest

SIZES = [20, 20, 30]


def tube(label=1):
    """A straight vessel along z, radius 4 voxels, i fastest."""
    return [label if (i - 9) ** 2 + (j - 9) ** 2 < 16.5 else 0
            for _ in range(SIZES[2]) for j in range(SIZES[1]) for i in range(SIZES[0])]


def write_closed_tube(path, radius, length, slope, around=32, rows=40):
    """A closed tube along z, whose far end is cut off obliquely."""
    def corner(row, i):
        x, y = (radius * f(2 * math.pi * (i % around) / around) for f in (math.cos, math.sin))
        return x, y, row / rows * (length + slope * x)

    faces, ends = [], ((0.0, 0.0, 0.0), (0.0, 0.0, length))
    for i in range(around):
        faces += [(corner(0, i + 1), corner(0, i), ends[0]), (corner(rows, i), corner(rows, i + 1), ends[1])]
        for row in range(rows):
            faces += [(corner(row, i), corner(row, i + 1), corner(row + 1, i)),
                      (corner(row, i + 1), corner(row + 1, i + 1), corner(row + 1, i))]
    lines = [line for face in faces for line in ("facet normal 0 0 0", "outer loop", *("vertex %.9g %.9g %.9g" % p for p in face), "endloop", "endfacet")]
    path.write_text("\n".join(["solid tube", *lines, "endsolid", ""]))


class CenterlineTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.image = nrrd.write(self.folder / "tube.nrrd", SIZES, tube())
        self.out = self.folder / "lines.vtp"

    def test_says_in_one_line_what_it_found(self):
        result = self.run_well("centerline", self.image, "-o", self.out)
        found = re.fullmatch(r".*lines\.vtp: 1 lines, \d+ points, length (\S+) mm, radius (\S+) to (\S+) mm, \S+ s\n",
                             result.stdout)
        self.assertTrue(found, result.stdout)
        self.assertAlmostEqual(float(found[1]), 30, delta=0.2)
        self.assertAlmostEqual(float(found[2]), 4, delta=0.3)
        self.assertAlmostEqual(float(found[3]), 4, delta=0.3)

    def test_the_file_says_what_it_was_made_from(self):
        self.run_well("centerline", self.image, "-o", self.out, "--spacing", "2", "-q")
        text = self.out.read_text()
        for name in ("radius", "branch"):
            self.assertIn(f'Name="{name}"', text)
        block = re.search(r'Name="lumesh_info".*\n(.*)\n', text)[1]
        header_length = 44  # Of four numbers of eight bytes in base64, before the compressed text.
        provenance = json.loads(zlib.decompress(base64.b64decode(block[header_length:])))["provenance"]
        self.assertEqual(provenance["command"], "centerline")
        self.assertIn("--spacing 2", provenance["options"])
        self.assertTrue(provenance["input"].endswith("tube.nrrd"))
        self.assertEqual(provenance["input_sha256"], hashlib.sha256(self.image.read_bytes()).hexdigest())

    def test_nothing_of_a_mesh_in_one_piece_is_left_out_at_its_openings(self):
        image, mesh = self.folder / "carotid.nrrd", self.folder / "carotid.vtu"
        self.run_well("phantom", "carotid", "--size", "128", "128", "127", "--spacing", "4", "-o", image, "-q")
        self.run_well("delaunay", image, "-o", mesh, "-q")
        self.assertEqual(self.run_well("centerline", mesh, "-o", self.out).stderr, "")

    def test_flat_ends_of_closed_surfaces_are_openings(self):
        # Axes ended beside oblique ends, with radii of the way to them.
        surface = self.folder / "tube.stl"
        for slope in (0, 0.6, 1):
            with self.subTest(slope=slope):
                write_closed_tube(surface, 2, 20, slope)
                told = self.run_well("centerline", surface, "-o", self.out).stdout
                lines, low, high = re.search(r"(\d+) lines,.* radius ([\d.]+) to ([\d.]+) mm", told).groups()
                self.assertEqual(lines, "1")
                self.assertGreater(float(low), 0.95 * 2)
                self.assertLess(float(high), 1.05 * 2)

    def test_quiet_says_nothing(self):
        self.assertEqual(self.run_well("centerline", self.image, "-o", self.out, "-q").stdout, "")

    def test_the_number_of_threads_does_not_change_the_lines(self):
        contents = []
        for threads in ("1", "2"):
            self.run_well("centerline", self.image, "-o", self.out, "-q", "--threads", threads)
            contents.append(self.out.read_bytes())
        self.assertEqual(contents[0], contents[1])

    def test_a_label_is_chosen(self):
        voxels = tube(3)
        voxels[0] = 1
        image = nrrd.write(self.folder / "labels.nrrd", SIZES, voxels)
        self.run_well("centerline", image, "-o", self.out, "--labels", "3")
        self.assert_refused(self.run_lumesh("centerline", image, "-o", self.out, "--labels", "2"), BAD_INPUT, "2")

    def test_labels_that_count_together_are_told_and_chosen_of_meshes_too(self):
        around = [2 if 16.5 <= (i - 9) ** 2 + (j - 9) ** 2 < 50 else 0 for _ in range(SIZES[2]) for j in range(SIZES[1]) for i in range(SIZES[0])]
        image = nrrd.write(self.folder / "walled.nrrd", SIZES, [a or b for a, b in zip(tube(), around)])
        mesh, numbers = self.folder / "walled.vtu", self.folder / "numbers.json"
        self.run_well("delaunay", image, "-o", mesh, "--edge-length", 2, "-q")
        for given in (image, mesh):
            told = self.run_well("centerline", given, "-o", self.out)
            self.assertIn("labels 1, 2 count together as one vessel", told.stdout)
            self.assertGreater(float(re.search(r"radius \S+ to (\S+) mm", told.stdout)[1]), 6)
            told = self.run_well("centerline", given, "-o", self.out, "--labels", 1, "--json", numbers)
            self.assertNotIn("count together", told.stdout)
            self.assertAlmostEqual(float(re.search(r"radius \S+ to (\S+) mm", told.stdout)[1]), 4, delta=0.4)
            self.assertEqual(json.loads(numbers.read_text())["labels"], [1])
        self.assert_refused(self.run_lumesh("centerline", mesh, "-o", self.out, "--labels", 7), BAD_INPUT, "walled.vtu", "7")

    def test_a_mesh_has_the_lines_of_its_image(self):
        mesh = self.folder / "tube.vtu"
        self.run_well("lattice", self.image, "-o", mesh, "-q")
        result = self.run_well("centerline", mesh, "-o", self.out)
        found = re.search(r": 1 lines, .* length (\S+) mm, radius (\S+) to", result.stdout)
        self.assertTrue(found, result.stdout)
        self.assertAlmostEqual(float(found[1]), 30, delta=0.5)
        self.assertAlmostEqual(float(found[2]), 4, delta=0.4)

    def test_bad_input_is_refused_in_one_line(self):
        empty = nrrd.write(self.folder / "empty.nrrd", SIZES, [0] * len(tube()))
        ball = nrrd.write(self.folder / "ball.nrrd", [20] * 3, nrrd.ball(20, 7))
        for path, word in ((empty, "no voxel"), (ball, "longer than wide"), (self.folder / "none.nrrd", "none.nrrd"),
                           (self.folder / "none.stl", "none.stl")):
            with self.subTest(path.name):
                self.assert_refused(self.run_lumesh("centerline", path, "-o", self.out), BAD_INPUT, path.name, word)
                self.assertFalse(self.out.exists())

    def test_bad_usage_is_refused_before_work(self):
        stl = self.folder / "tube.stl"
        for arguments, word in (((self.image, "-o", self.folder / "lines.vtu"), ".vtp"),
                                ((self.image, "-o", self.out, "--spacing", "0"), "--spacing"),
                                ((self.image, "-o", self.out, "--shortest-tip", "0.1"), "--shortest-tip"),
                                ((self.image, "-o", self.out, "--voxel", "1"), "--voxel"),
                                ((self.image, "-o", self.out, "--keep-open"), "--keep-open"),
                                ((stl, "-o", self.out, "--labels", "1"), "--labels"),
                                ((stl, "-o", self.out, "--threshold", "1"), "--threshold"),
                                ((self.image,), "--output")):
            with self.subTest(word):
                self.assert_refused(self.run_lumesh("centerline", *arguments), USAGE, word)

    def test_an_output_in_no_folder_or_over_its_input_is_refused(self):
        self.assert_refused(self.run_lumesh("centerline", self.image, "-o", self.folder / "none" / "l.vtp"), BAD_INPUT,
                            "folder")
        surface = self.folder / "tube.vtp"
        self.run_well("lattice", self.image, "-o", self.folder / "tube.vtu", "--surface", surface, "-q")
        self.assert_refused(self.run_lumesh("centerline", surface, "-o", surface), USAGE, "tube.vtp", "replaced")


if __name__ == "__main__":
    unittest.main()
