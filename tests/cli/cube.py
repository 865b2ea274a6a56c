"""The unit cube in n^3 cubes of six tetrahedra, for tests and benchmarks, and meshes as Medit text."""
import itertools
import pathlib


def cube(n):
    """Its points, tetrahedra with label 1, and boundary triangles with patches 1 to 6, numbered from 1."""
    side = n + 1

    def vertex(at):
        return 1 + at[0] + side * (at[1] + side * at[2])

    points = [(i / n, j / n, k / n) for k in range(side) for j in range(side) for i in range(side)]
    tetrahedra, triangles = [], []
    for k, j, i in itertools.product(range(n), repeat=3):
        for order in itertools.permutations(range(3)):
            at = [i, j, k]
            corners = [vertex(at)]
            for axis in order:
                at[axis] += 1
                corners.append(vertex(at))
            if order in ((0, 2, 1), (1, 0, 2), (2, 1, 0)):  # odd: turn it round
                corners[2], corners[3] = corners[3], corners[2]
            tetrahedra.append((*corners, 1))
    for axis, end in itertools.product(range(3), range(2)):
        for a, b in itertools.product(range(n), repeat=2):
            for middle in ((1, 0), (0, 1)):  # The diagonal runs from (0, 0) to (1, 1), as in the tetrahedra.
                face = []
                for da, db in ((0, 0), middle, (1, 1)):
                    at = [0, 0, 0]
                    at[axis], at[(axis + 1) % 3], at[(axis + 2) % 3] = end * n, a + da, b + db
                    face.append(vertex(at))
                triangles.append((*face, 1 + 2 * axis + end))
    return points, tetrahedra, triangles


def lines_of(path):
    """A Medit file's lines but for comments, which tell how it was made."""
    return [line for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]


def write_medit(path, points, tetrahedra, triangles):
    """Tetrahedra and triangles as cube() gives them; what is empty is left out."""
    sections = {"Vertices": [(*p, 0) for p in points], "Triangles": triangles, "Tetrahedra": tetrahedra}
    with open(path, "w", encoding="ascii") as file:
        file.write("MeshVersionFormatted 2\nDimension 3\n")
        for name, items in sections.items():
            if items:
                file.write(f"{name}\n{len(items)}\n" + "".join(" ".join(map(str, item)) + "\n" for item in items))
        file.write("End\n")


def write_sol(path, tensors):
    """Tensors in the file's order xx xy yy xz yz zz."""
    rows = "".join(" ".join(map(str, tensor)) + "\n" for tensor in tensors)
    pathlib.Path(path).write_text(f"MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n{len(tensors)}\n1 3\n{rows}End\n",
                                  encoding="ascii")


def read_medit(path):
    """Points, tetrahedra and triangles of a Medit text file, numbered from 1, with labels and patches last."""
    words = pathlib.Path(path).read_text(encoding="ascii").split()

    def rows(keyword, width, kind):
        if keyword not in words:
            return []
        start = words.index(keyword) + 2
        return [tuple(map(kind, words[i:i + width])) for i in range(start, start + width * int(words[start - 1]), width)]

    return [p[:3] for p in rows("Vertices", 4, float)], rows("Tetrahedra", 5, int), rows("Triangles", 4, int)
