"""Shapes known by a formula as label images, and measures of surfaces against them; needs numpy. Lengths in voxels unless their
name says otherwise; a voxel belongs to a shape if its centre does. Every shape lies whole in its image."""
import pathlib

import numpy as np

MARGIN = 5  # Voxels between a shape and the border of its image.


def unit(vector):
    return np.asarray(vector, float) / np.linalg.norm(vector)


def across(direction, angle):
    """A unit vector square to a direction, by an angle about it in radians."""
    first = unit(np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))]))
    return np.cos(angle) * first + np.sin(angle) * np.cross(direction, first)


class Vessel:
    """A straight vessel with round ends. Its radius is `radius`, less a smooth narrowing in its middle, down to `radius - narrowing`."""

    def __init__(self, radius, direction, centre, half_length, narrowing=0.0, width=4.0):
        self.radius, self.direction, self.centre = radius, unit(direction), np.asarray(centre, float)
        self.half_length, self.narrowing, self.width = half_length, narrowing, width

    def radius_at(self, along):
        return self.radius - self.narrowing * np.exp(-0.5 * (along / self.width) ** 2)

    def extent(self):
        return np.abs(self.direction) * self.half_length + self.radius

    def split(self, points):
        """Place along the axis, distance from it, and unit vectors away from it."""
        from_centre = points - self.centre
        along = from_centre @ self.direction
        outward = from_centre - along[..., None] * self.direction
        radial = np.linalg.norm(outward, axis=-1)
        return along, radial, outward / np.maximum(radial, 1e-12)[..., None]

    def inside(self, points):
        along, radial, _ = self.split(points)
        beyond = np.maximum(np.abs(along) - self.half_length, 0)
        return np.hypot(radial, beyond) < self.radius_at(np.minimum(np.abs(along), self.half_length))

    def distance_and_normal(self, points):
        """Signed distance to the wall, > 0 outside, and its normal there; away from the ends."""
        along, radial, outward = self.split(points)
        foot = along.copy()  # Of the nearest point of the meridian curve (foot, radius_at(foot)): Newton's method.
        for _ in range(30):
            dent = self.radius - self.radius_at(foot)
            slope, bend = dent * foot / self.width ** 2, dent * (1 - (foot / self.width) ** 2) / self.width ** 2
            gap = radial - self.radius_at(foot)
            foot += (along - foot + gap * slope) / (1 + slope ** 2 - gap * bend)
        slope = (self.radius - self.radius_at(foot)) * foot / self.width ** 2
        normal = (outward - slope[..., None] * self.direction) / np.sqrt(1 + slope ** 2)[..., None]
        gap = (radial - self.radius_at(foot)) - (along - foot) * slope
        return gap / np.sqrt(1 + slope ** 2), normal

    def measured(self, points):
        """Which points are away from the round ends."""
        return np.abs((points - self.centre) @ self.direction) <= self.half_length - self.radius

    def section_places(self, count=41):
        reach = self.half_length - self.radius
        return np.linspace(-reach, reach, count) + 1e-5


class Torus:
    def __init__(self, ring_radius, radius, axis, centre):
        self.ring_radius, self.radius, self.axis, self.centre = ring_radius, radius, unit(axis), np.asarray(centre, float)

    def extent(self):
        return np.full(3, self.ring_radius + self.radius)

    def distance_and_normal(self, points):
        from_centre = points - self.centre
        height = from_centre @ self.axis
        flat = from_centre - height[..., None] * self.axis
        ring = np.linalg.norm(flat, axis=-1)
        away = (ring - self.ring_radius)[..., None] * flat / np.maximum(ring, 1e-12)[..., None] + height[..., None] * self.axis
        distance = np.linalg.norm(away, axis=-1)
        return distance - self.radius, away / np.maximum(distance, 1e-12)[..., None]

    def inside(self, points):
        return self.distance_and_normal(points)[0] < 0

    def measured(self, points):
        return np.ones(len(points), bool)

    def volume(self):
        return 2 * np.pi ** 2 * self.ring_radius * self.radius ** 2


def rasterise(shape):
    """Labels [x, y, z] and the place of the centre of voxel (0, 0, 0)."""
    low = np.floor(shape.centre - shape.extent() - MARGIN).astype(int)
    high = np.ceil(shape.centre + shape.extent() + MARGIN).astype(int)
    labels = np.zeros(high - low + 1, np.uint8)
    y, z = np.meshgrid(np.arange(low[1], high[1] + 1.0), np.arange(low[2], high[2] + 1.0), indexing="ij")
    for i in range(len(labels)):
        labels[i] = shape.inside(np.stack([np.full_like(y, low[0] + i), y, z], axis=-1))
    return labels, low


def write_nrrd(path, labels, low, voxel_mm=1.0):
    edge, start = float(voxel_mm), [float(voxel_mm * place) for place in low]
    head = ("NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\n"
            f"sizes: {labels.shape[0]} {labels.shape[1]} {labels.shape[2]}\n"
            f"space directions: ({edge!r},0,0) (0,{edge!r},0) (0,0,{edge!r})\nkinds: domain domain domain\nencoding: raw\n"
            f"space origin: ({start[0]!r},{start[1]!r},{start[2]!r})\n\n")
    pathlib.Path(path).write_bytes(head.encode() + labels.tobytes(order="F"))


def area_vectors(points, triangles):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return 0.5 * np.cross(b - a, c - a)


def to_vertices(triangles, values, count):
    """Sums at vertices of what triangles have, an equal part to each corner."""
    return sum(np.bincount(triangles[:, k], values / 3, count) for k in range(3))


def vertex_normals(points, triangles):
    """Means of the normals of the triangles around a vertex, weighted with their angles there."""
    corners, normals = points[triangles], np.zeros_like(points)
    flat = area_vectors(points, triangles)
    flat /= np.maximum(np.linalg.norm(flat, axis=1), 1e-300)[:, None]
    for k in range(3):
        one, other = corners[:, (k + 1) % 3] - corners[:, k], corners[:, (k + 2) % 3] - corners[:, k]
        lengths = np.linalg.norm(one, axis=1) * np.linalg.norm(other, axis=1)
        angle = np.where(lengths > 1e-14, np.arccos(np.clip((one * other).sum(1) / np.maximum(lengths, 1e-300), -1, 1)), 0)
        for axis in range(3):
            normals[:, axis] += np.bincount(triangles[:, k], flat[:, axis] * angle, len(points))
    return normals / np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]


def section_area(points, triangles, centre, direction, place):
    """Area within a surface, whose normals point outwards, on a plane square to a direction."""
    height = (points - centre) @ direction - place
    cut = triangles[(height[triangles] > 0).any(1) & (height[triangles] <= 0).any(1)]
    corners, level = points[cut] - centre - place * direction, height[cut]
    ends = np.full((len(cut), 3, 3), np.nan)
    for k in range(3):
        here, there = level[:, k], level[:, (k + 1) % 3]
        crossed = (here > 0) != (there > 0)
        share = np.where(crossed, here / np.where(crossed, here - there, 1), np.nan)[:, None]
        ends[:, k] = corners[:, k] + share * (corners[:, (k + 1) % 3] - corners[:, k])
    order = np.argsort(np.isnan(ends[:, :, 0]), axis=1, kind="stable")
    one, other = (ends[np.arange(len(cut)), order[:, k]] for k in range(2))
    turn = np.cross(direction, np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    sign = np.where(((other - one) * turn).sum(1) < 0, -1, 1)
    return 0.5 * float((sign * (np.cross(one, other) @ direction)).sum())


def section_radii(points, triangles, centre, direction, places):
    areas = [section_area(points, triangles, centre, direction, place) for place in places]
    return np.sqrt(np.maximum(areas, 0) / np.pi)


def weighted(values, weights):
    """Mean and standard deviation."""
    mean = float((values * weights).sum() / weights.sum())
    return mean, float(np.sqrt(((values - mean) ** 2 * weights).sum() / weights.sum()))
