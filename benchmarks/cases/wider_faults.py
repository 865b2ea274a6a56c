"""Faults of a second kind for surface_repair.py, in edges of any length. Each is a function of points, triangles, the diagonal and
a random generator that gives points and triangles. Needs numpy."""
import numpy


def neighbours(triangles, v):
    return numpy.setdiff1d(triangles[(triangles == v).any(axis=1)], [v])


def pull(points, triangles, vertices, diagonal, random):
    """Each past one of its neighbours along their edge: by 0.4 % of the diagonal, or 60 % of an edge that is short."""
    points = points.copy()
    for v in vertices:
        over = points[random.choice(neighbours(triangles, v))]
        way = over - points[v]
        length = numpy.linalg.norm(way)
        points[v] = over + (0.6 * way if length < 0.008 * diagonal else way / length * 0.004 * diagonal)
    return points, triangles


def pulled(points, triangles, diagonal, random, count=5):
    return pull(points, triangles, random.choice(numpy.unique(triangles), count, replace=False), diagonal, random)


def pulled_near(points, triangles, diagonal, random):
    """Past a neighbour nearer than 0.6 % of the diagonal, by half of the edge."""
    points, left = points.copy(), 5
    for v in random.permutation(numpy.unique(triangles)):
        over = points[random.choice(neighbours(triangles, v))]
        if left == 0 or not 0 < numpy.linalg.norm(over - points[v]) < 0.006 * diagonal:
            continue
        points[v] = over + (over - points[v]) / 2
        left -= 1
    return points, triangles


def pulled_many(points, triangles, diagonal, random):
    return pulled(points, triangles, diagonal, random, 20)


def pulled_thin(points, triangles, diagonal, random):
    """Vertices nearest to a wall that is turned against theirs."""
    normals = numpy.zeros_like(points)
    across = numpy.cross(points[triangles[:, 1]] - points[triangles[:, 0]], points[triangles[:, 2]] - points[triangles[:, 0]])
    for corner in range(3):
        numpy.add.at(normals, triangles[:, corner], across)
    normals /= numpy.maximum(numpy.linalg.norm(normals, axis=1), 1e-30)[:, None]
    thickness = numpy.array([numpy.where(normals @ n < -0.7, numpy.linalg.norm(points - p, axis=1), numpy.inf).min()
                             for p, n in zip(points, normals)])
    thin = numpy.intersect1d(numpy.argsort(thickness)[:max(30, len(points) // 20)], triangles)
    return pull(points, triangles, random.choice(thin, 5, replace=False), diagonal, random)


def mixed(points, triangles, diagonal, random):
    """Four holes, a tenth of the triangles turned, five vertices pulled."""
    middles, gone = points[triangles].mean(axis=1), numpy.zeros(len(triangles), bool)
    for t in random.integers(len(triangles), size=4):
        gone |= numpy.linalg.norm(middles - middles[t], axis=1) < 0.012 * diagonal
        gone[t] = True
    points, triangles = pulled(points, triangles[~gone], diagonal, random)
    return points, numpy.where((random.random(len(triangles)) < 0.1)[:, None], triangles[:, ::-1], triangles)


def sieved(points, triangles, diagonal, random):
    del diagonal
    return points, triangles[random.random(len(triangles)) > 0.02]


def divided(points, triangles, diagonal, random):
    """Edges divided in one of their triangles only, the middle a little off."""
    chosen = random.choice(len(triangles), 20, replace=False)
    middles = points[triangles[chosen, :2]].mean(axis=1) + 1e-4 * diagonal * random.normal(size=(20, 3))
    halves = [half for m, (a, b, c) in enumerate(triangles[chosen], len(points)) for half in ((a, m, c), (m, b, c))]
    return numpy.concatenate([points, middles]), numpy.concatenate([numpy.delete(triangles, chosen, axis=0), halves])


def fan_between(triangles, v, first, last):
    """The triangles at a vertex from one edge to another, or none if that is all around or an edge is missing."""
    behind = {}
    for t in numpy.flatnonzero((triangles == v).any(axis=1)):
        s = list(triangles[t]).index(v)
        behind[triangles[t][(s + 1) % 3]] = (triangles[t][(s + 2) % 3], t)
    fan, at = [], first
    while at in behind and at != last and len(fan) < len(behind):
        at, t = behind[at]
        fan.append(t)
    return fan if at == last else []


def slit(points, triangles, diagonal, random):
    """Three paths of edges cut open and drawn apart by a tenth of the triangles."""
    del diagonal
    triangles = triangles.copy()
    for _ in range(3):
        path, along = [random.choice(numpy.unique(triangles))], random.normal(size=3)
        for _ in range(6):
            ways = [v for v in neighbours(triangles, path[-1]) if v not in path]
            if ways:
                path.append(max(ways, key=lambda v: (points[v] - points[path[-1]]) @ along /
                                numpy.linalg.norm(points[v] - points[path[-1]])))
        for before, v, after in zip(path, path[1:], path[2:]):
            fan = fan_between(triangles, v, after, before)
            if not fan:
                continue
            copy = points[v] + 0.1 * (points[triangles[fan]].mean(axis=(0, 1)) - points[v])
            triangles[fan] = numpy.where(triangles[fan] == v, len(points), triangles[fan])
            points = numpy.concatenate([points, [copy]])
    return points, triangles


def sheeted(points, triangles, diagonal, random):
    """Four open sheets that overlap the wall, beside it by 0.15 %."""
    middles, sheets, copies = points[triangles].mean(axis=1), [triangles], [points]
    for n in range(1, 5):
        near = numpy.linalg.norm(middles - random.choice(middles), axis=1) < 0.03 * diagonal
        side = random.normal(size=3)
        copies.append(points + 0.0015 * diagonal * side / numpy.linalg.norm(side))
        sheets.append(triangles[near] + n * len(points))
    return numpy.concatenate(copies), numpy.concatenate(sheets)


def needled(points, triangles, diagonal, random):
    """Thirty edges divided in both triangles, half of them at 1e-7 of their length."""
    behind = {(t[s], t[(s + 1) % 3]): n for n, t in enumerate(triangles) for s in range(3)}
    new, places, gone = [], [], set()
    for t in random.permutation(len(triangles)):
        a, b, c = triangles[t]
        other = behind.get((b, a))
        if len(places) == 30 or other is None or t in gone or other in gone:
            continue
        d = next(v for v in triangles[other] if v not in (a, b))
        m, share = len(points) + len(places), 1e-7 if len(places) % 2 else 0.5
        places.append(points[a] + share * (points[b] - points[a]) + 1e-9 * diagonal * random.normal(size=3))
        new += [(a, m, c), (m, b, c), (m, a, d), (b, m, d)]
        gone |= {t, other}
    return numpy.concatenate([points, places]), numpy.concatenate([numpy.delete(triangles, sorted(gone), axis=0), new])


def shaken(points, triangles, diagonal, random):
    """Vertices in two balls of 2 % of the diagonal moved by half an edge, at most 0.4 %."""
    ends = numpy.concatenate([triangles[:, [s, (s + 1) % 3]] for s in range(3)])
    lengths, count = numpy.zeros(len(points)), numpy.zeros(len(points))
    numpy.add.at(lengths, ends[:, 0], numpy.linalg.norm(points[ends[:, 1]] - points[ends[:, 0]], axis=1))
    numpy.add.at(count, ends[:, 0], 1)
    most = numpy.minimum(lengths / numpy.maximum(count, 1) / 2, 0.004 * diagonal)
    points = points.copy()
    for _ in range(2):
        centre = points[random.choice(triangles)].mean(axis=0)
        near = numpy.linalg.norm(points - centre, axis=1) < 0.02 * diagonal
        points[near] += random.normal(size=(near.sum(), 3)) * most[near, None] / numpy.sqrt(3)
    return points, triangles


def everything(points, triangles, diagonal, random):
    for fault in (slit, divided, pulled_near, sieved):
        points, triangles = fault(points, triangles, diagonal, random)
    return points, numpy.where((random.random(len(triangles)) < 0.05)[:, None], triangles[:, ::-1], triangles)


FAULTS = {"pulled": pulled, "pulled near": pulled_near, "pulled many": pulled_many, "pulled thin": pulled_thin, "mixed": mixed,
          "sieved": sieved, "slit": slit, "divided": divided, "sheets": sheeted, "needles": needled, "shaken": shaken,
          "everything": everything}
