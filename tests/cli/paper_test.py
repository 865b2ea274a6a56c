#!/usr/bin/env python3
"""The paper's page and benchmark: every option that they name exists, and every file is made before it is read.

Usage: paper_test.py LUMESH
"""
import functools
import pathlib
import re
import shlex
import sys
import unittest
import xml.etree.ElementTree

from program import LUMESH, ProgramTest  # Takes the program from the command line.

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "benchmarks"))
import curves  # noqa: E402
import paper_methods  # noqa: E402
from paper import Bench, outputs_of  # noqa: E402

COMMANDS = ("adapt", "centerline", "convert", "delaunay", "evaluate", "improve", "lattice", "layers", "merge", "metric", "phantom")
OF_SCRIPTS = {"--large", "--literal", "--rounds"}


class PaperTest(ProgramTest):
    @functools.cached_property
    def methods(self):
        return paper_methods.all_methods()

    @functools.cache
    def options_of(self, command):
        return set(re.findall(r"(?<![\w-])--?[a-z][\w-]*", self.run_well(command, "--help").stdout))

    def commands(self):
        return [shlex.split(c) for m in self.methods for c in (*m.before, *m.commands, *m.after)]

    def test_the_commands_have_options_of_the_program(self):
        for words in self.commands():
            for option in (w for w in words[1:] if re.match("--?[a-z]", w)):
                self.assertIn(option, self.options_of(words[0]), words)

    def test_files_are_made_before_they_are_read(self):
        made = set()
        for words in self.commands():
            out = {b for a, b in zip(words, words[1:]) if a in ("-o", "--surface")}
            out |= {words[words.index("--velocity") + 1]} if words[0] == "phantom" and "--velocity" in words else set()
            out |= {words[-1]} if words[0] == "convert" else set()
            read = {w for w in words[1:] if re.fullmatch(r"\w+\.[a-z]+", w)} - out
            self.assertLessEqual(read, made, words)
            made |= out
        self.assertEqual(made, {file for m in self.methods for file in outputs_of(m)})

    def test_what_a_method_reads_is_chosen_with_it(self):
        bench = Bench.__new__(Bench)
        bench.methods = self.methods
        by_key = {m.key: m for m in self.methods}
        chosen = [m.key for m in bench.needed([by_key["case2_merge"]])]
        self.assertEqual(chosen, ["case2_tetgen", "case2_aflr", "case2_cdt3d_iso", "case2_cdt3d_aniso", "case2_merge"])

    def test_the_page_names_options_of_the_program(self):
        known = set().union(*map(self.options_of, COMMANDS), OF_SCRIPTS)
        for line in (ROOT / "docs/paper.md").read_text().splitlines():
            for option in re.findall(r"(?<![\w-])--[a-z][\w-]*", line):
                self.assertIn(option, known, line)

    def test_curves_are_well_formed_and_have_all_of_the_counts(self):
        histogram = {"low": 0, "high": 180, "counts": [1] * 180}
        self.assertAlmostEqual(sum(curves.shares(histogram)[1]), 100)
        for picture in (curves.angle_figure({"a": histogram}), curves.conformity_figure({"a": histogram}, {"a": histogram}),
                        curves.angle_figure({"none": {"low": 0, "high": 180, "counts": [0] * 180}})):
            xml.etree.ElementTree.fromstring(picture)


if __name__ == "__main__":
    unittest.main()
