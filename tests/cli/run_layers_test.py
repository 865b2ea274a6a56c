#!/usr/bin/env python3
"""Boundary layers as the last stage of `lumesh run`.

Usage: run_layers_test.py LUMESH      Exit code of lumesh: 2 bad input.
"""
import json
import math
import pathlib
import re
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import nrrd
from case_runs import NO_PAGE, CaseTest
from program import BAD_INPUT

LAYERS = """
[input]
phantom = "bifurcation"
phantom_size = [88, 64, 80]
phantom_spacing = 0.3

[layers]
first_height = 0.06
count = 3
label = "thin=7"

[output]
meshes = ["a.vtu"]
"""


class LayersTest(CaseTest):
    """Boundary layers as the last stage."""

    text = LAYERS

    def test_no_end_is_foretold_while_layers_are_made(self):
        adapted = LAYERS.replace("[layers]", "[metric]\ncurvature = true\nedges_per_radius = 6\n[layers]")
        self.case.write_text(adapted + 'report = ""\n')
        lines = self.on_a_terminal("run", self.case, "-o", self.out).replace("\r", "\n").split("\n")
        self.assertTrue([line for line in lines if "lumesh: " in line], "the case is too quick for the test")
        self.assertEqual([line for line in lines if re.search("(9[89]|100) %|room", line)], [])

    def evaluate(self, mesh):
        evaluated = self.folder / "evaluated.json"
        self.run_well("evaluate", mesh, "--json", evaluated)
        return json.loads(evaluated.read_text())

    def run_on_one_thread(self):
        return self.run_case_once("--checkpoints", "--threads", "1")

    def volume_without_layers(self):
        bare = self.folder / "bare.toml"
        bare.write_text(LAYERS.split("[layers]")[0] + '[output]\nmeshes = ["bare.vtu"]\nreport = ""\n')
        self.run_well("run", bare, "-o", self.folder / "bare")
        return self.evaluate(self.folder / "bare/bare.vtu")["labels"][0]["volume_mm3"]

    def test_tetrahedra_around_the_lumen_with_coverage_in_page_and_numbers(self):
        volume = self.volume_without_layers()
        result = self.run_on_one_thread()
        self.assertEqual([line.split()[0] for line in result.stdout.splitlines()][:5],
                         ["input", "mesh", "layers", "write", "report"])
        found = self.evaluate(self.out / "a.vtu")
        self.assertTrue(found["valid"])
        labels = {label["label"]: label for label in found["labels"]}
        self.assertEqual((set(labels), labels[7]["name"]), ({1, 7}, "thin"))
        self.assertAlmostEqual(labels[1]["volume_mm3"] / volume, 1, places=9)
        stage = self.numbers()["stages"][-1]
        layers = stage["layers"]
        self.assertEqual((stage["name"], layers["layers"]), ("Boundary layers", 3))
        self.assertEqual(layers["core"]["tetrahedra"] + layers["shapes"]["tetrahedra"], found["tetrahedra"])
        self.assertEqual(stage["evaluation"]["tetrahedra"], found["tetrahedra"])
        wall = layers["patches"][0]
        self.assertEqual((wall["patch"], wall["layers"]), ("wall", 3))
        self.assertGreater(wall["layered"], 0.95)
        page = (self.out / "report.html").read_text(encoding="utf-8")
        for words in ("Layers, patch by patch", "Core and layers apart", "100 % of the thickness", "from the opposite side"):
            self.assertIn(words, page)
        self.assertEqual(len(stage["pictures"]), 5)

    def test_mixed_cells_of_the_lattice_go_to_the_layers_and_all_the_files(self):
        files = ["a.vtu", "a.vtk", "a.mesh", "a.meshb", "a.msh", "a.foam"]
        settings = ("--set", "mesher=lattice", "--set", "lattice.mixed=true", "--set", "lattice.spacing=0.35", "--set", f"output.meshes={files}", "--checkpoints", *NO_PAGE)
        result = self.run_case(*settings)
        self.assertIn("hexahedra", result.stdout)
        first, last = self.numbers()["stages"][-2:]
        found = self.evaluate(self.out / "a.vtu")
        self.assertTrue(found["valid"])
        self.assertGreater(found["hexahedra"], 50)
        self.assertEqual((first["evaluation"]["hexahedra"], first["evaluation"]["pyramids"]), (found["hexahedra"], found["pyramids"]))
        self.assertEqual(last["layers"]["core"]["tetrahedra"], first["evaluation"]["tetrahedra"])
        self.assertGreater(last["layers"]["patches"][0]["layered"], 0.95)
        for name in files[1:-1]:
            self.assertEqual(self.evaluate(self.out / name)["hexahedra"], found["hexahedra"], name)
        self.assertTrue((self.out / "constant" / "polyMesh").is_dir())
        bits = self.hash_of_mesh()
        again = self.run_case(*settings, "--resume", "--threads", "3")
        self.assertEqual(self.hash_of_mesh(), bits)
        self.assertEqual(again.stderr, result.stderr)
        stage = self.numbers()["stages"][-1]
        self.assertIn("checkpoint", stage["what"])
        self.assertEqual(stage["layers"], last["layers"])

    def test_prisms_within_the_lumen_leave_its_volume(self):
        volume = self.volume_without_layers()
        inward = ("--set", "layers.side=inward", "--set", "layers.cells=prisms", "--set", "output.meshes=['a.vtu', 'a.foam']")
        self.run_case(*inward, "--set", "layers.count=2", *NO_PAGE)
        found = self.evaluate(self.out / "a.vtu")
        self.assertTrue(found["valid"])
        self.assertGreater(found["prisms"], 1000)
        self.assertEqual({label["name"] for label in found["labels"]}, {"", "thin"})
        self.assertAlmostEqual(sum(label["volume_mm3"] for label in found["labels"]) / volume, 1, places=9)
        layers = self.numbers()["stages"][-1]["layers"]
        self.assertEqual(layers["layers"], 2)
        self.assertEqual(layers["shapes"]["prisms"], found["prisms"])
        self.assertIn("count = 2", (self.out / "effective.toml").read_text())
        self.assertTrue((self.out / "constant" / "polyMesh").is_dir())

    def test_resumed_layers_have_the_same_bits_and_the_same_report(self):
        self.run_on_one_thread()
        first, stage = self.hash_of_mesh(), self.numbers()["stages"][-1]
        page = (self.out / "report.html").read_text(encoding="utf-8")
        self.run_case("--resume", "--threads", "3")
        again = self.numbers()["stages"][-1]
        self.assertIn("checkpoint", again["what"])
        self.assertEqual(self.hash_of_mesh(), first)
        self.assertEqual((again["layers"], again["figures"]), (stage["layers"], stage["figures"]))
        pictures = [of.split('"')[0] for of in page.split("base64,")[1:]]
        self.assertGreater(len(pictures), 5)
        for picture in pictures:
            self.assertIn(picture, (self.out / "report.html").read_text(encoding="utf-8"))
        # Other layers: on the same mesh, which is taken.
        self.run_case("--resume", "--set", "layers.count=4", *NO_PAGE)
        taken = [stage["name"] for stage in self.numbers()["stages"] if "checkpoint" in stage["what"]]
        self.assertEqual(taken, ["First mesh"])
        self.assertNotEqual(self.hash_of_mesh(), first)

    def test_layers_stand_on_the_adapted_mesh(self):
        result = self.run_case("--set", "metric.points=centerline", "--set", "metric.complexity=1500", *NO_PAGE)
        self.assertEqual([line.split()[0] for line in result.stdout.splitlines()][3:6], ["metric", "adapted", "layers"])
        stages = self.numbers()["stages"]
        adapted, layered = stages[-2], stages[-1]
        self.assertEqual(adapted["evaluation"]["tetrahedra"], layered["layers"]["core"]["tetrahedra"])
        self.assertGreater(adapted["evaluation"]["metric_edge_length"]["fraction_in_band"], 0.85)

    def test_a_dry_run_foresees_the_cells_of_layers(self):
        line = next(line for line in self.run_case("--dry-run").stdout.splitlines() if "boundary layers" in line)
        self.run_on_one_thread()
        foreseen = float(line.split("of about ")[1].split()[0])
        self.assertAlmostEqual(foreseen / self.numbers()["stages"][-1]["layers"]["cells"], 1, delta=0.4)

    def test_a_dry_run_foresees_the_cells_of_layers_by_sizes(self):
        options = ("--set", "layers.first_height=0.01", "--set", "layers.growth=1.6", *NO_PAGE)
        self.case.write_text(LAYERS.replace("count = 3\n", ""))
        line = next(line for line in self.run_case("--dry-run", *options).stdout.splitlines() if "boundary layers" in line)
        self.run_case(*options)
        foreseen = float(line.split("of about ")[1].split()[0])
        self.assertLess(abs(math.log(foreseen / self.numbers()["stages"][-1]["layers"]["cells"])), math.log(1.5))

    def test_refuses_bad_layers_before_any_mesh(self):
        refused = [
            (["layers.first_height=-1"], "[layers] first_height must be greater than 0"),
            (["layers.first_height=0"], "[layers] first_height is missing"),
            (["layers.count=999"], "[layers] count must lie between 1 and 200"),
            (["layers.first_hight=1"], "did you mean \"first_height\"?"),
            (["layers.label=a=b"], "write NAME=NUMBER"),
            (["layers.side=up"], "must be one of \"outward\", \"inward\""),
            (["layers.first_height=1e6"], "more than the input is wide"),
            (["layers.patches=door"], "there will be no patch door"),
            (["layers.side=inward", "layers.into=9"], "[layers] into: there is no label 9; labels present: 1"),
            (["layers.cells=prisms", "output.meshes=a.xdmf"], "a.xdmf holds tetrahedra only"),
            (["mesher=lattice", "lattice.mixed=true", "output.meshes=a.xdmf"], "not the hexahedra of [lattice] mixed"),
            (["mesher=lattice", "lattice.mixed=true", "layers.side=inward"], "layers cannot deform with [layers] side"),
            (["mesher=lattice", "lattice.mixed=true", "metric.points=centerline"], "which [metric] and [adapt] do not change"),
        ]
        for settings, words in refused:
            with self.subTest(settings):
                arguments = [argument for setting in settings for argument in ("--set", setting)]
                result = self.run_lumesh("run", self.case, "-o", self.out, *arguments)
                self.assert_refused(result, BAD_INPUT, words)
                self.assertNotIn("mesh ", result.stdout)

    def test_a_name_of_two_labels_is_refused_as_by_the_command_layers(self):
        image, case = self.folder / "two.nrrd", self.folder / "two.toml"
        voxels = [1 + (i > 5) if 2 <= min(i, j, k) and max(i, j, k) <= 9 else 0
                  for k in range(12) for j in range(12) for i in range(12)]
        nrrd.write(image, [12, 12, 12], voxels)
        names = "".join(f"Segment{i}_LabelValue:={i + 1}\nSegment{i}_Name:=2\n" for i in range(2))
        image.write_bytes(image.read_bytes().replace(b"\n\n", f"\n{names}\n".encode(), 1))
        case.write_text(f'[input]\nimage = "{image}"\n[layers]\nfirst_height = 0.1\nside = "inward"\ninto = "2"\n')
        result = self.run_lumesh("run", case, "-o", self.out)
        self.assert_refused(result, BAD_INPUT, "[layers] into: several labels are called 2; give a number")

    def test_the_example_can_be_run(self):
        example = pathlib.Path(__file__).parents[2] / "examples" / "case3_flow_layers.toml"
        self.assertIn("5 boundary layers inward", self.run_well("run", example, "--dry-run").stdout)


if __name__ == "__main__":
    unittest.main()
