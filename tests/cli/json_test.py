#!/usr/bin/env python3
"""--json of every command that makes or changes something: one meaning, and the figures that the terminal has.

Usage: json_test.py LUMESH
"""
import json
import re
import unittest

from program import USAGE, ProgramTest

MAKERS = ("phantom", "repair", "lattice", "delaunay", "metric", "adapt", "improve", "layers", "merge", "centerline", "convert", "rename", "run")


class JsonTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.image, self.mesh, self.axes = (self.folder / name for name in ("b.nrrd", "b.vtu", "b.vtp"))
        self.numbers = self.folder / "numbers.json"
        self.give(("phantom", "bifurcation", "--size", 88, 64, 80, "--spacing", 0.3, "-o", "b.nrrd", "--centerline", "b.vtp"),
                  ("lattice", "b.nrrd", "-o", "b.vtu"))

    def told(self, *command):
        """The JSON of a command, which says the same on the terminal as without; and what it says there."""
        result = self.run_well(*command, "--json", self.numbers)
        told = json.loads(self.numbers.read_text())
        for file in told["files"]:
            self.assertTrue((self.folder / file["path"]).exists(), file)
            self.assertTrue(file["what"])
        warned = [line for line in result.stderr.splitlines() if line.startswith("lumesh: warning: ")]
        self.assertEqual([f"lumesh: warning: {warning}" for warning in told["warnings"]], warned)
        if "seconds_by_step" in told:
            self.assertLess(0, sum(told["seconds_by_step"].values()))
            self.assertLess(0, told["seconds"])
        return told, result.stdout

    def paths(self, told):
        return [file["path"] for file in told["files"]]

    def test_every_command_that_makes_something_has_it(self):
        for command in MAKERS:
            self.assertIn("--json [FILE]", self.run_well(command, "--help").stdout, command)

    def test_without_a_file_it_is_all_of_the_standard_output(self):
        out = self.folder / "out.vtu"
        for command in (("phantom", "sphere", "-o", self.folder / "s.nrrd"), ("lattice", self.image, "-o", out),
                        ("metric", self.mesh, "--points", self.axes, "-o", out), ("centerline", self.image, "-o", self.folder / "l.vtp"),
                        ("convert", self.mesh, out), ("rename", self.mesh, "-o", out, "--name", "wall=skin")):
            with self.subTest(command[0]):
                self.assertEqual(json.loads(self.run_well(*command, "--json").stdout)["warnings"], [])

    def test_it_replaces_no_input(self):
        out = self.folder / "out.vtu"
        for command, read in ((("lattice", self.image, "-o", out), self.image), (("convert", self.mesh, out), self.mesh),
                              (("rename", self.mesh, "-o", out, "--name", "wall=skin"), self.mesh),
                              (("metric", self.mesh, "--points", self.axes, "-o", out), self.mesh),
                              (("centerline", self.image, "-o", self.folder / "l.vtp"), self.image)):
            with self.subTest(command[0]):
                self.assert_refused(self.run_lumesh(*command, "--json", read), USAGE, read.name)

    def test_lattice(self):
        told, said = self.told("lattice", self.image, "-o", self.folder / "out.vtu", "--surface", self.folder / "out.vtp")
        counts = re.search(r"(\d+) tetrahedra, (\d+) vertices, (\d+) boundary triangles", said)
        self.assertEqual([told[key] for key in ("tetrahedra", "vertices", "boundary_triangles")], [int(n) for n in counts.groups()])
        self.assertEqual(told["hexahedra"], 0)
        self.assertEqual(self.paths(told), [str(self.folder / "out.vtu"), str(self.folder / "out.vtp")])
        faces = {name: int(count) for name, count in re.findall(r"patch (\S+) +(\d+) triangles", said)}
        self.assertEqual({patch["name"]: patch["faces"] for patch in told["patches"]}, faces)
        self.assertEqual(sum(faces.values()), told["boundary_triangles"])
        self.assertEqual({patch["name"]: patch["kind"] for patch in told["patches"]}["inlet_1"], "opening")
        self.assertEqual({opening["patches"] for opening in told["openings"]}, {"inlet_1", "outlet_1", "outlet_2"})
        self.assertEqual(told["differences_from_image"], [])

    def test_lattice_of_several_labels_and_cells(self):
        layered = self.folder / "layered.nrrd"
        self.run_well("phantom", "layered", "--size", 48, 48, 48, "--spacing", 2, "-o", layered)
        told, said = self.told("lattice", layered, "-o", self.folder / "out.vtu", "--mixed")
        self.assertEqual([told["hexahedra"], told["pyramids"]],
                         [int(n) for n in re.search(r"(\d+) hexahedra, (\d+) pyramids", said).groups()])
        self.assertGreater(told["hexahedra"], 0)

    def test_metric(self):
        told, said = self.told("metric", self.mesh, "--points", self.axes, "--complexity", 1e9, "--min-size", 1, "-o", self.folder / "out.sol")
        self.assertEqual(told["vertices"], int(re.search(r"metric of (\d+) vertices", said)[1]))
        self.assertEqual(f"{told['complexity']:.4g}", re.search(r"complexity (\S+) on", said)[1])
        self.assertEqual(len(told["warnings"]), 1)
        self.assertIn("complexity", told["warnings"][0])

    def test_centerline(self):
        told, said = self.told("centerline", self.image, "-o", self.folder / "out.vtp")
        counts = re.search(r"(\d+) lines, (\d+) points, length (\S+) mm, radius (\S+) to (\S+) mm", said)
        self.assertEqual([told["lines"], told["points"]], [int(counts[1]), int(counts[2])])
        radii = told["radius_mm"]
        self.assertEqual([f"{told['length_mm']:.5g}", f"{radii['min']:.3g}", f"{radii['max']:.3g}"], list(counts.groups()[2:]))

    def test_convert(self):
        told, said = self.told("convert", self.mesh, self.folder / "out.msh")
        counts = re.search(r"(\d+) cells, (\d+) points, (\d+) boundary faces, (\d+) patches", said)
        self.assertEqual([told["cells"], told["points"], told["boundary_faces"], len(told["patches"])], [int(n) for n in counts.groups()])
        self.assertEqual(sum(patch["faces"] for patch in told["patches"]), told["boundary_faces"])

    def test_rename(self):
        told, _ = self.told("rename", self.mesh, "-o", self.folder / "out.vtu", "--name", "wall=skin", "--name", "inlet_1=aorta:inlet")
        self.assertEqual(told["renamed"], [{"from": "wall", "to": "skin"}, {"from": "inlet_1", "to": "aorta", "kind": "inlet"}])
        self.assertEqual({patch["name"] for patch in told["patches"]}, {"skin", "aorta", "outlet_1", "outlet_2"})

    def test_phantom(self):
        told, said = self.told("phantom", "torus", "--size", 48, 48, 24, "-o", self.folder / "t.nrrd", "--seed", 3)
        self.assertEqual((told["kind"], told["size_voxels"], told["spacing_mm"]), ("torus", [48, 48, 24], [1, 1, 1]))
        (ring,) = told["labels"]
        figures = re.search(r"label 1: (\d+) voxels, (\S+) mm3 \(truth (\S+)\), components (\d+), Euler number (\S+)", said)
        self.assertEqual([str(ring["voxels"]), f"{ring['volume_mm3']:.6g}", f"{ring['reference']['volume_mm3']:.6g}",
                          str(ring["components"]), str(ring["euler"])], list(figures.groups()))
        self.assertEqual(ring["reference"]["euler"], 0)
        self.assertEqual(self.paths(told), [str(self.folder / "t.nrrd"), str(self.folder / "t.phantom.json")])

    def test_run(self):
        case = self.folder / "ball.toml"
        case.write_text(f'[input]\nphantom = "sphere"\nphantom_size = 24\n[output]\nfolder = "{self.folder / "ball"}"\nreport = ""\n')
        self.run_well("run", case, "--json", self.numbers)
        self.assertEqual(json.loads(self.numbers.read_text()), json.loads((self.folder / "ball" / "report.json").read_text()))
        self.assert_refused(self.run_lumesh("run", case, "--json", case), USAGE, "ball.toml")


if __name__ == "__main__":
    unittest.main()
