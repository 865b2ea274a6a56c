#!/usr/bin/env python3
"""Files of boundaries alone: closed, whatever lies between the cells of the mesh.

Usage: boundary_test.py LUMESH
"""
import collections
import json
import pathlib
import struct
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from program import MeshTest


def faces_of_stl(path):
    data = path.read_bytes()
    count = struct.unpack_from("<I", data, 80)[0]
    at = [84 + 50 * i + 12 for i in range(count)]
    return [[data[a + 12 * k:a + 12 * k + 12] for k in range(3)] for a in at]


def faces_of_off(path):
    lines = [words for words in (line.split("#")[0].split() for line in path.read_text().splitlines()) if words]
    points, faces = int(lines[1][0]), int(lines[1][1])
    return [words[1:1 + int(words[0])] for words in lines[2 + points:2 + points + faces]]


def unpaired_edges(faces):
    """Edges, with their direction, that are not once in one face and once turned in another."""
    edges = collections.Counter(edge for f in faces for edge in zip(f, f[1:] + f[:1]))
    return [e for e, count in edges.items() if count != 1 or edges[e[::-1]] != 1]


class BoundaryTest(MeshTest):
    def assert_closed(self, path):
        if path.suffix == ".vtp":
            off = path.with_suffix(".vtp.off")
            self.run_well("convert", path, off)
            path = off
        faces = faces_of_stl(path) if path.suffix == ".stl" else faces_of_off(path)
        self.assertGreater(len(faces), 100)
        self.assertEqual(len(unpaired_edges(faces)), 0, path.name)

    def meshes(self):
        """One of layers within, with faces of three and four corners, and one of three labels."""
        self.run_well("phantom", "layered", "-o", self.folder / "labels.nrrd", "--size", 48, 48, 48, "--spacing", 1)
        self.run_well("lattice", self.folder / "labels.nrrd", "-o", self.folder / "labels.vtu")
        return {"layers": (self.layered("--side", "inward", "--cells", "prisms"), "layer_inner"),
                "labels": (self.folder / "labels.vtu", "interface_1_2")}

    def test_what_lies_between_cells_is_no_part_of_it(self):
        for title, (mesh, inner) in self.meshes().items():
            for ending in (".stl", ".off", ".vtp"):
                with self.subTest(title, ending=ending):
                    surface = self.folder / f"{title}{ending}"
                    told = self.run_well("convert", mesh, self.out, "--surface", surface).stdout
                    self.assertRegex(told, rf"{surface.name}: the outer boundary, without \d+ faces between cells \(.*{inner}")
                    self.assert_closed(surface)
                    self.run_well("check", surface)

    def test_a_format_without_patches_gets_no_more_and_vtp_all(self):
        for title, (mesh, inner) in self.meshes().items():
            for ending in (".stl", ".off"):
                with self.subTest(title, ending=ending):
                    surface = self.folder / f"{title}_converted{ending}"
                    self.assertRegex(self.run_well("convert", mesh, surface).stderr, rf"holds the outer boundary alone, without \d+ faces between cells \(.*{inner}")
                    self.assert_closed(surface)
            every = self.folder / f"{title}_converted.vtp"
            self.assertNotIn("outer boundary", self.run_well("convert", mesh, every).stderr)
            faces = {p["name"]: p["faces"] for p in json.loads(self.run_well("info", every, "--json").stdout)["patches"]}
            self.assertGreater(faces[inner], 0)

    def test_commands_that_make_meshes_write_it_so_too(self):
        self.run_well("phantom", "layered", "-o", self.folder / "labels.nrrd", "--size", 48, 48, 48, "--spacing", 1)
        for mesher in ("lattice", "delaunay"):
            surface = self.folder / f"{mesher}.stl"
            self.run_well(mesher, self.folder / "labels.nrrd", "-o", self.out, "--surface", surface)
            self.assert_closed(surface)
        case = self.folder / "case.toml"
        case.write_text('mesher = "lattice"\n[input]\nimage = "labels.nrrd"\nlabels = [1]\n[layers]\nside = "inward"\nfirst_height = 0.2\n'
                        'count = 2\n[output]\nsurface = "s.stl"\nreport = ""\n')
        self.assertIn("s.stl: the outer boundary, without", self.run_lumesh("run", case, "-o", self.folder / "made").stdout)
        self.assert_closed(self.folder / "made" / "s.stl")


if __name__ == "__main__":
    unittest.main()
