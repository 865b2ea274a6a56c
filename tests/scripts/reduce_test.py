#!/usr/bin/env python3
"""Tests scripts/reduce.py: of a large input that a command dislikes only what it dislikes is left."""
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/cli"))
import nrrd


class ReduceTest(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        self.addCleanup(self.scratch.cleanup)
        self.folder = pathlib.Path(self.scratch.name)

    def reduce(self, given, condition):
        """`condition` is Python on the bytes of the file, `data`."""
        small = self.folder / ("small" + given.suffix)
        command = [sys.executable, "-c", f"import sys; data = open(sys.argv[1], 'rb').read(); sys.exit(3 if {condition} else 0)", "INPUT"]
        run = subprocess.run([sys.executable, ROOT / "scripts/reduce.py", "--code", "3", given, small, "--", *command], capture_output=True,
                             text=True, check=False)
        return run, small

    def test_an_image_shrinks_to_the_voxels_that_matter(self):
        voxels = [1] * 20 ** 3
        voxels[5 + 20 * (7 + 20 * 9)] = 200
        voxels[6 + 20 * (7 + 20 * 9)] = 201
        given = nrrd.write(self.folder / "big.nrrd", [20] * 3, voxels, encoding="gzip")
        run, small = self.reduce(given, "b'gzip' in data or (200 in data[-8000:] and 201 in data[-8000:])")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertIn(b"sizes: 2 1 1\n", small.read_bytes())
        self.assertTrue(small.read_bytes().endswith(b"\n\n" + bytes([200, 201])))

    def test_a_surface_shrinks_to_the_triangles_that_matter(self):
        triangle = lambda number: struct.pack("<12fH", 0, 0, 0, *[float(number)] * 9, 0)
        given = self.folder / "big.stl"
        given.write_bytes(b"\0" * 80 + struct.pack("<I", 100) + b"".join(map(triangle, range(100))))
        marks = [struct.pack("<3f", *[float(number)] * 3) for number in (13, 77)]
        run, small = self.reduce(given, f"all(mark in data for mark in {marks})")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual(small.read_bytes()[80:], struct.pack("<I", 2) + triangle(13) + triangle(77))

    def test_what_does_not_go_wrong_is_said(self):
        given = nrrd.write(self.folder / "good.nrrd", [4] * 3, [1] * 64)
        run, small = self.reduce(given, "False")
        self.assertIn("does not go wrong", run.stderr)
        self.assertFalse(small.exists())


if __name__ == "__main__":
    unittest.main()
