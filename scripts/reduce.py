#!/usr/bin/env python3
"""Makes an input that goes wrong small: takes away as much of it as it can while the command still ends the same way. Of label images
(.nrrd of bytes, without compression or with gzip) it takes slabs off the six sides and labels out, of surfaces (.stl) triangles
(delta debugging: Zeller and Hildebrandt 2002, doi:10.1109/32.988498). What is left belongs into tests/regress.

Usage: reduce.py [--code N] [--says TEXT] [--seconds S] INPUT OUTPUT -- COMMAND...
Example: reduce.py --code 3 --says "the mesh is invalid" case1.nrrd small.nrrd -- lumesh delaunay INPUT -o /tmp/out.vtu

The word INPUT in the command is the file that is tried. It goes wrong if the exit code is N (default: any above 1, or a signal) and
stderr has the TEXT.
"""
import argparse
import gzip
import pathlib
import re
import struct
import subprocess
import sys


class Trials:
    def __init__(self, options, command):
        self.options, self.command, self.count = options, command, 0
        self.file = options.output.with_name("trial" + options.output.suffix)

    def goes_wrong(self, write):
        self.count += 1
        write(self.file)
        words = [word.replace("INPUT", str(self.file)) for word in self.command]
        try:
            run = subprocess.run(words, capture_output=True, text=True, timeout=self.options.seconds, check=False)
        except subprocess.TimeoutExpired:
            return False
        finally:
            self.file.unlink()
        code_fits = run.returncode == self.options.code if self.options.code is not None else not 0 <= run.returncode <= 1
        return code_fits and self.options.says in run.stderr


class Image:
    """Bytes, x fastest; the origin stays where it is."""

    def __init__(self, path):
        header, _, data = path.read_bytes().partition(b"\n\n")
        fields = dict(line.split(": ", 1) for line in header.decode().splitlines() if ": " in line)
        if fields["type"] not in ("unsigned char", "uint8", "uchar", "uint8_t"):
            sys.exit(f"{path}: must have one byte per voxel")
        self.header = header.decode()
        self.size = [int(word) for word in fields["sizes"].split()]
        self.data = gzip.decompress(data) if fields["encoding"] in ("gzip", "gz") else data

    def write_to(self, path):
        header = re.sub(r"(?m)^sizes: .*$", "sizes: " + " ".join(map(str, self.size)), self.header)
        header = re.sub(r"(?m)^encoding: .*$", "encoding: raw", header)
        path.write_bytes(header.encode() + b"\n\n" + self.data)

    def changed(self, size, data):
        other = object.__new__(Image)
        other.header, other.size, other.data = self.header, size, data
        return other

    def without(self, axis, at_end, slabs):
        low, size = [0, 0, 0], list(self.size)
        size[axis] -= slabs
        low[axis] = 0 if at_end else slabs
        nx, ny, _ = self.size
        rows = [self.data[(z * ny + y) * nx + low[0]:][:size[0]]
                for z in range(low[2], low[2] + size[2]) for y in range(low[1], low[1] + size[1])]
        return self.changed(size, b"".join(rows))

    def smaller(self):
        """Largest steps first."""
        for label in sorted(set(self.data) - {0}):
            if len(set(self.data)) > 2:
                yield self.changed(self.size, self.data.replace(bytes([label]), b"\0"))
        for share in (2, 4, 8, 16, 1 << 20):
            for axis in range(3):
                slabs = max(1, self.size[axis] // share)
                for at_end in (False, True):
                    if self.size[axis] > slabs:
                        yield self.without(axis, at_end, slabs)

    def __str__(self):
        return " x ".join(map(str, self.size)) + " voxels"


class Surface:
    """Triangles of a binary or text STL file."""

    def __init__(self, path):
        data = path.read_bytes()
        if data.startswith(b"solid") and b"facet" in data[:500]:
            numbers = [float(x) for line in re.findall(rb"vertex\s+(.*)", data) for x in line.split()]
            self.triangles = [struct.pack("<12fH", 0, 0, 0, *numbers[i:i + 9], 0) for i in range(0, len(numbers), 9)]
        else:
            self.triangles = [data[i:i + 50] for i in range(84, len(data), 50)]

    def write_to(self, path):
        path.write_bytes(b"\0" * 80 + struct.pack("<I", len(self.triangles)) + b"".join(self.triangles))

    def smaller(self):
        part = len(self.triangles) // 2
        while part:
            for begin in range(0, len(self.triangles), part):
                other = object.__new__(Surface)
                other.triangles = self.triangles[:begin] + self.triangles[begin + part:]
                if other.triangles:
                    yield other
            part //= 2

    def __str__(self):
        return f"{len(self.triangles)} triangles"


def main():
    if "--" not in sys.argv:
        sys.exit(__doc__)
    split = sys.argv.index("--")
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--code", type=int)
    parser.add_argument("--says", default="")
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("input", type=pathlib.Path)
    parser.add_argument("output", type=pathlib.Path)
    options = parser.parse_args(sys.argv[1:split])
    trials = Trials(options, sys.argv[split + 1:])
    best = (Surface if options.input.suffix == ".stl" else Image)(options.input)
    if not trials.goes_wrong(best.write_to):
        sys.exit(f"{options.input}: does not go wrong that way")
    found = True
    while found:
        found = next((one for one in best.smaller() if trials.goes_wrong(one.write_to)), None)
        if found:
            best = found
            best.write_to(options.output)
            print(f"{best}, {trials.count} trials", flush=True)
    best.write_to(options.output)
    print(f"{options.output}: {best}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
