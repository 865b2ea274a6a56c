#!/usr/bin/env python3
"""Small inputs that go wrong easily, or once did. cases.toml says of each what is run and what must come of it: every command ends in time
with the exit code, a valid mesh has the pieces and patches, and what is refused is told in one line without control characters and leaves no
file. `scripts/reduce.py` makes a failing input small; put what is left here.

Usage: regress_test.py LUMESH
"""
import json
import pathlib
import resource
import shlex
import sys
import tempfile
import tomllib
import unittest

FOLDER = pathlib.Path(__file__).parent
sys.path.insert(0, str(FOLDER.parent / "cli"))
from program import ProgramTest

GIB = 1 << 30


def limit_memory():
    """What takes more for such small files has lost its bounds; stacks of threads take address space only."""
    resource.setrlimit(resource.RLIMIT_DATA, (2 * GIB, 2 * GIB))


class RegressTest(ProgramTest):
    def test_every_case(self):
        cases = tomllib.loads((FOLDER / "cases.toml").read_text())["case"]
        self.assertGreater(len(cases), 30)
        for case in cases:
            for command in case["commands"]:
                with self.subTest(case["input"], command=command): self.check_command(case, command)

    def test_every_input_has_a_case(self):
        inputs = {path.name for path in FOLDER.iterdir() if path.suffix != ".py" and path.name not in ("cases.toml", "__pycache__")}
        self.assertEqual(inputs, {case["input"] for case in tomllib.loads((FOLDER / "cases.toml").read_text())["case"]})

    def check_command(self, case, command):
        with tempfile.TemporaryDirectory(dir=self.folder) as folder:
            names = {"INPUT": str(FOLDER / case["input"]), "OUT": f"{folder}/out"}
            words = [word.replace("INPUT", names["INPUT"]).replace("OUT", names["OUT"]) for word in shlex.split(command)]
            result = self.run_lumesh(*words, preexec_fn=limit_memory)
            code = case.get("code", 0)
            self.assertEqual(result.returncode, code, result.stderr)
            self.assertIn(case.get("says", ""), result.stderr)
            self.assertIn(case.get("prints", ""), result.stdout)
            self.assertTrue(all(character.isprintable() or character == "\n" for character in result.stderr), repr(result.stderr))
            self.assertEqual(result.stderr.count("lumesh: error: "), int(code != 0), result.stderr)
            if code == 2: self.assertEqual(list(pathlib.Path(folder).iterdir()), [])
            if code == 0 and words[-1].endswith(".vtu"): self.assert_has(words[-1], case)

    def assert_has(self, mesh, case):
        """The mesh is valid and has the labels, pieces and patches that the case says."""
        labels = json.loads(self.run_well("evaluate", mesh, "--json").stdout)["labels"]
        if "pieces" in case:
            found = {str(label["label"]): label["components"] for label in labels}
            self.assertEqual(found, {label: found.get(label) if wanted == "any" else wanted for label, wanted in case["pieces"].items()})
        if "patches" in case:
            patches = json.loads(self.run_well("info", mesh, "--json").stdout)["patches"]
            self.assertEqual(sorted(patch["name"] for patch in patches), case["patches"])


if __name__ == "__main__":
    unittest.main()
