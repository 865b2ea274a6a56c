#!/usr/bin/env python3
"""Names of patches through every stage and format: the tables of docs/stages/surfaces.md, cell by cell.

A tube with a wall and two ends goes in; what comes out is read without lumesh (patch_files.py), and each patch must have the
area and the place that it had. Usage: names_test.py LUMESH
"""
import gzip
import json
import math
import os
import pathlib
import re
import shutil
import sys
import tempfile
import unittest

DEBIAN_PYTHON = "/usr/bin/python3"  # Where h5py may be, if it is not here.

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import patch_files

if not patch_files.HAS_HDF5 and os.path.realpath(sys.executable) != os.path.realpath(DEBIAN_PYTHON) and os.access(DEBIAN_PYTHON, os.X_OK):
    os.execv(DEBIAN_PYTHON, [DEBIAN_PYTHON, *sys.argv])

import nrrd
from cube import write_sol
from program import ProgramTest

ROOT = pathlib.Path(__file__).resolve().parents[2]
TAGGED = ROOT.parent / "shared" / "data" / "surfaces" / "tagged"
PAGE = ROOT / "docs" / "stages" / "surfaces.md"

RADIUS, LENGTH, AROUND, ROWS = 2.0, 6.0, 16, 8
PARTS = ("aorta", "inlet_a", "outlet_b")
FACE_IDS = (3, 7, 12)  # Of the parts.
ADDED = {"layer_inner"}  # By inward layers, between them and the core.
LAYERS = ("--side", "inward", "--first-height", 0.1, "--count", 2)

# What each word in the tables says of the keys by which the parts come out.
KEYS = {"names": PARTS, "`face_N`": [f"face_{i}" for i in FACE_IDS], "`patch_N`": ["patch_1", "patch_2", "patch_3"]}
NUMBERS, NOT_TAKEN, MIXED = "numbers", "–", "mixed"


def tube():
    """Points and the triangles of each part."""
    points = [(RADIUS * math.cos(2 * math.pi * i / AROUND), RADIUS * math.sin(2 * math.pi * i / AROUND), LENGTH * row / ROWS)
              for row in range(ROWS + 1) for i in range(AROUND)]
    points += [(0.0, 0.0, 0.0), (0.0, 0.0, LENGTH)]
    wall, first, last = [], [], []
    for i in range(AROUND):
        after, top = (i + 1) % AROUND, ROWS * AROUND
        for row in range(0, top, AROUND):
            wall += [(row + i, row + after, row + i + AROUND), (row + after, row + after + AROUND, row + i + AROUND)]
        first.append((after, i, len(points) - 2))
        last.append((top + i, top + after, len(points) - 1))
    return points, dict(zip(PARTS, (wall, first, last)))


def table(head):
    """Rows of the page's table whose first word is that: {format: {stage: word}}."""
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    begin = next(i for i, line in enumerate(lines) if line.startswith(f"| {head} |"))
    rows = []
    for line in lines[begin:]:
        if not line.startswith("|"):
            break
        rows.append([cell.strip() for cell in line.strip("|").split("|")])
    return {row[0]: dict(zip(rows[0][1:], row[1:], strict=True)) for row in rows[2:]}


def area_and_middle(faces):
    """Of polygons: their area, and the mean place on them."""
    area, moment = 0.0, [0.0, 0.0, 0.0]
    for a, *rest in faces:
        for b, c in zip(rest, rest[1:]):
            u, v = [b[k] - a[k] for k in range(3)], [c[k] - a[k] for k in range(3)]
            own = math.hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]) / 2
            area += own
            moment = [m + own * (a[k] + b[k] + c[k]) / 3 for k, m in enumerate(moment)]
    return area, [m / area for m in moment]


# Of what is written: (name of the file, how it is read, its unit in mm).
WRITTEN = {
    "`.vtu`": ("out.vtu", patch_files.read_vtu, 1),
    "`.vtk`": ("out.vtk", patch_files.read_legacy_vtk, 1),
    "`.msh`": ("out.msh", patch_files.read_gmsh, 1),
    "`.mesh`": ("out.mesh", patch_files.read_medit, 1),
    "`.meshb`": ("out.meshb", patch_files.read_medit_binary, 1),
    "`.foam`": ("out.foam", patch_files.read_foam, 1000),
    "`.xdmf`": ("out.xdmf", patch_files.read_xdmf, 1),
    "`NAME-mesh-complete`": ("out-mesh-complete", patch_files.read_simvascular, 1),
    "`.vtp`": ("out.vtp", patch_files.read_vtp, 1),
}
# Of what is read: (name of the surface, options, keys of [input]).
READ = {
    "`.vtp` of lumesh": ("named.vtp", (), ""),
    "`.vtp`, `ModelFaceID`": ("model.vtp", (), ""),
    "`.vtp`, `CellEntityIds`": ("entities.vtp", (), ""),
    "`.vtp`, `--patch-array`": ("array.vtp", ("--patch-array", "part"), 'patch_array = "part"\n'),
    "`.vtk` of PolyData": ("model.vtk", (), ""),
    "`.stl` of solids": ("tube.stl", (), ""),
    "`.stl.gz` of solids": ("tube.stl.gz", (), ""),
    "`.obj`": ("tube.obj", (), ""),
    "`.msh`": ("tube.msh", (), ""),
    "`.mesh`": ("tube.mesh", (), ""),
    "`.meshb`": ("tube.meshb", (), ""),
    "`.vtu`": ("tube.vtu", (), ""),
    "`.vtk`": ("tube.vtk", (), ""),
}
VOLUMES = ("`.msh`", "`.mesh`", "`.meshb`", "`.vtu`", "`.vtk`")  # These hold volumes, too.


class NamesTest(ProgramTest):
    @classmethod
    def setUpClass(cls):
        cls.inputs = pathlib.Path(tempfile.mkdtemp(prefix="lumesh_names_"))
        cls.addClassCleanup(shutil.rmtree, cls.inputs, ignore_errors=True)
        cls("write_inputs").write_inputs()

    def write_inputs(self):
        """Surfaces in every format, and a mesh with its layers, whole and in two parts, in those of volumes."""
        folder, surface = self.inputs, tube()
        patch_files.write_stl(folder / "tube.stl", *surface)
        (folder / "tube.stl.gz").write_bytes(gzip.compress((folder / "tube.stl").read_bytes()))
        patch_files.write_obj(folder / "tube.obj", *surface)
        patch_files.write_gmsh(folder / "tube.msh", *surface)
        patch_files.write_vtp(folder / "named.vtp", *surface, "patch", range(len(PARTS)), has_names=True)
        for name, array in (("model", "ModelFaceID"), ("entities", "CellEntityIds"), ("array", "part")):
            patch_files.write_vtp(folder / f"{name}.vtp", *surface, array, FACE_IDS)
        patch_files.write_polydata(folder / "model.vtk", *surface, "ModelFaceID", FACE_IDS)
        self.run_well("delaunay", folder / "tube.stl", "-o", folder / "volume.vtu", "--edge-length", 1, "-q")
        self.run_well("layers", folder / "volume.vtu", *LAYERS, "-o", folder / "layered.vtu", "-q")
        for row in VOLUMES:
            extension = row.strip("`")
            for kind, source in (("tube", "tube.msh"), ("volume", "volume.vtu")):
                if not (folder / (kind + extension)).exists():
                    self.run_well("convert", folder / source, folder / (kind + extension), "-q")
            for label, kind in ((1, "core"), ("layer", "layers")):
                self.run_well("convert", folder / "layered.vtu", folder / (kind + extension), "--only-labels", label, "-q")
        points = json.loads(self.run_well("info", folder / "volume.vtu", "--json").stdout)["points"]
        write_sol(folder / "sizes.sol", [(1, 0, 1, 0, 0, 1)] * points)

    def command(self, stage, row, out):
        """What reads the file of a row and writes to `out`."""
        surface, options, keys = READ[row]
        volume = self.inputs / ("volume" + row.strip("`")) if row in VOLUMES else self.inputs / surface
        surface = self.inputs / surface
        if stage == "delaunay":
            return stage, surface, *options, "--edge-length", 1, *self.output(stage, out)
        if stage == "run":
            case = self.folder / "case.toml"
            meshes = f'surface = "{out.name}"' if out.suffix == ".vtp" else f'meshes = ["{out.name}"]'
            case.write_text(f'mesher = "delaunay"\n[input]\nsurface = "{surface}"\n{keys}[delaunay]\nedge_length = 1\n'
                            f'[output]\nfolder = "{out.parent}"\n{meshes}\nreport = ""\njson = ""\n', encoding="utf-8")
            return stage, case
        if stage == "repair":
            return stage, surface, *options, "-o", out
        if stage == "merge":
            parts = [self.inputs / (kind + volume.suffix) for kind in ("core", "layers")]
            return stage, *(parts if row in VOLUMES else [volume] * 2), "-o", out
        more = {"adapt": ("--metric", self.inputs / "sizes.sol"), "layers": LAYERS, "convert": options, "improve": ()}[stage]
        return stage, volume, *more, "-o", out

    def output(self, stage, out):
        if out.suffix != ".vtp" or stage != "delaunay":
            return "-o", out
        return "-o", self.folder / "volume.vtu", "--surface", out

    def check_cell(self, row, stage, word, command, out, read, unit_mm):
        with self.subTest(format=row, stage=stage):
            result = self.run_lumesh(*command, "-q")
            if word == NOT_TAKEN:
                self.assertIn(result.returncode, (1, 2), "the page says that this is not taken")
                return
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assert_patches(read(out), word, unit_mm)

    def assert_patches(self, found, word, unit_mm):
        polygon = AROUND / 2 * RADIUS ** 2 * math.sin(2 * math.pi / AROUND)
        areas = (2 * AROUND * RADIUS * math.sin(math.pi / AROUND) * LENGTH, polygon, polygon)
        found = {key: area_and_middle(faces) for key, faces in found.items()}
        if word == MIXED:  # No face is lost: those of the parts' patches, and those between the parts.
            self.assertTrue(all(key.startswith("patch_") for key in found))
            self.assertGreater(sum(area for area, _ in found.values()), sum(areas))
            return
        middles = ((0, 0, LENGTH / 2), (0, 0, 0), (0, 0, LENGTH))
        if word == NUMBERS:  # Each part has one of its own.
            keys = [min(found, key=lambda key: math.dist(found[key][1], middle) + abs(found[key][0] * unit_mm ** 2 - area))
                    for area, middle in zip(areas, middles)]
            self.assertEqual(len(set(keys)), len(keys))
            self.assertLessEqual(set(found), set(range(1, len(PARTS) + 2)))
        else:
            keys = KEYS[word]
            self.assertLessEqual(set(keys), set(found))
            self.assertLessEqual(set(found), {*keys, *ADDED})
        for key, area, middle in zip(keys, areas, middles):
            got, place = found[key]
            self.assertAlmostEqual(got * unit_mm ** 2 / area, 1, delta=0.05, msg=f"area of {key}")
            self.assertLess(math.dist([unit_mm * x for x in place], middle), 0.1, f"place of {key}")

    def scratch(self, name):
        folder = pathlib.Path(tempfile.mkdtemp(dir=self.folder))
        return folder / name

    def test_every_format_that_is_read(self):
        rows = table("Read")
        self.assertEqual(list(rows), list(READ))
        for row, stages in rows.items():
            for stage, word in stages.items():
                is_surface = stage == "repair" or (stage == "convert" and row not in VOLUMES)
                out = self.scratch("out.vtp" if is_surface else "out.vtu")
                read = patch_files.read_vtp if is_surface else patch_files.read_vtu
                self.check_cell(row, stage, word, self.command(stage, row, out), out, read, 1)

    def test_every_format_that_is_written(self):
        rows = table("Written")
        self.assertEqual(list(rows), list(WRITTEN))
        for row, stages in rows.items():
            name, read, unit_mm = WRITTEN[row]
            if read is patch_files.read_xdmf and not patch_files.HAS_HDF5:
                print(f"names_test: {row} is left out: python3-h5py is missing; scripts/packages.sh test installs it")
                continue
            for stage, word in stages.items():
                out = self.scratch(name)
                source = "`.stl` of solids" if stage in ("delaunay", "run") else "`.vtu`"
                self.check_cell(row, stage, word, self.command(stage, source, out), out, read, unit_mm)

    def test_gmsh_2_2_has_the_names_too(self):
        out = self.folder / "out.msh"
        self.run_well("convert", self.inputs / "volume.vtu", out, "--msh-version", "2.2")
        self.assert_patches(patch_files.read_gmsh(out), "names", 1)

    def test_a_name_that_a_solver_would_not_take_is_told(self):
        odd = self.folder / "odd.msh"
        self.run_well("convert", self.inputs / "volume.vtu", odd, "--msh-version", "2.2")
        names = list(patch_files.read_gmsh(odd))
        odd.write_bytes(odd.read_bytes().replace(f'"{names[0]}"'.encode(), b'"dome wall"'))
        for out in ("odd.foam", "odd-mesh-complete"):
            told = self.run_well("convert", odd, self.scratch(out)).stderr
            self.assertIn('"dome wall" is dome_wall', told)
            self.assertEqual(told.count('" is '), 1, told)
        self.assertNotIn("dome_wall", self.run_well("convert", odd, self.folder / "odd.vtu").stderr)

    def test_start_values_of_openfoam_that_name_other_patches_are_told(self):
        case, renamed = self.scratch("cfd/case.foam"), self.folder / "renamed.vtu"
        (case.parent / "0").mkdir(parents=True)
        convert = ("convert", self.inputs / "volume.vtu", case)
        for name in ("U", "p"):
            (case.parent / "0" / name).write_text("dimensions [0 1 -1 0 0 0 0];\nboundaryField // of the tube\n{\n" + "".join(
                f"    {patch}\n    {{\n        type zeroGradient; value {{ a 1; }}\n    }}\n" for patch in ("wall", "inlet_a", "outlet_b")) + "}\n")
        self.assertNotIn("no entry", self.run_well(*convert).stderr)
        self.run_well("rename", self.inputs / "volume.vtu", "-o", renamed, "--name", "outlet_b=ica")
        told = self.run_well("convert", renamed, case).stderr
        self.assertIn("case.foam: 0/U, 0/p have no entry for ica, but for outlet_b, which no patch has", told)
        (case.parent / "0/U").write_text('boundaryField { ".*" { type zeroGradient; } }')
        self.assertIn("0/p has no entry for ica", self.run_well("convert", renamed, case).stderr)

    def test_models_of_simvascular_keep_their_face_ids(self):
        models = sorted(TAGGED.glob("*.vtp")) if TAGGED.is_dir() else []
        if not models:
            self.skipTest(f"no models in {TAGGED}")
        for model in models:
            with self.subTest(model.name):
                out = self.folder / f"{model.stem}-mesh-complete"
                self.run_well("delaunay", model, "-o", out, "-q")
                given = {key: area_and_middle(faces) for key, faces in patch_files.read_face_ids(model).items()}
                self.assertGreater(len(given), 2)
                found = patch_files.read_face_ids(out / "mesh-complete.exterior.vtp")
                files = patch_files.read_simvascular(out)
                self.assertEqual(set(found), set(given))
                self.assertEqual(set(files), {f"face_{key}" for key in given})
                for key, (area, middle) in given.items():
                    for faces in (found[key], files[f"face_{key}"]):
                        got, place = area_and_middle(faces)
                        self.assertAlmostEqual(got / area, 1, delta=0.05, msg=f"area of face {key}")
                        self.assertLess(math.dist(place, middle), 0.1 * math.sqrt(area), f"place of face {key}")

    def test_face_ids_stay_with_faces_that_are_renamed_or_exchange_their_names(self):
        made, named, swapped = (self.folder / f"{name}.vtu" for name in ("made", "named", "swapped"))
        self.run_well("delaunay", self.inputs / "model.vtp", "-o", made, "--edge-length", 1, "-q")
        self.run_well("rename", made, "-o", named, "--name", "face_12=in:inlet", "--name", "face_7=out:outlet")
        self.run_well("rename", named, "-o", swapped, "--name", "in=out:outlet", "--name", "out=in:inlet")
        self.run_well("improve", named, "-o", named)
        places = {}
        for mesh in (made, named, swapped):
            out = self.folder / f"{mesh.stem}-mesh-complete"
            self.run_well("convert", mesh, out)
            faces = patch_files.read_face_ids(out / "mesh-complete.exterior.vtp")
            places[mesh.stem] = {key: [round(x, 1) for x in area_and_middle(of_face)[1]] for key, of_face in faces.items()}
        self.assertEqual(set(places["made"]), set(FACE_IDS))
        self.assertEqual(places["named"], places["made"])
        self.assertEqual(places["swapped"], places["made"])

    def test_names_that_a_format_has_no_place_for_are_told(self):
        volume = self.inputs / "volume.vtu"
        for command in (("rename", volume, "-o", "out.meshb", "--name", "aorta=main"), ("convert", volume, "out.meshb"),
                        ("improve", volume, "-o", "out.meshb"), ("convert", volume, "out.stl")):
            told = self.run_lumesh(*command, cwd=self.folder)
            self.assertEqual(told.returncode, 0, told.stderr)
            self.assertRegex(told.stderr, r"warning: out\.\w+: this format has no names and kinds of patches: (aorta|main), inlet_a, outlet_b are lost in it")
        for quiet in (("convert", volume, "out.mesh"), ("convert", self.inputs / "volume.meshb", "again.meshb")):
            self.assertNotIn("lost in it", self.run_lumesh(*quiet, cwd=self.folder).stderr)

    def test_flat_patches_that_count_as_wall_are_told_until_they_are_named(self):
        bare, named = self.folder / "bare.msh", self.folder / "named.vtu"
        text = (self.inputs / "volume.msh").read_text(encoding="utf-8")
        begin, end = text.index("$Comments"), text.index("$EndComments")  # Where lumesh says the kinds.
        text = text[:begin] + text[end + len("$EndComments\n"):]
        bare.write_text(text.replace('"inlet_a"', '"ica"').replace('"outlet_b"', '"m1"'), encoding="utf-8")
        words = "no patch is an opening: the flat patches ica, m1 count as wall; say what they are by renaming them, --name ica=NAME:inlet"
        for command in (("convert", bare, self.folder / "case.foam"), ("layers", bare, *LAYERS, "-o", self.folder / "layered.vtu"),
                        ("info", bare)):
            self.assertEqual(self.run_well(*command).stderr.count(words), 1, command)
        self.run_well("rename", bare, "-o", named, "--name", "ica=in:inlet", "--name", "m1=out:outlet")
        kinds = {patch["name"]: patch["kind"] for patch in json.loads(self.run_well("info", named, "--json").stdout)["patches"]}
        self.assertEqual(kinds, {"aorta": "wall", "in": "inlet", "out": "outlet"})
        for command in (("convert", named, self.folder / "case.foam"), ("info", named), ("info", self.inputs / "volume.msh")):
            self.assertNotIn("count as wall", self.run_well(*command).stderr)

    def test_flat_patches_beside_a_wall_between_labels_are_told(self):
        image, mesh, bare = self.folder / "two.nrrd", self.folder / "two.msh", self.folder / "bare.msh"
        voxels = [(1 if k < 12 else 2) if math.hypot(i - 9.3, j - 9.6) < 6 else 0 for k in range(24) for j in range(20) for i in range(20)]
        nrrd.write(image, [20, 20, 24], voxels)
        self.run_well("delaunay", image, "-o", mesh, "--edge-length", 3)
        text = mesh.read_text(encoding="utf-8")
        begin, end = text.index("$Comments"), text.index("$EndComments")  # Where lumesh says the kinds.
        text = text[:begin] + text[end + len("$EndComments\n"):]
        bare.write_text(re.sub('"(wall_|interface_|inlet_|outlet_)', r'"part_\1', text), encoding="utf-8")
        told = self.run_well("info", bare).stderr
        self.assertRegex(told, r"the flat patches part_inlet_1\w*, part_outlet_1\w* count as wall")


if __name__ == "__main__":
    unittest.main()
