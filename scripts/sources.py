"""What the checks of this folder share: the files of the project and their text without comments and strings."""
import os
import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parent.parent
SOURCE_SUFFIXES = {".hpp", ".cpp", ".h"}


def source_files(root, folders):
    """All C++ files under the folders, sorted, as paths relative to the root."""
    found = []
    for folder in folders:
        for parent, _, names in os.walk(root / folder):
            found += [pathlib.Path(parent, name).relative_to(root) for name in names
                      if pathlib.Path(name).suffix in SOURCE_SUFFIXES]
    return sorted(found)


def faults_of_nothing(files, where):
    """A check that found no file to look at has shown nothing: its only fault then."""
    return [] if files else [f"{where}: no file to check"]


TOKENS = re.compile(
    r"""R"(?P<tag>[^()\s\\]{0,16})\(.*?\)(?P=tag)"   # raw strings
      | //[^\n]* | /\*.*?\*/                         # comments
      | "(?:\\.|[^"\\\n])*"                          # strings
      | (?<![0-9A-Za-z_])'(?:\\.|[^'\\\n])+'         # characters, but not the ' in 1'000
    """, re.VERBOSE | re.DOTALL)


def without_comments(text):
    """The text with comments blanked and strings emptied; every line keeps its number."""
    def blank(match):
        token = match.group()
        lines = "\n" * token.count("\n")
        return lines if token.startswith("/") else token[0].replace("R", "") + '""' + lines
    return TOKENS.sub(blank, text)
