#!/usr/bin/env python3
"""Makes the pictures of the pages of the stages anew: docs/images/stage_NAME.png, each by the commands beside its NAME below and
without any other program. A picture is one that lumesh draws itself: that of `evaluate --picture`, or one in a page of `--report`,
known by the words that stand with it. It is halved in size and stored with 256 colours at most, which keeps it below 150 kB.

Usage: stage_pictures.py [--program PATH] [--keep DIR] [NAME…]      NAME: all, or those of PICTURES
       stage_pictures.py --commands NAME                           what is run for it
"""
import argparse
import base64
import collections
import pathlib
import re
import shlex
import struct
import subprocess
import sys
import tempfile
import zlib

ROOT = pathlib.Path(__file__).resolve().parent.parent
OUTPUT = ROOT / "docs/images"
MOST_BYTES = 150_000
COLOURS = 256
UNFIT = 3  # Exit code of `check` for a file with faults.

VESSEL = "lumesh phantom bifurcation -o vessel.nrrd --centerline axes.vtp --velocity flow.vtp"
MESH = "lumesh delaunay vessel.nrrd -o vessel.vtu --edge-length 0.5"
CUT = "Cut, from the front"
CASE = """mesher = "delaunay"

[input]
image = "vessel.nrrd"

[delaunay]
edge_length = 0.6

[metric]
points = "centerline"
k = 20
complexity = 3000

[layers]
side = "inward"
first_height = 0.05
count = 4
cells = "prisms"
"""
HOLES = (lambda x, y, z: y < 9 and any((x - a) ** 2 + (z - c) ** 2 < r * r  # On one side of the vessel.
                                       for a, c, r in ((12.8, 5, 0.5), (5, 13.6, 0.4), (20, 13.2, 0.4), (13, 13, 0.9))))
ENDS = (lambda x, y, z: z < -0.05 or x < -0.05 or x > 26.3)  # Triangles in the faces of the image, where vessels leave it.


class Text(collections.namedtuple("Text", "path text")):
    """Writes a file."""

    def run(self, folder):
        (folder / self.path).write_text(self.text)

    def __str__(self):
        return f"# {self.path}:\n" + self.text


class Without(collections.namedtuple("Without", "source target goes")):
    """Writes a binary STL without the triangles whose middle goes."""

    def run(self, folder):
        data = (folder / self.source).read_bytes()
        facets = [data[at:at + 50] for at in range(84, len(data), 50)]

        def middle(facet):
            numbers = struct.unpack("<12f", facet[:48])
            return [sum(numbers[3 + k::3]) / 3 for k in range(3)]

        kept = [facet for facet in facets if not self.goes(*middle(facet))]
        (folder / self.target).write_bytes(data[:80] + struct.pack("<I", len(kept)) + b"".join(kept))

    def __str__(self):
        return f"# {self.target}: {self.source} without some triangles (scripts/stage_pictures.py)"


PICTURES = {
    # Name: commands, the file with the picture, and, where that is a page, how its words (alt) begin: the last such one.
    "phantom": ([VESSEL, "lumesh check vessel.nrrd --report page.html"], "page.html", "image"),
    "info": (["lumesh phantom layered -o layers.nrrd --size 48 48 48", "lumesh info layers.nrrd",
              "lumesh check layers.nrrd --report page.html"], "page.html", "image"),
    "lattice": (["lumesh phantom layered -o layers.nrrd", "lumesh lattice layers.nrrd -o layers.vtu --edge-length 5",
                 "lumesh evaluate layers.vtu --image layers.nrrd --report page.html"], "page.html", CUT),
    "delaunay": ([VESSEL, "lumesh delaunay vessel.nrrd -o vessel.vtu --edge-length 0.6",
                  "lumesh evaluate vessel.vtu --image vessel.nrrd --report page.html"], "page.html", CUT),
    "metric": ([VESSEL, MESH, "lumesh metric vessel.vtu --velocity flow.vtp --complexity 4000 -o metric.vtu",
                "lumesh adapt metric.vtu -o adapted.vtu --time-limit 60",
                "lumesh evaluate adapted.vtu --report page.html"], "page.html", CUT),
    "adapt": ([VESSEL, MESH, "lumesh metric vessel.vtu --curvature --edges-per-radius 3 --gradation 1.3 -o metric.vtu",
               "lumesh adapt metric.vtu -o adapted.vtu", "lumesh evaluate adapted.vtu --picture page.png"], "page.png", ""),
    "improve": ([VESSEL, "lumesh lattice vessel.nrrd -o lattice.vtu --edge-length 0.6", "lumesh improve lattice.vtu -o improved.vtu",
                 "lumesh evaluate improved.vtu --image vessel.nrrd --report page.html"], "page.html", "Part of the cut, enlarged"),
    "layers": ([VESSEL, MESH, "lumesh layers vessel.vtu --first-height 0.12 --count 5 -o layered.vtu --report page.html"], "page.html", "From where"),
    "merge": ([VESSEL, MESH, "lumesh layers vessel.vtu --first-height 0.1 --count 4 --cells prisms -o layered.vtu",
               "lumesh convert layered.vtu wall.vtu --only-labels vessel_wall", "lumesh convert layered.vtu lumen.vtu --only-labels 1",
               "lumesh merge lumen.vtu wall.vtu -o again.vtu", "lumesh evaluate again.vtu --report page.html"], "page.html", CUT),
    "rename": ([VESSEL, MESH, "lumesh rename vessel.vtu -o named.vtu --name inlet_1=carotid:inlet --name outlet_1=mca_upper:outlet"
                " --name outlet_2=mca_lower:outlet", "lumesh evaluate named.vtu --picture page.png"], "page.png", ""),
    "evaluate": ([VESSEL, MESH, "lumesh evaluate vessel.vtu --image vessel.nrrd --report page.html"], "page.html", "Cut, from the side"),
    "centerline": ([VESSEL, Text("case.toml", CASE), "lumesh run case.toml -o case"], "case/report.html", "The centerline"),
    "convert": (["lumesh phantom layered -o layers.nrrd", "lumesh lattice layers.nrrd -o layers.vtu",
                 "lumesh convert layers.vtu layers.msh --only-labels 1,2", "lumesh evaluate layers.msh --report page.html"],
                "page.html", CUT),
    "repair": ([VESSEL, MESH, "lumesh convert vessel.vtu vessel.msh --surface whole.stl", Without("whole.stl", "scanned.stl", HOLES),
                "lumesh check scanned.stl --report page.html", "lumesh repair scanned.stl -o sound.vtp"], "page.html", "Close-up"),
    "surfaces": ([VESSEL, MESH, "lumesh convert vessel.vtu vessel.msh --surface whole.stl", Without("whole.stl", "artery.stl", ENDS),
                  "lumesh delaunay artery.stl -o artery.vtu --edge-length 0.5", "lumesh evaluate artery.vtu --picture page.png"],
                 "page.png", ""),
    "run": ([VESSEL, Text("case.toml", CASE), "lumesh run case.toml -o case"], "case/report.html", "The mesh cut open"),
}


def halves(rows, width, channels):
    """Rows of half the width: the mean of 2 x 2 pixels, over white where there is alpha."""
    colours = 3

    def opaque(row):
        if channels == colours: return row
        out = bytearray()
        for at in range(0, len(row), channels):
            alpha = row[at + 3]
            out += bytes((value * alpha + 255 * (255 - alpha)) // 255 for value in row[at:at + 3])
        return out

    flat = [opaque(row) for row in rows]
    result = []
    for upper, lower in zip(flat[0::2], flat[1::2]):
        row = bytearray()
        for x in range(0, (width // 2) * 2 * colours, 2 * colours):
            row += bytes((upper[x + c] + upper[x + c + colours] + lower[x + c] + lower[x + c + colours] + 2) // 4 for c in range(colours))
        result.append(row)
    return result


def decoded(png):
    """Rows of a PNG of 8 bits that is not interlaced, its width and bytes per pixel."""
    if png[:8] != b"\x89PNG\r\n\x1a\n": raise ValueError("no PNG")
    at, data = 8, b""
    while at < len(png):
        length, kind = struct.unpack(">I4s", png[at:at + 8])
        body = png[at + 8:at + 8 + length]
        if kind == b"IHDR": width, height, depth, colour, _, _, interlace = struct.unpack(">IIBBBBB", body)
        if kind == b"IDAT": data += body
        at += 12 + length
    channels = {2: 3, 6: 4}.get(colour)
    if depth != 8 or channels is None or interlace: raise ValueError("a PNG of another kind")
    raw, rows = zlib.decompress(data), []
    stride = width * channels
    before = bytearray(stride)
    for y in range(height):
        filter_kind, row = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for x in range(stride):
            left = row[x - channels] if x >= channels else 0
            up = before[x]
            if filter_kind == 1: guess = left
            elif filter_kind == 2: guess = up
            elif filter_kind == 3: guess = (left + up) // 2
            elif filter_kind == 4:
                corner = before[x - channels] if x >= channels else 0
                a, b, c = abs(up - corner), abs(left - corner), abs(left + up - 2 * corner)
                guess = left if a <= b and a <= c else up if b <= c else corner
            else: guess = 0
            row[x] = (row[x] + guess) & 255
        rows.append(row)
        before = row
    return rows, width, channels


def palette(rows):
    """At most COLOURS colours by median cut, and the number of each colour that occurs."""
    counts = collections.Counter()
    for row in rows:
        counts.update(zip(row[0::3], row[1::3], row[2::3]))
    boxes = [sorted(counts)]
    while len(boxes) < COLOURS:
        def spread(box):
            return max(max(c[k] for c in box) - min(c[k] for c in box) for k in range(3)) * sum(counts[c] for c in box) ** 0.5
        widest = max((box for box in boxes if len(box) > 1), key=spread, default=None)
        if widest is None: break
        boxes.remove(widest)
        axis = max(range(3), key=lambda k: max(c[k] for c in widest) - min(c[k] for c in widest))
        widest.sort(key=lambda c: (c[axis], c))
        half, seen, total = 1, counts[widest[0]], sum(counts[c] for c in widest)
        while half < len(widest) - 1 and 2 * seen < total:
            seen += counts[widest[half]]
            half += 1
        boxes += [widest[:half], widest[half:]]
    colours, number = [], {}
    for box in boxes:
        total = sum(counts[c] for c in box)
        colours.append(bytes(sum(c[k] * counts[c] for c in box) // total for k in range(3)))
        for colour in box: number[colour] = len(colours) - 1
    return colours, number


def encoded(rows):
    colours, number = palette(rows)

    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    lines = b"".join(b"\0" + bytes(number[c] for c in zip(row[0::3], row[1::3], row[2::3])) for row in rows)
    header = struct.pack(">IIBBBBB", len(rows[0]) // 3, len(rows), 8, 3, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"PLTE", b"".join(colours))
            + chunk(b"IDAT", zlib.compress(lines, 9)) + chunk(b"IEND", b""))


def picture_in(path, words):
    if path.suffix == ".png": return path.read_bytes()
    found = None
    for alt, data in re.findall(r'<img[^>]*alt="([^"]*)"[^>]*src="data:image/png;base64,([^"]*)"', path.read_text()):
        if alt.startswith(words): found = data
    if found is None: raise ValueError(f"no picture '{words}' in {path.name}")
    return base64.b64decode(found)


def make(name, program, keep):
    commands, file, words = PICTURES[name]
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(keep) / name if keep else pathlib.Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        for command in commands:
            if not isinstance(command, str):
                command.run(folder)
                continue
            words_of_command = shlex.split(command)[1:]
            done = subprocess.run([program, *words_of_command], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
            if done.returncode not in ((0, UNFIT) if words_of_command[0] == "check" else (0,)):
                raise ValueError(f"{command}: exit code {done.returncode}\n{done.stderr}")
        png = encoded(halves(*decoded(picture_in(folder / file, words))))
    if len(png) > MOST_BYTES: raise ValueError(f"{name}: {len(png)} bytes, more than {MOST_BYTES}")
    target = OUTPUT / f"stage_{name}.png"
    target.write_bytes(png)
    print(f"{target.relative_to(ROOT)}: {len(png)} bytes")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(ROOT / "build/release/bin/lumesh"))
    parser.add_argument("--keep", help="leave what the commands made in this folder")
    parser.add_argument("--commands", action="store_true")
    parser.add_argument("names", nargs="*")
    arguments = parser.parse_args()
    for name in arguments.names or PICTURES:
        if name not in PICTURES: parser.error(f"no picture '{name}'; there are {', '.join(PICTURES)}")
        if arguments.commands: print("\n".join(str(command) for command in PICTURES[name][0]))
        else: make(name, str(pathlib.Path(arguments.program).resolve()), arguments.keep)
    return 0


if __name__ == "__main__":
    sys.exit(main())
