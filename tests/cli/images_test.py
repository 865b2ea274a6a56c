#!/usr/bin/env python3
"""Images as labs have them: level sets, frames, masks of several files, units, vessels that touch.

Usage: images_test.py LUMESH      Exit codes of lumesh: 1 usage, 2 bad input.
"""
import json
import math
import pathlib
import struct
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import nrrd
from program import BAD_INPUT, USAGE, ProgramTest

SHARED = pathlib.Path(__file__).resolve().parents[3] / "shared/data"
SIZES, MIDDLE = [24, 24, 24], (11.3, 11.6, 11.1)


def cube(value_at):
    """Values of a cube of voxels; i fastest."""
    return [value_at((i, j, k)) for k in range(SIZES[2]) for j in range(SIZES[1]) for i in range(SIZES[0])]


def depth(place, radius):
    return radius - math.dist(place, MIDDLE)


def write_series(path, frames):
    """A 4-D NIfTI file of bytes."""
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 4, *SIZES, len(frames), 1, 1, 1)
    struct.pack_into("<h", header, 70, 2)
    struct.pack_into("<8f", header, 76, *[1.0] * 8)
    struct.pack_into("<f", header, 108, 352.0)
    header[123] = 2
    struct.pack_into("<h", header, 254, 1)
    struct.pack_into("<12f", header, 280, -1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 0)  # RAS: the voxels' axes are L, P, S.
    header[344:348] = b"n+1\0"
    path.write_bytes(bytes(header) + b"".join(bytes(frame) for frame in frames))
    return path


class ImagesTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.mesh = self.folder / "out.mesh"

    def write(self, name, voxels, kind="uint8", **options):
        return nrrd.write(self.folder / name, SIZES, voxels, kind=kind, **options)

    def points(self, mesh):
        words = mesh.read_text().split()
        at = words.index("Vertices")
        count = int(words[at + 1])
        numbers = [float(word) for word in words[at + 2:at + 2 + 4 * count]]
        return [numbers[i:i + 3] for i in range(0, 4 * count, 4)]

    def radius_of(self, mesh):
        return max(math.dist(p, MIDDLE) for p in self.points(mesh))

    def test_level_sets_are_taken_by_all_commands_and_said(self):
        image = self.write("distance.nrrd", cube(lambda p: -depth(p, 7.4)), "float")
        for command in (["delaunay", image, "--delta", 0.8, "-o", self.mesh], ["lattice", image, "--spacing", 1.2, "-o", self.mesh]):
            result = self.run_well(*command)
            self.assertIn("negative inside", result.stderr)
            self.assertAlmostEqual(self.radius_of(self.mesh), 7.4, delta=0.08)
        self.assertEqual(self.run_well("info", image, "--level-set", "negative").stderr, "")
        self.run_well("evaluate", self.mesh, "--image", image, "--level-set", "negative")
        result = self.run_lumesh("info", image, "--level-set", "negative", "--threshold", 1)
        self.assert_refused(result, USAGE, "--level-set", "--threshold")

    def test_a_range_of_values_and_what_nothing_reaches(self):
        image = self.write("grey.nrrd", cube(lambda p: round(100 * depth(p, 7.4))), "int16")
        label = json.loads(self.run_well("info", image, "--threshold=-100,200", "--json").stdout)["labels"][0]
        self.assertEqual(label["voxels"], sum(-100 <= round(100 * depth((i, j, k), 7.4)) <= 200 for k in range(24)
                                              for j in range(24) for i in range(24)))
        self.assert_refused(self.run_lumesh("info", image, "--threshold", "5000,6000"), BAD_INPUT, "5000", "6000")
        self.assertEqual(self.run_lumesh("info", image, "--threshold", "3,2").returncode, USAGE)
        self.assertEqual(self.run_lumesh("info", image, "--threshold", "1,2,3").returncode, USAGE)

    def test_frames_one_or_all(self):
        series = write_series(self.folder / "s.nii", [cube(lambda p, r=r: 1 if depth(p, r) >= 0 else 0) for r in (5, 7)])
        self.assert_refused(self.run_lumesh("lattice", series, "-o", self.mesh), BAD_INPUT, "2 volumes", "--frame")
        self.assert_refused(self.run_lumesh("lattice", series, "--frame", 2, "-o", self.mesh), BAD_INPUT, "no frame 2")
        self.run_well("lattice", series, "--frame", 1, "-o", self.mesh)
        self.assertAlmostEqual(self.radius_of(self.mesh), 7, delta=0.5)
        self.run_well("lattice", series, "--all-frames", "-o", self.folder / "f.mesh")
        self.run_well("delaunay", series, "--all-frames", "-o", self.folder / "g%02d.mesh")
        for n, radius in enumerate((5, 7)):
            for name in (f"f_{n:03}.mesh", f"g{n:02}.mesh"):
                self.assertAlmostEqual(self.radius_of(self.folder / name), radius, delta=0.5)
        case = self.folder / "case.toml"
        case.write_text('mesher = "lattice"\n[input]\nimage = "s.nii"\nall_frames = true\n[output]\nreport = ""\n')
        self.run_well("run", case, "-o", self.folder / "out")
        self.assertTrue((self.folder / "out" / "frame_001" / "mesh.vtu").exists())

    def test_openings_keep_their_names_through_frames_and_json_is_one_document(self):
        def tube(low, high, beside=0):
            def value(p):
                radius = low + (high - low) * p[2] / (SIZES[2] - 1)
                is_beside = p[2] < 12 and math.dist((p[0], p[1]), (19.2, 12)) < beside
                return 1 if is_beside or math.dist((p[0], p[1]), (8.3, 11.6)) < radius else 0
            return cube(value)
        series = write_series(self.folder / "s.nii", [tube(6, 4), tube(4, 6), tube(4, 6, 3)])
        for command in ("lattice", "delaunay"):
            result = self.run_well(command, series, "--all-frames", "-o", self.folder / f"{command}.vtu", "--json")
            found = [{o["patches"]: o["centre_mm"] for o in frame["openings"]} for frame in json.loads(result.stdout)]
            self.assertEqual([set(frame) for frame in found], [{"inlet_1", "outlet_1"}, {"inlet_1", "outlet_1"}, {"inlet_1", "outlet_1", "outlet_2"}])
            for frame in found:
                self.assertLess(frame["inlet_1"][2], frame["outlet_1"][2])
            self.assertAlmostEqual(found[2]["outlet_2"][0], 19.2, delta=0.3)
            self.assertRegex(result.stderr, r"outlet_2 at .* is an opening that no frame before has")
        case = self.folder / "case.toml"
        case.write_text('mesher = "lattice"\n[input]\nimage = "s.nii"\nall_frames = true\n[output]\nreport = ""\n')
        self.assertEqual(len(json.loads(self.run_well("run", case, "-o", self.folder / "out", "--json").stdout)), 3)
        for folder in sorted((self.folder / "out").iterdir()):
            self.run_well("convert", folder / "mesh.vtu", self.folder / "frame.msh")
            mesh = json.loads(self.run_well("evaluate", folder / "mesh.vtu", "--json").stdout)
            areas = {p["name"]: p["area_mm2"] for p in mesh["boundary"]["patches"]}
            self.assertEqual(areas["inlet_1"] > areas["outlet_1"], folder.name == "frame_000")

    def test_layers_of_segments_are_labels_of_one_image(self):
        voxels = []  # The layer varies fastest.
        for place in ((i, j, k) for k in range(SIZES[2]) for j in range(SIZES[1]) for i in range(SIZES[0])):
            stem = math.dist(place[:2], (8, 8)) < 4
            side = 8 <= place[0] and math.dist(place[1:], (8, 12)) < 3
            voxels += [1 if stem else 0, 1 if side else 2 if math.dist(place[:2], (17, 18)) < 3 else 0]
        segments = [("aorta", 1, 0), ("left renal", 1, 1), ("vein", 2, 1)]
        lines = "".join(f"Segment{n}_Name:={name}\nSegment{n}_LabelValue:={value}\nSegment{n}_Layer:={layer}\n" for n, (name, value, layer) in enumerate(segments))
        image = self.folder / "two.seg.nrrd"
        image.write_bytes(("NRRD0004\ntype: uint8\ndimension: 4\nspace: left-posterior-superior\nsizes: 2 %d %d %d\n" % tuple(SIZES)
                           + "space directions: none (1,0,0) (0,1,0) (0,0,1)\nkinds: list domain domain domain\nendian: little\nencoding: raw\n"
                           + "space origin: (0,0,0)\n" + lines + "\n").encode() + bytes(voxels))
        pairs = list(zip(voxels[::2], voxels[1::2]))
        result = self.run_well("info", image, "--json")
        labels = {label["name"]: (label["label"], label["voxels"]) for label in json.loads(result.stdout)["labels"]}
        self.assertEqual(labels, {"aorta": (1, sum(pair == (1, 0) for pair in pairs)), "left renal": (3, sum(pair[1] == 1 for pair in pairs)),
                                  "vein": (2, sum(pair[1] == 2 for pair in pairs))})
        hidden = sum(pair[0] == 1 and pair[1] > 0 for pair in pairs)
        self.assertIn(f'2 layers of segments, which become one image of labels: "aorta" of layer 0 is label 1 without {hidden} voxels', result.stderr)
        one = json.loads(self.run_well("info", image, "--frame", 1, "--json").stdout)
        self.assertEqual([label["name"] for label in one["labels"]], ["left renal", "vein"])
        by_name = json.loads(self.run_well("info", image, "--labels", "left renal, 2", "--json").stdout)
        self.assertEqual([label["label"] for label in by_name["labels"]], [2, 3])
        refused = self.run_lumesh("info", image, "--labels", "right renal")
        self.assertEqual(refused.returncode, BAD_INPUT, refused.stderr)
        self.assertIn('no label is called "right renal"; there are aorta, vein, left renal', refused.stderr.splitlines()[-1])
        self.assert_refused(self.run_lumesh("info", self.write("plain.nrrd", bytes(map(bool, voxels[::2]))), "--labels", "aorta"), BAD_INPUT,
                            'its labels have no names, such as "aorta"; --labels takes their numbers')
        self.run_well("lattice", image, "-o", self.mesh)

    def test_words_of_a_header_that_say_nothing_are_told(self):
        voxels = bytes(1 if math.dist((i, j), (11, 11)) < 5 else 0 for k in range(SIZES[2]) for j in range(SIZES[1]) for i in range(SIZES[0]))

        def told(space, unit, *options):
            image = self.folder / "words.nrrd"
            image.write_bytes((f"NRRD0004\ntype: uint8\ndimension: 3\nspace: {space}\nsizes: %d %d %d\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n" % tuple(SIZES)
                               + f'kinds: domain domain domain\nendian: little\nencoding: raw\nspace units: "{unit}" "{unit}" "{unit}"\n\n').encode() + voxels)
            result = self.run_well("info", image, "--json", *options)
            return json.loads(result.stdout)["spacing_mm"][0], result.stderr

        self.assertIn('words.nrrd: its unit is "foo", which is not known: its lengths are taken as mm; --unit says', told("LPS", "foo")[1])
        self.assertNotIn("not known", told("LPS", "foo", "--unit", "mm")[1])
        self.assertIn("words.nrrd: its space, scanner-xyz, does not say which side is left: its coordinates are taken as LPS", told("scanner-xyz", "mm")[1])
        spacing, lines = told("LPS", "inches")
        self.assertEqual((spacing, "not known" in lines), (25.4, False))

    def test_masks_of_several_files(self):
        lumen = self.write("lumen.nrrd", cube(lambda p: 1 if depth(p, 5) >= 0 else 0))
        wall = self.write("wall.nrrd", cube(lambda p: 1 if depth(p, 8) >= 0 else 0))
        result = self.run_well("info", lumen, "--label-image", f"{wall}=2", "--json")
        self.assertEqual([label["label"] for label in json.loads(result.stdout)["labels"]], [1, 2])
        self.assertIn("keep that label", result.stderr)
        case = self.folder / "case.toml"
        case.write_text('mesher = "lattice"\n[input]\nimage = "lumen.nrrd"\nlabel_images = ["wall.nrrd=2"]\n[output]\nreport = ""\n')
        self.run_well("run", case, "-o", self.folder / "out")
        self.assertIn("Label 2", (self.folder / "out" / "report.json").read_text())
        self.run_well("run", self.folder / "out" / "effective.toml", "-o", self.folder / "again")
        other = nrrd.write(self.folder / "other.nrrd", [3, 3, 3], [1] * 27)
        self.assert_refused(self.run_lumesh("info", lumen, "--label-image", f"{other}=2"), BAD_INPUT, "other.nrrd", "grid")
        self.assertEqual(self.run_lumesh("info", lumen, "--label-image", "wall.nrrd").returncode, USAGE)

    def test_units_of_input_and_output(self):
        image = self.write("cm.nrrd", cube(lambda p: 1 if depth(p, 7) >= 0 else 0), spacing=[0.1] * 3)
        self.run_well("lattice", image, "--unit", "cm", "--out-unit", "m", "-o", self.folder / "m.vtu")
        info = json.loads(self.run_well("info", self.folder / "m.vtu", "--json").stdout)
        self.assertEqual(info["unit"], "m")
        self.assertAlmostEqual(info["box"][1][0] - info["box"][0][0], 0.014, delta=0.001)
        self.run_well("convert", self.folder / "m.vtu", self.folder / "cm.vtu", "--out-unit", "cm")
        info = json.loads(self.run_well("info", self.folder / "cm.vtu", "--json").stdout)
        self.assertEqual(info["unit"], "cm")
        self.assertAlmostEqual(info["box"][1][0] - info["box"][0][0], 1.4, delta=0.1)
        self.run_well("evaluate", self.folder / "cm.vtu", "--image", image, "--unit", "cm")
        self.assertEqual(self.run_lumesh("info", image, "--unit", "inch").returncode, USAGE)

    def test_check_lists_what_touches_and_commands_change_it(self):
        def pair(place):
            i, j, k = place
            return 1 if math.hypot(j - 7, k - 11.5) <= 3.2 or math.hypot(i - 12, j - 14.2) <= 3.4 else 0
        voxels = cube(pair)
        voxels[0] = 1
        image = self.write("pair.nrrd", voxels)
        found = {f["kind"]: f for f in json.loads(self.run_well("check", image, "--json").stdout)["findings"]}
        self.assertEqual(found["islands"]["voxels"], [[0, 0, 0]])
        self.assertEqual(found["touching"]["count"], 1)
        self.assertIn("--touching", found["touching"]["remedy"])
        i, j, k = found["touching"]["voxels"][0]
        self.assertLess(math.dist((i, j, k), (12, 10.5, 11.5)), 3)
        for choice, pieces in (("separate", 2), ("join", 1)):
            result = self.run_well("lattice", image, "--touching", choice, "--drop-below", 9, "-o", self.mesh)
            self.assertIn("1 voxels, 1 mm³, of small pieces", result.stderr)
            self.assertIn("between vessels", result.stderr)
            label = json.loads(self.run_well("info", image, "--touching", choice, "--drop-below", 9, "--json").stdout)["labels"][0]
            self.assertEqual(label["components"], pieces)
            numbers = self.folder / "numbers.json"
            self.run_well("evaluate", self.mesh, "--json", numbers)

    def test_the_table_of_info_names_options_as_the_command_line_does(self):
        image = SHARED / "multi-label/MRIcrop-seg.gipl.gz"
        if not image.exists():
            self.skipTest(f"no {image}")
        numbers = self.folder / "numbers.json"
        for told in (self.run_well("info", image, "--json", numbers).stdout, numbers.read_text()):
            self.assertIn("or give a plane with --cut-plane", told)

    def test_a_thrombus_around_a_lumen_is_told_and_gets_another_name(self):
        """Its ring is six times as large as the lumen: too large for a wall that is known as such."""
        def label_at(p):
            off = math.dist(p[:2], MIDDLE[:2])
            return 1 if off < 3.6 else 2 if off < 9.6 else 0
        image = self.write("thrombus.nrrd", cube(label_at))
        told = self.run_well("info", image).stderr
        self.assertRegex(told, r"let_\d_label_1 at .* shares \d+ % of its outline with \w+_label_2 \(1 of 2 such openings\)")
        mesh = self.folder / "out.vtu"
        result = self.run_well("delaunay", image, "-o", mesh, "--strict", "--name", "inlet_1_label_2=wall_rim_1",
                               "--name", "outlet_1_label_2=wall_rim_2", "--json", self.folder / "numbers.json")
        self.assertIn("of its outline", result.stderr)
        self.assertNotIn("missing", result.stderr)
        numbers = json.loads((self.folder / "numbers.json").read_text())
        patches = json.loads(self.run_well("info", mesh, "--json").stdout)["patches"]
        self.assertEqual({patch["name"]: patch["kind"] for patch in patches if "rim" in patch["name"]},
                         {"wall_rim_1": "opening", "wall_rim_2": "opening"})
        self.assertTrue(any("of its outline" in line for line in numbers["warnings"]))
        self.assertNotIn("outline", self.run_well("info", image, "--labels", 1).stderr)

    def test_numbers_of_pieces_are_said(self):
        def pair(place):
            i, j, k = place
            return 1 if math.hypot(j - 7, k - 11.5) <= 3.2 or math.hypot(i - 12, j - 14.2) <= 3.4 else 0
        voxels = cube(pair)
        image = self.write("pair.nrrd", voxels)
        said = self.run_well("info", image, "--touching", "separate").stderr
        self.assertNotIn("pieces", said)
        voxels[0] = 1
        image = self.write("speck.nrrd", voxels)
        self.assertIn("the object is in 2 pieces now, 2 before", self.run_well("info", image, "--touching", "join").stderr)
        ball = self.write("ball.nrrd", cube(lambda p: 1 if depth(p, 7) >= 0 else 0))
        self.assertIn("no vessels that touch were found; the object stays in 1 piece",
                      self.run_well("info", ball, "--touching", "separate").stderr)

    def test_meshers_tell_of_a_bridge_that_is_not_in_the_mesh(self):
        def bridged(place):
            i, j, k = place
            if (j, k) == (11, 11) and 7 <= i <= 16:
                return 1
            return 1 if min(math.dist(place, (6, 11, 11)), math.dist(place, (17, 11, 11))) <= 3.5 else 0
        image = self.write("bridged.nrrd", cube(bridged))
        told = "label 1 with 2 pieces and Euler number 2, of 1 and 1;"
        for options, remedy in ((("--mixed",), "--boundary exact"), ((), "--edge-length")):
            result = self.run_well("lattice", image, "-o", self.mesh, *options)
            self.assertIn(told, result.stderr)
            self.assertIn(remedy, result.stderr)
        numbers = self.folder / "numbers.json"
        result = self.run_well("delaunay", image, "-o", self.mesh, "--json", numbers)
        self.assertEqual(told in result.stderr, told in str(json.loads(numbers.read_text())["differences_from_image"]))
        case = self.folder / "case.toml"
        for mesher in ("lattice", "delaunay"):
            case.write_text(f'mesher = "{mesher}"\n[input]\nimage = "bridged.nrrd"\n[output]\nmeshes = ["m.vtu"]\n')
            report = self.run_lumesh("run", case, "-o", self.folder / "out")
            if mesher == "lattice":
                self.assertIn(told, report.stderr)
                self.assertIn("with 2 pieces and Euler number 2", (self.folder / "out" / "report.html").read_text())


if __name__ == "__main__":
    unittest.main()
