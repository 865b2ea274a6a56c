#!/usr/bin/env python3
"""`lumesh run` that is stopped: what it leaves, and that it leaves the files of another run alone.

Usage: run_stops_test.py LUMESH      Exit code of lumesh: 4 time limit.
"""
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from case_runs import NO_PAGE, CaseTest
from program import TIME_LIMIT


class StopsTest(CaseTest):
    def test_a_time_limit_leaves_a_mesh_and_says_so(self):
        result = self.run_lumesh("run", self.case, "-o", self.out, "--set", "metric.complexity=2000000", "--time-limit", "7")
        self.assertEqual(result.returncode, TIME_LIMIT, result.stderr)
        self.assertIn("time limit", result.stderr)
        self.assertIn("report.html, without measures and pictures of the rest", result.stdout)
        self.assertFalse(self.numbers()["complete"])
        self.run_well("evaluate", self.out / "a.vtu")

    def test_a_run_that_is_stopped_leaves_the_files_of_another_one(self):
        stages = "output.stages=true"
        self.run_case("--set", stages)
        files = {path: path.read_bytes() for path in self.out.iterdir() if path.is_file()}
        self.assertTrue({"first.vtu", "centerline.vtp"} <= {path.name for path in files})
        result = self.run_lumesh("run", self.case, "-o", self.out, "--set", stages, "--set", "centerline.spacing=1.7", "--set",
                                 "metric.complexity=2000000", "--time-limit", "7")
        self.assertEqual(result.returncode, TIME_LIMIT, result.stderr)
        for path, content in files.items():
            self.assertTrue(path.read_bytes() == content, path.name)
        self.run_well("evaluate", self.out / "partial" / "a.vtu")
        # One that ends replaces them.
        self.run_case("--set", stages, "--set", "centerline.spacing=1.7", *NO_PAGE)
        for name in ("first.vtu", "centerline.vtp", "a.vtu"):
            self.assertFalse((self.out / name).read_bytes() == files[self.out / name], name)
        self.assertFalse((self.out / "partial" / "first.vtu").exists())


if __name__ == "__main__":
    unittest.main()
