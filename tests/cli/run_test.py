#!/usr/bin/env python3
"""`lumesh run`: a whole case, its files, checkpoints, prediction, and what it refuses.

Usage: run_test.py LUMESH      Exit codes of lumesh: 1 usage, 2 bad input.
"""
import json
import math
import pathlib
import re
import struct
import sys
import unittest
from html.parser import HTMLParser
from random import Random

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import nrrd
from case_runs import NO_PAGE, CaseTest
from program import BAD_INPUT, USAGE, ProgramTest


class Links(HTMLParser):
    """What a page would fetch."""

    def __init__(self):
        super().__init__()
        self.fetched = []

    def handle_starttag(self, tag, attrs):
        for name, value in attrs:
            if name in ("src", "href", "xlink:href") and not value.startswith(("data:", "#")):
                self.fetched.append((tag, value))


class FoldsTest(ProgramTest):
    """A wall that folds is told by whatever meshes the image."""

    def test_a_case_tells_of_folded_walls_as_lattice_does(self):
        random, size = Random(4), 24
        waves = [([random.gauss(0, 0.35) for _ in range(3)], random.uniform(0, 6.28)) for _ in range(30)]
        voxels = [int(sum(math.cos(a * i + b * j + c * k + phase) for (a, b, c), phase in waves) > 2)
                  for k in range(size) for j in range(size) for i in range(size)]
        image = nrrd.write(self.folder / "blobs.nrrd", [size] * 3, voxels)

        def folds(result):
            return re.findall(r"the wall is folded: .*? mm by \d+ degrees", result.stderr)

        told = folds(self.run_well("lattice", image, "--spacing", "2.5", "-o", self.folder / "a.vtu"))
        self.assertTrue(told)
        case = self.folder / "case.toml"
        case.write_text('mesher = "lattice"\n[input]\nimage = "blobs.nrrd"\n[lattice]\nspacing = 2.5\n[output]\nmeshes = ["a.vtu"]\nreport = ""\n')
        self.assertEqual(folds(self.run_lumesh("run", case, "-o", self.folder / "out")), told)


class ExtendedInputTest(ProgramTest):
    """The report's first stage tells of what was given, apart from what was made of it."""

    def numbers(self, *settings):
        case = self.folder / "case.toml"
        case.write_text('mesher = "delaunay"\n[delaunay]\nedge_length = 2\n[output]\nmeshes = ["a.vtu"]\nreport = ""\n')
        result = self.run_well("run", case, "-o", self.folder / "out", *(word for one in settings for word in ("--set", one)))
        return result, json.loads((self.folder / "out/report.json").read_text())

    def test_an_extended_image_has_its_own_voxels_and_a_volume_that_is_the_meshs(self):
        size = [20, 18, 30]
        voxels = [int((i - 9.5) ** 2 + (j - 8.5) ** 2 < 16.5) for _ in range(size[2]) for j in range(size[1]) for i in range(size[0])]
        image = nrrd.write(self.folder / "tube.nrrd", size, voxels)
        result, report = self.numbers(f"input.image={image}", "input.extend=10.3")
        self.assertIn("voxels 20 x 18 x 30", result.stdout)
        figures = {figure["name"]: figure["value"] for figure in report["stages"][0]["figures"]}
        self.assertEqual((figures["Voxels"], figures["Label 1"]), ("20 x 18 x 30", sum(voxels)))
        self.assertAlmostEqual(figures["Label 1 with extensions"] / (sum(voxels) * (30 + 2 * 10.3) / 30), 1, delta=0.01)
        label = report["stages"][1]["evaluation"]["labels"][0]
        self.assertAlmostEqual(figures["Label 1 with extensions"], label["voxel_volume_mm3"], places=6)

    def test_an_open_surface_is_told_with_what_was_closed_of_it(self):
        image, closed, opened = (self.folder / name for name in ("tube.nrrd", "closed.stl", "open.stl"))
        nrrd.write(image, [20, 20, 30], [int((i - 9) ** 2 + (j - 9) ** 2 < 16.5) for _ in range(30) for j in range(20) for i in range(20)])
        self.run_well("lattice", image, "-o", self.folder / "tube.vtu", "--surface", closed, "-q")
        data = closed.read_bytes()
        facets = [data[84 + 50 * f:134 + 50 * f] for f in range(int.from_bytes(data[80:84], "little"))]
        wall = [f for f in facets if abs(struct.unpack("<3f", f[:12])[2]) < 0.999]
        opened.write_bytes(data[:80] + len(wall).to_bytes(4, "little") + b"".join(wall))
        result, report = self.numbers(f"input.surface={opened}")
        self.assertRegex(result.stdout, r"input .*open\.stl, triangles, once closed, cut and extended \d+, closed 2\n")
        closed_of = next(figure for figure in report["stages"][0]["figures"] if figure["name"] == "Closed")
        self.assertEqual(closed_of["note"].count("capped "), 2)


class SizesTest(CaseTest):
    """Sizes of the section [delaunay] are those of the command."""
    text = """
mesher = "delaunay"

[input]
image = "ball.nrrd"

[delaunay]
delta = 1.5
label_size = ["1=1.3"]
size_points = "points.xyz"
size_k = 2
size_factor = 0.5
size_floor = 0.8
size_ceiling = 3
size_boundary = 1
size_growth = 0.5
size_image = "sizes.nrrd"
size_mesh = "background.vtu"

[output]
meshes = ["a.vtu"]
report = ""
"""

    def test_a_case_with_every_size_gives_the_mesh_of_the_command(self):
        size = 20
        image = nrrd.write(self.folder / "ball.nrrd", [size] * 3, nrrd.ball(size, 7))
        sizes = nrrd.write(self.folder / "sizes.nrrd", [size] * 3, [1.0 if n % size < 8 else 0.0 for n in range(size ** 3)], kind="float")
        points = self.folder / "points.xyz"
        points.write_text("3 9 9\n3 10 9\n", encoding="ascii")
        other = self.folder / "other.xyz"
        other.write_text("".join(f"{6 + 0.3 * i} 9 9\n" for i in range(20)), encoding="ascii")
        background, first = self.folder / "background.vtu", self.folder / "first.vtu"
        self.run_well("delaunay", image, "--delta", 0.8, "-o", first)
        self.run_well("metric", first, "--points", other, "--k", 2, "--isotropic", "--min-size", 0.6, "-o", background)
        self.run_case()
        of_case, common = self.hash_of_mesh(), ("--delta", 1.5, "--size-points", points, "--size-k", 2, "--size-factor", 0.5,
                                                "--size-floor", 0.8, "--size-ceiling", 3)
        wanted = common + ("--label-size", "1=1.3", "--size-boundary", 1, "--size-growth", 0.5, "--size-image", sizes, "--size-mesh", background)
        self.run_well("delaunay", image, "-o", self.out / "a.vtu", *wanted)
        self.assertEqual(self.hash_of_mesh(), of_case)
        for unneeded in ("--label-size", "--size-boundary", "--size-image", "--size-mesh"):  # Each of them tells in this mesh.
            at = wanted.index(unneeded)
            count = 4 if unneeded == "--size-boundary" else 2
            self.run_well("delaunay", image, "-o", self.out / "a.vtu", *wanted[:at], *wanted[at + count:])
            with self.subTest(unneeded):
                self.assertNotEqual(self.hash_of_mesh(), of_case)


class CoarseForkTest(CaseTest):
    """The first mesh bends by more than the feature angle beside a crotch, where the boundary of the image is smooth."""

    text = """\
[input]
phantom = "bifurcation"
phantom_size = 72

[metric]
curvature = true
complexity = 8000

[output]
meshes = ["a.vtu"]
report = ""
"""

    def test_no_facet_stays_a_plane_that_its_neighbours_cross(self):
        self.run_case()
        mesh = json.loads(self.run_well("evaluate", self.out / "a.vtu", "--json").stdout)
        self.assertTrue(mesh["valid"])
        self.assertGreater(mesh["metric_mean_ratio"]["min"], 0.03)  # 0.008 beside such a plane; 0.05 to 0.14 at complexities of 7,000 to 9,000.


class RunTest(CaseTest):
    def run_on_one_thread(self):
        return self.run_case_once("--threads", "1")

    def run_with_all_files(self):
        return self.run_case_once("--checkpoints", "--set", "output.stages=true")

    def test_writes_what_it_says_and_nothing_between_the_stages(self):
        result = self.run_on_one_thread()
        names = {path.name for path in self.out.iterdir()}
        self.assertEqual(names, {"a.vtu", "a.msh", "a.stl", "report.html", "report.json", "effective.toml"})
        stages = [line.split()[0] for line in result.stdout.splitlines()]
        self.assertEqual(stages[:7], ["input", "centerline", "mesh", "metric", "adapted", "write", "report"])
        warnings = [line for line in result.stderr.splitlines() if "warning: " in line]
        self.assertEqual(sorted(warnings), sorted(set(warnings)))  # First and last mesh may have the same.
        self.assertTrue(any("narrower in the mesh than in the voxels" in warning for warning in warnings))
        report = self.numbers()
        self.assertEqual([stage["name"] for stage in report["stages"]],
                         ["Input", "Centerline", "First mesh", "Metric", "Adapted mesh"])
        last = report["stages"][-1]["evaluation"]
        self.assertTrue(last["valid"])
        self.assertAlmostEqual(last["complexity"] / 9000, 1, delta=0.03)
        self.assertEqual(last["metric_mean_ratio"]["below"]["0.1"], 0)
        self.assertTrue(last["narrowest_sections"])
        tightened = sum(section["tightened"] for section in last["narrowest_sections"])
        warned = [w for w in last["warnings"] if "narrower in the mesh than in the voxels" in w]
        self.assertEqual(len(warned), 1 if tightened else 0)
        page = (self.out / "report.html").read_text(encoding="utf-8")
        self.assertIn("Narrowest section of each branch", page)
        self.assertIn("Voxels kept", page)
        self.assertIn("<h2>Openings</h2>", page)
        # Vessels a voxel in radius, and a lattice that may not be as fine as it should.
        self.assertEqual(len(last["openings"]), 4)
        self.assertEqual(last["openings"][0]["patches"], "inlet_1")
        missing = [opening for opening in last["openings"] if not opening["patches"]]
        self.assertEqual(len([w for w in last["warnings"] if "is missing in the mesh" in w]), len(missing))
        wrong = sum(opening["wrong"] for opening in last["openings"]) - len(missing)
        self.assertEqual(len([w for w in last["warnings"] if "than the input's" in w]), wrong)
        evaluated = self.folder / "a.json"
        self.run_well("evaluate", self.out / "a.vtu", "--json", evaluated)
        self.assertEqual(json.loads(evaluated.read_text())["metric_edge_length"], last["metric_edge_length"])

    def test_the_page_fetches_nothing(self):
        self.run_on_one_thread()
        links = Links()
        links.feed((self.out / "report.html").read_text(encoding="utf-8"))
        self.assertEqual(links.fetched, [])

    def test_the_effective_case_gives_the_same_mesh_on_any_number_of_threads(self):
        self.run_on_one_thread()
        first = self.hash_of_mesh()
        effective = self.folder / "again.toml"
        effective.write_text((self.out / "effective.toml").read_text())
        (self.out / "a.vtu").unlink()
        self.run_well("run", effective, "-o", self.out, "--threads", "4", *NO_PAGE)
        self.assertEqual(self.hash_of_mesh(), first)

    def test_resumes_after_what_has_not_changed_with_the_same_result(self):
        self.run_with_all_files()
        first = self.hash_of_mesh()
        self.assertEqual({path.name for path in (self.out / "checkpoints").glob("*.vt?")},
                         {"centerline.vtp", "mesh.vtu", "metric.vtu", "adapted.vtu"})
        self.run_case("--resume", *NO_PAGE)
        self.assertEqual(self.hash_of_mesh(), first)
        taken = [stage["name"] for stage in self.numbers()["stages"] if "checkpoint" in stage["what"]]
        self.assertEqual(taken, ["Centerline", "First mesh", "Metric", "Adapted mesh"])
        # The last stage anew, from the metric of the checkpoint.
        (self.out / "checkpoints" / "adapted.vtu").unlink()
        self.run_case("--resume", *NO_PAGE)
        self.assertEqual(self.hash_of_mesh(), first)
        # Other settings of a stage: it and those after it are made anew.
        self.run_case("--resume", "--set", "metric.k=25", *NO_PAGE)
        taken = [stage["name"] for stage in self.numbers()["stages"] if "checkpoint" in stage["what"]]
        self.assertEqual(taken, ["Centerline", "First mesh"])
        self.assertNotEqual(self.hash_of_mesh(), first)
        # A boundary that is adapted imposes no sizes on the metric.
        self.run_case("--resume", "--set", "metric.k=25", "--set", "adapt.boundary=adapt", *NO_PAGE)
        taken = [stage["name"] for stage in self.numbers()["stages"] if "checkpoint" in stage["what"]]
        self.assertEqual(taken, ["Centerline", "First mesh"])

    def test_a_broken_checkpoint_is_made_anew(self):
        self.run_with_all_files()
        first = self.hash_of_mesh()
        mesh = self.out / "checkpoints" / "mesh.vtu"
        mesh.write_bytes(mesh.read_bytes()[:-1000])
        self.run_case("--resume", *NO_PAGE)
        self.assertEqual(self.hash_of_mesh(), first)

    def test_a_dry_run_predicts_and_makes_nothing(self):
        result = self.run_case("--dry-run")
        self.assertFalse(self.out.exists())
        self.assertIn("nothing was made", result.stdout)
        self.assertNotIn("first.vtu", result.stdout)
        bounded = self.run_case("--dry-run", "--set", "metric.min_size=40").stdout
        few = float(next(line for line in bounded.splitlines() if "adapted mesh" in line).split("about ")[-1].split()[0])
        self.assertLess(few, 5000)
        words = self.run_lumesh("run", self.case, "--dry-run", "--set", "lattice.spacing=1e-7")
        self.assertIn("[lattice] edge_length", words.stderr)
        line = next(line for line in result.stdout.splitlines() if "adapted mesh" in line)
        predicted = float(line.split("about ")[-1].split()[0])
        self.run_on_one_thread()
        made = self.numbers()["stages"][-1]["evaluation"]["tetrahedra"]
        self.assertAlmostEqual(predicted / made, 1, delta=0.35)

    def test_the_docs_have_every_key(self):
        self.run_on_one_thread()
        page = (pathlib.Path(__file__).parents[2] / "docs" / "stages" / "run.md").read_text(encoding="utf-8")
        lines = (self.out / "effective.toml").read_text().splitlines()
        keys = [line.removeprefix("# ").split(" =")[0] for line in lines if " =" in line and not line.startswith("[")]
        self.assertGreater(len(keys), 60)
        self.assertEqual([key for key in keys if f"`{key}`" not in page], [])

    def test_delaunay_alone_needs_no_metric(self):
        self.case.write_text('mesher = "delaunay"\n[input]\nphantom = "sphere"\nphantom_size = [24, 24, 24]\n'
                             "[delaunay]\ndelta = 5\n")
        self.run_case()
        self.assertEqual([stage["name"] for stage in self.numbers()["stages"]], ["Input", "First mesh"])
        self.assertTrue((self.out / "mesh.vtu").exists())

    def test_refuses_bad_cases_in_one_line(self):
        refused = [
            ("[input]\nphantom = \"carotid\"\n[metric]\ncomplexty = 5\n", "case.toml:4: unknown key \"complexty\""),
            ("[input\n", "case.toml:1"),
            ("mesher = delaunay\n", "quotes"),
            ("[input]\nimage = \"no.nrrd\"\n", "no.nrrd"),
            ("[input]\nphantom = \"carotis\"\n", "carotis"),
            ("[input]\nphantom = \"sphere\"\n[metric]\npoints = \"no.vtp\"\n", "no.vtp"),
            ("[input]\nphantom = \"sphere\"\n[metric]\ngradation = 1.5\n", "[metric] changes nothing without sizes"),
            ("[input]\nphantom = \"sphere\"\n[adapt]\nboundary = \"frozen\"\n", "[adapt] changes nothing without sizes"),
            ("[input]\nphantom = \"sphere\"\n[layers]\ngrowth = 1.5\n", "[layers] first_height is missing"),
            ("[input]\nphantom = \"sphere\"\n[metric]\npoints = \"one.csv\"\n", "one.csv"),
            ("[input]\nphantom = \"sphere\"\n[metric]\nvelocity = \"one.csv\"\n", "one.csv"),
            ("[input]\nphantom = \"sphere\"\n[metric]\npoints = \"two.csv\"\nk = 5\n", "two.csv: has only 2 different points"),
            ("[input]\nphantom = \"sphere\"\n[adapt]\nboundary = -1\n", "must be one of \"adapt\", \"frozen\""),
            ("[input]\nphantom = \"sphere\"\n[adapt]\nboundary = 5\n", "must be one of \"adapt\", \"frozen\""),
            ("[input]\nphantom = \"sphere\"\n[adapt]\nsplit_above = 1\ncollapse_below = 0.8\n", "[adapt] collapse_below"),
            ("mesher = \"lattice\"\n[input]\nphantom = \"sphere\"\nphantom_size = [32, 32, 32]\n[lattice]\nlabel_fidelity = [\"7=0.9\"]\n",
             "has no label 7 to mesh, which [lattice] label_fidelity names; it has 1"),
        ]
        (self.folder / "two.csv").write_text("1 2 3\n4 5 6\n")
        (self.folder / "one.csv").write_text("1 2 3\n")
        for text, words in refused:
            with self.subTest(text):
                self.case.write_text(text)
                result = self.run_lumesh("run", self.case, "-o", self.out)
                self.assert_refused(result, BAD_INPUT, words)
                self.assertNotIn("mesh ", result.stdout)  # Told before the time for a mesh is spent.
        self.assert_refused(self.run_lumesh("run", self.folder / "no.toml"), BAD_INPUT, "no.toml")

    def test_refuses_to_replace_its_input(self):
        self.case.write_text('mesher = "delaunay"\n[input]\nsurface = "mesh.vtu"\n[delaunay]\ndelta = 1\n')
        (self.folder / "mesh.vtu").write_text("a surface")
        self.assert_refused(self.run_lumesh("run", self.case, "-o", self.folder), BAD_INPUT, "would be replaced")

    def test_refuses_two_outputs_that_are_one_file_by_a_link(self):
        self.case.write_text('[input]\nphantom = "sphere"\n[output]\nmeshes = ["a.vtu", "b.vtu"]\n')
        self.out.mkdir()
        (self.out / "b.vtu").symlink_to("a.vtu")
        self.assert_refused(self.run_lumesh("run", self.case, "-o", self.out), BAD_INPUT, "b.vtu: is named for two outputs")

    def test_a_setting_needs_a_value(self):
        for setting in ("k", "metric=3"):
            self.assert_refused(self.run_lumesh("run", self.case, "--set", setting), USAGE, "SECTION.KEY=VALUE")

    def test_a_setting_needs_no_quotes(self):
        for value in ("3.vtu", "it's.vtu", '"a.vtu"', "1e5.vtp"):
            name = value.strip('"')
            key, good = ("surface", True) if name.endswith(".vtp") else ("report", False)
            result = self.run_lumesh("run", self.case, "-o", self.out, "--dry-run", "--set", f"output.{key}={value}")
            if good:
                self.assertEqual(result.returncode, 0, result.stderr)
                self.assertIn(name, result.stdout)
            else:
                self.assert_refused(result, BAD_INPUT, f"{name} must end in .html")
        dry = self.run_well("run", self.case, "-o", self.out, "--dry-run", "--set", " output.meshes = one.vtu ")
        self.assertIn(" one.vtu ", dry.stdout)
        self.assert_refused(self.run_lumesh("run", self.case, "--set", "metric.k=many"), BAD_INPUT, "whole number")

    def test_stages_speak_of_keys_and_resumed_ones_say_the_same(self):
        # So few tetrahedra may leave pieces.
        settings = ("--set", "lattice.max_tetrahedra=500", "--set", "adapt.allow_pieces=true", *NO_PAGE)
        first = self.run_case("--checkpoints", *settings)
        self.assertIn("[lattice] max_tetrahedra", first.stderr)
        self.assertNotIn("--max-tetrahedra", first.stderr)
        stages = self.numbers()["stages"]
        again = self.run_case("--resume", *settings)
        self.assertEqual(again.stderr, first.stderr)
        for was, now in zip(stages, self.numbers()["stages"], strict=True):
            self.assertEqual(now["figures"], was["figures"])
            self.assertEqual(now["warnings"], was["warnings"])


if __name__ == "__main__":
    unittest.main()
