#!/usr/bin/env python3
"""What the commands say and how they end: warnings, exit codes, help, progress.

Usage: commands_test.py LUMESH      Exit codes of lumesh: 1 usage, 2 bad input, 3 request not reached.
"""
import json
import math
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import nrrd
from program import BAD_INPUT, LUMESH, NOT_REACHED, USAGE, ProgramTest, lines_but_steps, take_signals, wait_for_line

SIZE = 24


class CommandTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.image = nrrd.write(self.folder / "ball.nrrd", [SIZE] * 3, nrrd.ball(SIZE, 8))
        self.mesh = self.folder / "ball.vtu"
        self.json = self.folder / "ball.json"

    def make_mesh(self, *options):
        return self.run_well("lattice", self.image, "-o", self.mesh, *options)

    def evaluate(self, *options):
        return self.run_lumesh("evaluate", self.mesh, "--json", self.json, *options)


class OptionsTest(CommandTest):
    def test_a_label_fidelity_that_is_not_one_pair_of_numbers_is_refused(self):
        for pair in ("1=0.7,2=0.9", "1=0.9x", "1=", "=0.9", "1", "x=0.9", "1.5=0.9", "1=0.7=0.9", "1 =0.7"):
            with self.subTest(pair):
                result = self.run_lumesh("lattice", self.image, "-o", self.mesh, "--label-fidelity", pair)
                self.assert_refused(result, USAGE, "--label-fidelity", f'"{pair}"', "LABEL=NUMBER")
                self.assertFalse(self.mesh.exists())

    def test_a_label_fidelity_of_a_label_that_is_not_there_is_refused(self):
        for pair in ("7=0.9", "0=0.9"):
            with self.subTest(pair):
                result = self.run_lumesh("lattice", self.image, "-o", self.mesh, "--label-fidelity", pair)
                self.assert_refused(result, BAD_INPUT, "--label-fidelity", "ball.nrrd", f"no label {pair[0]}", "it has 1")

    def test_a_label_fidelity_makes_the_mesh_finer(self):
        count = lambda result: int(re.search(r"(\d+) tetrahedra", result.stdout)[1])
        self.assertGreater(count(self.make_mesh("--label-fidelity", "1=0.96")), 2 * count(self.make_mesh()))

    def test_a_spacing_that_is_no_positive_number_is_named(self):
        for value in ("abc", "1e999", "0", "1mm", "inf", "nan"):
            for command, option in ((["lattice", self.image], "--edge-length"), (["phantom", "sphere"], "--spacing")):
                with self.subTest([*command, value]):
                    result = self.run_lumesh(*command, "-o", self.folder / "out.vtu", option, value)
                    self.assert_refused(result, USAGE, option)

    def test_numbers_of_phantoms_are_words(self):
        image = self.folder / "other.nrrd"
        told = lambda *options: json.loads(self.run_well("phantom", "sphere", "-o", image, *options, "--json").stdout)
        self.assertEqual(told("--size", 24)["size_voxels"], [24, 24, 24])
        self.assertEqual(told("--spacing", 0.5, 0.5, 1, "--size", 32, 32, 16)["spacing_mm"], [0.5, 0.5, 1])
        self.run_well("phantom", "sphere", "-o", image, "--size", 24, "--origin", -1, "-2.5", 3, "--rotate", 0, -30, 0)
        self.assertEqual(json.loads(self.run_well("info", image, "--json").stdout)["origin_mm"], [-1, -2.5, 3])
        for options, words in ((("--size", 24, 24), "3 numbers"), (("--size", 24.5), "whole"), (("--size", 4), "between 8 and 2048"),
                               (("--origin", 1), "--origin"), (("--noise", 3), "between 0 and 2"), (("--radius", "-1"), "at least 0")):
            with self.subTest(options):
                self.assert_refused(self.run_lumesh("phantom", "sphere", "-o", image, *options), USAGE, options[0], words)
        sections = json.loads(self.run_well("options", "--json").stdout)
        self.assertIn("ring_radius", [option["name"] for option in sections["phantom"]])

    def test_a_cut_plane_without_a_direction_is_refused_everywhere(self):
        self.make_mesh()
        for plane in ("0 0 0 0 0 0", "0 0 10 0 0 nan", "inf 0 0 1 0 0"):
            for command in (("lattice", self.image, "-o", self.folder / "other.vtu"),
                            ("evaluate", self.mesh, "--image", self.image)):
                with self.subTest(plane=plane, command=command[0]):
                    self.assert_refused(self.run_lumesh(*command, "--cut-plane", *plane.split()), USAGE, "--cut-plane")

    def test_images_are_written_in_the_formats_of_the_list_whatever_the_case_of_the_name(self):
        for name in ("a.NRRD", "a.nii.GZ", "a.Nii"):
            self.run_well("phantom", "sphere", "--size", 24, "-o", self.folder / name)
            self.assertEqual(json.loads(self.run_well("info", self.folder / name, "--json").stdout)["size_voxels"], [24, 24, 24])
        self.assertEqual((self.folder / "a.nii.GZ").read_bytes()[:2], b"\x1f\x8b")
        for options in (("-o", self.folder / "a.tiff"), ("-o", self.folder / "b.nrrd", "--velocity", self.folder / "v.vtu")):
            self.assert_refused(self.run_lumesh("phantom", "carotid", *options), USAGE, "; use .")
        self.assertFalse((self.folder / "b.nrrd").exists())

    def test_a_negative_number_of_tetrahedra_is_refused(self):
        result = self.run_lumesh("lattice", self.image, "-o", self.mesh, "--max-tetrahedra", "-5")
        self.assert_refused(result, USAGE, "--max-tetrahedra")

    def test_a_full_standard_output_is_an_error(self):
        with open("/dev/full", "w", encoding="utf-8") as full:
            result = subprocess.run([LUMESH, "info", str(self.image)], stdout=full, stderr=subprocess.PIPE, text=True,
                                    timeout=60, check=False)
        self.assert_refused(result, BAD_INPUT, "standard output")

    def test_an_unknown_command_is_named_with_the_nearest_one(self):
        for wrong, right in (("latice", "lattice"), ("evalute", "evaluate"), ("lat", "lattice"), ("covert", "convert")):
            with self.subTest(wrong):
                self.assert_refused(self.run_lumesh(wrong, "x"), USAGE, f'"{wrong}"', f'did you mean "{right}"?', "phantom")
        result = self.run_lumesh("mesh", "x")
        self.assert_refused(result, USAGE, '"mesh"', "phantom, info, check, repair, lattice, delaunay, metric, adapt, improve, layers, merge, evaluate, centerline, convert")
        self.assertNotIn("did you mean", result.stderr)

    def test_an_unknown_option_is_named_with_the_nearest_one_whatever_else_is_missing(self):
        for words, wrong, right in ((["lattice", "p.nrrd", "--outpt", "o.vtu"], "--outpt", "--output"),
                                    (["adapt", "p.vtu", "-o", "o.vtu", "--time_limit=3"], "--time_limit", "--time-limit"),
                                    (["--versio"], "--versio", "--version")):
            with self.subTest(wrong):
                self.assert_refused(self.run_lumesh(*words), USAGE, f'unknown option "{wrong}"; did you mean "{right}"?', "--help")
        for words, message in ((["adapt", "p.vtu", "-o", "o.vtu", "--bogus", 3], 'unknown option "--bogus" (lumesh adapt --help'),
                               (["adapt", "p.vtu", "-o", "o.vtu", "-z"], 'unknown option "-z"'),
                               (["lattice", "p.nrrd", "--outpt", "o.vtu", "--bogus", "-z", "--bogus"],
                                'unknown options "--outpt" (did you mean "--output"?), "--bogus", "-z" (lumesh lattice --help'),
                               (["adapt", "a.vtu", "b.vtu", "c.vtu", "-o", "d.vtu"], 'unexpected argument "b.vtu"'),
                               (["lattice", "p.nrrd", "-o", "o.vtu", "--max-tetrahedra"], "--max-tetrahedra: 1 required"),
                               (["lattice", "p.nrrd"], "--output is required")):
            with self.subTest(message):
                self.assert_refused(self.run_lumesh(*words), USAGE, message)

    def test_outputs_that_cannot_be_written_are_refused_before_the_work(self):
        self.make_mesh()
        nowhere = self.folder / "nodir" / "x"
        for command in (["evaluate", self.mesh, "--report", f"{nowhere}.html"], ["evaluate", self.mesh, "--json", f"{nowhere}.json"],
                        ["evaluate", self.mesh, "--picture", self.folder], ["convert", self.mesh, f"{nowhere}.msh"],
                        ["lattice", self.image, "-o", f"{nowhere}.vtu"],
                        ["lattice", self.image, "-o", self.folder / "y.vtu", "--surface", f"{nowhere}.stl"],
                        ["phantom", "sphere", "-o", self.folder / "y.nrrd", "--parameters", f"{nowhere}.json"]):
            with self.subTest(command):
                before = sorted(self.folder.iterdir())
                result = self.run_lumesh(*command)
                self.assert_refused(result, BAD_INPUT, "folder")
                self.assertEqual(result.stdout, "")
                self.assertEqual(sorted(self.folder.iterdir()), before)

    def test_convert_tells_of_each_file_what_is_in_it(self):
        self.make_mesh()
        faces = json.loads(self.run_well("info", self.mesh, "--json").stdout)["patches"][0]["faces"]
        told = self.run_well("convert", self.mesh, self.folder / "ball.stl").stdout
        self.assertEqual(told, f"{self.folder}/ball.stl: {faces} boundary faces, 1 patches\n")
        told = self.run_well("convert", self.mesh, self.folder / "ball.msh", "--surface", self.folder / "ball.vtp").stdout
        self.assertIn(f"ball.vtp: {faces} boundary faces, 1 patches\n", told)

    def test_what_is_said_stands_before_the_error_in_one_stream(self):
        sheet = self.folder / "sheet.off"
        sheet.write_text("OFF\n4 3 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n3 0 1 3\n3 0 1 2\n")
        told = subprocess.run([LUMESH, "check", sheet], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        self.assertEqual(told.returncode, NOT_REACHED, told.stdout)
        self.assertIn("unfit for meshing", told.stdout.splitlines()[-1])

    def test_convert_takes_two_names_or_o(self):
        self.make_mesh()
        help_text = self.run_well("convert", "--help").stdout
        self.assertNotIn("--output TEXT REQUIRED", help_text)
        for arguments in ([self.mesh, self.folder / "a.msh"], [self.mesh, "-o", self.folder / "b.msh"]):
            self.run_well("convert", *arguments)
            self.assertTrue(arguments[-1].exists())
        self.assert_refused(self.run_lumesh("convert", self.mesh), USAGE, "mesh to write")

    def test_convert_writes_the_files_of_solvers_again_and_again(self):
        self.make_mesh()
        names = ["out.xdmf", "out.h5", "out_facets.xdmf", "out_facets.h5", "out_tags.json", "out-mesh-complete"]
        before = {path.name for path in self.folder.iterdir()}
        for target in ("out.xdmf", "out.xdmf", "out-mesh-complete", "out-mesh-complete/"):
            self.run_well("convert", self.mesh, f"{self.folder}/{target}")
        self.assertEqual({path.name for path in self.folder.iterdir()} - before, set(names))
        self.assertEqual({path.name for path in (self.folder / "out-mesh-complete/mesh-surfaces").iterdir()}, {"wall.vtp"})

    def test_a_folder_with_other_files_is_not_replaced(self):
        self.make_mesh()
        folder = self.folder / "mesh-complete"
        folder.mkdir()
        (folder / "solver.xml").write_text("precious")
        for command in (["convert", self.mesh, folder], ["lattice", self.image, "-o", folder]):
            self.assert_refused(self.run_lumesh(*command), BAD_INPUT, "mesh-complete", "solver.xml")
        self.assertEqual([path.name for path in folder.iterdir()], ["solver.xml"])

    def test_a_mixed_mesh_is_refused_for_solvers_of_tetrahedra(self):
        self.make_mesh("--mixed")
        before = sorted(self.folder.iterdir())
        for target in ("out.xdmf", "out-mesh-complete"):
            result = self.run_lumesh("convert", self.mesh, self.folder / target)
            self.assert_refused(result, BAD_INPUT, target, "tetrahedra only", "hexahedra")
            self.assertEqual(sorted(self.folder.iterdir()), before)


class FoamTest(CommandTest):
    FILES = ["boundary", "cellZones", "faceZones", "faces", "neighbour", "owner", "pointZones", "points"]

    def test_a_case_of_openfoam_is_an_empty_file_and_its_folder(self):
        self.make_mesh()
        case = self.folder / "cfd"
        case.mkdir()
        result = self.run_well("convert", self.mesh, case / "ball.foam")
        self.assertIn("ball.foam: ", result.stdout)
        self.assertEqual((case / "ball.foam").read_bytes(), b"")
        self.assertEqual(sorted(path.name for path in (case / "constant/polyMesh").iterdir()), self.FILES)
        self.run_well("lattice", self.image, "-o", self.folder / "ball.foam")
        for name in self.FILES:
            if name != "boundary":  # It also says which command made the mesh.
                self.assertEqual((self.folder / "constant/polyMesh" / name).read_bytes(),
                                 (case / "constant/polyMesh" / name).read_bytes(), name)

    def test_a_case_that_cannot_be_written_leaves_nothing(self):
        self.make_mesh()
        (self.folder / "constant").write_text("no folder")
        before = sorted(self.folder.iterdir())
        self.assert_refused(self.run_lumesh("convert", self.mesh, self.folder / "ball.foam"), BAD_INPUT, "constant", "cannot be made")
        self.assertEqual(sorted(self.folder.iterdir()), before)


class EvaluateTest(CommandTest):
    def test_the_image_of_the_mesh_gives_no_warning(self):
        self.make_mesh()
        result = self.evaluate("--image", self.image)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        self.assertEqual(json.loads(self.json.read_text())["warnings"], [])

    def test_another_image_than_that_of_the_mesh_gives_a_warning(self):
        self.make_mesh()
        other = nrrd.write(self.folder / "other.nrrd", [SIZE] * 3, nrrd.ball(SIZE, 7))
        result = self.evaluate("--image", other, "--report", self.folder / "ball.html")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertRegex(result.stderr, r"^lumesh: warning: .*other\.nrrd: .*ball\.vtu.*ball\.nrrd.*\n$")
        warnings = json.loads(self.json.read_text())["warnings"]
        self.assertEqual([f"lumesh: warning: {w}" for w in warnings], result.stderr.splitlines())
        self.assertIn("Warnings", (self.folder / "ball.html").read_text())

    def test_an_invalid_mesh_ends_with_3_after_the_report(self):
        self.make_mesh()
        text = self.folder / "ball.mesh"
        self.run_well("convert", self.mesh, text)
        lines = text.read_text().splitlines()
        first = next(i for i, line in enumerate(lines) if line.startswith("Tetrahedra")) + 2
        a, b, *rest = lines[first].split()
        lines[first] = " ".join([b, a, *rest])  # the first tetrahedron inside out
        text.write_text("\n".join(lines) + "\n")
        result = self.run_lumesh("evaluate", text, "--json", self.json, "--report", self.folder / "ball.html")
        self.assert_refused(result, NOT_REACHED, "ball.mesh", "invalid")
        self.assertIn("INVALID", result.stdout)
        self.assertIs(json.loads(self.json.read_text())["valid"], False)
        self.assertTrue((self.folder / "ball.html").exists())

    def test_volumes_are_compared_with_what_the_cut_keeps(self):
        # A bar of 6 x 6 voxels along x from 4 to 20; the plane leaves 10.3 of its 16 voxels' length.
        voxels = [1 if 4 <= i < 20 and 9 <= j < 15 and 9 <= k < 15 else 0
                  for k in range(SIZE) for j in range(SIZE) for i in range(SIZE)]
        nrrd.write(self.image, [SIZE] * 3, voxels)
        cut = ("--cut-plane", "13.8", "0", "0", "2", "0", "0")
        self.make_mesh("--spacing", "1", *cut)
        self.evaluate("--image", self.image, *cut)
        label = json.loads(self.json.read_text())["labels"][0]
        self.assertAlmostEqual(label["voxel_volume_mm3"], 10.3 * 36, places=6)
        self.assertEqual(label["image"]["voxels"], 16 * 36)
        self.assertLess(abs(label["volume_error_percent"]), 12)  # edges are rounded off
        self.assertAlmostEqual(label["volume_mm3"], label["voxel_volume_mm3"] * (1 + label["volume_error_percent"] / 100))

    def write_corner_with_metric(self, rows):
        """The corner tetrahedron of the unit cube; rows of xx yy zz xy yz xz, one for each vertex."""
        numbers = " ".join(" ".join(map(str, row)) for row in rows)
        self.mesh.write_text(f"""<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64"><UnstructuredGrid>
<Piece NumberOfPoints="4" NumberOfCells="1">
<PointData><DataArray type="Float64" Name="metric" NumberOfComponents="6" format="ascii">{numbers}</DataArray></PointData>
<Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points>
<Cells><DataArray type="Int64" Name="connectivity" format="ascii">0 1 2 3</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">4</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">10</DataArray></Cells>
</Piece></UnstructuredGrid></VTKFile>""")

    def test_a_mesh_with_a_metric_is_measured_in_it(self):
        # Size 1/2 along x, 1 along y and 2 along z, at the origin and everywhere.
        self.write_corner_with_metric([(4, 1, 0.25, 0, 0, 0)] * 4)
        result = self.evaluate()
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        self.assertIn("metric edges", result.stdout)
        figures = json.loads(self.json.read_text())
        lengths = [2, 1, 0.5, 5 ** 0.5, 4.25 ** 0.5, 1.25 ** 0.5]
        self.assertEqual(figures["metric_edge_length"]["edges"], 6)
        self.assertAlmostEqual(figures["metric_edge_length"]["mean"], sum(lengths) / 6)
        self.assertAlmostEqual(figures["metric_edge_length"]["fraction_in_band"], 2 / 6)
        # 12 (3 V)^(2/3) / (sum of squares) with the metric volume 1/6.
        self.assertAlmostEqual(figures["metric_mean_ratio"]["min"], 12 * 0.5 ** (2 / 3) / sum(l * l for l in lengths))
        self.assertAlmostEqual(figures["complexity"], 1 / 6)

    def test_a_metric_that_is_not_positive_definite_is_refused_with_its_vertex(self):
        self.write_corner_with_metric([(1, 1, 1, 0, 0, 0)] * 3 + [(1, -1, 1, 0, 0, 0)])
        self.assert_refused(self.evaluate(), BAD_INPUT, "ball.vtu", "3", "positive definite")


class InfoTest(CommandTest):
    def test_numbers_are_short_and_fields_in_a_sensible_order(self):
        nrrd.write(self.image, [SIZE] * 3, nrrd.ball(SIZE, 8), spacing=[0.49999999999999994, 0.1, 1 / 3])
        all_fields = json.loads(self.run_well("info", self.image, "--json").stdout)
        self.assertEqual(all_fields["spacing_mm"], [0.5, 0.1, 0.333333333333])
        self.assertEqual(list(all_fields)[:3], ["kind", "size_voxels", "spacing_mm"])
        self.assertEqual(list(all_fields["labels"][0])[0], "label")
        text = self.run_well("info", self.image).stdout
        self.assertIn("[0.5,0.1,0.333333333333]", text)
        self.assertLess(text.index("size_voxels"), text.index("origin_mm"))

    def test_a_mesh_is_told_with_kinds_and_names_and_a_surface_by_its_triangles(self):
        self.make_mesh("--surface", self.folder / "ball.stl", "--name", "wall=dome")
        self.run_well("layers", self.mesh, "--first-height", "0.5", "--count", "1", "--label", "skin=7", "-o", self.mesh)
        told = json.loads(self.run_well("info", self.mesh, "--json").stdout)
        self.assertEqual([label.get("name") for label in told["labels"]][1:], ["skin"])
        self.assertEqual({patch["kind"] for patch in told["patches"]}, {"wall", "interface"})
        self.assertIn("kind wall", self.run_well("info", self.mesh).stdout)
        surface = json.loads(self.run_well("info", self.folder / "ball.stl", "--json").stdout)
        self.assertEqual(surface["kind"], "surface")
        self.assertGreater(surface["triangles"], 100)
        self.assertNotIn("tetrahedra", surface)

    def test_files_for_solvers_are_said_to_be_written_only(self):
        self.make_mesh()
        case = self.folder / "ball.foam"
        self.run_well("convert", self.mesh, case)
        for command in (("info", case), ("evaluate", case), ("lattice", case, "-o", self.mesh), ("centerline", case, "-o", self.folder / "a.vtp")):
            self.assert_refused(self.run_lumesh(*command), BAD_INPUT, "ball.foam", "written for solvers and not read")

    def test_help_names_every_image_format(self):
        for command in ("info", "lattice"):
            self.assertIn(".gipl", self.run_well(command, "--help").stdout)


class NameTest(CommandTest):
    def make_tube(self):
        labels = [1 if (i - 8) ** 2 + (j - 8) ** 2 < 30 else 0 for k in range(17) for j in range(17) for i in range(17)]
        return nrrd.write(self.folder / "tube.nrrd", [17] * 3, labels)

    def patches(self):
        self.run_well("evaluate", self.mesh, "--json", self.json)
        return {patch["name"]: patch["kind"] for patch in json.loads(self.json.read_text())["boundary"]["patches"]}

    def test_patches_get_names_by_name_and_place(self):
        tube = self.make_tube()
        for mesher in (["lattice"], ["delaunay", "--delta", "1.5"]):
            self.run_well(*mesher, tube, "-o", self.mesh, "--name", "8,8,-0.5=left_ica", "--name", "wall=vessel", "--strict")
            self.assertEqual(self.patches()["left_ica"], "opening")
            self.assertIn("vessel", self.patches())
        other = self.folder / "other.vtu"
        self.run_well("rename", self.mesh, "-o", other, "--name", "left_ica=vessel", "--name", "vessel=left_ica")
        self.mesh = other
        self.assertEqual((self.patches()["vessel"], self.patches()["left_ica"]), ("opening", "wall"))

    def test_surfaces_have_openings_at_their_flat_ends(self):
        tube, surface = self.make_tube(), self.folder / "tube.stl"
        self.run_well("lattice", tube, "-o", self.mesh, "--surface", surface)
        of_image = json.loads(self.run_well("info", tube, "--json").stdout)["openings"]
        of_surface = self.run_well("info", surface, "--json")
        self.assertNotIn("warning", of_surface.stderr)
        of_surface = json.loads(of_surface.stdout)["openings"]
        self.assertEqual([o["name"] for o in of_surface], ["inlet_1", "outlet_1"])
        self.assertEqual(sorted(o["centre_mm"][2] for o in of_surface), sorted(o["centre_mm"][2] for o in of_image))
        for opening in of_surface:
            self.assertAlmostEqual(opening["area_mm2"] / of_image[0]["area_mm2"], 1, delta=0.02)
            self.assertAlmostEqual(abs(opening["normal"][2]), 1, places=6)
            self.assertAlmostEqual(math.pi * opening["radius_mm"] ** 2, opening["area_mm2"], delta=0.01)
        self.assertRegex(self.run_well("info", surface).stdout, r"openings\n  name inlet_1 .*\n  name outlet_1 ")

    def test_a_closed_surface_is_said_to_have_no_opening(self):
        image, surface, case = self.folder / "ball.nrrd", self.folder / "ball.stl", self.folder / "case.toml"
        self.run_well("phantom", "sphere", "--size", 24, 24, 24, "-o", image)
        self.run_well("lattice", image, "-o", self.mesh, "--surface", surface)
        case.write_text('mesher = "delaunay"\n[input]\nsurface = "ball.stl"\n[delaunay]\ndelta = 2\n')
        for command, remedy in ((("info", surface), "--feature-angle"), (("delaunay", surface, "--delta", 2, "-o", self.mesh), "--feature-angle"),
                                (("run", case, "-o", self.folder / "out"), "feature_angle")):
            told = self.run_well(*command).stderr
            self.assertIn("the surface has no flat end, so the mesh has no openings", told)
            self.assertIn(remedy, told)

    def test_patches_of_a_surface_that_are_no_flat_ends_are_said_to_be_none(self):
        octahedron = self.folder / "octahedron.obj"
        octahedron.write_text("v 1 0 0\nv 0 1 0\nv -1 0 0\nv 0 -1 0\nv 0 0 1\nv 0 0 -1\ng upper\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"
                              "g lower\nf 2 1 6\nf 3 2 6\nf 4 3 6\nf 1 4 6\n")
        told = self.run_well("info", octahedron).stderr
        self.assertIn("none of the surface's 2 patches is a flat end, so the mesh has no openings", told)
        self.assertNotIn("has no flat end", told)

    def test_a_wall_that_is_called_symmetry_is_no_opening(self):
        made = self.run_well("lattice", self.make_tube(), "-o", self.mesh, "--name", "wall=wall:symmetry",
                             "--name", "8,8,16.5=middle:symmetry", "--strict")
        self.assertNotIn("warning", made.stderr)
        self.assertEqual(self.patches()["middle"], "symmetry")

    def test_kinds_reach_the_files_and_stay(self):
        tube = self.make_tube()
        self.run_well("lattice", tube, "-o", self.mesh, "--name", "8,8,-0.5=left_ica:inlet", "--name", "8,8,16.5=middle:symmetry",
                      "--strict")
        kinds = {"left_ica": "inlet", "middle": "symmetry", "wall": "wall"}
        self.assertEqual(self.patches(), kinds)
        made = self.mesh
        for later in (["convert"], ["improve"], ["layers", "--side", "inward", "--first-height", "0.1", "--count", "2"]):
            self.mesh = self.folder / f"{later[0]}.msh"
            self.run_well(*later, made, *(["-o"] if later[0] != "convert" else []), self.mesh)
            self.assertEqual({name: kind for name, kind in self.patches().items() if name in kinds}, kinds, later[0])
        self.run_well("convert", made, self.folder / "case.foam")
        boundary = (self.folder / "constant" / "polyMesh" / "boundary").read_text()
        for name, kind in (("left_ica", "patch"), ("middle", "symmetry"), ("wall", "wall")):
            self.assertRegex(boundary, rf"{name}\s*{{\s*type\s+{kind};")
        other = self.folder / "other.vtu"
        said = self.run_well("rename", made, "-o", other, "--name", "middle=stump:wall").stdout
        self.assertIn("middle is stump, kind wall, now", said)
        self.mesh = other
        self.assertEqual(self.patches()["stump"], "wall")
        self.assert_refused(self.run_lumesh("rename", made, "-o", other, "--name", "wall=outlet_1:wall"), USAGE, "another name")

    def test_an_opening_may_be_meant_by_its_area(self):
        tube = self.make_tube()
        known = json.loads(self.run_well("info", tube, "--json").stdout)
        areas = [opening["area_mm2"] for opening in known["openings"]]
        result = self.run_lumesh("lattice", tube, "-o", self.mesh, "--name", f"{areas[0]:.3f}mm2=x")
        self.assert_refused(result, BAD_INPUT, "2 openings are within 10 %")  # Both ends of the tube.

    def test_an_opening_that_is_not_there_is_refused_before_the_work(self):
        tube = self.make_tube()
        for name in ("outlet_5=x", "8,8,40=x"):
            result = self.run_lumesh("lattice", tube, "-o", self.mesh, "--name", name)
            self.assert_refused(result, BAD_INPUT, "there are inlet_1 at")
        self.assert_refused(self.run_lumesh("lattice", tube, "-o", self.mesh, "--name", "outlet_1=a b"), USAGE, "letters")
        self.assertFalse(self.mesh.exists())
        result = self.run_lumesh("lattice", tube, "-o", self.mesh, "--name", "vall=x")
        self.assertEqual(result.returncode, NOT_REACHED)
        self.assertIn("no patch vall to call x; it has wall", result.stderr)
        self.assertTrue(self.mesh.exists())


class EdgeLengthTest(CommandTest):
    def wall_edge(self, *command):
        """Edge of the equilateral triangle that has the mean area of those of the wall."""
        self.run_well(*command, "-o", self.mesh)
        self.run_well("evaluate", self.mesh, "--json", self.json)
        wall = next(p for p in json.loads(self.json.read_text())["boundary"]["patches"] if p["name"] == "wall")
        return math.sqrt(4 / math.sqrt(3) * wall["area_mm2"] / wall["faces"])

    def test_it_is_the_same_in_both_meshers_and_their_default(self):
        labels = [1 if (i - 15.3) ** 2 + (j - 15.1) ** 2 < 144 else 0 for k in range(30) for j in range(31) for i in range(31)]
        tube = nrrd.write(self.folder / "tube.nrrd", [31, 31, 30], labels)
        for options, edge in (((), 2.5), (("--edge-length", 4), 4)):
            with self.subTest(options=options):
                lattice, delaunay = (self.wall_edge(mesher, tube, *options) for mesher in ("lattice", "delaunay"))
                self.assertAlmostEqual(lattice / delaunay, 1, delta=0.1)
                self.assertAlmostEqual(lattice / edge, 0.87, delta=0.1)  # Edges that differ in length make smaller triangles.

    def test_cells_per_diameter_are_about_what_was_asked_for(self):
        for radius in (4, 6, 10):
            labels = [1 if (i - 15.3) ** 2 + (j - 15.1) ** 2 < radius ** 2 else 0 for k in range(40) for j in range(31) for i in range(31)]
            tube = nrrd.write(self.folder / "tube.nrrd", [31, 31, 40], labels)
            for mesher in ("lattice", "delaunay"):
                for cells in (4, 7, 10):
                    with self.subTest(mesher, radius=radius, cells=cells):
                        edge = self.wall_edge(mesher, tube, "--edge-length", 6, "--cells-per-diameter", cells)
                        # Edges of that area are shorter than the mean edge, and ends of the short tube have shorter ones.
                        self.assertAlmostEqual(2 * radius / edge / cells, 1.1, delta=0.25)
        result = self.run_lumesh("lattice", tube, "-o", self.mesh, "--cells-per-diameter", 4, "--fidelity", 0.6)
        self.assert_refused(result, USAGE, "--cells-per-diameter", "--fidelity")
        for value in ("nan", "0.5", "26", "x"):
            result = self.run_lumesh("lattice", tube, "-o", self.mesh, "--cells-per-diameter", value)
            self.assert_refused(result, USAGE, "--cells-per-diameter")


class SignalTest(CommandTest):
    def test_one_signal_ends_every_command_and_leaves_nothing_behind(self):
        big = self.folder / "big.nrrd"
        self.run_well("phantom", "carotid", "-o", big, "--size", 256, 256, 254, "--spacing", 2)
        self.make_mesh()
        good = self.folder / "good.vtu"
        good.write_bytes(b"what was there")
        before = {path.name for path in self.folder.iterdir()}
        for command in (("lattice", big, "--spacing", 1.5), ("delaunay", big, "--delta", 1), ("evaluate", self.mesh, "--image", big)):
            for which in (signal.SIGTERM, signal.SIGINT):
                with self.subTest(command[0], signal=which), subprocess.Popen(
                        [LUMESH, *map(str, command), "-v", *(("-o", str(good)) if command[0] != "evaluate" else ())],
                        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, preexec_fn=take_signals) as process:
                    wait_for_line(process, "cuts took")  # The image is read, and what takes long begins.
                    process.send_signal(which)
                    sent = time.monotonic()
                    errors = process.communicate(timeout=60)[1]
                    self.assertLess(time.monotonic() - sent, 3)  # A second, and what a busy machine adds.
                    self.assertEqual(process.returncode, 4, errors)
                    self.assertEqual(lines_but_steps(errors)[-1], "lumesh: error: interrupted; no unfinished file is left")
        self.assertEqual(good.read_bytes(), b"what was there")
        self.assertEqual({path.name for path in self.folder.iterdir()}, before)

    def test_a_signal_before_the_libraries_are_ready_is_answered_as_well(self):
        source, library = self.folder / "early.c", self.folder / "early.so"
        source.write_text("#include <signal.h>\n#include <unistd.h>\n"
                          "__attribute__((constructor)) static void stop(void) { kill(getpid(), SIGTERM); }\n")
        compiler = shutil.which("cc") or shutil.which("gcc") or self.skipTest("no C compiler")
        subprocess.run([compiler, "-shared", "-fPIC", source, "-o", library], check=True)
        result = subprocess.run([LUMESH, "lattice", self.image, "-o", self.mesh, "--spacing", "0.3"], capture_output=True, text=True,
                                check=False, env={**os.environ, "LD_PRELOAD": str(library)}, preexec_fn=take_signals)
        self.assertEqual((result.returncode, result.stderr), (4, "lumesh: error: interrupted; no unfinished file is left\n"))

    def test_what_nohup_ignores_stays_ignored(self):
        with subprocess.Popen([LUMESH, "lattice", self.image, "-v", "-o", self.mesh, "--spacing", "0.3"], stdout=subprocess.DEVNULL,
                              stderr=subprocess.PIPE, text=True, preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN)) as process:
            wait_for_line(process, "cuts took")
            self.assertIsNone(process.poll())
            process.send_signal(signal.SIGHUP)
            errors = process.communicate(timeout=120)[1]
        self.assertEqual(process.returncode, 0, errors)
        self.assertTrue(self.mesh.exists())


class OutputTest(CommandTest):
    def test_a_mesh_is_written_though_nobody_reads_what_is_said(self):
        command = f"'{LUMESH}' lattice '{self.image}' -o '{self.mesh}'"
        for words, code in ((f"{command} | true; exit ${{PIPESTATUS[0]}}", 0), (f"{command} >&- 2>&-", None), (f"{command} >/dev/full", 2)):
            with self.subTest(words):
                self.mesh.unlink(missing_ok=True)
                result = subprocess.run(["bash", "-c", words], capture_output=True, text=True, timeout=60, check=False)
                self.assertTrue(self.mesh.exists())
                self.assertLess(result.returncode, 64)
                if code is not None:
                    self.assertEqual(result.returncode, code, result.stderr)


class ProgressTest(CommandTest):
    def test_verbose_tells_each_step_with_its_time(self):
        result = self.make_mesh("-v")
        lines = result.stderr.splitlines()
        for line in lines:
            self.assertRegex(line, r"^lumesh: [\w ]+ took \d+\.\d\d s$")
        steps = [re.match(r"lumesh: (.*) took", line)[1] for line in lines]
        self.assertEqual((steps[0], steps[-2:]), ("read", ["check", "validity"]))
        self.assertIn("boundary", steps)
        self.assertIn("tetrahedra", result.stdout)

    def test_quiet_still_tells_of_a_lost_label(self):
        labels = nrrd.ball(SIZE, 8)
        labels[2 + SIZE * (2 + SIZE * 2)] = 5
        image = nrrd.write(self.folder / "lonely.nrrd", [SIZE] * 3, labels)
        result = self.run_well("lattice", image, "-o", self.mesh, "-q", "--max-refinement", "0", "--spacing", "6")
        self.assertEqual(result.stdout, "")
        self.assertIn("label 5", result.stderr)

    def test_quiet_prints_warnings_and_errors_only(self):
        result = self.make_mesh("-q")
        self.assertEqual((result.stdout, result.stderr), ("", ""))
        other = nrrd.write(self.folder / "other.nrrd", [SIZE] * 3, nrrd.ball(SIZE, 7))
        result = self.evaluate("--quiet", "--times", "--image", other)
        self.assertEqual(result.stdout, "")
        self.assertIn("warning", result.stderr)
        for command in (["convert", self.mesh, self.folder / "x.msh"],
                        ["phantom", "sphere", "-o", self.folder / "s.nrrd", "--size", "16", "16", "16"]):
            result = self.run_well(*command, "-q")
            self.assertEqual((result.stdout, result.stderr), ("", ""))
        self.assert_refused(self.run_lumesh("convert", "none.vtu", self.folder / "x.msh", "-q"), BAD_INPUT, "none.vtu")
        self.assert_refused(self.run_lumesh("lattice", self.image, "-o", self.mesh, "-q", "-v"), USAGE, "--quiet")


if __name__ == "__main__":
    unittest.main(verbosity=2)
