"""Runs of a case by `lumesh run`, for tests of it."""
import hashlib
import json
import pathlib
import shutil
import tempfile

from cube import lines_of
from program import ProgramTest

CASE = """\
mesher = "lattice"

[input]
phantom = "carotid"
phantom_size = [128, 128, 127]
phantom_spacing = 4

[lattice]
max_refinement = 2

[metric]
points = "centerline"
k = 20
max_aspect = 8
complexity = 9000

[adapt]
boundary = "frozen"

[output]
meshes = ["a.vtu", "a.msh"]
surface = "a.stl"
"""

NO_PAGE = ("--set", "output.report=")  # A fifth of the time, where only meshes and numbers are looked at.


class CaseTest(ProgramTest):
    text = CASE

    def setUp(self):
        super().setUp()
        self.case = self.folder / "case.toml"
        self.case.write_text(self.text)
        self.out = self.folder / "out"

    def run_case(self, *more):
        return self.run_well("run", self.case, "-o", self.out, *more)

    @classmethod
    def setUpClass(cls):
        cls.shared = tempfile.TemporaryDirectory(prefix="lumesh_cli_")
        cls.addClassCleanup(cls.shared.cleanup)
        cls.runs = {}

    def run_case_once(self, *more):
        """As run_case, but one run for all tests of the class with these options; each test has a copy of the files."""
        if more not in self.runs:
            folder = pathlib.Path(self.shared.name, str(len(self.runs)))
            self.runs[more] = folder, self.run_well("run", self.case, "-o", folder, *more)
        folder, result = self.runs[more]
        shutil.copytree(folder, self.out)
        return result

    def numbers(self):
        return json.loads((self.out / "report.json").read_text())

    def hash_of_mesh(self):
        """Of the points and cells, from a text format that says nothing of the run."""
        text = self.folder / "hashed.mesh"
        self.run_well("convert", self.out / "a.vtu", text)
        return hashlib.sha256("\n".join(lines_of(text)).encode()).hexdigest()
