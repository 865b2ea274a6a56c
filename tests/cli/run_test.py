#!/usr/bin/env python3
"""`lumesh run`: a whole case, its files, checkpoints, prediction, and what it refuses.

Usage: run_test.py LUMESH      Exit codes of lumesh: 1 usage, 2 bad input, 4 time limit.
"""
import hashlib
import json
import math
import pathlib
import re
import shutil
import struct
import sys
import tempfile
import unittest
from html.parser import HTMLParser
from random import Random

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import nrrd
from cube import lines_of
from program import BAD_INPUT, LUMESH, TIME_LIMIT, USAGE, ProgramTest

CASE = """\
mesher = "lattice"

[input]
phantom = "carotid"
phantom_size = [128, 128, 127]
phantom_spacing = 4

[lattice]
max_refinement = 2

[metric]
points = "centerline"
k = 20
max_aspect = 8
complexity = 9000

[adapt]
boundary = "frozen"

[output]
meshes = ["a.vtu", "a.msh"]
surface = "a.stl"
"""


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


class Links(HTMLParser):
    """What a page would fetch."""

    def __init__(self):
        super().__init__()
        self.fetched = []

    def handle_starttag(self, tag, attrs):
        for name, value in attrs:
            if name in ("src", "href", "xlink:href") and not value.startswith(("data:", "#")):
                self.fetched.append((tag, value))


class CaseTest(ProgramTest):
    text = CASE

    def setUp(self):
        super().setUp()
        self.case = self.folder / "case.toml"
        self.case.write_text(self.text)
        self.out = self.folder / "out"

    def run_case(self, *more):
        return self.run_well("run", self.case, "-o", self.out, *more)

    @classmethod
    def setUpClass(cls):
        cls.shared = tempfile.TemporaryDirectory(prefix="lumesh_cli_")
        cls.addClassCleanup(cls.shared.cleanup)
        cls.runs = {}

    def run_case_once(self, *more):
        """As run_case, but one run for all tests of the class with these options; each test has a copy of the files."""
        if more not in self.runs:
            folder = pathlib.Path(self.shared.name, str(len(self.runs)))
            self.runs[more] = folder, self.run_well("run", self.case, "-o", folder, *more)
        folder, result = self.runs[more]
        shutil.copytree(folder, self.out)
        return result

    def numbers(self):
        return json.loads((self.out / "report.json").read_text())

    def hash_of_mesh(self):
        """Of the points and cells, from a text format that says nothing of the run."""
        text = self.folder / "hashed.mesh"
        self.run_well("convert", self.out / "a.vtu", text)
        return hashlib.sha256("\n".join(lines_of(text)).encode()).hexdigest()


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
        self.assertGreater(mesh["metric_mean_ratio"]["min"], 0.1)  # 0.008 beside such a plane.


NO_PAGE = ("--set", "output.report=")  # A fifth of the time, where only meshes and numbers are looked at.


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

    def test_a_time_limit_leaves_a_mesh_and_says_so(self):
        result = self.run_lumesh("run", self.case, "-o", self.out, "--set", "metric.complexity=2000000", "--time-limit", "7")
        self.assertEqual(result.returncode, TIME_LIMIT, result.stderr)
        self.assertIn("time limit", result.stderr)
        self.assertIn("report.html, without measures and pictures of the rest", result.stdout)
        self.assertFalse(self.numbers()["complete"])
        self.run_well("evaluate", self.out / "a.vtu")

    def test_a_run_that_is_stopped_leaves_the_files_of_another_one(self):
        stages = "output.stages=true"
        self.run_with_all_files()
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
