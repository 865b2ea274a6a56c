#!/usr/bin/env python3
"""Every phase of which the progress line knows the usual share (apps/lumesh/usual_shares.hpp) is begun by its command.

Usage: progress_test.py LUMESH
"""
import pathlib
import re
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from program import ProgramTest

SHARES = pathlib.Path(__file__).parents[2] / "apps/lumesh/usual_shares.hpp"
# What follows the phase of the row before: passes say themselves how far they are.
OF_NO_PHASE = [("adapt", "adaptation"), ("improve", "improvement"), ("run", "adaptation")]
CASE = """[input]
image = "b.nrrd"
[metric]
points = "centerline"
complexity = 4000
"""


class ProgressTest(ProgramTest):
    def phases(self, *arguments):
        """Names of those that a command tells with -v."""
        result = self.run_lumesh(*arguments, "-v", cwd=self.folder)
        self.assertEqual(result.returncode, 0, result.stderr)
        return set(re.findall(r"^lumesh: (.*) took [0-9.]+ s$", result.stderr, re.MULTILINE))

    def test_rows_of_usual_shares_are_phases_of_their_commands(self):
        runs = [("phantom", "bifurcation", "--size", 88, 64, 80, "--spacing", 0.3, "-o", "b.nrrd"), ("info", "b.nrrd"), ("check", "b.nrrd"),
                ("lattice", "b.nrrd", "-o", "l.vtu", "--surface", "s.vtp"), ("repair", "s.vtp", "-o", "r.vtp"),
                ("delaunay", "b.nrrd", "-o", "d.vtu"), ("metric", "d.vtu", "--curvature", "-o", "m.vtu"),
                ("adapt", "m.vtu", "--complexity", 4000, "-o", "a.vtu"), ("improve", "d.vtu", "-o", "i.vtu"),
                ("layers", "d.vtu", "--patch", "wall", "--first-height", 0.1, "--count", 2, "--side", "inward", "-o", "y.vtu"),
                ("convert", "y.vtu", "1.vtu", "--only-labels", 1), ("convert", "y.vtu", "2.vtu", "--only-labels", "layer"),
                ("merge", "1.vtu", "2.vtu", "-o", "g.vtu"), ("evaluate", "d.vtu", "--image", "b.nrrd", "--report", "e.html"),
                ("centerline", "b.nrrd", "-o", "c.vtp"), ("rename", "d.vtu", "--name", "inlet_1=in", "-o", "n.vtu"), ("run", "case.toml")]
        (self.folder / "case.toml").write_text(CASE)
        begun = {}
        for arguments in runs: begun.setdefault(arguments[0], set()).update(self.phases(*arguments))
        rows = re.findall(r'^ *\{"([^"]+)", "([^"]+)", [0-9.]+\},$', SHARES.read_text(), re.MULTILINE)
        self.assertGreater(len(rows), 100)
        not_begun = [row for row in rows if row[1] not in begun.get(row[0], ())]
        self.assertEqual(not_begun, OF_NO_PHASE)


if __name__ == "__main__":
    unittest.main()
