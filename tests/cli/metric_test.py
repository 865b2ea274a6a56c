"""Of the command metric: metrics made of data."""
import math
import pathlib
import re
import unittest

from cube import cube, write_medit, write_sol
from program import BAD_INPUT, USAGE, MeshTest


def read_sol(path):
    """Tensors as xx xy yy xz yz zz."""
    lines = pathlib.Path(path).read_text(encoding="ascii").split("\n")
    first = lines.index("SolAtVertices") + 3
    return [tuple(map(float, line.split())) for line in lines[first:first + int(lines[first - 2])]]


class MetricCommandTest(MeshTest):
    def setUp(self):
        super().setUp()
        self.points, tetrahedra, triangles = cube(4)
        self.cube = self.folder / "cube.mesh"
        write_medit(self.cube, self.points, tetrahedra, triangles)
        self.sol = self.folder / "out.sol"

    def write_csv(self, rows, name="points.csv"):
        path = self.folder / name
        path.write_text("".join(",".join(map(str, row)) + "\n" for row in rows), encoding="ascii")
        return path

    def tensors(self, *options):
        self.run_well("metric", self.cube, "-o", self.sol, *options)
        return read_sol(self.sol)

    def refused(self, code, *options_and_words):
        """What stands behind None are words of the message."""
        split = options_and_words.index(None)
        result = self.run_lumesh("metric", self.cube, "-o", self.out, *options_and_words[:split])
        self.assert_refused(result, code, *options_and_words[split + 1:])


class OfferedTest(MetricCommandTest):
    """What the help offers of cases and images can be meant, or is refused with a way."""

    def test_the_flow_of_a_phantom_is_that_of_a_case(self):
        self.refused(USAGE, "--velocity", "phantom", None, "only a case", "by --velocity FILE")

    def test_all_frames_are_not_offered_where_one_is_needed(self):
        self.assertNotIn("--all-frames", self.run_well("metric", "--help").stdout)

    def test_defaults_name_no_option_in_another_spelling(self):
        self.assertIn("as the edges per radius say", self.run_well("metric", "--help").stdout)


class PointsTest(MetricCommandTest):
    def setUp(self):
        super().setUp()
        self.line = self.write_csv([(0.5, 0.5, 0.02 * i) for i in range(50)])

    def test_a_line_of_points_stretches_along_itself(self):
        for xx, xy, yy, xz, yz, zz in self.tensors("--points", self.line, "--k", 11):
            for value, size in ((xx, 0.02), (yy, 0.02), (zz, 0.1)):
                self.assertAlmostEqual(value * size ** 2, 1)
            self.assertLess(abs(xy) + abs(xz) + abs(yz), 1e-6)

    def test_isotropic_sizes_are_the_mean_distance_to_the_points(self):
        ring = self.write_csv([(0.5 + 0.3 * math.cos(math.pi * i / 15), 0.5 + 0.3 * math.sin(math.pi * i / 15), 0) for i in range(30)])
        tensors = self.tensors("--points", ring, "--k", 30, "--isotropic", "--gradation", 1e6)
        size = dict(zip(self.points, ((xx, yy, zz) for xx, _, yy, _, _, zz in tensors)))
        for height in (0, 0.25, 0.5, 1):  # On the axis of the ring all of its points are equally far.
            for value in size[0.5, 0.5, height]:
                self.assertAlmostEqual(1 / math.sqrt(value), math.hypot(0.3, height), places=6)

    def test_an_aspect_of_1_is_the_same_in_all_directions(self):
        for xx, xy, yy, xz, yz, zz in self.tensors("--points", self.line, "--max-aspect", 1):
            self.assertAlmostEqual(xx / yy, 1)
            self.assertAlmostEqual(xx / zz, 1)
            self.assertLess(abs(xy) + abs(xz) + abs(yz), 1e-9 * xx)

    def test_aspect_complexity_and_growth_hold_together(self):
        result = self.run_well("metric", self.cube, "--points", self.line, "--max-aspect", 3, "--gradation", 1.3,
                               "--complexity", 2000, "-o", self.sol)
        self.assertAlmostEqual(float(re.search(r"complexity (\S+)", result.stdout)[1]) / 2000, 1, delta=0.002)
        for xx, _, _, _, _, zz in read_sol(self.sol):
            self.assertAlmostEqual(math.sqrt(xx / zz), 3)

    def test_points_and_tensors_are_intersected(self):
        sizes = self.folder / "sizes.sol"
        write_sol(sizes, [[0.05 ** -2, 0, 0.05 ** -2, 0, 0, 0.05 ** -2] for _ in self.points])
        for xx, _, _, _, _, zz in self.tensors("--points", self.line, "--k", 11, "-m", sizes):
            self.assertAlmostEqual(xx * 0.02 ** 2, 1)
            self.assertAlmostEqual(zz * 0.05 ** 2, 1)

    def test_the_order_of_points_and_the_threads_do_not_matter(self):
        first = self.tensors("--points", self.line)
        turned = self.write_csv([(0.5, 0.5, 0.02 * i) for i in reversed(range(50))], "turned.csv")
        self.assertEqual(self.tensors("--points", turned, "--threads", 1), first)

    def test_bad_points_are_refused(self):
        empty, one = self.write_csv([], "empty.csv"), self.write_csv([(0, 0, 0)] * 60, "one.csv")
        few = self.write_csv([(0.1 * i, 0, 0) for i in range(9)], "few.csv")
        far = self.write_csv([(0.5, 0.5, 20 + i) for i in range(50)], "far.csv")
        broken = self.write_csv([(0, 0, 0), ("nan", 0, 0)], "broken.csv")
        self.refused(BAD_INPUT, "--points", empty, None, "empty.csv", "no points")
        self.refused(BAD_INPUT, "--points", one, None, "one.csv", "one place")
        self.refused(BAD_INPUT, "--points", few, None, "few.csv", "9 different points", "40")
        self.refused(BAD_INPUT, "--points", far, None, "far.csv", "far", "(0.5, 0.5, 20) to (0.5, 0.5, 69)", "(0, 0, 0) to (1, 1, 1)")
        self.refused(BAD_INPUT, "--points", broken, None, "broken.csv", "line 2")
        self.refused(BAD_INPUT, "--points", self.folder / "none.csv", None, "none.csv", "no such file")

    def test_options_that_contradict_are_refused(self):
        self.refused(BAD_INPUT, "--points", self.line, "--min-size", 2, "--max-size", 1, None, "--min-size 2", "--max-size 1")
        self.refused(USAGE, "--points", self.line, "--max-aspect", 0.5, None, "--max-aspect")
        self.refused(USAGE, "--points", self.line, "--k", 0, None, "--k")
        self.refused(USAGE, "--k", 20, None, "--k")


class VelocityTest(MetricCommandTest):
    """A flow along x that shears in z."""

    def setUp(self):
        super().setUp()
        n = 7
        self.places = [(i / n, j / n, k / n) for k in range(n + 1) for j in range(n + 1) for i in range(n + 1)]

    def write_flow(self, flow, names=("u", "v", "w"), name="flow.csv"):
        return self.write_csv([("x", "y", "z", *names), *((*p, *flow(*p)) for p in self.places)], name)

    def test_shear_is_long_along_the_flow_and_thin_along_the_gradient(self):
        shear = self.write_flow(lambda x, y, z: (2 + z, 0, 0))
        for xx, xy, yy, xz, yz, zz in self.tensors("--velocity", shear, "--velocity-stretch", 20, "--velocity-flatness", 3):
            self.assertAlmostEqual(math.sqrt(zz / xx), 20, delta=0.2)
            self.assertAlmostEqual(math.sqrt(zz / yy), 3, delta=0.05)
            self.assertLess(abs(xy) + abs(xz) + abs(yz), 1e-3 * zz)

    def test_sizes_are_those_across_which_the_velocity_changes_by_a_share(self):
        shear = self.write_flow(lambda x, y, z: (2 + z, 0, 0))
        speed = math.sqrt(sum((2 + z) ** 2 for _, _, z in self.places) / len(self.places))
        for *_, zz in self.tensors("--velocity", shear, "--velocity-change", 0.05):
            self.assertAlmostEqual(1 / math.sqrt(zz) / (0.05 * speed), 1, delta=0.01)

    def test_no_flow_and_a_constant_one_are_round(self):
        for speed in (0, 3):
            flow = self.write_flow(lambda x, y, z, speed=speed: (0, speed, 0))
            for k in (3, 20):
                for xx, _, yy, _, _, zz in self.tensors("--velocity", flow, "--velocity-k", k):
                    self.assertAlmostEqual(xx / yy, 1)
                    self.assertAlmostEqual(xx / zz, 1)

    def test_a_flow_and_points_are_intersected_at_the_complexity(self):
        shear = self.write_flow(lambda x, y, z: (2 + z, 0, 0))
        line = self.write_csv([(0.5, 0.5, 0.02 * i) for i in range(50)], "line.csv")
        result = self.run_well("metric", self.cube, "--velocity", shear, "--points", line, "--complexity", 3000, "-o", self.sol)
        self.assertAlmostEqual(float(re.search(r"complexity (\S+)", result.stdout)[1]) / 3000, 1, delta=0.002)
        stretches = [max(xx, yy, zz) / min(xx, yy, zz) for xx, _, yy, _, _, zz in read_sol(self.sol)]
        self.assertLess(max(stretches), 10 ** 2)

    def test_the_array_is_the_one_that_is_named(self):
        flow = self.write_flow(lambda x, y, z: (2 + z, 0, 0, 0, 1 + z, 0),
                               [f"{name}:{axis}" for name in ("first", "second") for axis in range(3)])
        self.refused(BAD_INPUT, "--velocity", flow, None, "flow.csv", "several", "first, second")
        self.refused(BAD_INPUT, "--velocity", flow, "--velocity-array", "third", None, "flow.csv", "third", "first, second")
        xx, _, yy, _, _, _ = self.tensors("--velocity", flow, "--velocity-array", "second")[0]
        self.assertGreater(xx, 50 * yy)

    def test_the_unit_of_samples_is_that_which_is_said(self):
        shear = self.write_flow(lambda x, y, z: (2 + z, 0, 0))
        expected = self.tensors("--velocity", shear)
        self.places = [(x / 1000, y / 1000, z / 1000) for x, y, z in self.places]
        metres = self.write_flow(lambda x, y, z: (2 + 1000 * z, 0, 0), name="metres.csv")
        self.refused(BAD_INPUT, "--velocity", metres, None, "metres.csv", "another unit")
        for given, wanted in zip(self.tensors("--velocity", metres, "--velocity-unit", "m"), expected):
            for a, b in zip(given, wanted):
                self.assertAlmostEqual(a, b, delta=1e-6 * max(map(abs, wanted)))
        self.refused(USAGE, "--velocity-unit", "m", None, "--velocity")

    def test_bad_flows_are_refused(self):
        broken = self.write_flow(lambda x, y, z: ("nan" if (x, y, z) == (0, 0, 0) else 1, 0, 0), name="broken.csv")
        self.refused(BAD_INPUT, "--velocity", broken, None, "broken.csv", "velocity of point 0", "not finite")
        self.places = [(x + 50, y, z) for x, y, z in self.places]
        far = self.write_flow(lambda x, y, z: (1, 0, 0), name="far.csv")
        self.refused(BAD_INPUT, "--velocity", far, None, "far.csv", "far from the mesh")
        self.places = self.places[:9]
        few = self.write_flow(lambda x, y, z: (1, 0, 0), name="few.csv")
        self.refused(BAD_INPUT, "--velocity", few, None, "few.csv", "9 different points", "20")
        self.refused(BAD_INPUT, "--velocity", self.write_csv([("x", "y", "z"), (0, 0, 0)]), None, "no point array of vectors", "none")
        self.refused(USAGE, "--velocity", far, "--velocity-k", 2, None, "--velocity-k", "between 3")
        self.refused(USAGE, "--velocity", far, "--velocity-stretch", 0.5, None, "--velocity-stretch", "between 1")
        self.refused(USAGE, "--velocity", far, "--velocity-flatness", 0, None, "--velocity-flatness", "between 1")
        self.refused(USAGE, "--velocity", far, "--velocity-change", 0, None, "--velocity-change")
        self.refused(USAGE, "--velocity-array", "u", None, "--velocity")


class SolutionTest(MetricCommandTest):
    def write_values(self, values, name="values.sol"):
        path = self.folder / name
        rows = "".join(f"{value}\n" for value in values)
        path.write_text(f"MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n{len(values)}\n1 1\n{rows}End\n",
                        encoding="ascii")
        return path

    def test_sizes_go_as_the_inverse_root_of_second_derivatives(self):
        values = self.write_values([x * x + 4 * y * y - 25 * z * z for x, y, z in self.points])
        for xx, xy, yy, xz, yz, zz in self.tensors("--hessian", values, "--norm", 4, "--complexity", 900):
            self.assertAlmostEqual(math.sqrt(yy / xx), 2, places=3)
            self.assertAlmostEqual(math.sqrt(zz / xx), 5, places=3)
            self.assertLess(abs(xy) + abs(xz) + abs(yz), 1e-3 * xx)

    def test_an_array_of_the_mesh_is_taken_by_its_name(self):
        # The array "size" is one that lumesh reads; any other scalar on the points does as well.
        mesh = self.folder / "mesh.vtk"
        points, tetrahedra, _ = cube(3)
        lines = ["# vtk DataFile Version 3.0", "t", "ASCII", "DATASET UNSTRUCTURED_GRID", f"POINTS {len(points)} double",
                 *(" ".join(map(str, p)) for p in points), f"CELLS {len(tetrahedra)} {5 * len(tetrahedra)}",
                 *("4 " + " ".join(str(v - 1) for v in t[:4]) for t in tetrahedra), f"CELL_TYPES {len(tetrahedra)}",
                 *["10"] * len(tetrahedra), f"POINT_DATA {len(points)}"]
        for name, factor in (("p", 4), ("q", 9)):
            lines += [f"SCALARS {name} double 1", "LOOKUP_TABLE default", *(str(x * x + factor * y * y) for x, y, _ in points)]
        mesh.write_text("\n".join(lines) + "\n", encoding="ascii")
        self.run_well("metric", mesh, "--hessian", "q", "-o", self.sol)
        for xx, _, yy, _, _, _ in read_sol(self.sol):
            self.assertAlmostEqual(math.sqrt(yy / xx), 3, places=3)
        self.assert_refused(self.run_lumesh("metric", mesh, "--hessian", "r", "-o", self.out), BAD_INPUT, "mesh.vtk", "r", "p, q")

    def test_bad_solutions_are_refused(self):
        self.refused(BAD_INPUT, "--hessian", self.write_values([1, 2, 3]), None, "values.sol", "has 3 values", "125 vertices")
        broken = self.write_values([1] * 124 + ["nan"], "broken.sol")
        self.refused(BAD_INPUT, "--hessian", broken, None, "broken.sol", "vertex 124", "not finite")
        self.refused(USAGE, "--hessian", broken, "--norm", 0.5, None, "norm")
        self.refused(USAGE, "--norm", 2, None, "--hessian")


class CurvatureTest(MetricCommandTest):
    def setUp(self):
        super().setUp()
        # The cube bent round the z axis: radii 1 and 2, a right angle.
        points, tetrahedra, triangles = cube(8)
        turned = [((1 + x) * math.cos(math.pi / 2 * y), (1 + x) * math.sin(math.pi / 2 * y), z) for x, y, z in points]
        self.pipe = self.folder / "pipe.mesh"
        write_medit(self.pipe, turned, tetrahedra, triangles)
        self.on_outer = [i for i, (x, y, z) in enumerate(points) if x == 1 and 0.2 < y < 0.8 and 0.2 < z < 0.8]

    def sizes_on_outer(self, *options):
        """Around and along the axis, of the vertices on the outer cylinder."""
        self.run_well("metric", self.pipe, "-o", self.sol, "--curvature", *options)
        tensors = read_sol(self.sol)
        for i in self.on_outer:
            xx, _, yy, _, _, zz = tensors[i]
            yield (xx + yy) ** -0.5, zz ** -0.5

    def test_edges_are_short_around_an_axis_and_long_along_it(self):
        for around, along in self.sizes_on_outer("--edges-per-radius", 5, "--max-size", 3):
            # The sum of the two eigenvalues across the axis is twice that of the size 2 / 5.
            self.assertAlmostEqual(around * math.sqrt(2), 0.4, delta=0.02)
            self.assertGreater(along, 2.5)

    def test_the_height_of_a_chord_is_a_tolerance(self):
        height = 2 * (1 - math.cos(0.1))
        for around, _ in self.sizes_on_outer("--chord-height", height):
            self.assertAlmostEqual(around * math.sqrt(2), 4 * math.sin(0.1), delta=0.02)

    def test_options_need_the_flag_and_exclude_each_other(self):
        self.refused(USAGE, "--chord-height", 0.1, None, "--curvature")
        self.refused(USAGE, "--image", "x.nrrd", None, "--curvature")
        self.refused(BAD_INPUT, "--curvature", "--image", self.folder / "x.nrrd", None, "x.nrrd")
        self.refused(USAGE, "--curvature", "--chord-height", 0.1, "--edges-per-radius", 3, None, "--chord-height")


if __name__ == "__main__":
    unittest.main()
