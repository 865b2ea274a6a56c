#!/usr/bin/env python3
"""What shells, scripts and terminals get: completion, exit codes in helps, --json, progress, stops.

Usage: shell_test.py LUMESH
"""
import json
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
from cube import cube, write_medit
from program import LUMESH, TIME_LIMIT, USAGE, ProgramTest, lines_but_steps, take_signals, wait_for_line

SIZE = 24


def commands():
    text = subprocess.run([LUMESH, "--help"], capture_output=True, text=True, check=True).stdout
    return re.findall(r"^  (\w+) +", text[text.index("Subcommands:"):], re.MULTILINE)


class CompletionTest(ProgramTest):
    def script(self, shell):
        path = self.folder / f"lumesh.{shell}"
        path.write_text(self.run_well("completion", shell).stdout)
        return path

    def bash(self, *words):
        script = f"source '{self.script('bash')}'; COMP_WORDS=({' '.join(words)} ''); COMP_CWORD={len(words)}; _lumesh; printf '%s\\n' \"${{COMPREPLY[@]}}\""
        return subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=True, cwd=self.folder).stdout.split()

    def test_bash_completes_commands_words_and_files(self):
        self.assertLessEqual(set(commands()), set(self.bash("lumesh")))
        self.assertEqual(self.bash("lumesh", "layers", "a.vtu", "--side"), ["outward", "inward"])
        self.assertIn("lumesh.bash", self.bash("lumesh", "lattice"))
        script = self.script("bash").read_text()
        for command in commands():
            for flag in re.findall(r"--[a-z][a-z-]*", subprocess.run([LUMESH, command, "--help"], capture_output=True, text=True,
                                                                     check=True).stdout.split("Options:")[1].split("Exit codes")[0]):
                self.assertRegex(script, rf"(?m)^    {command}\)\n      options='[^']*{flag}")

    @unittest.skipUnless(shutil.which("fish"), "fish is not installed")
    def test_fish_completes_commands_and_options(self):
        complete = lambda line: subprocess.run(["fish", "--no-config", "-c", f"source '{self.script('fish')}'; complete -C '{line}'"],
                                               capture_output=True, text=True, check=True).stdout
        self.assertIn("lattice\tMesh a segmented image", complete("lumesh latt"))
        self.assertIn("--first-height", complete("lumesh layers --first"))
        self.assertEqual([line.split("\t")[0] for line in complete("lumesh layers --side ").splitlines()], ["inward", "outward"])

    @unittest.skipUnless(shutil.which("zsh"), "zsh is not installed")
    def test_zsh_reads_its_script(self):
        words = f"autoload -U compinit && compinit -u -D; source '{self.script('zsh')}'; print $_comps[lumesh]"
        result = subprocess.run(["zsh", "-f", "-c", words], capture_output=True, text=True, check=True, cwd=self.folder)
        self.assertEqual((result.stdout.strip(), result.stderr), ("_lumesh", ""))


class HelpTest(ProgramTest):
    def test_every_help_has_the_exit_codes_once(self):
        whole = " ".join(self.run_well("--help").stdout.split())
        line = whole[whole.index("Exit codes: 0"):]
        for command in commands():
            with self.subTest(command):
                self.assertIn(line, " ".join(self.run_well(command, "--help").stdout.split()))

    def test_wrong_command_lines_have_one_code_everywhere(self):
        for command in commands():
            for wrong in (["--no-such-option"], ["--threads", "many"], []):
                if command == "options" and not wrong:
                    continue
                with self.subTest(command, wrong=wrong):
                    self.assert_refused(self.run_lumesh(command, *wrong), USAGE)


class JsonTest(ProgramTest):
    def test_json_replaces_no_input_nor_any_file_that_is_none(self):
        images = [nrrd.write(self.folder / f"{name}.nrrd", [SIZE] * 3, nrrd.ball(SIZE, 8)) for name in "ab"]
        held = [image.read_bytes() for image in images]
        for command in (("info",), ("check",)):
            for words in ((images[0], "--json", images[0]), ("--json", *images)):
                with self.subTest(command=command[0], words=words):
                    self.assert_refused(self.run_lumesh(*command, *words), USAGE, "a.nrrd", "replace")
        self.assertEqual([image.read_bytes() for image in images], held)

    @unittest.skipIf(os.geteuid() == 0 and not shutil.which("setpriv"), "needs another user")
    def test_the_standard_output_needs_no_folder(self):
        image = nrrd.write(self.folder / "a.nrrd", [SIZE] * 3, nrrd.ball(SIZE, 8))
        image.chmod(0o644)
        self.folder.chmod(0o755)
        user = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"] if os.geteuid() == 0 else []
        result = subprocess.run([*user, LUMESH, "info", image, "--json"], capture_output=True, text=True, check=False, cwd="/proc")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(json.loads(result.stdout)["kind"], "image")

    def test_json_is_a_file_or_the_standard_output_alone(self):
        image = nrrd.write(self.folder / "ball.nrrd", [SIZE] * 3, nrrd.ball(SIZE, 8))
        mesh = self.folder / "ball.vtu"
        out, report = self.folder / "out.vtu", self.folder / "report.json"
        self.run_well("delaunay", image, "-o", mesh)
        surface = self.folder / "ball.stl"
        self.run_well("convert", mesh, surface)
        for command in (["info", image], ["check", image], ["options"], ["evaluate", mesh], ["improve", mesh, "-o", out],
                        ["delaunay", image, "-o", out], ["repair", surface, "-o", self.folder / "out.stl"],
                        ["layers", mesh, "--first-height", "0.1", "-o", out]):
            with self.subTest(command[0]):
                to_file = self.run_well(*command, "--json", report)
                self.assertGreater(len(to_file.stdout), 50, "text beside the file")
                self.assertRaises(ValueError, json.loads, to_file.stdout)
                keys = json.loads(report.read_text()).keys()
                for dash in (["--json", "-"], ["--json"]):
                    self.assertEqual(json.loads(self.run_well(*command, *dash).stdout).keys(), keys)
        self.assertFalse((self.folder / "-").exists())


class StopTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.image = self.folder / "big.nrrd"
        self.give(("phantom", "carotid", "-o", "big.nrrd", "--size", 192, 192, 190, "--spacing", 2.7))

    def test_a_terminal_shows_stage_and_share_which_never_falls(self):
        text = self.on_a_terminal("lattice", self.image, "--spacing", "2", "-o", self.folder / "a.vtu")
        shares = [int(share) for share in re.findall(r"lumesh: [\w ]+, (\d+) %", text)]
        self.assertGreater(len(shares), 2, text)
        self.assertEqual(shares, sorted(shares))
        self.assertLessEqual(shares[-1], 100)
        self.assertTrue(text.endswith("\x1b[K"), "the line is cleared in the end")

    def test_files_pipes_and_quiet_commands_get_no_such_line(self):
        self.assertEqual(self.run_well("lattice", self.image, "-o", self.folder / "a.vtu").stderr, "")
        self.assertEqual(self.on_a_terminal("lattice", self.image, "-q", "-o", self.folder / "a.vtu"), "")

    def test_a_time_limit_ends_what_has_nothing_to_keep(self):
        out = self.folder / "a.vtu"
        out.write_bytes(b"what was there")
        before = sorted(self.folder.iterdir())
        began = time.monotonic()
        result = self.run_lumesh("lattice", self.image, "--spacing", "0.8", "-o", out, "--time-limit", "0.5")
        self.assertLess(time.monotonic() - began, 4)  # A second, and what a busy machine adds.
        self.assert_refused(result, TIME_LIMIT, "time limit of 0.5 s reached; no unfinished file is left")
        self.assertEqual((sorted(self.folder.iterdir()), out.read_bytes()), (before, b"what was there"))

    def test_a_stop_that_comes_while_results_are_written_is_too_late(self):
        mesh, out, stl = self.folder / "cube.mesh", self.folder / "out.vtu", self.folder / "out.stl"
        write_medit(mesh, *cube(3))
        self.run_well("convert", mesh, out)
        whole = out.stat().st_size
        out.unlink()
        os.mkfifo(out)  # The writing lasts until the file is read.
        for commands in (("convert", mesh, out, "--surface", stl), ("rename", mesh, "-o", out, "--name", "patch_1=low"),
                         ("metric", mesh, "-o", out, "--analytic", "linear")):
            for limit in ((), ("--time-limit", "0.3")):
                with self.subTest(commands[0], limit=limit), subprocess.Popen(
                        [LUMESH, *map(str, commands), *limit], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                        preexec_fn=take_signals) as process:
                    time.sleep(1)
                    if not limit:
                        process.send_signal(signal.SIGTERM)
                        time.sleep(0.5)  # More than the patience with what has no results.
                    if process.poll() is None: self.assertGreater(len(out.read_bytes()), whole / 2)
                    errors = process.communicate(timeout=60)[1]
                    self.assertEqual(process.returncode, 0, errors)
        self.assertTrue(stl.exists())

    def test_a_second_signal_ends_what_is_being_kept(self):
        mesh, out = self.folder / "cube.mesh", self.folder / "out.vtu"
        write_medit(mesh, *cube(3))
        os.mkfifo(out)  # That nobody reads: the writing lasts until the second signal, on any machine.
        with subprocess.Popen([LUMESH, "adapt", mesh, "--analytic", "polar-2", "--complexity", "300000", "-v", "-o", out],
                              stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, preexec_fn=take_signals) as process:
            wait_for_line(process, "reconnect took")  # The first pass that improves the mesh.
            process.send_signal(signal.SIGINT)
            self.assertEqual(wait_for_line(process, "interrupted"), "lumesh: interrupted; what there is will be written; once more ends it at once\n")
            process.send_signal(signal.SIGINT)
            errors = process.communicate(timeout=60)[1]
        self.assertEqual((process.returncode, lines_but_steps(errors)),
                         (TIME_LIMIT, ["lumesh: error: interrupted; no unfinished file is left"]))
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), ["big.nrrd", "big.phantom.json", "cube.mesh", "out.vtu"])


if __name__ == "__main__":
    unittest.main()
