#!/usr/bin/env python3
"""`lumesh layers`: what it makes of a vessel, what it says of it, and what it refuses.

Usage: layers_test.py LUMESH      Exit codes of lumesh: 1 usage, 2 bad input.
"""
import itertools
import json
import math
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from cube import cube, lines_of, write_medit
from program import BAD_INPUT, USAGE, MeshTest


def cylinder(radius, length, around, along):
    """Triangles, as corners, of a cylinder along z that is closed by flat caps."""
    def ring(share, z):
        return [(share * radius * math.cos(2 * math.pi * i / around), share * radius * math.sin(2 * math.pi * i / around), z)
                for i in range(around)]

    rings = [ring(1, length * j / along) for j in range(along + 1)]
    shares = [0.75, 0.5, 0.25]
    rings = [*(ring(share, 0) for share in reversed(shares)), *rings, *(ring(share, length) for share in shares)]
    triangles = []
    for low, high in zip(rings, rings[1:]):
        for i in range(around):
            k = (i + 1) % around
            triangles += [(low[i], low[k], high[k]), (low[i], high[k], high[i])]
    for i in range(around):
        k = (i + 1) % around
        triangles += [(rings[0][k], rings[0][i], (0, 0, 0)), (rings[-1][i], rings[-1][k], (0, 0, length))]
    return triangles


def write_stl(path, triangles):
    lines = ["solid cylinder"]
    for corners in triangles:
        lines += ["facet normal 0 0 0", "outer loop", *("vertex {!r} {!r} {!r}".format(*p) for p in corners), "endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid cylinder", ""]))


def write_parted_ball(path, seed):
    """An image of a ball that planes between some places, the same for a seed everywhere, part into labels."""
    def chance(i):
        value = math.sin(i * 12.9898 + seed * 78.233) * 43758.5453
        return value - math.floor(value)

    size, spacing = (10, 22, 16), (1, 1, 1 + 1.5 * chance(99))
    places = [[chance(3 * i + axis) * size[axis] * spacing[axis] for axis in range(3)] for i in range(4 + int(4 * chance(98)))]
    middle = [(size[axis] - 1) * spacing[axis] / 2 for axis in range(3)]
    radius = 1.6 * (3.5 + 3 * chance(97))
    voxels = bytearray()
    for k, j, i in itertools.product(range(size[2]), range(size[1]), range(size[0])):
        place = (i * spacing[0], j * spacing[1], k * spacing[2])
        nearest = min(range(len(places)), key=lambda n: math.dist(place, places[n]))
        voxels.append(1 + nearest if math.dist(place, middle) < radius else 0)
    path.write_bytes(("NRRD0004\ntype: uchar\ndimension: 3\nsizes: %d %d %d\nspacings: %r %r %r\nencoding: raw\n\n"
                      % (*size, *spacing)).encode() + bytes(voxels))


class LayersTest(MeshTest):
    def setUp(self):
        super().setUp()
        self.mesh = self.folder / "cube.mesh"
        points, tetrahedra, triangles = cube(4)
        write_medit(self.mesh, points, tetrahedra, triangles)

    def test_the_outer_surface_does_not_fold_around_a_corner(self):
        # Between layers and a ridge without them, triangles with one corner in common crossed; then sides over the rim did.
        for seed, edge, height in ((288, 2.6, 0.2), (288, 2.6, 0.25), (45, 3.1, 0.15)):
            with self.subTest(seed=seed, height=height):
                image, base = self.folder / "ball.nrrd", self.folder / "ball.vtu"
                write_parted_ball(image, seed)
                self.run_well("lattice", image, "-o", base, "--edge-length", edge)
                result = self.run_lumesh("layers", base, "--first-height", height, "--count", 4, "-o", self.out)
                self.assertNotIn("invalid", result.stderr)
                self.assertTrue(self.out.exists())

    def test_grows_named_layers_and_says_what_it_achieved(self):
        numbers, page = self.folder / "layers.json", self.folder / "layers.html"
        result = self.run_well("layers", self.vessel(), "--patch", "wall", "--first-height", 0.1, "--growth", 1.2, "--count", 4,
                               "--label", "vessel=7", "-o", self.out, "--json", numbers, "--report", page)
        report = json.loads(numbers.read_text())
        self.assertEqual(report["layers"], 4)
        self.assertAlmostEqual(report["heights"][3], 0.1 * 1.2 ** 3)
        wall = report["patches"][0]
        self.assertEqual(wall["patch"], "wall")
        self.assertGreater(wall["complete"], 0.85)
        self.assertAlmostEqual(sum(wall["limited"].values()), 1 - wall["complete"], places=6)
        self.assertEqual(wall["layers"], 4)
        self.assertAlmostEqual(wall["layered"] + wall["bare"], 1)
        self.assertIn("complete", result.stdout)
        for words in ("Layers, patch by patch", "wall", "Thickness reached", "data:image/png;base64,"):
            self.assertIn(words, page.read_text(encoding="utf-8"))
        found = self.evaluate(self.out)
        self.assertTrue(found["valid"])
        names = {patch["name"] for patch in found["boundary"]["patches"]}
        self.assertLessEqual({"wall", "layer_outer", "inlet_1", "inlet_1_layer"}, names)
        self.assertEqual({label["label"] for label in found["labels"]}, {1, 7})

    def test_inward_layers_keep_the_volume_and_the_wall(self):
        mesh = self.vessel()
        before = self.evaluate(mesh)
        self.run_well("layers", mesh, "--side", "inward", "--first-height", 0.05, "--count", 3, "-o", self.out)
        found = self.evaluate(self.out)
        self.assertTrue(found["valid"])
        self.assertEqual([label["name"] for label in found["labels"]], ["", "layer"])
        volume = [sum(label["volume_mm3"] for label in of["labels"]) for of in (before, found)]
        self.assertAlmostEqual(volume[1] / volume[0], 1, places=9)
        wall = [next(p for p in of["boundary"]["patches"] if p["name"] == "wall")["area_mm2"] for of in (before, found)]
        self.assertAlmostEqual(wall[1] / wall[0], 1, places=9)

    def test_prisms_of_a_cube_without_openings(self):
        self.run_well("layers", self.mesh, "--blds", 0.02, "--nbl", 3, "--cells", "prisms", "-o", self.out)
        found = self.evaluate(self.out)
        self.assertEqual(found["prisms"], 3 * 6 * 2 * 4 * 4)

    def bits_of(self, mesh, *arguments):
        out = self.folder / "bits.mesh"
        self.run_well("layers", mesh, "-o", out, *arguments)
        return lines_of(out)

    def test_the_same_bits_for_every_number_of_threads(self):
        mesh = self.vessel()
        for side, height in (("outward", 0.3), ("inward", 0.1)):
            options = ["--side", side, "--first-height", height, "--count", 3, "--threads"]
            first = self.bits_of(mesh, *options, 1)
            for threads in (2, 5):
                self.assertEqual(first, self.bits_of(mesh, *options, threads), (side, threads))

    def test_names_of_aflr_mean_the_same(self):
        ours = ["--first-height", 0.02, "--count", 4, "--growth", 1.1, "--growth-rise", 1.05, "--constant-layers", 2, "--most-growth", 1.3,
                "--cells", "prisms"]
        aflr = ["--mbl", 1, "--fints", 0, "--open", "--blds", 0.02, "--nbl", 4, "--blr", 1.1, "--bldr", 1.05, "--bli", 2, "--blrm", 1.3, "--blc"]
        self.assertEqual(self.bits_of(self.mesh, *ours), self.bits_of(self.mesh, *aflr))

    def test_the_papers_line_of_aflr_is_taken_as_it_stands(self):
        mesh, numbers = self.vessel(), self.folder / "layers.json"
        self.run_well("layers", mesh, "--blds", 0.3, "--mbl", 1, "--fints", 0, "--open", "-o", self.out, "--json", numbers)
        report = json.loads(numbers.read_text())
        self.assertGreater(report["layers"], 1)
        self.assertGreaterEqual(report["patches"][0]["least_first_height"], 0.95)
        self.assertGreaterEqual(report["patches"][0]["first_height_kept"], 0.75)  # A coarse mesh: branches of three voxels.
        self.out.unlink()
        for option, value, only in (("--mbl", 2, 1), ("--fints", 1, 0)):
            self.assert_refused(self.run_lumesh("layers", mesh, "--blds", 0.1, option, value, "-o", self.out), USAGE, option,
                                f"must be {only}, not {value}")

    def test_flat_caps_of_a_closed_surface_are_left_free(self):
        surface, mesh, case = (self.folder / name for name in ("cylinder.stl", "cylinder.vtu", "case.toml"))
        write_stl(surface, cylinder(3, 15, around=40, along=25))
        self.run_well("delaunay", surface, "--delta", 0.8, "-o", mesh)
        self.run_well("layers", mesh, "--first-height", 0.1, "--count", 3, "-o", self.out)
        case.write_text(f'mesher = "delaunay"\n[input]\nsurface = "{surface}"\n[delaunay]\ndelta = 0.8\n[metric]\n'
                        'curvature = true\ncomplexity = 2000\n[layers]\nfirst_height = 0.1\ncount = 3\n[output]\nmeshes = ["m.vtu"]\nreport = ""\n')
        self.run_well("run", case, "-o", self.folder / "of_case")
        for made in (self.out, self.folder / "of_case/m.vtu"):
            with self.subTest(made):
                areas = {p["name"]: p["area_mm2"] for p in self.evaluate(made)["boundary"]["patches"]}
                for cap in ("inlet_1", "outlet_1"):
                    self.assertAlmostEqual(areas[cap] / (math.pi * 3 ** 2), 1, delta=0.02)
                    self.assertAlmostEqual(areas[cap + "_layer"] / (math.pi * (3.364 ** 2 - 3 ** 2)), 1, delta=0.05)
                self.assertAlmostEqual(areas["layer_outer"] / (2 * math.pi * 3.364 * 15), 1, delta=0.05)
        self.assertIn(b'"metric"', (self.folder / "of_case/m.vtu").read_bytes())

    def test_extensions_behind_layers_are_told_with_all_cells(self):
        surface, mesh, out = self.folder / "cylinder.stl", self.folder / "cylinder.vtu", self.folder / "out.vtu"
        write_stl(surface, cylinder(1, 4, around=24, along=16))
        self.run_well("delaunay", surface, "-o", mesh, "--edge-length", 0.4, "-q")
        told = self.run_well("layers", mesh, "--side", "inward", "--first-height", 0.04, "--count", 2, "--extend", 2, "-o", out).stdout
        cells = json.loads(self.run_well("info", out, "--json").stdout)
        all_cells = cells["tetrahedra"] + cells["prisms"]
        self.assertRegex(told, rf"2 layers, .*\n.*out\.vtu: \d+ cells of extensions more, {all_cells} in all\n$")

    def test_keeps_the_metric_of_the_mesh(self):
        mesh, sized = self.vessel(), self.folder / "sized.vtu"
        self.run_well("metric", mesh, "--curvature", "-o", sized)
        for side in ("outward", "inward"):
            self.run_well("layers", sized, "--side", side, "--first-height", 0.05, "--count", 2, "-o", self.out)
            self.assertIn(b'"metric"', self.out.read_bytes())
            self.assertTrue(self.evaluate(self.out)["valid"])

    def test_between_labels_one_of_them_gives_way(self):
        image, mesh = self.folder / "two.nrrd", self.folder / "two.vtu"
        self.run_well("phantom", "layered", "-o", image, "--size", 64, "--spacing", 1.5)
        self.run_well("lattice", image, "-o", mesh)
        before = self.evaluate(mesh)
        between = next(p["name"] for p in before["boundary"]["patches"] if p["name"].startswith("interface"))
        first, second = between.split("_")[1:]
        options = ["--patch", between, "--first-height", 0.1, "--count", 2]
        for side in ("outward", "inward"):
            self.assert_refused(self.run_lumesh("layers", mesh, "-o", self.out, "--side", side, *options), BAD_INPUT, "has no free side")
        self.assert_refused(self.run_lumesh("layers", mesh, "-o", self.out, "--into", second, *options), USAGE, "--side inward")
        self.assert_refused(self.run_lumesh("layers", mesh, "-o", self.out, "--side", "inward", "--into", 99, *options), BAD_INPUT,
                            "there is no label 99")
        self.run_well("layers", mesh, "-o", self.out, "--side", "inward", "--into", second, *options)
        found = self.evaluate(self.out)
        self.assertTrue(found["valid"])
        volumes = [{label["label"]: label["volume_mm3"] for label in of["labels"]} for of in (before, found)]
        self.assertAlmostEqual(volumes[1][int(first)] / volumes[0][int(first)], 1, places=12)
        layers = max(volumes[1])
        self.assertAlmostEqual((volumes[1][int(second)] + volumes[1][layers]) / volumes[0][int(second)], 1, places=3)

    def test_around_a_mesh_of_mixed_cells_these_stay_as_they_are(self):
        image, mesh, core = self.folder / "ball.nrrd", self.folder / "ball.mesh", self.folder / "core.mesh"
        self.run_well("phantom", "sphere", "--size", 32, 32, 32, "--radius", 10, "-o", image)
        self.run_well("lattice", image, "-o", mesh, "--mixed", "--spacing", 1.5)
        before = self.evaluate(mesh)
        self.assertGreater(min(before["hexahedra"], before["pyramids"]), 100)
        layers = ["layers", mesh, "--first-height", 0.2, "--count", 3, "--label", 7]
        for cells in ("tetrahedra", "prisms"):
            numbers = self.folder / "layers.json"
            self.run_well(*layers, "--cells", cells, "-o", self.out, "--json", numbers)
            found, told = self.evaluate(self.out), json.loads(numbers.read_text())
            self.assertTrue(found["valid"])
            self.assertEqual(found["hexahedra"], before["hexahedra"])
            self.assertEqual(told["core"]["tetrahedra"], before["tetrahedra"])
            self.assertEqual(found["tetrahedra"], before["tetrahedra"] + told["shapes"]["tetrahedra"])
            self.assertEqual(found["prisms"], told["shapes"]["prisms"])
            self.assertEqual(found["pyramids"], before["pyramids"] + told["shapes"]["pyramids"])
            self.assertGreater(told["complete"], 0.99)
            # Points and cells of the core to the last digit, by what the files say of them.
            self.run_well("convert", self.out, core)
            was, now = (self.sections(of) for of in (mesh, core))
            for name in ("Vertices", "Tetrahedra", "Pyramids", "Hexahedra"):
                self.assertEqual(now[name][:len(was[name])], was[name], name)

    def sections(self, mesh):
        """Lines of each section of a Medit file, without their count and the references of points, which say on what they lie."""
        found, name = {}, None
        for line in mesh.read_text().splitlines():
            if line[:1].isalpha():
                name, found[line.split()[0]] = line.split()[0], []
            elif name and line and not line.startswith("#"):
                found[name].append(line.rsplit(" ", 1)[0] if name == "Vertices" else line)
        return {of: lines[1:] for of, lines in found.items()}

    def test_refuses_mixed_cells_that_layers_cannot_have(self):
        image, mesh = self.folder / "ball.nrrd", self.folder / "ball.vtu"
        self.run_well("phantom", "sphere", "--size", 32, 32, 32, "--radius", 10, "-o", image)
        self.run_well("lattice", image, "-o", mesh, "--mixed", "--spacing", 1.5)
        layers = ["--first-height", 0.2, "--count", 2, "-o", self.out]
        self.assert_refused(self.run_lumesh("layers", mesh, *layers, "--side", "inward"), BAD_INPUT, "ball.vtu", "only tetrahedra can be deformed",
                            "--side outward")
        layered = self.folder / "prisms.vtu"
        self.run_well("layers", self.vessel(), "--first-height", 0.1, "--count", 2, "--cells", "prisms", "-o", layered)
        self.assert_refused(self.run_lumesh("layers", layered, *layers), BAD_INPUT, "quadrilaterals")
        for command in (["improve"], ["adapt", "--analytic", "linear"], ["metric", "--curvature"]):
            self.assert_refused(self.run_lumesh(command[0], mesh, *command[1:], "-o", self.out), BAD_INPUT, "hexahedra, prisms or pyramids",
                                "tetrahedra only; mesh without")

    def test_refuses_what_cannot_be(self):
        refused = [
            (["--first-height", 1, "--count", 2, "--patch", "door"], "no patch door"),
            (["--first-height", 1e9, "--count", 2], "more than the surface is wide"),
            (["--first-height", 0.1, "--growth", 1], "do not grow never become as high"),
            (["--first-height", 0.1, "--short-of-room", "shrink"], "needs the number of layers"),
            (["--first-height", 0.1, "--growth", 0.9, "--thickness", 1], "growth below 1"),
        ]
        for arguments, words in refused:
            with self.subTest(arguments):
                self.assert_refused(self.run_lumesh("layers", self.mesh, "-o", self.out, *arguments), BAD_INPUT, words)
        for arguments, words in ((["--count", 2], "--first-height"),
                                 (["--first-height", 0, "--count", 2], "--first-height: must be greater than 0"),
                                 (["--first-height", -1, "--count", 2], "--first-height: must be greater than 0"),
                                 (["--first-height", 0.1, "--count", 2, "--label", "wall=x"], "NAME=NUMBER"),
                                 (["--first-height", 0.1, "--count", 1000], "between 1 and 200")):
            self.assert_refused(self.run_lumesh("layers", self.mesh, "-o", self.out, *arguments), USAGE, words)
        _, _, triangles = cube(2)
        points, _, _ = cube(2)
        surface = self.folder / "surface.mesh"
        write_medit(surface, points, [], triangles[:-2])
        self.assert_refused(self.run_lumesh("layers", surface, "-o", self.out, "--first-height", 0.1, "--count", 2), BAD_INPUT,
                            "surface.mesh")
        self.assert_refused(self.run_lumesh("layers", self.mesh, "-o", self.folder / "a.xdmf", "--first-height", 0.1, "--count", 2,
                                            "--cells", "prisms"), USAGE, "holds tetrahedra only")


if __name__ == "__main__":
    unittest.main()
