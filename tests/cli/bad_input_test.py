#!/usr/bin/env python3
"""What the program does with bad input: the right exit code, one clear line on stderr, no file left behind.

Usage: bad_input_test.py LUMESH      Exit codes of lumesh: 1 usage, 2 bad input, 3 request not reached, 5 memory.
"""
import contextlib
import os
import pathlib
import random
import resource
import shutil
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import nrrd
from program import BAD_INPUT, LUMESH, MEMORY, NOT_REACHED, USAGE, ProgramTest

SIZE = 24
NOBODY = 65534


def limit_address_space():
    """3 GiB: what asks for more must find out by itself, not by the machine's end."""
    resource.setrlimit(resource.RLIMIT_AS, (3 << 30, 3 << 30))


@contextlib.contextmanager
def small_tmpfs(folder):
    """A disk of 64 KiB; None where mounting is not permitted."""
    folder.mkdir()
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", str(folder)], capture_output=True,
                             check=False).returncode == 0
    try:
        yield folder if mounted else None
    finally:
        if mounted:
            subprocess.run(["umount", str(folder)], check=True)


class BadInputTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.folder.chmod(0o755)  # Others may look in: some tests run as nobody.
        self.good = nrrd.write(self.folder / "good.nrrd", [SIZE] * 3, nrrd.ball(SIZE, 8))
        self.mesh = self.folder / "out.vtu"

    def assert_refused(self, result, code, *words):
        self.assertEqual(result.returncode, code, result.stderr)
        errors = [line for line in result.stderr.splitlines() if not line.startswith("lumesh: warning: ")]
        self.assertEqual(len(errors), 1, f"one line is wanted on stderr, not:\n{result.stderr}")
        self.assertTrue(errors[0].startswith("lumesh: error: "), errors[0])
        for word in words:
            self.assertIn(str(word).lower(), errors[0].lower())
        for trace in ("terminate called", "itk::", "what():", "/usr/include", "std::", "[nrrd]", "fread"):
            self.assertNotIn(trace, result.stderr)

    def assert_nothing_written(self, folder=None, before=()):
        """No mesh, no half-written file beside it."""
        left = {path.name for path in (folder or self.folder).iterdir()}
        kept = set(before) if folder else {"good.nrrd", "bad.nrrd", "bad.nii.gz", "bad.xyz", "bad.vtu", "bad.msh", "bad.mha"}
        self.assertEqual(left - kept, set())

    def assert_image_refused(self, image, code, *words, options=()):
        result = self.run_lumesh("lattice", image, "-o", self.mesh, *options, preexec_fn=limit_address_space)
        self.assert_refused(result, code, *words)
        self.assert_nothing_written()

    def bad(self, **options):
        """good.nrrd with something else in it."""
        arguments = {"sizes": [SIZE] * 3, "voxels": nrrd.ball(SIZE, 8), **options}
        return nrrd.write(self.folder / "bad.nrrd", **arguments)

    # Files that are not what they should be.

    def test_noise_is_refused_by_both_meshers_at_once(self):
        draw = random.Random(3)
        noise = nrrd.write(self.folder / "noise.nrrd", [SIZE] * 3, [draw.randrange(1, 21) for _ in range(SIZE ** 3)])
        for command in ("lattice", "delaunay"):
            options = ("--delta", "2") if command == "delaunay" else ()
            result = self.run_lumesh(command, noise, "-o", self.mesh, *options)
            self.assert_refused(result, BAD_INPUT, "noise.nrrd", "look like grey values", "threshold")
            result = self.run_lumesh(command, noise, "-o", self.mesh, "--labels", ",".join(map(str, range(1, 21))), *options)
            self.assert_refused(result, BAD_INPUT, "noise.nrrd", "no segmentation", "threshold")
            self.assertFalse(self.mesh.exists())

    def test_the_good_image_is_meshed_so_that_the_tests_below_fail_for_their_own_reason(self):
        result = self.run_lumesh("lattice", self.good, "-o", self.mesh)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        self.assertTrue(self.mesh.stat().st_size > 0)

    def test_missing_file(self):
        self.assert_image_refused(self.folder / "none.nrrd", BAD_INPUT, "none.nrrd")

    def test_truncated_nrrd(self):
        self.bad()
        data = (self.folder / "bad.nrrd").read_bytes()
        (self.folder / "bad.nrrd").write_bytes(data[:len(data) // 2])
        self.assert_image_refused(self.folder / "bad.nrrd", BAD_INPUT, "bad.nrrd")

    def test_truncated_gzip_data(self):
        self.bad(encoding="gzip")
        data = (self.folder / "bad.nrrd").read_bytes()
        (self.folder / "bad.nrrd").write_bytes(data[:-60])
        self.assert_image_refused(self.folder / "bad.nrrd", BAD_INPUT, "bad.nrrd")

    def test_header_cut_in_the_middle_of_a_line(self):
        self.bad()
        data = (self.folder / "bad.nrrd").read_bytes()
        (self.folder / "bad.nrrd").write_bytes(data[:40])
        self.assert_image_refused(self.folder / "bad.nrrd", BAD_INPUT, "bad.nrrd")

    def test_empty_files(self):
        for name in ("bad.nrrd", "bad.nii.gz", "bad.mha"):
            with self.subTest(name):
                (self.folder / name).write_bytes(b"")
                self.assert_image_refused(self.folder / name, BAD_INPUT, name)

    def test_file_of_noise(self):
        noise = bytes((7 * i * i + 13) % 251 for i in range(5000))
        for name in ("bad.nrrd", "bad.nii.gz", "bad.mha"):
            with self.subTest(name):
                (self.folder / name).write_bytes(noise)
                self.assert_image_refused(self.folder / name, BAD_INPUT, name)

    def test_wrong_extension_of_the_image(self):
        shutil.copy(self.good, self.folder / "bad.xyz")
        self.assert_image_refused(self.folder / "bad.xyz", BAD_INPUT, "bad.xyz")

    def test_wrong_extension_of_the_mesh(self):
        result = self.run_lumesh("lattice", self.good, "-o", self.folder / "out.xyz")
        self.assertIn(result.returncode, (USAGE, BAD_INPUT))
        self.assert_refused(result, result.returncode, "out.xyz")
        self.assert_nothing_written()

    def test_a_folder_instead_of_a_file(self):
        (self.folder / "bad.nrrd").mkdir()
        self.assert_image_refused(self.folder / "bad.nrrd", BAD_INPUT, "bad.nrrd")

    # Images that cannot be meshed.

    def test_two_dimensions(self):
        self.assert_image_refused(self.bad(sizes=[SIZE, SIZE], voxels=[1] * SIZE ** 2), BAD_INPUT, "bad.nrrd", "3")

    def test_four_dimensions(self):
        image = self.bad(sizes=[8, 8, 8, 2], voxels=[1] * 1024)
        self.assert_image_refused(image, BAD_INPUT, "bad.nrrd", "2 volumes", "--frame")

    def test_all_zero(self):
        self.assert_image_refused(self.bad(voxels=[0] * SIZE ** 3), BAD_INPUT, "label")

    def test_no_such_label(self):
        self.assert_image_refused(self.good, BAD_INPUT, "good.nrrd", "3", "1", options=["--labels", "3"])

    def test_threshold_above_every_voxel(self):
        self.assert_image_refused(self.good, BAD_INPUT, "threshold", options=["--threshold", "99"])

    def test_infinity(self):
        voxels = [float(v) for v in nrrd.ball(SIZE, 8)]
        voxels[100] = float("inf")
        self.assert_image_refused(self.bad(voxels=voxels, kind="float"), BAD_INPUT, "bad.nrrd")

    def test_spacing_that_makes_no_sense(self):
        for value in ("0", "nan", "inf"):
            with self.subTest(value):
                directions = f"({value},0,0) (0,1,0) (0,0,1)"
                self.assert_image_refused(self.bad(header={"space directions": directions}), BAD_INPUT, "bad.nrrd")

    def test_negative_spacing(self):
        image = self.bad(header={"space": None, "space directions": None, "space origin": None, "spacings": "-1 1 1"})
        self.assert_image_refused(image, BAD_INPUT, "bad.nrrd", "spacing")

    def test_sheared_axes(self):
        image = self.bad(header={"space directions": "(1,0,0) (0.5,1,0) (0,0,1)"})
        self.assert_image_refused(image, BAD_INPUT, "bad.nrrd")

    # Images at the border of what can be meshed: a valid mesh, or one clear line, never a crash.

    def assert_meshed_or_refused(self, image, *options):
        result = self.run_lumesh("lattice", image, "-o", self.mesh, *options)
        if result.returncode == 0:
            self.assertTrue(self.mesh.stat().st_size > 0)
            check = self.run_lumesh("evaluate", self.mesh, "--json", self.folder / "out.json")
            self.assertEqual(check.returncode, 0, check.stderr)
            self.assertIn('"valid": true', (self.folder / "out.json").read_text())
        else:
            self.assertIn(result.returncode, (BAD_INPUT, NOT_REACHED))
            self.assert_refused(result, result.returncode)
            self.assert_nothing_written()

    def test_all_one_label(self):
        self.assert_meshed_or_refused(self.bad(voxels=[1] * SIZE ** 3))

    def test_one_voxel(self):
        voxels = [0] * SIZE ** 3
        voxels[(12 * SIZE + 12) * SIZE + 12] = 1
        self.assert_meshed_or_refused(self.bad(voxels=voxels))

    def test_object_touching_every_border(self):
        self.assert_meshed_or_refused(self.bad(voxels=nrrd.ball(SIZE, 14)))

    def test_image_of_one_voxel(self):
        self.assert_meshed_or_refused(self.bad(sizes=[1, 1, 1], voxels=[1]))

    def test_one_slice(self):
        self.assert_meshed_or_refused(self.bad(sizes=[SIZE, SIZE, 1], voxels=[1] * SIZE ** 2))

    def test_voxels_that_touch_at_corners_only(self):
        voxels = [(i + j + k) % 2 if 8 <= min(i, j, k) and max(i, j, k) < 14 else 0
                  for k in range(SIZE) for j in range(SIZE) for i in range(SIZE)]
        self.assert_meshed_or_refused(self.bad(voxels=voxels))

    # Requests and surroundings that cannot be met.

    def test_options_out_of_range(self):
        for options in (["--spacing", "-1"], ["--spacing", "nan"], ["--fidelity", "7"],
                        ["--min-dihedral", "80"], ["--threads", "-3"], ["--cut-plane", "0", "0", "0", "0", "0", "0"]):
            with self.subTest(options):
                self.mesh.unlink(missing_ok=True)
                self.assert_image_refused(self.good, USAGE, options=options)

    def test_unknown_options_and_commands(self):
        for arguments in (["lattice", self.good, "-o", self.mesh, "--no-such-option"], ["no-such-command"], [],
                          ["lattice", self.good], ["lattice"]):
            with self.subTest(arguments):
                result = self.run_lumesh(*arguments)
                self.assertEqual(result.returncode, USAGE, result.stderr)
                self.assert_nothing_written()

    def test_header_that_promises_more_voxels_than_any_memory_holds(self):
        image = self.bad(header={"sizes": "100000 100000 100000"})
        self.assertIn(self.run_lumesh("lattice", image, "-o", self.mesh, preexec_fn=limit_address_space).returncode,
                      (BAD_INPUT, MEMORY))
        self.assert_nothing_written()

    def test_spacing_that_asks_for_more_elements_than_memory_holds(self):
        self.assert_image_refused(self.good, MEMORY, "memory", options=["--spacing", "0.001"])

    def test_output_folder_missing(self):
        result = self.run_lumesh("lattice", self.good, "-o", self.folder / "nowhere" / "out.vtu")
        self.assert_refused(result, BAD_INPUT, "nowhere")
        self.assert_nothing_written()

    def test_output_folder_not_writable(self):
        closed = self.folder / "closed"
        closed.mkdir(mode=0o555)
        options = {}
        if os.getuid() == 0:  # root may write everywhere: be somebody else
            options = {"user": NOBODY, "group": NOBODY}
            if subprocess.run([LUMESH, "--version"], capture_output=True, check=False, **options).returncode != 0:
                self.skipTest("the program is in a folder that only root may enter")
        result = self.run_lumesh("lattice", self.good, "-o", closed / "out.vtu", **options)
        self.assert_refused(result, BAD_INPUT, "closed")
        self.assert_nothing_written(closed)

    def test_disk_full(self):
        with small_tmpfs(self.folder / "disk") as disk:
            if disk is None:
                self.skipTest("mounting a small disk is not permitted here")
            for name in ("out.vtu", "out.vtk", "out.mesh", "out.meshb", "out.msh", "out.xdmf", "out-mesh-complete"):
                with self.subTest(name):
                    result = self.run_lumesh("lattice", self.good, "-o", disk / name, "--spacing", "0.7")
                    self.assert_refused(result, BAD_INPUT, pathlib.Path(name).stem)  # Or a file beside it.
                    self.assert_nothing_written(disk)

    def test_a_good_file_survives_a_run_that_fails(self):
        with small_tmpfs(self.folder / "disk") as disk:
            if disk is None:
                self.skipTest("mounting a small disk is not permitted here")
            (disk / "out.vtu").write_text("precious")
            result = self.run_lumesh("lattice", self.good, "-o", disk / "out.vtu", "--spacing", "0.7")
            self.assert_refused(result, BAD_INPUT, "out.vtu")
            self.assertEqual((disk / "out.vtu").read_text(), "precious")
            self.assert_nothing_written(disk, ["out.vtu"])

    # The other commands.

    def test_info_of_bad_files(self):
        (self.folder / "bad.nrrd").write_bytes(b"NRRD0004\n")
        for name in ("none.nrrd", "bad.nrrd", "none.vtu"):
            with self.subTest(name):
                self.assert_refused(self.run_lumesh("info", self.folder / name), BAD_INPUT, name)

    def test_evaluate_and_convert_of_bad_meshes(self):
        self.assertEqual(self.run_lumesh("lattice", self.good, "-o", self.folder / "bad.vtu").returncode, 0)
        data = (self.folder / "bad.vtu").read_bytes()
        for fault, content in (("truncated", data[:len(data) // 2]), ("empty", b""), ("noise", data[:50] + data[900:])):
            (self.folder / "bad.vtu").write_bytes(content)
            with self.subTest(fault):
                self.assert_refused(self.run_lumesh("evaluate", self.folder / "bad.vtu", "--json", self.folder / "out.json"),
                                    BAD_INPUT, "bad.vtu")
                self.assert_refused(self.run_lumesh("convert", self.folder / "bad.vtu", self.folder / "out.msh"),
                                    BAD_INPUT, "bad.vtu")
                self.assert_nothing_written()

    def test_phantom_of_an_unknown_kind_or_impossible_size(self):
        result = self.run_lumesh("phantom", "teapot", "-o", self.folder / "out.nrrd")
        self.assertEqual(result.returncode, USAGE, result.stderr)
        self.assert_nothing_written()

    def test_an_output_that_is_a_link_to_a_file_of_another_kind_is_refused(self):
        image, mesh = self.folder / "ball.nrrd", self.folder / "ball.vtu"
        nrrd.write(image, [16] * 3, nrrd.ball(16, 5))
        self.run_well("lattice", image, "-o", mesh)
        before = mesh.read_bytes()
        (self.folder / "link.vtk").symlink_to("ball.vtu")
        (self.folder / "link.stl").symlink_to("ball.vtu")
        (self.folder / "a.vtu").symlink_to("b.vtu")
        (self.folder / "b.vtu").symlink_to("a.vtu")
        self.assert_refused(self.run_lumesh("convert", mesh, self.folder / "link.vtk"), BAD_INPUT, "link.vtk", "another kind")
        result = self.run_lumesh("lattice", image, "-o", self.folder / "other.vtu", "--surface", self.folder / "link.stl")
        self.assert_refused(result, BAD_INPUT, "link.stl", "another kind")
        self.assert_refused(self.run_lumesh("lattice", image, "-o", self.folder / "a.vtu"), BAD_INPUT, "a.vtu")
        self.assertEqual(mesh.read_bytes(), before)

    def test_an_output_that_is_a_link_into_a_missing_folder_is_refused_at_once(self):
        image, link = self.folder / "ball.nrrd", self.folder / "link.vtu"
        nrrd.write(image, [16] * 3, nrrd.ball(16, 5))
        link.symlink_to("missing/ball.vtu")
        result = self.run_lumesh("lattice", image, "-o", link, "-v")
        self.assert_refused(result, BAD_INPUT, "missing/ball.vtu: its folder does not exist")
        self.assertNotIn("took", result.stderr)
        self.assertTrue(link.is_symlink())


class HelpTest(unittest.TestCase):
    def test_every_command_has_help_with_an_example(self):
        for command in ("phantom", "info", "lattice", "evaluate", "convert"):
            with self.subTest(command):
                result = subprocess.run([LUMESH, command, "--help"], capture_output=True, text=True, check=False)
                self.assertEqual((result.returncode, result.stderr), (0, ""))
                self.assertIn(f"Example: lumesh {command}", result.stdout)


if __name__ == "__main__":
    unittest.main(verbosity=2)
