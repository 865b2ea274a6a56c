"""Remembers which files passed a check, by the content of the file and of the project's headers that it includes."""
import hashlib
import pathlib
import re

import sources

INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.MULTILINE)


class Stamps:
    """A file is fresh if it passed with the same content, the same included headers and the same settings."""

    def __init__(self, check, settings):
        self.folder = sources.ROOT / "build/stamps" / check
        self.folder.mkdir(parents=True, exist_ok=True)
        self.settings = settings
        self.texts = {}

    def is_fresh(self, path):
        return (self.folder / self._key(path)).exists()

    def mark(self, path):
        (self.folder / self._key(path)).touch()

    def _key(self, path):
        digest = hashlib.sha256(self.settings.encode())
        for file in sorted(self._closure(path, set())):
            digest.update(str(file).encode() + b"\0" + self._text(file).encode())
        return digest.hexdigest()

    def _text(self, path):
        if path not in self.texts:
            self.texts[path] = path.read_text()
        return self.texts[path]

    def _closure(self, path, seen):
        if path in seen:
            return seen
        seen.add(path)
        for name in INCLUDE.findall(self._text(path)):
            for folder in (path.parent, sources.ROOT / "include", sources.ROOT / "internal", sources.ROOT / "tests"):
                if (folder / name).is_file():
                    self._closure(pathlib.Path(folder / name), seen)
                    break
        return seen
