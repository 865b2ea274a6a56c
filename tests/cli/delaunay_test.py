#!/usr/bin/env python3
"""`lumesh delaunay`: what its options do to the mesh of a small ball, surfaces as input, and what it refuses.

Usage: delaunay_test.py LUMESH PLUGINS      PLUGINS: the folder of the plugins that the build of the tests makes.
Exit codes of lumesh: 1 usage, 2 bad input.
"""
import json
import math
import pathlib
import random
import statistics
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import nrrd
from cube import cube, read_medit, write_medit, write_sol
from program import BAD_INPUT, USAGE, MeshTest

PLUGINS = pathlib.Path(sys.argv.pop(1)).resolve()
SIZE, RADIUS = 24, 8  # Voxels of 1 mm.
MIDDLE = (SIZE - 1) / 2
DELTA = 2.5


def mean_edge(mesh, holds):
    """Of the tetrahedra whose centre and label fit."""
    points, tetrahedra, _ = mesh
    lengths = []
    for *corners, label in tetrahedra:
        at = [points[v - 1] for v in corners]
        if holds([sum(p[k] for p in at) / 4 for k in range(3)], label):
            lengths += [math.dist(at[i], at[j]) for i in range(4) for j in range(i)]
    return statistics.fmean(lengths)


def lower(centre, _):
    return centre[0] < MIDDLE - 3


def upper(centre, _):
    return centre[0] > MIDDLE + 3


def lumps(sizes, spacing, labels=5, count=36, seed=2):
    """Voxels of lumps around random places, i fastest; they fill the image, and meet its border everywhere."""
    draw = random.Random(seed)
    middles = [[draw.uniform(0, n * s) for n, s in zip(sizes, spacing)] for _ in range(count)]
    return [min((math.dist(m, (i * spacing[0], j * spacing[1], k * spacing[2])), n) for n, m in enumerate(middles))[1]
            % (labels + 1) for k in range(sizes[2]) for j in range(sizes[1]) for i in range(sizes[0])]


def polyhedron_volume(triangles):
    return sum(a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
               for a, b, c in triangles) / 6


def sphere(radius, rings=24):
    """Triangles of a ball by latitudes and longitudes, turned outwards."""
    def at(i, j):
        if i in (0, rings):
            return (0.0, 0.0, radius if i == 0 else -radius)
        polar, turn = math.pi * i / rings, math.pi * (j % (2 * rings)) / rings
        across = radius * math.sin(polar)
        return (across * math.cos(turn), across * math.sin(turn), radius * math.cos(polar))

    triangles = []
    for i in range(rings):
        for j in range(2 * rings):
            a, b, c, d = at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)
            triangles += [(a, b, c)] if i < rings - 1 else []
            triangles += [(a, c, d)] if i > 0 else []
    return triangles


def write_stl(path, triangles):
    facets = "".join("facet normal 0 0 0\nouter loop\n" + "".join(f"vertex {x!r} {y!r} {z!r}\n" for x, y, z in t) +
                     "endloop\nendfacet\n" for t in triangles)
    path.write_text(f"solid s\n{facets}endsolid s\n", encoding="ascii")
    return path


class DelaunayTest(MeshTest):
    def setUp(self):
        super().setUp()
        self.out = self.folder / "out.mesh"
        self.ball = nrrd.write(self.folder / "ball.nrrd", [SIZE] * 3, nrrd.ball(SIZE, RADIUS))

    def mesh(self, *options, source=None, delta=DELTA):
        """With what is written on stderr as `said`."""
        self.said = self.run_well("delaunay", source or self.ball, "-o", self.out, "--delta", delta, *options).stderr
        return read_medit(self.out)

    def refused(self, code, *words, options=(), source=None, delta=DELTA):
        self.out.unlink(missing_ok=True)
        result = self.run_lumesh("delaunay", source or self.ball, "-o", self.out, "--delta", delta, *options)
        self.assert_refused(result, code, *words)

    def assert_finer_below(self, mesh, factor):
        self.assertLess(mean_edge(mesh, lower), factor * mean_edge(mesh, upper))


class MeshesTest(DelaunayTest):
    def test_every_seeding_fills_the_ball(self):
        for seeding in ("lattice", "surface", "few"):
            with self.subTest(seeding):
                self.mesh("--seeding", seeding)
                numbers = self.evaluate(self.out)
                self.assertTrue(numbers["valid"])
                self.assertAlmostEqual(numbers["labels"][0]["volume_mm3"] / (4 / 3 * math.pi * RADIUS ** 3), 1, delta=0.05)

    def test_no_vertex_lies_beyond_the_border_of_the_image(self):
        sizes = (14, 10, 9)
        for spacing, options in (((3, 2, 0.2), ("--no-improve",)), ((2.4, 1.6, 0.24), ())):
            image = nrrd.write(self.folder / "lumps.nrrd", sizes, lumps(sizes, spacing), spacing)
            said = self.run_well("delaunay", image, "-o", self.out, *options).stderr
            beyond = max(abs(p[d] / spacing[d] - (sizes[d] - 1) / 2) - sizes[d] / 2
                         for p in read_medit(self.out)[0] for d in range(3))
            little = 0.01 * math.prod(spacing) ** (1 / 3) / min(spacing)  # Of the resolution, in voxels.
            self.assertLess(beyond, 5 * little, (spacing, options))
            self.assertTrue(beyond <= little or "beyond the image's border" in said, (spacing, options, beyond))

    def test_seedings_begin_with_points_inside_on_surfaces_or_few_of_them(self):
        seeds = {}
        report = self.folder / "report.json"
        for seeding in ("lattice", "surface", "few"):
            # Finer than a 20th of the ball: so far apart are few points.
            self.mesh("--seeding", seeding, "--size", 3, "--no-improve", "--json", report, delta=0.7)
            seeds[seeding] = json.loads(report.read_text(encoding="utf-8"))["seeds"]
        self.assertGreater(seeds["lattice"]["inside"], 0)
        self.assertEqual([seeds[s]["inside"] for s in ("surface", "few")], [0, 0])
        self.assertEqual(seeds["surface"]["boundary"], seeds["lattice"]["boundary"])
        self.assertLess(seeds["few"]["boundary"], 0.8 * seeds["surface"]["boundary"])

    def test_refinement_is_the_same_for_every_execution_and_number_of_threads(self):
        points = self.folder / "points.xyz"
        points.write_text(f"{MIDDLE - RADIUS} {MIDDLE} {MIDDLE}\n", encoding="ascii")
        options = ("--size-points", points, "--size-floor", 0.8, "--size-factor", 0.5, "--no-improve")
        first = self.mesh(*options, "--threads", 1)
        for execution in ("ordered", "speculative"):
            for threads in (1, 2, 8):
                with self.subTest(execution=execution, threads=threads):
                    self.assertEqual(self.mesh(*options, "--threads", threads, "--execution", execution), first)

    def test_ordered_improvement_is_the_same_for_every_number_of_threads(self):
        files = []
        for threads in (1, 2, 8):
            path = self.folder / f"{threads}.meshb"
            self.run_well("delaunay", self.ball, "-o", path, "--delta", DELTA, "--label-size", "1=1.8", "--threads", threads)
            files.append(path.read_bytes())
        self.assertEqual(files[1:], files[:1] * 2)

    def test_many_threads_that_try_and_give_way_come_to_an_end(self):
        self.mesh("--execution", "speculative", "--threads", 256)
        self.assertTrue(self.evaluate(self.out)["valid"])


class SizesTest(DelaunayTest):
    def test_labels_have_sizes_of_their_own(self):
        halves = [(1 if n % SIZE < SIZE / 2 else 2) * v for n, v in enumerate(nrrd.ball(SIZE, RADIUS))]
        image = nrrd.write(self.folder / "halves.nrrd", [SIZE] * 3, halves)
        # Away from the interface, whose edges fit the finer label.
        self.assert_finer_below(self.mesh("--label-size", "1=1", "--label-size", "2=2.2", "--no-improve", source=image), 0.6)
        self.refused(BAD_INPUT, "halves.nrrd", "label 7", "1, 2", source=image, options=("--label-size", "7=1"))
        self.refused(BAD_INPUT, "label 0", source=image, options=("--label-size", "0=1"))
        self.refused(BAD_INPUT, "label 2", source=image, options=("--labels", 1, "--label-size", "2=1"))
        for text in ("1", "1=", "=1", "1=x", "x=1", "1=0", "1=-1", "1=nan", "1=inf", "1=1=1"):
            self.refused(USAGE, "--label-size", f'"{text}"', options=("--label-size", text))
        self.refused(USAGE, "given twice", options=("--label-size", "1=1", "--label-size", "1=2"))

    def test_points_of_every_kind_of_file_make_the_mesh_finer_around_them(self):
        x, y, z = MIDDLE - RADIUS, MIDDLE, MIDDLE
        files = {
            "plain.xyz": f"# landmarks\n\n{x} {y} {z} 0.5\n",
            "named.csv": f'"radius","Points:2","Points:0","Points:1"\n0.5,{z},{x},{y}\n',
            "poly.vtk": f"# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 1 float\n{x} {y} {z}\n"
                        "VERTICES 1 2\n1 0\n",
            "lines.vtp": '<VTKFile type="PolyData"><PolyData><Piece NumberOfPoints="1" NumberOfLines="0"><Points><DataArray '
                         f'type="Float64" NumberOfComponents="3" format="ascii">{x} {y} {z}</DataArray></Points></Piece>'
                         "</PolyData></VTKFile>",
        }
        options = ("--size-factor", 0.4, "--size-floor", 0.8, "--size-ceiling", 3, "--no-improve")
        meshes = []
        for name, text in files.items():
            (self.folder / name).write_text(text, encoding="ascii")
            meshes.append(self.mesh("--size-points", self.folder / name, *options))
        self.assert_finer_below(meshes[0], 0.7)
        self.assertEqual(meshes[1:], meshes[:1] * 3)

    def test_the_mean_distance_to_points_needs_no_floor(self):
        line = self.folder / "line.xyz"
        line.write_text("".join(f"{MIDDLE - RADIUS} {MIDDLE} {MIDDLE + 0.1 * i}\n" for i in range(-20, 20)), encoding="ascii")
        self.assert_finer_below(self.mesh("--size-points", line, "--size-k", 30, "--no-improve"), 0.7)
        self.refused(BAD_INPUT, "line.xyz", "40 different points", "41", options=("--size-points", line, "--size-k", 41))
        self.refused(USAGE, "--size-k", options=("--size-points", line, "--size-k", 0, "--size-floor", 1))
        self.refused(USAGE, "--size-floor", "--size-k", options=("--size-points", line, "--size-factor", 2))

    def test_a_metric_of_aspect_1_and_an_isotropic_one_are_sizes_of_a_mesh(self):
        line, metric = self.folder / "line.xyz", self.folder / "metric.vtu"
        line.write_text("".join(f"{MIDDLE - RADIUS} {MIDDLE} {MIDDLE + 0.1 * i}\n" for i in range(-20, 20)), encoding="ascii")
        self.mesh("--no-improve", delta=1)
        self.run_well("convert", self.out, self.folder / "fine.mesh")
        for options in (("--max-aspect", 1, "--min-size", 1.2), ("--isotropic", "--k", 30)):
            self.run_well("metric", self.folder / "fine.mesh", "--points", line, *options, "-o", metric)
            coarse = self.mesh("--no-improve", delta=3)
            with self.subTest(options=options):
                self.assertGreater(len(self.mesh("--size-mesh", metric, "--no-improve", delta=3)[1]), 1.5 * len(coarse[1]))
        self.run_well("metric", self.folder / "fine.mesh", "--points", line, "-o", metric)
        self.refused(BAD_INPUT, "metric.vtu", "stretched", options=("--size-mesh", metric))

    def test_points_that_are_none_are_refused(self):
        for name, text, words in (("none.csv", "x,y,z\n", ["holds no points"]), ("two.xyz", "1 2 3\n1 2\n", ["line 2"]),
                                  ("words.txt", "1 2 3\na b c\n", ["line 2"]), ("nan.xyz", "1 nan 3\n", ["line 1"]),
                                  ("points.pdf", "1 2 3\n", ["unknown format"]), ("cut.vtp", "<VTKFile", [])):
            with self.subTest(name):
                (self.folder / name).write_text(text, encoding="ascii")
                self.refused(BAD_INPUT, name, *words, options=("--size-points", self.folder / name, "--size-floor", 1))
        missing = self.folder / "missing.vtp"
        self.refused(BAD_INPUT, "missing.vtp", "no such file", options=("--size-points", missing, "--size-floor", 1))
        self.refused(USAGE, "--size-floor", options=("--size-points", missing, "--size-factor", 2))
        self.refused(USAGE, "--size-points", options=("--size-factor", 2))
        self.refused(USAGE, "--size-ceiling",
                     options=("--size-points", missing, "--size-floor", 2, "--size-ceiling", 1))

    def test_sizes_grow_from_the_boundary(self):
        mesh = self.mesh("--size-boundary", 1, "--size-growth", 0.5, "--size", 5, "--no-improve")
        depth = lambda at: RADIUS - math.dist(at, [MIDDLE] * 3)
        near = mean_edge(mesh, lambda at, _: depth(at) < 2)
        far = mean_edge(mesh, lambda at, _: depth(at) > 4)
        self.assertLess(near, 0.7 * far)
        self.refused(USAGE, "--size-boundary", options=("--size-boundary", 0))
        self.refused(USAGE, "--size-growth", options=("--size-boundary", 1, "--size-growth", -1))
        self.refused(USAGE, "--size-boundary", options=("--size-growth", 1))

    def test_an_image_of_sizes(self):
        values = [1.0 if n % SIZE < SIZE / 2 else 0.0 for n in range(SIZE ** 3)]
        sizes = nrrd.write(self.folder / "sizes.nrrd", [SIZE] * 3, values, kind="float")
        self.assert_finer_below(self.mesh("--size-image", sizes, "--no-improve"), 0.6)
        bad = nrrd.write(self.folder / "bad.nrrd", [SIZE] * 3, [-1.0] + values[1:], kind="float")
        self.refused(BAD_INPUT, "bad.nrrd", "(0, 0, 0)", options=("--size-image", bad))
        self.refused(BAD_INPUT, "none.nrrd", options=("--size-image", self.folder / "none.nrrd"))

    def test_a_mesh_of_sizes(self):
        points, tetrahedra, triangles = cube(3)
        points = [tuple(SIZE * c for c in p) for p in points]
        sizes = [1.0 if p[0] < MIDDLE else 2.5 for p in points]
        medit = self.folder / "sizes.mesh"
        write_medit(medit, points, tetrahedra, triangles)
        self.refused(BAD_INPUT, "sizes.mesh", "no sizes", options=("--size-mesh", medit))
        write_sol(self.folder / "sizes.sol", [[s ** -2, 0, s ** -2, 0, 0, s ** -2] for s in sizes])
        first = self.mesh("--size-mesh", medit, "--no-improve")
        self.assert_finer_below(first, 0.8)

        def grid(values):
            cells = "".join("4 " + " ".join(str(v - 1) for v in t[:4]) + "\n" for t in tetrahedra)
            count = len(tetrahedra)
            return (f"# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {len(points)} double\n" +
                    "".join(f"{x} {y} {z}\n" for x, y, z in points) +
                    f"CELLS {count} {5 * count}\n{cells}CELL_TYPES {count}\n" +
                    "10\n" * count + f"POINT_DATA {len(points)}\nSCALARS size double 1\nLOOKUP_TABLE default\n" +
                    "\n".join(map(str, values)) + "\n")

        legacy = self.folder / "sizes.vtk"
        legacy.write_text(grid(sizes), encoding="ascii")
        self.assert_finer_below(self.mesh("--size-mesh", legacy, "--no-improve"), 0.8)
        legacy.write_text(grid([0.0] + sizes[1:]), encoding="ascii")
        self.refused(BAD_INPUT, "sizes.vtk", "vertex 0", options=("--size-mesh", legacy))
        write_sol(self.folder / "sizes.sol", [[1, 0, 1, 0, 0, 9]] * len(points))
        self.refused(BAD_INPUT, "sizes.sol", "stretched", options=("--size-mesh", medit))

    def test_the_smallest_of_several_counts(self):
        both = self.mesh("--label-size", "1=1.2", "--size-boundary", 2.5)
        self.assertEqual(len(both[1]), len(self.mesh("--label-size", "1=1.2")[1]))


def elements_to_adapt(mesh, landmarks, adapt_const):
    """Algorithm 3 of the paper, word for word: the elements of which it returns true."""
    points, tetrahedra, _ = mesh
    diag = [1 / min(math.dist(p, mark) for mark in landmarks) ** 2 for p in points]
    return [corners for *corners, _ in tetrahedra
            if any(math.sqrt((diag[a - 1] + diag[b - 1]) / 2) * math.dist(points[a - 1], points[b - 1]) > adapt_const
                   for i, a in enumerate(corners) for b in corners[:i])]


class CriterionTest(DelaunayTest):
    """Landmarks along the middle of a ball."""

    def setUp(self):
        super().setUp()
        self.marks = [(MIDDLE - 3 + 0.11 * i, MIDDLE + 0.2, MIDDLE - 0.3) for i in range(56)]
        self.points = self.folder / "landmarks.xyz"
        self.points.write_text("".join(f"{x} {y} {z}\n" for x, y, z in self.marks), encoding="ascii")

    def test_points_without_sizes_have_the_papers_criterion_which_improvement_keeps(self):
        coarse, asked = self.mesh("--size", 6), ("--size", 6, "--size-points", self.points)
        refined = self.mesh(*asked, "--no-improve")
        self.assertEqual(self.said, "")
        self.assertEqual(self.mesh(*asked, "--adapt-const", 2, "--no-improve"), refined)
        improved = self.mesh(*asked)
        self.assertEqual(self.said, "")
        self.assertGreater(len(elements_to_adapt(coarse, self.marks, 2)), 50)
        self.assertGreater(len(improved[1]), 1.5 * len(coarse[1]))
        self.assertEqual(elements_to_adapt(refined, self.marks, 2), [])
        self.assertEqual(elements_to_adapt(improved, self.marks, 2), [])

    def test_what_has_no_end_is_told_once_and_bounded(self):
        self.mesh("--size-points", self.points, "--adapt-const", 1.5, "--no-improve")
        self.assertEqual(self.said.count("warning"), 1, self.said)
        self.assertRegex(self.said, "--adapt-const 1.5 .*--size-floor")
        self.mesh("--size-points", self.points, "--adapt-const", 1.5, "--size-floor", 1, "--no-improve")
        self.assertEqual(self.said, "")
        self.refused(USAGE, "--size-factor", options=("--size-points", self.points, "--adapt-const", 2, "--size-factor", 1,
                                                      "--size-floor", 1))
        self.refused(USAGE, "--size-points", options=("--adapt-const", 2))

    def test_the_example_plugin_makes_the_same_mesh(self):
        text = self.folder / "landmarks.txt"
        text.write_bytes(self.points.read_bytes())
        plugin = f"{PLUGINS / 'landmark_sizing.so'}:{text}"
        for options, of_plugin in ((), ""), (("--adapt-const", 3, "--size-floor", 1), ",adapt_const=3,floor=1"):
            with self.subTest(of_plugin):
                built_in = self.mesh("--size", 6, "--size-points", self.points, *options)
                self.assertEqual(self.mesh("--size", 6, "--sizing", plugin + of_plugin), built_in)


class PluginsTest(DelaunayTest):
    def test_the_example_refines_around_landmarks(self):
        landmarks = self.folder / "landmarks.txt"
        landmarks.write_text(f"{MIDDLE - RADIUS} {MIDDLE} {MIDDLE}\n", encoding="ascii")
        plugin = f"{PLUGINS / 'landmark_sizing.so'}:{landmarks},adapt_const=0.5,floor=0.8"
        mesh = self.mesh("--sizing", plugin, "--no-improve")
        self.assertEqual(self.said, "")
        self.assert_finer_below(mesh, 0.7)
        self.assertEqual(self.mesh("--sizing", plugin, "--no-improve", "--threads", 8), mesh)

    def test_answers_that_make_no_sense_are_told_afterwards(self):
        self.mesh("--sizing", PLUGINS / "not_a_number.so", source=write_stl(self.folder / "ball.stl", sphere(2)), delta=0.8)
        self.assertRegex(self.said, "lumesh: warning: .*not_a_number.so")

    def test_bad_plugins_are_refused(self):
        not_a_library = self.folder / "text.so"
        not_a_library.write_text("hello", encoding="ascii")
        for plugin, *words in ((self.folder / "none.so", "none.so", "no such file"), (not_a_library, "text.so"),
                               (PLUGINS / "no_version.so", "lumesh_sizing_abi_version"),
                               (PLUGINS / "other_version.so", "version 2"), (PLUGINS / "no_functions.so", "lumesh_size_at"),
                               (f"{PLUGINS / 'good.so'}:-1", "refused its options")):
            with self.subTest(str(plugin)):
                self.out.unlink(missing_ok=True)
                result = self.run_lumesh("delaunay", self.ball, "-o", self.out, "--delta", DELTA, "--sizing", plugin)
                self.assertEqual(result.returncode, BAD_INPUT, result.stderr)
                self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
                for word in words:
                    self.assertIn(word, result.stderr)
                self.assertFalse(self.out.exists())


class SurfacesTest(DelaunayTest):
    def test_a_ball_of_triangles_keeps_its_volume(self):
        triangles = sphere(RADIUS)
        stl = write_stl(self.folder / "ball.stl", triangles)
        self.mesh(source=stl, delta=1.5)
        numbers = self.evaluate(self.out)
        self.assertTrue(numbers["valid"])
        self.assertAlmostEqual(numbers["labels"][0]["volume_mm3"] / polyhedron_volume(triangles), 1, delta=0.02)

    def test_openings_stand_in_the_json(self):
        image, numbers = self.folder / "carotid.nrrd", self.folder / "numbers.json"
        self.run_well("phantom", "carotid", "--size", 100, 100, 100, "-o", image)
        self.run_well("delaunay", image, "-o", self.out, "--json", numbers)
        told = {o["patches"]: o for o in json.loads(numbers.read_text())["openings"]}
        patches = {p["name"] for p in json.loads(self.run_well("info", self.out, "--json").stdout)["patches"]}
        self.assertEqual(set(told), patches - {"wall"})
        for opening in told.values():
            self.assertLess(abs(opening["change_percent"]), 5)

    def test_sharp_edges_are_kept_from_the_feature_angle_on(self):
        points, _, faces = cube(4)
        triangles = [[points[v - 1] for v in face[:3]] for face in faces]
        stl = write_stl(self.folder / "cube.stl", triangles)
        self.mesh(source=stl, delta=0.2)
        sharp = self.evaluate(self.out)["labels"][0]["volume_mm3"]
        self.assertAlmostEqual(sharp, 1, delta=1e-6)
        self.mesh("--feature-angle", 100, source=stl, delta=0.2)
        self.assertLess(self.evaluate(self.out)["labels"][0]["volume_mm3"], sharp - 1e-4)

    def test_surfaces_that_are_broken_are_refused(self):
        triangles = sphere(RADIUS, 6)
        self.refused(BAD_INPUT, "open.stl", "not closed", options=("--keep-open",),
                     source=write_stl(self.folder / "open.stl", triangles[1:]))
        fin = (triangles[0][0], triangles[0][1], (9, 9, 9))
        self.refused(BAD_INPUT, "three.stl", "manifold", source=write_stl(self.folder / "three.stl", triangles + [fin]))
        cut = self.folder / "cut.stl"
        cut.write_text("solid s\nfacet normal 0 0 0\nouter loop\nvertex 1 2", encoding="ascii")
        self.refused(BAD_INPUT, "cut.stl", source=cut)
        volume = self.folder / "volume.mesh"
        write_medit(volume, *cube(2))
        self.refused(BAD_INPUT, "volume.mesh", "volume", source=volume)
        self.refused(BAD_INPUT, "none.stl", "no such file", source=self.folder / "none.stl")

    def test_options_of_images_do_not_suit_surfaces_and_the_other_way_round(self):
        stl = write_stl(self.folder / "ball.stl", sphere(RADIUS, 6))
        for options in (("--labels", 1), ("--threshold", 1), ("--largest-component",), ("--boundary", "exact")):
            self.refused(USAGE, options[0], "ball.stl", source=stl, options=options)
        self.refused(USAGE, "--feature-angle", "ball.nrrd", options=("--feature-angle", 30))
        self.refused(USAGE, "--feature-angle", source=stl, options=("--feature-angle", 0))


class RefusalsTest(DelaunayTest):
    def test_a_delta_that_makes_no_sense_is_refused(self):
        stl = write_stl(self.folder / "ball.stl", sphere(RADIUS, 6))
        for delta in (0, -1, "nan", "inf"):
            with self.subTest(delta):
                self.refused(USAGE, "delta", delta=delta)
        self.refused(BAD_INPUT, "ball.nrrd", "larger than the object", delta=100)
        self.refused(BAD_INPUT, "ball.stl", "larger than the object", delta=100, source=stl)
        self.assert_refused(self.run_lumesh("delaunay", self.ball, "-o", self.out, "--edge-length", 100), BAD_INPUT,
                            "ball.nrrd: the edge length (100 mm) is larger than the object")
        self.refused(USAGE, "--seeding", options=("--seeding", "none"))

    def test_an_input_is_never_replaced_by_an_output(self):
        points = self.folder / "points.csv"
        points.write_text("0,0,0\n", encoding="ascii")
        kept = [self.ball.read_bytes(), points.read_bytes()]
        for options in (("--json", self.ball), ("--json", f"{self.folder}/./{self.ball.name}"),
                        ("--size-points", points, "--size-floor", 1, "--json", points)):
            with self.subTest(options=options):
                self.refused(USAGE, "replaced", options=options)
                self.assertEqual(kept, [self.ball.read_bytes(), points.read_bytes()])

    def test_the_name_of_the_surface_is_looked_at_before_meshing(self):
        self.refused(USAGE, "surface.obj", ".vtp", options=("--surface", self.folder / "surface.obj"))
        self.mesh("--surface", self.folder / "SURFACE.STL")

    def test_a_mesh_that_is_there_stays_when_the_input_is_bad(self):
        self.mesh()
        before = self.out.read_bytes()
        for options in (("--delta", 100), ("--delta", DELTA, "--sizing", self.folder / "none.so"),
                        ("--delta", DELTA, "--label-size", "7=1")):
            result = self.run_lumesh("delaunay", self.ball, "-o", self.out, *options)
            self.assertEqual(result.returncode, BAD_INPUT, result.stderr)
            self.assertEqual(self.out.read_bytes(), before)


if __name__ == "__main__":
    unittest.main(verbosity=2)
