#!/usr/bin/env python3
"""Command line, case files and `lumesh options` have the same options with the same defaults.

Usage: option_list_test.py LUMESH
"""
import json
import pathlib
import re
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from program import ProgramTest


class OptionListTest(ProgramTest):
    def test_help_has_every_option_of_its_stage(self):
        sections = json.loads(self.run_well("options", "--json").stdout)
        for command in ("lattice", "delaunay", "adapt", "layers", "metric", "centerline", "improve", "phantom"):
            words = " ".join(self.run_well(command, "--help").stdout.split())
            for option in sections[command]:
                if command == "centerline" and option["name"] == "make":  # A case makes it where it is needed.
                    continue
                with self.subTest(command=command, option=option["name"]):
                    self.assertIn(option["flags"], words)
                    self.assertIn(option["meaning"], words)
                    if option["default"] not in ("none", "off", "on"):
                        self.assertIn("=" + option["default"], words)

    def test_help_lists_the_formats_of_every_use(self):
        """Those of points and of data on them, too, and every format that is listed is taken."""
        formats = json.loads(self.run_well("options", "--json").stdout)["formats"]
        named = lambda use: ", ".join(name for name in formats[use] if name != ".vtk.gz" and name != ".stl.gz")
        for command, uses in (("metric", ("points", "point data", "metric alone", "carry metric")), ("delaunay", ("points", "read image")),
                              ("phantom", ("write image", "lines")), ("repair", ("read", "write surface")), ("centerline", ("lines",))):
            words = " ".join(self.run_well(command, "--help").stdout.split())
            for use in uses:
                with self.subTest(command=command, use=use):
                    self.assertIn(f"({named(use)})", words)
        self.assertEqual([name for name in (".csv", ".txt", ".xyz", ".pts", ".dat") if name not in formats["points"]], [])

    def test_a_case_has_every_size_of_the_command_delaunay(self):
        flags = set(re.findall(r"--([a-z-]*siz[a-z-]*)", self.run_well("delaunay", "--help").stdout))
        keys = [option["name"] for option in json.loads(self.run_well("options", "--json").stdout)["delaunay"]]
        self.assertEqual(flags, {key.replace("_", "-") for key in keys if "siz" in key})
        self.assertLessEqual({"size", "label-size", "size-points", "size-k", "size-boundary", "size-image", "size-mesh", "sizing"}, flags)

    def test_a_case_has_every_option_with_its_default(self):
        sections = json.loads(self.run_well("options", "--json").stdout)
        case = self.folder / "case.toml"
        case.write_text('[input]\nphantom = "sphere"\nphantom_size = [24, 24, 24]\n[output]\nreport = ""\n')
        self.run_well("run", case, "-o", self.folder / "out")
        text, section = {}, "case"
        for line in (self.folder / "out" / "effective.toml").read_text().splitlines():
            if line.startswith("["):
                section = line[1:line.index("]")]
            elif " =" in line:
                key, _, value = line.removeprefix("# ").partition(" =")
                text[section, key] = value.split(" # ")[0].strip().strip("'")
        for name, options in sections.items():
            for option in options if name not in ("improve", "repair", "phantom", "convert", "merge", "formats") else []:
                with self.subTest(section=name, option=option["name"]):
                    value = text[name, option["name"]]
                    if "words" in option:
                        self.assertEqual(value, option["default"])
                    elif option["default"].replace(".", "").isdigit():
                        self.assertAlmostEqual(float(value), float(option["default"]), places=4)


if __name__ == "__main__":
    unittest.main(verbosity=2)
