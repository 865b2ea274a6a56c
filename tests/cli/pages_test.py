#!/usr/bin/env python3
"""README.md and the worked examples of docs/stages run as they stand: every line of a block that begins with `lumesh` or `source <(lumesh`,
in order, in an empty folder of the page's own. It must end with exit code 0, or with N where its comment says `exit code N`.

Comments of the page that nobody sees say the rest: `<!-- before: COMMAND -->` makes what the page takes for granted, by lumesh or by
`without HOLES|ENDS FROM.stl TO.stl` (scripts/stage_pictures.py); cube.mesh and the cases of examples/ are there, these with a smaller
phantom. `<!-- not run: REASON -->` leaves out the next block.

Usage: pages_test.py LUMESH
"""
import os
import pathlib
import re
import subprocess
import sys
import unittest

from cube import cube, write_medit
from program import LUMESH, ProgramTest  # Takes the program from the command line.

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import stage_pictures  # noqa: E402

SECTION = re.compile(r"^## A worked example\n(.*?)(?=^## |\Z)", re.MULTILINE | re.DOTALL)
NO_COMMANDS = {"domain"}  # Its example is C++.


# What makes a case of examples/ small enough for a test.
SMALLER = {'phantom = "carotid"': 'phantom = "carotid"\nphantom_size = [128, 128, 127]\nphantom_spacing = 4', "complexity = 180000": "complexity = 5000"}


def write_smaller_cases(folder):
    folder.mkdir()
    for case in sorted((ROOT / "examples").glob("*.toml")):
        text = case.read_text()
        for what, smaller in SMALLER.items(): text = re.sub(f"^{what}", smaller, text, flags=re.MULTILINE)
        (folder / case.name).write_text(text)


def commands_of(text):
    """Commands of a text and of its comments, in order; a command that is not run is left out."""
    left_out, in_block = False, False
    for line in text.splitlines():
        if line.startswith("<!-- not run:"): left_out = True
        elif before := re.fullmatch(r"<!-- before: (.*) -->", line): yield before[1]
        elif line.startswith("    "):
            in_block = True
            command = line.strip().removeprefix("$ ")
            if command.startswith(("lumesh ", "source <(lumesh ")) and not left_out: yield command
        elif in_block: left_out, in_block = False, False


class PagesTest(ProgramTest):
    def setUp(self):
        super().setUp()
        (self.folder / "bin").mkdir()
        (self.folder / "bin/lumesh").symlink_to(LUMESH)
        self.environment = {**os.environ, "PATH": f"{self.folder / 'bin'}:{os.environ['PATH']}"}

    def run_line(self, command, folder):
        if command.startswith("without "):
            _, what, source, target = command.split()
            stage_pictures.Without(source, target, getattr(stage_pictures, what)).run(folder)
            return
        wanted = re.search(r"#.*\bexit code (\d+)", command)
        result = subprocess.run(["bash", "-c", command], cwd=folder, env=self.environment, capture_output=True, text=True, timeout=300,
                                check=False, stdin=subprocess.DEVNULL)
        self.assertEqual(result.returncode, int(wanted[1]) if wanted else 0, f"{command}\n{result.stderr}")

    def run_commands(self, name, text):
        """All in a folder of the name; their number."""
        folder = self.folder / name
        folder.mkdir()
        write_medit(folder / "cube.mesh", *cube(3))
        write_smaller_cases(folder / "examples")
        commands = list(commands_of(text))
        for command in commands: self.run_line(command, folder)
        return len(commands)

    def test_the_worked_examples_run(self):
        pages = sorted((ROOT / "docs/stages").glob("*.md"))
        self.assertGreater(len(pages), 12)
        for page in pages:
            text = page.read_text()
            with self.subTest(page.stem):
                self.assertRegex(text, SECTION)
                count = self.run_commands(page.stem, SECTION.search(text)[1])
                self.assertTrue(count or page.stem in NO_COMMANDS or "<!-- not run: " in text, "no command, and no reason why")

    def test_the_readme_runs(self):
        self.assertGreater(self.run_commands("readme", (ROOT / "README.md").read_text()), 20)

    def test_what_is_run_of_a_page(self):
        text = ("# a\n\n    lumesh no\n\n## A worked example\n\n<!-- before: without HOLES a.stl b.stl -->\n\n    lumesh one   # two\n    gmsh x\n\n"
                "<!-- not run: too long -->\n    lumesh no\n    lumesh no\n\nProse, `lumesh no`.\n\n    $ lumesh two\n\n## Options\n\n    lumesh no\n")
        self.assertEqual(list(commands_of(SECTION.search(text)[1])), ["without HOLES a.stl b.stl", "lumesh one   # two", "lumesh two"])


if __name__ == "__main__":
    unittest.main()
