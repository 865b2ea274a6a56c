#!/usr/bin/env python3
"""Tests benchmarks/compare.py: a row that became slower is found, noise is not, other machines are allowed for."""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]


class CompareTest(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        self.addCleanup(self.scratch.cleanup)
        self.folder = pathlib.Path(self.scratch.name)

    def record(self, name, factors, machine="one", spread=0.01, peak_mib=50, tetrahedra=1000):
        """A file in which the row `i` takes `factors[i]` seconds, give or take `spread` of it."""
        rows = {f"row{i}": {"command": f"do {i}", "cpu_seconds": [f * (1 + spread * k) for k in (-2, -1, 0, 1, 2)],
                            "peak_mib": peak_mib, "tetrahedra": tetrahedra} for i, f in enumerate(factors)}
        path = self.folder / f"{name}.json"
        path.write_text(json.dumps({"version": "lumesh", "machine": machine, "rows": rows}))
        return path

    def compare(self, *arguments):
        return subprocess.run([sys.executable, ROOT / "benchmarks/compare.py", *arguments], capture_output=True, text=True, check=False)

    def test_a_row_that_became_slower_is_worse(self):
        run = self.compare(self.record("before", [1, 2, 3]), self.record("after", [1, 2.2, 3]))
        self.assertEqual(run.returncode, 1, run.stdout)
        self.assertIn("3 rows, 1 worse than 3 %: row1", run.stdout)

    def test_what_noise_may_be_is_unclear_and_no_failure(self):
        run = self.compare(self.record("before", [1, 2], spread=0.1), self.record("after", [1, 2.1], spread=0.1))
        self.assertEqual(run.returncode, 0, run.stdout)
        self.assertIn("within the noise: row1", run.stdout)

    def test_two_percent_are_not_worse(self):
        run = self.compare(self.record("before", [1], spread=0.001), self.record("after", [1.02], spread=0.001))
        self.assertEqual(run.returncode, 0, run.stdout)
        self.assertNotIn("unclear", run.stdout)

    def test_a_slower_machine_is_not_worse_but_a_row_that_stands_out_is(self):
        run = self.compare(self.record("before", [1, 2, 3, 4]), self.record("after", [2, 4, 6.6, 8], machine="other"))
        self.assertEqual(run.returncode, 1, run.stdout)
        self.assertIn("4 rows, 1 worse than 3 %: row2", run.stdout)
        self.assertIn("other machine", run.stdout)

    def test_more_memory_is_worse_and_other_meshes_are_said(self):
        run = self.compare(self.record("before", [1]), self.record("after", [1], peak_mib=53, tetrahedra=1001))
        self.assertEqual(run.returncode, 1, run.stdout)
        self.assertIn("1000 -> 1001", run.stdout)

    def test_rows_of_another_command_are_left_out(self):
        after = self.record("after", [1, 9])
        after.write_text(after.read_text().replace("do 1", "do otherwise"))
        run = self.compare(self.record("before", [1, 2]), after)
        self.assertIn("1 rows, 0 worse", run.stdout)

    def test_files_without_a_common_row_are_no_success(self):
        self.assertEqual(self.compare(self.record("before", []), self.record("after", [1])).returncode, 2)

    def test_the_baselines_in_the_tree_have_the_rows_of_the_script(self):
        run = self.compare(ROOT / "benchmarks/baselines.json", ROOT / "benchmarks/baselines.json")
        self.assertEqual(run.returncode, 0, run.stdout)
        self.assertIn("17 rows, 0 worse", run.stdout)
        self.assertRegex(run.stdout, r"before: lumesh [0-9.]+, commit [0-9a-f]{12}\n")


if __name__ == "__main__":
    unittest.main()
