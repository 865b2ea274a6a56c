"""Meshes in Medit text files as lumesh writes them, and checks of them that ask nothing of lumesh; needs numpy."""
import json
import pathlib

import numpy as np

CELLS = {"Tetrahedra": 4, "Pyramids": 5, "Prisms": 6, "Hexahedra": 8}
FACES = {"Tetrahedra": [(0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)],
         "Pyramids": [(0, 1, 2, 3), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)],
         "Prisms": [(0, 1, 2), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)],
         "Hexahedra": [(0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]}
# Tetrahedra between corners of a cell, for its volume; quadrilaterals that are not flat have both diagonals' mean there.
PARTS = {"Tetrahedra": [(0, 1, 2, 3)], "Pyramids": [(0, 1, 2, 4), (0, 2, 3, 4)], "Prisms": [(0, 1, 2, 3), (1, 2, 3, 4), (2, 3, 4, 5)],
         "Hexahedra": [(0, 1, 3, 4), (1, 2, 3, 6), (1, 3, 4, 6), (1, 4, 5, 6), (3, 4, 6, 7)]}


class Mesh:
    """patches: as in lumesh's header; triangles: corners and patch, with quadrilaterals cut in two; cells: corners by shape."""

    def __init__(self, path):
        text = pathlib.Path(path).read_text(encoding="ascii")
        header = "".join(line.removeprefix("# lumesh_info ")[:-1]  # A line of the header ends in "|".
                         for line in text[:text.index("\nVertices\n")].splitlines() if line.startswith("# lumesh_info "))
        self.patches = json.loads(header)["patches"] if header else []
        self.points = section(text, "Vertices", 4, float)[:, :3]
        triangles, quads = section(text, "Triangles", 4, int), section(text, "Quadrilaterals", 5, int)
        halves = np.concatenate([quads[:, [0, 1, 2, 4]], quads[:, [0, 2, 3, 4]]])
        every = np.concatenate([triangles, halves])
        self.triangles, self.patch_of = every[:, :3] - 1, every[:, 3] - 1
        self.cells, self.labels = {}, {}
        for shape, corners in CELLS.items():
            rows = section(text, shape, corners + 1, int)
            if len(rows):
                self.cells[shape], self.labels[shape] = rows[:, :-1] - 1, rows[:, -1]

    def patch(self, name):
        """Triangles of the patches with a name."""
        numbers = [n for n, patch in enumerate(self.patches) if patch["name"] == name]
        return self.triangles[np.isin(self.patch_of, numbers)]

    def of_kind(self, *kinds):
        numbers = [n for n, patch in enumerate(self.patches) if patch["kind"] in kinds]
        return self.triangles[np.isin(self.patch_of, numbers)]

    def openings(self):
        """Names of the openings that have triangles."""
        here = set(self.patch_of.tolist())
        return [patch["name"] for n, patch in enumerate(self.patches) if patch["kind"] not in ("wall", "interface") and n in here]

    def volumes(self):
        """Of each cell, by shape, negative where any part of a cell is turned against the first cell's; and of each label."""
        volumes, by_label = {}, {}
        for shape, cells in self.cells.items():
            total, is_turned = np.zeros(len(cells)), np.zeros(len(cells), bool)
            for part in PARTS[shape]:
                a, b, c, d = (self.points[cells[:, k]] for k in part)
                six = np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a)
                six *= 1 if shape == "Tetrahedra" else np.sign(np.median(six))
                is_turned |= six <= 0
                total += six / 6
            volumes[shape] = np.where(is_turned, -np.abs(total), total)
            for label in np.unique(self.labels[shape]).tolist():
                by_label[label] = by_label.get(label, 0.0) + float(total[self.labels[shape] == label].sum())
        return volumes, by_label


def section(text, keyword, width, kind):
    found = text.find("\n" + keyword + "\n")
    if found < 0:
        return np.zeros((0, width), kind)
    start = found + len(keyword) + 2
    end = text.index("\n", start)
    return np.fromstring(text[end:], kind, width * int(text[start:end]), sep=" ").reshape(-1, width)


def areas_and_normals(points, triangles):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    vectors = 0.5 * np.cross(b - a, c - a)
    areas = np.linalg.norm(vectors, axis=1)
    return areas, vectors / np.maximum(areas, 1e-300)[:, None]


def pieces(pairs, count):
    """Number of the piece of each of `count` things that pairs join."""
    root = np.arange(count)
    while True:
        low = np.minimum(root[pairs[:, 0]], root[pairs[:, 1]])
        new = root.copy()
        np.minimum.at(new, pairs[:, 0], low)
        np.minimum.at(new, pairs[:, 1], low)
        new = new[new]
        new = new[new]
        if (new == root).all():
            return np.unique(root, return_inverse=True)[1]
        root = new


def faces_of(mesh):
    """Corners of each face of each cell, in order of size and -1 where a triangle has none; the cell."""
    faces, owners, first = [], [], 0
    for shape, cells in mesh.cells.items():
        for corners in FACES[shape]:
            face = np.full((len(cells), 4), -1)
            face[:, :len(corners)] = cells[:, corners]
            faces.append(np.sort(face, axis=1))
            owners.append(np.arange(first, first + len(cells)))
        first += len(cells)
    return np.concatenate(faces), np.concatenate(owners), first


def sorted_rows(rows, owners):
    """Rows that are alike next to each other; whose they are; how often each row is there."""
    width = int(rows.max()) + 2
    high, low = (rows[:, 0] + 1) * width + rows[:, 1] + 1, (rows[:, 2] + 1) * width + rows[:, 3] + 1
    order = np.lexsort((low, high))
    high, low = high[order], low[order]
    begins = np.concatenate([[True], (high[1:] != high[:-1]) | (low[1:] != low[:-1])])
    number = np.cumsum(begins) - 1
    return rows[order], owners[order], np.bincount(number)[number]


def crossings(points, triangles):
    """Pairs of triangles of which an edge of one passes through the other, away from common corners; places of the first ones."""
    corners = points[triangles]
    low, high = corners.min(1), corners.max(1)
    size = float(np.median((high - low).max(1))) * 1.5 + 1e-300
    first, last = np.floor(low / size).astype(int), np.floor(high / size).astype(int)
    number, cells = [], []
    spans = last - first + 1
    for span in np.unique(spans, axis=0):
        some = np.flatnonzero((spans == span).all(1))
        for step in np.ndindex(*span):
            number.append(some)
            cells.append(first[some] + np.array(step))
    number, cells = np.concatenate(number), np.concatenate(cells)
    key = np.unique(cells, axis=0, return_inverse=True)[1].ravel()
    order = np.argsort(key, kind="stable")
    key, number = key[order], number[order]
    ends = np.searchsorted(key, key, side="right")
    pairs = []
    for shift in range(1, int(np.bincount(key).max())):
        at = np.arange(len(key) - shift)
        at = at[at + shift < ends[at]]
        if len(at):
            pairs.append(np.stack([number[at], number[at + shift]], 1))
    if not pairs:
        return 0, []
    pairs = np.unique(np.sort(np.concatenate(pairs), axis=1), axis=0)
    apart = (low[pairs[:, 0]] > high[pairs[:, 1]]).any(1) | (low[pairs[:, 1]] > high[pairs[:, 0]]).any(1)
    pairs = pairs[~apart]
    bad = np.zeros(len(pairs), bool)
    for one, other in ((0, 1), (1, 0)):
        a, b, c = (corners[pairs[:, other], k] for k in range(3))
        normal = np.cross(b - a, c - a)
        theirs = triangles[pairs[:, other]]
        for k in range(3):
            ends_of = triangles[pairs[:, one]][:, [k, (k + 1) % 3]]
            free = ~(ends_of[:, :, None] == theirs[:, None, :]).any((1, 2))
            p, q = points[ends_of[:, 0]], points[ends_of[:, 1]]
            here, there = ((p - a) * normal).sum(1), ((q - a) * normal).sum(1)
            flat = 1e-9 * np.linalg.norm(normal, axis=1) * np.linalg.norm(q - p, axis=1)
            through = free & (here * there < 0) & (np.minimum(np.abs(here), np.abs(there)) > flat)
            share = np.where(through, here / np.where(here != there, here - there, 1), 0)[:, None]
            x = p + share * (q - p)
            inside = through
            for u, v in ((a, b), (b, c), (c, a)):
                inside = inside & ((np.cross(v - u, x - u) * normal).sum(1) > 1e-9 * (normal * normal).sum(1))
            bad |= inside
    return int(bad.sum()), corners[pairs[bad][:, 0]].mean(1)[:3].round(3).tolist()


def faults(mesh):
    """What is wrong with a mesh, as words; empty where nothing is."""
    found, (volumes, _) = [], mesh.volumes()
    for shape, volume in volumes.items():
        if (volume <= 0).any():
            found.append(f"{int((volume <= 0).sum())} {shape.lower()} not positive")
    faces, owners, _ = faces_of(mesh)
    faces, _, times = sorted_rows(faces, owners)
    if (times > 2).any():
        found.append(f"{int((times > 2).sum())} faces of more than two cells")
    outside = faces[times == 1]
    if (outside[:, 0] >= 0).any():  # Quadrilaterals: of the file, cut in two there.
        boundary = mesh.triangles[np.isin(mesh.patch_of, [n for n, p in enumerate(mesh.patches) if 0 in p["labels"]])]
    else:
        boundary = outside[:, 1:]
        listed = np.sort(mesh.triangles, axis=1)
        keys = {tuple(t) for t in listed.tolist()}
        lost = sum(tuple(t) not in keys for t in boundary.tolist())
        if lost:
            found.append(f"{lost} outer faces that are in no patch")
    edges = np.sort(boundary[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    _, edge_times = np.unique(edges, axis=0, return_counts=True)
    if (edge_times != 2).any():
        found.append(f"{int((edge_times != 2).sum())} outer edges with {sorted(set(edge_times[edge_times != 2].tolist()))} faces")
    crossed, places = crossings(mesh.points, boundary)
    if crossed:
        found.append(f"{crossed} outer triangles cross at {places}")
    return found


def components(mesh):
    """Pieces of the mesh that faces join."""
    faces, owners, count = faces_of(mesh)
    faces, owners, _ = sorted_rows(faces, owners)
    same = (faces[1:] == faces[:-1]).all(1)
    return int(pieces(np.stack([owners[:-1][same], owners[1:][same]], 1), count).max()) + 1
