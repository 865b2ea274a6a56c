#!/usr/bin/env python3
"""`lumesh metric` and `lumesh adapt`: what they make of a cube, and what they refuse.

Usage: adapt_test.py LUMESH      Exit codes of lumesh: 1 usage, 2 bad input, 4 time limit.
"""
import json
import math
import pathlib
import re
import signal
import subprocess
import sys
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from cube import cube, write_medit, write_sol
import nrrd
from program import BAD_INPUT, LUMESH, MEMORY, TIME_LIMIT, USAGE, MeshTest, take_signals, wait_for_line


def write_cube(path, n, one_patch=False):
    """As Medit text; returns its points."""
    points, tetrahedra, triangles = cube(n)
    if one_patch:
        triangles = [(*corners, 1) for *corners, _ in triangles]
    write_medit(path, points, tetrahedra, triangles)
    return points


class AdaptTest(MeshTest):
    def setUp(self):
        super().setUp()
        self.cube = self.folder / "cube.mesh"
        self.points = write_cube(self.cube, 3)

    def assert_conforms(self, found, shortest, longest):
        """As the metric asks, with no edge outside [shortest, longest]."""
        self.assertGreater(found["metric_edge_length"]["fraction_in_band"], 0.97)
        self.assertGreater(found["metric_edge_length"]["min"], shortest)
        self.assertLess(found["metric_edge_length"]["max"], longest)
        self.assertGreater(found["metric_mean_ratio"]["mean"], 0.86)
        self.assertGreater(found["metric_mean_ratio"]["min"], 0.35)

    def test_a_formula_becomes_a_unit_mesh(self):
        report = self.folder / "adapt.json"
        self.run_well("adapt", self.cube, "--analytic", "linear", "-o", self.out, "--json", report)
        found = self.evaluate(self.out)
        self.assert_conforms(found, 0.25, 2.5)
        exact = 100 * 2 / 0.198 * math.log(1 + 0.198 * 0.5 / 0.001)
        self.assertAlmostEqual(found["complexity"] / exact, 1, delta=0.02)
        counts = json.loads(report.read_text())["operators"]
        for name in ("insertion", "collapse", "edge_removal", "face_removal", "smoothing"):
            self.assertEqual(set(counts[name]), {"applied", "rejected", "contended"})
        self.assertGreater(counts["insertion"]["applied"], 5000)

    def test_the_complexity_asked_for_is_met(self):
        self.run_well("adapt", self.cube, "--analytic", "polar-2", "--complexity", 1500, "-o", self.out)
        self.assertAlmostEqual(self.evaluate(self.out)["complexity"] / 1500, 1, delta=0.03)

    def test_the_metric_of_the_adapted_mesh_is_written_beside_it(self):
        mesh, sol, both = self.folder / "adapted.meshb", self.folder / "adapted.solb", self.folder / "both.vtu"
        self.run_well("adapt", self.cube, "--analytic", "polar-2", "--complexity", 800, "-o", mesh, "--metric-output", sol)
        self.run_well("adapt", self.cube, "--analytic", "polar-2", "--complexity", 800, "-o", self.out)
        self.assertNotIn("metric_edge_length", self.evaluate(mesh))
        self.run_well("metric", mesh, "-m", sol, "-o", both)
        self.assertAlmostEqual(self.evaluate(both)["metric_edge_length"]["mean"],
                               self.evaluate(self.out)["metric_edge_length"]["mean"])
        text = self.folder / "again.sol"
        self.run_well("metric", both, "-o", text)
        tensors = [[float(x) for x in line.split()] for line in text.read_text().splitlines() if len(line.split()) == 6]
        self.assertEqual(len(tensors), self.evaluate(both)["vertices"])

    def test_more_vertices_than_the_complexity_asks_for_are_told(self):
        result = self.run_well("adapt", self.cube, "--analytic", "linear", "--complexity", 1, "--boundary", "frozen", "-o", self.out)
        self.assertIn("the surface needs more", result.stderr)

    def test_the_benchmarks_cube_with_a_cylinder_becomes_a_unit_mesh(self):
        mesh = pathlib.Path(__file__).parents[3] / "shared/data/ugawg/cube-cylinder/cube-cylinder.meshb"
        if not mesh.is_file():
            self.skipTest(f"no {mesh}")
        for formula in ("linear", "polar-2"):
            self.run_well("adapt", mesh, "--analytic", formula, "-o", self.out)
            found = self.evaluate(self.out)
            self.assert_conforms(found, 0.4, 2.2)

    def test_every_number_of_threads_gives_the_same_file(self):
        files = []
        for threads, balance in ((1, "none"), (2, "first-idle"), (8, "hierarchical"), (16, "node-first"), (64, "stealing")):
            path = self.folder / f"{threads}.vtu"
            self.run_well("adapt", self.cube, "--analytic", "polar-2", "--complexity", 800, "-o", path, "--nthreads", threads,
                          "--balance", balance, "--pin", "on")
            files.append(path.read_bytes())
        for file in files[1:]:
            self.assertEqual(file, files[0])

    def test_speculation_is_as_good_and_tells_what_each_thread_did(self):
        report = self.folder / "adapt.json"
        result = self.run_well("adapt", self.cube, "--analytic", "linear", "-o", self.out, "--execution", "speculative",
                               "--threads", 4, "--topology", "numa:2 core:2 pu:1", "--json", report, "-v")
        found = self.evaluate(self.out)
        self.assertGreater(found["metric_edge_length"]["fraction_in_band"], 0.97)
        self.assertGreater(found["metric_mean_ratio"]["mean"], 0.86)
        told = json.loads(report.read_text())
        self.assertEqual(len(told["threads"]), 4)
        for name, sums in told["operators"].items():
            for kind, count in sums.items():
                self.assertEqual(sum(thread["operators"][name][kind] for thread in told["threads"]), count)
            self.assertIn(f"lumesh: {name}: {sums['applied']} applied", result.stderr)
        for kind in ("local", "remote"):
            self.assertEqual(sum(thread["hand_overs"][kind] for thread in told["threads"]), told["hand_overs"][kind])
        self.assertIn("lumesh: thread 3: ", result.stderr)

    def test_the_metric_of_a_mesh_and_that_of_a_sol_file_are_the_same(self):
        sizes = [(0.2, 0.2, 0.05 + 0.2 * z) for _, _, z in self.points]
        sol = self.folder / "cube.sol"
        write_sol(sol, [(a ** -2, 0, b ** -2, 0, 0, c ** -2) for a, b, c in sizes])
        self.run_well("adapt", self.cube, "--metric", sol, "-o", self.out)
        found = self.evaluate(self.out)
        self.assertGreater(found["metric_edge_length"]["fraction_in_band"], 0.93)
        # 25 times the integral of dz / (0.05 + 0.2 z); a mesh of three layers interpolates it a little lower.
        self.assertAlmostEqual(found["complexity"] / (25 * 5 * math.log(5)), 1, delta=0.08)

    def test_metric_gives_the_mesh_its_tensors(self):
        self.run_well("metric", self.cube, "--analytic", "linear", "-o", self.out)
        adapted = self.folder / "adapted.vtu"
        self.run_well("adapt", self.out, "-o", adapted)
        self.assertGreater(self.evaluate(adapted)["metric_edge_length"]["fraction_in_band"], 0.9)

    def test_bounds_and_gradation_change_what_a_mesh_asks_for(self):
        own = self.folder / "own.vtu"
        self.run_well("metric", self.cube, "--analytic", "linear", "-o", own)

        def complexity(*options):
            result = self.run_well("metric", own, "-o", self.out, *options)
            return float(re.search(r"complexity (\d+)", result.stdout)[1])

        as_it_is = complexity()
        self.assertEqual(round(complexity("--min-size", 0.05, "--max-size", 0.05) * 0.05 ** 3), 1)
        self.assertLess(complexity("--min-size", 0.07), as_it_is)
        self.assertGreater(complexity("--gradation", 1.05), 1.01 * as_it_is)
        self.assertAlmostEqual(complexity("--gradation", 1.2, "--complexity", 5000) / 5000, 1, delta=0.002)
        bounded = self.run_lumesh("metric", own, "-o", self.out, "--complexity", "1e6", "--min-size", 0.1)
        self.assertEqual(bounded.returncode, 0)
        self.assertIn("bounds on sizes", bounded.stderr)

    def test_outputs_that_cannot_be_are_refused_before_any_work(self):
        adapt = ("adapt", self.cube, "--analytic", "linear")
        for name in ("x.txt", "x.sol", "x.vtp"):
            self.assert_refused(self.run_lumesh(*adapt, "-o", self.folder / name), USAGE, name, ".meshb")
        self.assert_refused(self.run_lumesh(*adapt, "-o", self.out, "--json", self.out), USAGE, self.out.name, "two outputs")

    def test_a_point_without_tetrahedra_is_refused(self):
        points, tetrahedra, triangles = cube(2)
        mesh = self.folder / "lonely.mesh"
        write_medit(mesh, [*points, (2, 2, 2)], tetrahedra, triangles)
        self.assert_refused(self.run_lumesh("adapt", mesh, "--analytic", "linear", "-o", self.out), BAD_INPUT, "lonely.mesh", "point 27")

    def test_two_parts_keep_their_own_sizes(self):
        points, tetrahedra, triangles = cube(2)
        n, mesh, sizes = len(points), self.folder / "two.mesh", self.folder / "two.sol"
        write_medit(mesh, points + [(x + 3, y, z) for x, y, z in points],
                    tetrahedra + [(*(v + n for v in t[:4]), 1) for t in tetrahedra],
                    triangles + [(*(v + n for v in t[:3]), t[3]) for t in triangles])
        write_sol(sizes, [[h ** -2, 0, h ** -2, 0, 0, h ** -2] for h in (0.25, 0.5) for _ in range(n)])
        self.run_well("metric", mesh, "-m", sizes, "-o", self.out)
        self.assertAlmostEqual(self.evaluate(self.out)["complexity"], 4 ** 3 + 2 ** 3)
        adapted = self.folder / "adapted.vtu"
        result = self.run_lumesh("adapt", self.out, "-o", adapted)
        self.assertEqual(result.returncode, BAD_INPUT)
        self.assertIn("has 2 pieces", result.stderr)
        self.assertFalse(adapted.exists())
        self.run_well("adapt", self.out, "-o", adapted, "--allow-pieces")
        self.assertEqual(self.evaluate(adapted)["components"], 2)

    def test_a_metric_output_of_another_kind_is_refused(self):
        self.assert_refused(self.run_lumesh("adapt", self.cube, "--analytic", "linear", "-o", self.out,
                                            "--metric-output", self.folder / "x.vtk"), USAGE, "x.vtk", ".sol")

    def test_metric_options_that_cannot_be_are_refused(self):
        metric = ("metric", self.cube, "-o", self.out)
        self.assert_refused(self.run_lumesh(*metric), BAD_INPUT, "cube.mesh", "no metric")
        for growth in (1, -3, "nan"):
            self.assert_refused(self.run_lumesh(*metric, "--analytic", "linear", "--gradation", growth), USAGE, "gradation")
        self.assert_refused(self.run_lumesh(*metric, "--analytic", "linear", "--min-size", 2, "--max-size", 1), BAD_INPUT,
                            "--min-size")
        self.assert_refused(self.run_lumesh("adapt", self.cube, "--analytic", "linear", "--gradation", 2, "-o", self.out), USAGE,
                            "--gradation")

    def assert_ended_early(self, code, errors, *words):
        """The first line comes at once, the second when the mesh is written."""
        self.assertEqual(code, TIME_LIMIT, errors)
        lines = errors.splitlines()
        self.assertEqual(len(lines), 2, errors)
        for word in (*words, "what there is will be written"):
            self.assertIn(word, lines[0])
        for word in (*words, "out.vtu", "best mesh so far"):
            self.assertIn(word, lines[1])
        # A valid mesh, or evaluate would say so, that is not done.
        self.assertGreater(self.evaluate(self.out)["metric_edge_length"]["max"], 2.5)

    def test_at_the_time_limit_the_best_mesh_so_far_is_written(self):
        result = self.run_lumesh("adapt", self.cube, "--analytic", "polar-2", "--complexity", 500000, "--time-limit", 1.5,
                                 "-o", self.out)
        self.assert_ended_early(result.returncode, result.stderr, "time limit of 1.5 s")

    def test_an_adapted_wall_stays_within_the_image(self):
        """A vessel that grazes the border, whose wall went 0.19 mm beyond it."""
        start, end, radius = (-3, 3.44, 17.57), (33, 1.24, 24.77), 3.861
        axis = [b - a for a, b in zip(start, end)]
        length2 = sum(x * x for x in axis)

        def is_inside(*voxel):
            off = [x - a for x, a in zip(voxel, start)]
            along = sum(o * x for o, x in zip(off, axis)) / length2
            return sum((o - along * x) ** 2 for o, x in zip(off, axis)) < radius ** 2

        image, first, sized = self.folder / "graze.nrrd", self.folder / "first.vtu", self.folder / "sized.vtu"
        nrrd.write(image, [30] * 3, [int(is_inside(i, j, k)) for k in range(30) for j in range(30) for i in range(30)])
        self.run_well("delaunay", image, "--delta", 1.2, "-o", first)
        for gradation in (0, 1.2, 1.3, 1.5, 2):
            self.run_well("metric", first, "--curvature", "--max-size", 6, "--min-size", 0.8, "--gradation", gradation, "-o", sized)
            errors = self.run_well("adapt", sized, "--allow-pieces", "--image", image, "-o", self.out).stderr
            low, high = json.loads(self.run_well("info", self.out, "--json").stdout)["box"]
            is_within = min(low) > -0.5 - 1e-6 and max(high) < 29.5 + 1e-6
            self.assertTrue(is_within or "beyond the image's border" in errors, (gradation, low, high, errors))
            self.assertGreater(min(low), -0.75, "of 1.5, 0.41 mm beyond before it was brought back")

    def test_an_interrupt_leaves_the_best_mesh_so_far(self):
        self.out.write_bytes(b"what was there")
        with subprocess.Popen([LUMESH, "adapt", self.cube, "--analytic", "polar-2", "--complexity", "500000", "-v", "-o", self.out],
                              stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, preexec_fn=take_signals) as process:
            wait_for_line(process, "reconnect took")  # The first pass that improves the mesh.
            process.send_signal(signal.SIGINT)
            sent = time.monotonic()
            errors = process.communicate(timeout=120)[1]
        self.assertLess(time.monotonic() - sent, 3)  # A second, and what a busy machine adds.
        self.assertEqual(process.returncode, TIME_LIMIT)
        self.assertIn("interrupted; ", errors)
        self.assertEqual(self.out.read_bytes(), b"what was there")
        partial = self.out.with_suffix(".partial" + self.out.suffix)
        self.assertEqual({path.name for path in self.folder.iterdir() if path.name.startswith(self.out.stem)} - {partial.name},
                         {self.out.name})
        self.assertIn(f"{partial} holds the best mesh so far", errors)
        self.assertTrue(self.evaluate(partial)["valid"])

    def test_a_frozen_surface_stays(self):
        for option in (("--boundary", "frozen"), ("--sref", "0")):
            result = self.run_well("adapt", self.cube, "--analytic", "linear", *option, "-o", self.out)
            self.assertIn("108 boundary triangles", result.stdout)

    def test_a_cube_of_one_patch_keeps_its_edges(self):
        write_cube(self.cube, 3, one_patch=True)
        self.run_well("adapt", self.cube, "--analytic", "linear", "-o", self.out)
        found = self.evaluate(self.out)
        self.assertGreater(found["metric_edge_length"]["fraction_in_band"], 0.97)
        adapted = self.folder / "adapted.mesh"
        self.run_well("convert", self.out, adapted)
        text = adapted.read_text(encoding="ascii").split()
        first, count = text.index("Vertices") + 2, int(text[text.index("Vertices") + 1])
        points = [tuple(map(float, text[i:i + 3])) for i in range(first, first + 4 * count, 4)]
        first, count = text.index("Triangles") + 2, int(text[text.index("Triangles") + 1])
        self.assertGreater(count, 1000)
        for i in range(first, first + 4 * count, 4):
            corners = [points[int(text[i + k]) - 1] for k in range(3)]
            self.assertTrue(any(all(p[axis] == end for p in corners) for axis in range(3) for end in (0, 1)), corners)
        self.assertEqual({text[i + 3] for i in range(first, first + 4 * count, 4)}, {text[first + 3]})

    def test_names_of_cdt3d_are_understood(self):
        self.run_well("adapt", self.cube, "--analytic", "polar-2", "--complexity", 2000, "--met", 1, "--meval", 1, "--reconstruct", 1, "--mpp", 5,
                      "--sref", 1, "--nqual", 3, "--nsmth", 2, "--cdff", 1.4, "--cdfn", 0.6, "--nthreads", 1, "-o", self.out)
        at_centroids = self.out.read_bytes()
        self.run_well("adapt", self.cube, "--analytic", "polar-2", "--complexity", 2000, "--placement", "centroid",
                      "--quality-passes", 3, "--smoothing-passes", 2, "--split-above", 1.4, "--threads", 2, "-o", self.out)
        other = self.folder / "by_cdt3d.vtu"
        other.write_bytes(at_centroids)
        self.assertEqual(self.evaluate(self.out)["vertices"], self.evaluate(other)["vertices"])
        self.run_well("adapt", self.cube, "--analytic", "polar-2", "--complexity", 2000, "-o", self.out)
        self.assertNotEqual(self.evaluate(self.out)["vertices"], self.evaluate(other)["vertices"])

    def test_coarse_vessels_keep_their_volume(self):
        image, mesh, sizes = self.folder / "c.nrrd", self.folder / "c.vtu", self.folder / "sizes.vtu"
        self.run_well("phantom", "carotid", "--size", 100, 100, 100, "-o", image)
        self.run_well("delaunay", image, "-o", mesh)  # Its edges are 0.6 to 1.8 radii long.
        self.run_well("metric", mesh, "--curvature", "--edges-per-radius", 4, "-o", sizes)
        for options in ((), ("--image", image)):
            numbers = self.folder / "numbers.json"
            self.run_well("adapt", sizes, "--boundary", "adapt", *options, "--json", numbers, "-o", self.out)
            (volume,) = json.loads(numbers.read_text())["volumes"]
            self.assertLess(abs(volume["change_percent"]), 0.05)

    def test_the_surface_follows_the_image(self):
        image, mesh, sizes = self.folder / "ball.nrrd", self.folder / "ball.vtu", self.folder / "sizes.sol"
        self.run_well("phantom", "sphere", "--size", 32, 32, 32, "--radius", 11, "-o", image)
        self.run_well("lattice", image, "-o", mesh)
        count = self.evaluate(mesh)["vertices"]
        write_sol(sizes, [[0.25, 0, 0.25, 0, 0, 0.25]] * count)  # 2 mm.
        numbers = self.folder / "numbers.json"
        self.run_well("adapt", mesh, "-m", sizes, "--image", image, "--json", numbers, "-o", self.out)
        (volume,) = json.loads(numbers.read_text())["volumes"]
        self.assertLess(abs(volume["change_percent"]), 0.1)
        self.run_well("evaluate", self.out, "--image", image, "--json", numbers)
        ball = json.loads(numbers.read_text())["labels"][0]
        self.assertAlmostEqual(volume["after_mm3"], ball["volume_mm3"], places=6)
        self.assertAlmostEqual(volume["before_mm3"], self.evaluate(mesh)["volume_mm3"], places=6)
        self.assertLess(abs(ball["volume_error_percent"]), 2)
        self.assertLess(ball["hausdorff_mm"]["mesh_to_image"]["max"], 1)
        self.out.unlink()
        alike = self.folder / "alike.nrrd"
        self.run_well("phantom", "sphere", "--size", 32, 32, 32, "--radius", 11, "--noise", 0.5, "-o", alike)
        warned = self.run_well("adapt", mesh, "-m", sizes, "--image", alike, "-o", self.out)
        self.assertIn("alike.nrrd: is not the file that", warned.stderr)
        self.out.unlink()
        other = self.folder / "other.nrrd"
        self.run_well("phantom", "sphere", "--size", 32, 32, 32, "--radius", 7, "-o", other)
        refused = self.run_lumesh("adapt", mesh, "-m", sizes, "--image", other, "-o", self.out)
        self.assert_refused(refused, BAD_INPUT, "other.nrrd", "off its boundary")
        self.assert_refused(self.run_lumesh("adapt", mesh, "-m", sizes, "--labels", 1, "-o", self.out), USAGE, "--image")
        self.assert_refused(self.run_lumesh("adapt", mesh, "-m", sizes, "--image", image, "--sref", 0, "-o", self.out), USAGE,
                            "--image")

    def test_what_cannot_be_adapted_is_refused(self):
        adapt = ("adapt", self.cube, "-o", self.out)
        self.assert_refused(self.run_lumesh(*adapt), BAD_INPUT, "cube.mesh", "no metric", "lumesh metric")
        self.assert_refused(self.run_lumesh(*adapt, "--analytic", "linear", "--complexity", "1e12"), MEMORY,
                            "tetrahedra", "GB", "complexity of")
        self.assert_refused(self.run_lumesh(*adapt, "--analytic", "cubic"), USAGE, "cubic")
        self.assert_refused(self.run_lumesh(*adapt, "--analytic", "linear", "--feature-angle", 0), USAGE, "--feature-angle")
        self.assert_refused(self.run_lumesh(*adapt, "--analytic", "linear", "--collapse-below", 7), USAGE, "--collapse-below")
        for option in ("--execution", "--balance", "--topology"):
            self.assert_refused(self.run_lumesh(*adapt, "--analytic", "linear", option, "eager"), USAGE, "eager")
        self.assert_refused(self.run_lumesh("adapt", self.folder / "none.mesh", "-o", self.out), BAD_INPUT, "none.mesh")

    def test_bad_tensors_are_refused(self):
        sol = self.folder / "bad.sol"
        good = (100, 0, 100, 0, 0, 100)
        for bad in ((100, 0, 100, 0, 0, 0), (100, 0, -100, 0, 0, 100), (1, 2, 1, 0, 0, 1), ("nan", 0, 1, 0, 0, 1),
                    ("inf", 0, 1, 0, 0, 1)):
            with self.subTest(bad):
                write_sol(sol, [good] * 10 + [bad] + [good] * 53)
                self.assert_refused(self.run_lumesh("adapt", self.cube, "-m", sol, "-o", self.out), BAD_INPUT, "bad.sol")
        write_sol(sol, [good] * 12)
        self.assert_refused(self.run_lumesh("adapt", self.cube, "-m", sol, "-o", self.out), BAD_INPUT, "12", "64")

    def test_broken_meshes_are_refused(self):
        text = self.cube.read_text(encoding="ascii")
        lines = text.splitlines()
        first = lines.index("Tetrahedra") + 2
        a, b, *rest = lines[first].split()
        inverted = self.folder / "inverted.mesh"
        inverted.write_text("\n".join([*lines[:first], " ".join([b, a, *rest]), *lines[first + 1:]]), encoding="ascii")
        self.assert_refused(self.run_lumesh("adapt", inverted, "--analytic", "linear", "-o", self.out), BAD_INPUT,
                            "inverted.mesh")
        surface = self.folder / "surface.mesh"
        at = text.index("Tetrahedra")
        surface.write_text(text[:at] + "End\n", encoding="ascii")
        self.assert_refused(self.run_lumesh("adapt", surface, "--analytic", "linear", "-o", self.out), BAD_INPUT,
                            "surface.mesh")


if __name__ == "__main__":
    unittest.main(verbosity=2)
