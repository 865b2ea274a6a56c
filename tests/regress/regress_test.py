#!/usr/bin/env python3
"""Small inputs that go wrong easily, or once did: each command of NAME.json on NAME.nrrd or NAME.stl must end well, with a valid
mesh, or with the exit code that "code" says. What the mesh must have, where the file says it: "pieces", the number of pieces (cells joined
through faces) of each label, no other labels, null: any number; "patches", all names; "warning", words on stderr. `scripts/reduce.py` makes
such inputs small; put what is left here.

Usage: regress_test.py LUMESH
"""
import json
import pathlib
import sys
import unittest

FOLDER = pathlib.Path(__file__).parent
sys.path.insert(0, str(FOLDER.parent / "cli"))
from program import ProgramTest


class RegressTest(ProgramTest):
    def test_every_input_of_the_folder(self):
        cases = sorted(FOLDER.glob("*.json"))
        self.assertGreater(len(cases), 4)
        for case in cases:
            about = json.loads(case.read_text())
            given = next(path for path in FOLDER.glob(case.stem + ".*") if path.suffix != ".json")
            for command in about["commands"]:
                with self.subTest(case.stem, command=command[0]):
                    words = [word.replace("INPUT", str(given)).replace("OUT", str(self.folder / "out")) for word in command]
                    result = self.run_lumesh(*words)
                    self.assertEqual(result.returncode, about.get("code", 0), result.stderr)
                    if words[-1].endswith(".vtu"): self.assertIn(about.get("warning", ""), result.stderr)
                    if words[-1].endswith(".vtu") and result.returncode == 0: self.assert_has(words[-1], about)

    def assert_has(self, mesh, about):
        """The mesh is valid and has the labels, pieces and patches that the case says."""
        labels = json.loads(self.run_well("evaluate", mesh, "--json").stdout)["labels"]
        if "pieces" in about:
            found = {str(label["label"]): label["components"] for label in labels}
            self.assertEqual(found, {label: found.get(label) if wanted is None else wanted for label, wanted in about["pieces"].items()})
        if "patches" in about:
            patches = json.loads(self.run_well("info", mesh, "--json").stdout)["patches"]
            self.assertEqual(sorted(patch["name"] for patch in patches), sorted(about["patches"]))


if __name__ == "__main__":
    unittest.main()
