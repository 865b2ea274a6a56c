"""Random vessels of which the openings are known by formula, for random_openings.py. Needs numpy.

Lengths are in voxels (the cube root of a voxel's volume), the middle of the first voxel is the origin, x comes first.
A shape is a function f that is negative inside and whose slope is 1 or a little less: round cones, joined with a fillet.
"""
import math

import numpy

KINDS = ("crossing", "tree", "comb", "thin", "oblique", "grazing", "edge", "merging", "two_labels", "layered")
TWO_LABELS = ("two_labels", "layered")
MAY_BE_UNCLEAR = ("grazing", "edge", "merging", "oblique")
FILLET = 2  # Voxels: creases between vessels are rounded, as no image shows them sharper.
CLEAR = 0.5  # Voxels that the wall may move by without changing the number of openings.
COARSE, FINE = 0.25, 0.08  # Steps of sampling.
RIM_RULE = 0.25  # docs/stages/lattice.md: a wall surrounds at least a quarter of its own area.


def unit(vector):
    return vector / numpy.linalg.norm(vector)


class Tube:
    """A round cone from one ball to another."""

    def __init__(self, start, end, radius, end_radius=None):
        self.start, self.end = numpy.array(start, float), numpy.array(end, float)
        self.radius, self.end_radius = radius, radius if end_radius is None else end_radius
        self.along = unit(self.end - self.start) if (self.end != self.start).any() else numpy.array((0.0, 0.0, 1.0))
        self.length = float(numpy.linalg.norm(self.end - self.start))

    def __call__(self, points):
        off = points - self.start
        way = numpy.clip(off @ self.along, 0, self.length)
        radius = self.radius + (self.end_radius - self.radius) * way / (self.length or 1)
        return numpy.sqrt(((off - way[..., None] * self.along) ** 2).sum(-1)) - radius

    def section_area(self, axis):
        """Of a plane square to an axis that cuts nothing but the straight middle part."""
        return math.pi * self.radius ** 2 / abs(self.along[axis])


def joined(tubes, points):
    """Union of tubes with a fillet."""
    f = tubes[0](points)
    for tube in tubes[1:]:
        g = tube(points)
        f = numpy.minimum(f, g) - numpy.maximum(FILLET - numpy.abs(f - g), 0) ** 2 / (4 * FILLET)
    return f


def components(mask):
    """Numbers of the 4-connected parts of a mask from 1 on, 0 outside, and how many there are."""
    parent, runs, before = [], [], []
    for row in mask:
        ends = numpy.flatnonzero(numpy.diff(numpy.concatenate(([0], row.astype(numpy.int8), [0]))))
        now = []
        for begin, end in zip(ends[::2], ends[1::2]):
            parent.append(len(parent))
            now.append((begin, end, len(parent) - 1))
            for other_begin, other_end, other in before:
                if other_begin < end and begin < other_end:
                    parent[find(parent, other)] = find(parent, len(parent) - 1)
        runs.append(now)
        before = now
    numbers, result = {}, numpy.zeros(mask.shape, int)
    for row, now in zip(result, runs):
        for begin, end, run in now:
            row[begin:end] = numbers.setdefault(find(parent, run), len(numbers) + 1)
    return result, len(numbers)


def find(parent, at):
    while parent[at] != at:
        parent[at] = parent[parent[at]]
        at = parent[at]
    return at


def holes(mask):
    """How many pieces of the outside a mask encloses."""
    outside, count = components(numpy.pad(~mask, 1, constant_values=True))
    return len(set(range(1, count + 1)) - {outside[0, 0]})


class Group:
    """What may be one opening: a part of {f < CLEAR} of one label in one face of the image."""

    def __init__(self, label, axis, side):
        self.label, self.axis, self.side = label, axis, side
        self.is_sure = False  # Exactly one opening, wherever the wall is within CLEAR.
        self.area = self.area_per_offset = self.depth = self.least_slope = 0.0
        self.is_at_edge = False
        self.is_rim = False  # None: at the rule's limit.
        self.holes = 0
        self.formula = None  # Area of the section if it is of one straight tube.

    def kind(self):
        """The class of tolerances it belongs to."""
        if not self.is_sure:
            return "unclear"
        if self.is_at_edge:
            return "at an edge"
        if self.least_slope < 0.5:
            return "oblique"
        return "thin" if self.depth < 2 else "plain"


class Face:
    """One side of the image, sampled."""

    def __init__(self, scene, axis, side):
        self.scene, self.axis, self.side = scene, axis, side
        self.others = [a for a in range(3) if a != axis]
        self.low = -0.5 * scene.spacing
        self.high = (scene.size - 0.5) * scene.spacing
        self.height = (self.low, self.high)[side][axis]
        self.places, self.steps = self.grid(self.low[self.others], self.high[self.others], COARSE)
        self.groups, self.group_maps = [], {}
        for label in scene.labels():
            self.find_groups(label, scene.label_function(label, self.places))
        self.mark_rims()

    def grid(self, low, high, step):
        counts = numpy.maximum(1, numpy.ceil((high - low) / step)).astype(int)
        steps = (high - low) / counts
        axes = [low[i] + steps[i] * (numpy.arange(counts[i]) + 0.5) for i in (0, 1)]
        places = numpy.empty((*counts, 3))
        places[..., self.axis] = self.height
        places[..., self.others[0]], places[..., self.others[1]] = numpy.meshgrid(*axes, indexing="ij")
        return places, steps

    def find_groups(self, label, f):
        near, count = components(f < CLEAR)
        self.group_maps[label] = near, len(self.groups)
        for number in range(1, count + 1):
            mine = near == number
            group = Group(label, self.axis, self.side)
            self.groups.append(group)
            parts = [components(mine & (f < -offset))[1] for offset in (0, CLEAR)]
            hollow = [holes(mine & (f < offset)) for offset in (CLEAR, 0, -CLEAR)]
            group.is_sure = parts == [1, 1] and len(set(hollow)) == 1
            if not (mine & (f < 0)).any():
                continue
            group.holes = hollow[1]
            group.depth = float(-f[mine].min())
            self.measure(group, mine, label)

    def measure(self, group, mine, label):
        """Areas on a fine grid around a part."""
        index = numpy.argwhere(mine)
        low = self.low[self.others] + self.steps * index.min(0)
        high = self.low[self.others] + self.steps * (index.max(0) + 1)
        places, steps = self.grid(low, high, FINE)
        back = tuple(numpy.floor((places[..., self.others[i]] - self.low[self.others[i]]) / self.steps[i]).astype(int)
                     for i in (0, 1))
        belongs = mine[back]
        f = self.scene.label_function(label, places)
        slopes = numpy.stack(numpy.gradient(f, *steps), -1) if min(f.shape) > 1 else numpy.ones((*f.shape, 2))

        def area(offset):
            reach = numpy.abs(slopes * steps).sum(-1)  # The change of f across a square.
            return float((numpy.clip(0.5 - (f - offset) / numpy.maximum(reach, 1e-9), 0, 1) * belongs).sum() * steps.prod())

        step = 0.05
        group.area = area(0)
        group.area_per_offset = (area(step) - area(-step)) / (2 * step)
        rim = belongs & (numpy.abs(f) < FINE)
        slope = numpy.linalg.norm(slopes, axis=-1)
        group.least_slope = float(numpy.quantile(slope[rim], 0.02)) if rim.any() else 0.0
        border = [(places[..., self.others[i]] - end) for i in (0, 1) for end in (self.low[self.others[i]],
                                                                                self.high[self.others[i]])]
        group.is_at_edge = bool((belongs & (f < CLEAR) & (numpy.abs(border).min(0) < FINE)).any())
        group.formula = self.formula(places[belongs & (f < 0)], group)

    def formula(self, inside, group):
        """Area of an ellipse, where only one straight tube is near and no end of it."""
        if group.is_at_edge or len(self.scene.labels()) > 1 or not len(inside):
            return None
        distances = [tube(inside).min() for tube in self.scene.tubes[1]]
        near = [tube for tube, d in zip(self.scene.tubes[1], distances) if d < FILLET + 1]
        if len(near) != 1 or near[0].radius != near[0].end_radius:
            return None
        way = (inside - near[0].start) @ near[0].along
        is_straight = way.min() > 0.1 and way.max() < near[0].length - 0.1 and abs(near[0].along[self.axis]) > 0.05
        return near[0].section_area(self.axis) if is_straight else None

    def mark_rims(self):
        for group in self.groups:
            if not group.holes:
                continue
            near, first = self.group_maps[group.label]
            mine = near == 1 + self.groups.index(group) - first
            f = self.scene.label_function(group.label, self.places)
            outside, _ = components(numpy.pad(~(mine & (f < 0)), 1, constant_values=True))
            is_hole = (outside > 0)[1:-1, 1:-1] & (outside != outside[0, 0])[1:-1, 1:-1]
            held = sum((is_hole & (self.scene.label_function(other, self.places) < 0)).sum()
                       for other in self.scene.labels() if other != group.label) * self.steps.prod()
            share = held / (RIM_RULE * group.area)
            group.is_rim = None if 0.88 < share < 1.12 else bool(share > 1)

    def group_at(self, label, points):
        """Numbers in groups() of places in this face; -1 where there is none."""
        near, first = self.group_maps[label]
        index = numpy.floor((points[:, self.others] - self.low[self.others]) / self.steps).astype(int)
        index = numpy.clip(index, 0, numpy.array(near.shape) - 1)
        number = near[index[:, 0], index[:, 1]]
        return numpy.where(number > 0, number - 1 + first, -1)


class Scene:
    """One image and all that is known of its openings."""

    def __init__(self, seed):
        self.seed, self.kind = seed, KINDS[seed % len(KINDS)]
        self.random = numpy.random.default_rng(seed)
        self.is_grey = self.kind not in TWO_LABELS and bool(self.random.random() < 0.5)
        for _ in range(1000):
            self.make()
            self.faces = [Face(self, axis, side) for axis in range(3) for side in (0, 1)] if self.is_small() else []
            groups = self.groups()
            is_clear = all(g.is_sure for g in groups) or self.kind in MAY_BE_UNCLEAR
            if is_clear and any(g.is_sure for g in groups):
                break
        else:
            raise ValueError(f"seed {seed}: no scene found")
        self.mark_parts_of_rims()
        self.check_sampling()

    def mark_parts_of_rims(self):
        """A wall that an edge of the image cuts has parts of its ring in both faces; elsewhere, the rule's limit."""
        of_walls = {g.label for g in self.groups() if g.is_rim}
        for group in self.groups():
            if group.label in of_walls and group.is_rim is False:
                group.is_rim = True if group.is_at_edge else None

    def groups(self):
        return [g for face in self.faces for g in face.groups]

    def make(self):
        """A frame and shapes in it."""
        random = self.random
        self.size = random.integers(40, 91, 3)
        self.spacing = numpy.ones(3)
        if random.random() < 0.25:
            self.spacing[random.integers(3)] = random.uniform(1.2, 2)
            self.spacing /= self.spacing.prod() ** (1 / 3)
        self.voxel_mm = float(random.choice((1, 0.25, 0.6)))
        self.origin_mm = random.uniform(-50, 50, 3) if random.random() < 0.5 else numpy.zeros(3)
        self.frame = self.random_rotation() if random.random() < 0.3 else numpy.eye(3)
        self.extent = (self.size - 1) * self.spacing
        self.tubes, self.split = {1: []}, None
        getattr(self, "make_" + self.kind)()

    def random_rotation(self):
        q, r = numpy.linalg.qr(self.random.normal(size=(3, 3)))
        q *= numpy.sign(numpy.diag(r))
        return q if numpy.linalg.det(q) > 0 else -q

    # Parts of scenes.

    def radius(self, low, high):
        most = 0.3 * self.extent.min()
        return float(math.exp(self.random.uniform(math.log(low), math.log(max(low, min(high, most))))))

    def direction(self):
        return unit(self.random.normal(size=3))

    def inside(self, share=0.5):
        return self.extent * (0.5 + share * (self.random.random(3) - 0.5))

    def through(self, point, along, radius):
        far = 3 * self.extent.max()
        return Tube(point - far * along, point + far * along, radius)

    def face_point(self, margin):
        """A place in a random face, its axis, and the direction out of the image."""
        axis, side = int(self.random.integers(3)), int(self.random.integers(2))
        point = margin + self.random.random(3) * numpy.maximum(self.extent - 2 * margin, 0)
        point[axis] = (-0.5 * self.spacing[axis], self.extent[axis] + 0.5 * self.spacing[axis])[side]
        out = numpy.zeros(3)
        out[axis] = 2 * side - 1
        return point, axis, out

    def tilted(self, out, low_deg, high_deg):
        """A direction so many degrees off another one."""
        across = unit(numpy.cross(out, self.direction()))
        angle = math.radians(self.random.uniform(low_deg, high_deg))
        return math.cos(angle) * out + math.sin(angle) * across

    # The kinds.

    def make_crossing(self):
        for _ in range(self.random.integers(1, 5)):
            self.tubes[1].append(self.through(self.inside(), self.direction(), self.radius(1.5, 20)))

    def make_thin(self):
        for _ in range(self.random.integers(2, 6)):
            self.tubes[1].append(self.through(self.inside(0.7), self.direction(), self.radius(1.5, 2.5)))

    def make_tree(self):
        node = self.inside()
        trunk = self.radius(3, 14)
        for i in range(self.random.integers(3, 6)):
            point, _, out = self.face_point(4)
            end = trunk if i == 0 else trunk * self.random.uniform(0.4, 0.8)
            end = max(1.5, end)
            along = unit(point - node)
            reach = float(numpy.linalg.norm(point - node)) + 40
            middle = node + 0.6 * (point - node)
            self.tubes[1] += [Tube(node, middle, max(trunk * 0.7, end), end), Tube(middle, node + reach * along, end)]

    def make_comb(self):
        margin = 6
        point, axis, out = self.face_point(margin)
        blob = point - out * self.random.uniform(20, 28)
        self.tubes[1].append(Tube(blob, blob, self.radius(4, 9)))
        for _ in range(self.random.integers(3, 7)):
            place = margin + self.random.random(3) * (self.extent - 2 * margin)
            place[axis] = point[axis]
            along = self.tilted(out, 0, 50)
            self.tubes[1].append(Tube(place - self.random.uniform(15, 30) * along, place + 30 * along, self.radius(1.5, 6)))
        self.tubes[1].append(self.through(blob, self.direction(), self.radius(1.5, 5)))

    def make_oblique(self):
        for _ in range(self.random.integers(1, 3)):
            point, _, out = self.face_point(12)
            self.tubes[1].append(self.through(point, self.tilted(out, 60, 80), self.radius(1.5, 8)))

    def make_grazing(self):
        point, axis, out = self.face_point(8)
        radius = self.radius(1.5, 15)
        depth = self.random.uniform(-1.5, min(3, radius))
        self.tubes[1].append(self.through(point - out * (radius - depth), self.tilted(out, 86, 90), radius))
        self.tubes[1].append(self.through(self.inside(), self.direction(), self.radius(1.5, 8)))

    def make_edge(self):
        point, axis, out = self.face_point(8)
        other = (axis + int(self.random.integers(1, 3))) % 3
        side = int(self.random.integers(2))
        radius = self.radius(1.5, 12)
        point[other] = (-0.5, self.extent[other] + 0.5)[side]
        second = numpy.zeros(3)
        second[other] = 2 * side - 1
        along = unit(unit(out + second * self.random.uniform(0.3, 2)) + 0.4 * self.direction())
        self.tubes[1].append(self.through(point + self.random.uniform(-1, 1) * radius * out, along, radius))

    def make_merging(self):
        point, axis, out = self.face_point(12)
        radii = [self.radius(1.5, 8), self.radius(1.5, 8)]
        across = numpy.roll(out, int(self.random.integers(1, 3)))
        for sign, radius in zip((-1, 1), radii):
            place = point + sign * across * sum(radii) / 2 * self.random.uniform(0.3, 0.9)
            along = unit(out - sign * across * self.random.uniform(0, 0.6) + 0.2 * self.direction())
            self.tubes[1].append(Tube(place - 60 * along, place + 30 * along, radius))

    def make_two_labels(self):
        radius, along = self.radius(2.5, 16), self.direction()
        middle = self.inside()
        self.tubes[1].append(self.through(middle, along, radius))
        if self.random.random() < 0.5:  # One vessel, divided across or along its axis, or beside it.
            normal = along if self.random.random() < 0.5 else unit(numpy.cross(along, self.direction()))
            self.split = normal, float(normal @ middle) + self.random.uniform(-0.5, 0.5) * radius
            return
        self.tubes[2] = [self.through(self.inside(), self.direction(), self.radius(2, 12))]

    def make_layered(self):
        self.tubes[2] = []
        for _ in range(self.random.integers(1, 3)):
            middle, along, radius = self.inside(), self.direction(), self.radius(2, 12)
            self.tubes[2].append(self.through(middle, along, radius))
            self.tubes[1].append(self.through(middle, along, radius + self.random.uniform(2, 4)))

    # What it is made of.

    def has_labels_only(self):
        """No values that say where the wall is between voxels."""
        return not self.is_grey

    def labels(self):
        return [1, 2] if self.split or 2 in self.tubes else [1]

    def label_function(self, label, points):
        """Negative in a label: the second one cuts the first."""
        f = joined(self.tubes[1], points)
        if self.split:
            g = points @ self.split[0] - self.split[1]
            return numpy.maximum(f, g if label == 1 else -g)
        if 2 in self.tubes:
            g = joined(self.tubes[2], points)
            return numpy.maximum(f, -g) if label == 1 else g
        return f

    def is_small(self):
        """Few enough voxels for a quick mesh, by every third of them."""
        places = numpy.stack(numpy.meshgrid(*[numpy.arange(0, n, 3) for n in self.size], indexing="ij"), -1) * self.spacing
        inside = sum(int((self.label_function(label, places) < 0).sum()) for label in self.labels())
        return 27 * inside < 70_000

    def voxels(self):
        """Labels, or of grey images how deep in the object a voxel is."""
        places = numpy.stack(numpy.meshgrid(*[numpy.arange(n) for n in self.size], indexing="ij"), -1) * self.spacing
        if self.is_grey:
            return numpy.clip(-self.label_function(1, places), -3, 3)
        labels = numpy.zeros(self.size, int)
        for label in self.labels():
            labels[self.label_function(label, places) < 0] = label
        return labels

    def check_sampling(self):
        """Sampled areas against the formula, where there is one."""
        for g in self.groups():
            if g.is_sure and g.formula and abs(g.area / g.formula - 1) > 2e-3:
                raise ValueError(f"seed {self.seed}: a section of {g.formula:.3f} is {g.area:.3f} when sampled")
