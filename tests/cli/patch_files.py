"""Patches of files that lumesh reads and writes, read here without it: each patch's name or number with its faces.

A face is a list of points in the file's unit. HDF5 needs h5py; where that is missing, HAS_HDF5 is false.
"""
import base64
import collections
import json
import re
import struct
import xml.etree.ElementTree
import zlib

try:
    import h5py
    HAS_HDF5 = True
except ImportError:
    HAS_HDF5 = False

# ---------------------------------------------------------------------------------------------------- VTK's XML files

CODES = {"Int8": "b", "UInt8": "B", "Int16": "h", "UInt16": "H", "Int32": "i", "UInt32": "I", "Int64": "q", "UInt64": "Q",
         "Float32": "f", "Float64": "d"}


def unpacked(data, code):
    return struct.unpack(f"<{len(data) // struct.calcsize(code)}{code}", data)


class VtkXml:
    """The arrays of a .vtu or .vtp file of one piece, by name; those of the corners as (section, name)."""

    def __init__(self, path):
        text = path.read_bytes()
        self.appended = b""
        begin = text.find(b"<AppendedData")
        if begin >= 0:  # Its bytes are no XML.
            first = text.index(b"_", text.index(b">", begin)) + 1
            self.is_base64 = b"base64" in text[begin:first]
            self.appended = text[first:text.rindex(b"</AppendedData>")]
            text = text[:begin] + b"</VTKFile>"
        root = xml.etree.ElementTree.fromstring(text)
        self.header = CODES[root.get("header_type", "UInt32")]
        self.is_packed = root.get("compressor") is not None
        self.arrays = {}
        for section in root.iter():
            for array in section.findall("DataArray"):
                key = array.get("Name")
                self.arrays[(section.tag, key) if key in ("connectivity", "offsets") else key] = array

    def values(self, key):
        array = self.arrays[key]
        code = CODES[array.get("type")]
        if array.get("format") == "ascii":
            return tuple(float(word) if code in "fd" else int(word) for word in array.text.split())
        if array.get("format") == "binary":
            return unpacked(self.block("".join(array.text.split()).encode(), True), code)
        return unpacked(self.block(self.appended[int(array.get("offset")):], self.is_base64), code)

    def rows(self, key, width):
        values = self.values(key)
        return [values[i:i + width] for i in range(0, len(values), width)]

    def block(self, data, is_base64):
        """The bytes of an array that begins here."""
        def head(size):
            """So many first bytes, and where what comes behind them begins."""
            if not is_base64:
                return data[:size], size
            length = 4 * -(-size // 3)
            return base64.b64decode(data[:length])[:size], length

        width = struct.calcsize(self.header)
        if not self.is_packed:
            size = unpacked(head(width)[0], self.header)[0]
            return head(width + size)[0][width:]
        blocks = unpacked(head(width)[0], self.header)[0]
        sizes, begin = head(width * (3 + blocks))
        sizes = unpacked(sizes, self.header)[3:]
        rest = data[begin:]
        if is_base64:
            rest = base64.b64decode(rest[:4 * -(-sum(sizes) // 3)])
        result, at = b"", 0
        for size in sizes:
            result += zlib.decompress(rest[at:at + size])
            at += size
        return result

    def info(self):
        return json.loads(bytes(self.values("lumesh_info")))

    def polygons(self, section="Polys"):
        points, corners = self.rows("Points", 3), self.values((section, "connectivity"))
        ends = self.values((section, "offsets"))
        return [[points[v] for v in corners[begin:end]] for begin, end in zip((0, *ends), ends)]


def gathered(keys, faces):
    result = collections.defaultdict(list)
    for key, face in zip(keys, faces):
        result[key].append(face)
    return dict(result)


def names_in(info):
    return [patch["name"] for patch in info["patches"]]


def read_vtu(path):
    file = VtkXml(path)
    points, names = file.rows("Points", 3), names_in(file.info())
    keys, faces = [], []
    for shape, width in (("triangle", 3), ("quadrilateral", 4)):
        if f"lumesh_{shape}s" in file.arrays:
            keys += [names[p] for p in file.values(f"lumesh_{shape}_patches")]
            faces += [[points[v] for v in face] for face in file.rows(f"lumesh_{shape}s", width)]
    return gathered(keys, faces)


def read_vtp(path):
    file = VtkXml(path)
    names = names_in(file.info())
    return gathered([names[p] for p in file.values("patch")], file.polygons())


def read_face_ids(path):
    """Of a model of SimVascular or a mesh for it."""
    file = VtkXml(path)
    return gathered(file.values("ModelFaceID"), file.polygons())


def read_simvascular(folder):
    """By the names of the files; whether the ids are the same is for the caller."""
    files = (folder / "mesh-surfaces").iterdir()
    return {path.stem: VtkXml(path).polygons() for path in files}


# ------------------------------------------------------------------------------------------------------ other formats


def read_legacy_vtk(path):
    """Points and fields of a binary file as lumesh writes it."""
    data, at, fields = path.read_bytes(), 0, {}
    widths = {"double": 8, "float": 4, "int": 4, "char": 1}
    codes = {"double": "d", "float": "f", "int": "i", "char": "b"}
    for line in re.finditer(rb"\n(POINTS|lumesh_info|lumesh_\w+) (\d+) (?:(\d+) )?(\w+)\n", data):
        if line.start() < at:
            continue  # Within numbers.
        kind = line[4].decode()
        count = 3 * int(line[2]) if line[3] is None else int(line[2]) * int(line[3])
        begin, at = line.end(), line.end() + widths[kind] * count
        fields[line[1].decode()] = struct.unpack(f">{count}{codes[kind]}", data[begin:at])
    names = names_in(json.loads(bytes(fields["lumesh_info"])))
    numbers, points = fields["lumesh_triangles"], fields["POINTS"]
    faces = [[points[3 * v:3 * v + 3] for v in numbers[i:i + 3]] for i in range(0, len(numbers), 3)]
    return gathered([names[p] for p in fields["lumesh_triangle_patches"]], faces)


def read_gmsh(path):
    """Of the versions 2.2 and 4.1, as text: what has a physical surface, by its name."""
    lines = path.read_text(encoding="utf-8").splitlines()

    def part(name):
        return lines[lines.index(f"${name}") + 1:lines.index(f"$End{name}")]

    names = {}
    for line in part("PhysicalNames")[1:]:
        dimension, tag, name = line.split(maxsplit=2)
        if dimension == "2":
            names[int(tag)] = name.strip('"')
    nodes, elements = part("Nodes"), part("Elements")
    keys, faces, points = [], [], {}
    if part("MeshFormat")[0].startswith("2.2"):
        for line in nodes[1:]:
            number, *xyz = line.split()
            points[int(number)] = tuple(map(float, xyz))
        for line in elements[1:]:
            _, kind, tags, physical, *rest = map(int, line.split())
            if kind in (2, 3):
                keys.append(names[physical])
                faces.append([points[v] for v in rest[tags - 1:]])
        return gathered(keys, faces)
    entities = part("Entities")
    counts = list(map(int, entities[0].split()))
    physical = {}
    for line in entities[1 + counts[0] + counts[1]:1 + counts[0] + counts[1] + counts[2]]:
        words = line.split()
        physical[int(words[0])] = int(words[8])
    at = 1
    while at < len(nodes):
        count = int(nodes[at].split()[3])
        for number, xyz in zip(nodes[at + 1:at + 1 + count], nodes[at + 1 + count:at + 1 + 2 * count]):
            points[int(number)] = tuple(map(float, xyz.split()))
        at += 1 + 2 * count
    at = 1
    while at < len(elements):
        dimension, entity, _, count = map(int, elements[at].split())
        for line in elements[at + 1:at + 1 + count] if dimension == 2 else ():
            keys.append(names[physical[entity]])
            faces.append([points[int(v)] for v in line.split()[1:]])
        at += 1 + count
    return gathered(keys, faces)


def read_medit(path):
    """By the names in lumesh's comment lines; reference N is patch N - 1."""
    text = path.read_text(encoding="utf-8")
    info = "".join(line.removeprefix("# lumesh_info ").removesuffix("|") for line in text.splitlines()
                   if line.startswith("# lumesh_info "))
    words = " ".join(line for line in text.splitlines() if not line.startswith("#")).split()

    def rows(keyword, width):
        if keyword not in words:
            return []
        at = words.index(keyword)
        numbers = words[at + 2:at + 2 + width * int(words[at + 1])]
        return [numbers[i:i + width] for i in range(0, len(numbers), width)]

    points = [tuple(map(float, row[:3])) for row in rows("Vertices", 4)]
    names, triangles = names_in(json.loads(info)), rows("Triangles", 4)
    return gathered([names[int(t[3]) - 1] for t in triangles], [[points[int(v) - 1] for v in t[:3]] for t in triangles])


def read_medit_binary(path):
    """Of version 2: by reference."""
    data = path.read_bytes()
    vertices, triangles, end = 4, 6, 54
    found, at = {}, 8
    while True:
        keyword, following = struct.unpack_from("<ii", data, at)
        if keyword == end:
            break
        if keyword in (vertices, triangles):
            count, = struct.unpack_from("<i", data, at + 8)
            layout = "<dddi" if keyword == vertices else "<iiii"
            found[keyword] = list(struct.iter_unpack(layout, data[at + 12:at + 12 + count * struct.calcsize(layout)]))
        at = following
    return gathered([t[3] for t in found[triangles]], [[found[vertices][v - 1][:3] for v in t[:3]] for t in found[triangles]])


def read_foam(path):
    """The boundary patches of the case beside the .foam file."""
    folder = path.parent / "constant" / "polyMesh"

    def lists(name):
        text = (folder / name).read_text(encoding="utf-8")
        return re.findall(r"^\d*\(([^()\n]*)\)$", text, re.MULTILINE)

    points = [tuple(map(float, row.split())) for row in lists("points")]
    faces = [[points[int(v)] for v in row.split()] for row in lists("faces")]
    boundary = (folder / "boundary").read_text(encoding="utf-8")
    result = {}
    for name, count, first in re.findall(r"^\s*(\S+)\s*\{[^}]*nFaces\s+(\d+);\s*startFace\s+(\d+);", boundary, re.MULTILINE):
        result[name] = faces[int(first):int(first) + int(count)]
    return result


def read_xdmf(path):
    """The facets by the names that stand beside them."""
    stem = path.with_suffix("")
    tags = json.loads(stem.with_name(stem.name + "_tags.json").read_text(encoding="utf-8"))["facet_tags"]
    names = {entry["tag"]: entry["name"] for entry in tags}
    with h5py.File(stem.with_name(stem.name + "_facets.h5"), "r") as file:
        points, cells, found = file["points"][()].tolist(), file["cells"][()].tolist(), file["facet_tags"][()].ravel().tolist()
    return gathered([names[tag] for tag in found], [[points[v] for v in cell] for cell in cells])


# -------------------------------------------------------------------------------------------------- surfaces to read


def write_stl(path, points, parts):
    with open(path, "w", encoding="ascii") as file:
        for name, triangles in parts.items():
            file.write(f"solid {name}\n")
            for triangle in triangles:
                corners = "".join("vertex %.17g %.17g %.17g\n" % points[v] for v in triangle)
                file.write(f"facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n")
            file.write(f"endsolid {name}\n")


def write_polydata(path, points, parts, array, numbers):
    """Triangles of the parts in legacy VTK, with a whole number on each."""
    triangles = [triangle for part in parts.values() for triangle in part]
    values = [number for number, part in zip(numbers, parts.values()) for _ in part]
    lines = ["# vtk DataFile Version 3.0", "tube", "ASCII", "DATASET POLYDATA", f"POINTS {len(points)} double"]
    lines += ["%.17g %.17g %.17g" % p for p in points]
    lines += [f"POLYGONS {len(triangles)} {4 * len(triangles)}"] + ["3 %d %d %d" % t for t in triangles]
    lines += [f"CELL_DATA {len(values)}", f"SCALARS {array} int 1", "LOOKUP_TABLE default", *map(str, values)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_obj(path, points, parts):
    with open(path, "w", encoding="ascii") as file:
        file.writelines("v %.17g %.17g %.17g\n" % p for p in points)
        for name, triangles in parts.items():
            file.write(f"g {name}\n")
            file.writelines("f %d %d %d\n" % tuple(v + 1 for v in triangle) for triangle in triangles)


def write_gmsh(path, points, parts):
    """Version 2.2."""
    names = "".join(f'2 {i} "{name}"\n' for i, name in enumerate(parts, 1))
    nodes = "".join("%d %.17g %.17g %.17g\n" % (i, *p) for i, p in enumerate(points, 1))
    rows = [(part, *(v + 1 for v in t)) for part, triangles in enumerate(parts.values(), 1) for t in triangles]
    elements = "".join(f"{i} 2 2 {part} {part} {a} {b} {c}\n" for i, (part, a, b, c) in enumerate(rows, 1))
    path.write_text(f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n{len(parts)}\n{names}$EndPhysicalNames\n"
                    f"$Nodes\n{len(points)}\n{nodes}$EndNodes\n$Elements\n{len(rows)}\n{elements}$EndElements\n", encoding="ascii")


def write_vtp(path, points, parts, array, numbers, has_names=False):
    """The number of each part in an array of that name; with the names, as lumesh has them, in the field data."""
    triangles = [t for part in parts.values() for t in part]
    values = [number for number, part in zip(numbers, parts.values()) for _ in part]

    def data(kind, name, text, more=""):
        return f'<DataArray type="{kind}" Name="{name}" format="ascii"{more}>{text}</DataArray>'

    info = json.dumps({"lumesh_info": 1, "unit": "mm", "frame": "LPS", "label_names": {}, "provenance": {}, "patches": [
        {"name": name, "kind": "opening" if i > 0 else "wall", "labels": [1, 0]} for i, name in enumerate(parts)]})
    field = data("Int8", "lumesh_info", " ".join(str(byte) for byte in info.encode()), f' NumberOfTuples="{len(info)}"')
    path.write_text(
        '<VTKFile type="PolyData" version="0.1"><PolyData>' + (f"<FieldData>{field}</FieldData>" if has_names else "") +
        f'<Piece NumberOfPoints="{len(points)}" NumberOfPolys="{len(triangles)}">'
        f'<CellData>{data("Int32", array, " ".join(map(str, values)))}</CellData><Points>'
        + data("Float64", "Points", " ".join("%.17g %.17g %.17g" % p for p in points), ' NumberOfComponents="3"')
        + "</Points><Polys>" + data("Int64", "connectivity", " ".join("%d %d %d" % t for t in triangles))
        + data("Int64", "offsets", " ".join(str(3 * i) for i in range(1, len(triangles) + 1)))
        + "</Polys></Piece></PolyData></VTKFile>", encoding="ascii")
