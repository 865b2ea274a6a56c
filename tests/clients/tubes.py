"""Straight tubes along z from z = 0: as an image of voxels, and as a mesh whose wall's vertices lie on the cylinder."""
import math
import pathlib


def write_tube_image(path, radius_mm, length_mm, voxel_mm):
    """A label image (.nrrd), axis at x = y = 0; the tube runs from its first face to its last."""
    across, along = 2 * math.ceil(radius_mm / voxel_mm) + 9, round(length_mm / voxel_mm)
    centre = (across - 1) / 2
    slice_ = bytes(1 if math.hypot(x - centre, y - centre) * voxel_mm <= radius_mm else 0 for y in range(across) for x in range(across))
    start = -centre * voxel_mm
    head = (f"NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: {across} {across} {along}\n"
            f"space directions: ({voxel_mm},0,0) (0,{voxel_mm},0) (0,0,{voxel_mm})\nkinds: domain domain domain\n"
            f"encoding: raw\nspace origin: ({start},{start},{voxel_mm / 2})\n\n")
    pathlib.Path(path).write_bytes(head.encode() + slice_ * along)


def disc(radius, rings):
    """Points and triangles of a disc: ring k has 6 k points."""
    points = [(0.0, 0.0)]
    for ring in range(1, rings + 1):
        points += [(radius * ring / rings * math.cos(math.pi * i / (3 * ring)), radius * ring / rings * math.sin(math.pi * i / (3 * ring)))
                   for i in range(6 * ring)]

    def point(ring, i):
        return 0 if ring == 0 else 1 + 3 * ring * (ring - 1) + i % (6 * ring)

    triangles = []
    for ring in range(1, rings + 1):
        for side in range(6):
            for i in range(ring):
                outer, inner = side * ring + i, side * (ring - 1) + i
                triangles.append((point(ring, outer), point(ring, outer + 1), point(ring - 1, inner)))
                if i + 1 < ring:
                    triangles.append((point(ring - 1, inner), point(ring, outer + 1), point(ring - 1, inner + 1)))
    return points, triangles


def write_tube_mesh(path, radius_mm, length_mm, rings, slices):
    """Tetrahedra in Gmsh's format 2.2 with the surfaces wall, inlet (z = 0) and outlet."""
    flat, triangles = disc(radius_mm, rings)
    count = len(flat)
    points = [(x, y, length_mm * k / slices) for k in range(slices + 1) for x, y in flat]
    rim = range(count - 6 * rings, count)
    edges = [(a, rim[(i + 1) % len(rim)]) for i, a in enumerate(rim)]
    elements = []  # type, physical group, corners
    for a, b, c in triangles:
        elements += [(2, 2, (a, c, b)), (2, 3, tuple(slices * count + p for p in (a, b, c)))]
    for k in range(slices):
        low, up = k * count, (k + 1) * count
        for a, b in edges:  # Diagonals from the lower point of smaller number, as in the tetrahedra.
            if a < b:
                elements += [(2, 1, (low + a, low + b, up + b)), (2, 1, (low + a, up + b, up + a))]
            else:
                elements += [(2, 1, (low + a, low + b, up + a)), (2, 1, (low + b, up + b, up + a))]
        for triangle in triangles:
            x, y, z = sorted(triangle)
            even = (x, y, z) in (triangle, triangle[1:] + triangle[:1], triangle[2:] + triangle[:2])
            for tet in ((low + x, low + y, low + z, up + z), (low + x, low + y, up + z, up + y), (low + x, up + y, up + z, up + x)):
                elements.append((4, 4, tet if even else (tet[1], tet[0], *tet[2:])))
    names = '3\n2 1 "wall"\n2 2 "inlet"\n2 3 "outlet"\n'.replace("3\n", "4\n", 1) + '3 4 "lumen"\n'
    with open(path, "w") as out:
        out.write(f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n{names}$EndPhysicalNames\n$Nodes\n{len(points)}\n")
        out.writelines(f"{i} {x:.17g} {y:.17g} {z:.17g}\n" for i, (x, y, z) in enumerate(points, 1))
        out.write(f"$EndNodes\n$Elements\n{len(elements)}\n")
        out.writelines(f"{i} {kind} 2 {group} {group} {' '.join(str(corner + 1) for corner in corners)}\n"
                       for i, (kind, group, corners) in enumerate(elements, 1))
        out.write("$EndElements\n")
