#!/usr/bin/env python3
"""`lumesh merge` and `lumesh convert --only-labels`: meshes taken apart and put together, and what is refused.

Usage: merge_test.py LUMESH      Exit codes of lumesh: 1 usage, 2 bad input.
"""
import json
import pathlib
import re
import struct
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import nrrd
from cube import cube, read_medit, write_medit
from program import BAD_INPUT, USAGE, MeshTest


def single(x):
    """As a file in single precision has it."""
    return struct.unpack("f", struct.pack("f", x))[0]


def shifted(mesh, x):
    points, tetrahedra, triangles = mesh
    return [(p[0] + x, *p[1:]) for p in points], tetrahedra, triangles


class MergeTest(MeshTest):
    def part(self, mesh, label, name):
        path = self.folder / name
        self.run_well("convert", mesh, path, "--only-labels", label)
        return path

    def summary(self, mesh):
        """What does not depend on the order of files."""
        found = self.evaluate(mesh)
        self.assertTrue(found["valid"])
        volumes = {label["label"]: round(label["volume_mm3"], 6) for label in found["labels"]}
        areas = {p["name"]: round(p["area_mm2"], 6) for p in found["boundary"]["patches"]}
        return volumes, areas, [found[key] for key in ("tetrahedra", "prisms", "pyramids", "vertices", "components")]

    def test_layers_taken_off_and_put_back_are_the_same_mesh(self):
        for options, label in ((("--cells", "prisms"), "vessel_wall"), (("--side", "inward"), "layer")):
            with self.subTest(label):
                whole = self.layered(*options)
                layers, rest = self.part(whole, label, "layers.vtu"), self.part(whole, 1, "rest.vtu")
                for files in ((rest, layers), (layers, rest)):
                    numbers = self.folder / "merge.json"
                    self.run_well("merge", *files, "-o", self.out, "--json", numbers)
                    self.assertEqual(self.summary(self.out), self.summary(whole))
                    told = json.loads(numbers.read_text())
                    self.assertEqual(told["farthest"], 0)
                    interface = {"vessel_wall": "wall", "layer": "layer_inner"}[label]
                    self.assertAlmostEqual(told["shared_area"], self.summary(whole)[1][interface], places=5)

    def test_a_file_in_single_precision_joins_one_in_double(self):
        whole = self.layered()
        layers, rest = self.part(whole, "vessel_wall", "layers.mesh"), self.part(whole, 1, "rest.mesh")
        points, tetrahedra, triangles = read_medit(layers)
        write_medit(layers, [tuple(map(single, p)) for p in points], tetrahedra, triangles)
        numbers = self.folder / "merge.json"
        self.run_well("merge", rest, layers, "-o", self.out, "--json", numbers)
        self.assertGreater(json.loads(numbers.read_text())["farthest"], 0)
        found, before = self.summary(self.out), self.summary(whole)
        self.assertEqual(found[2], before[2])
        self.assertAlmostEqual(found[0][2] / before[0][2], 1, places=5)
        self.out.unlink()
        self.assert_refused(self.run_lumesh("merge", rest, layers, "-o", self.out, "--tolerance", 0), BAD_INPUT,
                            "differ from its own", "farther apart than 0)")

    def test_labels_of_one_number_are_one_material_or_not(self):
        lower, upper = self.folder / "lower.mesh", self.folder / "upper.mesh"
        write_medit(lower, *cube(3))
        write_medit(upper, *shifted(cube(3), 1))
        result = self.run_well("merge", lower, upper, "-o", self.out)
        self.assertIn("18 faces (1 mm2) and 16 points shared", result.stdout)
        found = self.summary(self.out)
        self.assertEqual(found[0], {1: 2})
        self.assertEqual(found[2][3], 7 * 4 * 4)
        result = self.run_well("merge", lower, upper, "-o", self.out, "--equal-labels", "apart")
        self.assertIn("upper.mesh: label 1 is label 2 now", result.stdout)
        self.assertEqual(self.summary(self.out)[0], {1: 1, 2: 1})

    def test_labels_end_where_the_names_of_files_begin(self):
        one, copy = self.folder / "one.mesh", self.folder / "copy.mesh"
        write_medit(one, *cube(2))
        self.run_well("convert", "--only-labels", 1, one, copy)
        self.assertEqual(self.summary(copy), self.summary(one))
        image = nrrd.write(self.folder / "two.nrrd", [16] * 3, [max(a, 2 * b) for a, b in zip(nrrd.ball(16, 6), nrrd.ball(16, 3))])
        self.run_well("info", "--labels", 1, image)
        self.assert_refused(self.run_lumesh("convert", "--only-labels", "1,7", one, copy), BAD_INPUT, "label 7")
        self.run_well("lattice", "--labels", "1,2", image, "-o", copy)
        self.assertIn('"options":"--labels 1,2"', copy.read_text())  # As it can be given again.

    def test_patches_that_are_found_from_the_cells_are_told(self):
        one, several, out = self.folder / "one.mesh", self.folder / "several.mesh", self.out
        points, tetrahedra, _ = cube(4)
        write_medit(one, points, tetrahedra, [])
        write_medit(several, points, [(*t[:4], 2 if max(t[:4]) > len(points) // 2 + 13 else 1) for t in tetrahedra], [])
        line = "several.mesh: has no faces: its boundary, and interfaces of labels, are found from the cells and called (.*); ends"
        for command, *rest in (("convert", out), ("improve", "-o", out), ("layers", "--first-height", 0.001, "--count", 1, "-o", out),
                               ("metric", "--curvature", "--max-size", 0.5, "-o", out), ("rename", "--name", "wall_1=a", "-o", out)):
            called, = re.findall(line, self.run_well(command, several, *rest).stderr)
            self.assertEqual(set(called.split(", ")), {"wall_1", "wall_2", "interface_1_2"}, command)
            names = {patch["name"] for patch in json.loads(self.run_well("info", out, "--json").stdout)["patches"]}
            self.assertLessEqual({"wall_2", "interface_1_2"}, names)
        self.assertNotIn("found from", self.run_well("convert", one, out).stderr)

    def test_every_number_of_threads_gives_the_same_file(self):
        lower, upper, files = self.folder / "lower.mesh", self.folder / "upper.mesh", []
        write_medit(lower, *cube(6))
        write_medit(upper, *shifted(cube(6), 1))
        for threads in (1, 2, 7):
            self.run_well("merge", lower, upper, "-o", self.out, "--threads", threads)
            files.append(self.out.read_bytes())
        self.assertEqual(len(set(files)), 1)

    def test_what_does_not_fit_is_refused(self):
        one, far, finer, same = (self.folder / f"{name}.mesh" for name in ("one", "far", "finer", "same"))
        write_medit(one, *cube(2))
        write_medit(far, *shifted(cube(2), 4))
        write_medit(finer, *shifted(cube(3), 1))
        write_medit(same, *cube(2))
        refused = [
            ([one, far], BAD_INPUT, "shares no face", "come within 3 "),
            ([one, finer], BAD_INPUT, "differ from its own"),
            ([one, same], BAD_INPUT, "overlap"),
            ([one], USAGE, "two or more"),
            ([one, one], USAGE, "named twice"),
            ([one, self.folder / "none.mesh"], BAD_INPUT, "none.mesh"),
            ([one, far, "--tolerance", -1], USAGE, "tolerance"),
            ([one, far, "--tolerance", 1], BAD_INPUT, "shortest edge"),
        ]
        for arguments, code, *words in refused:
            with self.subTest(arguments):
                self.assert_refused(self.run_lumesh("merge", *arguments, "-o", self.out), code, *words)
        self.assert_refused(self.run_lumesh("convert", one, self.out, "--only-labels", "door"), BAD_INPUT, "door",
                            "labels present: 1")


if __name__ == "__main__":
    unittest.main()
