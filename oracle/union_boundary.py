"""The exact boundary of a union of rectangles, convex polygons and circles, as straight and circular pieces.

Every shape's outline is cut wherever another outline meets it; a cut piece lies wholly inside, wholly outside or wholly on the
boundary of the rest. A piece belongs to the union's boundary if exactly one of its two sides is covered. Testing the sides
rather than the piece itself settles abutting and coincident edges too: touching shapes form one solid.

Distances to the pieces are closed formulas, so the nearest boundary point is exact up to rounding.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

SIDE = 1e-6  # how far off a piece its sides are probed; features of the input are far larger
SAME = 1e-9  # cuts closer than this (in a piece's parameter, 0..1) are one cut


@dataclass(frozen=True)
class Line:
    """The segment from `a` to `b`; parameter t in 0..1."""

    a: np.ndarray
    b: np.ndarray

    def at(self, t):
        return self.a + t * (self.b - self.a)

    def normal(self, t):
        x, y = self.b - self.a
        return np.array([y, -x]) / np.hypot(x, y)

    def ends(self):
        return [self.a, self.b]

    def parameter(self, p):
        """The parameter of `p` if it lies on the segment, else None."""
        along = self.b - self.a
        t = np.dot(p - self.a, along) / np.dot(along, along)
        return t if 0 <= t <= 1 and np.linalg.norm(self.at(t) - p) < SAME else None

    def part(self, t0, t1):
        return Line(self.at(t0), self.at(t1))

    def nearest(self, points):
        along = self.b - self.a
        t = np.clip((points - self.a) @ along / np.dot(along, along), 0, 1)
        return self.a + t[:, None] * along


@dataclass(frozen=True)
class Arc:
    """The counter-clockwise arc of angles `begin`..`end` (radians); parameter t in 0..1."""

    center: np.ndarray
    radius: float
    begin: float
    end: float

    def at(self, t):
        return self.center + self.radius * self.normal(t)

    def normal(self, t):
        angle = self.begin + t * (self.end - self.begin)
        return np.array([np.cos(angle), np.sin(angle)])

    def ends(self):
        return []  # only whole circles are cut, and those have none

    def parameter(self, p):
        offset = p - self.center
        if abs(np.linalg.norm(offset) - self.radius) > SAME:
            return None
        return (np.arctan2(offset[1], offset[0]) - self.begin) % (2 * np.pi) / (self.end - self.begin)

    def part(self, t0, t1):
        span = self.end - self.begin
        return Arc(self.center, self.radius, self.begin + t0 * span, self.begin + t1 * span)

    def nearest(self, points):
        offset = points - self.center
        angle = np.arctan2(offset[:, 1], offset[:, 0])
        on_arc = (angle - self.begin) % (2 * np.pi) <= self.end - self.begin
        length = np.linalg.norm(offset, axis=1, keepdims=True)
        radial = np.divide(offset, length, out=np.tile([1.0, 0.0], (len(points), 1)), where=length > 0)
        first, last = self.at(0.0), self.at(1.0)
        closer = np.linalg.norm(points - first, axis=1) <= np.linalg.norm(points - last, axis=1)
        end = np.where(closer[:, None], first, last)
        return np.where(on_arc[:, None], self.center + self.radius * radial, end)


def corners(obstacle):
    """Counter-clockwise vertices of a rectangle or convex polygon, None for a circle."""
    if "rect" in obstacle:
        (x0, y0), (x1, y1) = obstacle["rect"]
        return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]], dtype=float)
    if "polygon" in obstacle:
        return np.array(obstacle["polygon"], dtype=float)
    return None


def outline(obstacle):
    """The shape's edges."""
    vertices = corners(obstacle)
    if vertices is None:
        circle = obstacle["circle"]
        return [Arc(np.array(circle["center"], dtype=float), circle["radius"], 0.0, 2 * np.pi)]
    return [Line(a, b) for a, b in zip(vertices, np.roll(vertices, -1, axis=0))]


def covers(obstacle, points):
    """Which of the points [M, 2] the closed shape holds."""
    vertices = corners(obstacle)
    if vertices is None:
        circle = obstacle["circle"]
        return np.linalg.norm(points - np.array(circle["center"]), axis=1) <= circle["radius"]
    inside = np.ones(len(points), dtype=bool)
    for a, b in zip(vertices, np.roll(vertices, -1, axis=0)):
        edge, offset = b - a, points - a
        inside &= edge[0] * offset[:, 1] - edge[1] * offset[:, 0] >= 0
    return inside


def covered(obstacles, points):
    """Which of the points [M, 2] the union holds."""
    return np.any([covers(o, points) for o in obstacles] or [np.zeros(len(points), dtype=bool)], axis=0)


def _crossings(one, other):
    """Points where two edges meet, other than along a stretch they share."""
    if isinstance(one, Line) and isinstance(other, Line):
        along, across = one.b - one.a, other.b - other.a
        turn = along[0] * across[1] - along[1] * across[0]
        if abs(turn) < 1e-12:
            return []
        offset = other.a - one.a
        t = (offset[0] * across[1] - offset[1] * across[0]) / turn
        s = (offset[0] * along[1] - offset[1] * along[0]) / turn
        return [one.at(t)] if -SAME <= t <= 1 + SAME and -SAME <= s <= 1 + SAME else []
    if isinstance(one, Arc) and isinstance(other, Arc):
        between = other.center - one.center
        gap = np.linalg.norm(between)
        if gap < SAME or gap > one.radius + other.radius or gap < abs(one.radius - other.radius):
            return []
        along = (gap**2 + one.radius**2 - other.radius**2) / (2 * gap)
        across = np.sqrt(max(one.radius**2 - along**2, 0.0))
        unit = between / gap
        return [one.center + along * unit + side * across * np.array([-unit[1], unit[0]]) for side in (-1, 1)]
    if isinstance(one, Arc):
        return _crossings(other, one)
    along, offset = one.b - one.a, one.a - other.center
    a, b, c = np.dot(along, along), np.dot(along, offset), np.dot(offset, offset) - other.radius**2
    under = b * b - a * c
    if under < 0:
        return []
    roots = [(-b - np.sqrt(under)) / a, (-b + np.sqrt(under)) / a]
    return [one.at(t) for t in roots if -SAME <= t <= 1 + SAME]


def union_boundary(obstacles):
    """The pieces (`Line` or `Arc`) that bound the union."""
    outlines = [outline(o) for o in obstacles]
    pieces = []
    for index, edges in enumerate(outlines):
        others = [edge for k, group in enumerate(outlines) if k != index for edge in group]
        for edge in edges:
            meets = [p for other in others for p in _crossings(edge, other) + other.ends()]
            found = (edge.parameter(p) for p in meets)
            cuts = sorted([0.0, 1.0] + [t for t in found if t is not None])
            for t0, t1 in pairwise(cuts):
                if t1 - t0 < SAME:
                    continue
                middle, side = edge.at((t0 + t1) / 2), SIDE * edge.normal((t0 + t1) / 2)
                if covered(obstacles, np.array([middle - side, middle + side])).sum() == 1:
                    pieces.append(edge.part(t0, t1))
    return pieces
