"""What the tests of the program share: a folder of their own, running it, and how it must refuse."""
import hashlib
import json
import os
import pathlib
import pty
import signal
import shutil
import subprocess
import sys
import tempfile
import threading
import unittest

GIVEN = tempfile.TemporaryDirectory(prefix="lumesh_cli_")  # What several tests begin with.
USAGE, BAD_INPUT, NOT_REACHED, TIME_LIMIT, MEMORY = 1, 2, 3, 4, 5
LUMESH = str(pathlib.Path(sys.argv.pop(1)).resolve())


def take_signals():
    """For preexec_fn: what the tests themselves were told to ignore, as in the background of a script, lumesh is not."""
    for which in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(which, signal.SIG_DFL)


def wait_for_line(process, words, seconds=120):
    """Reads stderr of a command, with -v the steps that have ended, up to a line with these words, which it returns. Where none comes in
    time, the command is ended; what stands behind the line is for communicate()."""
    deadline = threading.Timer(seconds, process.kill)
    deadline.start()
    try:
        said = []
        for line in iter(process.stderr.readline, ""):
            if words in line: return line
            said.append(line)
    finally:
        deadline.cancel()
    raise AssertionError(f"no line with '{words}' on stderr:\n{''.join(said)}")


def lines_but_steps(errors):
    """Lines on stderr but those of -v: a step may still end beside what ends the program."""
    return [line for line in errors.splitlines() if " took " not in line]


class ProgramTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="lumesh_cli_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def run_lumesh(self, *arguments, **options):
        return subprocess.run([LUMESH, *map(str, arguments)], capture_output=True, text=True, timeout=300, check=False,
                              stdin=subprocess.DEVNULL, **options)

    def run_well(self, *arguments):
        result = self.run_lumesh(*arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result

    def give(self, *commands):
        """What commands make, once for all tests that ask for them: copied into the folder of the test."""
        folder = pathlib.Path(GIVEN.name, hashlib.sha256(repr(commands).encode()).hexdigest())
        if not folder.exists():
            folder.mkdir()
            for command in commands:
                result = self.run_lumesh(*command, cwd=folder)
                self.assertEqual(result.returncode, 0, result.stderr)
        shutil.copytree(folder, self.folder, dirs_exist_ok=True)

    def on_a_terminal(self, *arguments):
        """What a terminal gets on stderr."""
        reader, writer = pty.openpty()
        with subprocess.Popen([LUMESH, *map(str, arguments)], stdout=subprocess.DEVNULL, stderr=writer) as process:
            os.close(writer)
            text = b""
            try:
                while block := os.read(reader, 4096):
                    text += block
            except OSError:  # The other end is closed.
                pass
        os.close(reader)
        self.assertEqual(process.returncode, 0, text)
        return text.decode()

    def assert_refused(self, result, code, *words):
        """The exit code, and one line that says what is wrong."""
        self.assertEqual(result.returncode, code, result.stderr)
        lines = result.stderr.splitlines()
        self.assertEqual(len(lines), 1, f"one line is wanted on stderr, not:\n{result.stderr}")
        self.assertTrue(lines[0].startswith("lumesh: error: "), lines[0])
        self.assertLess(len(lines[0]), 250)
        for word in words:
            self.assertIn(word, lines[0])


class MeshTest(ProgramTest):
    """Of commands that make a mesh of a mesh."""

    def setUp(self):
        super().setUp()
        self.out = self.folder / "out.vtu"

    def evaluate(self, mesh):
        numbers = self.folder / "numbers.json"
        self.run_well("evaluate", mesh, "--json", numbers)
        return json.loads(numbers.read_text())

    def vessel(self):
        """A bifurcation with a sac, of tetrahedra."""
        self.give(("phantom", "bifurcation", "--size", 88, 64, 80, "--spacing", 0.3, "-o", "b.nrrd"), ("lattice", "b.nrrd", "-o", "b.vtu"))
        return self.folder / "b.vtu"

    def layered(self, *options):
        """The vessel with layers around or within it."""
        layered = self.folder / "layered.vtu"
        self.run_well("layers", self.vessel(), "--first-height", 0.1, "--count", 3, *options, "-o", layered)
        return layered

    def assert_refused(self, result, code, *words):
        super().assert_refused(result, code, *words)
        self.assertFalse(self.out.exists())
