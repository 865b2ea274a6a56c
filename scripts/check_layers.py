#!/usr/bin/env python3
"""Checks who includes whom.

1. A module includes only itself and what ROOT/CMakeLists.txt lets it depend on; no private header of another module;
docs/design.md has the same table, and a graph of it (--graph prints that). 2. Headers of the API (include/) include no internal ones (internal/), and no header has the name of
   another in both. 3. A header of the API is named in docs/api.md, or one that is named there needs it. 4. Heavy
libraries never appear in shared headers; ITK in one .cpp, VTK in none, CGAL in one.

Usage: check_layers.py [--graph] [ROOT]
"""
import pathlib
import re
import sys

import sources

# Libraries that cost seconds per file or leak macros: how many files under src/ may include each.
HEAVY = {"ITK": (r"itk\w+\.h", 1), "VTK": (r"vtk\w+\.h", 1), "CGAL": (r"CGAL/.*", 1),
         "hwloc": (r"hwloc(?:/.*|\.h)", 1), "HDF5": (r"hdf5\.h|H5\w+\.h", 1), "OpenSSL": (r"openssl/.*", 1), "nlohmann-json": (r"nlohmann/.*", None), "CLI11": (r"CLI/.*", 0), "pugixml": (r"pugixml\.hpp", None)}

# Headers outside of modules, for plain C: every module may include them, and they include nothing of ours.
PLAIN_C = ["include/lumesh/sizing.h"]

# Folders of headers for other modules: the API, which is installed, and what only lumesh itself uses.
SHARED = ["include", "internal"]

INCLUDE = re.compile(r'^\s*#\s*include\s+[<"]([^>"]+)[>"]', re.MULTILINE)


def dependencies(root):
    """What each module depends on, from CMakeLists.txt, in its order; nothing where that is not there."""
    path = root / "CMakeLists.txt"
    text = path.read_text() if path.is_file() else ""
    found = re.findall(r"^lumesh_module\((\w+)(?: DEPENDS ([a-z ]+?))?(?: ALONE [^)]*)?\)", text, re.MULTILINE)
    return {module: names.split() for module, names in found} | ({"apps": ["pipeline"]} if found else {})


def allowed_modules(root):
    """Each module with everything it may include: the closure of its dependencies. Their order rules out cycles."""
    closure = {}
    for module, names in dependencies(root).items():
        closure[module] = {module}
        for name in names:
            closure[module] |= closure[name]  # KeyError: a module depends on one that stands behind it
    return closure


def graph(root):
    """The dependencies as a Mermaid graph, without those that follow from others."""
    allowed, lines = allowed_modules(root), ["```mermaid", "graph BT"]
    for module, names in dependencies(root).items():
        lines += [f"  {module} --> {name}" for name in names
                  if not any(name in allowed[other] for other in names if other != name)]
    return "\n".join([*lines, "```"])


def faults_of_design(root):
    """Yields where the table and the graph of docs/design.md differ from CMakeLists.txt."""
    page = root / "docs/design.md"
    if not page.is_file():
        return
    text = page.read_text()
    rows = dict(re.findall(r"^\| `(\w+)` \|[^|]*\| ([a-z ]*?) *\|$", text, re.MULTILINE))
    for module, names in dependencies(root).items():
        if rows.get(module) != " ".join(names):
            yield f"docs/design.md: `{module}` depends on '{' '.join(names)}' in CMakeLists.txt"
    if graph(root) not in text:
        yield "docs/design.md: the graph of modules is another; check_layers.py --graph prints it"


def module_of(path):
    """include/lumesh/<module>/..., internal/lumesh/<module>/..., src/<module>/..., or apps."""
    if path.parts[0] == "apps":
        return "apps"
    return path.parts[2] if path.parts[0] in SHARED else path.parts[1]


def faults_of_include(root, path, included, allowed):
    """Yields what is wrong with one include of one file."""
    if f"include/{included}" in PLAIN_C and (root / "include" / included).is_file():
        return
    if included.startswith("lumesh/"):
        module = included.split("/")[1]
        if module not in allowed[module_of(path)]:
            yield f"{path}: {module_of(path)} may not include {included} (see CMakeLists.txt)"
        homes = [folder for folder in SHARED if (root / folder / included).is_file()]
        if len(homes) != 1:
            yield f"{path}: {included} stands in {' and '.join(homes) or 'neither include nor internal'}"
        elif path.parts[0] == "include" and homes == ["internal"]:
            yield f"{path}: a header of the API includes {included}, which is not installed"
    elif ".." in pathlib.PurePath(included).parts or "src/" in included:
        yield f"{path}: {included} reaches out of its folder; private headers belong to one module"
    if path.parts[0] in SHARED:
        for name, (pattern, _) in HEAVY.items():
            if re.fullmatch(pattern, included):
                yield f"{path}: a shared header includes {name} ({included}); keep it in a .cpp"


def heavy_in_too_many(includes):
    """Yields heavy libraries that more files include than may."""
    for name, (pattern, limit) in HEAVY.items():
        users = [path for path, names in includes.items() if path.parts[0] == "src"
                 and any(re.fullmatch(pattern, included) for included in names)]
        if limit is not None and len(users) > limit:
            yield f"{name} is included by {len(users)} files of src, {limit} may: " + ", ".join(map(str, users))


def unneeded_in_api(root, includes):
    """Yields headers of the API that no header named in docs/api.md needs."""
    page = root / "docs/api.md"
    if not page.is_file():
        return
    todo = [f"lumesh/{name}" for name in re.findall(r"`([\w/]+\.hpp)`", page.read_text())]
    needed = set()
    while todo:
        path = pathlib.Path("include", todo.pop())
        if path in includes and path not in needed:
            needed.add(path)
            todo += includes[path]
    for path in includes:
        if path.parts[0] == "include" and path not in needed:
            yield f"{path}: docs/api.md does not name it, nor what needs it; it belongs into internal"


def main():
    arguments = sys.argv[1:]
    wants_graph = "--graph" in arguments
    if wants_graph: arguments.remove("--graph")
    root = pathlib.Path(arguments[0]) if arguments else sources.ROOT
    if wants_graph:
        print(graph(root))
        return 0
    allowed = allowed_modules(root)
    includes, faults = {}, []
    for path in sources.source_files(root, ["include/lumesh", "internal/lumesh", "src", "apps"]):
        if path.as_posix() in PLAIN_C:
            if any(included.startswith("lumesh/") for included in INCLUDE.findall((root / path).read_text())):
                faults.append(f"{path}: a header for plain C includes nothing of lumesh")
            continue
        if module_of(path) not in allowed:
            faults.append(f"{path}: module {module_of(path)} is not in CMakeLists.txt")
            continue
        includes[path] = INCLUDE.findall((root / path).read_text())
        for included in includes[path]:
            faults += faults_of_include(root, path, included, allowed)
    faults += sources.faults_of_nothing(includes, root)
    faults += heavy_in_too_many(includes)
    faults += unneeded_in_api(root, includes)
    faults += faults_of_design(root)
    print("\n".join(faults + [f"check_layers: {len(includes)} files, {len(faults)} faults"]))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
